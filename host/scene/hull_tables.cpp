#include "host/scene/hull_tables.hpp"

#include "host/scene/surface.hpp"

namespace lockstep {

namespace {

template <class real>
Vec4<real> entry(const Vector3& v, double w) {
  return {static_cast<real>(v[0]), static_cast<real>(v[1]), static_cast<real>(v[2]), static_cast<real>(w)};
}

template <class real>
void append(const ConvexHull& hull, Buffers<real>& b) {
  const auto count = [](const auto& elements) { return static_cast<u32>(elements.size()); };
  b.hulls.push_back({count(b.hull_vertices), count(hull.vertices), count(b.hull_faces), count(hull.faces),
                     count(b.hull_edges), count(hull.edges)});
  for (const Vector3& v : hull.vertices) b.hull_vertices.push_back(entry<real>(v, 0));
  for (const ConvexHull::Plane& plane : hull.planes) b.hull_planes.push_back(entry<real>(plane.normal, plane.offset));
  for (const std::vector<u32>& face : hull.faces) {
    b.hull_faces.push_back({count(b.hull_corners), count(face)});
    b.hull_corners.insert(b.hull_corners.end(), face.begin(), face.end());
  }
  b.hull_edges.insert(b.hull_edges.end(), hull.edges.begin(), hull.edges.end());
}

// The indices of its facets and edges count from those that there are.
template <class real>
void append(const Surface& surface, Buffers<real>& b) {
  const u32 first = static_cast<u32>(b.facets.size()), first_edge = static_cast<u32>(b.facet_edges.size());
  b.facets.reserve(b.facets.size() + surface.facets.size());
  const auto corner = [first](u32 of_surface) { return FACET_CORNER((of_surface >> 2) + first, of_surface & 3); };
  for (u32 t = 0; t < surface.facets.size(); ++t) {
    const FacetLinks& links = surface.facets[t];
    const Vector3 normal = normal_of_facet(surface, t);
    const std::array<Vector3, 3> corners = corners_of_facet(surface, t);
    Facet<real> facet = {};
    for (u32 k = 0; k < 3; ++k) {
      for (u32 i = 0; i < 3; ++i) facet.corners[3 * k + i] = static_cast<real>(corners[k][i]);
      facet.normal[k] = static_cast<real>(normal[k]);
      const bool stored = (links.flags >> FACET_EDGE_SHIFT(k) & 3) == FACET_EDGE_STORED;
      facet.next[k] = stored ? links.next[k] + first_edge : corner(links.next[k]);
    }
    facet.height = static_cast<real>(exact::dot(normal, corners[0]));
    facet.flags = links.flags;
    b.facets.push_back(facet);
  }
  for (const SurfaceEdge& edge : surface.edges) {
    FacetEdge<real> record = {};
    for (u32 i = 0; i < 3; ++i) record.across[i] = static_cast<real>(edge.across[i]);
    record.next = edge.next == NONE ? NONE : corner(edge.next);
    b.facet_edges.push_back(record);
  }
}

}  // namespace

template <class real>
u32 HullIndex::find_or_add(const std::vector<Vector3>& points, Buffers<real>& buffers, std::string& refusal) {
  const auto found = known_.find(points);
  if (found != known_.end()) return found->second;
  const ConvexHull hull = convex_hull(points, refusal);
  if (!refusal.empty()) return 0;
  append(hull, buffers);
  return known_[points] = static_cast<u32>(buffers.hulls.size() - 1);
}

template <class real>
u32 HullIndex::find_or_add(const std::shared_ptr<const TriangleMesh>& mesh, Buffers<real>& buffers) {
  const auto found = known_meshes_.find(mesh);
  if (found != known_meshes_.end()) return found->second;
  ConvexHull faces;  // no planes and no edges: nothing collides with it
  faces.vertices = mesh->vertices;
  for (const auto& triangle : mesh->triangles) faces.faces.emplace_back(triangle.begin(), triangle.end());
  append(faces, buffers);
  return known_meshes_[mesh] = static_cast<u32>(buffers.hulls.size() - 1);
}

template <class real>
u32 HullIndex::find_or_add(const std::shared_ptr<const Surface>& surface, Buffers<real>& buffers) {
  const auto [first, is_new] = known_surfaces_.try_emplace(surface, static_cast<u32>(buffers.facets.size()));
  if (is_new) append(*surface, buffers);
  return first->second;
}

template u32 HullIndex::find_or_add(const std::shared_ptr<const Surface>&, Buffers<float>&);
template u32 HullIndex::find_or_add(const std::shared_ptr<const Surface>&, Buffers<double>&);
template u32 HullIndex::find_or_add(const std::shared_ptr<const TriangleMesh>&, Buffers<float>&);
template u32 HullIndex::find_or_add(const std::shared_ptr<const TriangleMesh>&, Buffers<double>&);
template u32 HullIndex::find_or_add(const std::vector<Vector3>&, Buffers<float>&, std::string&);
template u32 HullIndex::find_or_add(const std::vector<Vector3>&, Buffers<double>&, std::string&);

}  // namespace lockstep
