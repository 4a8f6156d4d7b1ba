// Joints that are tied to each other: gears, racks, fingers that follow each other, tendons.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "host/record/checkpoint.hpp"
#include "host/report/measures.hpp"
#include "include/lockstep/world.hpp"
#include "tests/articulation_scene.hpp"
#include "tests/coupling_scene.hpp"
#include "tests/refusal.hpp"

namespace lockstep::test::couplings_test {
namespace {

constexpr double g = 9.81, pi = std::numbers::pi;

template <class real>
class Couplings : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(Couplings, Precisions);

template <class real>
constexpr double rounding = sizeof(real) == 4 ? 1e-4 : 1e-9;

struct Solved {
  std::string name;
  Scene scene;
};

std::vector<Solved> all_solvers(const Scene& scene) {
  const auto solved_by = [&](Solver solver, u32 substeps) {
    Scene solved = scene;
    replace_solver(solved.settings, solver);
    solved.settings.substeps = substeps;
    return solved;
  };
  return {{"gauss_seidel", solved_by(Solver::gauss_seidel, 1)},
          {"gauss_seidel of 4 sub-steps", solved_by(Solver::gauss_seidel, 4)},
          {"cell_gauss_seidel", solved_by(Solver::cell_gauss_seidel, 1)},
          {"jacobi", solved_by(Solver::jacobi, 1)},
          {"small_steps of 4", solved_by(Solver::small_steps, 4)},
          {"direct", solved_directly(solved_by(Solver::gauss_seidel, 1))}};
}

template <class real>
double coordinate(const InitialState<real>& state, const Buffers<real>& b, u32 joint) {
  return measure_joint(b, state.params, joint).coordinate;
}

template <class real>
double energy(const InitialState<real>& state, const Buffers<real>& b) {
  const Counters none = {};
  return measure(b, state.sizes, state.features, state.params, none).energy();
}

// Two wheels on axles of the world, of 0.1 and 0.3 kg m^2; the second rotates `ratio` times as fast.
Scene gears(double ratio, double armature) {
  Scene scene =
      joint_scene({bare_body({0, 0, 0}), bare_body({1, 0, 0}, {0.3, 0.3, 0.3})},
                  {joint_of(JOINT_HINGE, NONE, 0, {0, 0, 0}), joint_of(JOINT_HINGE, NONE, 1, {1, 0, 0})}, 0.01);
  scene.joints[0].motor_speed = 1e4;
  scene.joints[0].motor_force = 2;
  scene.joints[0].armature = armature;
  scene.couplings = {coupling_of({{0, -ratio}, {1, 1}})};
  return scene;
}

// w' = T / (I_a + a + c^2 I_b), beside a rotor as heavy as one likes.
TYPED_TEST(Couplings, OfWheelsAreGears) {
  using real = TypeParam;
  for (const double ratio : {-1.0, 0.5, 3.0}) {
    for (const double armature : {0.0, 5.0, 100.0}) {
      for (const auto& [name, scene] : all_solvers(gears(ratio, armature))) {
        const Buffers<real> b = after_steps<real>(scene, 20);
        const double speed = 0.2 * 2 / (0.1 + armature + ratio * ratio * 0.3);
        EXPECT_NEAR(double(b.motions[0].w[2]), speed, rounding<real> * speed) << name << ratio << ' ' << armature;
        EXPECT_NEAR(double(b.motions[1].w[2]), ratio * speed, 3 * rounding<real> * speed) << name << ratio;
      }
    }
  }
}

// A rack of 2 kg that falls along z and rotates a pinion of radius r: z'' = -m g / (m + I / r^2).
TYPED_TEST(Couplings, OfASliderAndAHingeAreRackAndPinion) {
  using real = TypeParam;
  const double radius = 0.2;
  Scene scene = joint_scene(
      {bare_body({0, 0, 1}), bare_body({0.2, 0, 0}, {0.1, 0.3, 0.1})},
      {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 1}), joint_of(JOINT_HINGE, NONE, 1, {0.2, 0, 0}, {0, 1, 0})}, 0.005);
  scene.bodies[0].mass = 2;
  scene.couplings = {coupling_of({{0, 1}, {1, -radius}})};
  for (const auto& [name, solved] : all_solvers(scene)) {
    const InitialState<real> state = compile<real>(solved);
    const double speed = -0.5 * 2 * g / (2 + 0.3 / (radius * radius));
    const Buffers<real> b = after_steps<real>(solved, 100);
    EXPECT_NEAR(double(b.motions[0].v[2]), speed, 10 * rounding<real>) << name;
    EXPECT_NEAR(double(b.motions[1].w[1]), speed / radius, 100 * rounding<real>) << name;
    EXPECT_NEAR(coordinate(state, b, 0), radius * coordinate(state, b, 1), rounding<real>) << name;
  }
}

