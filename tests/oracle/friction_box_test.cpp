// The boxed model: what it keeps of Coulomb's law and what it gives up, and the splittings, which can act on it.
#include "cpu_reference/oracle/models/friction_box.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "cpu_reference/oracle/models/friction_pyramid.hpp"
#include "tests/oracle/lcp_problems.hpp"
#include "tests/oracle/multibodies.hpp"

namespace lockstep::oracle::models::friction_box_test {
namespace {

using std::numbers::pi;
using test::g;

constexpr double mu = 0.5, dt = 0.01;

VectorXd velocities_of(const Multibody& m, lcp::BoxedSolver method) {
  const FrictionBox box(m);
  VectorXd z;
  EXPECT_EQ(method(box.boxed(), {.tolerance = 1e-12}, z).stop, Stop::solved);
  return box.velocities(z);
}

// Every tangent takes its own mu p_n: right along an axis; at an angle the force points to a corner, not against the
// sliding, and is up to sqrt(2) times too large.
TEST(FrictionBox, FrictionReachesItsCorners) {
  const double friction = mu * g * dt;
  for (const lcp::NamedBoxedSolver& s : lcp::boxed_solvers()) {
    if (s.name == "fischer_newton") continue;  // takes no friction
    const VectorXd along = velocities_of(test::sliding_point(1, 0, mu, dt), s.solve);
    EXPECT_NEAR(along[6], 1 - friction, 1e-12) << s.name;
    EXPECT_NEAR(along[7], 0, 1e-12) << s.name;
    const double angle = pi / 6;
    const VectorXd across = velocities_of(test::sliding_point(1, angle, mu, dt), s.solve);
    EXPECT_NEAR(across[6], std::cos(angle) - friction, 1e-12) << s.name;
    EXPECT_NEAR(across[7], std::sin(angle) - friction, 1e-12) << s.name << ": turned towards x, and sqrt(2) too strong";
  }
}

// A pyramid's matrix has zeros on its diagonal and is not symmetric: the splittings refuse it, and act on the box.
TEST(FrictionBox, IsWhatSplittingsCanActOn) {
  Multibody m = test::hinged_bar(0.3, 0.2);
  const lcp::Lcp pyramid = FrictionPyramid(m, 4).reduced();
  VectorXd z;
  EXPECT_EQ(lcp::pgs(pyramid, {}, z).stop, Stop::stalled);
  EXPECT_FALSE(pyramid.m.isApprox(pyramid.m.transpose()));

  const lcp::BoxedLcp box = FrictionBox(m).boxed();
  EXPECT_TRUE(box.m.isApprox(box.m.transpose(), 0));
  VectorXd first;
  ASSERT_EQ(lcp::pgs(box, {.tolerance = 1e-12, .iterations = 100'000}, first).stop, Stop::solved);
  const VectorXd u = FrictionBox(m).velocities(first);
  for (const lcp::NamedBoxedSolver& s : lcp::boxed_solvers()) {
    if (s.name == "fischer_newton" || s.name == "jacobi") continue;
    z = VectorXd();
    const SolveReport r = s.solve(box, {.tolerance = 1e-12, .iterations = 100'000}, z);
    EXPECT_EQ(r.stop, Stop::solved) << s.name;
    EXPECT_LT((FrictionBox(m).velocities(z) - u).norm(), 1e-9) << s.name;
  }
}

// Without friction both models are the same problem.
TEST(FrictionBox, AgreesWithThePyramidWithoutFriction) {
  const Multibody m = test::hinged_bar(0, 0);
  const FrictionPyramid pyramid(m, 4);
  VectorXd x;
  ASSERT_EQ(lcp::lemke(pyramid.reduced(), {.tolerance = 1e-12}, x).stop, Stop::solved);
  EXPECT_LT((velocities_of(m, lcp::baraff) - pyramid.velocities(x)).norm(), 1e-10);
}

}  // namespace
}  // namespace lockstep::oracle::models::friction_box_test
