#pragma OPENCL FP_CONTRACT OFF
// Writes the law of each joint for a sub-step (cpu_reference/prepare_joints.hpp states it).
#include "common.h"
#include "energy.h"
#include "joints/current_joint.h"
#include "joints/factor.h"
#include "joints/mobility.h"
#include "joints/revolutions.h"
#include "joints/spring_law.h"
#include "sleep.h"
#include "types.h"

#if FEATURE_JOINT_IMPEDANCES
// The row of armature and of the spring beside it.
static inline SpringLaw joint_impedance_law(real armature, SpringLaw spring, real before) {
  if (!(armature > (real)0)) return spring;
  const real compliance = (real)1 / armature;
  SpringLaw law = {-before, compliance};
  if (!(spring.compliance > (real)0)) return law;
  const real both = spring.compliance + compliance, of_armature = spring.compliance / both;
  law.bias = compliance / both * spring.bias - of_armature * before;
  law.compliance = of_armature * compliance;
  return law;
}
#endif

static inline void joint_free_law(const Joint joint, real x, SpringLaw spring, bool counted, real velocity_product,
                                  real dt, u32 lane, global JointBlock* block) {
  real slowest = -(real)JOINT_UNBOUNDED, fastest = (real)JOINT_UNBOUNDED, bound_softness = (real)0;
  if (joint.limited != (real)0) {
    const real above = x - joint.low, below = joint.high - x;
    if (joint.spring_compliance > (real)0) {
      slowest = -spring.bias;
      fastest = slowest;
    } else if (joint.low == joint.high) {
      slowest = -(joint_correction_speed(joint.correction * above, counted, dt) + velocity_product);
      fastest = slowest;
      bound_softness = joint.softness;
    } else {
      slowest = above > (real)0 ? -(above / dt) : -joint_correction_speed(joint.correction * above, counted, dt);
      fastest = below > (real)0 ? below / dt : joint_correction_speed(joint.correction * below, counted, dt);
      bound_softness = above < (real)0 || below < (real)0 ? joint.softness : (real)0;
    }
  }
  block->slowest[lane] = slowest;
  block->fastest[lane] = fastest;
  block->bound_softness[lane] = bound_softness;
}

// The velocities that are foreseen with.
static inline Velocity joint_foreseen_velocity(u32 body, u32 bodies, global const Velocity* previous_velocities,
                                               Motion motion) {
  const Velocity before = joint_velocity_before(body, bodies, previous_velocities);
  return before.damped > (real)0 ? make_velocity(vec3(motion.v), vec3(motion.w)) : before;
}

// The rate of each row at these velocities.
static inline void joint_row_rates(const CurrentJoint* current, const JointInfo info, Velocity a, Velocity b,
                                   real rates[JOINT_ROWS + 1u]) {
  const Vec3 w_a = vec3(a.w), w_b = vec3(b.w);
  const Vec3 on_a = cross3(w_a, current->arm_a), on_b = cross3(w_b, current->arm_b);
  const Vec3 u = sub3(add3(vec3(b.v), on_b), add3(vec3(a.v), on_a));
  Vec3 rate = sub3(sub3(cross3(w_b, on_b), cross3(w_a, on_a)), scale3((real)2, cross3(w_a, u)));
  const Vec3 w = sub3(w_b, w_a);
#if FEATURE_NON_HOLONOMIC
  if (LOCKS_SKATE(info.locked)) rate = sub3(rate, cross3(w, u));
  if (current->radius > (real)0) rate = sub3(rate, cross3(w, cross3(w, scale3(-current->radius, current->axes[2]))));
#endif
  const bool crosses = LOCKS_CROSS(info.locked);
  const Vec3 w_axes = crosses ? add3(w_a, scale3(dot3(current->axes[2], w), current->axes[2])) : w_a;
  const Vec3 angular_rate = cross3(w, w_axes);
  for (u32 i = 0u; i < 3u; ++i) {
    rates[i] = dot3(current->axes[i], rate);
    rates[i + 3u] = dot3(current->axes[i], angular_rate);
  }
  if (current->lead != (real)0) rates[2] = rates[2] - current->lead * rates[5];
  rates[JOINT_ROWS] = dot3(current->free_axis, info.free == FREE_ANGLE ? angular_rate : rate);
  if (info.free == FREE_LENGTH && current->coordinate > (real)0) {
    const real along = dot3(current->free_axis, u);
    rates[JOINT_ROWS] = rates[JOINT_ROWS] + (dot3(u, u) - along * along) / current->coordinate;
  }
}

