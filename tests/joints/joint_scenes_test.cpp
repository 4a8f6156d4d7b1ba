// What the scenes of joints show, held to what their descriptions say.
#include <gtest/gtest.h>

#include <cmath>

#include "host/report/measures.hpp"
#include "host/scene/joint_kinds.hpp"
#include "host/scene/read.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"

namespace lockstep::test::joint_scenes_test {
namespace {

u32 body_named(const Scene& scene, const std::string& name) {
  for (u32 i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].name == name) return i;
  }
  ADD_FAILURE() << name;
  return 0;
}

template <class real>
double energy(const InitialState<real>& state, const Buffers<real>& buffers) {
  const Counters none = {};
  return measure(buffers, state.sizes, state.features, state.params, none).energy();
}

// Let go level, a body on a joint keeps its energy to second order: the impulses act along the axes of the middle of
// the step. Along those of its start it would gain 14 % in these four seconds.
TEST(JointScenes, TrapezoidalPendulumKeepsItsEnergyToSecondOrder) {
  const auto worst = [](const JointDescription& joint, double dt) {
    BodyDescription body = bare_body({1, 0, 0}, {0.01, 0.01, 0.02});
    Scene scene = joint_scene({body}, {joint}, dt);
    scene.settings.integrator = Integrator::trapezoidal;
    scene.settings.gyroscopic = Gyroscopic::midpoint;
    const InitialState<double> state = compile<double>(scene);
    double error = 0;
    watch_steps<double>(scene, static_cast<u32>(std::lround(4 / dt)), [&](const Buffers<double>& b, u32) {
      error = std::max(error, std::abs(energy(state, b) - energy(state, state.buffers)));
    });
    return error / 9.81;  // of what it gains by the fall
  };
  JointDescription rod = joint_of(JOINT_DISTANCE, NONE, 0, {0, 0, 0}), spring = rod;
  rod.anchor_b = spring.anchor_b = {1, 0, 0};
  spring.spring = {.stiffness = 200, .rest = 1};
  JointDescription cross = joint_of(JOINT_UNIVERSAL, NONE, 0, {0, 0, 0}, {1, 1, 0});
  cross.second_axis = {1, -1, 0};
  JointDescription screw = joint_of(JOINT_SCREW, NONE, 0, {0, 0, 0}, {0, 1, 0});
  screw.pitch = 0.5;
  const JointDescription hinge = joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0}, {0, 1, 0});
  for (const JointDescription& joint : {joint_of(JOINT_BALL, NONE, 0, {0, 0, 0}), hinge, rod, spring, cross, screw}) {
    const double coarse = worst(joint, 0.004), fine = worst(joint, 0.002);
    EXPECT_LT(coarse, joint.kind == JOINT_UNIVERSAL ? 1e-3 : 3e-4) << name_of(joint.kind);  // that one tumbles
    EXPECT_LT(fine, coarse / 3.7) << name_of(joint.kind);  // of 1e-6 there is third order in it
  }
}

// Of all kinds: what the turning of the bodies adds to a row is foreseen, so that a joint that nothing closes comes
// apart in second order. Without it the order would be the first.
TEST(JointScenes, JointsThatNothingClosesOpenInSecondOrder) {
  for (u32 kind = 0; kind < JOINT_KINDS; ++kind) {
    SCOPED_TRACE(name_of(static_cast<JointKind>(kind)));
    const auto opened = [&](double dt) {
      BodyDescription a = bare_body({0, 0, 0}, {0.1, 0.2, 0.25}), b = bare_body({1, 0.2, 0}, {0.1, 0.12, 0.2});
      a.angular_velocity = {1, 2, -1};
      b.angular_velocity = {-2, 1, 3};
      b.velocity = {0, 1, 2};
      JointDescription joint = joint_of(static_cast<JointKind>(kind), 0, 1, {0.5, 0.1, 0}, {0.5, 1, 0.2});
      joint.second_axis = {1, -0.5, 0};
      if (kind == JOINT_DISTANCE) joint.anchor_b = {1, 0.8, 0};
      if (kind == JOINT_SCREW) joint.pitch = 0.8;
      if (kind == JOINT_ROLLING) joint.radius = 0.2;
      Scene scene = joint_scene({a, b}, {joint}, dt);
      scene.settings.stabilization = Stabilization::velocities;
      scene.settings.correction = 0;
      const JointDrift drift = joint_drift(after_steps<double>(scene, static_cast<u32>(std::lround(0.5 / dt))));
      return std::max(drift.separation, drift.angle);
    };
    const double coarse = opened(1e-3), fine = opened(5e-4);
    EXPECT_LT(coarse, 1e-3);
    if (coarse > 1e-12) {
      EXPECT_GT(coarse / fine, 3.5);
    }
  }
}

