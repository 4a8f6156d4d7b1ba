// The readers of the formats (cone_file.hpp), and what they have in common.
#pragma once

#include <string_view>

#include "host/error.hpp"
#include "host/problems/cone_file.hpp"

namespace lockstep {

ConeFile read_fclib(const std::string& path, std::span<const unsigned char> bytes);
/// The impulses in a file's group `solution`, or else the first of its `guesses`, for a problem from elsewhere.
oracle::ConeImpulses read_fclib_solution(const std::string& path, std::span<const unsigned char> bytes,
                                         const ConeFile& file);
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

/// Makes whole what is a triangle: a matrix without entries on one side of the diagonal whose entries on the other,
/// a_ij^2 <= a_ii a_jj, may be those of a symmetric positive semidefinite one. Says in `form` that `name` was one. Else
/// throws Error (input) where a matrix is far from symmetric: |a_ij - a_ji| is more than a twentieth of
/// sqrt(a_ii a_jj). Files of the field's collections are off by up to a fiftieth; those are solved as they stand.
oracle::SparseMatrix whole_matrix(const std::string& path, const std::string& location, oracle::SparseMatrix matrix,
                                  const std::string& name, std::string& form);

/// Fills in the problem from what stands in the file, whatever the dimension; `rolling`: coefficients of rolling
/// friction, where it is five.
void set_local(ConeFile& file, const oracle::SparseMatrix& w, const Eigen::VectorXd& q, const Eigen::VectorXd& mu,
               const Eigen::VectorXd& rolling, std::optional<oracle::Bilateral> joints);

/// The same of the global form. Throws std::runtime_error where M is not positive definite.
void set_global(ConeFile& file, oracle::GlobalConeProblem problem, const Eigen::VectorXd& rolling);

}  // namespace lockstep
