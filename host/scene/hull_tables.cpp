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
                     count(b.hull_edges), count(hull.edges), 0, 0});
  for (const Vector3& v : hull.vertices) b.hull_vertices.push_back(entry<real>(v, 0));
  for (const ConvexHull::Plane& plane : hull.planes) b.hull_planes.push_back(entry<real>(plane.normal, plane.offset));
  for (const std::vector<u32>& face : hull.faces) {
    b.hull_faces.push_back({count(b.hull_corners), count(face)});
    b.hull_corners.insert(b.hull_corners.end(), face.begin(), face.end());
  }
  b.hull_edges.insert(b.hull_edges.end(), hull.edges.begin(), hull.edges.end());
}

// The tables of a facet go on behind its one face (kernels/types.h).
template <class real>
void append(const Surface& surface, u32 index, Buffers<real>& b) {
  const auto count = [](const auto& elements) { return static_cast<u32>(elements.size()); };
  const Facet& facet = surface.facets[index];
  const Vector3 middle = middle_of_facet(surface, index);
  b.hulls.push_back(
      {count(b.hull_vertices), 3, count(b.hull_faces), 1, count(b.hull_edges), 3, facet.owned, facet.rim});
  const std::vector<Vector3> corners = corners_of_facet(surface, index);
  for (const Vector3& corner : corners) b.hull_vertices.push_back(entry<real>(corner, 0));
  b.hull_planes.push_back(entry<real>(facet.normal, exact::dot(facet.normal, corners[0])));
  b.hull_faces.push_back({count(b.hull_corners), 3});
  b.hull_corners.insert(b.hull_corners.end(), {0, 1, 2});
  u32 vertex_count = 3;
  for (u32 k = 0; k < 3; ++k) {
    b.hull_edges.push_back({k, (k + 1) % 3, 0, 1 + k});
    b.hull_planes.push_back(entry<real>(facet.across[k], 0));
    b.hull_faces.push_back({count(b.hull_corners), count(facet.around[k])});
    for (const u32 vertex : facet.around[k]) {
      b.hull_vertices.push_back(entry<real>(exact::subtract(surface.mesh.vertices[vertex], middle), 0));
      b.hull_corners.push_back(vertex_count++);
    }
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
u32 HullIndex::find_or_add(const std::shared_ptr<const Surface>& surface, u32 facet, Buffers<real>& buffers) {
  const auto [number, is_new] = known_facets_.try_emplace({surface, facet}, static_cast<u32>(buffers.hulls.size()));
  if (is_new) append(*surface, facet, buffers);
  return number->second;
}

template u32 HullIndex::find_or_add(const std::shared_ptr<const Surface>&, u32, Buffers<float>&);
template u32 HullIndex::find_or_add(const std::shared_ptr<const Surface>&, u32, Buffers<double>&);
template u32 HullIndex::find_or_add(const std::shared_ptr<const TriangleMesh>&, Buffers<float>&);
template u32 HullIndex::find_or_add(const std::shared_ptr<const TriangleMesh>&, Buffers<double>&);
template u32 HullIndex::find_or_add(const std::vector<Vector3>&, Buffers<float>&, std::string&);
template u32 HullIndex::find_or_add(const std::vector<Vector3>&, Buffers<double>&, std::string&);

}  // namespace lockstep
