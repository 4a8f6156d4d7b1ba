// Lays what a sub-step needs of each contact beside its lane, once a step, so that prepare_contacts reads it in order:
// the contact point in the frames of the bodies, the material of the pair, and the impulse to start from. Lanes without
// a contact are zero.
#pragma once

#include "cpu_reference/math.hpp"
#include "cpu_reference/tolerances.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// The index of the pair of materials that meet.
template <class real>
u32 materials_of(const Buffers<real>& buffers, const Contact& contact) {
  const WorldRange& world = buffers.world_ranges[contact.world];
  const u32 a = buffers.shape_infos[contact.shape_a].material, b = buffers.shape_infos[contact.shape_b].material;
  return world.first_material_pair + a * world.material_count + b;
}

template <class real>
void write_point(PointBlock<real>& block, StartBlock<real>& starts, u32 lane, const ContactPoint<real>& point,
                 u32 frame, MaterialPair<real> material, real inner_radius, real bounding_radius,
                 const ContactImpulse<real>& start) {
  block.anchor_a_x[lane] = point.anchor_a[0];
  block.anchor_a_y[lane] = point.anchor_a[1];
  block.anchor_a_z[lane] = point.anchor_a[2];
  block.radius_a[lane] = point.radius_a;
  block.anchor_b_x[lane] = point.anchor_b[0];
  block.anchor_b_y[lane] = point.anchor_b[1];
  block.anchor_b_z[lane] = point.anchor_b[2];
  block.radius_b[lane] = point.radius_b;
  block.normal_x[lane] = point.normal[0];
  block.normal_y[lane] = point.normal[1];
  block.normal_z[lane] = point.normal[2];
  block.friction[lane] = material.friction;
  block.restitution[lane] = material.restitution;
  block.inner_radius[lane] = inner_radius;
  block.bounding_radius[lane] = bounding_radius;
  block.frame[lane] = frame;
  starts.normal[lane] = start.normal;
  starts.tangent_x[lane] = start.tangent_x;
  starts.tangent_y[lane] = start.tangent_y;
  starts.tangent_z[lane] = start.tangent_z;
}

template <class real>
void write_impact(ImpactBlock<real>& block, u32 lane, ImpactPair<real> pair) {
  block.tangential_restitution[lane] = pair.tangential_restitution;
  block.law[lane] = pair.law;
}

template <class real>
void write_angular_friction(AngularFrictionPointBlock<real>& block, u32 lane, AngularFrictionPair<real> pair,
                            const Vec4<real>& moment) {
  block.torsion_radius[lane] = pair.torsion_radius;
  block.rolling_coefficient[lane] = pair.rolling_coefficient;
  block.moment_x[lane] = moment.x;
  block.moment_y[lane] = moment.y;
  block.moment_z[lane] = moment.z;
}

template <class real>
void write_static_friction(StaticFrictionBlock<real>& block, u32 lane, StaticFrictionPair<real> pair,
                           real bounding_radius) {
  block.friction[lane] = pair.friction;
  block.speed[lane] = pair.speed + pair.speed_share * bounding_radius;
}

template <class real>
void write_anisotropy(AnisotropyBlock<real>& block, u32 lane, AnisotropyPair<real> pair, Vec3<real> along) {
  block.x[lane] = along.x;
  block.y[lane] = along.y;
  block.z[lane] = along.z;
  block.across[lane] = pair.across;
  block.side[lane] = pair.side;
  block.perpendicular[lane] = pair.perpendicular;
}

/// An axis of a shape in the frame of its body.
template <class real>
Vec3<real> shape_axis(const Shape<real>& shape, Vec3<real> axis) {
  const real* q = shape.rotation;
  return rotate3(Quat<real>{q[0], q[1], q[2], q[3]}, axis);
}

/// The axis of anisotropy, the x axis of the shape whose it is, in the frame of its body.
template <class real>
Vec3<real> anisotropy_axis(const Buffers<real>& buffers, const Contact& contact, AnisotropyPair<real> pair) {
  return shape_axis(buffers.shapes[pair.side == 0 ? contact.shape_a : contact.shape_b], Vec3<real>{1, 0, 0});
}

/// The axis of a cylinder in the frame of its body, 0 of another shape.
template <class real>
Vec3<real> rim_axis(const Buffers<real>& buffers, u32 shape) {
  if (buffers.shape_infos[shape].kind != SHAPE_CYLINDER) return {0, 0, 0};
  return shape_axis(buffers.shapes[shape], Vec3<real>{0, 0, 1});
}

