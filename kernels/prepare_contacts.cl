#pragma OPENCL FP_CONTRACT OFF
// Writes the packed constraint stream of a sub-step (cpu_reference/prepare_contacts.hpp states the law).
#include "common.h"
#include "contact_now.h"
#include "frame.h"
#include "rigid_body.h"
#include "types.h"

static inline real prepare_bias(const StepParams p, real gap, real u_old, real u_free, real restitution, bool* soft) {
  const real gap_free = gap + p.dt * (((real)1 - p.theta) * u_old + p.theta * u_free);
  real bias;
  *soft = !(gap > (real)0);
  if (gap > (real)0) {
    bias = p.theta > (real)0 ? (gap / p.dt + ((real)1 - p.theta) * u_old) / p.theta : gap / p.dt + u_old;
    bias = bias > (real)0 ? bias : (real)0;
  } else {
    const real depth = -gap - p.slop;
    const real speed = p.correction * (depth > (real)0 ? depth : (real)0) / p.dt;
    bias = -(speed < p.correction_limit ? speed : p.correction_limit);
  }
  if (restitution > (real)0 && u_old < -p.restitution_threshold && gap_free < (real)0) {
    const real bounce = restitution * u_old;
    const real push_out = gap > (real)0 ? (real)0 : bias;
    if (bounce < push_out) *soft = false;
    bias = bounce < push_out ? bounce : push_out;
  }
  return bias;
}

static inline Vec3 prepare_central_arm(real inverse_mass, Vec3 normal, Vec3 arm) {
  return inverse_mass > (real)0 ? scale3(dot3(normal, arm), normal) : arm;
}

static inline Vec3 prepare_normal(global const ContactBlock* block, u32 lane) {
  return make3(block->normal_x[lane], block->normal_y[lane], block->normal_z[lane]);
}

// The velocity of a body at the end of an arm.
static inline Vec3 prepare_point_velocity(Vec3 v, Vec3 w, Vec3 arm) { return add3(v, cross3(w, arm)); }

static inline void prepare_write(u32 lane, Vec3 n, Vec3 arm_a, Vec3 arm_b, real bias, real friction,
                                 global ContactBlock* block) {
  block->normal_x[lane] = n.x;
  block->normal_y[lane] = n.y;
  block->normal_z[lane] = n.z;
  block->arm_a_x[lane] = arm_a.x;
  block->arm_a_y[lane] = arm_a.y;
  block->arm_a_z[lane] = arm_a.z;
  block->arm_b_x[lane] = arm_b.x;
  block->arm_b_y[lane] = arm_b.y;
  block->arm_b_z[lane] = arm_b.z;
  block->bias[lane] = bias;
  block->friction[lane] = friction;
}

static inline void prepare_write_delassus(u32 lane, real w_nn, real w_11, real w_22, real w_n1, real w_n2, real w_12,
                                          global ContactBlock* block) {
  block->w_nn[lane] = w_nn;
  block->w_11[lane] = w_11;
  block->w_22[lane] = w_22;
  block->w_n1[lane] = w_n1;
  block->w_n2[lane] = w_n2;
  block->w_12[lane] = w_12;
}

#if FEATURE_GENERAL_CONTACTS
static inline Vec3 prepare_spin(Motion body, Vec3 moment) {
  return make3(body.inertia_xx * moment.x + body.inertia_xy * moment.y + body.inertia_xz * moment.z,
               body.inertia_xy * moment.x + body.inertia_yy * moment.y + body.inertia_yz * moment.z,
               body.inertia_xz * moment.x + body.inertia_yz * moment.y + body.inertia_zz * moment.z);
}

static inline real prepare_share(Motion a, Motion b, Vec3 arm_a, Vec3 arm_b, Vec3 d, Vec3 e) {
  return dot3(cross3(arm_a, d), prepare_spin(a, cross3(arm_a, e))) +
         dot3(cross3(arm_b, d), prepare_spin(b, cross3(arm_b, e)));
}
#endif

