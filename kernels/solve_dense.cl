#pragma OPENCL FP_CONTRACT OFF
// Gauss-Seidel in the order of the list of contacts, by the dense Delassus matrix (cpu_reference/solve_dense.hpp).
#include "common.h"
#include "dense/dense_sweep.h"
#include "joints/solve_joint.h"
#include "start_contacts.h"
#include "types.h"

// Once a sub-step: all blocks, an item LANES rows of a pair of tiles.
kernel void dense_matrix(global const Contact* contacts, global const u32* contact_slots,
                         global const ContactBlock* contact_blocks, global const Motion* motions,
                         global const ContactTile* contact_tiles, global const CoupledTiles* coupled_tiles,
                         global DenseBlock* dense_blocks, global const u32* counters) {
  if (STEP_ABORTED(counters)) return;
  FOR_EACH(item, counters[COUNTER_COUPLED_TILES_NEEDED] * ITEMS_PER_BLOCK) {
    const u32 pair = item / ITEMS_PER_BLOCK, first = item % ITEMS_PER_BLOCK * LANES;
    const ContactTile column = contact_tiles[coupled_tiles[pair].column];
    DenseRows rows;
    dense_load_rows(contact_tiles[coupled_tiles[pair].row], first, contacts, contact_slots, contact_blocks, &rows);
    for (u32 k = 0u; k < column.count; ++k) {
      dense_column(k, column.first + k, first, &rows, contacts, contact_slots, contact_blocks, motions,
                   dense_blocks + pair);
    }
  }
}

// Relative velocities and impulses, as bodies and contacts have them.
kernel void dense_measure(const StepParams params, global const Contact* contacts, global const u32* contact_slots,
                          global const ContactBlock* contact_blocks, global const SlideBlock* slide_blocks,
                          global const ImpulseBlock* impulse_blocks, global const Motion* motions,
                          global const ContactTile* contact_tiles, global DenseTile* dense_tiles,
                          global ImpulseBlock* dense_changes, global const u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  FOR_EACH(slot, counters[COUNTER_ROWS] * PACK) {  // of lanes without a contact too
    global ImpulseBlock* changes = dense_changes + slot / PACK;
    changes->normal[slot % PACK] = changes->tangent_1[slot % PACK] = changes->tangent_2[slot % PACK] = (real)0;
  }
  FOR_EACH(item, dense_tile_end(&params, counters) * PACK) {
    const ContactTile tile = contact_tiles[item / PACK];
    global DenseTile* out = dense_tiles + item / PACK;
    const u32 k = item % PACK;
    for (u32 i = 0u; i < 3u; ++i) out->u[i][k] = out->r[i][k] = (real)0;
    if (k >= tile.count) continue;
    const u32 slot = contact_slots[tile.first + k], row = slot / PACK, at = slot % PACK;
    global const ContactBlock* block = contact_blocks + row;
    const Contact contact = contacts[tile.first + k];
    const Motion a = motions[contact.body_a], b = motions[contact.body_b];
    const Vec3 n = dense_normal(block, at);
    Vec3 t1, t2;
    tangents(n, &t1, &t2);
    const Vec3 u = sub3(add3(vec3(a.v), cross3(vec3(a.w), dense_arm_a(block, at))),
                        add3(vec3(b.v), cross3(vec3(b.w), dense_arm_b(block, at))));
    real u_1 = dot3(t1, u), u_2 = dot3(t2, u);
#if FEATURE_IMPACT_LAWS
    u_1 = u_1 + slide_blocks[row].bias_1[at];
    u_2 = u_2 + slide_blocks[row].bias_2[at];
#endif
    out->u[0][k] = dot3(n, u) + block->bias[at] + (real)0;  // never -0
    out->u[1][k] = u_1 + (real)0;
    out->u[2][k] = u_2 + (real)0;
    out->r[0][k] = impulse_blocks[row].normal[at];
    out->r[1][k] = impulse_blocks[row].tangent_1[at];
    out->r[2][k] = impulse_blocks[row].tangent_2[at];
    out->friction[k] = block->friction[at];
  }
}

// A work-group a world: `sweeps` sweeps.
kernel void dense_sweep(const StepParams params, const u32 sweeps, global const Contact* contacts,
                        global const ContactTile* contact_tiles, global const u32* tile_starts,
                        global const CoupledTiles* coupled_tiles, global const DenseBlock* dense_blocks,
                        global DenseTile* dense_tiles, global u32* counters) {
  const DenseProblem problem = DENSE_PROBLEM;
  dense_sweep_worlds(sweeps, params.worlds, &problem);
}

// Impulses, and by what they have changed.
kernel void dense_finish(const StepParams params, global const u32* contact_slots,
                         global const ContactTile* contact_tiles, global const DenseTile* dense_tiles,
                         global ImpulseBlock* impulse_blocks, global ImpulseBlock* dense_changes,
                         global const u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  FOR_EACH(item, dense_tile_end(&params, counters) * PACK) {
    const ContactTile tile = contact_tiles[item / PACK];
    const u32 k = item % PACK;
    if (k >= tile.count) continue;
    global const DenseTile* in = dense_tiles + item / PACK;
    const u32 slot = contact_slots[tile.first + k], at = slot % PACK;
    global ImpulseBlock* r = impulse_blocks + slot / PACK;
    global ImpulseBlock* change = dense_changes + slot / PACK;
    change->normal[at] = in->r[0][k] - r->normal[at];
    change->tangent_1[at] = in->r[1][k] - r->tangent_1[at];
    change->tangent_2[at] = in->r[2][k] - r->tangent_2[at];
    r->normal[at] = in->r[0][k];
    r->tangent_1[at] = in->r[1][k];
    r->tangent_2[at] = in->r[2][k];
  }
}

