// The descent of a world: how long its steps are, and how much of the last one is kept up.
//
// Contacts and joints are one convex problem, the relaxation of Coulomb's law by Anitescu and Tasora (Tasora, Anitescu,
// A matrix-free cone complementarity approach for solving large-scale, nonsmooth, rigid body dynamics, CMAME 2011;
// survey 5): minimise  f(r) = 1/2 r W r + q r  over the cones |r_t| <= mu r_n. Its optimum is
//   u = W r + q,   u_n >= mu |u_t|,   r u = 0,
// so that a contact that slides at u_t leaves at mu |u_t|: De Saxce's correction is what it lacks. The projected
// gradient, with a metric D and a step t,
//   r' = P(y - t D^-1 (W y + q)),   d = r' - y
// is accepted where  d W d <= |d|^2 / t  (in D), as f then falls as far as its slope promises. y is r itself, or, with
// acceleration (Nesterov 1983; Mazhar, Heyn, Negrut, Tasora, Using Nesterov's method to accelerate multibody dynamics
// with friction and contact, ACM TOG 2015, algorithm 1), ahead of it:
//   theta'^2 = (1 - theta') theta^2,   beta = theta (1 - theta) / (theta^2 + theta'),   y' = r' + beta (r' - r)
// Momentum is dropped where it leads uphill, (y - r')(r' - r) > 0 (O'Donoghue, Candes 2015).
//
// D makes t = 1 good for certain. A body with n sides of contacts and joints is, as far as each of them is concerned, n
// copies of a mass m / n (cpu_reference/body_copies.hpp), since |sum of n|^2 <= n sum of |.|^2; and k contacts of a
// pair count k times, for the same reason:
//   W <= D,   D_i = k |W_ii of the copies| of a contact, its largest sum of a row;   D_j = n K_j of a joint.
// So steps are as long as the problem lets them, tried a little longer each time, halved where that was too long, and
// never shorter than 1: no search within an iteration, which would be a wait for the host. kernels/gradient/descent.h
// is the twin.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "cpu_reference/rigid_body.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

/// What the descent of a world has come to.
template <class real>
struct Descent {
  real step = 1, theta = 1, beta = 0;
  real change = 0;     // the square of the largest change of a relative velocity that an impulse was moved by, m^2/s^2
  bool moved = false;  // the last step was good: impulses and bodies take it
  bool settled = false;  // it was the last
};

/// Of a step d, summed over a world: |d|^2 in D, the slope (y - r')(r' - r) in D, and d W d; J.
template <class real>
struct DescentSums {
  real length = 0, uphill = 0, bend = 0;
};

template <class real>
DescentSums<real> operator+(DescentSums<real> a, DescentSums<real> b) {
  return {a.length + b.length, a.uphill + b.uphill, a.bend + b.bend};
}

/// The sum over the bodies of a world, by a tree whose shape hangs on their number alone: each node adds SUM_WIDTH
/// values from left to right.
template <class real>
DescentSums<real> sum_of_world(std::vector<DescentSums<real>>& sums, u32 first, u32 count) {
  if (count == 0) return {};
  for (u32 stride = 1; stride < count; stride *= SUM_WIDTH) {
    for (u32 node = 0; node < count; node += SUM_WIDTH * stride) {
      DescentSums<real> sum = sums[first + node];
      for (u32 k = 1; k < SUM_WIDTH && node + k * stride < count; ++k) sum = sum + sums[first + node + k * stride];
      sums[first + node] = sum;
    }
  }
  return sums[first];
}

/// Judges the step of a world, and chooses the next.
template <class real>
void decide(Descent<real>& world, const DescentSums<real>& sums, bool accelerated, real tolerance) {
  const real change = real(float(std::sqrt(world.change)));
  world.change = 0;
  if (world.step > 1 && !(world.step * sums.bend <= sums.length)) {
    const real shorter = real(0.5) * world.step;
    world.step = shorter > 1 ? shorter : real(1);
    world.moved = false;
    return;
  }
  world.moved = true;
  world.step = real(DESCENT_GROWTH) * world.step;
  world.beta = 0;
  if (accelerated) {
    const real squared = world.theta * world.theta;
    const real next = real(0.5) * (std::sqrt(squared * (squared + real(4))) - squared);
    const bool uphill = sums.uphill > 0;
    world.beta = uphill ? real(0) : world.theta * (real(1) - world.theta) / (squared + next);
    world.theta = uphill ? real(1) : next;
  }
  if (tolerance > 0 && change <= tolerance) world.settled = true;
}

}  // namespace lockstep::reference
