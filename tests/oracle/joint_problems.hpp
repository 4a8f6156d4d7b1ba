// Jointed bodies made for tests: K of random masses, and rows of joints with random coefficients.
#pragma once

#include <random>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

struct Link {
  int a, b;  // bodies; -1: the world
  int rows;
};

/// Bodies of six velocities under joints: M of each a random symmetric positive definite block, G random. No contacts.
inline GlobalConeProblem jointed_bodies(int bodies, const std::vector<Link>& links, unsigned seed) {
  std::mt19937 random(seed);
  const auto number = [&] { return 2 * double(random()) / 4294967295.0 - 1; };
  std::vector<Eigen::Triplet<double>> m, g;
  GlobalConeProblem problem;
  problem.bodies = {0};
  for (int body = 0; body < bodies; ++body) {
    Eigen::Matrix<double, 6, 6> root;
    for (double& x : root.reshaped()) x = number();
    const Eigen::Matrix<double, 6, 6> mass =
        root * root.transpose() + std::pow(10, number()) * Eigen::Matrix<double, 6, 6>::Identity();
    for (int i = 0; i < 6; ++i) {
      for (int k = 0; k < 6; ++k) m.emplace_back(6 * body + i, 6 * body + k, mass(i, k));
    }
    problem.bodies.push_back(6 * (body + 1));
  }
  int rows = 0;
  problem.first = {0};
  for (const Link& link : links) {
    for (int row = rows; row < rows + link.rows; ++row) {
      for (const int body : {link.a, link.b}) {
        for (int k = 0; body >= 0 && k < 6; ++k) g.emplace_back(6 * body + k, row, number());
      }
    }
    rows += link.rows;
    problem.first.push_back(rows);
  }
  problem.m = SparseMatrix(6 * bodies, 6 * bodies);
  problem.m.setFromTriplets(m.begin(), m.end());
  problem.g = SparseMatrix(6 * bodies, rows);
  problem.g.setFromTriplets(g.begin(), g.end());
  problem.h = SparseMatrix(6 * bodies, 0);
  problem.f = Eigen::VectorXd(6 * bodies);
  problem.b = Eigen::VectorXd(rows);
  for (double& x : problem.f) x = number();
  for (double& x : problem.b) x = number();
  return problem;
}

/// Each body joined by 1 to 5 rows to one before it, or with one chance in `roots` to the world or to nothing.
inline std::vector<Link> random_forest(int bodies, int roots, unsigned seed) {
  std::mt19937 random(seed);
  std::vector<Link> links;
  for (int body = 0; body < bodies; ++body) {
    const int rows = 1 + int(random() % 5);
    const bool is_root = body == 0 || random() % unsigned(roots) == 0;
    if (is_root && random() % 2 == 0) continue;
    const int other = is_root ? -1 : int(random() % unsigned(body));
    if (random() % 2 == 0)
      links.push_back({body, other, rows});
    else
      links.push_back({other, body, rows});
  }
  return links;
}

/// From the world along one body after the other.
inline std::vector<Link> chain_of(int bodies, int rows) {
  std::vector<Link> links;
  for (int body = 0; body < bodies; ++body) links.push_back({body - 1, body, rows});
  return links;
}

}  // namespace lockstep::oracle
