// Redo of a step that ran out of room, and the line that names what went bad.
#include "host/simulation.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>

#include "host/scene/read.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::simulation_test {
namespace {

// Finds a given number of pairs and contacts in every step, and has no room for all at first.
class FakeBackend final : public Backend<float> {
 public:
  FakeBackend(Sizes sizes, Counters found) : sizes_(sizes), found_(found) {
    buffers_.body_infos = {{0, 0, BODY_STATIC, 1}, {1, 0, BODY_STATIC, 1}, {1, 1, BODY_STATIC, 1}};
    sizes_.bodies = 3;
  }

  void run(Stage stage, const StepParams<float>& params) override {
    if (stage == Stage::begin_step) last_params = params;
  }
  Counters counters() override {
    Counters current = found_;
    if (found_[COUNTER_PAIRS_NEEDED] > sizes_.pairs)
      current[COUNTER_STATUS] |= STATUS_PAIRS_FULL;
    else if (found_[COUNTER_CONTACTS_NEEDED] > sizes_.contacts)
      current[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
    else if (found_[COUNTER_BLOCKS_NEEDED] > sizes_.blocks || found_[COUNTER_ROWS_NEEDED] > sizes_.rows)
      current[COUNTER_STATUS] |= STATUS_BLOCKS_FULL | STATUS_ROWS_FULL;
    return current;
  }
  void grow(const Sizes& sizes) override { sizes_ = sizes; }
  void enable(Feature) override {}
  const Buffers<float>& download(std::span<const Buffer>) override { return buffers_; }
  void upload(Buffer, const Buffers<float>&) override {}
  const Sizes& sizes() const override { return sizes_; }
  Features features() const override { return static_cast<Features>(Feature::time_stepping); }
  std::string name() const override { return "fake"; }
  StageSeconds stage_seconds() const override { return {}; }

  /// From the next step on.
  void find(const Counters& found) { found_ = found; }

  StepParams<float> last_params = {};

 private:
  Sizes sizes_;
  Counters found_;
  Buffers<float> buffers_;
};

TEST(Simulation, RedoesAStepWithRoomForWhatItNeeds) {
  Counters found = {};
  found[COUNTER_PAIRS_NEEDED] = 100;
  found[COUNTER_CONTACTS_NEEDED] = 1000;
  found[COUNTER_BLOCKS_NEEDED] = 3;
  found[COUNTER_ROWS_NEEDED] = 14;
  Sizes sizes;
  sizes.pairs = sizes.contacts = sizes.blocks = sizes.rows = 1;
  auto owned = std::make_unique<FakeBackend>(sizes, found);
  FakeBackend& backend = *owned;
  Simulation<float> simulation(std::move(owned), {});
  simulation.step();
  EXPECT_EQ(simulation.redone(), 3u);
  EXPECT_EQ(simulation.steps_done(), 1u);
  EXPECT_EQ(backend.sizes().pairs, 128u);  // 125 in whole blocks of 16
  EXPECT_EQ(backend.sizes().contacts, 1264u);
  EXPECT_EQ(backend.sizes().blocks, 16u);
  EXPECT_EQ(backend.sizes().rows, 32u);
  EXPECT_EQ(backend.last_params.pair_capacity, 128u);
  EXPECT_EQ(backend.last_params.contact_capacity, 1264u);
  EXPECT_EQ(backend.last_params.block_capacity, 16u);
  EXPECT_EQ(backend.last_params.row_capacity, 32u);
  simulation.step();
  EXPECT_EQ(simulation.redone(), 3u);
}

std::string message_of_step(u32 status, u32 bad_body) {
  Counters found = {};
  found[COUNTER_STATUS] = status;
  found[COUNTER_BAD_BODY] = bad_body;
  Simulation<float> simulation(std::make_unique<FakeBackend>(Sizes(), found), {});
  try {
    simulation.step();
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::comparison);
    return error.what();
  }
  return "";
}

TEST(Simulation, NamesTheBodyTheStageAndTheStepThatWentBad) {
  EXPECT_EQ(message_of_step(STATUS_BAD_FORCES | STATUS_BAD_POSE, NONE - 2),
            "step 0, integrate_velocities: body 1 of world 1: the forces make its velocity infinite, not a number or "
            "faster than the speed limit; try a shorter time step");
  EXPECT_EQ(message_of_step(STATUS_TOO_DENSE, NONE - 1),
            "step 0, couple_contacts: body 0 of world 1: its world has more than 4096 contacts, the most that "
            "dense_gauss_seidel takes; take gauss_seidel");
  EXPECT_EQ(message_of_step(STATUS_BAD_POSE, NONE - 0),
            "step 0, integrate_positions: body 0 of world 0: its pose is infinite or not a number; try a shorter time "
            "step");
  EXPECT_EQ(message_of_step(STATUS_OUT_OF_GRID | STATUS_PAIRS_FULL, 0),
            "step 0, sort_cells: some body: a shape is too far out for the collision grid, its cell has no number");
}

// A step that failed is none of those done, is unsolved once, and none follows it.
TEST(Simulation, CountsAStepThatFailedOnce) {
  Counters found = {};
  auto owned = std::make_unique<FakeBackend>(Sizes(), found);
  FakeBackend& backend = *owned;
  Simulation<float> simulation(std::move(owned), {});
  simulation.step();
  EXPECT_EQ(simulation.unsolved().count, 0u);
  found[COUNTER_STATUS] = STATUS_BAD_POSE;
  backend.find(found);
  EXPECT_THROW(simulation.step(), Error);
  found[COUNTER_STATUS] = 0;
  backend.find(found);
  for (int i = 0; i < 3; ++i) {
    try {
      simulation.step();
      FAIL() << "no step follows one that was cut short";
    } catch (const Error& error) {
      EXPECT_EQ(error.failure(), Failure::comparison);
      EXPECT_EQ(std::string(error.what()),
                "step 1: failed before, and no step follows one that was cut short; go on from a state before it");
    }
    EXPECT_EQ(simulation.steps_done(), 1u);
    EXPECT_EQ(simulation.unsolved().count, 1u);
    EXPECT_EQ(simulation.unsolved().ended[u32(Stop::bad)], 1u);
    EXPECT_EQ(simulation.unsolved().worst_step, 1u);
    EXPECT_EQ(simulation.unsolved().worst_stop, Stop::bad);
  }
}

// What sweeps left undone in the sub-steps of a step is at its limit.
TEST(Simulation, SumsUpWhatSweepsLeftUnsolved) {
  Counters found = {};
  auto owned = std::make_unique<FakeBackend>(Sizes(), found);
  FakeBackend& backend = *owned;
  StepParams<float> params = {};
  params.tolerance = 0.25f;
  Simulation<float> simulation(std::move(owned), params);
  simulation.step();
  for (const u32 count : {3u, 0u, 2u}) {
    found[COUNTER_UNSOLVED] = count;
    backend.find(found);
    simulation.step();
  }
  const Unsolved unsolved = simulation.unsolved();
  EXPECT_EQ(unsolved.count, 5u);
  EXPECT_EQ(unsolved.ended[u32(Stop::limit)], 5u);
  EXPECT_EQ(unsolved.first_step, 1u);
  EXPECT_EQ(unsolved.first_stop, Stop::limit);
  EXPECT_EQ(unsolved.tolerance, 0.25);
  EXPECT_TRUE(unsolved.of_changes);
}

TEST(Unsolved, KeepsTheFirstAndTheWorst) {
  Unsolved all;
  all.add(Unsolved::of(1, 4, Stop::stalled, 1e-7, 1e-10));
  all.add({});
  all.add(Unsolved::of(2, 5, Stop::limit, 1e-3, 1e-10));
  all.add(Unsolved::of(1, 6, Stop::infeasible, 1e-5, 1e-10));
  EXPECT_EQ(all.count, 4u);
  EXPECT_EQ(all.ended, (std::array<u32, stop_count>{0, 2, 1, 1, 0}));
  EXPECT_EQ(all.first_step, 4u);
  EXPECT_EQ(all.first_stop, Stop::stalled);
  EXPECT_EQ(all.worst_step, 5u);
  EXPECT_EQ(all.worst_stop, Stop::limit);
  all.add(Unsolved::of(1, 7, Stop::bad, std::numeric_limits<double>::quiet_NaN(), 1e-10));
  all.add(Unsolved::of(1, 8, Stop::limit, 1e9, 1e-10));
  EXPECT_EQ(all.worst_step, 7u) << "no number is worse than any number";
  EXPECT_EQ(all.worst_stop, Stop::bad);
  EXPECT_EQ(all.count, 6u);
}

// The lists as short as can be: every one of them has to grow, some of them several times.
template <class real>
InitialState<real> with_capacity_one(InitialState<real> state) {
  state.sizes.pairs = state.sizes.contacts = state.sizes.blocks = state.sizes.rows = 1;
  state.params.pair_capacity = state.params.contact_capacity = 1;
  state.params.block_capacity = state.params.row_capacity = 1;
  state.sizes.coupled_tiles = std::min(state.sizes.coupled_tiles, 1u);
  resize(state.buffers, state.sizes, state.features);
  return state;
}

template <class real>
std::vector<WorldHash> hashes_after(std::unique_ptr<Backend<real>> backend, const StepParams<real>& params, int steps,
                                    bool redoes) {
  Simulation<real> simulation(std::move(backend), params);
  for (int i = 0; i < steps; ++i) simulation.step();
  EXPECT_GT(simulation.counters()[COUNTER_CONTACTS], 0u);
  EXPECT_EQ(simulation.redone() > 0, redoes);
  return simulation.world_hashes();
}

bool equal(const std::vector<WorldHash>& a, const std::vector<WorldHash>& b) {
  return a.size() == b.size() && std::memcmp(a.data(), b.data(), a.size() * sizeof(WorldHash)) == 0;
}

template <class real>
void expect_capacities_change_nothing() {
  constexpr int steps = 60;
  const InitialState<real> ample = compile<real>(read_scene("spheres_small"));
  const InitialState<real> tight = with_capacity_one(ample);
  const auto expected = hashes_after<real>(std::make_unique<ReferenceBackend<real>>(ample), ample.params, steps, false);
  EXPECT_TRUE(
      equal(expected, hashes_after<real>(std::make_unique<ReferenceBackend<real>>(tight), tight.params, steps, true)));
  EXPECT_TRUE(equal(expected, hashes_after<real>(std::make_unique<DeviceBackend<real>>(ample, test_device()),
                                                 ample.params, steps, false)));
  EXPECT_TRUE(equal(expected, hashes_after<real>(std::make_unique<DeviceBackend<real>>(tight, test_device()),
                                                 tight.params, steps, true)));
  EXPECT_TRUE(
      equal(expected, hashes_after<real>(std::make_unique<CheckedBackend<real>>(tight, test_device(), DeviceOptions(),
                                                                                CheckOptions{.poison = true}),
                                         tight.params, steps, true)));
}

// Every list that grows in some scene: several points a pair, joints, events, patches, copies of bodies, a tree.
TEST(Simulation, CapacitiesChangeNothingInAnyKindOfScene) {
  for (const char* name : {"slabs", "rover", "sensor_gate", "dominoes", "cylinders_and_hulls", "mixed_spheres"}) {
    for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps, Solver::jacobi, Solver::accelerated_gradient,
                                Solver::dense_gauss_seidel, Solver::cell_gauss_seidel}) {
      for (const FrictionModel friction : {FrictionModel::cones, FrictionModel::patches}) {
        Scene scene = read_scene(name);
        if (!scene.joints.empty() && solver != scene.settings.solver) continue;  // not every solver holds its joints
        const bool cones_alone = is_gradient(solver) || solver == Solver::dense_gauss_seidel;
        if (cones_alone && friction == FrictionModel::patches) continue;  // refused
        SCOPED_TRACE(std::string(name) + ", " + name_of(solver) + ", " + name_of(friction));
        replace_solver(scene.settings, solver);
        scene.settings.friction_model = friction;
        const InitialState<float> ample = compile<float>(scene), tight = with_capacity_one(ample);
        EXPECT_TRUE(
            equal(hashes_after<float>(std::make_unique<ReferenceBackend<float>>(ample), ample.params, 40, false),
                  hashes_after<float>(std::make_unique<ReferenceBackend<float>>(tight), tight.params, 40, true)));
      }
    }
  }
}

