// Narrow phase: where the shapes of each pair touch, or will within the step: at points whose
// gap <= margin + h max(0, approach speed). The points are kept in the frames of the bodies; how close they are is
// measured again in each sub-step (prepare_contacts). Where a body asks for it they are those of the impact within the
// step instead of those that are closest at its start.
#pragma once

#include "cpu_reference/shapes/advance.hpp"
#include "cpu_reference/shapes/may_touch.hpp"
#include "cpu_reference/shapes/pairs.hpp"
#include "cpu_reference/tolerances.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// One side of a pair.
template <class real>
struct Side {
  const ShapeInfo& info;
  const Shape<real>& shape;
  const Motion<real>& motion;
  Pose<real> pose;
  Vec3<real> arm;  // from the centre of mass to the centre of the shape, world axes
  u32 first_seam, seam_count;
};

template <class real>
Side<real> collide_side(const Buffers<real>& b, u32 shape) {
  const u32 body = b.shape_infos[shape].body;
  const Pose<real> pose = make_pose(b.positions[body], b.orientations[body]);
  const bool has_seams = (b.shape_infos[shape].flags & SHAPE_HAS_SEAMS) != 0;
  const u32 first_seam = has_seams ? b.seam_starts[shape] : 0;
  return {b.shape_infos[shape],
          b.shapes[shape],
          b.motions[body],
          pose,
          rotate3(pose.orientation, vec3(b.shapes[shape].offset)),
          first_seam,
          has_seams ? b.seam_starts[shape + 1] - first_seam : 0};
}

template <class real>
real collide_slop(const StepParams<real>& params, const Side<real>& a, const Side<real>& b) {
  return pair_slop(params, pair_radius(a.shape.size[3], b.shape.size[3]),
                   pair_radius(solid_radius(a.shape), solid_radius(b.shape)));
}

template <class real>
real collide_displacement(const StepParams<real>& params, const Side<real>& side) {
  return shape_displacement(step_length(params), point_velocity(side.motion, side.arm), side.motion,
                            side.shape.bounding_radius);
}

/// How close the two come at most before they make contacts.
template <class real>
real collide_largest_margin(const StepParams<real>& params, const Side<real>& a, const Side<real>& b) {
  return pair_margin(params, own_margin(params, a.shape.bounding_radius, a.shape.size[3]),
                     own_margin(params, b.shape.bounding_radius, b.shape.size[3]));
}
template <class real>
real collide_margin(const StepParams<real>& params, const Side<real>& a, const Side<real>& b) {
  const real own = pair_radius(own_margin(params, a.shape.bounding_radius, a.shape.size[3]),
                               own_margin(params, b.shape.bounding_radius, b.shape.size[3]));
  return params.margin + used_margin(own, collide_displacement(params, a) + collide_displacement(params, b));
}

/// The largest gap that can matter: a point of shape a, which is no farther from its centre than its bounding radius,
/// meets b no faster than |v| + |w| bounding_radius, with v and w the relative motion at the centre of a.
template <class real>
real collide_limit(const StepParams<real>& params, const Side<real>& a, const Side<real>& b, Vec3<real> arm_b) {
  const Vec3<real> v = sub3(point_velocity(b.motion, arm_b), point_velocity(a.motion, a.arm));
  const Vec3<real> w = sub3(vec3(b.motion.w), vec3(a.motion.w));
  return collide_margin(params, a, b) + step_length(params) * (length3(v) + length3(w) * a.shape.bounding_radius);
}

/// From the centre of mass of b to that of a.
template <class real>
Vec3<real> collide_offset_ab(const Side<real>& a, const Side<real>& b) {
  return sub3(a.pose.position, b.pose.position);
}

/// The centre of shape b, seen from that of shape a.
template <class real>
Vec3<real> collide_center_b(const Side<real>& a, const Side<real>& b) {
  return sub3(b.arm, add3(a.arm, collide_offset_ab(a, b)));
}

template <class real>
HullTables<real> collide_tables(const Buffers<real>& b) {
  return {b.hulls.data(),      b.hull_vertices.data(), b.hull_planes.data(),
          b.hull_faces.data(), b.hull_edges.data(),    b.hull_corners.data(),
          b.facets.data(),     b.facet_edges.data(),   (b.current_seams.empty() ? b.seams : b.current_seams).data()};
}

/// The share of a step that has passed when contacts are evaluated, at the start of each sub-step, on their mean.
template <class real>
real contact_lag(const StepParams<real>& params) {
  return real(0.5) * real(params.substeps - 1) / real(params.substeps);
}