// A coupling of one joint is where the joint is locked; of a motor's it gives what the motor does.
TYPED_TEST(Couplings, OfOneJointLockIt) {
  using real = TypeParam;
  Scene scene = gears(1, 0);
  scene.couplings = {coupling_of({{0, 2}}, 0.5)};  // twice its angle
  for (const auto& [name, solved] : all_solvers(scene)) {
    const InitialState<real> state = compile<real>(solved);
    EXPECT_NEAR(coordinate(state, after_steps<real>(solved, 200), 0), 0.25, 1e-4) << name;
  }
}

// m x'' = -k (x_1 - x_0): w^2 = k (1 / m_0 + 1 / m_1), and the energy stays.
TYPED_TEST(Couplings, WithASpringAreTendons) {
  using real = TypeParam;
  Scene scene = joint_scene(
      {bare_body({0, 0, 0}), bare_body({0, 1, 0})},
      {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0}, {1, 0, 0}), joint_of(JOINT_SLIDER, NONE, 1, {0, 1, 0}, {1, 0, 0})},
      0.005);
  scene.gravity = {0, 0, 0};
  scene.bodies[1].mass = 3;
  CouplingDescription tendon = coupling_of({{0, -1}, {1, 1}});
  tendon.limited = false;
  tendon.spring = {.stiffness = 4 * pi * pi * 0.75, .rest = 0.2};  // one oscillation a second
  scene.couplings = {tendon};
  scene.settings.integrator = Integrator::trapezoidal;
  for (const auto& [name, solved] : all_solvers(scene)) {
    if (solved.settings.solver == Solver::small_steps) continue;  // whose springs lose energy
    const InitialState<real> state = compile<real>(solved);
    const double first = energy(state, state.buffers);
    EXPECT_NEAR(first, 0.5 * 4 * pi * pi * 0.75 * 0.04, 1e-5);
    watch_steps<real>(solved, 200, [&](const Buffers<real>& b, u32 i) {
      const double t = scene.settings.dt * (i + 1), length = coordinate(state, b, 1) - coordinate(state, b, 0);
      ASSERT_NEAR(length, 0.2 - 0.2 * std::cos(2 * pi * t), 1e-3) << name << ' ' << i;
      ASSERT_NEAR(energy(state, b), first, 1e-3 * first) << name << ' ' << i;
    });
  }
}

// It falls until the tendon is taut, which pulls with the weight then.
TYPED_TEST(Couplings, WithLimitsEndThere) {
  using real = TypeParam;
  Scene scene =
      joint_scene({bare_body({0, 0, 0}), bare_body({0, 1, 0})},
                  {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0}), joint_of(JOINT_SLIDER, NONE, 1, {0, 1, 0})}, 0.005);
  scene.bodies[1].mass = 3;
  CouplingDescription tendon = coupling_of({{0, 1}, {1, 1}});  // over a pulley
  tendon.low = -0.1;
  tendon.high = 1;
  scene.couplings = {tendon};
  for (const auto& [name, solved] : all_solvers(scene)) {
    const InitialState<real> state = compile<real>(solved);
    watch_steps<real>(solved, 60, [&](const Buffers<real>& b, u32 i) {
      const double length = coordinate(state, b, 0) + coordinate(state, b, 1);
      ASSERT_GT(length, -0.1 - 1e-3) << name << ' ' << i;
      if (i < 59) return;
      EXPECT_NEAR(length, -0.1, 1e-3) << name;
      EXPECT_NEAR(double(b.motions[0].v[2] + b.motions[1].v[2]), 0, 2e-3) << name;
    });
  }
}

