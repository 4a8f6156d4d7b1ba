#include "cpu_reference/canary.hpp"

#include <algorithm>
#include <bit>
#include <cfenv>
#include <cmath>
#include <limits>
#include <type_traits>

#include "cpu_reference/math.hpp"  // refuses fast-math
#include "kernels/canary.h"

namespace lockstep::reference {

namespace {

u32 mix(u32 x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

template <class real>
real value(u32 sign, u32 exponent, u32 high, u32 low) {
  if constexpr (std::is_same_v<real, double>) {
    const u32 upper = (sign << 31) | (exponent << 20) | (high & 0xfffffu);
    return std::bit_cast<double>((std::uint64_t{upper} << 32) | low);
  } else {
    return std::bit_cast<float>((sign << 31) | (exponent << 23) | (low & 0x7fffffu));
  }
}

template <class real>
constexpr u32 exponent_of_one = std::is_same_v<real, double> ? 1023 : 127;

template <class real>
real operand(u32 set, u32 number, u32 one, u32 spread) {
  const u32 low = mix(set * 16u + number);
  const u32 high = mix(low);
  const u32 more = mix(high);
  return value<real>(more >> 31, one - spread / 2u + (more & (spread - 1u)), high, low);
}

template <class real>
real denormal(u32 set, u32 number) {
  const u32 low = mix(set * 16u + number);
  const u32 high = mix(low);
  return value<real>(mix(high) >> 31, 0, high, low);
}

template <class real>
real signed_zero(u32 set, u32 number) {
  return value<real>(mix(set * 16u + number) >> 31, 0, 0, 0);
}

template <class real>
real product(real a, real b) {
  return a * b;
}

}  // namespace

template <class real>
std::vector<real> canary(u32 count) {
  std::vector<real> results(std::size_t{count} * CANARY_CASES);
  constexpr u32 one = exponent_of_one<real>;
  for (u32 i = 0; i < count; ++i) {
    const auto store = [&](CanaryCase number, real result) { results[number * count + i] = result; };
    const real a = operand<real>(i, 0, one, CANARY_NEAR), b = operand<real>(i, 1, one, CANARY_NEAR);
    const real c = operand<real>(i, 2, one, CANARY_NEAR), d = operand<real>(i, 3, one, CANARY_NEAR);
    const real e = operand<real>(i, 4, one, CANARY_NEAR), f = operand<real>(i, 5, one, CANARY_NEAR);
    store(CANARY_SUM_OF_PRODUCT, a * b + c);
    store(CANARY_DIFFERENCE_OF_PRODUCT, c - a * b);
    store(CANARY_TWO_PRODUCTS, a * b - c * d);
    const real of_two = e * f;
    store(CANARY_ACROSS_STATEMENTS, of_two + d);
    store(CANARY_DOT_PRODUCT, a * d + b * e + c * f);
    real total = f;
    total += a * c;
    total -= b * d;
    store(CANARY_ACCUMULATION, total);
    store(CANARY_ACROSS_FUNCTIONS, product(c, e) + f);

    const real p = operand<real>(i, 6, one, CANARY_FAR), q = operand<real>(i, 7, one, CANARY_FAR);
    store(CANARY_QUOTIENT, p / q);
    store(CANARY_RECIPROCAL, real(1) / q);
    store(CANARY_ROOT, std::sqrt(std::fabs(p)));
    store(CANARY_RECIPROCAL_ROOT, real(1) / std::sqrt(std::fabs(q)));

    const real x = denormal<real>(i, 8), y = denormal<real>(i, 9);
    const real tiny = operand<real>(i, 10, CANARY_NEAR / 2u + 1u, CANARY_NEAR);
    store(CANARY_DENORMAL_SUM, x + y);
    store(CANARY_DENORMAL_SCALED, x * real(65536));
    store(CANARY_DENORMAL_PRODUCT, tiny * a);
    store(CANARY_DENORMAL_QUOTIENT, y / real(3));
    store(CANARY_DENORMAL_ROOT, std::sqrt(std::fabs(x)));
    store(CANARY_THIRD, p / real(3));

    const real zero = signed_zero<real>(i, 11), other_zero = signed_zero<real>(i, 12);
    store(CANARY_TIMES_ZERO, a * real(0));
    store(CANARY_PLUS_ZERO, zero + real(0));
    store(CANARY_ZERO_MINUS, real(0) - zero);
    store(CANARY_LARGER_ZERO, zero > other_zero ? zero : other_zero);
    store(CANARY_NEGATED_DIFFERENCE, -(zero - other_zero));
    store(CANARY_SUM_TAKEN_BACK, (a + b) - a);
    store(CANARY_SUM_OF_THREE, a + (b + c));
    store(CANARY_COMMON_FACTOR, a * b + a * c);
    store(CANARY_SCALED_TWICE, a * real(3) * real(5));
    store(CANARY_QUOTIENT_TAKEN_BACK, p / q * q);
    store(CANARY_ROOT_SQUARED, std::sqrt(std::fabs(p)) * std::sqrt(std::fabs(p)));
    store(CANARY_COMMON_START, (a - c) - (b - c));
  }
  for (u32 i = 0; i < count; ++i) {
    const u32 end = std::min(i + i % CANARY_TERMS, count);
    real sum = 0;
    for (u32 k = i; k < end; ++k) sum = sum + results[CANARY_SUM_OF_PRODUCT * count + k];
    results[CANARY_SUM_IN_A_LOOP * count + i] = sum;
  }
  return results;
}

template std::vector<float> canary<float>(u32);
template std::vector<double> canary<double>(u32);

bool host_arithmetic_is_default() {
  if (std::fegetround() != FE_TONEAREST) return false;
  const volatile float denormal = std::numeric_limits<float>::denorm_min();
  const volatile float smallest = std::numeric_limits<float>::min();
  const volatile float as_operand = denormal * 16777216.0f;
  const volatile float as_result = smallest * 0.5f;
  return as_operand > 0 && as_result > 0;
}

}  // namespace lockstep::reference
