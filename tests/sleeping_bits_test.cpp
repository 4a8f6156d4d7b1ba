// Sleep and the bits: twins agree, nothing of how a step is run counts, and what is awake has the bits that it has
// where nobody sleeps.
#include <cstring>

#include "host/record/checkpoint.hpp"
#include "host/scene/step_params.hpp"
#include "tests/sleeping_scenes.hpp"

namespace lockstep::test::sleeping_bits_test {
namespace {

// Piles that fall asleep, a ball that comes late and wakes one of them, and boxes that tumble on.
std::string tumblers() {
  std::string bodies = column(0, 2) + ", " + column(4, 2) + ", " + ball(-4, 0.5, R"(, "velocity": [6, 0, 0])");
  for (int i = 0; i < 5; ++i)
    bodies += ", " + box(20 + 1.2 * i, 4 + 1.5 * (i % 3), R"(, "angular_velocity": [0.3, 1, 0.2])");
  return bodies;
}

std::string with_solver(const std::string& name, double after) {
  const std::string model = name == "patches" ? R"("friction_model": "patches")" : R"("solver": ")" + name + "\"";
  return model + R"(, "sleeping": {"after": )" + std::to_string(after) + "}";
}

constexpr const char* solvers[] = {"gauss_seidel", "small_steps", "jacobi", "patches", "dense_gauss_seidel"};

TEST(SleepingBits, TwinsAgreeWhileIslandsFallAsleepAndWake) {
  for (const char* solver : solvers) {
    SCOPED_TRACE(solver);
    InitialState<float> state = compile<float>(scene_of(tumblers(), with_solver(solver, 0.2)));
    const bool first = std::string(solver) == solvers[0];
    expect_twins_agree(state, 50, first ? all_launch_options() : launch_options({{16, 0}}));
  }
  const auto in_double = compile<double>(scene_of(tumblers(), with_solver("gauss_seidel", 0.2)));
  expect_twins_agree(in_double, 50, launch_options({{8, 0}}));
}

// A door that hangs at rest by a hinge with limits, beside it a box on a spring; a ball comes and knocks the door open.
TEST(SleepingBits, TwinsAgreeWithJointsThatSleep) {
  const std::string bodies = R"({"name": "door", "mass": 2, "position": [0, 0.5, 1.5],
    "shapes": [{"type": "box", "size": [0.1, 1, 1]}]}, {"name": "box", "mass": 1, "position": [5, 0, 2], "shapes": [
    {"type": "box", "size": [0.5, 0.5, 0.5]}]}, )" +
                             ball(-3.5, 1.5, R"(, "velocity": [6, 0, 3])");
  const std::string joints = R"(, "joints": [
    {"type": "hinge", "bodies": ["world", "door"], "anchor": [0, 0, 1.5], "axis": [0, 0, 1], "limits_deg": [-90, 90]},
    {"type": "slider", "bodies": ["world", "box"], "anchor": [5, 0, 2], "axis": [1, 0, 0],
     "spring": {"stiffness": 100, "damping": 10}}])";
  for (const char* solver : {"gauss_seidel", "small_steps", "jacobi", "dense_gauss_seidel"}) {
    SCOPED_TRACE(solver);
    const auto state = compile<float>(scene_of(bodies, with_solver(solver, 0.2), joints));
    expect_twins_agree(state, 45, launch_options({{1, 7}, {16, 0}}));
    Simulation<float> simulation = on_reference(state);
    for (u32 i = 0; i < 25; ++i) simulation.step();
    EXPECT_EQ(simulation.counters()[COUNTER_ASLEEP], 2u);
    for (u32 i = 0; i < 20; ++i) simulation.step();
    EXPECT_EQ(simulation.wakings(), 1u);
    EXPECT_EQ(simulation.counters()[COUNTER_ASLEEP], 1u);
  }
}