// The impulse to start from, put back into the cone over the turned frame.
static inline void prepare_impulse(real normal, Vec3 tangent, Vec3 t1, Vec3 t2, real friction, u32 lane,
                                   global ImpulseBlock* impulses) {
  normal = normal > (real)0 ? normal : (real)0;
  const real tangent_1 = dot3(tangent, t1), tangent_2 = dot3(tangent, t2);
  const real length = sqrt(tangent_1 * tangent_1 + tangent_2 * tangent_2);
  const real limit = friction * normal;
  const real scale = length > limit ? limit / length : (real)1;
  impulses->normal[lane] = normal;
  impulses->tangent_1[lane] = scale * tangent_1;
  impulses->tangent_2[lane] = scale * tangent_2;
}

// The law of contact i between bodies a and b, in a lane of its row. Returns its softness.
static inline real prepare_contact(const StepParams params, u32 i, u32 central, u32 lane,
                                   global const WorldRange* world_ranges, global const ShapeInfo* shape_infos,
                                   global const MaterialPair* material_pairs, global const Contact* contacts,
                                   global const ContactPoint* contact_points,
                                   global const ContactImpulse* start_impulses, Pose pose_a, Pose pose_b,
                                   Motion motion_a, Motion motion_b, Velocity old_a, Velocity old_b,
                                   global ContactBlock* block, global ImpulseBlock* impulses) {
  const Contact contact = contacts[i];
  const ContactNow now = contact_now(contact_points + i, contact.normal, pose_a, pose_b);
  const Vec3 n = now.normal;
  Vec3 t1, t2;
  tangents(n, &t1, &t2);
  const Vec3 arm_a = central ? prepare_central_arm(motion_a.inverse_mass, n, now.arm_a) : now.arm_a;
  const Vec3 arm_b = central ? prepare_central_arm(motion_b.inverse_mass, n, now.arm_b) : now.arm_b;

  const real u_old = dot3(n, sub3(prepare_point_velocity(vec3(old_a.v), vec3(old_a.w), arm_a),
                                  prepare_point_velocity(vec3(old_b.v), vec3(old_b.w), arm_b)));
  const real u_free = dot3(n, sub3(prepare_point_velocity(vec3(motion_a.v), vec3(motion_a.w), arm_a),
                                   prepare_point_velocity(vec3(motion_b.v), vec3(motion_b.w), arm_b)));
  const WorldRange world = world_ranges[contact.world];
  const MaterialPair pair =
      material_pairs[world.first_material_pair + shape_infos[contact.shape_a].material * world.material_count +
                     shape_infos[contact.shape_b].material];

  // before the block is overwritten: from sub-step to sub-step the impulse comes from there
  if (params.substep == 0u) {
    const ContactImpulse start = start_impulses[i];
    prepare_impulse(start.normal, make3(start.tangent_x, start.tangent_y, start.tangent_z), t1, t2, pair.friction, lane,
                    impulses);
  } else {
    Vec3 old_t1, old_t2;
    tangents(prepare_normal(block, lane), &old_t1, &old_t2);
    const Vec3 tangent = add3(scale3(impulses->tangent_1[lane], old_t1), scale3(impulses->tangent_2[lane], old_t2));
    prepare_impulse(impulses->normal[lane], tangent, t1, t2, pair.friction, lane, impulses);
  }

#if FEATURE_CONTINUOUS
  const real restitution = contact.feature == CORE_FEATURE ? (real)0 : pair.restitution;
#else
  const real restitution = pair.restitution;
#endif
  bool soft;
  const real bias = prepare_bias(params, now.gap, u_old, u_free, restitution, &soft);
  prepare_write(lane, n, arm_a, arm_b, bias, pair.friction, block);
  const real inverse_mass = motion_a.inverse_mass + motion_b.inverse_mass;
  real w_nn = inverse_mass;
  if (central) {
    const real w_11 =
        inverse_mass + dot3(arm_a, arm_a) * motion_a.inertia_xx + dot3(arm_b, arm_b) * motion_b.inertia_xx;
    prepare_write_delassus(lane, inverse_mass, w_11, w_11, (real)0, (real)0, (real)0, block);
  }
#if FEATURE_GENERAL_CONTACTS
  if (!central) {
    w_nn = inverse_mass + prepare_share(motion_a, motion_b, arm_a, arm_b, n, n);
    prepare_write_delassus(lane, w_nn, inverse_mass + prepare_share(motion_a, motion_b, arm_a, arm_b, t1, t1),
                           inverse_mass + prepare_share(motion_a, motion_b, arm_a, arm_b, t2, t2),
                           prepare_share(motion_a, motion_b, arm_a, arm_b, n, t1),
                           prepare_share(motion_a, motion_b, arm_a, arm_b, n, t2),
                           prepare_share(motion_a, motion_b, arm_a, arm_b, t1, t2), block);
  }
#endif
  return soft ? params.softness * w_nn : (real)0;
}

