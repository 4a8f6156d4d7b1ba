// Motions of one body with an exact answer, and how far an integrator ends from it.
#pragma once

#include <cmath>

#include "tests/bodies.hpp"

namespace lockstep {

inline const double pi = std::acos(-1.0);

/// The complete elliptic integral K of modulus k, by the arithmetic-geometric mean; takes k' = sqrt(1 - k^2).
inline double elliptic_k(double complement) {
  double a = 1, b = complement;
  while (a - b > 1e-15) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  return pi / (2 * a);
}

// ---- Dzhanibekov: a free body spun about its middle axis, I = (1, 2, 3), w = (epsilon, 5, 0), flips over and over
// ----

inline BodySetup dzhanibekov(double epsilon) {
  BodySetup body;
  body.inertia = {1, 2, 3};
  body.angular_velocity = {epsilon, 5, 0};
  return body;
}

/// Landau and Lifshitz, Mechanics, section 37.
inline double dzhanibekov_period(double epsilon) {
  const double twice_energy = epsilon * epsilon + 2 * 25, momentum_squared = epsilon * epsilon + 4 * 25;
  const double rate = std::sqrt((2 - 1) * (twice_energy * 3 - momentum_squared) / (1 * 2 * 3));
  const double complement_squared =
      1 - (3 - 2) * (momentum_squared - twice_energy * 1) / ((2 - 1) * (twice_energy * 3 - momentum_squared));
  return 4 * elliptic_k(std::sqrt(complement_squared)) / rate;
}

/// The period as it is seen: twice the time between the first two passages of the body-frame w_y through zero.
inline double measured_dzhanibekov_period(double epsilon, const MotionSetup& motion) {
  const auto state = make_bodies<double>({dzhanibekov(epsilon)}, motion);
  ReferenceBackend<double> backend(state);
  double last = angular_velocity_body(backend.buffers(), 0)[1], first_passage = 0;
  for (u32 i = 0; i < 1000000; ++i) {
    step(backend, state.params);
    const double current = angular_velocity_body(backend.buffers(), 0)[1];
    if ((last < 0) != (current < 0)) {
      const double passage = (i + last / (last - current)) * motion.dt;
      if (first_passage != 0) return 2 * (passage - first_passage);
      first_passage = passage;
    }
    last = current;
  }
  return 0;
}

/// After half a period the body spins backwards: the distance of the body-frame w from (epsilon, -5, 0).
inline double dzhanibekov_error(double epsilon, Integrator integrator, u32 steps) {
  const MotionSetup motion = {
      .dt = dzhanibekov_period(epsilon) / 2 / steps, .integrator = integrator, .gravities = {{0, 0, 0}}};
  const auto after = run_steps(make_bodies<double>({dzhanibekov(epsilon)}, motion), steps);
  return length(angular_velocity_body(after, 0) - Vector3{epsilon, -5, 0});
}

/// The body's x axis after 1.7 s, well inside a flip: an orientation without the symmetry of a whole one.
inline Vector3 dzhanibekov_axis_after(Integrator integrator, u32 steps) {
  const MotionSetup motion = {.dt = 1.7 / steps, .integrator = integrator, .gravities = {{0, 0, 0}}};
  return rotate(orientation(run_steps(make_bodies<double>({dzhanibekov(0.1)}, motion), steps), 0), {1, 0, 0});
}

// ---- pendulum A01: 1 kg at 1 m, released level; period 2.36784195 s
// ---------------------------------------------------

inline BodySetup pendulum() {
  BodySetup body;
  body.pivoted = true;
  body.com_offset = {0, 0, -1};
  body.inertia = {1, 1, 1e-3};
  body.orientation = about({0, 1, 0}, -pi / 2);
  body.position = {1, 0, 0};
  return body;
}

/// Distance from the exact place after 10 s, m.
inline double pendulum_error(Integrator integrator, u32 steps) {
  const auto after =
      run_steps(make_bodies<double>({pendulum()}, {.dt = 10.0 / steps, .integrator = integrator}), steps);
  return length(position(after, 0) - Vector3{0.2750874626, 0, -0.9614192051});
}

// ---- symmetric tops: the figure axis is the body's z axis, the pivot below the centre of mass
// -------------------------

inline Vector3 figure_axis(Quaternion q) { return rotate(q, {0, 0, 1}); }

/// The heavy top of Simo and Wong (1991): M = 20, g = l = 1, J = (5, 5, 1) about the centre of mass, tilted by 0.05
/// rad.
inline BodySetup simo_wong_top() {
  BodySetup top;
  top.mass = 20;
  top.pivoted = true;
  top.com_offset = {0, 0, 1};
  top.inertia = {25, 25, 1};  // about the pivot
  top.orientation = about({1, 0, 0}, 0.05);
  top.position = figure_axis(top.orientation);
  top.angular_velocity = 50.0 * figure_axis(top.orientation);
  return top;
}
inline MotionSetup top_motion(double dt, Integrator integrator) {
  return {.dt = dt, .integrator = integrator, .gravities = {{0, 0, -1}}};
}

/// A top that precesses steadily under 30 degrees: M g l = 4.905, I = (0.3, 0.3, 0.1) about the pivot, w_z = 60 in the
/// body frame. I_x cos(30) rate^2 - I_z w_z rate + M g l = 0 has the roots 0.848689 and 22.245322 rad/s.
inline BodySetup precessing_top(double rate) {
  BodySetup top;
  top.pivoted = true;
  top.com_offset = {0, 0, 0.5};
  top.inertia = {0.3, 0.3, 0.1};
  top.orientation = about({1, 0, 0}, pi / 6);
  const Vector3 axis = figure_axis(top.orientation);
  top.position = 0.5 * axis;
  top.angular_velocity = Vector3{0, 0, rate} + (60 - rate * axis[2]) * axis;
  return top;
}
struct Precession {
  double rate;      // rad/s, over the whole time
  double nutation;  // largest deviation of the tilt's cosine
};
inline Precession measured_precession(double start_rate, Integrator integrator, double dt, double end) {
  const auto state = make_bodies<double>({precessing_top(start_rate)}, {.dt = dt, .integrator = integrator});
  ReferenceBackend<double> backend(state);
  const u32 steps = static_cast<u32>(std::lround(end / dt));
  Vector3 last = figure_axis(orientation(state.buffers, 0));
  const double tilt = last[2];
  double angle = 0, nutation = 0;
  for (u32 i = 0; i < steps; ++i) {
    step(backend, state.params);
    const Vector3 current = figure_axis(orientation(backend.buffers(), 0));
    angle += std::atan2(last[0] * current[1] - last[1] * current[0], last[0] * current[0] + last[1] * current[1]);
    nutation = std::fmax(nutation, std::fabs(current[2] - tilt));
    last = current;
  }
  return {angle / (steps * dt), nutation};
}

/// The figure axis after one second.
inline Vector3 top_axis_after(Integrator integrator, u32 steps) {
  const auto state = make_bodies<double>({simo_wong_top()}, top_motion(1.0 / steps, integrator));
  return figure_axis(orientation(run_steps(state, steps), 0));
}
/// Kinetic and potential energy, J; the height counts from the pivot.
template <class real>
double top_energy(const Buffers<real>& b) {
  return rotation_energy(b, 0) + 20.0 * 1.0 * position(b, 0)[2];
}
/// The largest relative deviation of the energy from its start over 9 s at h = 0.009 s.
inline double top_energy_drift(Integrator integrator) {
  const auto state = make_bodies<double>({simo_wong_top()}, top_motion(0.009, integrator));
  ReferenceBackend<double> backend(state);
  const double start = top_energy(state.buffers);
  double drift = 0;
  for (u32 i = 0; i < 1000; ++i) {
    step(backend, state.params);
    drift = std::fmax(drift, std::fabs(top_energy(backend.buffers()) / start - 1));
  }
  return drift;
}

}  // namespace lockstep
