// MJCF files: any text is read and compiled, or refused with an Error.
#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  using namespace lockstep;
  try {
    compile<float>(parse_scene(std::string(reinterpret_cast<const char*>(data), size), "fuzz.xml"));
  } catch (const Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) __builtin_trap();
  }
  return 0;
}
