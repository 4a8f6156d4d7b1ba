// Reads recordings: those that are whole, those that a crash cut short, and those that are still being written.
#pragma once

#include <span>
#include <vector>

#include "host/record/hdf5.hpp"
#include "host/record/recorded_forces.hpp"
#include "host/record/recording.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

/// Throws Error (input), one line that names the file, wherever it is no whole recording.
class RecordingReader {
 public:
  explicit RecordingReader(const std::string& path);
  /// The same of a file that lies in memory.
  RecordingReader(std::span<const unsigned char> bytes, const std::string& path);

  const RecordingLabel& label() const { return label_; }
  const std::string& version() const { return version_; }      // of the program that made it
  const std::string& precision() const { return precision_; }  // "float" or "double"
  const OracleChoice& oracle() const { return oracle_; }       // that made the steps; none: a device or the reference
  /// "finished", "unsolved: ..." where an oracle left something so, "interrupted", an error; "running" where the run is
  /// not over, or was killed.
  const std::string& outcome() const { return outcome_; }

  /// Of a step, s: what the scene said, or in an older recording what the precision of the run made of it.
  template <class real>
  double dt(const StepParams<real>& params) const {
    return label_.dt > 0 ? label_.dt : double(params.dt) * params.substeps;
  }

  /// Steps that are there whole.
  u32 steps() const { return static_cast<u32>(rows_.size()); }
  const std::vector<StepRow>& rows() const { return rows_; }

  /// The hashes of the state after each step, steps x worlds, and of the poses.
  const std::vector<std::uint64_t>& state_hashes() const { return state_hashes_; }
  const std::vector<std::uint64_t>& pose_hashes() const { return pose_hashes_; }

  /// What was done to bodies, joints and the state from outside before each of the steps, in order; nothing in a run
  /// that went by itself.
  const std::vector<InputRow>& inputs() const { return inputs_; }

  /// Of the steps that the report measured, in order.
  const std::vector<MeasureRow>& measures() const { return measures_; }

  /// Whether forces were recorded, and those of a row: what the step had of contacts and joints.
  bool has_forces() const { return !contact_ends_.empty() || h5::has(file_, "joint_forces"); }
  RecordedForces forces(u32 row) const;

  /// What the run began with. `real` must be the precision.
  template <class real>
  InitialState<real> start() const;

  /// A row of the table body_tables[table]: bodies x columns.
  template <class real>
  std::vector<real> bodies(u32 table, u32 row) const;

 private:
  void read_head();
  void read_steps();
  u32 step_after_restores(u32 row, std::size_t& input) const;
  void read_inputs();
  bool restores(std::size_t input) const;
  void read_measures();
  void read_contact_ends();
  std::vector<std::uint64_t> read_hashes(const char* name) const;

  std::string path_;
  h5::Handle file_;
  RecordingLabel label_;
  OracleChoice oracle_;
  u32 format_ = 0;
  std::string version_, precision_, outcome_;
  std::vector<StepRow> rows_;
  std::vector<InputRow> inputs_;
  std::vector<MeasureRow> measures_;
  std::vector<std::uint64_t> state_hashes_, pose_hashes_, contact_ends_;
};

}  // namespace lockstep