static inline void joint_write3(Vec3 v, u32 lane, global real (*field)[PACK]) {
  field[0][lane] = v.x;
  field[1][lane] = v.y;
  field[2][lane] = v.z;
}

// All that follows from the geometry; that of padding, and of joints that sleep, is zero.
static inline void joint_write(const CurrentJoint* current, const JointFactor* factor, const real* bias,
                               const real* velocity_product, const real* coupling, const real* response, u32 lane,
                               global JointBlock* block) {
  for (u32 i = 0u; i < 3u; ++i) joint_write3(current->axes[i], lane, block->axes + 3u * i);
  joint_write3(current->arm_a, lane, block->arm_a);
  joint_write3(current->arm_b, lane, block->arm_b);
  joint_write3(current->free_axis, lane, block->free_axis);
  for (u32 i = 0u; i < JOINT_LOWER; ++i) block->lower[i][lane] = factor->lower[i];
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    block->inverse_pivot[i][lane] = factor->inverse_pivot[i];
    block->bias[i][lane] = bias[i];
    block->velocity_product[i][lane] = velocity_product[i];
    block->coupling[i][lane] = coupling[i];
    block->response[i][lane] = response[i];
  }
  block->velocity_product[JOINT_ROWS][lane] = velocity_product[JOINT_ROWS];
}

static inline void joint_clear(u32 lane, global JointBlock* block) {
  const CurrentJoint current = {{{0}}};
  const JointFactor factor = {{0}};
  const real none[JOINT_ROWS + 1u] = {0};
  joint_write(&current, &factor, none, none, none, none, lane, block);
  block->softness[lane] = (real)0;
  block->spring[lane] = (real)0;
  block->free_mobility[lane] = (real)0;
  block->coupled_mobility[lane] = (real)0;
  block->motor_speed[lane] = (real)0;
  block->motor_impulse[lane] = (real)0;
  block->slowest[lane] = (real)0;
  block->fastest[lane] = (real)0;
  block->bound_softness[lane] = (real)0;
  block->spring_compliance[lane] = (real)0;
  block->lead[lane] = (real)0;
  block->impedance_compliance[lane] = (real)0;
  block->impedance_speed[lane] = (real)0;
}

#if FEATURE_JOINTS_AHEAD
static inline void joint_move_on(Velocity velocity, real time, Vec3* x, Quat* q) {
  *x = add3(*x, scale3(time, vec3(velocity.v)));
  *q = integrate_orientation(*q, vec3(velocity.w), time);
}

static inline CurrentJoint joint_with_error_of(CurrentJoint current, CurrentJoint later) {
  for (u32 i = 0u; i < JOINT_ROWS; ++i) later.error[i] = current.error[i];
  later.coordinate = current.coordinate;
  return later;
}
#endif

#if FEATURE_JOINTS_AHEAD || FEATURE_JOINT_IMPEDANCES
// The velocity that the free row had at the start of the sub-step.
static inline real joint_free_velocity_before(global const Velocity* previous_velocities, u32 bodies,
                                              const JointInfo info, const CurrentJoint* current) {
  const Velocity a = joint_velocity_before(info.body_a, bodies, previous_velocities);
  const Velocity b = joint_velocity_before(info.body_b, bodies, previous_velocities);
  const Vec3 w_a = vec3(a.w), w_b = vec3(b.w);
  const Vec3 u = sub3(add3(vec3(b.v), cross3(w_b, current->arm_b)), add3(vec3(a.v), cross3(w_a, current->arm_a)));
  return dot3(current->free_axis, info.free == FREE_ANGLE ? sub3(w_b, w_a) : u);
}
#endif

