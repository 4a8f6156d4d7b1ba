// Worlds of spheres and planes for the tests of single stages, put into buffers without a scene file.
#pragma once

#include <algorithm>
#include <initializer_list>

#include "cpu_reference/reference.hpp"
#include "host/scene/compile.hpp"

namespace lockstep::test {

/// A generator of its own: equal numbers with every compiler.
class Random {
 public:
  explicit Random(u32 seed) : state_(seed * 2654435761u + 12345u) {}
  u32 bits() {
    state_ ^= state_ << 13;
    state_ ^= state_ >> 17;
    return state_ ^= state_ << 5;
  }
  double between(double low, double high) { return low + (high - low) * (bits() >> 8) / 16777216.0; }
  Vector3 vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }

 private:
  u32 state_;
};

inline BodyDescription sphere_body(Vector3 position, double radius, Vector3 velocity = {0, 0, 0}) {
  BodyDescription body;
  body.mass = 1;
  body.inertia = {0.4 * radius * radius, 0.4 * radius * radius, 0.4 * radius * radius};
  body.position = position;
  body.velocity = velocity;
  ShapeDescription sphere;
  sphere.radius = radius;
  body.shapes.push_back(sphere);
  return body;
}

/// A static body with a plane through `position`, its normal the z axis of `orientation`.
inline BodyDescription plane_body(Vector3 position = {0, 0, 0}, Quaternion orientation = {0, 0, 0, 1}) {
  BodyDescription body;
  body.kind = BODY_STATIC;
  body.position = position;
  body.orientation = orientation;
  ShapeDescription plane;
  plane.kind = SHAPE_PLANE;
  body.shapes.push_back(plane);
  return body;
}

template <class real>
void set(real* out, const Vector3& in) {
  for (int k = 0; k < 3; ++k) out[k] = real(in[k]);
}

template <class real>
void add_body(InitialState<real>& state, u32 world, u32 id, const BodyDescription& body) {
  Buffers<real>& b = state.buffers;
  const u32 index = u32(b.body_infos.size());
  const bool isotropic = body.inertia[0] == body.inertia[1] && body.inertia[1] == body.inertia[2];
  b.body_infos.push_back({world, id, u32(body.kind), isotropic ? 1u : 0u});
  b.positions.push_back({real(body.position[0]), real(body.position[1]), real(body.position[2]), 0});
  b.orientations.push_back(
      {real(body.orientation[0]), real(body.orientation[1]), real(body.orientation[2]), real(body.orientation[3])});
  Mass<real> mass = {};
  Motion<real> motion = {};
  set(motion.v, body.velocity);
  set(motion.w, body.angular_velocity);
  if (body.kind == BODY_DYNAMIC) {
    mass.mass = real(body.mass);
    motion.inverse_mass = mass.inverse_mass = real(1 / body.mass);
    set(mass.inertia, body.inertia);
    set(mass.inverse_inertia, {1 / body.inertia[0], 1 / body.inertia[1], 1 / body.inertia[2]});
  }
  b.masses.push_back(mass);
  b.motions.push_back(motion);
  for (const ShapeDescription& s : body.shapes) {
    const u32 shape_index = u32(b.shapes.size());
    const u32 shape_id = shape_index - b.world_ranges[world].first_shape;
    const bool central = s.kind == SHAPE_SPHERE && s.offset == Vector3{0, 0, 0};
    const u32 flags = (central ? SHAPE_IS_CENTRAL : 0) | (s.sensor ? SHAPE_IS_SENSOR : 0) |
                      (body.continuous ? SHAPE_IS_CONTINUOUS : 0);
    b.shape_infos.push_back({index, shape_id, u32(s.kind), s.material, s.category, s.mask, flags, 0});
    Shape<real> shape = {};
    set(shape.offset, s.offset);
    for (int k = 0; k < 4; ++k) shape.rotation[k] = real(s.rotation[k]);
    shape.size[0] = shape.reach = real(s.radius);
    b.shapes.push_back(shape);
    if (s.kind == SHAPE_PLANE) b.planes.push_back(shape_index);
  }
}

/// A batch of worlds with one material (friction 0.5, no restitution), steps of 1/60 s, and room for `pairs` pairs and
/// as many contacts.
template <class real>
InitialState<real> make_worlds(const std::vector<std::vector<BodyDescription>>& worlds, u32 pairs) {
  InitialState<real> state;
  state.features = with(with(static_cast<u32>(Feature::contacts), Feature::general_contacts), Feature::time_stepping);
  Buffers<real>& b = state.buffers;
  for (u32 w = 0; w < worlds.size(); ++w) {
    b.world_ranges.push_back({u32(b.body_infos.size()), u32(worlds[w].size()), u32(b.shapes.size()), 0,
                              u32(b.planes.size()), 0, u32(b.material_pairs.size()), 1});
    b.gravities.push_back({0, 0, real(-9.81), 0});
    b.material_pairs.push_back({real(0.5), 0});
    for (u32 id = 0; id < worlds[w].size(); ++id) add_body(state, w, id, worlds[w][id]);
    b.world_ranges[w].shape_count = u32(b.shapes.size()) - b.world_ranges[w].first_shape;
    b.world_ranges[w].plane_count = u32(b.planes.size()) - b.world_ranges[w].first_plane;
  }

  Sizes& sizes = state.sizes;
  sizes.worlds = u32(worlds.size());
  sizes.bodies = u32(b.body_infos.size());
  sizes.shapes = u32(b.shapes.size());
  sizes.planes = u32(b.planes.size());
  sizes.material_pairs = u32(b.material_pairs.size());
  sizes.buckets = 1;
  while (sizes.buckets < sizes.shapes) sizes.buckets *= 2;
  sizes.pairs = sizes.contacts = pairs;
  sizes.blocks = MAX_COLORS + 2 * pairs / PACK;
  resize(b, sizes, state.features);

  StepParams<real>& p = state.params;
  p.dt = real(1) / real(60);
  p.restitution_threshold = 0;
  p.correction = real(0.2);
  p.correction_limit = 3;
  p.slop = real(1e-4);
  p.margin = real(0.005);
  p.speed_limit = real(1e5);
  p.bodies = sizes.bodies;
  p.shapes = sizes.shapes;
  p.worlds = sizes.worlds;
  p.buckets = sizes.buckets;
  p.pair_capacity = sizes.pairs;
  p.contact_capacity = sizes.contacts;
  p.block_capacity = sizes.blocks;
  p.iterations = 10;
  p.substeps = 1;
  return state;
}

/// Runs stages of the reference from counters of zero on.
template <class real>
void run_reference(InitialState<real>& state, std::initializer_list<Stage> stages) {
  std::ranges::fill(state.buffers.counters, 0u);
  for (Stage stage : stages) reference::run_stage(stage, state.buffers, state.params);
}

}  // namespace lockstep::test
