// Fuzzer of the readers of meshes in this process: the first byte says of which. A reader gives a mesh whose triangles
// have vertices, or throws std::runtime_error in one line.
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <stdexcept>

#include "host/scene/mesh_formats.hpp"

namespace {

lockstep::TriangleMesh read(unsigned char kind, const std::string& bytes) {
  switch (kind % 4) {
    case 0: return lockstep::read_obj(bytes);
    case 1: return lockstep::read_stl(bytes);
    case 2: return lockstep::read_ply(bytes);
    default: return lockstep::read_gltf(bytes, "mesh.gltf", [&](const std::string&) { return bytes; });
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  if (size == 0) return 0;
  const std::string bytes(reinterpret_cast<const char*>(data) + 1, size - 1);
  try {
    const lockstep::TriangleMesh mesh = read(data[0], bytes);
    for (const auto& triangle : mesh.triangles)
      for (const lockstep::u32 corner : triangle)
        if (corner >= mesh.vertices.size()) std::abort();
  } catch (const std::runtime_error& error) {
    if (std::strchr(error.what(), '\n') != nullptr || std::strlen(error.what()) > 600) {
      std::fprintf(stderr, "not one line: %s\n", error.what());
      std::abort();
    }
  }
  return 0;
}
