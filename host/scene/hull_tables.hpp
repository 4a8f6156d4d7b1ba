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

  /// The same of a mesh, which pictures draw as they draw a hull.
  template <class real>
  u32 find_or_add(const std::shared_ptr<const TriangleMesh>& mesh, Buffers<real>& buffers);

  /// The same of a surface: the index of its first facet in `facets`.
  template <class real>
  u32 find_or_add(const std::shared_ptr<const Surface>& surface, Buffers<real>& buffers);

 private:
  std::map<std::shared_ptr<const TriangleMesh>, u32> known_meshes_;
  std::map<std::vector<Vector3>, u32> known_;
  std::map<std::shared_ptr<const Surface>, u32> known_surfaces_;
};

}  // namespace lockstep
