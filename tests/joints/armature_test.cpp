// Inertia along the free coordinate of a joint, as of the rotor of a geared motor.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracles.hpp"
#include "tests/articulation_scene.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::armature_test {
namespace {

constexpr double g = 9.81, pi = std::numbers::pi;

template <class real>
class Armature : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Armature, Precisions);

template <class real>
constexpr double rounding = sizeof(real) == 4 ? 1e-5 : 1e-12;

Scene solved_by(Scene scene, Solver solver, u32 substeps, u32 iterations = 0) {
  replace_solver(scene.settings, solver);
  scene.settings.substeps = substeps;
  if (iterations > 0) scene.settings.iterations = iterations;
  return scene;
}

// By the trapezoidal rule, but for small_steps, which has none.
Scene at_mid_step(Scene scene) {
  if (scene.settings.solver != Solver::small_steps) scene.settings.integrator = Integrator::trapezoidal;
  return scene;
}

struct Solved {
  const char* name;
  Scene scene;
};

// By every solver that runs in float too.
std::vector<Solved> all_solvers(const Scene& scene) {
  return {{"gauss_seidel", solved_by(scene, Solver::gauss_seidel, 1)},
          {"gauss_seidel of 4 sub-steps", solved_by(scene, Solver::gauss_seidel, 4)},
          {"small_steps of 1", solved_by(scene, Solver::small_steps, 1)},
          {"small_steps of 4", solved_by(scene, Solver::small_steps, 4)},
          {"jacobi", solved_by(scene, Solver::jacobi, 1)},
          {"direct", solved_directly(solved_by(scene, Solver::gauss_seidel, 1))},
          {"direct of 4 sub-steps", solved_directly(solved_by(scene, Solver::gauss_seidel, 4))},
          {"gradient", solved_by(scene, Solver::gradient, 1, 200)},
          {"accelerated_gradient", solved_by(scene, Solver::accelerated_gradient, 1, 200)}};
}

Buffers<double> by_oracle(Scene scene, const std::string& oracle, u32 steps) {
  const Integrator integrator = scene.settings.integrator;
  replace_solver(scene.settings, *find_solver(oracle));
  scene.settings.integrator = integrator;
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation(make_oracle(state), state.params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  return simulation.backend().download(measured_buffers(simulation.backend().features()));
}

constexpr const char* oracles[] = {"nsgs", "mixed_ldlt", "impulse_based", "auto", "reduced_auto"};

template <class real>
double energy(const InitialState<real>& state, const Buffers<real>& b) {
  const Counters none = {};
  return measure(b, state.sizes, state.features, state.params, none).energy();
}

// A body of 2 kg on a slider, with its rotor of 3 kg: x'' = -m g / (m + a), and a motor of 10 N beside it.
Scene falling(double motor_force = 0) {
  Scene scene = joint_scene({bare_body({0.3, 0, 0})}, {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0})}, 0.01);
  scene.bodies[0].mass = 2;
  scene.joints[0].armature = 3;
  scene.joints[0].motor_speed = motor_force > 0 ? 100 : 0;
  scene.joints[0].motor_force = motor_force;
  return scene;
}

TYPED_TEST(Armature, WeighsNothingAndResistsAcceleration) {
  using real = TypeParam;
  for (const double force : {0.0, 10.0}) {
    for (const auto& [name, scene] : all_solvers(falling(force))) {
      const Buffers<real> after = after_steps<real>(scene, 50);
      EXPECT_NEAR(double(after.motions[0].v[2]), 0.5 * (force - 2 * g) / 5, 10 * rounding<real>) << name;
      EXPECT_NEAR(double(after.positions[0].x), 0.3, 1e-5) << name;  // small_steps has soft joints
    }
    if constexpr (sizeof(real) == 8) {
      for (const char* oracle : oracles)
        EXPECT_NEAR(by_oracle(falling(force), oracle, 50).motions[0].v[2], 0.5 * (force - 2 * g) / 5, 1e-9) << oracle;
    }
  }
}

// The rod of a pendulum that starts level; j is its angle below that.
Scene pendulum(double dt, double armature, Integrator integrator) {
  Scene scene = joint_scene({bare_body({0.4, 0, 1}, {0.01, 0.08, 0.08})},
                            {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 1}, {0, 1, 0})}, dt);
  scene.bodies[0].mass = 1.5;
  scene.joints[0].armature = armature;
  scene.settings.integrator = integrator;
  return scene;
}

template <class real>
double angle_of(const Buffers<real>& b) {
  return 2 * std::atan2(double(b.orientations[0].y), double(b.orientations[0].w));
}

