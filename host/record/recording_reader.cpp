#include "host/record/recording_reader.hpp"

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "host/error.hpp"
#include "host/record/consistency.hpp"
#include "host/record/identity.hpp"
#include "host/record/inputs.hpp"
#include "host/record/recording_tables.hpp"
#include "host/record/state_group.hpp"

namespace lockstep {

namespace {

// More rows than a file has bytes are not there, whatever it says.
constexpr hsize_t most_words = 1u << 30;

// How often HDF5 reads what does not fit its checksum, in case it is just being written; it waits twice as long each
// time, from 1 ns on: here some milliseconds, with its own 100 attempts for ever.
constexpr unsigned read_attempts = 22;

h5::Handle open_file(const std::string& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (status.type() == std::filesystem::file_type::not_found) throw Error(Failure::input, path, "no such file");
  if (status.type() == std::filesystem::file_type::directory)
    throw Error(Failure::input, path, "is a directory, must be a recording");
  h5::be_quiet();
  const h5::Handle access(H5Pcreate(H5P_FILE_ACCESS));
  h5::check(H5Pset_metadata_read_attempts(access, read_attempts));
  // as one who reads while another writes, which also opens what a writer never closed
  return h5::Handle(H5Fopen(path.c_str(), H5F_ACC_RDONLY | H5F_ACC_SWMR_READ, access));
}

// What HDF5 or the layout of the file does not like, as one line that names the file.
template <class Work>
auto reading(const std::string& path, Work&& work) {
  try {
    return work();
  } catch (const h5::Failed& failed) {
    throw Error(Failure::input, path, std::string("is no recording that this program reads: ") + failed.what());
  }
}

// Reads the rows [first, first + count) of a table.
void read_rows(hid_t dataset, hid_t type, hsize_t first, hsize_t count, void* out) {
  std::vector<hsize_t> extent = h5::extent_of(dataset), start(extent.size(), 0);
  start[0] = first;
  extent[0] = count;
  const h5::Handle file_space(H5Dget_space(dataset)), memory_space = h5::space(extent);
  h5::check(H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start.data(), nullptr, extent.data(), nullptr));
  h5::check(H5Dread(dataset, type, memory_space, file_space, H5P_DEFAULT, out));
}

// A table of `extent`, at least as many rows as extent[0] says.
h5::Handle open_table(hid_t file, const char* name, hid_t type, const std::vector<hsize_t>& extent) {
  h5::Handle dataset = h5::open_dataset(file, name);
  const h5::Handle stored(H5Dget_type(dataset));
  if (h5::check(H5Tequal(stored, type)) == 0) throw h5::Failed(std::string(name) + " is of another type");
  const std::vector<hsize_t> there = h5::extent_of(dataset);
  if (there.size() != extent.size() || !std::equal(there.begin() + 1, there.end(), extent.begin() + 1) ||
      there[0] < extent[0])
    throw h5::Failed(std::string(name) + " has another shape than the scene and the steps give it");
  return dataset;
}

// All rows of a table.
template <class Row>
std::vector<Row> read_table(hid_t file, const char* name, const h5::Handle& type) {
  const h5::Handle dataset = open_table(file, name, type, {0});
  std::vector<Row> rows;
  const hsize_t count = h5::extent_of(dataset)[0];
  if (count > most_words) throw h5::Failed(std::string(name) + " has more rows than there can be");
  if (H5Dget_storage_size(dataset) * 1000 < count) throw h5::Failed(std::string(name) + " is not all there");
  rows.resize(count);
  if (count > 0) read_rows(dataset, type, 0, count, rows.data());
  return rows;
}

// Whether this can be done to the bodies or the joints of the scene.
template <class real>
bool fits(const InputRow& row, const InitialState<real>& state) {
  if (row.kind == InputKind::restore || row.kind == InputKind::cold_start) return true;
  if (row.kind == InputKind::gravity) return row.body < state.sizes.worlds;
  if (row.kind == InputKind::motor) return row.body < state.sizes.joints && row.linear[1] >= 0;
  if (row.kind == InputKind::rest) return row.body < state.sizes.joints && has_spring(state.buffers.joints[row.body]);
  return row.body < state.sizes.bodies && (row.kind != InputKind::load || has(state.features, Feature::loads));
}

}  // namespace