TEST(Simulation, CapacitiesChangeNothingInFloat) { expect_capacities_change_nothing<float>(); }
TEST(Simulation, CapacitiesChangeNothingInDouble) { expect_capacities_change_nothing<double>(); }

// ---- a body gone bad in flight
// ---------------------------------------------------------------------------------------

// What a run says after body 7 was given something that is no number, five steps after the start.
std::string message_after(std::unique_ptr<Backend<float>> owned, const StepParams<float>& params, Buffer where) {
  Backend<float>& backend = *owned;
  Simulation<float> simulation(std::move(owned), params);
  for (int i = 0; i < 5; ++i) simulation.step();
  Buffers<float> buffers = backend.download(std::span(&where, 1));
  if (where == Buffer::motions) buffers.motions[7].w[1] = std::numeric_limits<float>::quiet_NaN();
  if (where == Buffer::positions) buffers.positions[7].z = std::numeric_limits<float>::infinity();
  if (where == Buffer::orientations) buffers.orientations[7].x = std::numeric_limits<float>::quiet_NaN();
  backend.upload(where, buffers);
  try {
    for (int i = 0; i < 3; ++i) simulation.step();
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::comparison);
    return error.what();
  }
  return "goes on";
}

// A run that is resumed has impulses to start from.
TEST(Simulation, TheFirstStepOfARunGetsTenTimesTheSweeps) {
  StepParams<float> params = {};
  params.iterations = 7;
  for (const u32 steps_done : {0u, 3u}) {
    auto owned = std::make_unique<FakeBackend>(Sizes(), Counters{});
    FakeBackend& backend = *owned;
    Simulation<float> simulation(std::move(owned), params, steps_done);
    simulation.step();
    EXPECT_EQ(backend.last_params.iterations, steps_done == 0 ? 70u : 7u);
    simulation.step();
    EXPECT_EQ(backend.last_params.iterations, 7u);
  }
}

