#include "host/app/mismatch_picture.hpp"

#include <fmt/format.h>

#include <cstdio>

#include "host/record/whole_file.hpp"
#include "host/render/difference.hpp"

namespace lockstep::app {

namespace {

constexpr u32 picture_width = 1280, picture_height = 720;

}  // namespace

template <class real>
void draw_mismatch(const Mismatch& mismatch, CheckedBackend<real>& backend, SceneModel model, const std::string& scene,
                   const std::string& path) {
  const Difference& d = mismatch.difference();
  const Buffers<real>& reference = backend.reference_buffers();
  const Buffers<real>& device = backend.device_buffers(d, difference_buffers(backend.features()));
  const std::string_view where = d.stage == Stage::count ? "all sub-steps as one launch" : info(d.stage).name;
  const Picture picture =
      draw_difference(device, reference, std::move(model), location_of(d.buffer, d.element, d.word, reference),
                      {fmt::format("{}, step {}, {}", scene, d.step, where),
                       fmt::format("{}[{}] word {}", info(d.buffer).name, d.element, d.word),
                       "device    " + d.device_value, "reference " + d.reference_value},
                      picture_width, picture_height);
  replace_file(path, encode_png(picture));
  fmt::print(stderr, "lockstep: {}: both states, where they part\n", path);
}

template void draw_mismatch(const Mismatch&, CheckedBackend<float>&, SceneModel, const std::string&,
                            const std::string&);
template void draw_mismatch(const Mismatch&, CheckedBackend<double>&, SceneModel, const std::string&,
                            const std::string&);

}  // namespace lockstep::app
