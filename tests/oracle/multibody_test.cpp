// Scenes' constraint systems as the oracles take them, and solved by them.
#include "host/steppers/multibody.hpp"

#include <gtest/gtest.h>

#include <string>

#include "cpu_reference/oracle/models/friction_box.hpp"
#include "cpu_reference/oracle/models/friction_pyramid.hpp"
#include "host/error.hpp"
#include "tests/oracle/lcp_problems.hpp"
#include "tests/oracle/multibodies.hpp"

namespace lockstep::multibody_test {
namespace {

using oracle::SolveLimits;
using oracle::Stop;
namespace models = oracle::models;
namespace test = models::test;
using models::FrictionPyramid;
using models::Index;
using models::Multibody;
using models::VectorXd;

constexpr SolveLimits tight = {.tolerance = 1e-11};

ContactSystem system_of(const std::string& name, u32 steps) { return test::system_after(read_scene(name), steps); }

VectorXd velocities(const ContactSystem& system) {
  VectorXd u(6 * Index(system.bodies.size()));
  for (std::size_t b = 0; b < system.bodies.size(); ++b)
    u.segment<6>(6 * Index(b)) << system.bodies[b].v, system.bodies[b].w;
  return u;
}

// Contacts of a scene, pressed without friction: four points of a box make the matrix rank-deficient. Impulses are not
// unique, velocities are: every method finds the same, and complementarity holds.
TEST(ScenesLcps, WithoutFrictionAllMethodsAgree) {
  for (const char* scene : {"three_cubes", "box_stack", "mass_ratio"}) {
    Multibody m = multibody(system_of(scene, 30));
    ASSERT_GE(m.contacts.size(), 8u) << scene;
    for (models::Contact& c : m.contacts) c.friction = 0;
    const models::Rows rows(m);
    const models::JointElimination joints(rows, m);
    oracle::lcp::Lcp p = {joints.delassus(rows.normal), joints.free_velocity(rows.normal)};
    for (std::size_t i = 0; i < m.contacts.size(); ++i) p.q[Index(i)] += m.contacts[i].bias;
    const auto first = oracle::lcp::test::solve(oracle::lcp::lemke, p, tight);
    ASSERT_EQ(first.report.stop, Stop::solved) << scene;
    const VectorXd u = joints.velocities(rows.normal, first.z);
    for (const char* name : {"keller", "baraff", "pgs_sm", "fischer_newton"}) {
      const auto s = oracle::lcp::test::solve(oracle::lcp::test::solver(name).solve, p, tight);
      EXPECT_EQ(s.report.stop, Stop::solved) << scene << ": " << name;
      EXPECT_LT(s.report.residual, 1e-10) << scene << ": " << name;
      EXPECT_LT((joints.velocities(rows.normal, s.z) - u).norm(), 1e-9) << scene << ": " << name;
    }
  }
}

// With friction: a pyramid, by Lemke's method and by Newton's.
TEST(ScenesLcps, PyramidsAreSolved) {
  for (const char* scene : {"three_cubes", "box_stack", "slope_slip", "sphere_stack"}) {
    const Multibody m = multibody(system_of(scene, 30));
    for (const int directions : {4, 8}) {
      const oracle::lcp::Lcp p = FrictionPyramid(m, directions).reduced();
      for (const char* name : {"lemke", "fischer_newton"}) {
        const auto s = oracle::lcp::test::solve(oracle::lcp::test::solver(name).solve, p, tight);
        EXPECT_EQ(s.report.stop, Stop::solved) << scene << ": " << name << ", " << directions;
      }
    }
  }
}

// What the sweeps of a step converge to is what the pyramid gives where nothing slides.
TEST(ScenesLcps, ScenesAtRestAgreeWithTheirSweeps) {
  Scene scene = read_scene("box_stack");
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.iterations = 3000;
  const ContactSystem system = test::system_after(scene, 40);
  const Multibody m = multibody(system);
  const FrictionPyramid pyramid(m, 8);
  const auto s = oracle::lcp::test::solve(oracle::lcp::lemke, pyramid.reduced(), tight);
  ASSERT_EQ(s.report.stop, Stop::solved);
  EXPECT_LT((pyramid.velocities(s.z) - velocities(system)).norm(), 1e-6);
}

TEST(ScenesLcps, JointsAgreeWithTheirSweeps) {
  Scene scene = read_scene("pendulum_chain");
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.iterations = 5000;
  const ContactSystem system = test::system_after(scene, 20);
  const Multibody m = multibody(system);
  ASSERT_GE(m.joint_rows.size(), 10u);
  const FrictionPyramid pyramid(m, 4);
  const VectorXd u = pyramid.velocities(VectorXd::Zero(pyramid.size()));
  EXPECT_GT(u.norm(), 0.1);
  EXPECT_LT((u - velocities(system)).norm(), 1e-6 * u.norm());
}

TEST(ScenesLcps, RefuseWhatTheModelsDoNotHave) {
  const auto refusal = [](const char* scene, bool reduce) -> std::string {
    try {
      const Multibody m = multibody(system_of(scene, 2));
      if (reduce) FrictionPyramid(m, 4).reduced();
    } catch (const Error& e) {
      return e.what();
    }
    return "";
  };
  EXPECT_NE(refusal("bricard", true).find("30 rows have rank"), std::string::npos) << refusal("bricard", true);
  EXPECT_NE(refusal("rover", false).find("has a motor, a limit or a spring"), std::string::npos)
      << refusal("rover", false);
}

}  // namespace
}  // namespace lockstep::multibody_test
