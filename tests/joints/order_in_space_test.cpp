// What rotates about all axes is of second order by the trapezoidal rule, free or held, whatever solves its joints.
// Judges are Euler's equations by the classical Runge-Kutta method, and steps in reduced coordinates, which share no
// code with those of sweeps and trees.
#include <cmath>

#include "host/scene/read.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::test::order_in_space_test {
namespace {

constexpr double time = 1;
const Vector3 inertia = {0.04, 0.1, 0.07};

// 1 kg at this place, as a part of what rotates with w about the origin.
BodyDescription body_at(const Vector3& position, const Vector3& w) {
  BodyDescription body = bare_body(position, inertia);
  body.velocity = cross(w, position);
  body.angular_velocity = w;
  return body;
}

struct Case {
  const char* name;
  Scene scene;
};
void PrintTo(const Case& c, std::ostream* out) { *out << c.name; }

JointDescription universal(u32 a, u32 b, const Vector3& anchor) {
  JointDescription joint = joint_of(JOINT_UNIVERSAL, a, b, anchor, {0, 1, 0});
  joint.second_axis = {0, 0, 1};
  return joint;
}
JointDescription screw(u32 a, u32 b, const Vector3& anchor, const Vector3& axis) {
  JointDescription joint = joint_of(JOINT_SCREW, a, b, anchor, axis);
  joint.pitch = 0.5;
  return joint;
}
JointDescription rod(u32 a, u32 b, const Vector3& from, const Vector3& to) {
  JointDescription joint = joint_of(JOINT_DISTANCE, a, b, from);
  joint.anchor_b = to;
  return joint;
}

std::vector<Case> cases() {
  const Vector3 none = {0, 0, 0}, w = {1, 2, 0.5}, x = {1, 0, 0}, two_x = {2, 0, 0}, y = {0, 1, 0};
  BodyDescription on_rod = bare_body(x, inertia);  // whose anchor is at rest
  on_rod.angular_velocity = {3, 1, 2};
  on_rod.velocity = cross({3, 1, 2}, {0.2, -0.1, 0});
  const auto scene = [](std::vector<BodyDescription> bodies, std::vector<JointDescription> joints) {
    return joint_scene(std::move(bodies), std::move(joints), 0.01);
  };
  const auto chain = [&](const JointDescription& first, const JointDescription& second, const Vector3& rate,
                         const Vector3& end) {
    return scene({body_at(x, rate), body_at(end, rate)}, {first, second});
  };
  return {
      {"ball", chain(joint_of(JOINT_BALL, NONE, 0, none), joint_of(JOINT_BALL, 0, 1, two_x), w, {3, 0, 0})},
      {"hinge",
       chain(joint_of(JOINT_HINGE, NONE, 0, none, y), joint_of(JOINT_HINGE, 0, 1, two_x, x), {0, 0, 0}, {3, 0.5, 0})},
      {"universal", chain(universal(NONE, 0, none), universal(0, 1, two_x), {0, 0, 0}, {3, 0, 0})},
      {"slider", chain(joint_of(JOINT_BALL, NONE, 0, none), joint_of(JOINT_SLIDER, 0, 1, two_x, x), w, {3, 0, 0.2})},
      {"fixed", chain(joint_of(JOINT_BALL, NONE, 0, none), joint_of(JOINT_FIXED, 0, 1, two_x), w, {3, 0, 0.2})},
      {"cylindrical",
       chain(joint_of(JOINT_BALL, NONE, 0, none), joint_of(JOINT_CYLINDRICAL, 0, 1, two_x, {1, 0, 1}), w, {3, 0, 0.3})},
      {"planar",
       chain(joint_of(JOINT_BALL, NONE, 0, none), joint_of(JOINT_PLANAR, 0, 1, two_x, {1, 0, 1}), w, {3, 0, 0.3})},
      {"screw", chain(joint_of(JOINT_BALL, NONE, 0, none), screw(0, 1, two_x, {1, 0, 1}), w, {3, 0, 0.3})},
      {"rod", scene({on_rod}, {rod(NONE, 0, none, {0.8, 0.1, 0})})},
  };
}

// Where the last body is.
Vector3 end_of(Scene scene, const char* solver, JointSolver joint_solver, u32 steps) {
  scene.name = scene.source = "order_in_space";
  replace_solver(scene.settings, *find_solver(solver));
  scene.settings.joint_solver = joint_solver;
  scene.settings.integrator = Integrator::trapezoidal;
  scene.settings.dt = time / steps;
  if (std::string_view(solver) == "gauss_seidel") scene.settings.iterations = 200;
  World world(scene, in_double());
  world.step(steps);
  return world.pose(world.bodies().back()).position;
}

class OrderInSpace : public testing::TestWithParam<Case> {};
INSTANTIATE_TEST_SUITE_P(Joints, OrderInSpace, testing::ValuesIn(cases()),
                         [](const auto& at) { return std::string(at.param.name); });

TEST_P(OrderInSpace, IsTwo) {
  const Scene& scene = GetParam().scene;
  const Vector3 fine = end_of(scene, "reduced_nsgs", JointSolver::automatic, 6400);
  for (const JointSolver solver : {JointSolver::sweeps, JointSolver::direct}) {
    SCOPED_TRACE(name_of(solver));
    double before = 0;
    for (const u32 steps : {100u, 200u, 400u, 800u, 1600u}) {
      const double error = length(end_of(scene, "gauss_seidel", solver, steps) - fine);
      if (before > 0) {
        EXPECT_GT(before / error, 3.2) << steps;
      }
      before = error;
    }
    EXPECT_LT(before, 1e-4);
  }
}

// Rates of (q, w) of a body that a ball joint holds in the origin, at c in its frame, in its frame.
struct Rotation {
  Quaternion q;
  Vector3 w;
};

Rotation rates(const Rotation& s, double mass, const Vector3& c, const Vector3& moments, const Vector3& gravity) {
  const Vector3 about = {moments[0] + mass * (c[1] * c[1] + c[2] * c[2]),
                         moments[1] + mass * (c[0] * c[0] + c[2] * c[2]),
                         moments[2] + mass * (c[0] * c[0] + c[1] * c[1])};
  const Vector3 torque = cross(c, mass * unrotate(s.q, gravity));
  const Vector3 momentum = {about[0] * s.w[0], about[1] * s.w[1], about[2] * s.w[2]};
  const Vector3 left = torque - cross(s.w, momentum);
  const auto [x, y, z, w] = s.q;
  const Vector3 r = s.w;
  return {{0.5 * (w * r[0] + y * r[2] - z * r[1]), 0.5 * (w * r[1] + z * r[0] - x * r[2]),
           0.5 * (w * r[2] + x * r[1] - y * r[0]), -0.5 * (x * r[0] + y * r[1] + z * r[2])},
          {left[0] / about[0], left[1] / about[1], left[2] / about[2]}};
}

Rotation moved(const Rotation& s, double h, const Rotation& by) {
  Rotation next = s;
  for (int k = 0; k < 4; ++k) next.q[k] += h * by.q[k];
  next.w = s.w + h * by.w;
  return next;
}

Vector3 runge_kutta_end(const Vector3& c, const Vector3& w, const Vector3& gravity) {
  Rotation s = {{0, 0, 0, 1}, w};
  const int steps = 20000;
  const double h = time / steps;
  const auto rate = [&](const Rotation& at) { return rates(at, 1, c, inertia, gravity); };
  for (int i = 0; i < steps; ++i) {
    const Rotation a = rate(s), b = rate(moved(s, h / 2, a)), d = rate(moved(s, h / 2, b)), e = rate(moved(s, h, d));
    for (const auto& [k, share] : {std::pair{a, 1.0}, {b, 2.0}, {d, 2.0}, {e, 1.0}}) s = moved(s, h * share / 6, k);
  }
  return rotate(s.q, c);
}

// A long top on a ball joint.
TEST(OrderOnAPivot, IsTwo) {
  const Vector3 w = {3, 1, 2}, c = {2, 0, 0}, gravity = {0, 0, -9.80665};
  const Vector3 exact = runge_kutta_end(c, w, gravity);
  EXPECT_NEAR(exact[0], -1.732586, 1e-6);
  Scene scene = joint_scene({body_at(c, w)}, {joint_of(JOINT_BALL, NONE, 0, {0, 0, 0})}, 0.01);
  scene.gravity = gravity;
  for (const JointSolver solver : {JointSolver::sweeps, JointSolver::direct}) {
    double before = 0;
    for (const u32 steps : {100u, 200u, 400u, 800u, 1600u}) {
      const double error = length(end_of(scene, "gauss_seidel", solver, steps) - exact);
      if (before > 0) {
        EXPECT_NEAR(std::log2(before / error), 2, 0.1) << steps;
      }
      before = error;
    }
    EXPECT_LT(before, 5e-6);
  }
}

// Closing its joint rotates a body, and leaves what it does in its own frame: energy was gained from it without end.
TEST(OrderOnAPivot, AFastTopKeepsItsEnergy) {
  BodyDescription top = body_at({0.3, 0, 0}, {60, 1, 0});
  top.inertia = {0.01, 0.2, 0.2};
  Scene scene = joint_scene({top}, {joint_of(JOINT_BALL, NONE, 0, {0, 0, 0})}, 1.0 / 240);
  scene.name = scene.source = "top";
  scene.gravity = {0, 0, 0};
  scene.settings.integrator = Integrator::trapezoidal;
  World world(scene, in_double());
  const double first = world.errors().kinetic;
  world.step(2400);
  EXPECT_NEAR(world.errors().kinetic, first, 0.001 * first);
}

// A free body under a constant torque.
TEST(OrderOfAFreeBody, IsTwo) {
  const auto axis_after = [](u32 steps) {
    Scene scene = joint_scene({bare_body({0, 0, 0}, inertia)}, {}, time / steps);
    scene.name = scene.source = "free";
    scene.settings.integrator = Integrator::trapezoidal;
    scene.bodies[0].angular_velocity = {3, 1, 2};
    World world(scene, in_double());
    world.set_load(world.bodies()[0], [](double) { return Wrench{{0, 0, 0}, {0.3, -0.2, 0.4}}; });
    world.step(steps);
    return rotate(world.pose(world.bodies()[0]).orientation, {1, 0, 0});
  };
  const Vector3 fine = axis_after(25600);
  double before = 0;
  for (const u32 steps : {100u, 200u, 400u, 800u, 1600u}) {
    const double error = length(axis_after(steps) - fine);
    if (before > 0) {
      EXPECT_NEAR(std::log2(before / error), 2, 0.1) << steps;
    }
    before = error;
  }
}

// Bricard's mechanism keeps its energy: 1e-3 of its 25 J were lost at this step.
TEST(OrderInSpace, BricardKeepsItsEnergy) {
  Scene scene = read_scene("bricard");
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.joint_solver = JointSolver::direct;
  scene.settings.integrator = Integrator::trapezoidal;
  scene.settings.dt = 0.00025;
  World world(scene, in_double());
  const auto energy = [&] { return world.errors().kinetic + world.errors().potential; };
  const double first = energy();
  world.step(40000);  // 10 s
  EXPECT_NEAR(energy(), first, 1e-5);
}

}  // namespace
}  // namespace lockstep::test::order_in_space_test
