#pragma OPENCL FP_CONTRACT OFF
// Lays what a sub-step needs of each contact beside its lane (cpu_reference/pack_points.hpp).
#include "common.h"
#include "math.h"
#include "tolerances.h"
#include "types.h"

static inline void pack_point(u32 lane, const ContactPoint point, u32 frame, real friction, real restitution,
                              real inner_radius, real bounding_radius, const ContactImpulse start,
                              global PointBlock* block, global StartBlock* starts) {
  block->anchor_a_x[lane] = point.anchor_a[0];
  block->anchor_a_y[lane] = point.anchor_a[1];
  block->anchor_a_z[lane] = point.anchor_a[2];
  block->radius_a[lane] = point.radius_a;
  block->anchor_b_x[lane] = point.anchor_b[0];
  block->anchor_b_y[lane] = point.anchor_b[1];
  block->anchor_b_z[lane] = point.anchor_b[2];
  block->radius_b[lane] = point.radius_b;
  block->normal_x[lane] = point.normal[0];
  block->normal_y[lane] = point.normal[1];
  block->normal_z[lane] = point.normal[2];
  block->friction[lane] = friction;
  block->restitution[lane] = restitution;
  block->inner_radius[lane] = inner_radius;
  block->bounding_radius[lane] = bounding_radius;
  block->frame[lane] = frame;
  starts->normal[lane] = start.normal;
  starts->tangent_x[lane] = start.tangent_x;
  starts->tangent_y[lane] = start.tangent_y;
  starts->tangent_z[lane] = start.tangent_z;
}

#if FEATURE_ANGULAR_FRICTION
static inline void pack_angular_friction(u32 lane, AngularFrictionPair pair, Vec4 moment,
                                         global AngularFrictionPointBlock* block) {
  block->torsion_radius[lane] = pair.torsion_radius;
  block->rolling_coefficient[lane] = pair.rolling_coefficient;
  block->moment_x[lane] = moment.x;
  block->moment_y[lane] = moment.y;
  block->moment_z[lane] = moment.z;
}
#endif

#if FEATURE_STATIC_FRICTION
static inline void pack_static_friction(u32 lane, StaticFrictionPair pair, real bounding_radius,
                                        global StaticFrictionBlock* block) {
  block->friction[lane] = pair.friction;
  block->speed[lane] = pair.speed + pair.speed_share * bounding_radius;
}
#endif

// An axis of a shape in the frame of its body.
static inline Vec3 shape_axis(global const Shape* shape, Vec3 axis) {
  return rotate3(make4(shape->rotation[0], shape->rotation[1], shape->rotation[2], shape->rotation[3]), axis);
}

#if FEATURE_ELLIPTIC_FRICTION
static inline void pack_anisotropy(u32 lane, AnisotropyPair pair, Vec3 along, global AnisotropyBlock* block) {
  block->x[lane] = along.x;
  block->y[lane] = along.y;
  block->z[lane] = along.z;
  block->across[lane] = pair.across;
  block->side[lane] = pair.side;
  block->perpendicular[lane] = pair.perpendicular;
}

// The axis of anisotropy, the x axis of the shape whose it is, in the frame of its body.
static inline Vec3 pack_along(global const Shape* shape) { return shape_axis(shape, make3((real)1, (real)0, (real)0)); }
#endif

#if FEATURE_SEPARATED_CONTACTS && FEATURE_CYLINDERS
// The axis of a cylinder in the frame of its body, 0 of another shape.
static inline Vec3 pack_rim_axis(u32 kind, global const Shape* shape) {
  const Vec3 axis = shape_axis(shape, make3((real)0, (real)0, (real)1)), none = make3((real)0, (real)0, (real)0);
  return kind == SHAPE_CYLINDER ? axis : none;
}

static inline void pack_rims(u32 lane, Vec3 axis_a, Vec3 axis_b, global RimBlock* block) {
  block->axis_a_x[lane] = axis_a.x;
  block->axis_a_y[lane] = axis_a.y;
  block->axis_a_z[lane] = axis_a.z;
  block->axis_b_x[lane] = axis_b.x;
  block->axis_b_y[lane] = axis_b.y;
  block->axis_b_z[lane] = axis_b.z;
}
#endif