TEST(SleepingBits, TwinsAgreeInEachBroadPhaseWithEventsAndTriggers) {
  const std::string gate = R"({"type": "static", "position": [0, 0, 0.5], "shapes": [
    {"type": "box", "size": [3, 3, 3], "trigger": true}]}, )";
  std::uint64_t hashes[2];
  for (const char* broad_phase : {"grid", "bvh"}) {
    SCOPED_TRACE(broad_phase);
    const std::string settings = R"("events": true, "sleeping": {"after": 0.2}, "broad_phase": ")";
    const auto state = compile<float>(scene_of(gate + tumblers(), settings + broad_phase + "\""));
    expect_twins_agree(state, 50, launch_options({{1, 7}, {16, 0}}));
    Simulation<float> simulation = on_reference(state);
    for (u32 i = 0; i < 50; ++i) simulation.step();
    EXPECT_GT(simulation.wakings(), 0u);
    hashes[std::string(broad_phase) == "bvh"] = hash_of(simulation);
  }
  EXPECT_EQ(hashes[0], hashes[1]);
}

// Whoever steps it: with lanes, work-groups and threads, fused and not, redone for want of room.
TEST(SleepingBits, DoNotDependOnHowAStepIsRun) {
  const InitialState<float> state = compile<float>(scene_of(tumblers(), with_solver("gauss_seidel", 0.2)));
  const auto hash_after = [](Simulation<float> simulation) {
    for (u32 i = 0; i < 60; ++i) simulation.step();
    EXPECT_GT(simulation.wakings(), 0u);
    return hash_of(simulation);
  };
  const std::uint64_t expected = hash_after(on_reference(state));
  for (const DeviceOptions& options : launch_options({{1, 0}, {8, 4}, {16, 16}}))
    EXPECT_EQ(hash_after(on_device(state, options)), expected);
  InitialState<float> tight = state;
  tight.sizes.pairs = tight.sizes.contacts = 16;
  tight.sizes.blocks = tight.sizes.rows = 2;
  set_sizes(tight.params, tight.sizes);
  tight.buffers.cached_keys.clear();
  for_each_buffer(tight.buffers, [&](Buffer buffer, auto& elements) {
    if (info(buffer).lifetime == Lifetime::transient) elements.clear();
  });
  resize(tight.buffers, tight.sizes, tight.features);
  EXPECT_EQ(hash_after(on_reference(tight)), expected);
  EXPECT_EQ(hash_after(on_device(tight)), expected);
}

// Bodies are 0 the plane, 1-2 and 3-4 the piles, 5 the ball, 6-10 those that tumble.
TEST(SleepingBits, OfWhatIsAwakeAreThoseWithoutSleep) {
  for (const char* solver : solvers) {
    SCOPED_TRACE(solver);
    Simulation<float> with = on_reference(compile<float>(scene_of(tumblers(), with_solver(solver, 0.2))));
    Simulation<float> without = on_reference(compile<float>(scene_of(tumblers(), with_solver(solver, 1e9))));
    u32 asleep_steps = 0;
    for (u32 i = 0; i < 120; ++i) {
      with.step();
      without.step();
      asleep_steps += sleeps(with, 1) ? 1 : 0;
      const Buffers<float>&a = state_of(with), &b = state_of(without);
      for (u32 body = 5; body <= 10; ++body) {
        if (body == 5 && with.wakings() > 0) continue;  // it has touched what slept
        if (a.sleepers[body].island != NONE) continue;  // tumbling ends
        ASSERT_EQ(std::memcmp(&a.positions[body], &b.positions[body], sizeof a.positions[0]), 0) << i << " " << body;
        ASSERT_EQ(std::memcmp(&a.orientations[body], &b.orientations[body], sizeof a.positions[0]), 0) << i;
        ASSERT_EQ(std::memcmp(&a.motions[body], &b.motions[body], sizeof a.motions[0]), 0) << i << " " << body;
      }
    }
    EXPECT_GT(asleep_steps, 10u);
    EXPECT_GT(with.wakings(), 0u);
  }
}