#if FEATURE_JOINTS_AHEAD
// Adds to the velocity products of locked rows what they moved with before, half of each.
static inline void joint_halve_with_velocities_before(global const Velocity* previous_velocities, u32 bodies,
                                                      const JointInfo info, const CurrentJoint* current,
                                                      real* velocity_product) {
  const Velocity a = joint_velocity_before(info.body_a, bodies, previous_velocities);
  const Velocity b = joint_velocity_before(info.body_b, bodies, previous_velocities);
  const Vec3 w_a = vec3(a.w), w_b = vec3(b.w), w = sub3(w_b, w_a);
  const Vec3 u = sub3(add3(vec3(b.v), cross3(w_b, current->arm_b)), add3(vec3(a.v), cross3(w_a, current->arm_a)));
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    if ((info.locked >> i & 1u) == 0u) continue;
    real before = dot3(current->axes[i % 3u], i < 3u ? u : w);
    if (i == 2u) before = before - current->lead * dot3(current->axes[2], w);
    velocity_product[i] = (real)0.5 * (velocity_product[i] + before);
  }
}
#endif

// What is off at a joint; squares of lengths and of angles.
typedef struct JointMeasure {
  real separation, ratio, angle;
  long energy, kinetic;
} JointMeasure;

// The square of how far a body reaches from its centre of mass: to the anchor, or its least radius of gyration; none of
// one that cannot move.
static inline real joint_body_size(const real* anchor, Motion body) {
  const real trace = body.inertia_xx + body.inertia_yy + body.inertia_zz;
  if (!(body.inverse_mass > (real)0)) return (real)JOINT_UNBOUNDED;
  const real arm = dot3(vec3(anchor), vec3(anchor));
  const real gyration = trace > (real)0 ? (real)3 * body.inverse_mass / trace : (real)0;
  return arm > gyration ? arm : gyration;
}

// How far the free coordinate is beyond its limits.
static inline real joint_beyond(const Joint* joint, const CurrentJoint* current) {
  if (joint->limited == (real)0 || joint->spring_compliance > (real)0) return (real)0;
  const real below = joint->low - current->coordinate, above = current->coordinate - joint->high;
  const real beyond = below > above ? below : above;
  return beyond > (real)0 ? beyond : (real)0;
}

static inline real squared_separation(const JointInfo info, const Joint* joint, const CurrentJoint* current) {
  real sum = (real)0;
  for (u32 i = 0u; i < 3u; ++i) {
    if ((info.locked >> i & 1u) != 0u) sum = sum + current->error[i] * current->error[i];
  }
  const real beyond = info.free == FREE_ANGLE ? (real)0 : joint_beyond(joint, current);
  return sum + beyond * beyond;
}

static inline void joint_add_spring(const StepParams* params, const CurrentJoint* current, real rate, real compliance,
                                    real rest, JointMeasure* measure) {
  if (!(compliance > (real)0)) return;
  const real stretch = current->coordinate - rest;
  const real stiffness = rate / (compliance * params->dt);
  measure->energy += energy_units((real)0.5 * stiffness * (stretch * stretch), params->units_per_joule);
}

static inline void measure_joint(const StepParams* params, const JointInfo info, const Joint* joint,
                                 const CurrentJoint* current, Motion a, Motion b, JointMeasure* measure) {
  const real separation = squared_separation(info, joint, current);
  const real size_a = joint_body_size(joint->anchor_a, a), size_b = joint_body_size(joint->anchor_b, b);
  const real size = size_a < size_b ? size_a : size_b;
  const real ratio = size > (real)0 ? separation / size : (real)0;
  const real beyond = info.free == FREE_ANGLE ? joint_beyond(joint, current) : (real)0;
  real angle = beyond * beyond;
  for (u32 i = 3u; i < JOINT_ROWS; ++i) {
    if ((info.locked >> i & 1u) != 0u) angle = angle + current->error[i] * current->error[i];
  }
  measure->separation = separation > measure->separation ? separation : measure->separation;
  measure->ratio = ratio > measure->ratio ? ratio : measure->ratio;
  measure->angle = angle > measure->angle ? angle : measure->angle;
  if (!(joint->motor_force < (real)0))  // one of bounded force keeps no energy
    joint_add_spring(params, current, joint->rate, joint->spring_compliance, joint->low, measure);
#if FEATURE_JOINT_IMPEDANCES
  joint_add_spring(params, current, joint->side_rate, joint->side_compliance, joint->side_rest, measure);
#endif
}

