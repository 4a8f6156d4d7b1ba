// Gauss-Seidel in the order of the list of contacts, without colours, on the Delassus matrix itself: Courtecuisse and
// Allard, Parallel Dense Gauss-Seidel Algorithm on Many-Core Processors, HPCC 2009 (survey 5). With W = J M^-1 J^T and
// u the relative velocities of all contacts, their biases added, a sweep solves one contact i after another,
//   q = u_i - W_ii r_i,   r_i' solves its cone (cpu_reference/cone.hpp),   d = r_i' - r_i,
// and all that share a movable body with it feel the change, each row of W for itself:
//   u_j = u_j + W_ji d.
// Rows are what may be done at once; bodies are left alone. A row adds up what it feels in the order of the list,
// whoever does it and however contacts are laid out in tiles: u is never -0, so that a block of zeros changes nothing.
//
// u starts as J v behind the warm start, and at the end the bodies get M^-1 J^T of what impulses have changed by,
// colour after colour as in the warm start. Joints are swept on the bodies before each sweep of contacts, which then
// begins and ends with them. kernels/solve_dense.cl is the twin; it stores W, as this does, once a sub-step.
#pragma once

#include <cmath>
#include <vector>

#include "cpu_reference/couple_contacts.hpp"
#include "cpu_reference/joints/solve_joint.hpp"
#include "cpu_reference/sweep_contacts.hpp"

namespace lockstep::reference {

template <class real>
class DenseSweeps {
 public:
  explicit DenseSweeps(Buffers<real>& buffers);
  void run(const StepParams<real>& params);

 private:
  /// A block W_ji, column by column: what a unit impulse of i along each of its axes makes of the velocity of j.
  struct Block {
    u32 contact;  // j
    ConeVector<real> normal, tangent_1, tangent_2;
  };
  struct Row {
    u32 row, lane;  // where the contact stands in its block
    ContactFrame<real> frame;
    ConeVector<real> u, r;
    std::vector<Block> felt;  // in the order of the list, its own among them
    u32 own = 0;
  };

  const Motion<real>& body(u32 i) const { return buffers_.motions[i]; }
  void couple(u32 i);
  void measure();
  real solve_contact(u32 i);
  real sweep();
  void apply_to_bodies();