// So do those of an island among others and alone: its contacts stand elsewhere in the list.
TEST(SleepingBits, OfAnIslandDoNotDependOnOthers) {
  std::string piles = column(-30, 5) + ", " + column(-25, 5) + ", ", tumbling;
  for (int i = 0; i < 8; ++i)
    tumbling += (i > 0 ? ", " : "") + box(1.1 * (i % 3), 3 + 1.2 * i, R"(, "angular_velocity": [0.3, 1, 0.2])");
  for (const char* solver : solvers) {
    SCOPED_TRACE(solver);
    // bodies of the same ids: others stand where they are, or are out of the world's reach
    std::string far = piles;
    for (std::size_t at = 0; (at = far.find(R"("mass": 1, )", at)) != std::string::npos; at += 10)
      far.replace(at, 10, R"("type": "static",)");
    Simulation<float> among = on_reference(compile<float>(scene_of(piles + tumbling, with_solver(solver, 1e9))));
    Simulation<float> alone = on_reference(compile<float>(scene_of(far + tumbling, with_solver(solver, 1e9))));
    u32 fewer = 0;
    for (u32 i = 0; i < 150; ++i) {
      among.step();
      alone.step();
      fewer += alone.counters()[COUNTER_CONTACTS] < among.counters()[COUNTER_CONTACTS] ? 1 : 0;
      const Buffers<float>&a = state_of(among), &b = state_of(alone);
      for (u32 body = 11; body <= 18; ++body)
        ASSERT_EQ(std::memcmp(&a.positions[body], &b.positions[body], sizeof a.positions[0]), 0) << i << " " << body;
    }
    EXPECT_EQ(fewer, 150u);
  }
}

TEST(SleepingBits, AWorldInABatchHasThoseThatItHasAlone) {
  const std::vector<Scene> scenes = {scene_of(tumblers()), scene_of(column(0, 4)), scene_of(two_columns_and_a_ball)};
  Simulation<float> batch = on_reference(compile<float>(std::span<const Scene>(scenes)));
  std::vector<Simulation<float>> alone;
  for (const Scene& scene : scenes) alone.push_back(on_reference(compile<float>(scene)));
  for (u32 i = 0; i < 120; ++i) {
    batch.step();
    for (Simulation<float>& world : alone) world.step();
  }
  EXPECT_GT(batch.wakings(), 0u);
  const std::vector<WorldHash> hashes = batch.world_hashes();
  for (std::size_t w = 0; w < alone.size(); ++w) {
    const WorldHash hash = alone[w].world_hashes().front();
    EXPECT_EQ(hash.state_low, hashes[w].state_low) << w;
    EXPECT_EQ(hash.state_high, hashes[w].state_high) << w;
  }
}

TEST(SleepingBits, GoOnFromACheckpointWithSleepers) {
  const InitialState<float> state = compile<float>(scene_of(tumblers(), with_solver("gauss_seidel", 0.2)));
  Simulation<float> whole = on_reference(state);
  std::vector<std::vector<unsigned char>> checkpoints;
  std::vector<u32> asleep;
  while (whole.steps_done() < 120) {
    if (whole.steps_done() % 20 == 0) {
      const CheckpointLabel label = {"x", whole.backend().name(), identity_of(state), hash_of(whole)};
      const Buffers<float>& current = whole.backend().download(persistent_buffers(state.features));
      checkpoints.push_back(encode_checkpoint(label, current, state.features));
      asleep.push_back(whole.counters()[COUNTER_ASLEEP]);
    }
    whole.step();
  }
  EXPECT_GE(*std::max_element(asleep.begin(), asleep.end()), 4u);
  for (const auto& bytes : checkpoints) {
    InitialState<float> resumed = state;
    const CheckpointLabel label = resume_from(bytes, "x.h5", "x", resumed);
    Simulation<float> rest = on_device(resumed);
    EXPECT_EQ(hash_of(rest), label.state_hash);
    while (rest.steps_done() < 120) rest.step();
    EXPECT_EQ(hash_of(rest), hash_of(whole));
  }
}

}  // namespace
}  // namespace lockstep::test::sleeping_bits_test
