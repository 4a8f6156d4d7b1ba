// Writes a recording while a simulation runs. Every batch of steps is on its way to the disk before the next is full,
// so that a crash at any moment leaves a file with a prefix of the run; others can read it meanwhile.
#pragma once

#include <memory>
#include <span>
#include <string_view>
#include <vector>

#include "host/record/recorded_forces.hpp"
#include "host/record/recording.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

inline constexpr std::string_view recording_signature = "\x89HDF\r\n\x1a\n";

template <class real>
class RecordingWriter {
 public:
  /// `start` is what the simulation starts from. Replaces the file. Throws Error (device) where it cannot be written.
  RecordingWriter(const std::string& path, const RecordingLabel& label, const InitialState<real>& start,
                  const Recorded& recorded = {});
  /// Closes the recording; what went wrong then is lost.
  ~RecordingWriter();

  /// The buffers that add() wants, as they are after a step and after the stage hash_state.
  static std::span<const Buffer> wanted();

  bool has_forces() const { return has_forces_; }
  /// Of the step that is added next, where the recording has forces.
  void add(const RecordedForces& forces);
  /// One more step. The writing is done by another thread; throws Error (device) where it failed.
  void add(const StepRow& row, const Buffers<real>& buffers);
  void add(const MeasureRow& row);
  /// Before the step that it names; of a recording that has inputs. Its `row` is set here.
  void add(const InputRow& row);
  /// How many steps and inputs there are so far.
  RecordingPosition position() const;

  /// Writes what is left and how the run ended. Throws Error (device) where that fails.
  void close(const std::string& outcome);

 private:
  class Thread;
  std::unique_ptr<Thread> thread_;
  bool has_forces_;
};

}  // namespace lockstep
