// Springs on the free coordinate of a joint.
#include <gtest/gtest.h>

#include <cmath>

#include "host/report/measures.hpp"
#include "host/scene/joint_kinds.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::spring_test {
namespace {

template <class real>
class JointSprings : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(JointSprings, Precisions);

constexpr double dt = 1.0 / 240;
constexpr double inertia = 0.1;

// A body of 1 kg whose coordinate stands at `x`, with nothing but the spring.
Scene sprung(JointKind kind, const JointSpring& spring, double x) {
  Scene scene = joint_scene({bare_body({0, 0, 0})}, {joint_of(kind, NONE, 0, {0, 0, 0})}, dt);
  scene.gravity = {0, 0, 0};
  scene.settings.integrator = Integrator::trapezoidal;
  scene.joints[0].spring = spring;
  scene.joints[0].reference_poses = ReferencePoses{};  // where the coordinate of a hinge and a slider is 0
  if (kind == JOINT_SLIDER) scene.bodies[0].position = {0, 0, x};
  if (kind == JOINT_HINGE) scene.bodies[0].orientation = {0, 0, std::sin(x / 2), std::cos(x / 2)};
  if (kind == JOINT_DISTANCE) scene.bodies[0].position = {x, 0, 0};
  return scene;
}

template <class real>
double coordinate(JointKind kind, const Buffers<real>& b) {
  if (kind == JOINT_HINGE) return 2 * std::atan2(double(b.orientations[0].z), double(b.orientations[0].w));
  return kind == JOINT_SLIDER ? double(b.positions[0].z) : double(b.positions[0].x);
}

template <class real>
double speed(JointKind kind, const Buffers<real>& b) {
  if (kind == JOINT_HINGE) return double(b.motions[0].w[2]);
  return double(b.motions[0].v[kind == JOINT_SLIDER ? 2 : 0]);
}

// x_n = x_0 cos(n f), with cos f = 1 / (1 + h^2 k / 2 m): never more and never less, however stiff it is. (A step turns
// a body by 2 atan(h w / 2), so that a hinge does so for small swings.)
TYPED_TEST(JointSprings, SwingForEverWithTheTrapezoidalRule) {
  using real = TypeParam;
  for (const JointKind kind : {JOINT_SLIDER, JOINT_HINGE, JOINT_DISTANCE}) {
    const bool is_angular = kind == JOINT_HINGE;
    const double m = is_angular ? inertia : 1, rest = kind == JOINT_DISTANCE ? 1 : 0.1, swing = is_angular ? 1e-3 : 0.3;
    const double rounding = is_angular ? 0.01 * swing : sizeof(real) == 4 ? 1e-4 : 1e-11;
    for (const double stiffness : {3.0, 3e3, 3e6}) {
      const Scene scene = sprung(kind, {.stiffness = stiffness, .rest = rest}, rest + swing);
      const double phase = std::acos(1 / (1 + dt * dt * stiffness / (2 * m)));
      watch_steps<real>(scene, 200, [&](const Buffers<real>& b, u32 i) {
        EXPECT_NEAR(coordinate(kind, b), rest + swing * std::cos((i + 1) * phase), rounding)
            << name_of(kind) << ' ' << stiffness << ' ' << i;
      });
    }
  }
}

// What a spring takes from a speed in a short step is next to nothing beside it: v = -h k x / (m + h^2 k), in float
// too.
TYPED_TEST(JointSprings, ThatAreSoftForTheirStepPushByTheirStretch) {
  using real = TypeParam;
  for (const JointKind kind : {JOINT_SLIDER, JOINT_HINGE, JOINT_DISTANCE}) {
    const double m = kind == JOINT_HINGE ? inertia : 1, rest = kind == JOINT_DISTANCE ? 1 : 0, x = 0.3, h = 5e-4;
    for (const double stiffness : {0.1, 10.0, 1e3}) {
      Scene scene = sprung(kind, {.stiffness = stiffness, .rest = rest}, rest + x);
      scene.settings.dt = h;
      scene.settings.integrator = Integrator::semi_implicit_euler;
      const double expected = -h * stiffness * x / (m + h * h * stiffness);
      EXPECT_NEAR(speed(kind, after_steps<real>(scene, 1)), expected, (sizeof(real) == 4 ? 2e-6 : 1e-12) * -expected)
          << name_of(kind) << ' ' << stiffness;
    }
  }
}

// The velocity of that swing is v_n = -x_0 (2 / h) tan(f / 2) sin(n f), so that with a = h^2 k / 2 m its energy is
// k x_0^2 / 2 (1 - sin^2(n f) a / (2 + a)).
TYPED_TEST(JointSprings, EnergyGoesBetweenSpringAndBody) {
  using real = TypeParam;
  for (const JointKind kind : {JOINT_SLIDER, JOINT_HINGE, JOINT_DISTANCE}) {
    const bool is_angular = kind == JOINT_HINGE;
    const double m = is_angular ? inertia : 1, rest = kind == JOINT_DISTANCE ? 1 : 0.1, swing = is_angular ? 1e-3 : 0.3;
    const double rounding = is_angular ? 0.02 : sizeof(real) == 4 ? 1e-3 : 1e-10;
    for (const double stiffness : {3.0, 3e3, 3e6}) {
      const Scene scene = sprung(kind, {.stiffness = stiffness, .rest = rest}, rest + swing);
      const InitialState<real> state = compile<real>(scene);
      const Counters none = {};
      const auto energy = [&](const Buffers<real>& b) {
        return measure(b, state.sizes, state.features, state.params, none).energy();
      };
      const double whole = stiffness * swing * swing / 2, a = dt * dt * stiffness / (2 * m),
                   phase = std::acos(1 / (1 + a));
      EXPECT_NEAR(energy(state.buffers), whole, rounding * whole);
      EXPECT_TRUE(joints_conserve_energy(state.buffers, state.params));
      watch_steps<real>(scene, 200, [&](const Buffers<real>& b, u32 i) {
        const double s = std::sin((i + 1) * phase);
        EXPECT_NEAR(energy(b), whole * (1 - s * s * a / (2 + a)), rounding * whole)
            << name_of(kind) << ' ' << stiffness << ' ' << i;
      });
    }
  }
}

TYPED_TEST(JointSprings, DampersDoNotConserveEnergy) {
  using real = TypeParam;
  const auto conserves = [](const JointSpring& spring, double h, Integrator integrator = Integrator::trapezoidal) {
    Scene scene = sprung(JOINT_SLIDER, spring, 0.3);
    scene.settings.integrator = integrator;
    scene.settings.dt = h;
    const InitialState<real> state = compile<real>(scene);
    return joints_conserve_energy(state.buffers, state.params);
  };
  for (const double h : {1.0 / 1000, 1.0 / 240, 1.0 / 60, 0.007, 0.03}) {
    for (const double stiffness : {0.7, 3.3e2, 1e7}) {
      EXPECT_TRUE(conserves({.stiffness = stiffness}, h)) << h << ' ' << stiffness;
      EXPECT_FALSE(conserves({.stiffness = stiffness, .damping = 1e-5 * h * stiffness}, h)) << h << ' ' << stiffness;
    }
    EXPECT_FALSE(conserves({.damping = 1}, h)) << h;
    for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::explicit_euler})
      EXPECT_TRUE(conserves({.stiffness = 40}, h, integrator)) << h;
  }
}