/// `h`: what is left of the step, s.
template <class real>
WorldShape<real> collide_world_shape(const Side<real>& side, Vec3<real> center, bool alone, real margin, real lag,
                                     real h) {
  return {center,
          shape_rotation(side.pose, side.shape),
          vec3(side.shape.size),
          side.info.hull,
          alone,
          scale3(h, point_velocity(side.motion, side.arm)),
          scale3(h, vec3(side.motion.w)),
          margin,
          lag,
          side.first_seam,
          alone ? 0 : side.seam_count};
}

/// How the two meet, about the centre of shape a. `alone`: facets, and shapes with seams, are taken for themselves.
template <class real>
Manifold<real> collide_sides(const Buffers<real>& buffers, const StepParams<real>& params, const Side<real>& a,
                             const Side<real>& b, real limit, bool alone, real h) {
  const real margin = collide_largest_margin(params, a, b), lag = contact_lag(params);
  return collide_shapes(a.info.kind, collide_world_shape(a, {0, 0, 0}, alone, margin, lag, h), b.info.kind,
                        collide_world_shape(b, collide_center_b(a, b), alone, margin, lag, h), collide_tables(buffers),
                        limit);
}

template <class real>
bool collide_in_range(const Manifold<real>& m, u32 k, const Side<real>& a, const Side<real>& b, Vec3<real> offset_ab,
                      real margin, real time_left) {
  const Vec3<real> arm = add3(a.arm, sub3(m.points[k].anchor_a, scale3(m.radius_a, m.normal)));
  const real speed = approach_speed(m.normal, a.motion, arm, b.motion, add3(arm, offset_ab));
  return gap_at(m, k) <= margin + time_left * speed;
}

/// Puts one more point into a list that is ordered by feature.
template <class real>
Manifold<real> collide_insert(Manifold<real> m, ManifoldPoint<real> point) {
  u32 slot = m.count++;
  for (; slot > 0 && m.points[slot - 1].feature > point.feature; --slot) m.points[slot] = m.points[slot - 1];
  m.points[slot] = point;
  return m;
}

/// The points that are in range with so much time of the step left (s); each anchor is seen from the centre of its own
/// shape, world axes.
template <class real>
Manifold<real> collide_keep(const StepParams<real>& params, Manifold<real> m, const Side<real>& a, const Side<real>& b,
                            real time_left) {
  const Vec3<real> offset_ab = collide_offset_ab(a, b), center_b = collide_center_b(a, b);
  const real margin = collide_margin(params, a, b);
  const u32 found = m.count;
  m.count = 0;
  for (u32 k = 0; k < found; ++k) {
    if (collide_in_range(m, k, a, b, offset_ab, margin, time_left)) m = collide_insert(m, m.points[k]);
  }
  for (u32 k = 0; k < m.count; ++k) m.points[k].anchor_b = sub3(m.points[k].anchor_b, center_b);
  return m;
}

template <class real>
bool collide_is_facet(const Side<real>& side) {
  return is_facet(side.info.kind, collide_world_shape(side, {0, 0, 0}, false, real(0), real(0), real(0)));
}

template <class real>
Side<real> collide_moved(const Side<real>& side, const Mover<real>& mover, real time) {
  const Pose<real> pose = advance_pose(mover, time);
  const Vec3<real> arm = rotate3(pose.orientation, vec3(side.shape.offset));
  return {side.info, side.shape, side.motion, pose, arm, side.first_seam, side.seam_count};
}

/// Adds the core of the continuous side where its middle would come to the tangent plane of the other side in the time
/// that is left.
template <class real>
void collide_add_core(const Buffers<real>& buffers, const Side<real>& a, const Side<real>& b, real time_left,
                      Manifold<real>& m) {
  const bool of_a = (a.info.flags & SHAPE_IS_CONTINUOUS) != 0;
  const Side<real>& side = of_a ? a : b;
  const real radius = core_radius(side.info.kind, vec3(side.shape.size), side.info.hull, collide_tables(buffers));
  if (m.count == 0 || radius < 0) return;
  const Vec3<real> offset_ab = collide_offset_ab(a, b), center_b = collide_center_b(a, b);
  const Vec3<real> arm_a = of_a ? a.arm : sub3(b.arm, offset_ab);
  const real speed = approach_speed(m.normal, a.motion, arm_a, b.motion, add3(arm_a, offset_ab));
  if (middle_gap(m, of_a, center_b) < time_left * speed) add_core(m, of_a, radius);
}