// j'' = m g l cos j / (I + m l^2 + a), by Runge and Kutta.
double pendulum_angle(double time, double armature) {
  const double c = 1.5 * g * 0.4 / (0.08 + 1.5 * 0.16 + armature);
  double j = 0, u = 0;
  const u32 steps = 10000;
  const double h = time / steps;
  const auto rate = [&](double at) { return c * std::cos(at); };
  for (u32 i = 0; i < steps; ++i) {
    const double u_2 = u + h / 2 * rate(j), u_3 = u + h / 2 * rate(j + h / 2 * u), u_4 = u + h * rate(j + h / 2 * u_2);
    const double k = rate(j) + 2 * rate(j + h / 2 * u) + 2 * rate(j + h / 2 * u_2) + rate(j + h * u_3);
    j += h / 6 * (u + 2 * u_2 + 2 * u_3 + u_4);
    u += h / 6 * k;
  }
  return j;
}

TYPED_TEST(Armature, SlowsAPendulum) {
  using real = TypeParam;
  EXPECT_NEAR(pendulum_angle(1, 2), 1.2054841, 1e-7);  // as MuJoCo has it
  for (const auto& [name, scene] : all_solvers(pendulum(0.002, 2, Integrator::semi_implicit_euler)))
    EXPECT_NEAR(angle_of(after_steps<real>(scene, 500)), 1.2054841, 4e-3) << name;
  if constexpr (sizeof(real) == 8) {
    for (const char* oracle : oracles)
      EXPECT_NEAR(angle_of(by_oracle(pendulum(0.002, 2, Integrator::semi_implicit_euler), oracle, 500)), 1.2054841,
                  4e-3)
          << oracle;
  }
}

// By sweeps, directly and in reduced coordinates; energy stays, that of the rotor counted in.
TEST(ArmaturePendulum, IsOfSecondOrderByTheTrapezoidalRule) {
  for (const bool direct : {false, true}) {
    std::vector<double> errors, reduced_errors;
    for (const u32 steps : {400u, 800u, 1600u}) {  // in longer ones the third order shows
      Scene scene = pendulum(1.0 / steps, 0.3, Integrator::trapezoidal);
      scene = direct ? solved_directly(scene) : scene;
      const InitialState<double> state = compile<double>(scene);
      const double first = energy(state, state.buffers);
      watch_steps<double>(scene, steps, [&](const Buffers<double>& b, u32 i) {
        EXPECT_NEAR(energy(state, b), first, 10.0 / (steps * steps)) << i;
        if (i + 1 == steps) errors.push_back(std::abs(angle_of(b) - pendulum_angle(1, 0.3)));
      });
      reduced_errors.push_back(std::abs(angle_of(by_oracle(scene, "reduced_auto", steps)) - pendulum_angle(1, 0.3)));
    }
    for (const std::vector<double>& of : {errors, reduced_errors}) {
      EXPECT_LT(of[0], 2e-4);
      EXPECT_NEAR(of[0] / of[1], 4, 0.3);
      EXPECT_NEAR(of[1] / of[2], 4, 0.3);
    }
  }
}

// Two bodies in space on a hinge, of 0.1 and 0.3 kg m^2, and a motor of 2 N m: their relative speed grows by
// t / (I_1 I_2 / (I_1 + I_2) + a), and neither gets momentum.
TYPED_TEST(Armature, IsInertiaBetweenTwoBodies) {
  using real = TypeParam;
  Scene scene = joint_scene({bare_body({0, 0, 0}), bare_body({0, 0, 1}, {0.3, 0.3, 0.3})},
                            {joint_of(JOINT_HINGE, 0, 1, {0, 0, 0.5})}, 0.01);
  scene.gravity = {0, 0, 0};
  scene.joints[0].armature = 0.5;
  scene.joints[0].motor_speed = 1e4;
  scene.joints[0].motor_force = 2;
  for (const auto& [name, solved] : all_solvers(scene)) {
    const Buffers<real> b = after_steps<real>(solved, 20);
    const double w_0 = double(b.motions[0].w[2]), w_1 = double(b.motions[1].w[2]);
    EXPECT_NEAR(w_1 - w_0, 0.2 * 2 / (0.1 * 0.3 / 0.4 + 0.5), 10 * rounding<real>) << name;
    EXPECT_NEAR(0.1 * w_0 + 0.3 * w_1, 0, rounding<real>) << name;
  }
}

