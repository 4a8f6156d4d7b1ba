// Whether a problem has no solution, by a certificate that is checked (Farkas' lemma).
#pragma once

#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep::oracle::lcp {

/// Whether the ray y proves that w = M x + q, low <= x <= high has no solution: x may go on along y without end, and y
/// . w < 0 wherever it is, where it would have to be >= 0. That is, y_i > 0 only where high_i is infinite, y_i < 0 only
/// where low_i is, and
///   q . y + sum_i max(c_i low_i, c_i high_i) < 0,   c = M^T y.
/// For low = 0 and high = infinity: y >= 0, M^T y <= 0, q . y < 0. What is within 1e-11 of the sum that it is counts as
/// 0, and what is to be below 0 has to be by 1e-6: a solution that this overlooks would be 100,000 times as large as q.
/// `p` is to be scaled (watch.hpp).
bool proves_infeasible(const Lcp& p, const VectorXd& low, const VectorXd& high, VectorXd y);
bool proves_infeasible(const Lcp& p, const VectorXd& y);

}  // namespace lockstep::oracle::lcp
