// A step of the pairs in contact along the projected gradient (cpu_reference/gradient/descent.hpp): contact by contact,
// from the velocities that the bodies have at y. kernels/gradient/gradient_pairs.h is the twin, LANES pairs at a time.
#pragma once

#include "cpu_reference/gradient/descent.hpp"
#include "cpu_reference/sweep_contacts.hpp"

namespace lockstep::reference {

/// What an impulse gives a body, N s and N m s, and what its joint or pair adds to the sums of the step.
template <class real>
struct GradientContribution {
  Vec3<real> impulse, moment;
  real length, uphill;
};

/// The nearest point of the cone |r_t| <= mu r_n.
template <class real>
ConeVector<real> project_on_cone(ConeVector<real> r, real friction) {
  const real length = std::sqrt(r.tangent_1 * r.tangent_1 + r.tangent_2 * r.tangent_2);
  if (r.normal >= 0 && length <= friction * r.normal) return r;
  if (friction * length <= -r.normal) return {0, 0, 0};
  const real normal = (r.normal + friction * length) / (real(1) + friction * friction);
  const real share = length > 0 ? friction * normal / length : real(0);
  return {normal, share * r.tangent_1, share * r.tangent_2};
}

/// How many times more sides a body has with its joints than its pairs in contact alone; 1 where it cannot move.
template <class real>
real joined_share(const Buffers<real>& buffers, u32 body, real pairs) {
  if (!(pairs > 0)) return 1;
  return real(1) + real(buffers.joint_side_starts[body + 1] - buffers.joint_side_starts[body]) / pairs;
}

/// D of a contact, 1/kg: the block is that of the copies of its bodies.
template <class real>
real contact_metric(const ContactBlock<real>& block, u32 lane, u32 count, real share) {
  const real n1 = std::fabs(block.w_n1[lane]), n2 = std::fabs(block.w_n2[lane]), t12 = std::fabs(block.w_12[lane]);
  const real row_n = block.w_nn[lane] + n1 + n2, row_1 = n1 + block.w_11[lane] + t12,
             row_2 = n2 + t12 + block.w_22[lane];
  return share * (real(count) * larger(row_n, larger(row_1, row_2)));
}

/// y' = r' + beta (r' - r), and r is r'.
template <class real>
void take_step(real beta, real next, real& r, real& y) {
  y = next + beta * (next - r);
  r = next;
}

template <class real>
void take_contact_step(real beta, const ImpulseBlock<real>& next, u32 lane, ImpulseBlock<real>& r,
                       ImpulseBlock<real>& y) {
  take_step(beta, next.normal[lane], r.normal[lane], y.normal[lane]);
  take_step(beta, next.tangent_1[lane], r.tangent_1[lane], y.tangent_1[lane]);
  take_step(beta, next.tangent_2[lane], r.tangent_2[lane], y.tangent_2[lane]);
}

/// What a pair contributes, on either body, by the steps of its contacts so far.
template <class real>
struct PairStep {
  GradientContribution<real> a = {}, b = {};
  real length = 0, uphill = 0;
  real change = 0;  // the square of the largest change, m^2/s^2
};

/// The step of a contact from y to next, with s = step / D.
template <class real>
void step_contact(const ContactBlock<real>& block, ConeVector<real> bias, real metric, real step, u32 lane,
                  const Motion<real>& a, const Motion<real>& b, const ImpulseBlock<real>& r_block,
                  const ImpulseBlock<real>& y_block, ImpulseBlock<real>& next_block, PairStep<real>& out) {
  const ContactFrame<real> c = contact_frame<real>(block, lane);
  const ConeVector<real> y = impulse_of(y_block, lane), r = impulse_of(r_block, lane);
  const auto [u_n, u_1, u_2] = biased_velocity(c, bias, a, b);
  const real s = step / metric;
  const ConeVector<real> next =
      project_on_cone<real>({y.normal - s * u_n, y.tangent_1 - s * u_1, y.tangent_2 - s * u_2}, block.friction[lane]);
  next_block.normal[lane] = next.normal;
  next_block.tangent_1[lane] = next.tangent_1;
  next_block.tangent_2[lane] = next.tangent_2;

  const ConeVector<real> d = {next.normal - y.normal, next.tangent_1 - y.tangent_1, next.tangent_2 - y.tangent_2};
  const Vec3<real> impulse =
      add3(add3(scale3(d.normal, c.normal), scale3(d.tangent_1, c.tangent_1)), scale3(d.tangent_2, c.tangent_2));
  const real squared = d.normal * d.normal + d.tangent_1 * d.tangent_1 + d.tangent_2 * d.tangent_2;
  const real along = d.normal * (next.normal - r.normal) + d.tangent_1 * (next.tangent_1 - r.tangent_1) +
                     d.tangent_2 * (next.tangent_2 - r.tangent_2);
  out.a.impulse = add3(out.a.impulse, impulse);
  out.a.moment = add3(out.a.moment, cross3(c.arm_a, impulse));
  out.b.impulse = sub3(out.b.impulse, impulse);
  out.b.moment = sub3(out.b.moment, cross3(c.arm_b, impulse));
  out.length = out.length + metric * squared;
  out.uphill = out.uphill - metric * along;
  out.change = larger(metric / step * (metric / step) * squared, out.change);
}

}  // namespace lockstep::reference
