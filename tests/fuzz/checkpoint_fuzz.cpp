// Checkpoints: any bytes, and a good file with changes inside and a hash that fits.
#include "host/error.hpp"
#include "host/record/checkpoint.hpp"
#include "host/scene/read.hpp"
#include "tests/fuzz/edits.hpp"

namespace {

using namespace lockstep;
using Bytes = std::vector<unsigned char>;

const InitialState<float>& scene() {
  static const InitialState<float> state = compile<float>(read_scene("sensor_gate"));
  return state;
}

Bytes changed(std::span<const unsigned char> edits) {
  static const Bytes good =
      encode_checkpoint<float>({"sensor_gate", "a device", identity_of(scene()), 0}, scene().buffers, scene().features);
  const h5::Handle access(H5Pcreate(H5P_FILE_ACCESS));
  h5::check(H5Pset_fapl_core(access, 1u << 16, false));
  Bytes inside = checkpoint_contents(good, "good");
  h5::check(H5Pset_file_image(access, inside.data(), inside.size()));
  const h5::Handle file(H5Fopen("edited", H5F_ACC_RDWR, access));
  Edits(edits).apply(file);
  h5::check(H5Fflush(file, H5F_SCOPE_LOCAL));
  inside.resize(static_cast<std::size_t>(h5::check(H5Fget_file_image(file, nullptr, 0))));
  h5::check(H5Fget_file_image(file, inside.data(), inside.size()));
  return seal_checkpoint(inside);
}

void resume(std::span<const unsigned char> bytes) {
  try {
    InitialState<float> state = scene();
    resume_from(bytes, "fuzz.h5", "sensor_gate", state);
  } catch (const Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) __builtin_trap();
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  h5::be_quiet();
  resume({data, size});
  resume(changed({data, size}));
  return 0;
}
