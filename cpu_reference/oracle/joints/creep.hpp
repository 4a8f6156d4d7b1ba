// Shortens what sweeps do slowly. Where impulses are not unique, or what hangs on a contact is heavy, they move on by
// nearly the same step for thousands of sweeps: along the null space of W until a contact opens or slides, or towards a
// limit, by a factor q a time. Such a step d, seen twice, is taken t times at once (Aitken's extrapolation),
//   t = q / (1 - q), but no further than to where the first contact would leave its cone.
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace lockstep::oracle {

class Creep {
 public:
  /// `mu`: of the contacts, whose impulses come first; it must outlive this.
  explicit Creep(const Eigen::VectorXd& mu) : mu_(mu) {}

  /// Shown an iterate and its residual after so many sweeps, from where to go on instead: further ahead, or where it
  /// was before a leap that gained nothing. Nothing: go on.
  std::optional<Eigen::VectorXd> leap(const Eigen::VectorXd& x, double residual, std::uint32_t sweeps);

 private:
  double room(const Eigen::VectorXd& x, const Eigen::VectorXd& step) const;

  const Eigen::VectorXd& mu_;
  Eigen::VectorXd last_, step_, before_;
  double residual_before_ = 0;
  std::uint32_t sweeps_ = 0, interval_ = 0;
  std::uint32_t waits_ = 0, next_wait_ = 1;  // looks
  bool leapt_ = false;
};

}  // namespace lockstep::oracle