static inline void prepare_padding(u32 lane, global ContactBlock* block, global ImpulseBlock* impulses) {
  const Vec3 zero = make3((real)0, (real)0, (real)0);
  prepare_write(lane, zero, zero, zero, (real)0, (real)0, block);
  prepare_write_delassus(lane, (real)0, (real)0, (real)0, (real)0, (real)0, (real)0, block);
  prepare_impulse((real)0, zero, zero, zero, (real)0, lane, impulses);
}

kernel void prepare_contacts(const StepParams params, global const WorldRange* world_ranges,
                             global const ShapeInfo* shape_infos, global const MaterialPair* material_pairs,
                             global const Vec4* positions, global const Vec4* orientations,
                             global const Motion* motions, global const Velocity* previous_velocities,
                             global const Contact* contacts, global const ContactPoint* contact_points,
                             global const ContactImpulse* start_impulses, global const BlockBodies* block_bodies,
                             global const BlockRows* block_rows, global ContactBlock* contact_blocks,
                             global ImpulseBlock* impulse_blocks, global SoftnessBlock* softness_blocks,
                             global const u32* counters) {
  if (STEP_IS_VOID(counters)) return;
  FOR_EACH(slot, counters[COUNTER_BLOCKS] * PACK) {
    const u32 lane = slot % PACK;
    global const BlockBodies* bodies = block_bodies + slot / PACK;
    const BlockRows rows = block_rows[slot / PACK];
    const u32 count = bodies->count[lane];
    if (count > 0u) {
      const u32 a = bodies->body_a[lane], b = bodies->body_b[lane];
      const Pose pose_a = make_pose(positions[a], orientations[a]), pose_b = make_pose(positions[b], orientations[b]);
      const Motion motion_a = motions[a], motion_b = motions[b];
      const Velocity old_a = previous_velocities[a], old_b = previous_velocities[b];
      for (u32 k = 0u; k < count; ++k) {
        const real softness = prepare_contact(params, bodies->contact[lane] + k, bodies->kind[lane] == BLOCK_CENTRAL,
                                              lane, world_ranges, shape_infos, material_pairs, contacts, contact_points,
                                              start_impulses, pose_a, pose_b, motion_a, motion_b, old_a, old_b,
                                              contact_blocks + rows.first + k, impulse_blocks + rows.first + k);
#if FEATURE_SOFT_CONTACTS
        softness_blocks[rows.first + k].softness[lane] = softness;
#endif
      }
    }
    for (u32 k = count; k < rows.count; ++k) {
      prepare_padding(lane, contact_blocks + rows.first + k, impulse_blocks + rows.first + k);
#if FEATURE_SOFT_CONTACTS
      softness_blocks[rows.first + k].softness[lane] = (real)0;
#endif
    }
  }
}