// As heavy as nothing else it keeps the coordinate's speed: the bodies go on as one.
TYPED_TEST(Armature, ThatIsHeavyLocksTheCoordinate) {
  using real = TypeParam;
  for (const double armature : {1e3, 1e6}) {
    Scene scene = joint_scene(
        {bare_body({0, 0, 0}), bare_body({1, 0, 0})},
        {joint_of(JOINT_HINGE, NONE, 0, {-0.5, 0, 0}, {0, 1, 0}), joint_of(JOINT_HINGE, 0, 1, {0.5, 0, 0}, {0, 1, 0})},
        0.005);
    scene.joints[1].armature = armature;
    for (const auto& [name, solved] : {Solved{"direct", solved_directly(solved_by(scene, Solver::gauss_seidel, 1))},
                                       Solved{"gauss_seidel", solved_by(scene, Solver::gauss_seidel, 1, 50)},
                                       Solved{"small_steps", solved_by(scene, Solver::small_steps, 4, 20)}}) {
      const Buffers<real> b = after_steps<real>(solved, 60);
      const double w_0 = double(b.motions[0].w[1]), w_1 = double(b.motions[1].w[1]);
      EXPECT_GT(w_0, 1) << name;
      EXPECT_NEAR(w_1, w_0, 10 / armature + (sizeof(real) == 4 ? 5e-4 : 1e-4)) << name;
    }
  }
}

// It falls onto its lower limit and stays there; a light body with a heavy rotor no less.
TYPED_TEST(Armature, GoesWithLimits) {
  using real = TypeParam;
  for (const double mass : {2.0, 0.01}) {
    Scene scene = falling();
    scene.bodies[0].mass = mass;
    scene.joints[0].limited = true;
    scene.joints[0].low = mass > 1 ? -0.1 : -0.001;
    scene.joints[0].high = 0.5;
    for (const auto& [name, solved] : all_solvers(scene)) {
      const InitialState<real> state = compile<real>(solved);
      watch_steps<real>(solved, 200, [&](const Buffers<real>& b, u32 i) {
        ASSERT_GE(double(b.positions[0].z), 1.02 * double(state.buffers.joints[0].low)) << name << ' ' << i;
        if (i + 1 < 200) return;
        EXPECT_NEAR(double(b.motions[0].v[2]), 0, 1e-4) << name;
        EXPECT_NEAR(measure_joint(b, state.params, 0).drive, mass * g, 1e-3 * mass * g) << name;
      });
    }
  }
}

// m x'' + a x'' = -k x, and limits beside the spring that it comes to: one row of them all.
TYPED_TEST(Armature, GoesWithSpringsAndLimits) {
  using real = TypeParam;
  Scene scene = falling();
  scene.gravity = {0, 0, 0};
  scene.bodies[0].velocity = {0, 0, 1};
  scene.joints[0].spring = {.stiffness = 5 * 4 * pi * pi};  // one oscillation a second
  for (const auto& [name, solved] : all_solvers(scene)) {
    if (solved.settings.solver == Solver::small_steps) continue;  // whose springs lose energy
    const Scene mid = at_mid_step(solved);
    const InitialState<real> state = compile<real>(mid);
    EXPECT_TRUE(has(state.features, Feature::joint_impedances));
    const double first = 0.5 * 5 * 1;  // the rotor goes along from the start
    watch_steps<real>(mid, 100, [&](const Buffers<real>& b, u32 i) {
      const double t = 0.01 * (i + 1);
      EXPECT_NEAR(double(b.positions[0].z), std::sin(2 * pi * t) / (2 * pi), 2e-3) << name << ' ' << i;
      EXPECT_NEAR(energy(state, b), first, 1e-2) << name << ' ' << i;
    });
  }
  scene.joints[0].limited = true;
  scene.joints[0].low = -0.5;
  scene.joints[0].high = 0.1;
  for (const auto& [name, solved] : all_solvers(scene)) {
    double highest = 0;
    watch_steps<real>(at_mid_step(solved), 40, [&](const Buffers<real>& b, u32 i) {
      highest = std::max(highest, double(b.positions[0].z));
      if (i + 1 < 40) return;
      EXPECT_LT(double(b.motions[0].v[2]), 0) << name;
    });
    EXPECT_NEAR(highest, 0.1, 2e-3) << name;
  }
}

