// The residual of docs/theory/residuals.md on contact problems small enough to be solved by hand.
#include "host/report/residual.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <Eigen/LU>
#include <cmath>

namespace lockstep::residual_test {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

const Vector3d up = Vector3d::UnitZ();
constexpr double roundoff = 0x1p-53;

SystemBody sphere(double mass, double radius) {
  SystemBody body;
  body.inverse_mass = 1 / mass;
  body.inverse_inertia = Matrix3d::Identity() / (0.4 * mass * radius * radius);
  return body;
}

SystemContact contact(u32 a, u32 b, double radius_a, double radius_b, double friction) {
  SystemContact c;
  c.body_a = a;
  c.body_b = b;
  c.normal = up;
  c.arm_a = -radius_a * up;
  c.arm_b = radius_b * up;
  c.friction = friction;
  c.impulse = Vector3d::Zero();
  return c;
}

// Gives the bodies the velocities that the impulses make of free velocities: body 0 is the immovable ground.
void apply_impulses(ContactSystem& system) {
  for (const SystemContact& c : system.contacts) {
    for (const double sign : {1.0, -1.0}) {
      SystemBody& body = system.bodies[sign > 0 ? c.body_a : c.body_b];
      const Vector3d arm = sign > 0 ? c.arm_a : c.arm_b;
      body.v += sign * body.inverse_mass * c.impulse;
      body.w += sign * body.inverse_inertia * arm.cross(c.impulse);
    }
  }
}

// A ball that falls on the ground with 2 m/s; the impulse is the exact one times `share`. All masses and lengths
// scaled.
ContactSystem landing(double share, double mass, double length) {
  ContactSystem system;
  system.bodies = {SystemBody{}, sphere(3 * mass, 0.5 * length)};
  system.bodies[1].v = Vector3d(0, 0, -2 * length);
  system.contacts = {contact(1, 0, 0.5 * length, 0, 0.5)};
  system.contacts[0].impulse = share * 6 * mass * length * up;
  apply_impulses(system);
  return system;
}

TEST(Residual, IsZeroWithoutContacts) { EXPECT_EQ(residual(ContactSystem{}, roundoff).relative, 0); }

TEST(Residual, IsZeroForABallAtRest) {
  const Residual r = residual(landing(1, 1, 1), roundoff);
  EXPECT_EQ(r.defect_max, 0);
  EXPECT_EQ(r.relative, 0);
  EXPECT_DOUBLE_EQ(r.scale, 2);
}

TEST(Residual, IsTheMissingShareOfTheImpulse) {
  for (const double missing : {0.1, 1e-3}) {
    const Residual r = residual(landing(1 - missing, 1, 1), roundoff);
    EXPECT_NEAR(r.relative, missing, 1e-12);
    EXPECT_NEAR(r.defect_max, 2 * missing, 1e-12) << "the ball still sinks at this velocity";
  }
}

TEST(Residual, DoesNotDependOnUnits) {
  const Residual plain = residual(landing(0.5, 1, 1), roundoff);
  for (const double mass : {1000.0, 0.001}) {
    const Residual other = residual(landing(0.5, mass, 0.01), roundoff);
    EXPECT_NEAR(other.relative, plain.relative, 1e-12);
    EXPECT_NEAR(other.defect_max, 0.01 * plain.defect_max, 1e-12);
  }
  const double in_kg = residual(landing(1.5, 1, 1), roundoff).natural_map;
  const double in_tonnes = residual(landing(1.5, 0.001, 1), roundoff).natural_map;
  EXPECT_LT(in_tonnes, 0.01 * in_kg) << "the form with rho = 1 does depend on them";
}

TEST(Residual, IsZeroForASlidingBall) {
  ContactSystem system;
  system.bodies = {SystemBody{}, sphere(2, 0.5)};
  system.bodies[1].v = Vector3d(10, 0, -1);
  system.contacts = {contact(1, 0, 0.5, 0, 0.2)};
  system.contacts[0].impulse = Vector3d(-0.2 * 2, 0, 2);  // on the cone, against the sliding
  apply_impulses(system);
  EXPECT_NEAR(residual(system, roundoff).relative, 0, 1e-15);

  // friction in the wrong direction is a defect, although it is on the cone
  system.contacts[0].impulse = Vector3d(0, 0.4, 2);
  EXPECT_GT(residual(system, roundoff).relative, 0.05);
}

TEST(Residual, SeesAPullingImpulse) {
  ContactSystem system = landing(0, 1, 1);
  system.bodies[1].v = Vector3d(0, 0, 1);
  system.contacts[0].impulse = -3 * up;
  apply_impulses(system);  // held back to rest
  EXPECT_GT(residual(system, roundoff).defect_max, 0.1);
}

TEST(Residual, KnowsTheBias) {
  // a ball that may not leave at less than 0.7 m/s: restitution or a correction
  ContactSystem system = landing(1, 1, 1);
  system.bodies[1].v = Vector3d(0, 0, -2);
  system.contacts[0].bias = -0.7;
  system.contacts[0].impulse = 3 * 2.7 * up;
  apply_impulses(system);
  EXPECT_NEAR(residual(system, roundoff).relative, 0, 1e-15);
}

TEST(Residual, IsZeroForAStickingContactOfAGeneralBody) {
  ContactSystem system;
  system.bodies = {SystemBody{}, sphere(1, 0.5)};
  SystemBody& body = system.bodies[1];
  body.inverse_inertia << 3, 0.4, 0.1, 0.4, 2, -0.3, 0.1, -0.3, 5;
  const Vector3d v = {0.2, 0.1, -1}, w = {0.5, -0.3, 0.8};
  system.contacts = {contact(1, 0, 0.5, 0, 10)};  // so rough that it sticks
  SystemContact& c = system.contacts[0];
  c.arm_a = Vector3d(0.3, -0.2, -0.5);
  Matrix3d r;
  r << 0, -c.arm_a.z(), c.arm_a.y(), c.arm_a.z(), 0, -c.arm_a.x(), -c.arm_a.y(), c.arm_a.x(), 0;
  const Matrix3d delassus = body.inverse_mass * Matrix3d::Identity() - r * body.inverse_inertia * r;
  c.impulse = -delassus.inverse() * (v + w.cross(c.arm_a));
  body.v = v;
  body.w = w;
  apply_impulses(system);
  const Residual result = residual(system, roundoff);
  EXPECT_NEAR(result.relative, 0, 1e-14);
  EXPECT_NEAR(result.scale, (v + w.cross(c.arm_a)).norm(), 1e-14);
}

// A ball of mass `upper` on a ball of mass `lower` on the ground, both falling at 1 m/s and stopped exactly.
ContactSystem tower(double lower, double upper) {
  ContactSystem system;
  system.bodies = {SystemBody{}, sphere(lower, 0.5), sphere(upper, 0.5)};
  system.bodies[1].v = system.bodies[2].v = -up;
  system.contacts = {contact(1, 0, 0.5, 0, 0.5), contact(2, 1, 0.5, 0.5, 0.5)};
  system.contacts[0].impulse = (lower + upper) * up;
  system.contacts[1].impulse = upper * up;
  apply_impulses(system);
  return system;
}

TEST(Residual, IsZeroForATowerOfTwo) {
  EXPECT_NEAR(residual(tower(1, 2), roundoff).relative, 0, 1e-15);
  // q: -1 m/s at the ground, 0 between the balls
  EXPECT_NEAR(residual(tower(1, 2), roundoff).scale, std::sqrt(0.5), 1e-15);
}

TEST(Residual, SeesALightBodyUnderAHeavyOne) {
  ContactSystem system = tower(1e-3, 1e3);
  system.contacts[0].impulse -= 1e-4 * up;  // a ten-millionth of the load, but a tenth of the light ball's momentum
  system.bodies[1].v -= 0.1 * up;
  const Residual r = residual(system, roundoff);
  EXPECT_NEAR(r.defect_max, 0.1, 1e-3);
  EXPECT_GT(r.relative, 0.05);
}

TEST(Residual, NamesTheWorstContact) {
  ContactSystem system = tower(1, 2);
  system.bodies[2].v -= 0.1 * up;
  EXPECT_EQ(residual(system, roundoff).worst, 1u);
  system = tower(1, 2);
  system.bodies[1].v -= 0.1 * up;
  system.bodies[2].v -= 0.1 * up;
  EXPECT_EQ(residual(system, roundoff).worst, 0u);
}

TEST(Residual, RoundingIsThatOfThePrecision) {
  const ContactSystem system = landing(1, 1, 1);
  EXPECT_DOUBLE_EQ(residual(system, 0x1p-24).rounding, 0x1p-24);  // |W||r| = |q| = 2 m/s
  EXPECT_DOUBLE_EQ(residual(system, 0x1p-53).rounding, 0x1p-53);
}

TEST(Cone, ProjectsOntoInsidePolarAndSurface) {
  const Vector3d inside = {0.1, 0.2, 1};
  EXPECT_EQ(project_on_cone(inside, up, 0.5), inside);
  EXPECT_EQ(project_on_cone(Vector3d(0.1, 0, -1), up, 0.5), Vector3d::Zero());
  EXPECT_EQ(project_on_cone(-up, up, 0), Vector3d::Zero());
  EXPECT_EQ(project_on_cone(Vector3d(3, 4, 2), up, 0), 2 * up);
  const Vector3d far = {3, 0, 1}, near = project_on_cone(far, up, 0.5);
  EXPECT_NEAR(near.x(), 0.5 * near.z(), 1e-15);
  EXPECT_NEAR((far - near).dot(near), 0, 1e-15) << "the difference is normal to the cone";
}

}  // namespace
}  // namespace lockstep::residual_test
