// The records of articulations: trees of movable bodies that joints hold together. A part of types.h, which includes it
// in its place.
#ifndef LOCKSTEP_ARTICULATION_TYPES_H
#define LOCKSTEP_ARTICULATION_TYPES_H

#include "joint_types.h"

// Rows of a joint that an articulation solves: the locked ones, and behind them the free one where a spring acts on it
// or it is locked too.
#define LINK_ROWS (JOINT_ROWS + 1u)
// Entries on and below the diagonal of a symmetric matrix of a body's six velocities, and of so many rows.
#define LINK_ENTRIES 21u
#define ROW_ENTRIES 28u

// Links are numbered level by level: a body that nothing movable holds is one at level 0, and those that joints hold to
// it are at the next. Found at load.
INDEX_RECORD(Articulation) {
  u32 first_level, level_count;  // link_levels[level] is the first link of a level
  u32 root;                      // a body: where it sleeps all do
  u32 pad;
};

INDEX_RECORD(LinkInfo) {
  u32 body;
  u32 parent;                    // a link; NONE where what holds it cannot move, or nothing does
  u32 joint;                     // that holds it; NONE where it floats
  u32 slot;                      // of the joint: of its block and lane
  u32 first_child, child_count;  // links
  u32 is_b;                      // 1 where it is body b of the joint
  u32 pad;
};

// A joint that closes a loop: between two links, or between one and what cannot move. It is measured like the joint of
// a link that is its body b and whose parent is its body a.
INDEX_RECORD(ClosureInfo) {
  u32 joint, slot;
  u32 link_a, link_b;  // its bodies; NONE of what cannot move
};

// Joints that close loops of an articulation and are solved with it: none where there are more than MAX_CLOSURES.
#define MAX_CLOSURES 16u
#define CLOSURE_STRIDE (MAX_CLOSURES * LINK_ROWS)  // of the rows of their matrix

INDEX_RECORD(ClosureSet) {
  u32 first, count;
  u32 first_column;  // less the first link of the articulation: of the answers to each row, one for each link
  u32 links;         // of the articulation
};

// A link and its joint in a sub-step. Velocities are those of the link against its parent, impulses act on the link and
// their opposite on the parent, at the joint. World frame.
RECORD(LinkFactor) {
  real axes[3][3];                       // x, y, z of the joint's frame
  real arm[3], parent_arm[3];            // from the centres of mass to where the impulses act
  real free_linear[3], free_angular[3];  // the free row: its axis is one of them, the other is zero
  real lead;                             // of a screw: its row of z is u_z - lead w_z
  real spring_compliance;                // of the free row's spring, or its impedance
  real impedance;                        // 1 where the free row is that of an impedance, 0 elsewhere
  real error[LINK_ROWS];                 // m/s and rad/s; where joints are closed m and rad
  real inertia[LINK_ENTRIES];            // of all that hangs on the link: L D L^T, L below the diagonal, 1/D on it
  real mobility[ROW_ENTRIES];            // of the rows, with the parent held; 0 on the diagonal of those that are not
  real onto_parent[LINK_ENTRIES];        // what the parent feels of that inertia
};

// What a solve hands up and down.
RECORD(LinkMotion) {
  real force[6];           // N s and N m s about the centre of mass: what the children ask
  real wanted[LINK_ROWS];  // velocity of the rows with the parent held, m/s and rad/s
  real effort[6];          // impulse and moment of the rows at the joint: with the parent held, then as it moves
  real change[6];          // of the velocity
  real push[6];            // what joints that close loops push with, about the centre of mass
};

#endif