/// The points at the impact, or at the end of the step where the two do not meet before. On its way to a facet a body
/// may be beside it: until it is there the facet is taken for itself. And so is a shape with seams.
template <class real>
Manifold<real> collide_at_impact(const Buffers<real>& buffers, const StepParams<real>& params, const Side<real>& a,
                                 const Side<real>& b, real limit) {
  const real h = step_length(params), slop = collide_slop(params, a, b);
  Manifold<real> m = collide_sides(buffers, params, a, b, limit, true, h);
  const Mover<real> mover_a = make_mover(a.info, a.shape, a.motion, a.pose);
  const Mover<real> mover_b = make_mover(b.info, b.shape, b.motion, b.pose);
  real time = 0;
  for (u32 round = 0; round < advance_rounds && m.count > 0 && time < h && closest_gap(m) > slop; ++round) {
    time = advance_time(time, closest_gap(m), closing_speed(mover_a, mover_b, m.normal, h), h);
    m = collide_sides(buffers, params, collide_moved(a, mover_a, time), collide_moved(b, mover_b, time), limit, true,
                      h);
  }
  const Side<real> at_a = time > 0 ? collide_moved(a, mover_a, time) : a;
  const Side<real> at_b = time > 0 ? collide_moved(b, mover_b, time) : b;
  if (collide_is_facet(a) || collide_is_facet(b) || a.seam_count + b.seam_count > 0)
    m = collide_sides(buffers, params, at_a, at_b, limit, false, h - time);
  m = collide_keep(params, m, at_a, at_b, h - time);
  collide_add_core(buffers, at_a, at_b, h - time, m);
  if (time > 0) bring_back(m, mover_a, mover_b, time);
  return m;
}

/// The points of a pair.
template <class real>
Manifold<real> collide_pair(const Buffers<real>& buffers, const StepParams<real>& params, Pair pair) {
  const Side<real> a = collide_side(buffers, pair.shape_a), b = collide_side(buffers, pair.shape_b);
  const u32 flags = a.info.flags | b.info.flags;
  if ((flags & SHAPE_IS_TRIGGER) != 0) return no_manifold<real>();
  const real limit = collide_limit(params, a, b, add3(a.arm, collide_offset_ab(a, b)));
  if ((flags & SHAPE_IS_CONTINUOUS) != 0) return collide_at_impact(buffers, params, a, b, limit);
  const real h = step_length(params);
  return collide_keep(params, collide_sides(buffers, params, a, b, limit, false, h), a, b, h);
}

/// The points of a manifold in the frames of the bodies.
template <class real>
ContactPoint<real> contact_point(const Buffers<real>& b, const Contact& contact, const Manifold<real>& m, u32 k) {
  const Quat<real> orientation_a = quat(b.orientations[contact.body_a]),
                   orientation_b = quat(b.orientations[contact.body_b]);
  const Vec3<real> anchor_a =
      add3(vec3(b.shapes[contact.shape_a].offset), unrotate3(orientation_a, m.points[k].anchor_a));
  const Vec3<real> anchor_b =
      add3(vec3(b.shapes[contact.shape_b].offset), unrotate3(orientation_b, m.points[k].anchor_b));
  Vec3<real> normal = m.normal;
  if (m.frame == NORMAL_OF_A) normal = unrotate3(orientation_a, normal);
  if (m.frame == NORMAL_OF_B) normal = unrotate3(orientation_b, normal);
  return {{anchor_a.x, anchor_a.y, anchor_a.z},
          m.radius_a,
          {anchor_b.x, anchor_b.y, anchor_b.z},
          m.radius_b,
          {normal.x, normal.y, normal.z, 0}};
}

/// Contacts ordered by (shape_a, shape_b, feature), numbered within their world. Where they are more than the capacity
/// none is kept, and the step is aborted.
template <class real>
void collide(Buffers<real>& b, const StepParams<real>& params) {
  const u32 pairs = b.counters[COUNTER_PAIRS];
  std::vector<Manifold<real>> manifolds(pairs);
  u32 total = 0;
  for (u32 p = 0; p < pairs; ++p) {
    manifolds[p] = collide_pair(b, params, b.pairs[p]);
    b.contact_starts[p] = total;
    total += manifolds[p].count;
  }
  b.contact_starts[pairs] = total;
  b.counters[COUNTER_CONTACTS_NEEDED] = total;
  b.counters[COUNTER_CONTACTS] = total <= params.contact_capacity ? total : 0;
  if (total > params.contact_capacity) {
    b.counters[COUNTER_STATUS] |= STATUS_CONTACTS_FULL;
    return;
  }

  for (u32 p = 0; p < pairs; ++p) {
    const Pair pair = b.pairs[p];
    const Manifold<real>& m = manifolds[p];
    const u32 body_a = b.shape_infos[pair.shape_a].body, body_b = b.shape_infos[pair.shape_b].body;
    const u32 world = b.body_infos[body_a].world;
    const u32 first = b.contact_starts[b.pair_starts[b.world_ranges[world].first_shape]];
    for (u32 k = 0; k < m.count; ++k) {
      const u32 i = b.contact_starts[p] + k;
      b.contacts[i] = {pair.shape_a, pair.shape_b, m.points[k].feature, body_a, body_b, world, i - first, m.frame};
      b.contact_points[i] = contact_point(b, b.contacts[i], m, k);
    }
  }
}

}  // namespace lockstep::reference
