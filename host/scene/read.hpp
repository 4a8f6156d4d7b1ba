// Scene files: JSON as docs/reference/scene_format.md and scenes/scene.schema.json describe it, or a robot alone
// (.urdf, .xml; docs/reference/formats.md).
#pragma once

#include <string>
#include <vector>

#include "host/scene/robot_reading.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// Reads a scene from a path, or a built-in scene by its name. Throws Error (input) with "file: /json/path: rule and
/// value". With another seed than 0 what it draws at random is drawn otherwise: jitters take as their seed the one in
/// the file plus `seed` times seed_stride, modulo 2^32. Scene::notes say what was left out of robots, which
/// `reading` refuses, or allows more of.
Scene read_scene(const std::string& path_or_name, u32 seed = 0, const RobotReading& reading = {});

/// Reads a scene from JSON text, or a robot where `source`, which stands for the file in errors, ends in .urdf or .xml.
Scene parse_scene(const std::string& text, const std::string& source, u32 seed = 0, const RobotReading& reading = {});

/// The camera alone, which may have been asked for in a scene that was read elsewhere: its meshes need not be there.
std::optional<CameraDescription> parse_camera(const std::string& text, const std::string& source);

/// One more body for a scene, in the words of its file: JSON of an entry of "bodies" that is no generator. Materials
/// and categories have the names of the scene, and a new category becomes one of it. Throws Error (input).
BodyDescription parse_body(const std::string& text, const std::string& source, Scene& scene);

/// The same of a joint, but for the key "bodies", which it must not have: the caller knows them.
JointDescription parse_joint(const std::string& text, const std::string& source);

/// The same of a joint that is described anew: its anchors, axes, pitch and radius are those of `joint`, whatever the
/// text says, and so is its kind, which it may leave out.
JointDescription parse_joint_change(const std::string& text, const std::string& source, const JointDescription& joint);

struct SceneListing {
  std::string name, description;
};

/// The built-in scenes, ordered by name.
std::vector<SceneListing> built_in_scenes();

}  // namespace lockstep
