// Small constraint systems, and those of scenes, for the tests of the models.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <memory>
#include <string>

#include "cpu_reference/oracle/models/multibody.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/report/contact_system.hpp"
#include "host/report/measures.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep::oracle::models::test {

constexpr double g = 9.81;

/// A point of 1 kg on the ground (body 0), sliding at `speed` in this direction, at the end of a free step of `dt`.
inline Multibody sliding_point(double speed, double angle, double friction, double dt) {
  Multibody m;
  m.bodies.resize(2);
  m.bodies[1].inverse_mass = 1;
  m.bodies[1].v = {speed * std::cos(angle), speed * std::sin(angle), -g * dt};
  m.contacts.push_back({.body_a = 1, .body_b = 0, .friction = friction});
  return m;
}

/// A ball of 2 kg and radius 0.5 on the ground.
inline Multibody ball_on_ground(const Vector3d& v, const Vector3d& w, double friction, double dt) {
  Multibody m;
  m.bodies.resize(2);
  m.bodies[1] = {0.5, Eigen::Matrix3d::Identity() / (0.4 * 2 * 0.25), v - g * dt * Vector3d::UnitZ(), w};
  m.contacts.push_back({.body_a = 1, .body_b = 0, .arm_a = {0, 0, -0.5}, .friction = friction});
  return m;
}

/// Row i of a ball joint (0 to 2), or of what a hinge locks beside it, for two bodies: a against b.
inline Row ball_row(std::size_t a, std::size_t b, const Vector3d& arm_a, const Vector3d& arm_b, int i) {
  const Vector3d axis = Vector3d::Unit(i);
  return {a, b, axis, arm_a.cross(axis), -arm_b.cross(axis)};
}
inline Row angular_row(std::size_t a, std::size_t b, const Vector3d& axis) {
  return {a, b, Vector3d::Zero(), axis, -axis};
}

/// A bar on the ground whose two halves a hinge along y joins, with dry friction in it; the far ends touch the ground.
inline Multibody hinged_bar(double friction, double dry) {
  Multibody m;
  m.bodies.resize(3);
  const Eigen::Matrix3d inertia = Eigen::Vector3d(10, 5, 4).asDiagonal();
  for (const std::size_t k : {1u, 2u})
    m.bodies[k] = {1.0 / double(k), inertia, {0.3, 0.2, -1}, {0.1, k == 1 ? 0.5 : -0.7, 0.2}};
  for (int i = 0; i < 3; ++i) m.joint_rows.push_back({ball_row(1, 2, {0.5, 0, 0}, {-0.5, 0, 0}, i), 0});
  for (int i : {0, 2}) m.joint_rows.push_back({angular_row(1, 2, Vector3d::Unit(i)), 0});
  m.dry_rows.push_back({angular_row(1, 2, Vector3d::UnitY()), dry});
  for (const double y : {-0.1, 0.1}) {
    m.contacts.push_back({.body_a = 1, .body_b = 0, .arm_a = {-0.5, y, -0.1}, .bias = 0.1, .friction = friction});
    m.contacts.push_back({.body_a = 2, .body_b = 0, .arm_a = {0.5, y, -0.1}, .friction = friction});
  }
  return m;
}

/// The system that the last sub-step of a scene solved, in double.
inline ContactSystem system_after(Scene scene, u32 steps) {
  const InitialState<double> state = compile<double>(scene);
  Simulation<double> simulation(std::make_unique<ReferenceBackend<double>>(state), state.params);
  for (u32 i = 0; i < steps; ++i) simulation.step();
  const Counters counters = simulation.counters();
  return contact_system(simulation.backend().download(measured_buffers(simulation.backend().features())), counters);
}

}  // namespace lockstep::oracle::models::test
