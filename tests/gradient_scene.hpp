// Scenes that are solved along a gradient.
#pragma once

#include "cpu_reference/gradient/gradient_pairs.hpp"
#include "host/report/residual.hpp"
#include "host/scene/compile_gradient.hpp"
#include "tests/contact_scene.hpp"

namespace lockstep::test {

template <class real>
void use_gradient(InitialState<real>& state, bool accelerated = true, u32 iterations = 50) {
  state.features = with(state.features, Feature::gradient);
  if (has(state.features, Feature::contacts)) state.features = with(state.features, Feature::jacobi);
  compile_gradient(accelerated, state);
  resize(state.buffers, state.sizes, state.features);
  state.params.iterations = iterations;
}

/// Ready to be solved: up to the warm start, from impulses that were drawn.
template <class real>
InitialState<real> started_by_gradient(InitialState<real> state, bool accelerated, u32 iterations) {
  use_gradient(state, accelerated, iterations);
  return started(std::move(state));
}

/// 1/2 r W r + q r of the contacts of a solved state, J; `free` has the velocities without impulses.
inline double objective_of(const Buffers<double>& free, const Buffers<double>& solved) {
  double sum = 0;
  for (u32 block = 0; block < solved.counters[COUNTER_BLOCKS]; ++block) {
    const BlockBodies& bodies = solved.block_bodies[block];
    for (u32 lane = 0; lane < PACK; ++lane) {
      for (u32 k = 0; k < bodies.count[lane]; ++k) {
        const u32 row = solved.block_rows[block].first + k;
        const ContactBlock<double>& contact = solved.contact_blocks[row];
        const auto c = reference::contact_frame<double>(contact, lane);
        const auto r = reference::impulse_of(solved.impulse_blocks[row], lane);
        const auto velocity = [&](const Buffers<double>& b) {
          return reference::velocity_at(c.arm_a, c.arm_b, b.motions[bodies.body_a[lane]],
                                        b.motions[bodies.body_b[lane]]);
        };
        const auto both = reference::add3(velocity(free), velocity(solved));
        sum +=
            0.5 * (r.normal * (reference::dot3(c.normal, both) + 2 * contact.bias[lane]) +
                   r.tangent_1 * reference::dot3(c.tangent_1, both) + r.tangent_2 * reference::dot3(c.tangent_2, both));
      }
    }
  }
  return sum;
}

/// The residual of the convex problem of a step's end.
template <class real>
Residual residual_of(const Buffers<real>& after) {
  return residual(contact_system(after, after.counters), sizeof(real) == 4 ? 0x1p-24 : 0x1p-53);
}

}  // namespace lockstep::test
