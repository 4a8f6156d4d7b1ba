// The tables that the stages read convex hulls from: equal hulls, such as those of a generator's copies, share an
// entry.
#pragma once

#include <map>
#include <string>
#include <vector>

#include "host/buffers.hpp"
#include "host/scene/hull.hpp"

namespace lockstep {

class HullIndex {
 public:
  /// The index of the hull of these points in `hulls`, appended to the tables where it is new. Where the points have
  /// none, `refusal` says so.
  template <class real>
  u32 find_or_add(const std::vector<Vector3>& points, Buffers<real>& buffers, std::string& refusal);

 private:
  std::map<std::vector<Vector3>, u32> known_;
};

}  // namespace lockstep
