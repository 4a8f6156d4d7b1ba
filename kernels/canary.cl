#pragma OPENCL FP_CONTRACT OFF
#include "canary.h"
#include "common.h"
#include "types.h"

// A work-item computes LANES operand sets at once, as the solve kernels do: scalars and vectors are different code on
// many devices.
#if LANES == 1
#define WIDE(type) type
#else
#define WIDE_PASTE(type, lanes) type##lanes
#define WIDE_EXPAND(type, lanes) WIDE_PASTE(type, lanes)
#define WIDE(type) WIDE_EXPAND(type, LANES)
#endif
#define AS_EXPAND(type) as_##type
#define AS(type) AS_EXPAND(type)
#define CONVERT_EXPAND(type) convert_##type
#define CONVERT(type) CONVERT_EXPAND(type)

typedef WIDE(uint) CanaryWords;
typedef WIDE(REAL) CanaryValue;

static inline CanaryWords canary_mix(CanaryWords x) {
  x ^= x >> 16;
  x *= 0x7feb352du;
  x ^= x >> 15;
  x *= 0x846ca68bu;
  x ^= x >> 16;
  return x;
}

// Sign, biased exponent and mantissa put together; the mantissa is filled from two words.
static inline CanaryValue canary_value(CanaryWords sign, CanaryWords exponent, CanaryWords high, CanaryWords low) {
#if REAL_IS_DOUBLE
  const CanaryWords upper = (sign << 31) | (exponent << 20) | (high & 0xfffffu);
  return AS(WIDE(double))((CONVERT(WIDE(ulong))(upper) << 32) | CONVERT(WIDE(ulong))(low));
#else
  return AS(WIDE(float))((sign << 31) | (exponent << 23) | (low & 0x7fffffu));
#endif
}

#if REAL_IS_DOUBLE
#define CANARY_ONE 1023u
#else
#define CANARY_ONE 127u
#endif

// A random number with an exponent in the `spread` powers of two about 2^middle.
static inline CanaryValue canary_operand(CanaryWords set, u32 number, u32 one, u32 spread) {
  const CanaryWords low = canary_mix(set * 16u + number);
  const CanaryWords high = canary_mix(low);
  const CanaryWords more = canary_mix(high);
  return canary_value(more >> 31, one - spread / 2u + (more & (spread - 1u)), high, low);
}

static inline CanaryValue canary_denormal(CanaryWords set, u32 number) {
  const CanaryWords low = canary_mix(set * 16u + number);
  const CanaryWords high = canary_mix(low);
  return canary_value(canary_mix(high) >> 31, 0u * low, high, low);
}

static inline CanaryValue canary_zero(CanaryWords set, u32 number) {
  const CanaryWords none = 0u * set;
  return canary_value(canary_mix(set * 16u + number) >> 31, none, none, none);
}

static inline CanaryValue canary_product(CanaryValue a, CanaryValue b) { return a * b; }

static inline void canary_store(global real* results, u32 number, u32 count, u32 set, CanaryValue value) {
#if LANES == 1
  results[number * count + set] = value;
#elif LANES == 8
  vstore8(value, 0, results + number * count + set);
#else
  vstore16(value, 0, results + number * count + set);
#endif
}