template <class real>
void write_rims(RimBlock<real>& block, u32 lane, Vec3<real> axis_a, Vec3<real> axis_b) {
  block.axis_a_x[lane] = axis_a.x;
  block.axis_a_y[lane] = axis_a.y;
  block.axis_a_z[lane] = axis_a.z;
  block.axis_b_x[lane] = axis_b.x;
  block.axis_b_y[lane] = axis_b.y;
  block.axis_b_z[lane] = axis_b.z;
}

template <class real>
void pack_points(Buffers<real>& buffers, const StepParams<real>&) {
  if (step_aborted(buffers.counters)) return;
  for (u32 block = 0; block < buffers.counters[COUNTER_BLOCKS]; ++block) {
    const BlockBodies& bodies = buffers.block_bodies[block];
    for (u32 k = 0; k < buffers.block_rows[block].count; ++k) {
      const u32 row = buffers.block_rows[block].first + k;
      PointBlock<real>& points = buffers.point_blocks[row];
      StartBlock<real>& starts = buffers.start_blocks[row];
      ImpactBlock<real>* impacts = buffers.impact_blocks.empty() ? nullptr : &buffers.impact_blocks[row];
      AngularFrictionPointBlock<real>* angular_friction_points =
          buffers.angular_friction_points.empty() ? nullptr : &buffers.angular_friction_points[row];
      StaticFrictionBlock<real>* static_friction =
          buffers.static_friction_blocks.empty() ? nullptr : &buffers.static_friction_blocks[row];
      RimBlock<real>* rims = buffers.rim_blocks.empty() ? nullptr : &buffers.rim_blocks[row];
      AnisotropyBlock<real>* anisotropy = buffers.anisotropy_blocks.empty() ? nullptr : &buffers.anisotropy_blocks[row];
      for (u32 lane = 0; lane < PACK; ++lane) {
        if (k >= bodies.count[lane]) {
          write_point(points, starts, lane, ContactPoint<real>{}, NORMAL_FIXED, {}, real(0), real(0),
                      ContactImpulse<real>{});
          if (impacts) write_impact(*impacts, lane, {});
          if (rims) write_rims(*rims, lane, Vec3<real>{0, 0, 0}, Vec3<real>{0, 0, 0});
          if (angular_friction_points) write_angular_friction(*angular_friction_points, lane, {}, Vec4<real>{});
          if (static_friction) write_static_friction(*static_friction, lane, {}, real(0));
          if (anisotropy) write_anisotropy(*anisotropy, lane, {}, Vec3<real>{0, 0, 0});
          continue;
        }
        const u32 i = bodies.contact[lane] + k;
        const Contact& contact = buffers.contacts[i];
        const u32 pair = materials_of(buffers, contact);
        MaterialPair<real> material = buffers.material_pairs[pair];
        if (contact.feature == CORE_FEATURE) material.restitution = 0;
        const real inner =
            pair_radius(buffers.shapes[contact.shape_a].size[3], buffers.shapes[contact.shape_b].size[3]);
        const real bounding =
            pair_radius(solid_radius(buffers.shapes[contact.shape_a]), solid_radius(buffers.shapes[contact.shape_b]));
        write_point(points, starts, lane, buffers.contact_points[i], contact.normal, material, inner, bounding,
                    buffers.start_impulses[i]);
        if (angular_friction_points)
          write_angular_friction(*angular_friction_points, lane, buffers.angular_friction_pairs[pair],
                                 buffers.start_moments[i]);
        if (static_friction)
          write_static_friction(*static_friction, lane, buffers.static_friction_pairs[pair], bounding);
        if (anisotropy)
          write_anisotropy(*anisotropy, lane, buffers.anisotropy_pairs[pair],
                           anisotropy_axis(buffers, contact, buffers.anisotropy_pairs[pair]));
        if (rims) write_rims(*rims, lane, rim_axis(buffers, contact.shape_a), rim_axis(buffers, contact.shape_b));
        if (impacts)
          write_impact(*impacts, lane,
                       contact.feature == CORE_FEATURE ? ImpactPair<real>{} : buffers.impact_pairs[pair]);
      }
    }
  }
}

}  // namespace lockstep::reference