// Two links stand out level from a wall in hinges that rub by 20 N m, where their weight asks for 9.81 and 2.4525 N m:
// nothing moves, from the first step on.
TEST(Simulation, HingesWithFrictionDoNotSlipAtFirst) {
  for (const char* joint_solver : {"sweeps", "direct"}) {
    const Scene scene =
        parse_scene(std::string(R"({"settings": {"dt": 0.01, "joint_solver": ")") + joint_solver + R"("},
        "bodies": [{"name": "a", "mass": 0.5, "inertia": [0.01, 0.05, 0.05], "position": [0.5, 0, 0]},
                   {"name": "b", "mass": 0.5, "inertia": [0.01, 0.05, 0.05], "position": [1.5, 0, 0]}],
        "joints": [{"name": "j0", "type": "hinge", "bodies": ["world", "a"], "anchor": [0, 0, 0], "axis": [0, 1, 0],
                    "friction": 20},
                   {"name": "j1", "type": "hinge", "bodies": ["a", "b"], "anchor": [1, 0, 0], "axis": [0, 1, 0],
                    "friction": 20}]})",
                    "simulation_test");
    const InitialState<double> state = compile<double>(scene);
    Simulation<double> simulation(std::make_unique<ReferenceBackend<double>>(state), state.params);
    const Buffer wanted[] = {Buffer::motions};
    for (int step = 0; step < 30; ++step) {
      simulation.step();
      for (const Motion<double>& motion : simulation.backend().download(wanted).motions)
        for (const double w : motion.w) EXPECT_NEAR(w, 0, 1e-4) << joint_solver << " " << step;
    }
  }
}

TEST(Simulation, NamesTheBodyThatWentBadInFlight) {
  const InitialState<float> state = compile<float>(read_scene("spheres_small"));
  const auto expect_both = [&](Buffer where, const std::string& start) {
    const std::string reference = message_after(std::make_unique<ReferenceBackend<float>>(state), state.params, where);
    EXPECT_EQ(reference.rfind(start, 0), 0u) << reference;
    EXPECT_EQ(message_after(std::make_unique<DeviceBackend<float>>(state, test_device()), state.params, where),
              reference);
  };
  for (const Buffer where : {Buffer::motions, Buffer::positions, Buffer::orientations})
    expect_both(where, "step 5, sort_cells: body 7 of world 0: a shape is too far out");
}

}  // namespace
}  // namespace lockstep::simulation_test
