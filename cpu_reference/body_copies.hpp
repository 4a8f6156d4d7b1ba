// Bodies split among the pairs in contact: Jacobi's method with mass splitting (Tonge, Benevolenski, Voroshilov, Mass
// Splitting for Jitter-Free Parallel Rigid Body Simulation, SIGGRAPH 2012), which solves all pairs at once.
//
// A body with n pairs becomes n copies of a mass m / n and an inertia I / n, one for each pair. Each pair is solved on
// copies of its own, that start at the velocity of the body; then the body gets the mean of their velocities:
//   v' = v + (1 / n) sum_k (v_k - v) = v + 1 / m sum_k p_k,
// as though the impulses p_k of all pairs had acted on the whole body, so that momentum is kept. Copies that are
// solved apart and put together again can only lose energy: the sweeps do not overshoot, as plain Jacobi's do, and
// where no impulse changes any more the laws of all contacts hold. kernels/body_copies.h is the twin.
#pragma once

#include <vector>

#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// Calls function(bodies, block, lane) for every pair, colour after colour and overflow block after overflow block: as
/// blocks are laid out in that order, simply one after another.
template <class real, class Function>
void for_each_pair_slot(const Buffers<real>& buffers, Function&& function) {
  if (buffers.color_starts.empty()) return;  // a scene of joints alone
  for (u32 block = 0; block < buffers.color_starts[MAX_COLORS + 1]; ++block) {
    for (u32 lane = 0; lane < PACK; ++lane) {
      if (buffers.block_bodies[block].count[lane] > 0) function(buffers.block_bodies[block], block, lane);
    }
  }
}

/// One of so many copies of a body: as fast, and lighter.
template <class real>
Motion<real> body_copy_of(const Motion<real>& body, real copies) {
  Motion<real> copy = body;
  for (real* field : {&copy.inverse_mass, &copy.inertia_xx, &copy.inertia_yy, &copy.inertia_zz, &copy.inertia_xy,
                      &copy.inertia_xz, &copy.inertia_yz})
    *field = copies * *field;
  return copy;
}

/// The bodies that a pair is solved on: the whole ones, or its copies of them.
template <class real>
struct PairMotions {
  Motion<real> a, b;
};
template <class real>
PairMotions<real> pair_motions(const Buffers<real>& buffers, u32 block, u32 lane) {
  const BlockBodies& bodies = buffers.block_bodies[block];
  const Motion<real>&a = buffers.motions[bodies.body_a[lane]], &b = buffers.motions[bodies.body_b[lane]];
  if (buffers.body_copy_blocks.empty()) return {a, b};
  const BodyCopyBlock<real>& copies = buffers.body_copy_blocks[block];
  return {body_copy_of(a, copies.copies_a[lane]), body_copy_of(b, copies.copies_b[lane])};
}

/// Makes a body whole again from its copies, in the order of their slots.
template <class real>
void mean_of_copies(const Motion<real>* copies, u32 count, Motion<real>& body) {
  const Vec3<real> v = vec3(body.v), w = vec3(body.w);
  Vec3<real> dv = sub3(vec3(copies[0].v), v), dw = sub3(vec3(copies[0].w), w);
  for (u32 k = 1; k < count; ++k) {
    dv = add3(dv, sub3(vec3(copies[k].v), v));
    dw = add3(dw, sub3(vec3(copies[k].w), w));
  }
  const real n = real(count);
  store3(body.v, add3(v, Vec3<real>{dv.x / n, dv.y / n, dv.z / n}));
  store3(body.w, add3(w, Vec3<real>{dw.x / n, dw.y / n, dw.z / n}));
}

/// Calls function(block, lane, a, b) for every pair on its own copies, then puts the bodies together.
template <class real, class Function>
void for_each_pair_on_copies(Buffers<real>& buffers, Function&& function) {
  std::vector<Motion<real>> copies(buffers.body_copy_starts.back());
  for_each_pair_slot(buffers, [&](const BlockBodies&, u32 block, u32 lane) {
    PairMotions<real> pair = pair_motions(buffers, block, lane);
    function(block, lane, pair.a, pair.b);
    const u32 slot_a = buffers.body_copy_blocks[block].slot_a[lane],
              slot_b = buffers.body_copy_blocks[block].slot_b[lane];
    if (slot_a != NONE) copies[slot_a] = pair.a;
    if (slot_b != NONE) copies[slot_b] = pair.b;
  });
  for (u32 i = 0; i + 1 < buffers.body_copy_starts.size(); ++i) {
    const u32 begin = buffers.body_copy_starts[i], count = buffers.body_copy_starts[i + 1] - begin;
    if (count > 0) mean_of_copies(copies.data() + begin, count, buffers.motions[i]);
  }
}

}  // namespace lockstep::reference
