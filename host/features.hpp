// What a scene models. Features decide which stages run, which buffers exist and what kernels are compiled with.
#pragma once

#include <cstdint>
#include <utility>

namespace lockstep {

enum class Feature : std::uint64_t {
  always = 0,
  contacts = 1ull << 0,  // shapes that can touch
  general_contacts =
      1ull << 1,       // some contact may need the full 3 x 3 Delassus block: shapes off centre, anisotropic bodies
  pivots = 1ull << 2,  // bodies that turn about a fixed point
  time_stepping = 1ull << 3,  // velocities, then positions; what contacts need
  runge_kutta = 1ull << 4,    // free flight in one stage of fourth order
  gyroscopic = 1ull << 5,     // some body is anisotropic and its gyroscopic moment is wanted
  manifolds = 1ull << 6,      // some pair can touch at several points: there are shapes beside spheres and planes
  capsules = 1ull << 7,
  boxes = 1ull << 8,
  cylinders = 1ull << 9,
  hulls = 1ull << 10,
  grid = 1ull << 11,           // candidate pairs come from a uniform grid ...
  bvh = 1ull << 12,            // ... or from a tree of boxes
  events = 1ull << 13,         // who began and ceased to touch is wanted
  triggers = 1ull << 14,       // shapes that only detect; they come with events
  continuous = 1ull << 15,     // some body's impacts are looked for within the step
  queries = 1ull << 16,        // rays or volumes were asked about: switched on while the simulation runs
  soft_contacts = 1ull << 17,  // contacts that overlap are springs, and a sweep takes back what they added
  joints = 1ull << 18,
  soft_joints = 1ull << 19,       // joints are springs too
  patches = 1ull << 20,           // the contacts of a pair share one friction patch
  jacobi = 1ull << 21,            // pairs in contact are solved all at once, each on copies of its bodies; no colours
  tolerance = 1ull << 22,         // a sub-step ends its sweeps when they change little
  all_pairs = 1ull << 23,         // ... or from comparing all shapes: one of the three wherever there are contacts
  loads = 1ull << 24,             // forces and torques act on bodies from outside
  particles = 1ull << 25,         // bodies push each other by particles, with springs and dampers; shapes do not touch
  shear_springs = 1ull << 26,     // particles remember how far they were sheared
  joint_springs = 1ull << 27,     // springs act on free coordinates of joints
  joints_ahead = 1ull << 28,      // joints act along axes of later than the start of a sub-step: theta is not 1
  closed_joints = 1ull << 29,     // joints are closed by the poses of their bodies, once these have moved
  screws = 1ull << 30,            // some joint ties travel to angle
  facets = 1ull << 31,            // some hulls are triangles of a surface
  impact_laws = 1ull << 32,       // some materials bounce by another law than Newton's
  non_holonomic = 1ull << 33,     // some joints lock velocities alone: skates, and what rolls
  sleeping = 1ull << 34,          // islands of bodies that are at rest for long sleep until they are touched
  gradient = 1ull << 35,          // contacts and joints are solved as one convex problem, by descent along its gradient
  angular_friction = 1ull << 36,  // some contacts resist rolling, or rotation about their normal
  static_friction = 1ull << 37,   // some stick by more than they slide with
  elliptic_friction = 1ull << 38,   // friction of some is anisotropic; it comes with angular_friction
  partitions = 1ull << 39,          // pairs in contact are solved cell by cell of a grid; what is in no cell by colours
  dense = 1ull << 40,               // contacts are solved in the order of their list, by the dense Delassus matrix
  shape_trees = 1ull << 41,         // some bodies that nothing pushes have so many shapes that they keep a tree of them
  articulations = 1ull << 42,       // joints of trees of bodies are solved all at once
  closures = 1ull << 43,            // some of them close loops
  seams = 1ull << 44,               // some shapes that do not move against each other lie flush
  coupled_normals = 1ull << 45,     // the normal impulses of the points of a pair are found together
  separated_contacts = 1ull << 46,  // overlap is taken back by the poses of bodies, and contacts foresee the sub-step
  impacts = 1ull << 47,             // how fast contacts come together is wanted; it comes with events
  summed_impulses = 1ull << 48,     // what contacts and joints gave in all sub-steps of a step is wanted
  joint_angles = 1ull << 49,        // some joints count the revolutions of their angles
  joint_impedances = 1ull << 50,    // some have armature, or a spring beside limits
  couplings = 1ull << 51,           // free coordinates of some are tied to each other
  geometric_stiffness = 1ull << 52,  // light bodies between loaded joints get the inertia with which a step is stable
  planar_joints = 1ull << 53,        // planar joints tie some bodies to what cannot move
  moving_seams = 1ull << 54,         // some seams are those of kinematic bodies with other bodies
  // what needs one of several
  constraints = contacts | joints,
  relaxing = soft_contacts | soft_joints,
  // what needs both
  angular_friction_sleepers = angular_friction | sleeping,
  foreseen_rims = separated_contacts | cylinders,
  summed_contacts = summed_impulses | contacts,
  summed_joints = summed_impulses | joints,
};

/// Features whose stages and buffers are nothing without those of another.
inline constexpr std::pair<Feature, Feature> feature_needs[] = {
    {Feature::manifolds, Feature::contacts},
    {Feature::capsules, Feature::contacts},
    {Feature::boxes, Feature::contacts},
    {Feature::cylinders, Feature::contacts},
    {Feature::hulls, Feature::contacts},
    {Feature::grid, Feature::contacts},
    {Feature::bvh, Feature::contacts},
    {Feature::all_pairs, Feature::contacts},
    {Feature::events, Feature::contacts},
    {Feature::triggers, Feature::events},
    {Feature::impacts, Feature::events},
    {Feature::continuous, Feature::contacts},
    {Feature::soft_contacts, Feature::contacts},
    {Feature::patches, Feature::contacts},
    {Feature::jacobi, Feature::contacts},
    {Feature::soft_joints, Feature::joints},
    {Feature::joint_springs, Feature::joints},
    {Feature::closed_joints, Feature::joints},
    {Feature::screws, Feature::joints},
    {Feature::joint_angles, Feature::joints},
    {Feature::joint_impedances, Feature::joints},
    {Feature::couplings, Feature::joints},
    {Feature::geometric_stiffness, Feature::joints},
    {Feature::planar_joints, Feature::joints},
    {Feature::facets, Feature::hulls},
    {Feature::seams, Feature::manifolds},
    {Feature::moving_seams, Feature::seams},
    {Feature::shape_trees, Feature::contacts},
    {Feature::shear_springs, Feature::particles},
    {Feature::impact_laws, Feature::contacts},
    {Feature::non_holonomic, Feature::joints},
    {Feature::angular_friction, Feature::contacts},
    {Feature::static_friction, Feature::contacts},
    {Feature::elliptic_friction, Feature::angular_friction},
    {Feature::partitions, Feature::contacts},
    {Feature::articulations, Feature::joints},
    {Feature::closures, Feature::articulations},
    {Feature::separated_contacts, Feature::contacts},
    {Feature::coupled_normals, Feature::manifolds},
    {Feature::coupled_normals, Feature::general_contacts},
    {Feature::dense, Feature::contacts},
    {Feature::dense, Feature::general_contacts},
};

using Features = std::uint64_t;  // a set: bits of Feature

constexpr bool has(Features set, Feature feature) {
  return (set & static_cast<Features>(feature)) == static_cast<Features>(feature);
}
constexpr Features with(Features set, Feature feature) { return set | static_cast<Features>(feature); }

}  // namespace lockstep