RecordingReader::RecordingReader(const std::string& path)
    : path_(path), file_(reading(path, [&] { return open_file(path); })) {
  reading(path_, [&] { read_head(), read_steps(), read_inputs(), read_measures(), read_contact_ends(); });
}

RecordingReader::RecordingReader(std::span<const unsigned char> bytes, const std::string& path)
    : path_(path), file_(reading(path, [&] { return h5::open_image(bytes); })) {
  reading(path_, [&] { read_head(), read_steps(), read_inputs(), read_measures(), read_contact_ends(); });
}

void RecordingReader::read_head() {
  format_ = h5::read_attribute<u32>(file_, "format");
  version_ = h5::read_text_attribute(file_, "version");
  if (format_ < oldest_recording_format || format_ > recording_format)
    throw h5::Failed("it has format " + std::to_string(format_) + ", of version " + version_ + ", wanted is " +
                     std::to_string(recording_format) + ", of version " LOCKSTEP_VERSION "; record it again");
  precision_ = read_precision(file_);
  label_.scene = h5::read_text_attribute(file_, "scene");
  label_.device = h5::read_text_attribute(file_, "device");
  label_.options = h5::read_text_attribute(file_, "options");
  label_.source = h5::read_text_attribute(file_, "source");
  if (h5::has_attribute(file_, "dt")) label_.dt = h5::read_attribute<double>(file_, "dt");
  if (!(label_.dt >= 0 && std::isfinite(label_.dt))) throw h5::Failed("its dt makes no sense");
  label_.scene_text = h5::read_text(file_, "scene_text");
  outcome_ = h5::read_text_attribute(file_, "outcome");
  oracle_ = read_oracle(h5::open_group(file_, "compiled_scene"));
}

void RecordingReader::read_steps() {
  rows_ = read_table<StepRow>(file_, "steps", step_row_type());
  if (h5::has(file_, "inputs")) inputs_ = read_table<InputRow>(file_, "inputs", input_row_type(format_));
  // rows that are announced and not there yet are zeros
  std::size_t input = 0;
  const auto follows = [&](u32 row) {
    const u32 restored = step_after_restores(row, input);
    if (restored != NONE) return rows_[row].step == restored;
    return row == 0 ? rows_[0].step > 0 : rows_[row].step == rows_[row - 1].step + 1;
  };
  for (u32 row = 0; row < rows_.size(); ++row) {
    if (follows(row)) continue;
    if (rows_[row].step != 0 && outcome_ != "running")
      throw h5::Failed("steps[" + std::to_string(row) + "] does not follow the one before it");
    rows_.resize(row);
    break;
  }
  state_hashes_ = read_hashes("state_hashes");
  pose_hashes_ = read_hashes("pose_hashes");
}

// What the step of a row is after the last restore before it; NONE where there is none. `input` is the first input of
// the row, and then that of the next one.
u32 RecordingReader::step_after_restores(u32 row, std::size_t& input) const {
  if (format_ < restores_format) return NONE;
  u32 step = NONE;
  for (; input < inputs_.size() && inputs_[input].row == row; ++input) {
    const InputRow& restore = inputs_[input];
    if (restore.kind != InputKind::restore) continue;
    if (restore.body > row) throw h5::Failed("inputs[" + std::to_string(input) + "] makes no sense");
    step = restore.body == 0 ? rows_[0].step : rows_[restore.body - 1].step + 1;
  }
  return step;
}

