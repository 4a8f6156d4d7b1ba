// How well a contact problem was solved: the residual of docs/theory/residuals.md, the same for every solver.
#pragma once

#include <optional>

#include "host/report/contact_system.hpp"

namespace lockstep {

struct Residual {
  double relative = 0;    // rms of the defect velocities over `scale`
  double defect_max = 0;  // largest defect velocity, m/s
  double defect_rms = 0;  // m/s
  u32 worst = 0;          // index into ContactSystem::contacts, or joints, of the largest defect
  bool worst_is_joint = false;
  double scale = 0;        // U: rms of the free relative velocities, m/s
  double rounding = 0;     // what rounding alone makes of `relative`, for the unit roundoff given
  double natural_map = 0;  // |F| / |q| with rho = 1: the form of the literature; it depends on the units
  // of patches and of the convex relaxation: what `relative` is larger by where the same impulses face Coulomb's law in
  // a cone for each contact
  std::optional<double> model_error = std::nullopt;
};

/// The residual of a solved system; where its contacts form friction patches, that of the problem of patches, and where
/// it was relaxed, that of the convex problem. Otherwise of the canonical one of a cone for each contact. `roundoff` is
/// 2^-24 where the solver worked in float, 2^-53 in double.
Residual residual(const ContactSystem& system, double roundoff);

/// The largest defect velocity of each contact, or pair in contact where they form friction patches (said of its first
/// contact; 0 of the others), and of each joint, by index into the system, m/s.
struct DefectVelocities {
  std::vector<double> contacts, joints;
};
DefectVelocities defect_velocities(const ContactSystem& system);

/// The nearest point of the Coulomb cone { |t| <= mu n } about the unit vector `normal`.
Eigen::Vector3d project_on_cone(const Eigen::Vector3d& impulse, const Eigen::Vector3d& normal, double friction);

}  // namespace lockstep
