// K = L D L^T of the locked rows of a joint. cpu_reference/joints/factor.hpp is the twin and says more.
#ifndef LOCKSTEP_JOINT_FACTOR_H
#define LOCKSTEP_JOINT_FACTOR_H

#include "types.h"

typedef struct JointFactor {
  real lower[JOINT_LOWER];
  real inverse_pivot[JOINT_ROWS];
} JointFactor;

// Where L_ij, j < i, stands.
#define LOWER_INDEX(i, j) ((i) * ((i)-1u) / 2u + (j))

static inline void factorise(real k[JOINT_ROWS][JOINT_ROWS], u32 locked, JointFactor* f) {
  real pivots[JOINT_ROWS];
  for (u32 j = 0u; j < JOINT_ROWS; ++j) {
    const bool in = (locked >> j & 1u) != 0u;
    real pivot = k[j][j];
    for (u32 n = 0u; n < j; ++n) pivot = pivot - f->lower[LOWER_INDEX(j, n)] * f->lower[LOWER_INDEX(j, n)] * pivots[n];
    pivots[j] = in ? pivot : (real)0;
    f->inverse_pivot[j] = in ? (real)1 / pivot : (real)0;
    for (u32 i = j + 1u; i < JOINT_ROWS; ++i) {
      real entry = k[i][j];
      for (u32 n = 0u; n < j; ++n)
        entry = entry - f->lower[LOWER_INDEX(i, n)] * f->lower[LOWER_INDEX(j, n)] * pivots[n];
      f->lower[LOWER_INDEX(i, j)] = (locked >> i & 1u) != 0u ? entry * f->inverse_pivot[j] : (real)0;
    }
  }
}

// Replaces b by K^-1 b.
static inline void solve_factor(const JointFactor* f, real b[JOINT_ROWS]) {
  for (u32 i = 1u; i < JOINT_ROWS; ++i) {
    for (u32 n = 0u; n < i; ++n) b[i] = b[i] - f->lower[LOWER_INDEX(i, n)] * b[n];
  }
  for (u32 i = 0u; i < JOINT_ROWS; ++i) b[i] = b[i] * f->inverse_pivot[i];
  for (u32 i = JOINT_ROWS - 1u; i-- > 0u;) {
    for (u32 n = i + 1u; n < JOINT_ROWS; ++n) b[i] = b[i] - f->lower[LOWER_INDEX(n, i)] * b[n];
  }
}

#endif
