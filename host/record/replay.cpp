#include "host/record/replay.hpp"

#include <algorithm>
#include <map>
#include <utility>

#include "host/backends/words.hpp"
#include "host/record/current_state.hpp"
#include "host/record/inputs.hpp"
#include "host/record/measure_row.hpp"
#include "host/record/recording_tables.hpp"
#include "host/scene/json_node.hpp"
#include "host/simulation.hpp"
#include "host/steppers/measure_backend.hpp"
#include "host/world_hash.hpp"

namespace lockstep {

namespace {

// Does again what was done from outside, row by row, and keeps the states that are gone back to until the last time.
template <class real>
class InputReplay {
 public:
  InputReplay(const RecordingReader& recording, Simulation<real> simulation, Buffers<real> driven)
      : inputs_(recording.inputs()), simulation_(std::move(simulation)), driven_(std::move(driven)) {
    for (u32 i = 0; i < inputs_.size(); ++i)
      if (inputs_[i].kind == InputKind::restore) last_restore_[restored_position(inputs_[i])] = i;
  }

  Simulation<real>& simulation() { return simulation_; }

  /// What was done before the step of a row; all rows before it have been done.
  void act_before(u32 row) {
    for (;;) {
      keep({row, next_});
      if (next_ == inputs_.size() || inputs_[next_].row != row) return;
      if (inputs_[next_].kind == InputKind::restore) {
        restore();
        continue;
      }
      u32 end = next_ + 1;
      while (end < inputs_.size() && inputs_[end].row == row && inputs_[end].kind != InputKind::restore &&
             !last_restore_.contains({row, end}))
        ++end;
      act(std::span(inputs_).subspan(next_, end - next_), simulation_, driven_);
      next_ = end;
    }
  }

 private:
  struct Kept {
    SavedSimulation simulation;
    Buffers<real> driven;
  };

  void keep(const RecordingPosition& position) {
    if (last_restore_.contains(position)) kept_.try_emplace(position, Kept{simulation_.save(), driven_});
  }

  void restore() {
    const RecordingPosition to = restored_position(inputs_[next_]);
    Kept& kept = kept_.at(to);
    simulation_.restore(kept.simulation);
    driven_ = kept.driven;
    if (last_restore_.at(to) == next_) kept_.erase(to);
    ++next_;
  }

  const std::vector<InputRow>& inputs_;
  Simulation<real> simulation_;
  Buffers<real> driven_;
  u32 next_ = 0;                                   // of the inputs
  std::map<RecordingPosition, u32> last_restore_;  // the input that is the last one to go back there
  std::map<RecordingPosition, Kept> kept_;
};

template <class real>
class Replay {
 public:
  Replay(const RecordingReader& recording, const StepTarget& target, const Parting<real>& parting)
      : recording_(recording), target_(target), parting_(parting), start_(recording.start<real>()) {}

  Replayed run(const std::function<void(u32)>& done) const {
    Inputs inputs(recording_, simulate(start_), driven_by_inputs(start_.buffers));
    Simulation<real>& simulation = inputs.simulation();
    for (u32 row = 0; row < recording_.steps(); ++row) {
      inputs.act_before(row);
      simulation.step();
      const std::vector<WorldHash> hashes = simulation.world_hashes();
      for (u32 world = 0; world < hashes.size(); ++world)
        if (state_hash(hashes[world]) != recorded_state_hash(row, world)) explain(row, world, hashes[world]);
      // what is stored beside the hash has to be of the same step
      std::optional<std::string> difference = body_difference(simulation, row);
      for (u32 world = 0; !difference && world < hashes.size(); ++world)
        if (pose_hash(hashes[world]) != recorded_pose_hash(row, world))
          difference = "the pose hash of world " + std::to_string(world) + " was recorded as " +
                       hash_text(recorded_pose_hash(row, world)) + " and is " + hash_text(pose_hash(hashes[world])) +
                       " here";
      if (!difference) difference = count_difference(simulation, row);
      if (!difference) difference = measure_difference(simulation, row);
      if (!difference && recording_.has_forces())
        difference = lockstep::difference(recording_.forces(row), recorded_forces(simulation));
      if (difference) refuse_stored(row, *difference);
      done(row + 1);
    }
    return {simulation.backend().name(), simulation.backend().unsolved()};
  }

 private:
  using Inputs = InputReplay<real>;

  Simulation<real> simulate(const InitialState<real>& state) const {
    return Simulation<real>(make_stepper(state, target_).backend, state.params, state.buffers.step_index.front());
  }

  // The state from which the step of a row starts, with what was done before it.
  InitialState<real> state_before(u32 row) const {
    Inputs inputs(recording_, simulate(start_), driven_by_inputs(start_.buffers));
    for (u32 i = 0; i < row; ++i) {
      inputs.act_before(i);
      inputs.simulation().step();
    }
    inputs.act_before(row);
    return current_state(start_, inputs.simulation());
  }