// A bead on an arm that rotates about z, with a rotor of its own: x'' = m x w^2 / (m + a), L = (I + m x^2) w.
TEST(ArmatureOfASlider, GoesAlongOnARotatingArm) {
  const auto bead = [](double dt) {
    Scene scene = joint_scene(
        {bare_body({0, 0, 0}), bare_body({0.5, 0, 0})},
        {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0}), joint_of(JOINT_SLIDER, 0, 1, {0.5, 0, 0}, {1, 0, 0})}, dt);
    scene.gravity = {0, 0, 0};
    scene.bodies[0].inertia = {5, 5, 5};
    for (BodyDescription& body : scene.bodies) body.angular_velocity = {0, 0, 2};
    scene.bodies[1].velocity = {0, 1, 0};
    scene.joints[1].armature = 2;
    scene.settings.integrator = Integrator::trapezoidal;
    scene.settings.iterations = 30;
    return scene;
  };
  // E = (m + a) x'^2 / 2 + L^2 / 2 (I + m x^2), moments about the hinge: 5 + 0.1 of the bodies
  const auto off = [&](const Buffers<double>& b, double time) {
    double x = 0.5, u = 0;
    const double l = (5.1 + 0.25) * 2;
    const u32 steps = 20000;
    for (u32 i = 0; i < steps; ++i) {  // leapfrog
      const double h = time / steps;
      x += h / 2 * u;
      const double w = l / (5.1 + x * x);
      u += h * x * w * w / 3;
      x += h / 2 * u;
    }
    return std::abs(std::hypot(b.positions[1].x, b.positions[1].y) - x);
  };
  for (const bool direct : {false, true}) {
    const auto error = [&](double dt) {
      const Scene scene = direct ? solved_directly(bead(dt)) : bead(dt);
      return off(after_steps<double>(scene, u32(std::lround(1 / dt))), 1);
    };
    EXPECT_LT(error(0.01), 1e-2);
    EXPECT_LT(error(0.0025), 3e-3);
  }
  EXPECT_LT(off(by_oracle(bead(0.01), "reduced_auto", 100), 1), 2e-3);
  EXPECT_LT(off(by_oracle(bead(0.005), "reduced_auto", 200), 1), 5e-4);
}

// What is measured in the steps is what the report measures.
TYPED_TEST(Armature, IsCountedAsEnergyOfMotion) {
  using real = TypeParam;
  Scene scene = falling();
  scene.gravity = {0, 0, 0};
  scene.bodies[0].velocity = {0, 0, 2};
  const InitialState<real> state = compile<real>(scene);
  EXPECT_NEAR(energy(state, state.buffers), 0.5 * 5 * 4, 1e-5);
  StepParams<real> params = state.params;
  params.units_per_joule = 1000;
  ReferenceBackend<real> backend(state);
  step(backend, params);
  EXPECT_EQ(backend.buffers().counters[COUNTER_KINETIC], 10000u);
  EXPECT_EQ(backend.buffers().counters[COUNTER_ENERGY], 10000u);
}

TYPED_TEST(Armature, MatchesTheReference) {
  using real = TypeParam;
  for (const auto& [name, solved] : all_solvers(with_impedances(random_joints(31, 30, 40)))) {
    SCOPED_TRACE(name);
    Scene scene = solved;
    scene.settings.iterations = 5;
    expect_twins_agree(compile<real>(scene), 3);
    expect_twins_agree(compile<real>(at_mid_step(scene)), 3);
  }
}

TYPED_TEST(Armature, OfATreeIsSolvedWithIt) {
  using real = TypeParam;
  for (const Scene& scene : {with_impedances(random_tree(32, 60)), with_impedances(random_mechanism(33, 40, 5))}) {
    expect_stages_agree<real>(scene, Feature::articulations);
    expect_one_solve_is_exact<real>(scene, sizeof(real) == 4 ? 1e-3 : 1e-10);
  }
}

// A ball of 1 kg on a slide of an MJCF file.
Scene mjcf(const std::string& joints) {
  return parse_scene("<mujoco><worldbody><body>" + joints +
                         "<geom type=\"sphere\" size=\"0.1\" mass=\"1\"/></body></worldbody></mujoco>",
                     "robot.xml");
}

TEST(ArmatureOfMjcf, IsThatOfItsJoint) {
  const Scene scene = mjcf(R"(<joint type="slide" armature="3" range="-5 5" damping="0"/>)");
  EXPECT_NEAR(after_steps<double>(scene, 250).motions[0].v[2], -g / 4 * 250 * scene.settings.dt, 1e-9);
  const Scene damped = mjcf(R"(<joint type="slide" armature="3" range="-5 5" damping="2"/>)");
  ASSERT_EQ(damped.joints.size(), 1u);
  EXPECT_TRUE(damped.joints[0].limited && damped.joints[0].spring) << "one joint has them all";
  EXPECT_EQ(mjcf(R"(<joint axis="1 0 0"/><joint axis="0 1 0"/>)").joints.size(), 1u);
  EXPECT_EQ(mjcf(R"(<joint axis="1 0 0"/><joint axis="0 1 0" armature="1"/>)").joints.size(), 2u)
      << "two hinges with rotors of their own are no cross";
}

TYPED_TEST(Armature, CostsNothingWhereNoJointHasIt) {
  using real = TypeParam;
  Scene scene = falling();
  EXPECT_TRUE(has(compile<real>(scene).features, Feature::joint_impedances));
  scene.joints[0].armature = 0;
  scene.joints[0].spring = {.stiffness = 1};
  EXPECT_FALSE(has(compile<real>(scene).features, Feature::joint_impedances));
}

}  // namespace
}  // namespace lockstep::test::armature_test
