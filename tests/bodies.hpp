// Bodies for tests, written straight into the buffers: no scene file stands between a test and a stage.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include "host/backends/reference_backend.hpp"
#include "host/scene/scene.hpp"
#include "host/step.hpp"

namespace lockstep {

/// A body as the buffers hold it: `inertia` is about the pivot where there is one, `velocity` follows from it.
struct BodySetup {
  u32 world = 0;
  BodyKind kind = BODY_DYNAMIC;
  double mass = 1;
  Vector3 inertia = {1, 1, 1};
  Vector3 position = {0, 0, 0};
  Quaternion orientation = {0, 0, 0, 1};
  Vector3 velocity = {0, 0, 0};
  Vector3 angular_velocity = {0, 0, 0};  // world frame
  bool pivoted = false;
  Vector3 com_offset = {0, 0, 0};                 // from the pivot to the centre of mass, body frame
  Vector3 force = {0, 0, 0}, torque = {0, 0, 0};  // of a user, world frame
};

struct MotionSetup {
  double dt = 0.01;
  Integrator integrator = Integrator::semi_implicit_euler;
  Gyroscopic gyroscopic = Gyroscopic::midpoint;
  std::vector<Vector3> gravities = {{0, 0, -9.81}};  // one a world
};

// ---- vectors in double, independent of the twins -------------------------------------------------------------------

inline Vector3 operator+(Vector3 a, Vector3 b) { return {a[0] + b[0], a[1] + b[1], a[2] + b[2]}; }
inline Vector3 operator-(Vector3 a, Vector3 b) { return {a[0] - b[0], a[1] - b[1], a[2] - b[2]}; }
inline Vector3 operator*(double s, Vector3 a) { return {s * a[0], s * a[1], s * a[2]}; }
inline double dot(Vector3 a, Vector3 b) { return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]; }
inline double length(Vector3 a) { return std::sqrt(dot(a, a)); }
inline Vector3 cross(Vector3 a, Vector3 b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
inline Quaternion about(Vector3 axis, double angle) {
  const double s = std::sin(angle / 2) / length(axis);
  return {s * axis[0], s * axis[1], s * axis[2], std::cos(angle / 2)};
}
/// Body to world, by the matrix of the quaternion.
inline Vector3 rotate(Quaternion q, Vector3 a) {
  const auto [x, y, z, w] = q;
  return {(1 - 2 * (y * y + z * z)) * a[0] + 2 * (x * y - z * w) * a[1] + 2 * (x * z + y * w) * a[2],
          2 * (x * y + z * w) * a[0] + (1 - 2 * (x * x + z * z)) * a[1] + 2 * (y * z - x * w) * a[2],
          2 * (x * z - y * w) * a[0] + 2 * (y * z + x * w) * a[1] + (1 - 2 * (x * x + y * y)) * a[2]};
}
inline Vector3 unrotate(Quaternion q, Vector3 a) { return rotate({-q[0], -q[1], -q[2], q[3]}, a); }

// ---- state in, state out -------------------------------------------------------------------------------------------

template <class real>
Vector3 position(const Buffers<real>& b, u32 i) {
  return {b.positions[i].x, b.positions[i].y, b.positions[i].z};
}
template <class real>
Quaternion orientation(const Buffers<real>& b, u32 i) {
  return {b.orientations[i].x, b.orientations[i].y, b.orientations[i].z, b.orientations[i].w};
}
template <class real>
Vector3 velocity(const Buffers<real>& b, u32 i) {
  return {b.motions[i].v[0], b.motions[i].v[1], b.motions[i].v[2]};
}
template <class real>
Vector3 angular_velocity(const Buffers<real>& b, u32 i) {
  return {b.motions[i].w[0], b.motions[i].w[1], b.motions[i].w[2]};
}
template <class real>
Vector3 angular_velocity_body(const Buffers<real>& b, u32 i) {
  return unrotate(orientation(b, i), angular_velocity(b, i));
}
/// I w in the body frame; about the pivot where there is one.
template <class real>
Vector3 angular_momentum_body(const Buffers<real>& b, u32 i) {
  const Vector3 w = angular_velocity_body(b, i);
  return {b.masses[i].inertia[0] * w[0], b.masses[i].inertia[1] * w[1], b.masses[i].inertia[2] * w[2]};
}
template <class real>
Vector3 angular_momentum(const Buffers<real>& b, u32 i) {
  return rotate(orientation(b, i), angular_momentum_body(b, i));
}
/// The energy of turning, J; of a pivoted body all of its kinetic energy.
template <class real>
double rotation_energy(const Buffers<real>& b, u32 i) {
  return 0.5 * dot(angular_momentum_body(b, i), angular_velocity_body(b, i));
}

template <class real>
InitialState<real> make_bodies(const std::vector<BodySetup>& bodies, const MotionSetup& motion) {
  InitialState<real> state;
  state.sizes.worlds = static_cast<u32>(motion.gravities.size());
  state.sizes.bodies = static_cast<u32>(bodies.size());

  StepParams<real>& params = state.params;
  params.dt = real(motion.dt);
  params.theta = motion.integrator == Integrator::explicit_euler ? real(0)
                 : motion.integrator == Integrator::trapezoidal  ? real(0.5)
                                                                 : real(1);
  params.gyroscopic = motion.gyroscopic != Gyroscopic::none;
  params.gyroscopic_theta = motion.gyroscopic == Gyroscopic::explicit_  ? real(0)
                            : motion.gyroscopic == Gyroscopic::midpoint ? real(0.5)
                                                                        : real(1);
  params.speed_limit = real(1e5);
  params.bodies = state.sizes.bodies;
  params.worlds = state.sizes.worlds;
  params.substeps = 1;

  const bool runge_kutta = motion.integrator == Integrator::runge_kutta;
  state.features = with(state.features, runge_kutta ? Feature::runge_kutta : Feature::time_stepping);
  for (const BodySetup& body : bodies) {
    const bool isotropic = body.inertia[0] == body.inertia[1] && body.inertia[1] == body.inertia[2];
    if (body.pivoted) state.features = with(state.features, Feature::pivots);
    if (body.force != Vector3{} || body.torque != Vector3{}) state.features = with(state.features, Feature::loads);
    if (!isotropic && params.gyroscopic) state.features = with(state.features, Feature::gyroscopic);
  }

  Buffers<real>& b = state.buffers;
  resize(b, state.sizes, state.features);
  for (u32 w = 0; w < state.sizes.worlds; ++w) {
    const Vector3& g = motion.gravities[w];
    b.gravities[w] = {real(g[0]), real(g[1]), real(g[2]), real(0)};
  }
  for (u32 i = 0; i < state.sizes.bodies; ++i) {
    const BodySetup& body = bodies[i];
    WorldRange& range = b.world_ranges[body.world];
    if (range.body_count == 0) range.first_body = i;
    const bool dynamic = body.kind == BODY_DYNAMIC;
    const bool isotropic = body.inertia[0] == body.inertia[1] && body.inertia[1] == body.inertia[2];
    b.body_infos[i] = {body.world, range.body_count++, static_cast<u32>(body.kind), isotropic};

    const Vector3 com_offset = rotate(body.orientation, body.com_offset);
    const Vector3 v = body.pivoted ? cross(body.angular_velocity, com_offset) : body.velocity;
    b.masses[i].mass = real(dynamic ? body.mass : 0);
    b.masses[i].inverse_mass = real(dynamic ? 1 / body.mass : 0);
    b.motions[i].inverse_mass = b.masses[i].inverse_mass;
    for (u32 k = 0; k < 3; ++k) {
      b.masses[i].inertia[k] = real(dynamic ? body.inertia[k] : 0);
      b.masses[i].inverse_inertia[k] = real(dynamic ? 1 / body.inertia[k] : 0);
      b.motions[i].v[k] = real(v[k]);
      b.motions[i].w[k] = real(body.angular_velocity[k]);
    }
    if (has(state.features, Feature::loads)) {
      for (u32 k = 0; k < 3; ++k)
        b.loads[i].force[k] = real(body.force[k]), b.loads[i].torque[k] = real(body.torque[k]);
    }
    const Vector3& x = body.position;
    const Quaternion& q = body.orientation;
    b.positions[i] = {real(x[0]), real(x[1]), real(x[2]), real(0)};
    b.orientations[i] = {real(q[0]), real(q[1]), real(q[2]), real(q[3])};
    if (body.pivoted) {
      for (u32 k = 0; k < 3; ++k) {
        b.pivots[i].point_world[k] = real(x[k] - com_offset[k]);
        b.pivots[i].com_offset_body[k] = real(body.com_offset[k]);
      }
      b.pivots[i].pivoted = real(1);
    }
  }
  return state;
}

/// Steps on the reference and returns the buffers afterwards.
template <class real>
Buffers<real> run_steps(const InitialState<real>& state, u32 steps) {
  ReferenceBackend<real> backend(state);
  for (u32 i = 0; i < steps; ++i) step(backend, state.params);
  return backend.buffers();
}

/// Runs one stage of the reference on the buffers of a state.
template <class real>
Buffers<real> run_stage(Stage stage, const InitialState<real>& state) {
  ReferenceBackend<real> backend(state);
  backend.run(stage, state.params);
  return backend.buffers();
}

/// Bodies of every sort in two worlds, all in motion: for comparing twins and for hashes. The sorts repeat after nine.
inline std::vector<BodySetup> mixed_bodies(bool with_pivots, u32 per_world = 9) {
  std::vector<BodySetup> bodies;
  for (u32 world = 0; world < 2; ++world) {
    for (u32 i = 0; i < per_world; ++i) {
      const u32 sort = i % 9;
      BodySetup body;
      body.world = world;
      body.kind = sort == 3 ? BODY_STATIC : sort == 4 ? BODY_KINEMATIC : BODY_DYNAMIC;
      body.mass = 0.5 + 0.3 * i;
      body.inertia = sort % 2 ? Vector3{0.7, 0.7, 0.7} : Vector3{0.3 + 0.1 * sort, 0.5 + 0.02 * world, 0.71};
      body.position = {1.5 * i, -0.3 * i + world, 2.0 / (1 + i)};
      body.orientation = about({1, 0.2 * i, -0.3}, 0.4 + i);
      if (body.kind != BODY_STATIC) body.velocity = {0.1 * i, 3.0 - i, 1.0 / 3};
      if (body.kind != BODY_STATIC) body.angular_velocity = {1.1 - 0.04 * i, 0.2 + world, 7.0 / (1 + i)};
      if (sort == 8) body.angular_velocity = {900, -1100, 700};  // many radians in a step
      body.pivoted = with_pivots && sort >= 5 && sort < 8;
      if (body.pivoted) body.com_offset = {0.1, -0.2 * world, 0.5};
      bodies.push_back(body);
    }
  }
  return bodies;
}

}  // namespace lockstep