static inline void dense_apply_item(u32 begin, u32 item, global const BlockBodies* block_bodies,
                                    global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                                    global const ImpulseBlock* dense_changes, global Motion* motions) {
  const StartStream stream = {block_bodies, block_rows, contact_blocks, dense_changes, 0, 0, 0, 0, motions};
  start_item(begin, item, &stream);
}

// The bodies of a colour get the changes.
kernel void dense_apply_color(const u32 color, global const u32* color_starts, global const BlockBodies* block_bodies,
                              global const BlockRows* block_rows, global const ContactBlock* contact_blocks,
                              global const ImpulseBlock* dense_changes, global Motion* motions,
                              global const u32* counters) {
  if (SWEEP_SKIPPED(counters)) return;
  const u32 begin = color_starts[color], items = (color_starts[color + 1u] - begin) * ITEMS_PER_BLOCK;
  FOR_EACH(item, items)
  dense_apply_item(begin, item, block_bodies, block_rows, contact_blocks, dense_changes, motions);
}

// One work-group: those of the colours from `first_color` on and of the overflow.
kernel void dense_apply_tail(const u32 first_color, global const u32* color_starts,
                             global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                             global const ContactBlock* contact_blocks, global const ImpulseBlock* dense_changes,
                             global Motion* motions, global const u32* counters) {
  const u32 phases = contact_phases(counters);
  u32 phase = min(first_color, counters[COUNTER_COLORS]);
  do {
    const bool is_there = phase < phases;
    const u32 begin = is_there ? phase_begin(phase, color_starts, counters) : 0u;
    const u32 items = is_there ? (phase_end(phase, color_starts, counters) - begin) * ITEMS_PER_BLOCK : 0u;
    for (u32 item = (u32)get_local_id(0); item < items; item += (u32)get_local_size(0))
      dense_apply_item(begin, item, block_bodies, block_rows, contact_blocks, dense_changes, motions);
    barrier(CLK_GLOBAL_MEM_FENCE);
  } while (++phase < phases);
}

// One work-group: all of it, `rounds` times `sweeps` sweeps.
kernel void solve_dense_group(const StepParams params, const u32 rounds, const u32 sweeps, const u32 joint_phase_count,
                              global const Contact* contacts, global const u32* contact_slots,
                              global const ContactBlock* contact_blocks, global const SlideBlock* slide_blocks,
                              global const ContactTile* contact_tiles, global const u32* tile_starts,
                              global const CoupledTiles* coupled_tiles, global const u32* color_starts,
                              global const BlockBodies* block_bodies, global const BlockRows* block_rows,
                              global const u32* joint_phases, global const JointLanes* joint_lanes,
                              global const JointBlock* joint_blocks, global JointImpulseBlock* joint_impulses,
                              global ImpulseBlock* impulse_blocks, global Motion* motions,
                              global DenseBlock* dense_blocks, global DenseTile* dense_tiles,
                              global ImpulseBlock* dense_changes, global u32* counters) {
  const DenseProblem problem = DENSE_PROBLEM;
  dense_matrix(contacts, contact_slots, contact_blocks, motions, contact_tiles, coupled_tiles, dense_blocks, counters);
  dense_measure(params, contacts, contact_slots, contact_blocks, slide_blocks, impulse_blocks, motions, contact_tiles,
                dense_tiles, dense_changes, counters);
  barrier(CLK_GLOBAL_MEM_FENCE);
  u32 round = 0u;
  do {
#if FEATURE_JOINTS
    sweep_joints(PURPOSE_SOLVE, 0u, STEP_ABORTED(counters) ? 0u : joint_phase_count, joint_phases, joint_lanes,
                 joint_blocks, joint_impulses, motions, counters);
    dense_measure(params, contacts, contact_slots, contact_blocks, slide_blocks, impulse_blocks, motions, contact_tiles,
                  dense_tiles, dense_changes, counters);
    barrier(CLK_GLOBAL_MEM_FENCE);
#endif
    dense_sweep_worlds(sweeps, params.worlds, &problem);
#if FEATURE_JOINTS
    dense_finish(params, contact_slots, contact_tiles, dense_tiles, impulse_blocks, dense_changes, counters);
    barrier(CLK_GLOBAL_MEM_FENCE);
    dense_apply_tail(0u, color_starts, block_bodies, block_rows, contact_blocks, dense_changes, motions, counters);
#endif
#if FEATURE_TOLERANCE
    if (group_has_settled(params.tolerance, round + 1u >= rounds, counters)) break;
#endif
  } while (++round < rounds);
#if !FEATURE_JOINTS
  dense_finish(params, contact_slots, contact_tiles, dense_tiles, impulse_blocks, dense_changes, counters);
  barrier(CLK_GLOBAL_MEM_FENCE);
  dense_apply_tail(0u, color_starts, block_bodies, block_rows, contact_blocks, dense_changes, motions, counters);
#endif
}
