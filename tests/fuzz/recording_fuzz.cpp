// Recordings: a good one with changes inside.
#include <unistd.h>

#include <cstdlib>

#include "host/error.hpp"
#include "host/record/recording_reader.hpp"
#include "host/record/recording_tables.hpp"
#include "host/record/whole_file.hpp"
#include "tests/fuzz/edits.hpp"

namespace {

using namespace lockstep;

const std::vector<unsigned char>& good() {
  static const std::vector<unsigned char> bytes = read_whole_file(std::getenv("LOCKSTEP_FUZZ_RECORDING"));
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  h5::be_quiet();
  static const std::string path = "/dev/shm/lockstep_fuzz_" + std::to_string(getpid()) + ".h5";
  replace_file(path, good());
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
    for (u32 table = 0; table < std::size(body_tables); ++table)
      if (recording.steps() > 0) recording.bodies<float>(table, recording.steps() - 1);
  } catch (const Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) __builtin_trap();
  }
  return 0;
}
