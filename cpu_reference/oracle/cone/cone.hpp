// Coulomb's cone K = { |r_t| <= mu r_n } in the frame of a contact: normal, first tangent, second tangent.
#pragma once

#include <Eigen/Core>

namespace lockstep::oracle {

/// The nearest point of K.
inline Eigen::Vector3d project_on_cone(const Eigen::Vector3d& x, double mu) {
  const double n = x[0], t = x.tail<2>().norm();
  if (n >= 0 && t <= mu * n) return x;               // inside
  if (mu * t <= -n) return Eigen::Vector3d::Zero();  // in the polar cone
  const double on_cone = (n + mu * t) / (1 + mu * mu);
  Eigen::Vector3d result(on_cone, 0, 0);
  if (t > 0) result.tail<2>() = mu * on_cone / t * x.tail<2>();
  return result;
}

/// The nearest point of the disc of this radius.
inline Eigen::Vector2d project_on_disc(const Eigen::Vector2d& x, double radius) {
  const double length = x.norm();
  return length > radius ? Eigen::Vector2d(radius / length * x) : x;
}

/// De Saxce's change of variables: u^ = u + mu |u_t| n.
inline Eigen::Vector3d de_saxce(const Eigen::Vector3d& u, double mu) {
  return {u[0] + mu * u.tail<2>().norm(), u[1], u[2]};
}

/// F = r - P_K(r - rho u^): zero exactly at a solution, for every rho > 0.
inline Eigen::Vector3d natural_map(const Eigen::Vector3d& r, const Eigen::Vector3d& u, double mu, double rho) {
  return r - project_on_cone(r - rho * de_saxce(u, mu), mu);
}

}  // namespace lockstep::oracle
