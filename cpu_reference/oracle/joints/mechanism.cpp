#include "cpu_reference/oracle/joints/mechanism.hpp"

#include <algorithm>
#include <map>

#include "cpu_reference/oracle/joints/sets.hpp"

namespace lockstep::oracle {

namespace {

using Eigen::Index;

constexpr Index velocities_of_a_body = 6;

bool couples_across(const SparseMatrix& m, Index size) {
  for (int k = 0; k < m.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator entry(m, k); entry; ++entry) {
      if (entry.row() / size != entry.col() / size) return true;
    }
  }
  return false;
}

DisjointSets velocities_together(const SparseMatrix& m, std::span<const std::uint32_t> bodies) {
  const auto n = static_cast<std::size_t>(m.rows());
  DisjointSets together(n);
  for (int k = 0; k < m.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator entry(m, k); entry; ++entry)
      together.unite(std::size_t(entry.row()), std::size_t(entry.col()));
  }
  for (std::size_t i = 0; i + 1 < bodies.size(); ++i) {
    for (std::uint32_t k = bodies[i] + 1; k < bodies[i + 1]; ++k) together.unite(bodies[i], k);
  }
  if (bodies.empty() && m.rows() % velocities_of_a_body == 0 && !couples_across(m, velocities_of_a_body)) {
    for (std::size_t k = 0; k < n; ++k) together.unite(k / velocities_of_a_body * velocities_of_a_body, k);
  }
  return together;
}

}  // namespace

Mechanism mechanism_of(const SparseMatrix& m, const SparseMatrix& g, std::span<const std::uint32_t> bodies,
                       std::span<const std::uint32_t> blocks) {
  Mechanism mechanism;
  DisjointSets together = velocities_together(m, bodies);
  const auto n = static_cast<std::size_t>(m.rows());
  constexpr auto none = ~std::uint32_t(0);
  std::vector<std::uint32_t> of_set(n, none), body_of(n);
  for (std::size_t i = 0; i < n; ++i) {
    std::uint32_t& body = of_set[together.find(i)];
    if (body == none) {
      body = static_cast<std::uint32_t>(mechanism.bodies.size());
      mechanism.bodies.emplace_back();
    }
    body_of[i] = body;
    mechanism.bodies[body].push_back(static_cast<Index>(i));
  }
  std::map<std::vector<std::uint32_t>, std::size_t> joints;
  for (std::size_t block = 0; block + 1 < blocks.size(); ++block) {
    std::vector<std::uint32_t> seen;
    for (std::uint32_t row = blocks[block]; row < blocks[block + 1]; ++row) {
      for (SparseMatrix::InnerIterator entry(g, row); entry; ++entry) seen.push_back(body_of[std::size_t(entry.row())]);
    }
    std::ranges::sort(seen);
    seen.erase(std::ranges::unique(seen).begin(), seen.end());
    if (seen.empty()) continue;
    const auto [entry, is_new] = joints.try_emplace(seen, mechanism.joints.size());
    if (is_new) mechanism.joints.push_back({{}, seen});
    for (std::uint32_t row = blocks[block]; row < blocks[block + 1]; ++row)
      mechanism.joints[entry->second].rows.push_back(row);
  }
  return mechanism;
}

}  // namespace lockstep::oracle
