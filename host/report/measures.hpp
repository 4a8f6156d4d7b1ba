// What is measured on the state at the end of a step, in double and outside the timed step
// (docs/reference/error_measures.md).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "host/buffers.hpp"
#include "host/report/joints.hpp"
#include "host/report/residual.hpp"

namespace lockstep {

/// Mechanics of the dynamic bodies of one world. Pivoted bodies count with their energy only: their pivot takes up
/// momentum.
struct WorldMeasures {
  double mass = 0;                                             // kg
  double kinetic = 0;                                          // J
  double potential = 0;                                        // -m g . x, and of joints' springs, J
  Eigen::Vector3d momentum = Eigen::Vector3d::Zero();          // kg m/s
  Eigen::Vector3d angular_momentum = Eigen::Vector3d::Zero();  // about the centre of mass of the world, kg m^2/s
  Eigen::Vector3d weight = Eigen::Vector3d::Zero();            // M g, N
  double momentum_size = 0, angular_momentum_size = 0;         // sums of the bodies' magnitudes
};

/// Exact distances of the listed contacts at the poses of the step's end; contacts that do not overlap do not count.
struct Penetration {
  double max = 0, mean = 0;  // m; the mean is over the overlapping contacts
  u32 touching = 0;
  double ratio = 0;  // the largest to the inner radius of the smaller shape
};

/// World-local ids. Of a joint the shapes are NONE; the body that stands for the world is NONE too.
struct WorstContact {
  u32 world, body_a, body_b, shape_a, shape_b;
};

struct Measures {
  std::vector<WorldMeasures> worlds;
  double max_speed = 0;  // of a dynamic body, m/s
  u32 contacts = 0;
  Penetration penetration;
  std::optional<Residual> residual;       // where there were contacts or joints
  std::optional<WorstContact> worst;      // where the largest defect sits
  std::optional<double> pivot_drift;      // largest distance of a pivot from its place, m; where there are pivots
  std::optional<JointDrift> joint_drift;  // where there are joints

  double energy() const;  // of all worlds, J
};

/// The buffers that measure() reads in a scene of these features.
std::vector<Buffer> measured_buffers(Features features);

/// Measures the state after a step (or before the first one, with counters of zero).
template <class real>
Measures measure(const Buffers<real>& buffers, const Sizes& sizes, Features features, const StepParams<real>& params,
                 std::span<const u32> counters);

/// Whether nothing outside the dynamic bodies can give them momentum, gravity aside: no shapes on immovable bodies, no
/// joints to them, no pivots.
template <class real>
bool momentum_is_conserved(const Buffers<real>& buffers, Features features);

}  // namespace lockstep