// m x'' + c x' + k x = 0 from x_0 at rest: with d = c / 2 m and w = sqrt(k / m - d^2)
//   x = x_0 e^-dt (cos wt + d/w sin wt).
TYPED_TEST(JointSprings, DampedSwingIsTheExactOneToSecondOrder) {
  const double k = 40, c = 1.5, d = c / 2, w = std::sqrt(k - d * d), swing = 0.3;
  const auto worst = [&](double h) {
    Scene scene = sprung(JOINT_SLIDER, {.stiffness = k, .damping = c}, swing);
    scene.settings.dt = h;
    double error = 0;
    watch_steps<TypeParam>(scene, static_cast<u32>(std::lround(2 / h)), [&](const Buffers<TypeParam>& b, u32 i) {
      const double t = (i + 1) * h, exact = swing * std::exp(-d * t) * (std::cos(w * t) + d / w * std::sin(w * t));
      error = std::max(error, std::abs(coordinate(JOINT_SLIDER, b) - exact));
    });
    return error;
  };
  EXPECT_LT(worst(dt), 1.5e-3 * swing);
  if (sizeof(TypeParam) == 8) {
    EXPECT_LT(worst(dt / 4), 0.07 * worst(dt));
  }
}

// A dashpot alone: v_n = v_0 ((1 - (1 - t) z) / (1 + t z))^n with z = h c / m and t = (z + 3) / (z + 6).
TYPED_TEST(JointSprings, DashpotSlowsAsItShould) {
  using real = TypeParam;
  const double c = 30;
  for (const JointKind kind : {JOINT_SLIDER, JOINT_HINGE, JOINT_DISTANCE}) {
    const double m = kind == JOINT_HINGE ? inertia : 1, z = dt * c / m, t = (z + 3) / (z + 6);
    Scene scene = sprung(kind, {.damping = c}, 0.5);
    scene.bodies[0].velocity = {kind == JOINT_DISTANCE ? 2.0 : 0.0, 0, kind == JOINT_SLIDER ? 2.0 : 0.0};
    scene.bodies[0].angular_velocity = {0, 0, kind == JOINT_HINGE ? 2.0 : 0.0};
    watch_steps<real>(scene, 50, [&](const Buffers<real>& b, u32 i) {
      EXPECT_NEAR(speed(kind, b), 2 * std::pow((1 - (1 - t) * z) / (1 + t * z), i + 1.0),
                  sizeof(real) == 4 ? 2e-6 : 1e-13)
          << name_of(kind) << ' ' << i;
    });
  }
}

