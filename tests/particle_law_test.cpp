#include "host/scene/particle_law.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace lockstep::particle_law_test {
namespace {

// Schwager and Poeschel 2007, equations 19 and 20, with zeta the damping in parts of the critical one.
double closed_form(double zeta) {
  const double root = std::sqrt(std::abs(1 - zeta * zeta));
  const double phase = zeta < 1 ? std::atan2(2 * zeta * root, 2 * zeta * zeta - 1)  // 0 .. pi
                                : std::log((zeta + root) / (zeta - root));
  return std::exp(-zeta / root * phase);
}

TEST(ParticleLaw, RestitutionIsThatOfTheDampedSpring) {
  EXPECT_NEAR(restitution_of(0), 1, 5e-5);
  for (const double zeta : {0.05, 0.2, 0.5, 0.9, 1.2, 3.0})
    EXPECT_NEAR(restitution_of(zeta), closed_form(zeta), 5e-5) << zeta;
}

TEST(ParticleLaw, DampingGivesTheRestitutionThatIsAskedFor) {
  for (const double e : {0.01, 0.1, 0.5, 0.9, 0.99}) EXPECT_NEAR(restitution_of(damping_ratio(e)), e, 5e-5) << e;
  EXPECT_EQ(damping_ratio(1), 0);
}

BodyDescription ball(double mass, double radius) {
  BodyDescription body;
  body.mass = mass;
  body.inertia = {0.4 * mass * radius * radius, 0.4 * mass * radius * radius, 0.4 * mass * radius * radius};
  return body;
}

// Without damping, of two particles alone: omega^2 = 2 k / m, and symplectic Euler is stable up to omega h = 2. The
// bound is for a pile and thus below that, but not by an order of magnitude.
TEST(ParticleLaw, TheLongestStepIsCloseToTheExactBoundOfTwoParticles) {
  const double k = 1e5, m = 0.3;
  const double exact = 2 / std::sqrt(2 * k / m);
  const double step = longest_stable_step(ball(m, 0.1), {{{0, 0, 0}}}, {.radius = 0.1, .stiffness = k}, 0);
  EXPECT_LT(step, exact);
  EXPECT_GT(step, exact / 8);
}

TEST(ParticleLaw, TheLongestStepGoesWithTheRootOfMassOverStiffness) {
  const auto step = [](double k, double m) {
    return longest_stable_step(ball(m, 0.1), {{{0, 0, 0}}}, {.radius = 0.1, .stiffness = k}, 0.4);
  };
  EXPECT_NEAR(step(4e5, 1) / step(1e5, 1), 0.5, 1e-12);
  EXPECT_NEAR(step(1e5, 4) / step(1e5, 1), 2, 1e-12);
}

TEST(ParticleLaw, BodiesThatDoNotMoveBearAnyStep) {
  BodyDescription body = ball(1, 1);
  body.kind = BODY_KINEMATIC;
  EXPECT_EQ(longest_stable_step(body, {{{0, 0, 0}}}, {.radius = 0.1, .stiffness = 1}, 0),
            std::numeric_limits<double>::infinity());
}

}  // namespace
}  // namespace lockstep::particle_law_test
