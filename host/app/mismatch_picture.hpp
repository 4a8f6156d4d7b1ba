// The picture that `check` and `verify` draw where device and reference part.
#pragma once

#include <string>

#include "host/backends/checked_backend.hpp"
#include "host/render/scene_model.hpp"

namespace lockstep::app {

/// Draws both states as they are now into a PNG file, and says so on stderr.
template <class real>
void draw_mismatch(const Mismatch& mismatch, CheckedBackend<real>& backend, SceneModel model, const std::string& scene,
                   const std::string& path);

}  // namespace lockstep::app
