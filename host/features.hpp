// What a scene models. Features decide which stages run, which buffers exist and what kernels are compiled with.
#pragma once

#include "kernels/types.h"

namespace lockstep {

enum class Feature : u32 {
  always = 0,
  contacts = 1u << 0,  // shapes that can touch
  general_contacts =
      1u << 1,       // some contact may need the full 3 x 3 Delassus block: shapes off centre, anisotropic bodies
  pivots = 1u << 2,  // bodies that turn about a fixed point
  time_stepping = 1u << 3,  // velocities, then positions; what contacts need
  runge_kutta = 1u << 4,    // free flight in one stage of fourth order
  gyroscopic = 1u << 5,     // some body is anisotropic and its gyroscopic moment is wanted
  manifolds = 1u << 6,      // some pair can touch at several points: there are shapes beside spheres and planes
  capsules = 1u << 7,
  boxes = 1u << 8,
  cylinders = 1u << 9,
  hulls = 1u << 10,
  grid = 1u << 11,           // candidate pairs come from a uniform grid ...
  bvh = 1u << 12,            // ... or from a tree of boxes
  events = 1u << 13,         // who began and ceased to touch is wanted
  sensors = 1u << 14,        // shapes that only feel; they come with events
  continuous = 1u << 15,     // some body's impacts are looked for within the step
  queries = 1u << 16,        // rays or volumes were asked about: switched on while the simulation runs
  soft_contacts = 1u << 17,  // contacts that overlap are springs, and a sweep takes back what they added
  joints = 1u << 18,
  soft_joints = 1u << 19,    // joints are springs too
  patches = 1u << 20,        // the contacts of a pair rub as one
  jacobi = 1u << 21,         // pairs in contact are solved all at once, each on parts of its bodies; no colours
  tolerance = 1u << 22,      // a sub-step ends its sweeps when they change little
  all_pairs = 1u << 23,      // ... or from comparing all shapes: one of the three wherever there are contacts
  loads = 1u << 24,          // forces and torques act on bodies from outside
  particles = 1u << 25,      // bodies push each other by particles, with springs and dampers; shapes do not touch
  shear_springs = 1u << 26,  // particles remember how far they were sheared
  joint_springs = 1u << 27,  // springs act on free coordinates of joints
  joints_ahead = 1u << 28,   // joints act along axes of later than the start of a sub-step: theta is not 1
  closed_joints = 1u << 29,  // joints are closed by the poses of their bodies, once these have moved
  screws = 1u << 30,         // some joint ties travel to angle
  facets = 1u << 31,         // some hulls are triangles of a surface
  // what needs one of several
  constraints = contacts | joints,
  relaxing = soft_contacts | soft_joints,
};

using Features = u32;  // a set: bits of Feature

constexpr bool has(Features set, Feature feature) {
  return (set & static_cast<u32>(feature)) == static_cast<u32>(feature);
}
constexpr Features with(Features set, Feature feature) { return set | static_cast<u32>(feature); }

}  // namespace lockstep
