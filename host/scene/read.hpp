// Scene files: JSON as docs/scene_format.md and scenes/scene.schema.json describe it, or a robot alone (.urdf,
// docs/formats.md).
#pragma once

#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

/// Reads a scene from a path, or a built-in scene by its name. Throws Error (input) with "file: /json/path: rule and
/// value".
Scene read_scene(const std::string& path_or_name);

/// Reads a scene from JSON text, or from URDF where `source`, which stands for the file in errors, ends in .urdf.
Scene parse_scene(const std::string& text, const std::string& source);

/// The camera alone, which may have been asked for in a scene that was read elsewhere: its meshes need not be there.
std::optional<CameraDescription> parse_camera(const std::string& text, const std::string& source);

struct SceneListing {
  std::string name, description;
};

/// The built-in scenes, ordered by name.
std::vector<SceneListing> built_in_scenes();

}  // namespace lockstep