// Of the steps that are there; what was done before the next one may be there already.
void RecordingReader::read_inputs() {
  if (format_ < restores_format) {
    for (InputRow& row : inputs_) {
      const auto felt = std::ranges::lower_bound(rows_, row.step, {}, &StepRow::step);
      row.row = row.step == 0 ? NONE : static_cast<u32>(felt - rows_.begin());
    }
  }
  const auto is_later = [this](const InputRow& row) { return row.step == 0 || row.row >= rows_.size(); };
  inputs_.erase(std::ranges::find_if(inputs_, is_later), inputs_.end());
  bool superseded = false;  // by a restore before the same step
  for (std::size_t i = inputs_.size(); i-- > 0;) {
    const InputRow& row = inputs_[i];
    superseded = superseded && inputs_[i + 1].row == row.row;
    const auto is_bad = [](double x) { return !std::isfinite(x); };
    if ((i > 0 && row.row < inputs_[i - 1].row) || (!superseded && row.step != rows_[row.row].step) ||
        row.kind > InputKind::cold_start || std::any_of(row.linear, row.linear + 3, is_bad) ||
        std::any_of(row.angular, row.angular + 3, is_bad) || (row.kind == InputKind::restore && !restores(i)))
      throw h5::Failed("inputs[" + std::to_string(i) + "] makes no sense");
    superseded = superseded || row.kind == InputKind::restore;
  }
}

// Whether a restore goes back to a moment before it.
bool RecordingReader::restores(std::size_t input) const {
  const InputRow& restore = inputs_[input];
  if (!(restore.linear[0] >= 0 && restore.linear[0] <= double(input))) return false;
  const RecordingPosition to = restored_position(restore);
  return format_ >= restores_format && double(to.inputs) == restore.linear[0] && to.rows <= restore.row &&
         (to.inputs == 0 || inputs_[to.inputs - 1].row <= to.rows) && inputs_[to.inputs].row >= to.rows;
}

// Those of steps that are not there yet may be there already.
void RecordingReader::read_measures() {
  if (!h5::has(file_, "measures")) return;
  measures_ = read_table<MeasureRow>(file_, "measures", measure_row_type());
  const double first = rows_.empty() ? 1 : rows_.front().step, last = rows_.empty() ? 0 : rows_.back().step;
  for (std::size_t i = 0; i < measures_.size(); ++i) {
    const double step = measures_[i].step;
    const bool is_after = step >= first && (i == 0 || step > measures_[i - 1].step);
    if (!is_after || step != std::floor(step) || (step > last && outcome_ != "running"))
      throw h5::Failed("measures[" + std::to_string(i) + "] is of no step");
  }
}

// Of the rows of contact_forces, which are there before their ends are.
void RecordingReader::read_contact_ends() {
  if (!h5::has(file_, "contact_ends")) return;
  contact_ends_ = read_table<std::uint64_t>(file_, "contact_ends", h5::Handle(H5Tcopy(H5T_STD_U64LE)));
  if (contact_ends_.size() < steps()) throw h5::Failed("contact_ends is not all there");
  contact_ends_.resize(steps());
  const std::vector<hsize_t> extent = h5::extent_of(h5::open_dataset(file_, "contact_forces"));
  if (!std::ranges::is_sorted(contact_ends_) || extent.size() != 1 ||
      (!contact_ends_.empty() && contact_ends_.back() > extent[0]))
    throw h5::Failed("contact_ends makes no sense");
}