#if FEATURE_JOINT_IMPEDANCES
// The energy of motion that armature has, at the start of the sub-step.
static inline void measure_armature(const StepParams* params, const JointInfo info, real armature,
                                    const CurrentJoint* current, global const Velocity* previous_velocities,
                                    JointMeasure* measure) {
  if (!(armature > (real)0)) return;
  const real u = joint_free_velocity_before(previous_velocities, params->bodies, info, current);
  const long units = energy_units((real)0.5 * armature * (u * u), params->units_per_joule);
  measure->energy += units;
  measure->kinetic += units;
}
#endif

static inline void prepare_joint(const StepParams* params, const JointInfo info, const Joint joint, JointSizes sizes,
                                 global const Velocity* previous_velocities, global real* joint_angles, u32 index,
                                 Vec3 x_a, Quat q_a, Vec3 x_b, Quat q_b, Motion a, Motion b, u32 lane,
                                 global JointBlock* block, JointMeasure* measure) {
  const Velocity going_a = joint_foreseen_velocity(info.body_a, params->bodies, previous_velocities, a);
  const Velocity going_b = joint_foreseen_velocity(info.body_b, params->bodies, previous_velocities, b);
  const Vec3 w_a = vec3(going_a.w), w_b = vec3(going_b.w);
  const real angle = params->dt * params->dt * (dot3(w_a, w_a) + dot3(w_b, w_b));
  const real foreseen = params->dt / ((real)1 + angle);
  CurrentJoint current = current_joint(joint, info.locked, info.free, sizes, x_a, q_a, x_b, q_b);
  count_revolutions(info, joint_angles, index, params->dt, a, b, &current);
  if (counts_revolutions(info)) joint_angles[index] = current.coordinate;
  if (params->substep == 0u && joint.spring == (real)0) measure_joint(params, info, &joint, &current, a, b, measure);
#if FEATURE_JOINT_IMPEDANCES
  if (params->substep == 0u) measure_armature(params, info, joint.armature, &current, previous_velocities, measure);
#endif
#if FEATURE_JOINTS_AHEAD
  const real lead_time = ((real)1 - params->theta) * foreseen;
  joint_move_on(going_a, lead_time, &x_a, &q_a);
  joint_move_on(going_b, lead_time, &x_b, &q_b);
  current = joint_with_error_of(current, current_joint(joint, info.locked, info.free, sizes, x_a, q_a, x_b, q_b));
#endif
  real k[JOINT_ROWS][JOINT_ROWS], column[JOINT_ROWS], free_mobility;
  joint_mobility(&current, info.free == FREE_ANGLE, a, b, k, column, &free_mobility);
  JointFactor factor;
  factorise(k, info.locked, &factor);

  const bool is_free = info.free != FREE_NOTHING;
  real velocity_product[JOINT_ROWS + 1u];
  joint_row_rates(&current, info, going_a, going_b, velocity_product);
  const real ahead = (real)0.5 * foreseen;
  real bias[JOINT_ROWS], coupling[JOINT_ROWS], response[JOINT_ROWS];
  for (u32 i = 0u; i < JOINT_ROWS; ++i) {
    const bool locked = (info.locked >> i & 1u) != 0u;
    bias[i] = locked ? joint.correction * current.error[i] / params->dt : (real)0;
    velocity_product[i] = locked ? ahead * velocity_product[i] : (real)0;
    coupling[i] = locked && is_free ? column[i] : (real)0;
    response[i] = coupling[i];
  }
#if FEATURE_JOINT_IMPEDANCES
  const bool rotates = info.free != FREE_ANGLE || LOCKS_CROSS(info.locked);
  const real free_product = rotates ? foreseen * velocity_product[JOINT_ROWS] : (real)0;
#endif
  const bool equal = joint.limited != (real)0 && joint.low == joint.high && !(joint.spring_compliance > (real)0);
  velocity_product[JOINT_ROWS] = equal ? ahead * velocity_product[JOINT_ROWS] : (real)0;
#if FEATURE_JOINTS_AHEAD
  if (params->theta == (real)0.5f)
    joint_halve_with_velocities_before(previous_velocities, params->bodies, info, &current, velocity_product);
#endif
  solve_factor(&factor, response);
  real coupled_mobility = (real)0;
  for (u32 i = 0u; i < JOINT_ROWS; ++i) coupled_mobility = coupled_mobility + coupling[i] * response[i];

  joint_write(&current, &factor, bias, velocity_product, coupling, response, lane, block);
  block->softness[lane] = joint.softness;
  block->spring[lane] = joint.spring;
  block->free_mobility[lane] = is_free ? free_mobility : (real)0;
  block->coupled_mobility[lane] = coupled_mobility;
  const bool bounds_spring = joint.motor_force < (real)0;
  block->motor_speed[lane] = bounds_spring ? joint.motor_speed * params->dt : joint.motor_speed;
  block->motor_impulse[lane] = joint.motor_force * params->dt;
  block->lead[lane] = sizes.lead;
  real before = (real)0;
#if FEATURE_JOINTS_AHEAD || FEATURE_JOINT_IMPEDANCES
  before = joint_free_velocity_before(previous_velocities, params->bodies, info, &current);
#endif
  real mobility = (is_free ? free_mobility : (real)0) - coupled_mobility;
  SpringLaw impedance = {(real)0, (real)0};
#if FEATURE_JOINT_IMPEDANCES
  if (joint.armature > (real)0) mobility = mobility / ((real)1 + joint.armature * mobility);
  impedance = joint_spring_law(joint.side_rate, joint.side_compliance, params, current.coordinate - joint.side_rest,
                               mobility, before);
  impedance = joint_impedance_law(joint.armature, impedance, before - free_product);
#endif
  block->impedance_compliance[lane] = impedance.compliance;
  block->impedance_speed[lane] = impedance.compliance > (real)0 ? -impedance.bias : (real)0;
  const SpringLaw spring =
      joint_spring_law(joint.rate, joint.spring_compliance, params, current.coordinate - joint.low, mobility, before);
  block->spring_compliance[lane] = spring.compliance;
  joint_free_law(joint, current.coordinate, spring, counts_revolutions(info), velocity_product[JOINT_ROWS], params->dt,
                 lane, block);
}

