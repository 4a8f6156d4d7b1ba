// Runs begin on the reference and go on, on the device, as if they had always been there.
#include "host/steppers/starting_backend.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/stepper.hpp"
#include "host/world_hash.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::starting_backend_test {
namespace {

u32 steps_on_reference(const Backend<float>& backend) {
  for (const auto& [plan, steps] : backend.steps_by_plan())
    if (plan == "reference") return steps;
  return 0;
}

template <class real>
Simulation<real> starting(const InitialState<real>& state) {
  return {std::make_unique<StartingBackend<real>>(state, test_device(), DeviceOptions()), state.params};
}

// Steps until the device has taken over, at least so often.
template <class real>
u32 step_until_moved(Simulation<real>& simulation, u32 least) {
  u32 steps = 0;
  while (steps < least || simulation.backend().name() == "reference") {
    simulation.step();
    ++steps;
    std::this_thread::sleep_for(std::chrono::milliseconds(5));
  }
  return steps;
}

TEST(StartingBackend, MovesBetweenTwoStepsAndKeepsTheBits) {
  const InitialState<float> state = compile<float>(read_scene("spheres_small"));
  Simulation<float> moves = starting(state);
  EXPECT_EQ(moves.backend().name(), "reference");
  moves.step();
  SavedSimulation after_one = moves.save();
  const u32 steps = step_until_moved(moves, 30) + 1;
  EXPECT_GT(steps_on_reference(moves.backend()), 0u);
  Simulation<float> reference(std::make_unique<ReferenceBackend<float>>(state), state.params);
  for (u32 i = 0; i < steps; ++i) reference.step();
  EXPECT_EQ(state_hash(moves.world_hashes()[0]), state_hash(reference.world_hashes()[0]));

  // a copy that the reference made, put back on the device
  moves.restore(after_one);
  Simulation<float> again(std::make_unique<ReferenceBackend<float>>(state), state.params);
  for (u32 i = 0; i < 40; ++i) again.step();
  for (u32 i = 0; i < 39; ++i) moves.step();
  EXPECT_EQ(state_hash(moves.world_hashes()[0]), state_hash(again.world_hashes()[0]));
}

// What somebody wrote while the reference stepped is there on the device.
TEST(StartingBackend, TakesWhatWasWrittenToTheDevice) {
  const InitialState<double> state = compile<double>(read_scene("rag_doll"));
  Simulation<double> moves = starting(state),
                     reference(std::make_unique<ReferenceBackend<double>>(state), state.params);
  Buffers<double> changed = state.buffers;
  changed.gravities[0].x = 1;
  for (Simulation<double>* simulation : {&moves, &reference}) {
    simulation->step();
    simulation->backend().upload(Buffer::gravities, changed);
  }
  const u32 steps = step_until_moved(moves, 20);
  for (u32 i = 0; i < steps; ++i) reference.step();
  EXPECT_EQ(state_hash(moves.world_hashes()[0]), state_hash(reference.world_hashes()[0]));
}

TEST(Stepper, TakesTheReferenceForFewBodiesWhereNobodyAsksForADevice) {
  const auto name_for = [](const char* scene, const char* device, const DeviceOptions& options = {}) {
    const InitialState<float> state = compile<float>(read_scene(scene));
    return make_stepper(state, target_of(device, options, {})).backend->name();
  };
  EXPECT_EQ(name_for("slide_to_roll", "auto"), "reference");
  EXPECT_NE(name_for("slide_to_roll", "cpu"), "reference");
  DeviceOptions asked;
  asked.lanes = 1;
  EXPECT_NE(name_for("slide_to_roll", "auto", asked), "reference");
}

}  // namespace
}  // namespace lockstep::starting_backend_test
