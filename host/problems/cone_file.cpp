#include "host/problems/cone_file.hpp"

#include <cmath>

#include "host/problems/formats.hpp"
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

void expect_symmetric(const std::string& path, const std::string& location, const oracle::SparseMatrix& matrix) {
  const oracle::SparseMatrix skew = matrix - oracle::SparseMatrix(matrix.transpose());
  double largest = 0, most_skew = 0;
  for (int k = 0; k < matrix.outerSize(); ++k) {
    for (oracle::SparseMatrix::InnerIterator entry(matrix, k); entry; ++entry)
      largest = std::max(largest, std::abs(entry.value()));
  }
  for (int k = 0; k < skew.outerSize(); ++k) {
    for (oracle::SparseMatrix::InnerIterator entry(skew, k); entry; ++entry)
      most_skew = std::max(most_skew, std::abs(entry.value()));
  }
  if (most_skew > 1e-2 * largest)
    refuse_problem(path, location, "must be symmetric, is not; the rows and columns may be in another order");
}

ConeFile read_cone_file(const std::string& path) {
  const std::vector<unsigned char> bytes = read_whole_file(path);
  const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
  if (text.starts_with("\x89HDF")) return read_fclib(path, bytes);
  return read_siconos_text(path, text);
}

}  // namespace lockstep