RecordedForces RecordingReader::forces(u32 row) const {
  return reading(path_, [&] {
    RecordedForces forces;
    if (!contact_ends_.empty()) {
      const std::uint64_t first = row == 0 ? 0 : contact_ends_[row - 1], count = contact_ends_[row] - first;
      if (count > most_words / sizeof(ContactForceRow)) throw h5::Failed("contact_ends makes no sense");
      const h5::Handle type = contact_force_row_type();
      const h5::Handle dataset = open_table(file_, "contact_forces", type, {first + count});
      forces.contacts.resize(count);
      if (count > 0) read_rows(dataset, type, first, count, forces.contacts.data());
    }
    if (h5::has(file_, "joint_forces")) {
      const std::vector<hsize_t> extent = h5::extent_of(h5::open_dataset(file_, "joint_forces"));
      if (extent.size() != 3 || extent[1] > most_words) throw h5::Failed("joint_forces is no table of joints");
      const h5::Handle dataset =
          open_table(file_, "joint_forces", H5T_IEEE_F64LE, {row + hsize_t{1}, extent[1], joint_force_columns});
      forces.joints.resize(extent[1]);
      read_rows(dataset, H5T_NATIVE_DOUBLE, row, 1, forces.joints.data());
    }
    return forces;
  });
}

std::vector<std::uint64_t> RecordingReader::read_hashes(const char* name) const {
  const std::vector<hsize_t> extent = h5::extent_of(h5::open_dataset(file_, name));
  if (extent.size() != 2 || extent[1] == 0 || extent[1] > most_words || extent[1] * steps() > most_words)
    throw h5::Failed(std::string(name) + " has no shape of hashes");
  const h5::Handle dataset = open_table(file_, name, H5T_STD_U64LE, {steps(), extent[1]});
  if (H5Dget_storage_size(dataset) * 1000 < extent[1] * steps())
    throw h5::Failed(std::string(name) + " is not all there");
  std::vector<std::uint64_t> hashes(steps() * extent[1]);
  if (!hashes.empty()) read_rows(dataset, H5T_NATIVE_UINT64, 0, steps(), hashes.data());
  return hashes;
}

template <class real>
InitialState<real> RecordingReader::start() const {
  return reading(path_, [&] {
    const h5::Handle scene = h5::open_group(file_, "compiled_scene");
    InitialState<real> state = read_constants<real>(scene);
    const SceneIdentity written = {h5::read_attribute<std::uint64_t>(scene, "settings_hash"),
                                   h5::read_attribute<std::uint64_t>(scene, "constants_hash")};
    if (identity_of(state) != written) throw h5::Failed("the compiled scene is damaged, its hash does not fit");
    expect_consistent_constants(state);
    const h5::Handle persistent = h5::open_group(file_, "initial_state");
    read_persistent(persistent, state);
    if (persistent_hash(state.buffers) != h5::read_attribute<std::uint64_t>(persistent, "hash"))
      throw h5::Failed("the initial state is damaged, its hash does not fit");
    expect_consistent_lists(state);
    if (!rows_.empty() && rows_[0].step != state.buffers.step_index.front() + 1)
      throw h5::Failed("the first step does not follow the initial state");
    if (state_hashes_.size() != std::size_t{steps()} * state.sizes.worlds ||
        pose_hashes_.size() != state_hashes_.size())
      throw h5::Failed("the hashes are not those of so many worlds");
    for (const InputRow& row : inputs_) {
      if (!fits(row, state)) throw h5::Failed("inputs are of another scene");
    }
    return state;
  });
}

template <class real>
std::vector<real> RecordingReader::bodies(u32 table, u32 row) const {
  return reading(path_, [&] {
    const BodyTable& about = body_tables[table];
    const std::vector<hsize_t> extent = h5::extent_of(h5::open_dataset(file_, about.name));
    if (extent.size() != 3 || extent[1] > most_words)
      throw h5::Failed(std::string(about.name) + " is no table of bodies");
    const h5::Handle dataset =
        open_table(file_, about.name, h5::file_type<real>(), {row + hsize_t{1}, extent[1], about.columns});
    std::vector<real> values(extent[1] * about.columns);
    read_rows(dataset, h5::memory_type<real>(), row, 1, values.data());
    return values;
  });
}

template InitialState<float> RecordingReader::start<float>() const;
template InitialState<double> RecordingReader::start<double>() const;
template std::vector<float> RecordingReader::bodies<float>(u32, u32) const;
template std::vector<double> RecordingReader::bodies<double>(u32, u32) const;

}  // namespace lockstep
