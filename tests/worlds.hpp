// Worlds of shapes of all kinds for the tests of single stages, put into buffers without a scene file.
#pragma once

#include <algorithm>
#include <cmath>
#include <initializer_list>

#include "cpu_reference/reference.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/step_params.hpp"

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
  /// A unit quaternion; not uniform, and free of libm.
  Quaternion rotation() {
    const Quaternion q = {between(-1, 1), between(-1, 1), between(-1, 1), between(-1, 1)};
    const double square = q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3];
    if (square < 0.01) return {0, 0, 0, 1};
    const double s = 1 / std::sqrt(square);
    return {s * q[0], s * q[1], s * q[2], s * q[3]};
  }

 private:
  u32 state_;
};

/// A dynamic body of 1 kg with this shape at its centre of mass.
inline BodyDescription body_of(const ShapeDescription& shape, const Vector3& inertia, const Vector3& position) {
  BodyDescription body;
  body.mass = 1;
  body.inertia = inertia;
  body.position = position;
  body.shapes.push_back(shape);
  return body;
}

inline BodyDescription sphere_body(Vector3 position, double radius, Vector3 velocity = {0, 0, 0}) {
  ShapeDescription sphere;
  sphere.radius = radius;
  const double moment = 0.4 * radius * radius;
  BodyDescription body = body_of(sphere, {moment, moment, moment}, position);
  body.velocity = velocity;
  return body;
}

inline BodyDescription box_body(Vector3 position, Vector3 half_extents, Quaternion orientation = {0, 0, 0, 1}) {
  ShapeDescription box;
  box.kind = SHAPE_BOX;
  box.half_extents = half_extents;
  const double x = half_extents[0] * half_extents[0], y = half_extents[1] * half_extents[1],
               z = half_extents[2] * half_extents[2];
  BodyDescription body = body_of(box, {(y + z) / 3, (x + z) / 3, (x + y) / 3}, position);
  body.orientation = orientation;
  return body;
}

/// A capsule or a cylinder along the body's z axis; both with the moments of the cylinder.
inline BodyDescription round_body(ShapeKind kind, Vector3 position, double radius, double half_length,
                                  Quaternion orientation = {0, 0, 0, 1}) {
  ShapeDescription round;
  round.kind = kind;
  round.radius = radius;
  round.half_length = half_length;
  const double across = radius * radius / 4 + half_length * half_length / 3;
  BodyDescription body = body_of(round, {across, across, radius * radius / 2}, position);
  body.orientation = orientation;
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

/// The sizes of a shape and its bounding radius, as the scene compiler sets them. Of a hull only these: its tables stay
/// empty.
template <class real>
void set_size(Shape<real>& out, const ShapeDescription& in) {
  Vector3 size = {0, 0, 0};
  double bounding_radius = 0;
  const double slack = 1.000001;
  switch (in.kind) {
    case SHAPE_SPHERE: size[0] = bounding_radius = in.radius; break;
    case SHAPE_CAPSULE:
      size = {in.radius, in.half_length, 0};
      bounding_radius = slack * (in.radius + in.half_length);
      break;
    case SHAPE_CYLINDER:
      size = {in.radius, in.half_length, 0};
      bounding_radius = slack * std::sqrt(in.radius * in.radius + in.half_length * in.half_length);
      break;
    case SHAPE_BOX:
    case SHAPE_HULL:
      size = in.half_extents;
      for (const Vector3& point : in.points) {
        for (unsigned k = 0; k < 3; ++k) size[k] = std::max(size[k], std::abs(point[k]));
      }
      bounding_radius = slack * std::sqrt(size[0] * size[0] + size[1] * size[1] + size[2] * size[2]);
      break;
    default: break;  // a plane has no size
  }
  for (unsigned k = 0; k < 3; ++k) out.size[k] = real(size[k]);
  out.bounding_radius = real(bounding_radius);
}

inline Features features_of(ShapeKind kind) {
  const Features manifolds = static_cast<Features>(Feature::manifolds);
  switch (kind) {
    case SHAPE_CAPSULE: return with(manifolds, Feature::capsules);
    case SHAPE_BOX: return with(manifolds, Feature::boxes);
    case SHAPE_CYLINDER: return with(manifolds, Feature::cylinders);
    case SHAPE_HULL: return with(manifolds, Feature::hulls);
    default: return 0;
  }
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
    const u32 flags = (central ? SHAPE_IS_CENTRAL : 0) | (s.trigger ? SHAPE_IS_TRIGGER : 0) |
                      (body.continuous ? SHAPE_IS_CONTINUOUS : 0);
    b.shape_infos.push_back({index, shape_id, u32(s.kind), s.material, s.category, s.mask, flags, 0});
    Shape<real> shape = {};
    set(shape.offset, s.offset);
    for (int k = 0; k < 4; ++k) shape.rotation[k] = real(s.rotation[k]);
    set_size(shape, s);
    b.shapes.push_back(shape);
    state.features |= features_of(s.kind);
    if (s.kind == SHAPE_PLANE) b.planes.push_back(shape_index);
  }
}

/// A batch of worlds with one material (friction 0.5, no restitution), steps of 1/60 s, and room for `pairs` pairs and
/// as many contacts.
template <class real>
InitialState<real> make_worlds(const std::vector<std::vector<BodyDescription>>& worlds, u32 pairs) {
  InitialState<real> state;
  state.features = with(with(with(static_cast<Features>(Feature::contacts), Feature::grid), Feature::general_contacts),
                        Feature::time_stepping);
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
  sizes.blocks = sizes.rows = MAX_COLORS + 2 * pairs / PACK;
  resize(b, sizes, state.features);

  StepParams<real>& p = state.params;
  p.dt = real(1) / real(60);
  p.restitution_threshold = 0;
  p.correction = real(0.2);
  p.correction_limit = 3;
  p.slop = real(1e-4);
  p.margin = real(0.005);
  p.speed_limit = real(1e5);
  set_sizes(p, sizes);
  p.iterations = 10;
  p.relaxations = 1;
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
