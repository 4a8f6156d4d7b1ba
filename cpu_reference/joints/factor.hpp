// K = L D L^T of the locked rows of a joint, written out without pivoting: K is positive definite, as one of the bodies
// can move. A row that is not locked has zeros in L and 1 / D, so that what is solved for it is zero.
// kernels/joints/factor.h is the twin.
#pragma once

#include "kernels/types.h"

namespace lockstep::reference {

template <class real>
struct JointFactor {
  real lower[JOINT_LOWER];
  real inverse_pivot[JOINT_ROWS];
};

/// Where L_ij, j < i, stands.
constexpr u32 lower_index(u32 i, u32 j) { return i * (i - 1) / 2 + j; }

/// Of K only the entries on and below the diagonal are read.
template <class real>
JointFactor<real> factorise(const real (&k)[JOINT_ROWS][JOINT_ROWS], u32 locked) {
  JointFactor<real> f;
  real pivots[JOINT_ROWS];
  for (u32 j = 0; j < JOINT_ROWS; ++j) {
    const bool in = (locked >> j & 1) != 0;
    real pivot = k[j][j];
    for (u32 n = 0; n < j; ++n) pivot = pivot - f.lower[lower_index(j, n)] * f.lower[lower_index(j, n)] * pivots[n];
    pivots[j] = in ? pivot : real(0);
    f.inverse_pivot[j] = in ? real(1) / pivot : real(0);
    for (u32 i = j + 1; i < JOINT_ROWS; ++i) {
      real entry = k[i][j];
      for (u32 n = 0; n < j; ++n) entry = entry - f.lower[lower_index(i, n)] * f.lower[lower_index(j, n)] * pivots[n];
      f.lower[lower_index(i, j)] = (locked >> i & 1) != 0 ? entry * f.inverse_pivot[j] : real(0);
    }
  }
  return f;
}

/// Replaces b by K^-1 b. The rows of b that are not locked do not count.
template <class real>
void solve_factor(const JointFactor<real>& f, real (&b)[JOINT_ROWS]) {
  for (u32 i = 1; i < JOINT_ROWS; ++i) {
    for (u32 n = 0; n < i; ++n) b[i] = b[i] - f.lower[lower_index(i, n)] * b[n];
  }
  for (u32 i = 0; i < JOINT_ROWS; ++i) b[i] = b[i] * f.inverse_pivot[i];
  for (u32 i = JOINT_ROWS - 1; i-- > 0;) {
    for (u32 n = i + 1; n < JOINT_ROWS; ++n) b[i] = b[i] - f.lower[lower_index(n, i)] * b[n];
  }
}

}  // namespace lockstep::reference
