// Contact impulses of least norm among those that do the same to the bodies (docs/reference/forces.md).
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "kernels/types.h"

namespace lockstep {

struct SharedContact {
  u32 body_a = NONE, body_b = NONE;                   // any numbers; NONE: of a body that nothing moves
  Eigen::Vector3d point = Eigen::Vector3d::Zero();    // where the impulse acts on both, m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitZ();  // from b to a, unit
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();     // of anisotropy: what of it is in the tangent plane; zero: none
  double along = 0, across = 0;                       // mu along that axis and across it; the first where there is none
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();  // on a, N s
};

/// Of all r_i in the cones of their contacts with the sums of the r_i and of their moments on each body, those with the
/// least sum of squares:
///
///   min 1/2 sum |r_i|^2,   G r = G r(reported),   r_i in K_i = { r_n >= 0, (r_1 / mu_1)^2 + (r_2 / mu_2)^2 <= r_n^2 }.
///
/// K_i is widened to the told impulse where that is outside of it. By the dual of the projection on an affine set and a
/// cone (Henrion and Malick 2012, "Projection methods in conic optimization", section 3), r_i = P_Ki(G_i^T l) at the
/// minimum over l of 1/2 sum |P_Ki(G_i^T l)|^2 - l . G r(reported), found by proximal steps in l, each by Newton's
/// method (semismooth: P_K is piecewise smooth), for each set of bodies that contacts join. Where rounding keeps the
/// sums from being met to 1e-9 the told impulses of a set stay.
std::vector<Eigen::Vector3d> least_norm_impulses(std::span<const SharedContact> contacts);

}  // namespace lockstep