// `count` is a multiple of PACK.
kernel void canary(global real* results, u32 count) {
  FOR_EACH(i, count / LANES) {
    const u32 set = i * LANES;
    CanaryWords sets;
#if LANES == 1
    sets = set;
#elif LANES == 8
    sets = set + (uint8)(0, 1, 2, 3, 4, 5, 6, 7);
#else
    sets = set + (uint16)(0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15);
#endif
    const CanaryValue a = canary_operand(sets, 0, CANARY_ONE, CANARY_NEAR);
    const CanaryValue b = canary_operand(sets, 1, CANARY_ONE, CANARY_NEAR);
    const CanaryValue c = canary_operand(sets, 2, CANARY_ONE, CANARY_NEAR);
    const CanaryValue d = canary_operand(sets, 3, CANARY_ONE, CANARY_NEAR);
    const CanaryValue e = canary_operand(sets, 4, CANARY_ONE, CANARY_NEAR);
    const CanaryValue f = canary_operand(sets, 5, CANARY_ONE, CANARY_NEAR);
    canary_store(results, CANARY_SUM_OF_PRODUCT, count, set, a * b + c);
    canary_store(results, CANARY_DIFFERENCE_OF_PRODUCT, count, set, c - a * b);
    canary_store(results, CANARY_TWO_PRODUCTS, count, set, a * b - c * d);
    const CanaryValue product = e * f;
    const CanaryValue sum = product + d;
    canary_store(results, CANARY_ACROSS_STATEMENTS, count, set, sum);
    canary_store(results, CANARY_DOT_PRODUCT, count, set, a * d + b * e + c * f);
    CanaryValue total = f;
    total += a * c;
    total -= b * d;
    canary_store(results, CANARY_ACCUMULATION, count, set, total);
    canary_store(results, CANARY_ACROSS_FUNCTIONS, count, set, canary_product(c, e) + f);

    const CanaryValue p = canary_operand(sets, 6, CANARY_ONE, CANARY_FAR);
    const CanaryValue q = canary_operand(sets, 7, CANARY_ONE, CANARY_FAR);
    canary_store(results, CANARY_QUOTIENT, count, set, p / q);
    canary_store(results, CANARY_RECIPROCAL, count, set, (real)1 / q);
    canary_store(results, CANARY_ROOT, count, set, sqrt(fabs(p)));
    canary_store(results, CANARY_RECIPROCAL_ROOT, count, set, (real)1 / sqrt(fabs(q)));

    const CanaryValue x = canary_denormal(sets, 8);
    const CanaryValue y = canary_denormal(sets, 9);
    const CanaryValue tiny = canary_operand(sets, 10, CANARY_NEAR / 2u + 1u, CANARY_NEAR);
    canary_store(results, CANARY_DENORMAL_SUM, count, set, x + y);
    canary_store(results, CANARY_DENORMAL_SCALED, count, set, x * (real)65536);
    canary_store(results, CANARY_DENORMAL_PRODUCT, count, set, tiny * a);
    canary_store(results, CANARY_DENORMAL_QUOTIENT, count, set, y / (real)3);
    canary_store(results, CANARY_DENORMAL_ROOT, count, set, sqrt(fabs(x)));
    canary_store(results, CANARY_THIRD, count, set, p / (real)3);

    const CanaryValue zero = canary_zero(sets, 11), other_zero = canary_zero(sets, 12);
    canary_store(results, CANARY_TIMES_ZERO, count, set, a * (real)0);
    canary_store(results, CANARY_PLUS_ZERO, count, set, zero + (real)0);
    canary_store(results, CANARY_ZERO_MINUS, count, set, (real)0 - zero);
    canary_store(results, CANARY_LARGER_ZERO, count, set, zero > other_zero ? zero : other_zero);
    canary_store(results, CANARY_NEGATED_DIFFERENCE, count, set, -(zero - other_zero));
    canary_store(results, CANARY_SUM_TAKEN_BACK, count, set, (a + b) - a);
    canary_store(results, CANARY_SUM_OF_THREE, count, set, a + (b + c));
    canary_store(results, CANARY_COMMON_FACTOR, count, set, a * b + a * c);
    canary_store(results, CANARY_SCALED_TWICE, count, set, a * (real)3 * (real)5);
    canary_store(results, CANARY_QUOTIENT_TAKEN_BACK, count, set, p / q * q);
    canary_store(results, CANARY_ROOT_SQUARED, count, set, sqrt(fabs(p)) * sqrt(fabs(p)));
    canary_store(results, CANARY_COMMON_START, count, set, (a - c) - (b - c));
  }
}

// Sums of what the canary has computed, of neighbours in memory.
kernel void canary_sums(global real* results, u32 count) {
  FOR_EACH(set, count) {
    const u32 after = set + set % CANARY_TERMS, end = after < count ? after : count;
    real sum = (real)0;
    for (u32 i = set; i < end; ++i) sum = sum + results[CANARY_SUM_OF_PRODUCT * count + i];
    results[CANARY_SUM_IN_A_LOOP * count + set] = sum;
  }
}