// Atwood's machine comes of it, and a ratio is a block and tackle: a = g (c m_0 - m_1) / (m_1 + c^2 m_0) and so on.
TYPED_TEST(Couplings, OfSlidersArePulleys) {
  using real = TypeParam;
  Scene scene =
      joint_scene({bare_body({0, 0, 0}), bare_body({0, 1, 0})},
                  {joint_of(JOINT_SLIDER, NONE, 0, {0, 0, 0}), joint_of(JOINT_SLIDER, NONE, 1, {0, 1, 0})}, 0.005);
  scene.bodies[1].mass = 3;
  scene.couplings = {coupling_of({{0, 1}, {1, 2}})};
  for (const auto& [name, solved] : all_solvers(scene)) {
    const Buffers<real> b = after_steps<real>(solved, 40);
    const double a_1 = g * (2 * 1 - 3) / (3 + 4 * 1);
    EXPECT_NEAR(double(b.motions[1].v[2]), 0.2 * a_1, 10 * rounding<real>) << name;
    EXPECT_NEAR(double(b.motions[0].v[2]), -0.4 * a_1, 10 * rounding<real>) << name;
  }
}

// On a palm that falls onto its limit, with rotors or without: it stays whole, though the joints share a body. Who
// starts apart is brought together.
TEST(CouplingsOfAGripper, DoNotDrift) {
  for (const double armature : {0.0, 2.0}) {
    Scene scene = gripper(0);
    scene.joints[0].limited = true;
    scene.joints[0].low = -0.1;
    scene.joints[0].high = 1;
    scene.joints[1].armature = armature;
    for (const auto& [name, solved] : all_solvers(scene)) {
      const InitialState<double> state = compile<double>(solved);
      double fastest = 0;
      watch_steps<double>(solved, 1000, [&](const Buffers<double>& b, u32 i) {
        const double first = coordinate(state, b, 1), second = coordinate(state, b, 2);
        fastest = std::max(fastest, std::abs(b.motions[1].w[1]));
        // the few sweeps of the step in which it lands leave some, which comes back
        ASSERT_NEAR(second, -0.5 * first, i >= 70 && i < 100 ? 5e-4 : 1e-6) << name << ' ' << i;
      });
      EXPECT_GT(fastest, 0.5) << name;
    }
    for (const auto& [name, solved] : all_solvers(gripper(0.4))) {
      const InitialState<double> state = compile<double>(solved);
      const Buffers<double> b = after_steps<double>(solved, 500);
      EXPECT_NEAR(coordinate(state, b, 2), 0.4 - 0.5 * coordinate(state, b, 1), 1e-4) << name;
    }
  }
}

TEST(CouplingsOfAWorld, GoOnFromSnapshots) {
  for (const char* device : {"reference", "auto"}) {
    for (const char* precision : {"float", "double"}) {
      World world(gripper(0.2), WorldOptions{.device = device, .precision = precision});
      world.step(20);
      const Snapshot snapshot = world.save();
      std::vector<std::uint64_t> hashes;
      for (u32 i = 0; i < 10; ++i) {
        world.step();
        hashes.push_back(world.state_hash());
      }
      world.restore(snapshot);
      for (const std::uint64_t hash : hashes) {
        world.step();
        EXPECT_EQ(world.state_hash(), hash);
      }
    }
  }
}

