// The cases with an exact answer, run as scenes from reader to report, each held to a bound at one time step. The
// bounds are a few times what bench/closed_forms_bench prints; first-order quantities are also held to their order.
#include <gtest/gtest.h>

#include <cctype>
#include <stdexcept>

#include "bench/closed_forms.hpp"

namespace lockstep::bench {
namespace {

struct Bound {
  std::string name;
  double dt;
  std::vector<double> bounds;  // for each quantity of the case, in its order
};

// In double. What has no error but rounding is held to rounding.
const std::vector<Bound> bounds = {
    {"free flight: explicit Euler", 0.005, {0.03, 1e-3}},
    {"free flight: semi-implicit Euler", 0.005, {0.03, 1e-3}},
    {"free flight: trapezoidal", 0.01, {1e-13, 1e-13}},
    {"free flight: Runge-Kutta 4", 0.01, {1e-13, 3e-9}},
    {"Dzhanibekov: Runge-Kutta 4", 0.02, {2e-6, 1e-5}},
    {"Dzhanibekov: midpoint", 0.01, {1e-3, 1e-10}},
    {"heavy top", 0.009, {0.0127}},  // a thousandth of a percent of the Hamiltonian
    {"steady precession: slow", 0.002, {2e-5, 2e-6}},
    {"steady precession: fast", 0.002, {2e-5, 1e-5}},
    {"pendulum A01", 0.01, {2e-6}},
    {"Zeno ball: e = 0.5", 0.001, {0.01, 0.003}},
    {"Zeno ball: e = 0.8", 0.001, {0.02, 0.016}},
    {"slide to roll", 0.01, {1e-12, 1e-12, 1e-12}},
    {"sphere on a slope of 30 degrees", 0.01, {1e-12, 1e-12}},
    {"least friction that rolls", 0.005, {2e-5}},
    {"boxes on a slope of 20 degrees", 0.01, {1e-8, 1e-8}},
};

const ClosedForm& named(const std::string& name) {
  for (const ClosedForm& form : closed_forms()) {
    if (form.name == name) return form;
  }
  throw std::out_of_range(name);
}

class ExactCases : public testing::TestWithParam<Bound> {};

TEST_P(ExactCases, StaysWithinItsBoundInDouble) {
  const auto errors = named(GetParam().name).run(GetParam().dt, "double");
  ASSERT_EQ(errors.size(), GetParam().bounds.size());
  for (std::size_t i = 0; i < errors.size(); ++i)
    EXPECT_LT(errors[i].error, GetParam().bounds[i]) << errors[i].quantity;
}

std::string letters_of_name(const testing::TestParamInfo<Bound>& bound) {
  std::string letters;
  for (const char c : bound.param.name) {
    if (std::isalnum(static_cast<unsigned char>(c))) letters += c;
  }
  return letters;
}

INSTANTIATE_TEST_SUITE_P(All, ExactCases, testing::ValuesIn(bounds), letters_of_name);

TEST(ExactCases, FloatIsNoWorseThanItsRounding) {
  // the exact cases of double, in float: what is left is the rounding of some hundred steps
  for (const char* name : {"slide to roll", "sphere on a slope of 30 degrees"}) {
    for (const CaseError& error : named(name).run(0.01, "float"))
      EXPECT_LT(error.error, 2e-5 * error.exact) << name << ", " << error.quantity;
  }
}

TEST(ExactCases, BouncesConvergeAtFirstOrder) {
  for (const char* name : {"Zeno ball: e = 0.5", "Zeno ball: e = 0.8"}) {
    const double coarse = named(name).run(0.004, "double")[1].error, fine = named(name).run(0.001, "double")[1].error;
    EXPECT_NEAR(coarse / fine, 4, 0.4) << name;
  }
}

}  // namespace
}  // namespace lockstep::bench
