// The canary sings where the device rounds as the reference does, and names what a device does otherwise.
#include "host/backends/canary.hpp"

#include <gtest/gtest.h>

#include <cfenv>
#include <cmath>

#include "cpu_reference/canary.hpp"
#include "kernels/canary.h"
#include "tests/stage_harness.hpp"

namespace lockstep::canary_test {
namespace {

TEST(Canary, KernelMatchesReference) {
  for (const u32 lanes : {1u, 8u, 16u}) {
    for (const bool double_precision : {false, true}) {
      if (double_precision && !test_device().fp64) continue;
      for (const u32 threads : {0u, 1u}) {
        EXPECT_EQ(describe(run_canary(test_device(), double_precision, lanes, threads)), "bit-exact")
            << "lanes " << lanes << (double_precision ? " double" : " float") << ", threads " << threads;
      }
    }
  }
}

struct Planted {
  const char *from, *to;
  bool contraction, division, sqrt, denormals;
  const char* formula;
};

TEST(Canary, NamesAPlantedFailure) {
  const Planted planted[] = {
      {"set, a * b + c)", "set, fma(a, b, c))", false, true, true, true, "a * b + c of operand set"},
      {"sum = product + d", "sum = fma(e, f, d)", false, true, true, true, "p = e * f; p + d of operand set"},
      {"set, p / q)", "set, p * ((real)1 / q))", true, false, true, true, "p / q of operand set"},
      {"set, (real)1 / sqrt(fabs(q)))", "set, sqrt((real)1 / fabs(q)))", true, true, false, true, "1 / sqrt(q)"},
      {"set, x + y)", "set, (real)0 * x)", true, true, true, false, "denormal + denormal of operand set"},
  };
  for (const Planted& plant : planted) {
    const KernelPatch patch[] = {{"canary.cl", plant.from, plant.to}};
    const CanaryVerdict verdict = run_canary(test_device(), false, 1, 0, patch);
    EXPECT_EQ(verdict.contraction_ok, plant.contraction) << plant.from;
    EXPECT_EQ(verdict.division_ok, plant.division) << plant.from;
    EXPECT_EQ(verdict.sqrt_ok, plant.sqrt) << plant.from;
    EXPECT_EQ(verdict.denormals_ok, plant.denormals) << plant.from;
    EXPECT_FALSE(verdict.bit_exact());
    EXPECT_NE(verdict.first_failure.find(plant.formula), std::string::npos) << verdict.first_failure;
  }
  EXPECT_TRUE(run_canary(test_device(), false, 1).bit_exact());
}

// What a compiler makes of a formula that takes floating-point numbers for real ones: each is told from the formula.
TEST(Canary, NamesAFormulaThatBecameAnother) {
  const struct {
    const char *formula, *from, *to;
  } rewritten[] = {
      {"a * 0", "set, a * (real)0)", "set, fabs(a * (real)0))"},
      {"zero + 0", "set, zero + (real)0)", "set, zero)"},
      {"0 - zero", "set, (real)0 - zero)", "set, -zero)"},
      {"zero > other ? zero : other", "zero > other_zero ? zero : other_zero", "other_zero < zero ? zero : zero"},
      {"-(zero - other)", "-(zero - other_zero)", "other_zero - zero"},
      {"(a + b) - a", "(a + b) - a", "b"},
      {"a + (b + c)", "a + (b + c)", "(a + b) + c"},
      {"a * b + a * c", "a * b + a * c", "a * (b + c)"},
      {"a * 3 * 5", "a * (real)3 * (real)5", "a * (real)15"},
      {"p / q * q", "p / q * q", "p"},
      {"sqrt(p) * sqrt(p)", "sqrt(fabs(p)) * sqrt(fabs(p))", "fabs(p)"},
      {"(a - c) - (b - c)", "(a - c) - (b - c)", "a - b"},
      {"a sum in a loop", "for (u32 i = set; i < end; ++i) sum", "for (u32 i = end; i-- > set;) sum"},
  };
  for (const auto& [formula, from, to] : rewritten) {
    const KernelPatch patch[] = {{"canary.cl", from, to}};
    const CanaryVerdict verdict = run_canary(test_device(), false, 1, 0, patch);
    EXPECT_FALSE(verdict.algebra_ok) << formula;
    EXPECT_EQ(verdict.first_failure.rfind(std::string(formula) + " of operand set", 0), 0u) << verdict.first_failure;
    EXPECT_EQ(describe(verdict).rfind("not bit-exact: algebra; ", 0), 0u) << describe(verdict);
  }
}

TEST(Canary, SeesAThreadThatRoundsOtherwise) {
  EXPECT_TRUE(reference::host_arithmetic_is_default());
  std::fesetround(FE_UPWARD);
  const bool upward = reference::host_arithmetic_is_default();
  std::fesetround(FE_TONEAREST);
  EXPECT_FALSE(upward);
}

// Of the operand sets, enough tell a rounding of their own from the right one: the canary cannot pass by luck.
TEST(Canary, OperandsTellTheDifference) {
  const u32 count = 4096;
  const auto results = reference::canary<float>(count);
  u32 denormal_results = 0, denormal_products = 0;
  for (u32 i = 0; i < count; ++i) {
    denormal_results += std::fpclassify(results[CANARY_DENORMAL_SUM * count + i]) == FP_SUBNORMAL;
    denormal_products += std::fpclassify(results[CANARY_DENORMAL_PRODUCT * count + i]) == FP_SUBNORMAL;
  }
  EXPECT_GT(denormal_results, count / 4);
  EXPECT_GT(denormal_products, count / 16);
}

}  // namespace
}  // namespace lockstep::canary_test
