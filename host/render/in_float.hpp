// What the device holds, as Eigen's types in float: enough for what is drawn.
#pragma once

#include "host/in_double.hpp"

namespace lockstep {

/// Of three reals in a row, or of a Vec4.
template <class Reals>
Eigen::Vector3f vector3f(const Reals& p) {
  return vector3(p).template cast<float>();
}

/// Of x y z w in a row, or of a Vec4.
template <class Reals>
Eigen::Quaternionf rotationf(const Reals& q) {
  return rotation(q).template cast<float>();
}

}  // namespace lockstep
