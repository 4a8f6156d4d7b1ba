// The file of a recording while it is written, by one thread.
#pragma once

#include "host/record/chunks.hpp"
#include "host/record/recording.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

/// Steps that are written together.
template <class real>
struct Batch {
  std::vector<StepRow> steps;
  std::vector<std::uint64_t> state_hashes, pose_hashes;  // of each step and world
  std::vector<Vec4<real>> positions, orientations;       // of each step and body
  std::vector<Motion<real>> motions;
  std::vector<MeasureRow> measures;
  std::vector<InputRow> inputs;
  std::vector<std::uint64_t> contact_ends;  // of each step
  std::vector<ContactForceRow> contact_forces;
  std::vector<JointForceRow> joint_forces;  // of each step and joint

  void clear();
};

/// A file that gets its name when its head is whole, so that whoever finds one can read it. Until it is closed it is
/// locked: two that write one recording would lose steps.
class UnfinishedFile {
 public:
  /// To be named `name`. Throws Error (input) where another recording is being written under that name, h5::Failed
  /// where none can be made.
  explicit UnfinishedFile(const std::string& name);
  ~UnfinishedFile();
  UnfinishedFile(const UnfinishedFile&) = delete;
  UnfinishedFile& operator=(const UnfinishedFile&) = delete;

  const std::string& path() const { return path_; }  // until it has its name
  void publish();
  /// Throws h5::Failed where its name has become that of another file, or of none.
  void expect_named() const;

 private:
  const std::string name_;
  std::string path_;
  int descriptor_ = -1;
  bool has_name_ = false;
};

template <class real>
class RecordingFile {
 public:
  RecordingFile(const std::string& path, const RecordingLabel& label, const InitialState<real>& start,
                const Recorded& recorded);

  /// Steps of a full batch; only the last one may have fewer.
  std::size_t batch_steps() const { return batch_steps_; }

  void write(const Batch<real>& batch);
  void close(const std::string& outcome);

  /// After a failure: leaves the file as a crash would, which readers can live with. Closing it would write a part of
  /// what did not fit.
  void abandon();

 private:
  void write_bodies(const Batch<real>& batch);
  void write_forces(const Batch<real>& batch);

  UnfinishedFile unfinished_;
  h5::Handle file_;
  std::size_t bodies_, batch_steps_;
  bool has_contact_forces_, has_joint_forces_;
  GrowingRows steps_, state_hashes_, pose_hashes_, measures_, inputs_, contact_ends_, contact_forces_, joint_forces_;
  GrowingRows tables_[4];  // body_tables
  ChunkPacker packer_;
  std::vector<real> columns_;
};

}  // namespace lockstep
