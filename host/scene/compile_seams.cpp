#include "host/scene/compile_seams.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "host/scene/extents.hpp"

namespace lockstep {

namespace {

using exact::add, exact::cross, exact::dot, exact::length, exact::multiply, exact::rotate, exact::scale,
    exact::subtract, exact::unit;

// How far apart shapes may be that lie flush, as a share of the smallest half extent of the two.
constexpr double flush = 1e-4;
// Sines: of what is one plane (cpu_reference/shapes/facet.hpp), and of a direction that leans a little over an edge.
constexpr double level = 1e-3, lean = 5e-3;

struct Frame {
  Vector3 position;
  Quaternion rotation;
};

Quaternion inverse(const Quaternion& q) { return {-q[0], -q[1], -q[2], q[3]}; }

Frame within(const Frame& outer, const Frame& inner) {
  return {add(outer.position, rotate(outer.rotation, inner.position)), multiply(outer.rotation, inner.rotation)};
}

Frame seen_from(const Frame& frame, const Frame& viewer) {
  const Quaternion back = inverse(viewer.rotation);
  return {rotate(back, subtract(frame.position, viewer.position)), multiply(back, frame.rotation)};
}

// A box, a hull or a facet that nothing pushes, and a box around it that is wider by what may be between it and others.
struct Block {
  u32 shape;
  u32 surface;  // blocks of one surface know each other already
  Frame frame;
  Extents box;
  double smallest;  // half extent
  double rounding;  // of its place
};

// Its vertices, edges and the planes that bound it, own coordinates; of a facet as bound_plane of
// cpu_reference/shapes/seams.hpp.
struct Solid {
  std::vector<Vector3> vertices;
  std::vector<std::array<Vector3, 2>> edges;
  std::vector<std::pair<Vector3, double>> planes;
  bool facet = false;
};

Solid solid_box(const Vector3& half) {
  Solid solid;
  for (unsigned k = 0; k < 3; ++k) {
    const unsigned u = (k + 1) % 3, v = (k + 2) % 3;
    for (unsigned corner = 0; corner < 4; ++corner) {
      Vector3 from = half;
      if ((corner & 1) != 0) from[u] = -half[u];
      if ((corner & 2) != 0) from[v] = -half[v];
      Vector3 to = from;
      to[k] = -half[k];
      solid.edges.push_back({from, to});
      if (k == 0) solid.vertices.insert(solid.vertices.end(), {from, to});
    }
    Vector3 normal = {0, 0, 0};
    for (const double side : {-1.0, 1.0}) {
      normal[k] = side;
      solid.planes.emplace_back(normal, half[k]);
    }
  }
  return solid;
}

template <class real>
Vector3 vector(const Vec4<real>& v) {
  return {double(v.x), double(v.y), double(v.z)};
}

template <class real>
Solid solid_hull(const Hull& hull, const Buffers<real>& b) {
  Solid solid;
  for (u32 v = hull.first_vertex; v < hull.first_vertex + hull.vertex_count; ++v)
    solid.vertices.push_back(vector(b.hull_vertices[v]));
  for (u32 e = hull.first_edge; e < hull.first_edge + hull.edge_count; ++e) {
    const HullEdge& edge = b.hull_edges[e];
    solid.edges.push_back({vector(b.hull_vertices[hull.first_vertex + edge.vertex_a]),
                           vector(b.hull_vertices[hull.first_vertex + edge.vertex_b])});
  }
  for (u32 f = hull.first_face; f < hull.first_face + hull.face_count; ++f)
    solid.planes.emplace_back(vector(b.hull_planes[f]), double(b.hull_planes[f].w));
  solid.facet = hull.face_count == 1;
  if (!solid.facet) return solid;
  const auto [normal, offset] = solid.planes[0];
  solid.planes.emplace_back(scale(-1, normal), -offset);
  for (const auto& [start, end] : solid.edges) {
    const Vector3 across = unit(cross(subtract(end, start), normal));
    solid.planes.emplace_back(across, dot(across, start));
  }
  return solid;
}

template <class real>
Solid solid_of(const Buffers<real>& b, u32 shape) {
  const ShapeInfo& info = b.shape_infos[shape];
  if (info.kind == SHAPE_HULL) return solid_hull(b.hulls[info.hull], b);
  const Shape<real>& box = b.shapes[shape];
  return solid_box({double(box.size[0]), double(box.size[1]), double(box.size[2])});
}

// Whether some edge of one solid is in the other, which stands in this frame, or no farther than the tolerance from it.
bool touches_an_edge(const Solid& one, const Solid& other, const Frame& frame, double tolerance) {
  const Quaternion back = inverse(frame.rotation);
  for (const auto& [start, end] : one.edges) {
    const Vector3 p = rotate(back, subtract(start, frame.position)), q = rotate(back, subtract(end, frame.position));
    double from = 0, to = 1;
    for (const auto& [normal, offset] : other.planes) {
      const double out_p = dot(normal, p) - offset - tolerance, out_q = dot(normal, q) - offset - tolerance;
      if (out_p > 0 && out_q > 0) from = 2;
      if (out_p > 0 && out_q <= 0) from = std::max(from, out_p / (out_p - out_q));
      if (out_p <= 0 && out_q > 0) to = std::min(to, out_p / (out_p - out_q));
    }
    if (from <= to) return true;
  }
  return false;
}

// Whether a solid in this frame covers a point against a direction, as neighbour_covers there.
bool covers(const Solid& solid, const Frame& frame, const Vector3& point, const Vector3& up, double tolerance) {
  const Quaternion back = inverse(frame.rotation);
  const Vector3 at = rotate(back, subtract(point, frame.position)), own_up = rotate(back, up);
  for (const auto& [normal, offset] : solid.planes)
    if (dot(normal, at) - offset > tolerance) return false;
  for (const Vector3& vertex : solid.vertices) {
    const Vector3 d = subtract(vertex, at);
    if (dot(own_up, d) > level * length(d) + tolerance) return true;
  }
  return solid.facet && dot(own_up, solid.planes[0].first) < -0.5;
}

template <class real>
class SeamFinder {
 public:
  explicit SeamFinder(Buffers<real>& b) : b_(b), seams_(b.shapes.size()) {}