// A weight comes to rest where k x = m g, by every solver, and neither the relaxing sweep nor a soft joint moves it.
TYPED_TEST(JointSprings, CarryAWeight) {
  using real = TypeParam;
  const double k = 200, rest = 0.05;
  Scene scene = sprung(JOINT_SLIDER, {.stiffness = k, .damping = 30, .rest = rest}, 0);
  scene.gravity = {0, 0, -9.81};
  scene.settings.integrator = Integrator::semi_implicit_euler;
  Scene soft = with_small_steps(scene, 4), jacobi = scene;
  soft.joints[0].frequency = 20;
  replace_solver(jacobi.settings, Solver::jacobi);
  for (const Scene& each : {scene, with_small_steps(scene, 4), soft, jacobi}) {
    const Buffers<real> b = after_steps<real>(each, 1000);
    EXPECT_NEAR(coordinate(JOINT_SLIDER, b), rest - 9.81 / k, sizeof(real) == 4 ? 2e-6 : 1e-12);
    EXPECT_NEAR(double(b.joint_impulses[0].free[0]), 9.81 * dt / substeps_of(each.settings),
                sizeof(real) == 4 ? 1e-6 : 1e-13);
  }
}

// A motor pushes as far as its force reaches, F = k x; and before that at its speed, the spring or not.
TYPED_TEST(JointSprings, YieldToAMotor) {
  using real = TypeParam;
  const double k = 400, force = 60;
  for (const bool small : {false, true}) {
    Scene scene = sprung(JOINT_SLIDER, {.stiffness = k, .damping = 40}, 0);
    scene.settings.integrator = Integrator::semi_implicit_euler;
    scene.joints[0].motor_speed = 0.5;
    scene.joints[0].motor_force = force;
    if (small) scene = with_small_steps(scene, 4);
    watch_steps<real>(scene, 720, [&](const Buffers<real>& b, u32 i) {
      // k x + c v stays below the force until x = (60 - 20) / 400
      const double time = (i + 1) * dt;
      if (time > 0.02 && time < 0.19) {
        EXPECT_NEAR(speed(JOINT_SLIDER, b), 0.5, 1e-5) << i;
      }
      if (i == 719) {
        EXPECT_NEAR(coordinate(JOINT_SLIDER, b), force / k, 1e-5);
      }
    });
  }
}

// Two bodies on a spring between them: their centre stays, and they swing with the reduced mass.
TYPED_TEST(JointSprings, ActOnBothBodies) {
  using real = TypeParam;
  const double k = 50, heavy = 3;
  Scene scene = sprung(JOINT_DISTANCE, {.stiffness = k, .rest = 1}, 0);
  scene.bodies.push_back(bare_body({1.4, 0, 0}));
  scene.bodies[0].mass = heavy;
  scene.joints[0].body_a = 0;
  scene.joints[0].body_b = 1;
  scene.joints[0].reference_poses.reset();
  scene.joints[0].anchor_b = {1.4, 0, 0};
  const double m = heavy / (heavy + 1), phase = std::acos(1 / (1 + dt * dt * k / (2 * m)));
  const double rounding = sizeof(real) == 4 ? 1e-4 : 1e-12;
  watch_steps<real>(scene, 200, [&](const Buffers<real>& b, u32 i) {
    const double x0 = double(b.positions[0].x), x1 = double(b.positions[1].x);
    EXPECT_NEAR(x1 - x0, 1 + 0.4 * std::cos((i + 1) * phase), rounding) << i;
    EXPECT_NEAR(heavy * x0 + x1, 1.4, rounding) << i;
  });
}

TEST(SpringsOfJoints, CostNothingWhereThereAreNone) {
  Scene scene = sprung(JOINT_SLIDER, {.stiffness = 1}, 0);
  EXPECT_TRUE(has(compile<float>(scene).features, Feature::joint_springs));
  scene.joints[0].spring.reset();
  EXPECT_FALSE(has(compile<float>(scene).features, Feature::joint_springs));
}

}  // namespace
}  // namespace lockstep::test::spring_test
