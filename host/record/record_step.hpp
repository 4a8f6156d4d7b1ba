// A simulation into a recording: a step, and how it ended.
#pragma once

#include "host/record/recording_writer.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracles.hpp"
#include "host/verdict.hpp"

namespace lockstep {

/// The step that the simulation has just done; hashes its state.
template <class real>
void record_step(RecordingWriter<real>& recording, Simulation<real>& simulation, double milliseconds) {
  Backend<real>& backend = simulation.backend();
  backend.run(Stage::hash_state, simulation.params());
  const Counters& counters = simulation.counters();
  if (recording.has_forces()) recording.add(recorded_forces(simulation));
  recording.add(StepRow{simulation.steps_done(), counters[COUNTER_PAIRS], counters[COUNTER_CONTACTS],
                        simulation.redone(), milliseconds},
                backend.download(RecordingWriter<real>::wanted()));
}

/// What a recording of this simulation says of its outcome, once all steps are done.
template <class real>
std::string finished(Simulation<real>& simulation, const OracleChoice& oracle, const Verdict& verdict) {
  const Unsolved unsolved = simulation.unsolved();
  if (unsolved.count > 0) return "unsolved: " + in_words(oracle ? oracle.name : "the solver", unsolved);
  return verdict.good() ? "finished" : "bad: " + in_words(verdict);
}

}  // namespace lockstep
