// The order of the solves: what the solver's sweeps and the warm start share. kernels/sweep_contacts.h is the twin.
#pragma once

#include <optional>

#include "cpu_reference/body_copies.hpp"
#include "cpu_reference/purpose.hpp"
#include "cpu_reference/solve_angular_friction.hpp"
#include "cpu_reference/solve_contact.hpp"
#include "cpu_reference/solve_normals.hpp"
#include "cpu_reference/solve_patch.hpp"

namespace lockstep::reference {

/// The law of the normal velocity, u_n + bias + softness r_n >= 0: soft contacts relax into hard ones without a bias
/// (cpu_reference/relax_constraints.hpp). Tangential biases are those of impacts.
template <class real>
struct ContactLaw {
  ConeVector<real> bias;
  real softness;
};

template <class real>
ContactLaw<real> contact_law(Purpose purpose, const Buffers<real>& buffers, u32 row, u32 lane) {
  // -0 adds nothing, not even to the sign of a zero
  ConeVector<real> bias = {buffers.contact_blocks[row].bias[lane], real(-0.0), real(-0.0)};
  if (!buffers.slide_blocks.empty()) {
    bias.tangent_1 = buffers.slide_blocks[row].bias_1[lane];
    bias.tangent_2 = buffers.slide_blocks[row].bias_2[lane];
  }
  const real softness = buffers.softness_blocks.empty() ? real(0) : buffers.softness_blocks[row].softness[lane];
  if (purpose == Purpose::solve) return {bias, softness};
  if (softness > 0) bias.normal = 0;
  return {bias, 0};
}

/// Whether springs push a point of the pair out faster than its hit_speed.
template <class real>
bool is_pushed_out(const Buffers<real>& buffers, u32 block, u32 lane) {
  if (buffers.normal_couplings.empty() || buffers.softness_blocks.empty()) return false;
  const real hit_speed = std::fabs(buffers.normal_couplings[block].hit_speed[lane]);
  const u32 first = buffers.block_rows[block].first, end = first + buffers.block_bodies[block].count[lane];
  for (u32 row = first; row < end; ++row)
    if (buffers.softness_blocks[row].softness[lane] > 0 && buffers.contact_blocks[row].bias[lane] < -hit_speed)
      return true;
  return false;
}

/// Solves a pair: its contacts one after another, and its normals together before and behind them. Springs share what
/// rests on the points of a pair among them, and solved exactly they tremble: their normals are solved together from
/// the solve on in which the pair is hit. Where overlap is pushed out as fast as that, what relaxes is taken back of
/// all points at once, before their friction: behind it, friction would not see its normals. Returns the largest of the
/// squares of by how much the solves of single contacts changed relative velocities.
template <class real>
real solve_pair(Purpose purpose, Buffers<real>& buffers, u32 block, u32 lane, Motion<real>& a, Motion<real>& b) {
  const BlockBodies& bodies = buffers.block_bodies[block];
  const u32 first = buffers.block_rows[block].first, count = bodies.count[lane];
  real change = 0;
  const auto for_each_row = [&](auto&& solve) {
    for (u32 row = first; row < first + count; ++row) {
      const ContactLaw<real> law = contact_law(purpose, buffers, row, lane);
      change = larger(solve(row, law, buffers.contact_blocks[row], buffers.impulse_blocks[row]), change);
    }
  };
  if (buffers.patch_blocks.empty()) {
    std::optional<PairNormals<real>> normals;
    if (!buffers.normal_couplings.empty() && count > 1)
      normals = pair_normals(buffers.normal_couplings[block], buffers.contact_blocks, first, count, lane,
                             [&](u32 row) { return contact_law(purpose, buffers, row, lane); });
    const auto solve = [&] {
      if (normals) solve_normals(*normals, buffers.impulse_blocks, first, bodies.kind[lane], lane, a, b);
    };
    const auto solve_if_hit = [&] {
      if (normals && !buffers.softness_blocks.empty()) {
        real& hit_speed = buffers.normal_couplings[block].hit_speed[lane];
        if (!(hit_speed < 0) && !is_pair_hit(*normals, hit_speed, a, b)) return;
        hit_speed = -std::fabs(hit_speed);
      }
      solve();
    };
    if (purpose == Purpose::relax && is_pushed_out(buffers, block, lane)) {
      solve();
    } else {
      solve_if_hit();
    }
    for_each_row([&](u32 row, ContactLaw<real> law, const auto& contact, auto& impulses) {
      if (buffers.angular_friction_blocks.empty())
        return solve_contact(contact, law.bias, law.softness, impulses, bodies.kind[lane], lane, a, b);
      const EllipseBlock<real>* ellipse = buffers.ellipse_blocks.empty() ? nullptr : &buffers.ellipse_blocks[row];
      return solve_angular_friction(contact, buffers.angular_friction_blocks[row], ellipse, law.bias, law.softness,
                                    impulses, buffers.angular_friction_impulses[row], bodies.kind[lane], lane, a, b);
    });
    solve_if_hit();
    return change;
  }
  const auto solve = [&](u32, ContactLaw<real> law, const auto& contact, auto& impulses) {
    return solve_normal(contact, law.bias.normal, law.softness, impulses, lane, a, b);
  };
  for_each_row(solve);
  change = larger(solve_patch_friction(buffers.patch_blocks[block], buffers.impulse_blocks, first, count,
                                       buffers.patch_impulses[block], lane, a, b),
                  change);
  for_each_row(solve);
  return change;
}

/// Gives the bodies of a pair these impulses of its contacts, and the moments of those with angular friction.
template <class real>
void start_pair(const Buffers<real>& buffers, const std::vector<ImpulseBlock<real>>& impulses, u32 block, u32 lane,
                Motion<real>& a, Motion<real>& b) {
  const BlockBodies& bodies = buffers.block_bodies[block];
  const u32 first = buffers.block_rows[block].first, end = first + bodies.count[lane];
  const bool uses_patches = !buffers.patch_blocks.empty();
  for (u32 row = first; row < end; ++row) {
    if (uses_patches)
      start_normal(buffers.contact_blocks[row], impulses[row], lane, a, b);
    else
      push(contact_frame<real>(buffers.contact_blocks[row], lane), bodies.kind[lane], impulse_of(impulses[row], lane),
           a, b);
    if (!buffers.angular_friction_blocks.empty())
      start_angular_friction(buffers.contact_blocks[row], buffers.angular_friction_blocks[row],
                             buffers.angular_friction_impulses[row], bodies.kind[lane], lane, a, b);
  }
  if (uses_patches) start_patch_friction(buffers.patch_blocks[block], buffers.patch_impulses[block], lane, a, b);
}

/// Calls function(block, lane, a, b) for every pair: one after another, or each on copies of its bodies.
template <class real, class Function>
void for_each_pair(Buffers<real>& buffers, Function&& function) {
  if (!buffers.body_copy_blocks.empty()) return for_each_pair_on_copies(buffers, function);
  for_each_pair_slot(buffers, [&](const BlockBodies& bodies, u32 block, u32 lane) {
    function(block, lane, buffers.motions[bodies.body_a[lane]], buffers.motions[bodies.body_b[lane]]);
  });
}

/// One sweep over all pairs. Returns the square of the largest change of a relative velocity.
template <class real>
real sweep_contacts(Purpose purpose, Buffers<real>& buffers) {
  real change = 0;
  for_each_pair(buffers, [&](u32 block, u32 lane, Motion<real>& a, Motion<real>& b) {
    change = larger(solve_pair(purpose, buffers, block, lane, a, b), change);
  });
  return change;
}

/// Gives the bodies the impulses that the contacts start from.
template <class real>
void start_contacts(Buffers<real>& buffers) {
  for_each_pair(buffers, [&](u32 block, u32 lane, Motion<real>& a, Motion<real>& b) {
    start_pair(buffers, buffers.impulse_blocks, block, lane, a, b);
  });
}

}  // namespace lockstep::reference
