// The manifold of what two patches share: up to four points that keep the depth and most of the area.
// kernels/shapes/share.h is the twin.
#pragma once

#include "cpu_reference/shapes/widest.hpp"

namespace lockstep::reference {

/// How much a point adds to the chosen ones: nothing it has already; a length, then areas.
template <class real>
real shared_gain(const Chosen<real>& chosen, Vec3<real> normal, const SharedPoint<real>& point) {
  const Vec3<real> p = chosen.points[0].on_a;
  const Vec3<real> x = sub3(point.on_a, p);
  if (chosen.count == 1) return length3(cross3(normal, x));
  const Vec3<real> q = sub3(chosen.points[1].on_a, p);
  const real beside_pq = dot3(normal, cross3(q, x));
  if (chosen.count == 2) return beside_pq < 0 ? -beside_pq : beside_pq;
  const Vec3<real> r = sub3(chosen.points[2].on_a, p);
  const real sense = dot3(normal, cross3(q, r)) > 0 ? real(-1) : real(1);  // outside is positive
  const real beside_qr = dot3(normal, cross3(sub3(r, q), sub3(x, q))), beside_rp = dot3(normal, cross3(x, r));
  real gain = sense * beside_pq;
  gain = sense * beside_qr > gain ? sense * beside_qr : gain;
  return sense * beside_rp > gain ? sense * beside_rp : gain;
}

/// Sorted by feature.
template <class real>
void shared_sort(Chosen<real>& chosen) {
  for (u32 i = 1; i < chosen.count; ++i) {
    for (u32 j = i; j > 0 && chosen.points[j].feature < chosen.points[j - 1].feature; --j) {
      const SharedPoint<real> point = chosen.points[j];
      chosen.points[j] = chosen.points[j - 1];
      chosen.points[j - 1] = point;
    }
  }
}

/// Whether the points of a meeting are over each other along their normal, but for a hundredth of a size. Those of the
/// direction that separates two shapes best are; where a facet leaves that one to a neighbour (facet.hpp), the best of
/// the others may be told by points far beside each other.
template <class real>
bool is_in_line(const Meeting<real>& meeting, real size) {
  const Vec3<real> d = sub3(meeting.at_a, meeting.at_b), n = meeting.crossing_normal;
  const Vec3<real> beside = sub3(d, scale3(dot3(n, d), n));
  return dot3(beside, beside) <= real(1e-4) * (size * size);
}

/// Up to four points: the first, the farthest from it, the farthest from their line, the farthest outside of the
/// triangle; then those that enclose most, one of them within `slack` (depth_slack) of the deepest. Depth chooses no
/// more than that: it changes with every step, and the points of bodies at rest are to stay. `meeting` is the deepest
/// point where the patches show none as deep. `scale` is the size of the smaller shape.
template <class real>
Manifold<real> share_patches(const Patch<real>& a, const Patch<real>& b, real radius_a, real radius_b,
                             const Meeting<real>& meeting, Vec3<real> displacement, real limit, real tolerance,
                             real slack, real scale) {
  // round surfaces that pass each other by so little are as good as in line: it makes 2e-4 of the radius
  const real width = real(0.02) * (radius_a + radius_b) + real(1e-4) * scale;
  const PatchPair<real> pair = patch_pair(a, b, meeting.normal, tolerance, width, displacement);
  const u32 count = shared_count(pair);
  Chosen<real> chosen = {};
  SharedPoint<real> deepest = {};
  deepest.gap = real(1e30);
  real least = deepest.gap;
  u32 valid = 0;
  for (u32 k = 0; k < count; ++k) {
    const SharedPoint<real> point = shared_candidate(pair, k);
    if (!point.valid) continue;
    ++valid;
    least = point.gap < least ? point.gap : least;
    if (point.gap < deepest.gap - slack) deepest = point;
    if (!chosen.points[0].valid && point.gap <= limit) chosen.points[0] = point;
  }
  // the farthest point of a shape need not lie over the face that it is farthest behind: other points come first
  const bool sure = meeting.frame == NORMAL_FIXED || meeting.crossing_gap > real(-1e29);
  const bool deeper = sure && meeting.gap < least - slack;
  const bool at_meeting = valid == 0 || (deeper && is_in_line(meeting, scale));
  if (at_meeting) {
    deepest.on_a = meeting.at_a;
    deepest.on_b = meeting.at_b;
    deepest.gap = meeting.gap;
    deepest.feature = 0;
    least = meeting.gap;
  }
  if (at_meeting || !chosen.points[0].valid) chosen.points[0] = deepest;
  chosen.count = 1;
  for (u32 pass = 1; pass < 4 && chosen.count == pass; ++pass) {
    bool found = false;
    real best = real(0.001) * scale;
    if (pass > 1) best = best * length3(sub3(chosen.points[1].on_a, chosen.points[0].on_a));
    for (u32 k = 0; k < count; ++k) {
      const SharedPoint<real> point = shared_candidate(pair, k);
      if (!point.valid || !(point.gap <= limit)) continue;
      const real gain = shared_gain(chosen, meeting.normal, point);
      if (!(gain > best)) continue;
      best = gain * real(1.001);
      chosen.points[pass] = point;
      found = true;
    }
    if (found) chosen.count = pass + 1;
  }
  // of a disc on a plane, which has no corners, the first four do
  const bool on_plane = pair.first.kind == PATCH_POLYGON && pair.first.corners == 0;
  const bool wider = pair.second.kind == PATCH_DISC ? !on_plane : valid > 4;
  bool deep = false;
  for (u32 k = 0; k < chosen.count; ++k) deep = deep || chosen.points[k].gap <= least + slack;
  if (chosen.count > 2 && pair.first.kind != PATCH_SEGMENT && (wider || !deep)) {
    shared_widen(pair, count, limit, least + slack, deepest, chosen);
  } else if (!deep && chosen.count == 1) {
    chosen.points[0] = deepest;
  }
  shared_sort(chosen);
  Manifold<real> m =
      manifold_along(meeting.normal, frame_on_round(meeting.frame, radius_a, radius_b), radius_a, radius_b);
  for (u32 k = 0; k < chosen.count; ++k) {
    m = with_point(m, add3(chosen.points[k].on_a, scale3(radius_a, meeting.normal)),
                   sub3(chosen.points[k].on_b, scale3(radius_b, meeting.normal)), chosen.points[k].feature);
  }
  return m;
}

}  // namespace lockstep::reference
