// The tangents that a normal stands for. cpu_reference/frame.hpp is the twin, lane_tangents of solve_contact.h the same
// in lanes.
#ifndef LOCKSTEP_FRAME_H
#define LOCKSTEP_FRAME_H

#include "math.h"
#include "types.h"

// Duff et al., "Building an orthonormal basis, revisited" (2017): right-handed with the normal.
static inline void tangents(Vec3 n, Vec3* t1, Vec3* t2) {
  const real sign = n.z < (real)0 ? (real)-1 : (real)1;
  const real a = (real)-1 / (sign + n.z);
  const real b = n.x * n.y * a;
  *t1 = make3((real)1 + sign * n.x * n.x * a, sign * b, -sign * n.x);
  *t2 = make3(b, sign + n.y * n.y * a, -n.y);
}

#endif
