// What the device holds, as Eigen's types in double: the report computes nothing in the precision of the run.
#pragma once

#include <Eigen/Geometry>

#include "kernels/types.h"

namespace lockstep {

template <class real>
Eigen::Vector3d vector3(const real* p) {
  return {double(p[0]), double(p[1]), double(p[2])};
}
template <class real>
Eigen::Vector3d vector3(const Vec4<real>& p) {
  return {double(p.x), double(p.y), double(p.z)};
}

/// Of unit length again: what is left of rounding would count as a stretch.
template <class real>
Eigen::Quaterniond rotation(const real* q) {
  return Eigen::Quaterniond(double(q[3]), double(q[0]), double(q[1]), double(q[2])).normalized();
}
template <class real>
Eigen::Quaterniond rotation(const Vec4<real>& q) {
  return Eigen::Quaterniond(double(q.w), double(q.x), double(q.y), double(q.z)).normalized();
}

}  // namespace lockstep
