// Recordings: a good one with changes inside.
#include <unistd.h>

#include "host/error.hpp"
#include "host/record/recording_file.hpp"
#include "host/record/recording_reader.hpp"
#include "host/record/recording_tables.hpp"
#include "host/record/whole_file.hpp"
#include "host/scene/read.hpp"
#include "tests/fuzz/edits.hpp"

namespace {

using namespace lockstep;

const std::string path = "/dev/shm/lockstep_fuzz_" + std::to_string(getpid()) + ".h5";

// Two steps of a scene with a body, a plane and a contact; what they did is all zeros.
std::vector<unsigned char> make_good() {
  const InitialState<float> state = compile<float>(read_scene("slide_to_roll"));
  RecordingFile<float> file(path, {"slide_to_roll", "a device", "{}", "{}"}, state, {.inputs = true, .forces = true});
  Batch<float> batch;
  for (u32 step = 1; step <= 2; ++step) batch.steps.push_back({step, 1, 1, 0, 0.5});
  batch.state_hashes.resize(2 * state.sizes.worlds);
  batch.pose_hashes.resize(2 * state.sizes.worlds);
  batch.positions.resize(2 * state.sizes.bodies);
  batch.orientations.resize(2 * state.sizes.bodies);
  batch.motions.resize(2 * state.sizes.bodies);
  batch.measures.resize(1);
  batch.contact_ends = {1, 2};
  batch.contact_forces.resize(2);
  batch.inputs.push_back({.step = 1});
  batch.inputs.push_back({.step = 2, .body = 1});
  file.write(batch);
  file.close("finished");
  return read_whole_file(path);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  h5::be_quiet();
  static const std::vector<unsigned char> good = make_good();
  replace_file(path, good);
  try {
    const h5::Handle file(H5Fopen(path.c_str(), H5F_ACC_RDWR, H5P_DEFAULT));
    Edits({data, size}).apply(file);
  } catch (const h5::Failed&) {
    return 0;
  }
  try {
    const RecordingReader recording(path);
    if (recording.precision() == "double")
      recording.start<double>();
    else
      recording.start<float>();
    if (recording.steps() > 0) recording.forces(recording.steps() - 1);
    for (u32 table = 0; table < std::size(body_tables); ++table)
      if (recording.steps() > 0) recording.bodies<float>(table, recording.steps() - 1);
  } catch (const Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) __builtin_trap();
  }
  return 0;
}
