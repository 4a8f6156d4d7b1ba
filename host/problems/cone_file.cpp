#include "host/problems/cone_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/problems/formats.hpp"
#include "host/problems/rolling.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep {

void expect_finite(const std::string& path, const std::string& location, std::span<const double> numbers) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!std::isfinite(numbers[i]))
      refuse_problem(path, location + "[" + std::to_string(i) + "]",
                     "must be a finite number, is not; write the file anew");
  }
}

void expect_friction(const std::string& path, const std::string& location, const Eigen::VectorXd& mu) {
  expect_finite(path, location, {mu.data(), static_cast<std::size_t>(mu.size())});
  for (Eigen::Index i = 0; i < mu.size(); ++i) {
    if (mu[i] < 0) refuse_problem(path, location + "[" + std::to_string(i) + "]", "must be >= 0, is negative");
  }
}

oracle::SparseMatrix whole_matrix(const std::string& path, const std::string& location, oracle::SparseMatrix matrix,
                                  const std::string& name, std::string& form) {
  const Eigen::VectorXd diagonal = matrix.diagonal();
  const auto size = [&](Eigen::Index i, Eigen::Index j) { return std::sqrt(std::abs(diagonal[i] * diagonal[j])); };
  bool above = false, below = false, semidefinite = true;
  double largest = 0;
  for (int k = 0; k < matrix.outerSize(); ++k) {
    for (oracle::SparseMatrix::InnerIterator entry(matrix, k); entry; ++entry) {
      if (entry.value() == 0) continue;
      largest = std::max(largest, std::abs(entry.value()));
      above |= entry.row() < entry.col();
      below |= entry.row() > entry.col();
      semidefinite &= std::abs(entry.value()) <= (1 + 1e-9) * size(entry.row(), entry.col());
    }
  }
  if (above != below && semidefinite) {
    form += fmt::format(", {} from its {} triangle", name, above ? "upper" : "lower");
    const oracle::SparseMatrix twice = matrix + oracle::SparseMatrix(matrix.transpose());
    oracle::SparseMatrix once = twice;
    for (int k = 0; k < once.outerSize(); ++k) {
      for (oracle::SparseMatrix::InnerIterator entry(once, k); entry; ++entry) {
        if (entry.row() == entry.col()) entry.valueRef() *= 0.5;
      }
    }
    return once;
  }
  const oracle::SparseMatrix skew = matrix - oracle::SparseMatrix(matrix.transpose());
  for (int k = 0; k < skew.outerSize(); ++k) {
    for (oracle::SparseMatrix::InnerIterator entry(skew, k); entry; ++entry) {
      if (std::abs(entry.value()) > 0.05 * size(entry.row(), entry.col()) + 1e-12 * largest)
        refuse_problem(path, location,
                       fmt::format("must be symmetric, is not: {:.3g} at ({}, {}), {:.3g} at ({}, {}); the rows and "
                                   "columns may be in another order",
                                   matrix.coeff(entry.row(), entry.col()), entry.row(), entry.col(),
                                   matrix.coeff(entry.col(), entry.row()), entry.col(), entry.row()));
    }
  }
  return matrix;
}

void set_local(ConeFile& file, const oracle::SparseMatrix& w, const Eigen::VectorXd& q, const Eigen::VectorXd& mu,
               const Eigen::VectorXd& rolling, std::optional<oracle::Bilateral> joints) {
  if (file.dimension == 2)
    file.problem = oracle::embed_plane(w, q, mu, std::move(joints));
  else if (file.dimension == 5)
    file.problem = split_rolling(w, q, mu, rolling, std::move(joints));
  else
    file.problem = {oracle::block_matrix(w), q, mu, std::move(joints), {}};
}

void set_global(ConeFile& file, oracle::GlobalConeProblem problem, const Eigen::VectorXd& rolling) {
  if (file.dimension == 5)
    problem = split_rolling(problem, rolling);
  else
    problem.dimension = file.dimension;
  file.problem = oracle::local_form(problem);
  file.global = std::move(problem);
}

Eigen::Index ConeFile::velocities() const {
  if (!global) return 0;
  return global->m.rows() - (dimension == 5 ? contacts() : 0);
}

Eigen::VectorXd impulses_in_problem(const ConeFile& file, const Eigen::VectorXd& r) {
  if (file.dimension == 5) return split_impulses(r);
  const Eigen::Index d = file.dimension;
  Eigen::VectorXd result = Eigen::VectorXd::Zero(r.size() / d * 3);
  for (Eigen::Index i = 0; i < r.size(); ++i) result[i / d * 3 + i % d] = r[i];
  return result;
}

Eigen::VectorXd impulses_in_file(const ConeFile& file, const Eigen::VectorXd& r) {
  if (file.dimension == 5) return joined_impulses(r);
  const Eigen::Index d = file.dimension;
  Eigen::VectorXd result(r.size() / 3 * d);
  for (Eigen::Index i = 0; i < result.size(); ++i) result[i] = r[i / d * 3 + i % d];
  return result;
}

ConeFile read_cone_file(const std::string& path) {
  const std::vector<unsigned char> bytes = read_whole_file(path);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\x89HDF")) return read_fclib(path, bytes);
  return read_siconos_text(path, text);
}

}  // namespace lockstep
