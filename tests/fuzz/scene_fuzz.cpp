// Scene files: any text is read and compiled, or refused with an Error.
#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"
#include "host/scene/sample_particles.hpp"

namespace {

using namespace lockstep;

// A line of text can ask for two million bodies, or as many particles; a fuzzer has other things to do.
bool is_small(const Scene& scene) {
  double particles = 0;
  for (const BodyDescription& body : scene.bodies) {
    for (const ShapeDescription& shape : body.shapes)
      if (scene.particles && shape.kind != SHAPE_PLANE) particles += expected_particles(shape, *scene.particles);
  }
  return scene.bodies.size() <= 5000 && particles <= 2'000;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const unsigned char* data, std::size_t size) {
  try {
    const Scene scene = parse_scene(std::string(reinterpret_cast<const char*>(data), size), "fuzz.json");
    if (is_small(scene)) compile<float>(scene);
  } catch (const Error& error) {
    if (std::string(error.what()).find('\n') != std::string::npos) __builtin_trap();
  }
  return 0;
}
