// The joints of a scene file: single ones, and those that generators copy with their bodies.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "host/scene/json_node.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// A joint whose bodies are still names. `next`: the body of that name in the next copy of a generator.
struct NamedJoint {
  JointDescription joint;
  std::array<std::string, 2> names;
  std::array<bool, 2> next = {false, false};
  JsonNode node;
};

/// Reads a joint. In a generator a name may end in "+1".
NamedJoint read_joint(const JsonNode& node, bool in_generator);

/// Reads an array of them.
std::vector<NamedJoint> read_joints(const JsonNode& array, bool in_generator);

/// Reads the keys "motor", "friction" and "spring" of a joint whose kind, anchors and limits are known.
void read_drive(const JsonNode& node, JointDescription& joint);

/// An angle in radians or, under the other key, in degrees; one of the two must be there.
double angle_at(const JsonNode& node, const char* radians, const char* degrees);

/// The joints of one copy of a generator, of `copies`: names of the template's bodies get the copy's number, places are
/// shifted. A joint to the copy behind the last one is left out.
void add_copied_joints(const std::vector<NamedJoint>& templates, const std::vector<BodyDescription>& bodies, u32 number,
                       u32 copies, const Vector3& shift, std::vector<NamedJoint>& joints);

/// Finds the bodies by their names. Refuses unknown ones, and joints that hold nothing.
std::vector<JointDescription> resolve_joints(const std::vector<NamedJoint>& joints,
                                             const std::vector<BodyDescription>& bodies);

}  // namespace lockstep
