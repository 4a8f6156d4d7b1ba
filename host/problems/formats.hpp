// The readers of the formats (cone_file.hpp), and what they have in common.
#pragma once

#include <string_view>

#include "host/error.hpp"
#include "host/problems/cone_file.hpp"

namespace lockstep {

ConeFile read_fclib(const std::string& path, std::span<const unsigned char> bytes);
ConeFile read_siconos_text(const std::string& path, std::string_view text);

[[noreturn]] inline void refuse_problem(const std::string& path, const std::string& location, const std::string& what) {
  throw Error(Failure::input, path, location + ": " + what);
}

/// More contacts than anybody's problem; a damaged count would ask for all memory.
constexpr long long most_contacts = 10'000'000;

/// Throws Error (input) where there is a number that is none, or infinite.
void expect_finite(const std::string& path, const std::string& location, std::span<const double> numbers);

/// Throws Error (input) where a coefficient of friction is negative or no number.
void expect_friction(const std::string& path, const std::string& location, const Eigen::VectorXd& mu);

/// Throws Error (input) where a matrix is far from symmetric: off by more than a hundredth of its largest entry. Files
/// of the field's collections are off by up to two thousandths; such problems are solved as they are.
void expect_symmetric(const std::string& path, const std::string& location, const oracle::SparseMatrix& matrix);

}  // namespace lockstep
