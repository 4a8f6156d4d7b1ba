// The records of joints: a part of types.h, which includes it in its place.
#ifndef LOCKSTEP_JOINT_TYPES_H
#define LOCKSTEP_JOINT_TYPES_H

// Rows that a joint can lock: linear x, y, z and angular x, y, z in its frame.
#define JOINT_ROWS 6u
// Entries below the diagonal of a matrix of so many rows.
#define JOINT_LOWER 15u
// A bound of the free velocity that bounds nothing, m/s or rad/s.
#define JOINT_UNBOUNDED 1e30f
// Whether of the angles only that about y of a cross is locked: a universal joint's.
#define LOCKS_CROSS(locked) ((locked) >> 3 == 2u)
// Whether its angle is kept from step to step, with its revolutions; those of a screw its travel tells.
#define COUNTS_REVOLUTIONS(info) ((info).free == FREE_ANGLE && (info).kind != JOINT_SCREW)
// Closing takes such an angle no farther than this from where its velocity brings it, rad: far less than half a
// revolution.
#define JOINT_CLOSING_ANGLE 1
// Of a body whose joints stiffen it by k its inertia counts for at least this share of h^2 k; a quarter is what a step
// stands.
#define STIFF_INERTIA_SHARE 0.5f
// Damped against the mean rotation of so many bodies in a row from each of its joints.
#define STIFF_ROW 8u
// Whether nothing but the velocity along an axis of b is locked: a skate's.
#define LOCKS_SKATE(locked) ((locked) == 4u)

#ifndef __cplusplus  // as in types.h
enum JointKind {
#define JOINT_KIND(name, NAME, linear, angular, free, keys, level, reduced, noun, leaves) JOINT_##NAME,
#include "joint_kinds.def"
#undef JOINT_KIND
  JOINT_KINDS
};
#endif

// The coordinate of a joint that limits, a motor, a spring and friction act on.
enum JointFree {
  FREE_NOTHING = 0,  // there is none
  FREE_ANGLE = 1,    // by which b is rotated against a about the axis, with all its revolutions, from how they stood at
                     // load; of a universal joint that of its cross
  FREE_TRAVEL = 2,   // of b's anchor from a's, along the axis
  FREE_LENGTH = 3    // from anchor to anchor
};

// The frame of a joint is fixed in both bodies, and was one at load.
RECORD(Joint) {
  real anchor_a[3];        // from the centre of mass of a, body frame
  real correction;         // share of the error that a sub-step takes back by a velocity
  real anchor_b[3];        // of b
  real softness;           // in parts of the joint's Delassus block; 0 where it is hard
  real frame_a[4];         // joint to body a
  real frame_b[4];         // joint to body b
  real low, high;          // limits of the free coordinate, m or rad; equal ones lock it, or are where its spring rests
  real motor_speed;        // m/s or rad/s, of b against a
  real motor_force;        // N or N m that the motor has at most; 0 without. Dry friction is a motor that wants 0.
                           // Below 0: the spring pushes with motor_speed -+ this, N or N m
  real limited;            // 1 or 0
  real spring;             // 1 where softness is meant, not only a way to solve: it is not relaxed
  real rate;               // of the free coordinate's spring: u + rate (x - low) + compliance r = 0, 1/s
  real spring_compliance;  // 1/kg or 1/(kg m^2); 0 where there is no such spring
  real armature;           // inertia along the free coordinate, kg or kg m^2; 0: none
  // of a spring beside armature or limits, as rate, spring_compliance and low are of one alone
  real side_rate, side_compliance, side_rest;
};

INDEX_RECORD(JointInfo) {
  u32 body_a, body_b;  // the null body (index bodies) for the world
  u32 world;
  u32 id;      // stable and local to the world
  u32 kind;    // JointKind
  u32 locked;  // bit of each locked row
  u32 free;    // JointFree
  u32 direct;  // 1 where its articulation solves it alone, and sweeps leave it out
};

// A block has PACK lanes, a joint each, of one colour: no two share a movable body. Found at load.
INDEX_RECORD(JointLanes) {
  u32 body_a[PACK], body_b[PACK];  // the null body for padding
  u32 joint[PACK];                 // NONE for padding
  u32 free[PACK];                  // JointFree
};