kernel void prepare_joints(const StepParams params, global const Vec4* positions, global const Vec4* orientations,
                           global const Motion* motions, global const Velocity* previous_velocities,
                           global const Sleeper* sleepers, global const JointInfo* joint_infos,
                           global const Joint* joints, global const real* screw_leads, global const real* rolling_radii,
                           global const JointLanes* joint_lanes, global JointBlock* joint_blocks,
                           global real* joint_angles, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  JointMeasure measure = {(real)0, (real)0, (real)0, 0, 0};
  FOR_EACH(slot, params.joint_blocks * PACK) {
    const u32 lane = slot % PACK, index = joint_lanes[slot / PACK].joint[lane];
    global JointBlock* block = joint_blocks + slot / PACK;
    if (index == NONE || joint_sleeps(joint_infos[index], params.bodies, sleepers)) {
      joint_clear(lane, block);
      continue;
    }
    const JointInfo info = joint_infos[index];
    Vec3 x_a, x_b;
    Quat q_a, q_b;
    joint_pose(info.body_a, params.bodies, positions, orientations, &x_a, &q_a);
    joint_pose(info.body_b, params.bodies, positions, orientations, &x_b, &q_b);
    prepare_joint(&params, info, joints[index], joint_sizes(screw_leads, rolling_radii, index), previous_velocities,
                  joint_angles, index, x_a, q_a, x_b, q_b, motions[info.body_a], motions[info.body_b], lane, block,
                  &measure);
  }
  if (params.substep != 0u) return;
  raise_maximum(counters, COUNTER_MAX_JOINT_SEPARATION, sqrt(measure.separation));
  raise_maximum(counters, COUNTER_MAX_JOINT_SEPARATION_RATIO, sqrt(measure.ratio));
  raise_maximum(counters, COUNTER_MAX_JOINT_ANGLE, sqrt(measure.angle));
  add_energy(counters, COUNTER_ENERGY, measure.energy);
#if FEATURE_JOINT_IMPEDANCES
  add_energy(counters, COUNTER_KINETIC, measure.kinetic);
#endif
}
