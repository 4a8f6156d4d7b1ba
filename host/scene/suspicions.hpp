// What looks like a mistake in a scene that can be simulated: sizes in millimetres, bodies that start inside each
// other, a quaternion with w first. Each is said in a line with its cure; none is an error
// (docs/how_to/when_it_looks_wrong.md).
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep {

/// Two bodies that touch where a simulation starts, at the point where they are deepest in each other.
/// host/backends/first_contacts.hpp finds them.
struct FirstContact {
  u32 body_a, body_b;    // indices into Scene::bodies
  u32 shape_a, shape_b;  // indices into their shapes
  double gap;            // m, below 0 where they overlap
  Vector3 normal;        // from b to a, world frame
};

/// A line for each: where, what, and the cure. Of one kind three are named and the others counted. What is sound, or
/// can be meant, is not among them: each has conditions that exclude it, in suspicions.cpp.
std::vector<std::string> suspicions_of(const Scene& scene, std::span<const FirstContact> contacts);

}  // namespace lockstep