// What a sub-step solves, world frame. Velocities are those of b against a, impulses act on b and their opposite on a,
// at b's anchor.
RECORD(JointBlock) {
  real axes[9][PACK];                    // x, y, z of the joint's frame in a, or of its cross
  real arm_a[3][PACK];                   // from the centre of mass of a to the anchor of b
  real arm_b[3][PACK];                   // from that of b
  real lower[JOINT_LOWER][PACK];         // K = L D L^T of the locked rows, K = J M^-1 J^T: L below its diagonal of ones
  real inverse_pivot[JOINT_ROWS][PACK];  // 1 / D; 0 for rows that are not locked
  real bias[JOINT_ROWS][PACK];           // m/s, rad/s
  real velocity_product[JOINT_ROWS + 1u][PACK];  // J'v h: what their rotation adds; the free row's last
  real softness[PACK];                           // s: u + bias + J'v + s K r = 0
  real spring[PACK];                             // 1 or 0
  real free_axis[3][PACK];
  real coupling[JOINT_ROWS][PACK];  // velocity of each locked row for a unit of the free impulse
  real response[JOINT_ROWS][PACK];  // K^-1 coupling
  real free_mobility[PACK];         // J M^-1 J^T of the free row: its velocity for a unit of its impulse
  real coupled_mobility[PACK];      // coupling . response: how much of free_mobility the locked rows take away
  real motor_speed[PACK];
  real motor_impulse[PACK];           // the motor has at most
  real slowest[PACK], fastest[PACK];  // bounds of the free velocity
  real bound_softness[PACK];          // of these bounds, in parts of free_mobility
  real spring_compliance[PACK];       // of its spring: both bounds are the velocity at which that would not push
  real lead[PACK];                  // of a screw, pitch / 2 pi, m a radian; 0 of others: its row of z is u_z - lead w_z
  real impedance_compliance[PACK];  // of armature and what is beside it: u - impedance_speed + compliance r = 0
  real impedance_speed[PACK];       // at which it would not push; both are 0 where there is none
};

// Kept from step to step: along the axes of the joint's frame in a, or of its cross. Of the free row `free` is what
// bounds, motor and spring give, `impedance` what armature and a spring beside it do.
RECORD(JointImpulseBlock) { real locked[JOINT_ROWS][PACK], free[PACK], impedance[PACK]; };

// What joints have given in the sub-steps of the step so far (feature summed_impulses): the locked rows on b at its
// anchor, world frame, N s and N m s, and the free row along its coordinate.
RECORD(JointSumBlock) { real impulse[3][PACK], moment[3][PACK], free[PACK]; };

// Those of body i are body_joints[body_joint_starts[i]] ... [body_joint_starts[i + 1] - 1], in the order of the joints
// (feature geometric_stiffness). Bodies that cannot move have none.
INDEX_RECORD(BodyJoint) {
  u32 joint;
  u32 slot;  // in the blocks of joints: PACK block + lane
};

// Ties free coordinates x of joints: of their sum, each by its ratio, the limits and the spring are what they are of
// the coordinate of one joint.
RECORD(Coupling) {
  real low, high;         // limits, m or rad; equal ones lock it
  real limited;           // 1 or 0
  real correction;        // share of the error that a sub-step takes back by a velocity
  real softness;          // of limits that are reached, in parts of the coupling's mobility
  real rate, compliance;  // of its spring: u + rate (x - rest) + compliance r = 0; compliance is 0 without
  real rest;
};

INDEX_RECORD(CouplingInfo) {
  u32 first, count;  // of its coupled joints
  u32 world;
  u32 id;  // stable and local to the world
};

INDEX_RECORD(CoupledJoint) {
  u32 joint;
  u32 slot;            // in the blocks of joints: PACK block + lane
  u32 body_a, body_b;  // of the joint
  u32 free;            // JointFree
};

// What a sub-step solves.
RECORD(CouplingRow) {
  real mobility;           // its velocity for a unit of its impulse, as locked rows and impedances of its joints answer
  real relaxed_mobility;   // the same in the relaxing sweep
  real slowest, fastest;   // bounds of its velocity
  real bound_softness;     // in parts of its mobility
  real compliance, speed;  // of its spring: u - speed + compliance r = 0
  real pad;
};

// Kept from step to step: what its bounds and its spring give.
RECORD(CouplingImpulse) { real bound, spring; };

#endif