kernel void pack_points(global const WorldRange* world_ranges, global const ShapeInfo* shape_infos,
                        global const MaterialPair* material_pairs, global const ImpactPair* impact_pairs,
                        global const AngularFrictionPair* angular_friction_pairs,
                        global const StaticFrictionPair* static_friction_pairs,
                        global const AnisotropyPair* anisotropy_pairs, global const Shape* shapes,
                        global const Contact* contacts, global const ContactPoint* contact_points,
                        global const ContactImpulse* start_impulses, global const Vec4* start_moments,
                        global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                        global PointBlock* point_blocks, global RimBlock* rim_blocks, global StartBlock* start_blocks,
                        global ImpactBlock* impact_blocks, global AngularFrictionPointBlock* angular_friction_points,
                        global StaticFrictionBlock* static_friction_blocks, global AnisotropyBlock* anisotropy_blocks,
                        global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  const ContactPoint no_point = {
      {(real)0, (real)0, (real)0}, (real)0, {(real)0, (real)0, (real)0}, (real)0, {(real)0, (real)0, (real)0, (real)0}};
  const ContactImpulse no_impulse = {(real)0, (real)0, (real)0, (real)0};
  FOR_EACH(slot, counters[COUNTER_BLOCKS] * PACK) {
    const u32 lane = slot % PACK, count = block_bodies[slot / PACK].count[lane];
    const u32 first = block_bodies[slot / PACK].contact[lane];
    const BlockRows rows = block_rows[slot / PACK];
    for (u32 k = 0u; k < count; ++k) {
      const Contact contact = contacts[first + k];
      const WorldRange world = world_ranges[contact.world];
      const u32 materials = world.first_material_pair + shape_infos[contact.shape_a].material * world.material_count +
                            shape_infos[contact.shape_b].material;
      const MaterialPair pair = material_pairs[materials];
#if FEATURE_CONTINUOUS
      const real restitution = contact.feature == CORE_FEATURE ? (real)0 : pair.restitution;
#else
      const real restitution = pair.restitution;
#endif
      const real inner_radius = pair_radius(shapes[contact.shape_a].size[3], shapes[contact.shape_b].size[3]);
      const real bounding_radius =
          pair_radius(solid_radius(shapes + contact.shape_a), solid_radius(shapes + contact.shape_b));
      pack_point(lane, contact_points[first + k], contact.normal, pair.friction, restitution, inner_radius,
                 bounding_radius, start_impulses[first + k], point_blocks + rows.first + k,
                 start_blocks + rows.first + k);
#if FEATURE_SEPARATED_CONTACTS && FEATURE_CYLINDERS
      pack_rims(lane, pack_rim_axis(shape_infos[contact.shape_a].kind, shapes + contact.shape_a),
                pack_rim_axis(shape_infos[contact.shape_b].kind, shapes + contact.shape_b),
                rim_blocks + rows.first + k);
#endif
#if FEATURE_ANGULAR_FRICTION
      pack_angular_friction(lane, angular_friction_pairs[materials], start_moments[first + k],
                            angular_friction_points + rows.first + k);
#endif
#if FEATURE_STATIC_FRICTION
      pack_static_friction(lane, static_friction_pairs[materials], bounding_radius,
                           static_friction_blocks + rows.first + k);
#endif
#if FEATURE_ELLIPTIC_FRICTION
      const AnisotropyPair anisotropy = anisotropy_pairs[materials];
      pack_anisotropy(lane, anisotropy,
                      pack_along(shapes + (anisotropy.side == 0u ? contact.shape_a : contact.shape_b)),
                      anisotropy_blocks + rows.first + k);
#endif
#if FEATURE_IMPACT_LAWS
      const ImpactPair impact = impact_pairs[materials];
#if FEATURE_CONTINUOUS
      const bool bounces = contact.feature != CORE_FEATURE;
#else
      const bool bounces = true;
#endif
      global ImpactBlock* impacts = impact_blocks + rows.first + k;
      impacts->tangential_restitution[lane] = bounces ? impact.tangential_restitution : (real)0;
      impacts->law[lane] = bounces ? impact.law : (u32)IMPACT_NEWTON;
#endif
    }
    for (u32 k = count; k < rows.count; ++k) {
      pack_point(lane, no_point, NORMAL_FIXED, (real)0, (real)0, (real)0, (real)0, no_impulse,
                 point_blocks + rows.first + k, start_blocks + rows.first + k);
#if FEATURE_SEPARATED_CONTACTS && FEATURE_CYLINDERS
      const Vec3 no_axis = make3((real)0, (real)0, (real)0);
      pack_rims(lane, no_axis, no_axis, rim_blocks + rows.first + k);
#endif
#if FEATURE_ANGULAR_FRICTION
      const AngularFrictionPair free = {(real)0, (real)0};
      const Vec4 no_moment = {(real)0, (real)0, (real)0, (real)0};
      pack_angular_friction(lane, free, no_moment, angular_friction_points + rows.first + k);
#endif
#if FEATURE_STATIC_FRICTION
      const StaticFrictionPair none = {(real)0, (real)0, (real)0};
      pack_static_friction(lane, none, (real)0, static_friction_blocks + rows.first + k);
#endif
#if FEATURE_ELLIPTIC_FRICTION
      const AnisotropyPair isotropic = {(real)0, 0u, 0u};
      pack_anisotropy(lane, isotropic, make3((real)0, (real)0, (real)0), anisotropy_blocks + rows.first + k);
#endif
#if FEATURE_IMPACT_LAWS
      impact_blocks[rows.first + k].tangential_restitution[lane] = (real)0;
      impact_blocks[rows.first + k].law[lane] = (u32)IMPACT_NEWTON;
#endif
    }
  }
}