  /// Blocks that may lie flush.
  void find(std::vector<Block> blocks);

  /// Edges of facets over which another surface goes on are none that bodies can leave the surface by.
  void join_surfaces();

  void store() {
    u32 total = 0;
    for (std::size_t shape = 0; shape < seams_.size(); ++shape) {
      b_.seam_starts.push_back(total);
      if (seams_[shape].empty()) continue;
      b_.shape_infos[shape].flags |= SHAPE_HAS_SEAMS;
      for (const auto& [neighbour, seam] : seams_[shape]) b_.seams.push_back(seam);
      total += static_cast<u32>(seams_[shape].size());
    }
    b_.seam_starts.push_back(total);
    if (total == 0) b_.seam_starts.clear();
  }

  Block block_of(u32 shape, u32 surface, const Frame& frame) const;

 private:
  static std::vector<Block> near_others(const std::vector<Block>& blocks);
  void add_seams(const Block& one, const Block& other);
  bool goes_on(u32 shape, const Solid& facet, u32 edge) const;

  Buffers<real>& b_;
  std::vector<std::map<u32, Seam<real>>> seams_;  // of each shape, by neighbour
};

template <class real>
Block SeamFinder<real>::block_of(u32 shape, u32 surface, const Frame& frame) const {
  const Shape<real>& record = b_.shapes[shape];
  Block block = {shape, surface, frame, {frame.position, frame.position}, 1e300, 0};
  Vector3 half = {0, 0, 0};
  for (unsigned axis = 0; axis < 3; ++axis) {
    Vector3 side = {0, 0, 0};
    side[axis] = double(record.size[axis]);
    block.smallest = std::min(block.smallest, side[axis]);
    const Vector3 rotated = rotate(frame.rotation, side);
    for (unsigned k = 0; k < 3; ++k) half[k] += std::abs(rotated[k]);
  }
  if (surface != NONE) {  // half the height of the triangle
    const Solid facet = solid_of(b_, shape);
    double longest = 0;
    for (const auto& [start, end] : facet.edges) longest = std::max(longest, length(subtract(end, start)));
    const Vector3* v = facet.vertices.data();
    block.smallest = 0.5 * length(cross(subtract(v[1], v[0]), subtract(v[2], v[0]))) / longest;
  }
  block.rounding = 4 * double(std::numeric_limits<real>::epsilon()) * (length(frame.position) + length(half));
  const double wider = flush * block.smallest + block.rounding;
  for (unsigned k = 0; k < 3; ++k) {
    block.box.low[k] -= half[k] + wider;
    block.box.high[k] += half[k] + wider;
  }
  return block;
}

// All but the facets that are in no box around another surface or block.
template <class real>
std::vector<Block> SeamFinder<real>::near_others(const std::vector<Block>& blocks) {
  std::map<u32, Extents> surfaces;
  std::vector<Extents> alone;
  for (const Block& block : blocks) {
    if (block.surface != NONE)
      surfaces[block.surface].unite(block.box);
    else
      alone.push_back(block.box);
  }
  std::map<u32, std::vector<Extents>> others;  // that a surface meets
  for (const auto& [surface, box] : surfaces) {
    for (const auto& [other, other_box] : surfaces)
      if (other != surface && box.meets(other_box)) others[surface].push_back(other_box);
    for (const Extents& other_box : alone)
      if (box.meets(other_box)) others[surface].push_back(other_box);
  }
  std::vector<Block> near;
  for (const Block& block : blocks) {
    const auto meets = [&](const Extents& box) { return block.box.meets(box); };
    if (block.surface == NONE || std::ranges::any_of(others[block.surface], meets)) near.push_back(block);
  }
  return near;
}

template <class real>
void SeamFinder<real>::find(std::vector<Block> blocks) {
  blocks = near_others(blocks);
  // in order along the axis along which they are spread most
  Vector3 first = {1e300, 1e300, 1e300}, last = {-1e300, -1e300, -1e300};
  for (const Block& block : blocks) {
    for (unsigned k = 0; k < 3; ++k) {
      first[k] = std::min(first[k], block.box.low[k]);
      last[k] = std::max(last[k], block.box.low[k]);
    }
  }
  const Vector3 spread = subtract(last, first);
  const auto axis = static_cast<unsigned>(std::ranges::max_element(spread) - spread.begin());
  std::ranges::stable_sort(blocks, {}, [axis](const Block& block) { return block.box.low[axis]; });
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    for (std::size_t j = i + 1; j < blocks.size() && blocks[j].box.low[axis] <= blocks[i].box.high[axis]; ++j) {
      const Block &p = blocks[i], &q = blocks[j];
      if (!p.box.meets(q.box) || (p.surface != NONE && p.surface == q.surface)) continue;
      const ShapeInfo &one = b_.shape_infos[p.shape], &other = b_.shape_infos[q.shape];
      if (one.category != other.category || one.mask != other.mask) continue;  // not the same bodies feel both
      add_seams(p, q);
    }
  }
}

template <class real>
void SeamFinder<real>::add_seams(const Block& p, const Block& q) {
  const double tolerance = flush * std::min(p.smallest, q.smallest) + p.rounding + q.rounding;
  const Solid solid_p = solid_of(b_, p.shape), solid_q = solid_of(b_, q.shape);
  for (const bool swapped : {false, true}) {
    const Block &one = swapped ? q : p, &other = swapped ? p : q;
    const Frame frame = seen_from(other.frame, one.frame);
    if (!touches_an_edge(swapped ? solid_q : solid_p, swapped ? solid_p : solid_q, frame, tolerance)) continue;
    const Shape<real>& shape = b_.shapes[other.shape];
    Seam<real> seam = {};
    for (unsigned k = 0; k < 3; ++k) seam.offset[k] = static_cast<real>(frame.position[k]);
    seam.tolerance = static_cast<real>(tolerance);
    for (unsigned k = 0; k < 4; ++k) {
      seam.rotation[k] = static_cast<real>(frame.rotation[k]);
      seam.size[k] = shape.size[k];
    }
    seam.kind = b_.shape_infos[other.shape].kind;
    seam.hull = b_.shape_infos[other.shape].hull;
    seams_[one.shape][other.shape] = seam;
  }
}

// Whether the neighbours of a facet cover an edge all along, against what leans a little over it.
template <class real>
bool SeamFinder<real>::goes_on(u32 shape, const Solid& facet, u32 edge) const {
  const auto& [start, end] = facet.edges[edge];
  const Vector3 normal = facet.planes[0].first, out = facet.planes[2 + edge].first;
  const Vector3 up = unit(add(normal, scale(lean, out)));
  for (const double share : {0.05, 0.3, 0.5, 0.7, 0.95}) {
    const Vector3 point = add(start, scale(share, subtract(end, start)));
    const bool covered = std::ranges::any_of(seams_[shape], [&](const auto& entry) {
      const Seam<real>& seam = entry.second;
      const Frame frame = {
          {double(seam.offset[0]), double(seam.offset[1]), double(seam.offset[2])},
          {double(seam.rotation[0]), double(seam.rotation[1]), double(seam.rotation[2]), double(seam.rotation[3])}};
      return covers(solid_of(b_, entry.first), frame, point, up, double(seam.tolerance));
    });
    if (!covered) return false;
  }
  return true;
}

template <class real>
void SeamFinder<real>::join_surfaces() {
  for (u32 shape = 0; shape < seams_.size(); ++shape) {
    ShapeInfo& info = b_.shape_infos[shape];
    if (seams_[shape].empty() || info.kind != SHAPE_HULL || b_.hulls[info.hull].face_count != 1) continue;
    const Solid facet = solid_of(b_, shape);
    Hull hull = b_.hulls[info.hull];  // of this shape alone from here on
    std::array<Vec4<real>, 4> planes = {};
    std::copy_n(b_.hull_planes.begin() + hull.first_face, 4, planes.begin());
    bool changed = false;
    for (u32 edge = 0; edge < 3; ++edge) {
      if (vector(planes[1 + edge]) == facet.planes[0].first || !goes_on(shape, facet, edge)) continue;
      planes[1 + edge] = planes[0];
      planes[1 + edge].w = 0;
      changed = true;
    }
    if (!changed) continue;
    const u32 first_face = static_cast<u32>(b_.hull_faces.size());
    for (u32 k = 0; k < 4; ++k) b_.hull_faces.push_back(HullFace(b_.hull_faces[hull.first_face + k]));
    b_.hull_planes.insert(b_.hull_planes.end(), planes.begin(), planes.end());
    hull.first_face = first_face;
    info.hull = static_cast<u32>(b_.hulls.size());
    b_.hulls.push_back(hull);
  }
}

// Bodies that do not meet all that other static bodies meet: a joint or a rule keeps them from touching some.
std::set<u32> filtered_bodies(const Scene& scene) {
  std::set<u32> bodies;
  for (const JointDescription& joint : scene.joints) bodies.insert({joint.body_a, joint.body_b});
  for (const auto& pair : scene.passing) bodies.insert(pair.begin(), pair.end());
  return bodies;
}

// Which surface each shape of a scene is a facet of, a number that others do not have; NONE: it is no facet. The facets
// of a surface follow each other.
std::vector<u32> surfaces_of(const Scene& scene) {
  std::vector<u32> surfaces;
  u32 count = 0;
  for (const BodyDescription& body : scene.bodies) {
    const ShapeDescription* before = nullptr;
    for (const ShapeDescription& shape : body.shapes) {
      const bool facet = shape.kind == SHAPE_FACET;
      const bool follows = before && before->surface == shape.surface && before->facet + 1 == shape.facet;
      if (facet && !follows) ++count;
      surfaces.push_back(facet ? count : NONE);
      before = facet ? &shape : nullptr;
    }
  }
  return surfaces;
}

}  // namespace

