// Who began and who ceased to touch in this step: the pairs that touch now, against those of the step before.
//
// Two shapes touch where one of their contacts does (mark_touching); a trigger and a shape touch where they overlap at
// the end of the step. Both lists are ordered by (shape_a, shape_b), and so are the events. What sleeps goes on to
// touch what it touched, though the pairs of the step leave it out.
#pragma once

#include <algorithm>
#include <utility>

#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/shapes/overlap.hpp"
#include "cpu_reference/sleep.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

inline bool is_trigger(const ShapeInfo& info) { return (info.flags & SHAPE_IS_TRIGGER) != 0; }

template <class real>
bool trigger_overlaps(const Buffers<real>& b, Pair pair) {
  const ShapeInfo &info_a = b.shape_infos[pair.shape_a], &info_b = b.shape_infos[pair.shape_b];
  const Pose<real> pose_a = make_pose(b.positions[info_a.body], b.orientations[info_a.body]);
  const Pose<real> pose_b = make_pose(b.positions[info_b.body], b.orientations[info_b.body]);
  const HullTables<real> tables = {b.hulls.data(),      b.hull_vertices.data(), b.hull_planes.data(),
                                   b.hull_faces.data(), b.hull_edges.data(),    b.hull_corners.data(),
                                   b.facets.data(),     b.facet_edges.data()};
  return shapes_overlap(info_a.kind, shape_in_world(pose_a, b.shapes[pair.shape_a], info_a.hull, pose_a.position),
                        info_b.kind, shape_in_world(pose_b, b.shapes[pair.shape_b], info_b.hull, pose_a.position),
                        tables);
}

template <class real>
bool pair_touches(const Buffers<real>& b, u32 p) {
  const Pair pair = b.pairs[p];
  if (is_trigger(b.shape_infos[pair.shape_a]) || is_trigger(b.shape_infos[pair.shape_b]))
    return trigger_overlaps(b, pair);
  bool touches = false;
  for (u32 i = b.contact_starts[p]; i < b.contact_starts[p + 1]; ++i) touches = touches || b.touched[i] != 0;
  return touches;
}

template <class real>
Event make_event(const Buffers<real>& b, Pair pair, bool begins) {
  if (is_trigger(b.shape_infos[pair.shape_b])) std::swap(pair.shape_a, pair.shape_b);
  const ShapeInfo &info_a = b.shape_infos[pair.shape_a], &info_b = b.shape_infos[pair.shape_b];
  const BodyInfo &body_a = b.body_infos[info_a.body], &body_b = b.body_infos[info_b.body];
  const u32 kind = is_trigger(info_a) ? (begins ? EVENT_TRIGGER_ENTER : EVENT_TRIGGER_LEAVE)
                                      : (begins ? EVENT_CONTACT_BEGIN : EVENT_CONTACT_END);
  return {kind, b.step_index[0], body_a.world, body_a.id, info_a.id, body_b.id, info_b.id, 0};
}

/// Whether a pair that touched is left out by the broad phase because both sides rest.
template <class real>
bool pair_sleeps(const Buffers<real>& b, Pair pair) {
  return !looks_for_others(b, pair.shape_a) && !looks_for_others(b, pair.shape_b);
}

inline bool pair_before(Pair p, Pair q) {
  return p.shape_a != q.shape_a ? p.shape_a < q.shape_a : p.shape_b < q.shape_b;
}

template <class real>
void find_events(Buffers<real>& b, const StepParams<real>&) {
  if (step_aborted(b.counters)) return;
  std::vector<Pair> current;
  for (u32 p = 0; p < b.counters[COUNTER_PAIRS]; ++p) {
    if (pair_touches(b, p)) current.push_back(b.pairs[p]);
  }

  std::vector<Pair> after;
  const u32 count = static_cast<u32>(current.size()), before = b.touching_count[0];
  u32 events = 0;
  for (u32 i = 0, j = 0; i < count || j < before;) {
    if (j == before || (i < count && pair_before(current[i], b.touching[j]))) {
      after.push_back(current[i]);
      b.events[events++] = make_event(b, current[i++], true);
    } else if (i == count || pair_before(b.touching[j], current[i])) {
      if (pair_sleeps(b, b.touching[j]))
        after.push_back(b.touching[j++]);
      else
        b.events[events++] = make_event(b, b.touching[j++], false);
    } else {
      after.push_back(current[i]);
      ++i, ++j;
    }
  }
  b.counters[COUNTER_TOUCHES] = static_cast<u32>(after.size());
  b.counters[COUNTER_EVENTS] = events;
  b.touching_count[0] = static_cast<u32>(after.size());
  std::copy(after.begin(), after.end(), b.touching.begin());
}

}  // namespace lockstep::reference
