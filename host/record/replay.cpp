#include "host/record/replay.hpp"

#include <algorithm>

#include "host/backends/words.hpp"
#include "host/record/current_state.hpp"
#include "host/record/inputs.hpp"
#include "host/record/recording_tables.hpp"
#include "host/scene/json_node.hpp"
#include "host/simulation.hpp"
#include "host/world_hash.hpp"

namespace lockstep {

namespace {

template <class real>
class Replay {
 public:
  Replay(const RecordingReader& recording, const StepTarget& target, const Parting<real>& parting)
      : recording_(recording), target_(target), parting_(parting), start_(recording.start<real>()) {}

  Replayed run(const std::function<void(u32)>& done) const {
    Simulation<real> simulation = simulate(start_);
    Buffers<real> driven = driven_by_inputs(start_.buffers);
    for (u32 row = 0; row < recording_.steps(); ++row) {
      act(inputs_before(row), simulation.backend(), driven);
      simulation.step();
      const std::vector<WorldHash> hashes = simulation.world_hashes();
      for (u32 world = 0; world < hashes.size(); ++world) {
        const std::size_t at = std::size_t{row} * hashes.size() + world;
        if (state_hash(hashes[world]) != recording_.state_hashes()[at] ||
            pose_hash(hashes[world]) != recording_.pose_hashes()[at])
          explain(row, world, hashes[world]);
      }
      done(row + 1);
    }
    return {simulation.backend().name(), simulation.backend().unsolved()};
  }

 private:
  Simulation<real> simulate(const InitialState<real>& state) const {
    return Simulation<real>(make_stepper(state, target_).backend, state.params, state.buffers.step_index.front());
  }

  // What was done before the step of a row.
  std::span<const InputRow> inputs_before(u32 row) const {
    const std::vector<InputRow>& all = recording_.inputs();
    const u32 step = recording_.rows()[row].step;
    return {std::ranges::lower_bound(all, step, {}, &InputRow::step),
            std::ranges::upper_bound(all, step, {}, &InputRow::step)};
  }

  // The state from which the step of a row starts, with what was done before it.
  InitialState<real> state_before(u32 row) const {
    Simulation<real> simulation = simulate(start_);
    Buffers<real> driven = driven_by_inputs(start_.buffers);
    for (u32 i = 0; i < row; ++i) {
      act(inputs_before(i), simulation.backend(), driven);
      simulation.step();
    }
    act(inputs_before(row), simulation.backend(), driven);
    return current_state(start_, simulation);
  }

  [[noreturn]] void explain(u32 row, u32 world, const WorldHash& here) const {
    const u32 step = recording_.rows()[row].step - 1;  // as every message counts, from 0
    const InitialState<real> before = state_before(row);
    check(before);
    const std::string where = "step " + std::to_string(step);
    compare_bodies(before, row, where);
    const std::size_t at = std::size_t{row} * start_.sizes.worlds + world;
    fail(where, "the state hash of world " + std::to_string(world) + " was recorded as " +
                    hash_text(recording_.state_hashes()[at]) + " and is " + hash_text(state_hash(here)) +
                    " here; poses and velocities are equal");
  }

  // The step on the device and in the reference beside each other: throws Mismatch where they part. An oracle has no
  // twin.
  void check(const InitialState<real>& before) const {
    if (before.oracle) return;
    const std::optional<DeviceInfo> device = target_.device ? target_.device : select_device("auto");
    if (!device) return;
    auto owned = std::make_unique<CheckedBackend<real>>(before, *device, target_.options, CheckOptions{.fused = true});
    CheckedBackend<real>& backend = *owned;
    Simulation<real> simulation(std::move(owned), before.params, before.buffers.step_index.front());
    try {
      simulation.step();
    } catch (const Mismatch& mismatch) {
      if (parting_) parting_(mismatch, backend);
      throw;
    }
  }

  void compare_bodies(const InitialState<real>& before, u32 row, const std::string& where) const {
    Simulation<real> simulation = simulate(before);
    simulation.step();
    const Buffer wanted[] = {Buffer::positions, Buffer::orientations, Buffer::motions};
    const Buffers<real>& current = simulation.backend().download(wanted);
    const auto compare = [&](u32 table, const char* buffer, const auto& records, std::size_t first) {
      const std::size_t columns = body_tables[table].columns;
      const std::vector<real> recorded = recording_.bodies<real>(table, row);
      for (std::size_t i = 0; i < std::min(recorded.size() / columns, records.size()); ++i) {
        for (std::size_t k = 0; k < columns; ++k) {
          const real is = reinterpret_cast<const real*>(&records[i])[first + k], was = recorded[i * columns + k];
          if (!same_bits(was, is))
            fail(where, std::string(buffer) + "[" + std::to_string(i) + "] word " + std::to_string(first + k) +
                            ": recorded " + show_word(was) + ", here " + show_word(is));
        }
      }
    };
    compare(0, "positions", current.positions, 0);
    compare(1, "orientations", current.orientations, 0);
    compare(2, "motions", current.motions, offsetof(Motion<real>, v) / sizeof(real));
    compare(3, "motions", current.motions, offsetof(Motion<real>, w) / sizeof(real));
  }

  // Here device and reference agree, so that it is the recording that is another.
  [[noreturn]] void fail(const std::string& where, const std::string& what) const {
    const std::string recorder = quote(recording_.label().device) + ", version " + quote(recording_.version());
    const std::string why =
        start_.oracle ? "; the steps are those of " + start_.oracle.name +
                            ", and an oracle promises its bits to one build on one machine: this was recorded by "
                      : "; device and reference agree here, so look at what recorded it: ";
    throw Error(Failure::comparison, where, what + why + recorder);
  }

  const RecordingReader& recording_;
  const StepTarget& target_;
  const Parting<real>& parting_;
  const InitialState<real> start_;
};

}  // namespace

template <class real>
Replayed replay(const RecordingReader& recording, const StepTarget& target, const std::function<void(u32)>& done,
                const Parting<real>& parting) {
  return Replay<real>(recording, target, parting).run(done);
}

template Replayed replay(const RecordingReader&, const StepTarget&, const std::function<void(u32)>&,
                         const Parting<float>&);
template Replayed replay(const RecordingReader&, const StepTarget&, const std::function<void(u32)>&,
                         const Parting<double>&);

}  // namespace lockstep