  Buffers<real>& buffers_;
  std::vector<Row> rows_;  // of each contact
};

template <class real>
DenseSweeps<real>::DenseSweeps(Buffers<real>& buffers) : buffers_(buffers), rows_(buffers.counters[COUNTER_CONTACTS]) {
  for (u32 i = 0; i < rows_.size(); ++i) {
    const u32 slot = buffers.contact_slots[i];
    rows_[i].row = slot / PACK;
    rows_[i].lane = slot % PACK;
    rows_[i].frame = contact_frame<real>(buffers.contact_blocks[slot / PACK], slot % PACK);
  }
  for (u32 i = 0; i < rows_.size(); ++i) couple(i);
}

/// The blocks of a column: J_j of the velocities that a unit impulse gives to bodies at rest.
template <class real>
void DenseSweeps<real>::couple(u32 i) {
  const Contact& contact = buffers_.contacts[i];
  const auto shares = [&](u32 j) {
    bool found = false;
    for_each_movable(buffers_, contact, [&](u32 k) {
      found = found || k == buffers_.contacts[j].body_a || k == buffers_.contacts[j].body_b;
    });
    return found;
  };
  const auto still = [&](u32 k) {
    Motion<real> motion = body(k);
    store3(motion.v, Vec3<real>{0, 0, 0});
    store3(motion.w, Vec3<real>{0, 0, 0});
    return motion;
  };
  const auto felt_by = [&](u32 j, Vec3<real> impulse) {
    Motion<real> a = still(contact.body_a), b = still(contact.body_b);
    push_at(rows_[i].frame.arm_a, rows_[i].frame.arm_b, BLOCK_GENERAL, impulse, a, b);
    const auto moved = [&](u32 k) { return k == contact.body_a ? a : k == contact.body_b ? b : still(k); };
    const ContactFrame<real>& at = rows_[j].frame;
    const Vec3<real> u =
        velocity_at(at.arm_a, at.arm_b, moved(buffers_.contacts[j].body_a), moved(buffers_.contacts[j].body_b));
    return ConeVector<real>{dot3(at.normal, u), dot3(at.tangent_1, u), dot3(at.tangent_2, u)};
  };
  const ContactFrame<real>& frame = rows_[i].frame;
  const u32 column = tile_of(contact, i);
  for (u32 pair = buffers_.tile_starts[column]; pair < buffers_.tile_starts[column + 1]; ++pair) {
    const ContactTile& tile = buffers_.contact_tiles[buffers_.coupled_tiles[pair].row];
    for (u32 j = tile.first; j < tile.first + tile.count; ++j) {
      if (!shares(j)) continue;
      if (j == i) rows_[i].own = static_cast<u32>(rows_[i].felt.size());
      rows_[i].felt.push_back({j, felt_by(j, frame.normal), felt_by(j, frame.tangent_1), felt_by(j, frame.tangent_2)});
    }
  }
}

/// Impulses and velocities as bodies and buffers have them.
template <class real>
void DenseSweeps<real>::measure() {
  for (u32 i = 0; i < rows_.size(); ++i) {
    Row& at = rows_[i];
    const ConeVector<real> u = biased_velocity(at.frame, contact_law(Purpose::solve, buffers_, at.row, at.lane).bias,
                                               body(buffers_.contacts[i].body_a), body(buffers_.contacts[i].body_b));
    at.u = {u.normal + real(0), u.tangent_1 + real(0), u.tangent_2 + real(0)};  // never -0
    at.r = impulse_of(buffers_.impulse_blocks[at.row], at.lane);
  }
}

/// Returns the square of by how much it changed the relative velocity.
template <class real>
real DenseSweeps<real>::solve_contact(u32 i) {
  Row& at = rows_[i];
  const Block& own = at.felt[at.own];
  const Delassus<real> w = {own.normal.normal,    own.tangent_1.tangent_1, own.tangent_2.tangent_2,
                            own.tangent_1.normal, own.tangent_2.normal,    own.tangent_2.tangent_1};
  const ConeVector<real> old = at.r, u = at.u;
  const ConeVector<real> q = {u.normal - (w.nn * old.normal + w.n1 * old.tangent_1 + w.n2 * old.tangent_2),
                              u.tangent_1 - (w.n1 * old.normal + w.t11 * old.tangent_1 + w.t12 * old.tangent_2),
                              u.tangent_2 - (w.n2 * old.normal + w.t12 * old.tangent_1 + w.t22 * old.tangent_2)};
  at.r = solve_general(q, w, buffers_.contact_blocks[at.row].friction[at.lane]);
  const ConeVector<real> d = {at.r.normal - old.normal, at.r.tangent_1 - old.tangent_1, at.r.tangent_2 - old.tangent_2};
  for (const Block& block : at.felt) {
    ConeVector<real>& v = rows_[block.contact].u;
    v.normal +=
        block.normal.normal * d.normal + block.tangent_1.normal * d.tangent_1 + block.tangent_2.normal * d.tangent_2;
    v.tangent_1 += block.normal.tangent_1 * d.normal + block.tangent_1.tangent_1 * d.tangent_1 +
                   block.tangent_2.tangent_1 * d.tangent_2;
    v.tangent_2 += block.normal.tangent_2 * d.normal + block.tangent_1.tangent_2 * d.tangent_1 +
                   block.tangent_2.tangent_2 * d.tangent_2;
  }
  return contact_change(w, BLOCK_GENERAL, d);
}

template <class real>
real DenseSweeps<real>::sweep() {
  real change = 0;
  for (u32 i = 0; i < rows_.size(); ++i) change = larger(solve_contact(i), change);
  return change;
}

template <class real>
void DenseSweeps<real>::apply_to_bodies() {
  std::vector<ImpulseBlock<real>> changes(buffers_.impulse_blocks.size());
  for (const Row& at : rows_) {
    ImpulseBlock<real>&r = buffers_.impulse_blocks[at.row], &change = changes[at.row];
    change.normal[at.lane] = at.r.normal - r.normal[at.lane];
    change.tangent_1[at.lane] = at.r.tangent_1 - r.tangent_1[at.lane];
    change.tangent_2[at.lane] = at.r.tangent_2 - r.tangent_2[at.lane];
    r.normal[at.lane] = at.r.normal;
    r.tangent_1[at.lane] = at.r.tangent_1;
    r.tangent_2[at.lane] = at.r.tangent_2;
  }
  for_each_pair(buffers_, [&](u32 block, u32 lane, Motion<real>& a, Motion<real>& b) {
    start_pair(buffers_, changes, block, lane, a, b);
  });
}

template <class real>
void DenseSweeps<real>::run(const StepParams<real>& params) {
  const bool jointed = !buffers_.joint_blocks.empty();
  measure();
  for (u32 i = 0; i < params.iterations; ++i) {
    const real of_joints = sweep_joints(Purpose::solve, buffers_);
    if (jointed) measure();
    const real change = larger(sweep(), of_joints);
    if (jointed) apply_to_bodies();
    if (!(params.tolerance > 0)) continue;
    ++buffers_.counters[COUNTER_SWEEPS];
    if (real(float(std::sqrt(change))) <= params.tolerance) break;
    if (i + 1 == params.iterations) ++buffers_.counters[COUNTER_UNSOLVED];
  }
  if (!jointed) apply_to_bodies();
}

}  // namespace lockstep::reference