// The ring has one motion, which it keeps: six hinges of five bodies are four too many, and do no harm.
TEST(JointScenes, BricardSwingsOn) {
  const Scene scene = read_scene("bricard");
  const InitialState<double> state = compile<double>(scene);
  const double first = energy(state, state.buffers);
  double fastest = 0;
  watch_steps<double>(scene, 500, [&](const Buffers<double>& b, u32 i) {
    fastest = std::max(fastest, length(angular_velocity(b, 2)));
    if (i % 50 != 49) return;
    EXPECT_NEAR(energy(state, b), first, 0.01 * first);
    EXPECT_LT(joint_drift(b).separation, 1e-4);
    EXPECT_LT(joint_drift(b).angle, 5e-3);
  });
  EXPECT_GT(fastest, 1);
}

// The piston is where the crank's angle puts it: x = r cos + sqrt(l^2 - r^2 sin^2). The flap knocks at its stops and
// the bob stays on its rod.
TEST(JointScenes, SliderCrankGoesAsItsGeometrySays) {
  const Scene scene = read_scene("slider_crank");
  const u32 crank = body_named(scene, "crank"), piston = body_named(scene, "piston"), flap = body_named(scene, "flap"),
            bob = body_named(scene, "bob");
  const auto angle = [](const Buffers<double>& b, u32 body) {
    return 2 * std::atan2(b.orientations[body].y, b.orientations[body].w);
  };
  const double stop = scene.joints[5].high;
  double leaned = 0;
  watch_steps<double>(scene, 1500, [&](const Buffers<double>& b, u32 i) {
    const double crank_angle = angle(b, crank), side = 0.5 * std::sin(crank_angle);
    const Vector3 center = position(b, piston);
    EXPECT_NEAR(center[0], 0.5 * std::cos(crank_angle) + std::sqrt(1.5 * 1.5 - side * side), 1e-3);
    EXPECT_NEAR(length(position(b, bob) - center - Vector3{0, 0, -0.15}), 0.75, 1e-3);
    leaned = std::max(leaned, std::abs(std::remainder(angle(b, flap), 6.283185307179586)));
    EXPECT_LT(joint_drift(b).separation, 1e-3);
    if (i < 50) return;
    EXPECT_NEAR(angular_velocity(b, crank)[1], 6, 0.2);  // less when the flap knocks
  });
  EXPECT_NEAR(leaned, stop, 0.02);
}

// The slanting shaft turns as Cardan's formula says, 0.8 to 1.25 times as fast, and the last as fast as the first.
TEST(JointScenes, CardanShaftRotatesUniformlyAgain) {
  const Scene scene = read_scene("cardan_shaft");
  const u32 driver = body_named(scene, "driver"), middle = body_named(scene, "middle"),
            driven = body_named(scene, "driven");
  double least = 10, most = 0;
  watch_steps<float>(scene, 800, [&](const Buffers<float>& b, u32 i) {
    const Vector3 w = angular_velocity(b, middle);
    const double ratio = dot(w, {0.8, 0, 0.6}) / 4;
    const Quaternion q = orientation(b, driver);
    const Vector3 arm =
        exact::rotate(q, exact::rotate({-scene.bodies[driver].orientation[0], -scene.bodies[driver].orientation[1],
                                        -scene.bodies[driver].orientation[2], scene.bodies[driver].orientation[3]},
                                       {0, 0, 1}));
    EXPECT_NEAR(ratio, 0.8 / (1 - 0.36 * arm[2] * arm[2]), 0.01) << i;
    least = std::min(least, ratio);
    most = std::max(most, ratio);
    EXPECT_NEAR(angular_velocity(b, driven)[0], 4, 0.02) << i;
    EXPECT_LT(joint_drift(b).separation, 1e-4);
    EXPECT_LT(joint_drift(b).angle, 1e-4);
  });
  EXPECT_NEAR(least, 0.8, 0.01);
  EXPECT_NEAR(most, 1.25, 0.01);
}

// Two nuts run down as fast as each other, turning against each other, a rubbed one more slowly by as much as its
// friction is of what drives it, and the last stays.
TEST(JointScenes, ScrewNutsRunDown) {
  const Scene scene = read_scene("screw_nut");
  const auto height = [&](const Buffers<float>& b, const char* name) {
    return position(b, body_named(scene, name))[2];
  };
  const double start = 1.9, drives = scene.bodies[0].mass * 9.81 * 0.4 / (2 * 3.141592653589793);
  watch_steps<float>(scene, 800, [&](const Buffers<float>& b, u32 i) {
    const double fell = start - height(b, "free");
    EXPECT_NEAR(height(b, "left_handed"), height(b, "free"), 1e-3) << i;
    EXPECT_NEAR(b.motions[0].w[2], -b.motions[1].w[2], 1e-2) << i;
    EXPECT_NEAR(height(b, "locked"), start, 1e-4) << i;
    if (fell < 1.59) {
      EXPECT_NEAR(start - height(b, "rubbing"), fell * (1 - 2 / drives), 1e-3) << i;
    }
    EXPECT_LT(joint_drift(b).separation, 1e-4) << i;
  });
}

