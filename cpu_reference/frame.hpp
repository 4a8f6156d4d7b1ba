// The tangents that a normal stands for, so that they need no room in the packed stream. kernels/frame.h is the twin.
#pragma once

#include "cpu_reference/math.hpp"

namespace lockstep::reference {

template <class real>
struct Tangents {
  Vec3<real> t1, t2;
};

/// Duff et al., "Building an orthonormal basis, revisited" (2017): right-handed with the normal, no branch.
template <class real>
Tangents<real> tangents(Vec3<real> n) {
  const real sign = n.z < 0 ? real(-1) : real(1);
  const real a = real(-1) / (sign + n.z);
  const real b = n.x * n.y * a;
  return {{real(1) + sign * n.x * n.x * a, sign * b, -sign * n.x}, {b, sign + n.y * n.y * a, -n.y}};
}

}  // namespace lockstep::reference
