// The constraint system of the last sub-step as the report sees it: one cone per contact point, everything in double
// and in the world frame, so that no tangent frame is needed.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "host/buffers.hpp"

namespace lockstep {

struct SystemBody {
  Eigen::Vector3d v = Eigen::Vector3d::Zero();                // of the centre of mass at the end of the solve, m/s
  Eigen::Vector3d w = Eigen::Vector3d::Zero();                // rad/s
  double inverse_mass = 0;                                    // 1/kg, 0 for immovable bodies
  Eigen::Matrix3d inverse_inertia = Eigen::Matrix3d::Zero();  // world frame, 1/(kg m^2)
};

struct SystemContact {
  u32 body_a = 0, body_b = 0;    // into ContactSystem::bodies
  Eigen::Vector3d normal;        // from b to a, unit
  Eigen::Vector3d arm_a, arm_b;  // from the centre of mass to the contact point, m
  double bias = 0;               // m/s: u_n + bias >= 0
  double friction = 0;           // mu
  Eigen::Vector3d impulse;       // on a, N s
  u32 contact = 0;               // index into the contact list it came from
};

struct ContactSystem {
  std::vector<SystemBody> bodies;
  std::vector<SystemContact> contacts;
};

/// The system that the last sub-step solved, from the buffers `contact_system_buffers` of the step's end.
template <class real>
ContactSystem contact_system(const Buffers<real>& buffers, std::span<const u32> counters);

}  // namespace lockstep