// Pucks stay level, on their table and within its rim; the paddle keeps its speed but for the knocks.
TEST(JointScenes, PucksStayOnTheirAirTable) {
  const Scene scene = read_scene("air_table");
  double paddle = 0;
  watch_steps<float>(scene, 800, [&](const Buffers<float>& b, u32) {
    for (u32 i = 1; i < scene.bodies.size(); ++i) {
      const Vector3 center = position(b, i);
      EXPECT_NEAR(center[2], scene.bodies[i].position[2], 1e-5);
      EXPECT_LT(std::abs(center[0]), 1.5);
      EXPECT_LT(std::abs(center[1]), 1.0);
    }
    EXPECT_LT(joint_drift(b).angle, 1e-4);
    paddle = b.motions[1].w[2];
  });
  EXPECT_NEAR(paddle, 3, 0.5);
}

TEST(JointScenes, RoverDrivesOverItsBumps) {
  const Scene scene = read_scene("rover");
  const u32 chassis = body_named(scene, "chassis");
  double highest = 0;
  Vector3 center = {};
  watch_steps<float>(scene, 300, [&](const Buffers<float>& b, u32) {
    center = position(b, chassis);
    highest = std::max(highest, center[2]);
    EXPECT_LT(joint_drift(b).separation, 0.02);
  });
  EXPECT_GT(center[0], 3);
  EXPECT_LT(std::abs(center[1]), 0.5);
  EXPECT_GT(highest, 0.44);  // it started at 0.42
}

// Knees bend backwards by no more than the displacement in a step takes them, and the figure comes to lie.
TEST(JointScenes, RagDollKeepsItsLimits) {
  const Scene scene = read_scene("rag_doll");
  const double degree = 3.141592653589793 / 180;
  float speed = 1;
  watch_steps<float>(scene, 400, [&](const Buffers<float>& b, u32) {
    for (const JointDescription& joint : scene.joints) {
      if (!joint.limited) continue;
      const Quaternion a = orientation(b, joint.body_a), c = orientation(b, joint.body_b);
      const Quaternion was =
          exact::multiply({-scene.bodies[joint.body_a].orientation[0], -scene.bodies[joint.body_a].orientation[1],
                           -scene.bodies[joint.body_a].orientation[2], scene.bodies[joint.body_a].orientation[3]},
                          scene.bodies[joint.body_b].orientation);
      Quaternion rotation =
          exact::multiply(exact::multiply({-a[0], -a[1], -a[2], a[3]}, c), {-was[0], -was[1], -was[2], was[3]});
      const Vector3 axis = exact::unit(unrotate(scene.bodies[joint.body_a].orientation, joint.axis));
      double angle = 2 * std::atan2(dot({rotation[0], rotation[1], rotation[2]}, axis), rotation[3]);
      angle = std::remainder(angle, 360 * degree);
      EXPECT_GT(angle, joint.low - 5 * degree);
      EXPECT_LT(angle, joint.high + 5 * degree);
    }
    EXPECT_LT(joint_drift(b).separation, 0.03);
    speed = std::abs(b.motions[body_named(scene, "torso")].v[2]);
  });
  EXPECT_LT(speed, 0.2f);
}

// A short run of the chain with its hundred-fold end mass: no joint opens by a millimetre, no energy is gained.
TEST(JointScenes, HeavyChainStaysWhole) {
  Scene scene = read_scene("chain64");
  const InitialState<float> state = compile<float>(scene);
  watch_steps<float>(scene, 100, [&](const Buffers<float>& b, u32) {
    EXPECT_LT(joint_drift(b).separation, 1e-3);
    EXPECT_NEAR(energy(state, b) / 40880, 0, 1e-3);
  });
}

// Bodies that a joint holds do not collide, unless it says so; others do.
TEST(JointScenes, JoinedBodiesDoNotCollide) {
  for (const bool tree : {false, true}) {
    for (const bool collide : {false, true}) {
      std::vector<BodyDescription> bodies = {sphere_body({0, 0, 0}, 0.5), sphere_body({0.8, 0, 0}, 0.5),
                                             sphere_body({1.6, 0, 0}, 0.5)};
      Scene scene = joint_scene(bodies, {joint_of(JOINT_FIXED, 1, 0, {0.4, 0, 0})}, 1.0 / 60);
      scene.materials.push_back({"default"});
      scene.settings.broad_phase = tree ? BroadPhase::bvh : BroadPhase::grid;
      scene.joints[0].collide = collide;
      EXPECT_EQ(after_steps<float>(scene, 1).counters[COUNTER_CONTACTS], collide ? 2u : 1u);
      expect_twins_agree(compile<float>(scene), 2, launch_options({{1, 0}, {16, 0}}));
    }
  }
}

}  // namespace
}  // namespace lockstep::test::joint_scenes_test
