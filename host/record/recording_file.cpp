#include "host/record/recording_file.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstddef>
#include <cstdio>
#include <cstring>
#include <limits>

#include "host/error.hpp"
#include "host/record/identity.hpp"
#include "host/record/recording_tables.hpp"
#include "host/record/state_group.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep {

namespace {

// Bodies times steps of a batch: a few hundred kilobytes of each table.
constexpr std::size_t batch_bodies = 1u << 16, longest_batch = 64;
constexpr hsize_t input_chunk = 256, contact_chunk = 4096;
// What is written at the end takes the place of this in the file.
constexpr const char* running = "running";
constexpr std::size_t outcome_length = 512;

// A byte that no recording has: HDF5 locks files for itself.
struct flock writer_lock() {
  struct flock lock = {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  lock.l_start = std::numeric_limits<off_t>::max() - 1;
  lock.l_len = 1;
  return lock;
}

void expect_unlocked(const std::string& path) {
  const int descriptor = ::open(path.c_str(), O_RDWR | O_CLOEXEC | O_NONBLOCK);
  if (descriptor < 0) return;
  struct flock lock = writer_lock();
  const bool locked = ::fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
  ::close(descriptor);
  if (locked) throw Error(Failure::input, path, "is a recording that is being written; name another file");
}

h5::Handle create(const std::string& path) {
  h5::be_quiet();
  const h5::Handle access(H5Pcreate(H5P_FILE_ACCESS));
  // what others can read while it is written needs the format of version 1.10
  h5::check(H5Pset_libver_bounds(access, H5F_LIBVER_V110, H5F_LIBVER_V110));
  h5::check(H5Pset_fclose_degree(access, H5F_CLOSE_STRONG));
  return h5::Handle(H5Fcreate(path.c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access));
}

void write_outcome(hid_t attribute, std::string outcome) {
  outcome.resize(outcome_length);
  h5::check(H5Awrite(attribute, h5::text_type(outcome_length), outcome.data()));
}

template <class real>
void write_head(hid_t file, const RecordingLabel& label, const InitialState<real>& start) {
  h5::write_attribute(file, "format", recording_format);
  h5::write_attribute(file, "version", std::string(LOCKSTEP_VERSION));
  h5::write_attribute(file, "precision", std::string(sizeof(real) == 8 ? "double" : "float"));
  h5::write_attribute(file, "scene", label.scene);
  h5::write_attribute(file, "device", label.device);
  h5::write_attribute(file, "options", label.options);
  h5::write_attribute(file, "source", label.source);
  h5::write_attribute(file, "dt", label.dt);
  h5::write_text(file, "scene_text", label.scene_text);
  const h5::Handle outcome(H5Acreate2(file, "outcome", h5::text_type(outcome_length), h5::Handle(H5Screate(H5S_SCALAR)),
                                      H5P_DEFAULT, H5P_DEFAULT));
  write_outcome(outcome, running);

  const h5::Handle scene(H5Gcreate2(file, "compiled_scene", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  write_constants(scene, start);
  const SceneIdentity identity = identity_of(start);
  h5::write_attribute(scene, "settings_hash", identity.settings);
  h5::write_attribute(scene, "constants_hash", identity.constants);
  const h5::Handle state(H5Gcreate2(file, "initial_state", H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  write_persistent(state, start.buffers, start.features);
  h5::write_attribute(state, "hash", persistent_hash(start.buffers));
}

}  // namespace

UnfinishedFile::UnfinishedFile(const std::string& name) : name_(name) {
  expect_unlocked(name);
  descriptor_ = make_beside(name, path_);
  if (descriptor_ < 0) throw h5::Failed(std::strerror(errno));
  struct flock lock = writer_lock();
  ::fcntl(descriptor_, F_OFD_SETLK, &lock);  // a file system without locks has none
}

UnfinishedFile::~UnfinishedFile() {
  if (descriptor_ >= 0) ::close(descriptor_);
  if (!has_name_ && !path_.empty()) std::remove(path_.c_str());
}

void UnfinishedFile::publish() {
  expect_unlocked(name_);
  if (std::rename(path_.c_str(), name_.c_str()) != 0) throw h5::Failed(std::strerror(errno));
  has_name_ = true;
}

void UnfinishedFile::expect_named() const {
  struct stat mine, named;
  if (::fstat(descriptor_, &mine) != 0 || ::stat(name_.c_str(), &named) != 0 || mine.st_ino != named.st_ino ||
      mine.st_dev != named.st_dev)
    throw h5::Failed("another file has taken its name, or it was removed while it was written");
}

template <class real>
void Batch<real>::clear() {
  steps.clear();
  state_hashes.clear();
  pose_hashes.clear();
  positions.clear();
  orientations.clear();
  motions.clear();
  measures.clear();
  inputs.clear();
  contact_ends.clear();
  contact_forces.clear();
  joint_forces.clear();
}

template <class real>
RecordingFile<real>::RecordingFile(const std::string& path, const RecordingLabel& label,
                                   const InitialState<real>& start, const Recorded& recorded)
    : unfinished_(path),
      file_(create(unfinished_.path())),
      bodies_(start.sizes.bodies),
      batch_steps_(std::clamp<std::size_t>(batch_bodies / bodies_, 1, longest_batch)),
      has_contact_forces_(recorded.forces && has(start.features, Feature::contacts)),
      has_joint_forces_(recorded.forces && has(start.features, Feature::joints)) {
  write_head(file_, label, start);
  const hsize_t worlds = start.sizes.worlds, bodies = bodies_;
  steps_ = GrowingRows(file_, "steps", step_row_type(), {}, batch_steps_);
  state_hashes_ = GrowingRows(file_, "state_hashes", H5T_STD_U64LE, {worlds}, batch_steps_);
  pose_hashes_ = GrowingRows(file_, "pose_hashes", H5T_STD_U64LE, {worlds}, batch_steps_);
  measures_ = GrowingRows(file_, "measures", measure_row_type(), {}, 1);
  if (recorded.inputs) inputs_ = GrowingRows(file_, "inputs", input_row_type(), {}, input_chunk);
  for (std::size_t i = 0; i < std::size(body_tables); ++i)
    tables_[i] =
        GrowingRows(file_, body_tables[i].name, h5::file_type<real>(), {bodies, body_tables[i].columns}, batch_steps_);
  if (has_contact_forces_) {
    contact_ends_ = GrowingRows(file_, "contact_ends", H5T_STD_U64LE, {}, batch_steps_);
    contact_forces_ = GrowingRows(file_, "contact_forces", contact_force_row_type(), {}, contact_chunk);
  }
  if (has_joint_forces_) {
    const hsize_t joints = start.sizes.joints;
    joint_forces_ = GrowingRows(file_, "joint_forces", H5T_IEEE_F64LE, {joints, joint_force_columns}, batch_steps_);
  }
  h5::check(H5Fstart_swmr_write(file_));
  unfinished_.publish();
}

// The steps come last: what they count is there.
template <class real>
void RecordingFile<real>::write(const Batch<real>& batch) {
  write_bodies(batch);
  if (!batch.inputs.empty()) inputs_.append_any(batch.inputs.data(), batch.inputs.size());
  if (!batch.steps.empty()) {
    write_forces(batch);
    state_hashes_.append(batch.state_hashes.data(), batch.steps.size(), packer_);
    pose_hashes_.append(batch.pose_hashes.data(), batch.steps.size(), packer_);
    steps_.append(batch.steps.data(), batch.steps.size(), packer_);
  }
  for (const MeasureRow& row : batch.measures) measures_.append(&row, 1, packer_);
}

template <class real>
void RecordingFile<real>::write_bodies(const Batch<real>& batch) {
  if (batch.steps.empty()) return;
  // the first `count` numbers of every record, from `first` on
  const auto write = [&](GrowingRows& table, const auto& records, std::size_t first, std::size_t count) {
    columns_.resize(records.size() * count);
    for (std::size_t i = 0; i < records.size(); ++i) {
      const real* record = reinterpret_cast<const real*>(&records[i]) + first;
      for (std::size_t k = 0; k < count; ++k) columns_[i * count + k] = record[k];
    }
    table.append(columns_.data(), batch.steps.size(), packer_);
  };
  constexpr std::size_t v = offsetof(Motion<real>, v) / sizeof(real), w = offsetof(Motion<real>, w) / sizeof(real);
  write(tables_[0], batch.positions, 0, 3);
  write(tables_[1], batch.orientations, 0, 4);
  write(tables_[2], batch.motions, v, 3);
  write(tables_[3], batch.motions, w, 3);
}

template <class real>
void RecordingFile<real>::write_forces(const Batch<real>& batch) {
  if (has_contact_forces_) {
    if (!batch.contact_forces.empty())
      contact_forces_.append_any(batch.contact_forces.data(), batch.contact_forces.size());
    contact_ends_.append(batch.contact_ends.data(), batch.steps.size(), packer_);
  }
  if (has_joint_forces_) joint_forces_.append(batch.joint_forces.data(), batch.steps.size(), packer_);
}

template <class real>
void RecordingFile<real>::close(const std::string& outcome) {
  {
    const h5::Handle attribute(H5Aopen(file_, "outcome", H5P_DEFAULT));
    write_outcome(attribute, outcome);
  }
  h5::check(H5Fflush(file_, H5F_SCOPE_GLOBAL));
  h5::check(H5Fclose(file_.release()));
  unfinished_.expect_named();
}

template <class real>
void RecordingFile<real>::abandon() {
  for (GrowingRows* rows :
       {&steps_, &state_hashes_, &pose_hashes_, &measures_, &inputs_, &contact_ends_, &contact_forces_, &joint_forces_})
    rows->abandon();
  for (GrowingRows& table : tables_) table.abandon();
  file_.release();
}

template struct Batch<float>;
template struct Batch<double>;
template class RecordingFile<float>;
template class RecordingFile<double>;

}  // namespace lockstep