TEST(CouplingsOfAWorld, AreKeptInCheckpoints) {
  const InitialState<double> state = compile<double>(gripper(0.2));
  ReferenceBackend<double> whole(state);
  for (u32 i = 0; i < 20; ++i) step(whole, state.params);
  const CheckpointLabel label = {"gripper", "reference", identity_of(state), 0};
  const auto bytes = encode_checkpoint(label, whole.download(persistent_buffers(state.features)), state.features);
  InitialState<double> resumed = state;
  resume_from(bytes, "x.h5", "gripper", resumed);
  ReferenceBackend<double> rest(resumed);
  for (u32 i = 0; i < 10; ++i) {
    step(whole, state.params);
    step(rest, resumed.params);
  }
  EXPECT_NE(whole.buffers().coupling_impulses[0].bound, 0);
  EXPECT_EQ(whole.buffers().coupling_impulses[0].bound, rest.buffers().coupling_impulses[0].bound);
  for (u32 i = 0; i < 3; ++i) EXPECT_EQ(whole.buffers().positions[i].x, rest.buffers().positions[i].x);
}

// Those of worlds in a batch have the bits that they have alone.
TEST(CouplingsOfAWorld, AreNothingToOtherWorlds) {
  const std::vector<Scene> worlds = {gears(0.5, 0), gears(2, 0), gripper(0.1), gripper(0.3)};
  std::vector<Scene> same(worlds);
  for (Scene& scene : same) scene.settings = worlds[0].settings;
  const InitialState<double> state = compile<double>(same);
  ReferenceBackend<double> all(state);
  for (u32 i = 0; i < 20; ++i) step(all, state.params);
  for (u32 w = 0; w < same.size(); ++w) {
    const Buffers<double> alone = after_steps<double>(same[w], 20);
    const u32 first = state.buffers.world_ranges[w].first_body;
    for (u32 i = 0; i < same[w].bodies.size(); ++i)
      EXPECT_EQ(all.buffers().motions[first + i].w[1], alone.motions[i].w[1]);
  }
}

TEST(CouplingsOfAWorld, GoWithTheirJoints) {
  Scene scene = gripper(0.2);
  scene.couplings.push_back(coupling_of({{0, 1}}, 0.1));
  World world(scene, WorldOptions{.device = "reference", .precision = "double"});
  world.step(3);
  world.remove(world.joints()[1]);
  world.step(200);
  EXPECT_NEAR(world.pose(world.bodies()[0]).position[2], 0.1, 1e-3) << "the other one stays";
}

TEST(CouplingsOfAWorld, AreRefusedWhereNothingSolvesThem) {
  const auto refusal = [](auto&& change) {
    Scene scene = gripper(0.2);
    scene.source = "x.json";
    change(scene);
    return lockstep::refusal([&] { World(scene, WorldOptions{.device = "reference", .precision = "double"}).step(); });
  };
  const std::string sweeps =
      "x.json: /settings/solver: couplings of joints are solved by sweeps; take gauss_seidel, cell_gauss_seidel, "
      "jacobi "
      "or small_steps";
  for (const char* solver : {"gradient", "nsgs", "reduced_auto"})
    EXPECT_EQ(refusal([&](Scene& scene) { replace_solver(scene.settings, *find_solver(solver)); }), sweeps) << solver;
  EXPECT_EQ(
      refusal([](Scene& scene) { scene.settings.sleeping.emplace(); }),
      "x.json: /settings/sleeping: an island that sleeps would not feel a coupling of its joints; leave it out in "
      "scenes with couplings");
  EXPECT_EQ(refusal([](Scene& scene) { scene.couplings[0].joints[0].ratio = 0; }),
            "coupling: must have finite ratios that are not 0");
  EXPECT_EQ(refusal([](Scene& scene) { scene.couplings[0].joints[0].joint = 9; }),
            "coupling: has a joint that the scene does not have");
  EXPECT_EQ(refusal([](Scene& scene) { scene.couplings[0].limited = false; }), "coupling: needs limits or a spring");
  EXPECT_EQ(refusal([](Scene& scene) { scene.joints[1].kind = JOINT_BALL; }),
            "coupling: has the joint \"\", which has no coordinate");
}

}  // namespace
}  // namespace lockstep::test::couplings_test