template <class real>
void compile_seams(std::span<const Scene> worlds, InitialState<real>& state) {
  Buffers<real>& b = state.buffers;
  SeamFinder<real> finder(b);
  for (u32 world = 0; world < worlds.size(); ++world) {
    const WorldRange& range = b.world_ranges[world];
    const std::set<u32> filtered = filtered_bodies(worlds[world]);
    std::vector<Block> fixed;
    std::map<u32, std::vector<Block>> of_body;  // in its frame
    std::vector<u32> surfaces = surfaces_of(worlds[world]);
    for (u32 i = range.first_shape; i < range.first_shape + range.shape_count; ++i) {
      const ShapeInfo& info = b.shape_infos[i];
      const u32 kind = b.body_infos[info.body].kind, surface = surfaces[i - range.first_shape];
      const bool hull = info.kind == SHAPE_HULL && b.hulls[info.hull].edge_count > 0;
      if (kind == BODY_DYNAMIC || (info.flags & SHAPE_IS_TRIGGER) != 0 || (info.kind != SHAPE_BOX && !hull)) continue;
      const Shape<real>& shape = b.shapes[i];
      const Frame own = {
          {double(shape.offset[0]), double(shape.offset[1]), double(shape.offset[2])},
          {double(shape.rotation[0]), double(shape.rotation[1]), double(shape.rotation[2]), double(shape.rotation[3])}};
      if (kind == BODY_STATIC && !filtered.contains(info.body - range.first_body)) {
        const Vec4<real>& q = b.orientations[info.body];
        const Frame body = {vector(b.positions[info.body]), {double(q.x), double(q.y), double(q.z), double(q.w)}};
        fixed.push_back(finder.block_of(i, surface, within(body, own)));
      } else {
        of_body[info.body].push_back(finder.block_of(i, surface, own));
      }
    }
    finder.find(std::move(fixed));
    for (auto& [body, blocks] : of_body) finder.find(std::move(blocks));
  }
  finder.join_surfaces();
  finder.store();
  if (b.seams.empty()) return;
  state.features = with(state.features, Feature::seams);
  state.sizes.seams = static_cast<u32>(b.seams.size());
}

template void compile_seams<float>(std::span<const Scene>, InitialState<float>&);
template void compile_seams<double>(std::span<const Scene>, InitialState<double>&);

}  // namespace lockstep
