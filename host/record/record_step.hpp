// A step of a simulation into a recording.
#pragma once

#include "host/record/recording_writer.hpp"
#include "host/simulation.hpp"

namespace lockstep {

/// The step that the simulation has just done; hashes its state.
template <class real>
void record_step(RecordingWriter<real>& recording, Simulation<real>& simulation, double milliseconds) {
  Backend<real>& backend = simulation.backend();
  backend.run(Stage::hash_state, simulation.params());
  const Counters& counters = simulation.counters();
  recording.add(StepRow{simulation.steps_done(), counters[COUNTER_PAIRS], counters[COUNTER_CONTACTS],
                        simulation.redone(), milliseconds},
                backend.download(RecordingWriter<real>::wanted()));
}

}  // namespace lockstep
