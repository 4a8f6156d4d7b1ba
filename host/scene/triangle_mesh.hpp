// Closed triangle meshes: what makes one a solid, and where it is close to a point. In exact arithmetic
// (exact_math.hpp).
#pragma once

#include <map>
#include <string>
#include <unordered_map>

#include "host/scene/scene.hpp"

namespace lockstep {

/// Makes vertices at one position one, as files often give a corner once for each triangle, and drops triangles that
/// have two corners there. All vertices must be finite.
TriangleMesh welded(TriangleMesh mesh);

/// A point as messages write it, m.
std::string point_text(const Vector3& p);

/// Says that triangles s and t both run from a vertex to another.
std::string edge_run_twice(const TriangleMesh& mesh, u32 s, u32 t, u32 from, u32 to);

/// Which triangle runs along an edge from its first to its second vertex.
using TrianglesAtEdges = std::map<std::pair<u32, u32>, u32>;

/// Of a welded mesh. Where two triangles run the same way along an edge `flaw` says so.
TrianglesAtEdges triangles_at_edges(const TriangleMesh& mesh, std::string& flaw);

/// Why a welded mesh bounds no solid: it has an edge without two triangles, triangles turned against each other, a side
/// turned in or triangles that cut each other; with a place, and what to do. Nothing where it is good.
std::string flaw_of(const TriangleMesh& mesh);

/// The triangles of a mesh by the cells of a lattice, for questions about points.
class MeshSearch {
 public:
  /// Distances are asked for up to about `max_distance`, m. Keeps a reference to the mesh.
  MeshSearch(const TriangleMesh& mesh, double max_distance);

  struct Nearest {
    bool found = false;
    double distance = 0;
    Vector3 point = {0, 0, 0};
  };
  /// The point of the surface nearest to p, where one is within `max_distance` of it, m.
  Nearest nearest(const Vector3& p, double max_distance) const;

  /// Whether p is inside: an odd number of triangles is below it.
  bool contains(const Vector3& p) const;

 private:
  using Cells = std::unordered_map<std::uint64_t, std::vector<u32>>;
  const std::vector<u32>& at(const Cells& cells, long x, long y, long z) const;

  const TriangleMesh& mesh_;
  double size_;
  Cells cells_, columns_;
};

}  // namespace lockstep