  [[noreturn]] void explain(u32 row, u32 world, const WorldHash& here) const {
    const u32 step = recording_.rows()[row].step - 1;  // as every message counts, from 0
    const InitialState<real> before = state_before(row);
    check(before);
    const std::string where = "step " + std::to_string(step);
    Simulation<real> simulation = simulate(before);
    simulation.step();
    if (const std::optional<std::string> difference = body_difference(simulation, row)) fail(where, *difference);
    fail(where, "the state hash of world " + std::to_string(world) + " was recorded as " +
                    hash_text(recorded_state_hash(row, world)) + " and is " + hash_text(state_hash(here)) +
                    " here; poses and velocities are equal");
  }

  std::uint64_t recorded_state_hash(u32 row, u32 world) const {
    return recording_.state_hashes()[std::size_t{row} * start_.sizes.worlds + world];
  }
  std::uint64_t recorded_pose_hash(u32 row, u32 world) const {
    return recording_.pose_hashes()[std::size_t{row} * start_.sizes.worlds + world];
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

  // The first word of the tables of bodies that is not what the simulation has after the step of a row.
  std::optional<std::string> body_difference(Simulation<real>& simulation, u32 row) const {
    const Buffer wanted[] = {Buffer::positions, Buffer::orientations, Buffer::motions};
    const Buffers<real>& current = simulation.backend().download(wanted);
    std::optional<std::string> found;
    const auto compare = [&](u32 table, const char* buffer, const auto& records, std::size_t first) {
      const std::size_t columns = body_tables[table].columns;
      const std::vector<real> recorded = found ? std::vector<real>{} : recording_.bodies<real>(table, row);
      for (std::size_t i = 0; !found && i < std::min(recorded.size() / columns, records.size()); ++i) {
        for (std::size_t k = 0; !found && k < columns; ++k) {
          const real is = reinterpret_cast<const real*>(&records[i])[first + k], was = recorded[i * columns + k];
          if (!same_bits(was, is))
            found = std::string(buffer) + "[" + std::to_string(i) + "] word " + std::to_string(first + k) +
                    ": recorded " + show_word(was) + ", here " + show_word(is);
        }
      }
    };
    compare(0, "positions", current.positions, 0);
    compare(1, "orientations", current.orientations, 0);
    compare(2, "motions", current.motions, offsetof(Motion<real>, v) / sizeof(real));
    compare(3, "motions", current.motions, offsetof(Motion<real>, w) / sizeof(real));
    return found;
  }

  // Of the table `steps`: how often a step was redone and how long it took is nothing that is simulated.
  std::optional<std::string> count_difference(Simulation<real>& simulation, u32 row) const {
    const StepRow& was = recording_.rows()[row];
    const Counters& counters = simulation.counters();
    const std::pair<const char*, std::pair<u32, u32>> counts[] = {
        {"pairs", {was.pairs, counters[COUNTER_PAIRS]}}, {"contacts", {was.contacts, counters[COUNTER_CONTACTS]}}};
    for (const auto& [name, of] : counts)
      if (of.first != of.second)
        return std::string(name) + ": recorded " + std::to_string(of.first) + ", here " + std::to_string(of.second);
    return {};
  }

  // Of the table `measures`, which has some of the steps.
  std::optional<std::string> measure_difference(Simulation<real>& simulation, u32 row) const {
    const u32 step = recording_.rows()[row].step;
    const std::vector<MeasureRow>& rows = recording_.measures();
    const auto was = std::ranges::lower_bound(rows, double(step), {}, &MeasureRow::step);
    if (was == rows.end() || was->step != step) return {};
    const MeasureRow here =
        measure_row(step, measure(simulation.backend(), simulation.params(), simulation.counters()));
    for (const MeasureColumn& column : measure_columns)
      if (!same_bits((*was).*column.member, here.*column.member))
        return std::string("measures, ") + column.name + ": recorded " + show_word((*was).*column.member) + ", here " +
               show_word(here.*column.member);
    return {};
  }

  // The state hash is that of the replay, and what is stored beside it is of no such state.
  [[noreturn]] void refuse_stored(u32 row, const std::string& what) const {
    throw Error(Failure::comparison, "step " + std::to_string(recording_.rows()[row].step - 1),
                what + "; the state hash is equal, so the file was changed since it was recorded");
  }

  // Here device and reference agree, so that it is the recording that is another.
  [[noreturn]] void fail(const std::string& where, const std::string& what) const {
    if (recording_.version() != LOCKSTEP_VERSION)
      throw Error(Failure::comparison, where,
                  what + "; recorded by version " + recording_.version() +
                      ", replayed by version " LOCKSTEP_VERSION
                      ", and bits are promised within one version: record it again");
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
