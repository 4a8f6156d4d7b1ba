// Frictional contact problems made for tests.
#pragma once

#include <Eigen/Geometry>
#include <cmath>
#include <random>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

/// One contact of an isotropic body: W = mobility.
inline ConeProblem single_contact(double mobility, const Eigen::Vector3d& q, double mu) {
  ConeProblem problem;
  problem.w.diagonal = {0};
  problem.w.first = {0, 1};
  problem.w.column = {0};
  problem.w.block = {mobility * Eigen::Matrix3d::Identity()};
  problem.q = q;
  problem.mu = Eigen::VectorXd::Constant(1, mu);
  return problem;
}

/// A row of bodies of 1 to 100 kg, each on three feet on uneven ground, and pushed against the next: `contacts` of
/// them, feet first. With all feet they have more rows than velocities, so that W is singular.
inline GlobalConeProblem random_heap(std::uint32_t bodies, std::uint32_t contacts, double mu, unsigned seed) {
  std::mt19937 random(seed);
  const auto number = [&](double low, double high) { return low + (high - low) * double(random()) / 4294967295.0; };
  GlobalConeProblem problem;
  std::vector<Eigen::Triplet<double>> m, h;
  for (std::uint32_t k = 0; k < 6 * bodies; ++k) m.emplace_back(k, k, k % 6 < 3 ? std::pow(10, number(0, 2)) : 1.0);
  for (std::uint32_t i = 0; i < contacts; ++i) {
    const std::uint32_t a = i % bodies, foot = i / bodies;
    const bool on_ground = foot < 3;
    const double azimuth = 2.1 * foot + number(-0.2, 0.2);
    const Eigen::Vector3d tilt(number(-0.1, 0.1), number(-0.1, 0.1), number(-0.1, 0.1));
    const Eigen::Vector3d n = (tilt + (on_ground ? Eigen::Vector3d::UnitZ() : Eigen::Vector3d::UnitX())).normalized();
    const Eigen::Vector3d arm = on_ground ? Eigen::Vector3d(0.4 * std::cos(azimuth), 0.4 * std::sin(azimuth), -0.5)
                                          : Eigen::Vector3d(-0.5, number(-0.2, 0.2), number(-0.2, 0.2));
    Eigen::Matrix3d frame;
    frame << n.transpose(), n.unitOrthogonal().transpose(), n.cross(n.unitOrthogonal()).transpose();
    for (const auto& [body, sign] : {std::pair(a, 1.0), std::pair(a + 1, -1.0)}) {
      if (sign < 0 && (on_ground || body >= bodies)) continue;
      const Eigen::Vector3d from = sign > 0 ? arm : Eigen::Vector3d(arm + Eigen::Vector3d::UnitX());
      for (int row = 0; row < 3; ++row) {
        const Eigen::Vector3d direction = frame.row(row).transpose(), moment = from.cross(direction);
        for (int k = 0; k < 3; ++k) {
          h.emplace_back(6 * body + k, 3 * i + row, sign * direction[k]);
          h.emplace_back(6 * body + 3 + k, 3 * i + row, sign * moment[k]);
        }
      }
    }
  }
  problem.m = SparseMatrix(6 * bodies, 6 * bodies);
  problem.m.setFromTriplets(m.begin(), m.end());
  problem.h = SparseMatrix(6 * bodies, 3 * contacts);
  problem.h.setFromTriplets(h.begin(), h.end());
  problem.g = SparseMatrix(6 * bodies, 0);
  problem.f = Eigen::VectorXd::Zero(6 * bodies);
  for (std::uint32_t k = 0; k < 6 * bodies; k += 6)
    problem.f.segment<3>(k) = problem.m.coeff(k, k) * Eigen::Vector3d(number(-0.5, 0.5), number(-0.5, 0.5), -1);
  problem.w = Eigen::VectorXd::Zero(3 * contacts);
  problem.mu = Eigen::VectorXd::Constant(contacts, mu);
  return problem;
}

}  // namespace lockstep::oracle
