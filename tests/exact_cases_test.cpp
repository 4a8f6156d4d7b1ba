// The cases of single bodies that have an exact answer, run as scenes from reader to report, each held to a bound at
// one time step. The bounds are a few times what `lockstep bench` prints; first-order quantities are also held to their
// order.
#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <stdexcept>

#include "host/cases/hard_case.hpp"

namespace lockstep {
namespace {

struct Bound {
  std::string name, method;
  double dt;
  std::vector<double> bounds;  // for each quantity of the case, in its order
};

// In double. What has no error but rounding is held to rounding.
const std::vector<Bound> bounds = {
    {"free_flight", "explicit Euler", 0.005, {0.03, 1e-3}},
    {"free_flight", "semi-implicit Euler", 0.005, {0.03, 1e-3}},
    {"free_flight", "midpoint", 0.01, {1e-13, 1e-13}},
    {"free_flight", "Runge-Kutta 4", 0.01, {1e-13, 3e-9}},
    {"dzhanibekov", "Runge-Kutta 4", 0.02, {2e-6, 1e-5}},
    {"dzhanibekov", "midpoint", 0.01, {1e-3, 1e-10}},
    {"heavy_top", "Runge-Kutta 4", 0.009, {0.0127}},  // a thousandth of a percent of the Hamiltonian
    {"slow_precession", "Runge-Kutta 4", 0.002, {2e-5, 2e-6}},
    {"fast_precession", "Runge-Kutta 4", 0.002, {2e-5, 1e-5}},
    {"pendulum_a01", "Runge-Kutta 4", 0.01, {2e-6}},
    {"zeno_ball", "gauss_seidel, trapezoidal", 0.001, {0.003, 0.01}},
    {"zeno_ball_bouncy", "gauss_seidel, trapezoidal", 0.001, {0.016, 0.02}},
    {"slide_to_roll", "gauss_seidel, trapezoidal", 0.01, {1e-12, 1e-12, 1e-12}},
    {"sphere_on_slope", "gauss_seidel, trapezoidal", 0.01, {1e-12, 1e-12}},
    {"rolling_threshold", "gauss_seidel, trapezoidal", 0.005, {2e-5}},
    {"incline", "gauss_seidel", 0.01, {1e-8, 1e-8}},
};

std::vector<CaseError> errors_of(const std::string& name, const std::string& method, double dt,
                                 const std::string& precision) {
  const auto one = std::ranges::find(hard_cases(), name, &HardCase::name);
  if (one == hard_cases().end()) throw std::out_of_range(name);
  const auto by = std::ranges::find(one->methods, method, &Method::name);
  if (by == one->methods.end()) throw std::out_of_range(name + " by " + method);
  Trial trial(*by, {.dt = dt}, precision, std::nullopt);
  return one->run(trial);
}

class ExactCases : public testing::TestWithParam<Bound> {};

TEST_P(ExactCases, StaysWithinItsBoundInDouble) {
  const auto errors = errors_of(GetParam().name, GetParam().method, GetParam().dt, "double");
  ASSERT_EQ(errors.size(), GetParam().bounds.size());
  for (std::size_t i = 0; i < errors.size(); ++i)
    EXPECT_LT(errors[i].error, GetParam().bounds[i]) << errors[i].quantity;
}

std::string letters_of_name(const testing::TestParamInfo<Bound>& bound) {
  std::string letters;
  for (const char c : bound.param.name + "_" + bound.param.method)
    if (std::isalnum(static_cast<unsigned char>(c)) || c == '_') letters += c;
  return letters;
}

INSTANTIATE_TEST_SUITE_P(All, ExactCases, testing::ValuesIn(bounds), letters_of_name);

TEST(ExactCases, FloatIsNoWorseThanItsRounding) {
  // the exact cases of double, in float: what is left is the rounding of some hundred steps
  for (const char* name : {"slide_to_roll", "sphere_on_slope"}) {
    for (const CaseError& error : errors_of(name, "gauss_seidel, trapezoidal", 0.01, "float"))
      EXPECT_LT(error.error, 2e-5 * error.exact) << name << ", " << error.quantity;
  }
}

TEST(ExactCases, BouncesConvergeAtFirstOrder) {
  for (const char* name : {"zeno_ball", "zeno_ball_bouncy"}) {
    const double coarse = errors_of(name, "gauss_seidel, trapezoidal", 0.004, "double")[0].error;
    const double fine = errors_of(name, "gauss_seidel, trapezoidal", 0.001, "double")[0].error;
    EXPECT_NEAR(coarse / fine, 4, 0.4) << name;
  }
}

}  // namespace
}  // namespace lockstep
