#include "host/scene/compile_seams.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <set>
#include <vector>

#include "host/scene/extents.hpp"
#include "host/scene/surface.hpp"

namespace lockstep {

namespace {

using exact::add, exact::cross, exact::dot, exact::length, exact::multiply, exact::rotate, exact::scale,
    exact::subtract, exact::unit;

// How far apart shapes may be that lie flush, as a share of the smallest half extent of the two.
// Where one moves by itself rounding carries the two apart.
constexpr double flush = 1e-4, flush_moving = 1e-3;
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
  u32 mover;    // the kinematic body whose shape it is, or NONE where the others are shapes of that body, too
  u32 surface;  // blocks of one surface know each other already
  Frame frame;
  Extents box;
  double smallest;  // half extent
  double width;     // the middle one of the three
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
  return solid;
}

template <class real>
Vector3 vector(const real* v) {
  return {double(v[0]), double(v[1]), double(v[2])};
}

template <class real>
Solid solid_facet(const Facet<real>& facet) {
  Solid solid;
  solid.facet = true;
  for (u32 k = 0; k < 3; ++k) solid.vertices.push_back(vector(facet.corners + 3 * k));
  const Vector3 normal = vector(facet.normal);
  solid.planes = {{normal, double(facet.height)}, {scale(-1, normal), -double(facet.height)}};
  for (u32 k = 0; k < 3; ++k) {
    const Vector3 &start = solid.vertices[k], &end = solid.vertices[(k + 1) % 3];
    solid.edges.push_back({start, end});
    const Vector3 across = unit(cross(subtract(end, start), normal));
    solid.planes.emplace_back(across, dot(across, start));
  }
  return solid;
}

bool is_facet(const ShapeInfo& info) { return info.kind == SHAPE_HULL && (info.hull & HULL_IS_FACET) != 0; }

template <class real>
Solid solid_of(const Buffers<real>& b, u32 shape) {
  const ShapeInfo& info = b.shape_infos[shape];
  if (is_facet(info)) return solid_facet(b.facets[info.hull & ~HULL_IS_FACET]);
  if (info.kind == SHAPE_HULL) return solid_hull(b.hulls[info.hull], b);
  const Shape<real>& box = b.shapes[shape];
  return solid_box({double(box.size[0]), double(box.size[1]), double(box.size[2])});
}

// How far beyond a plane in the frame of a solid it reaches, negative where it does not.
double height_above(const Solid& solid, const Vector3& normal, double offset) {
  double highest = -1e300;
  for (const Vector3& vertex : solid.vertices) highest = std::max(highest, dot(normal, vertex) - offset);
  return highest;
}

// Whether one solid has a face which the other one, in this frame, is not in front of, but close behind.
bool continues(const Solid& one, const Solid& other, const Frame& frame, double tolerance, double span) {
  const Quaternion back = inverse(frame.rotation);
  return std::ranges::any_of(
      one.planes.begin(), one.planes.begin() + (one.facet ? 1 : one.planes.size()), [&](const auto& plane) {
        const auto& [normal, offset] = plane;
        const double height = height_above(other, rotate(back, normal), offset - dot(normal, frame.position));
        return height <= tolerance && height >= -span;
      });
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
  explicit SeamFinder(Buffers<real>& b) : b_(b) {}

  /// How wide a gap the largest body of a world spans, from here on.
  void set_span(double span) { span_ = span; }

  /// Blocks that may lie flush.
  void find(std::vector<Block> blocks);

  /// Edges of facets over which another surface goes on are none that bodies can leave the surface by.
  void join_surfaces();

  void store() {
    if (seams_.empty()) return;
    bool some_move = false;
    for (const auto& [shape, neighbours] : seams_) {
      b_.seam_starts.resize(shape + 1, static_cast<u32>(b_.seams.size()));
      b_.shape_infos[shape].flags |= SHAPE_HAS_SEAMS;
      for (const auto& [neighbour, found] : neighbours) {
        b_.seams.push_back(found.seam);
        b_.seam_sides.push_back({shape, found.moves ? neighbour : NONE});
        some_move = some_move || found.moves;
      }
    }
    b_.seam_starts.resize(b_.shapes.size() + 1, static_cast<u32>(b_.seams.size()));
    if (!some_move) b_.seam_sides.clear();
  }

  Block block_of(u32 shape, u32 mover, u32 surface, const Frame& frame) const;

 private:
  void add_seams(const Block& one, const Block& other);
  bool goes_on(u32 shape, const Solid& facet, u32 edge) const;

  Buffers<real>& b_;
  double span_ = 0;
  // of a shape, by neighbour
  struct Found {
    Seam<real> seam;
    bool moves;  // its neighbour moves by itself
  };
  std::map<u32, std::map<u32, Found>> seams_;
};

template <class real>
Block SeamFinder<real>::block_of(u32 shape, u32 mover, u32 surface, const Frame& frame) const {
  const Shape<real>& record = b_.shapes[shape];
  Block block = {shape, mover, surface, frame, {frame.position, frame.position}, 1e300, 0, 0};
  Vector3 half = {0, 0, 0};
  for (unsigned axis = 0; axis < 3; ++axis) {
    Vector3 side = {0, 0, 0};
    side[axis] = double(record.size[axis]);
    block.smallest = std::min(block.smallest, side[axis]);
    const Vector3 rotated = rotate(frame.rotation, side);
    for (unsigned k = 0; k < 3; ++k) half[k] += std::abs(rotated[k]);
  }
  std::array<double, 3> sides = {double(record.size[0]), double(record.size[1]), double(record.size[2])};
  std::ranges::sort(sides);
  block.width = sides[1];
  if (surface != NONE) {  // half the height of the triangle
    const Facet<real>& facet = b_.facets[b_.shape_infos[shape].hull & ~HULL_IS_FACET];
    const Vector3 v[] = {vector(facet.corners), vector(facet.corners + 3), vector(facet.corners + 6)};
    double longest = 0;
    for (u32 k = 0; k < 3; ++k) longest = std::max(longest, length(subtract(v[(k + 1) % 3], v[k])));
    block.smallest = block.width = 0.5 * length(cross(subtract(v[1], v[0]), subtract(v[2], v[0]))) / longest;
  }
  block.rounding = 4 * double(std::numeric_limits<real>::epsilon()) * (length(frame.position) + length(half));
  const double wider = std::max(flush_moving * block.smallest, 0.5 * std::min(span_, block.width)) + block.rounding;
  for (unsigned k = 0; k < 3; ++k) {
    block.box.low[k] -= half[k] + wider;
    block.box.high[k] += half[k] + wider;
  }
  return block;
}

template <class real>
void SeamFinder<real>::find(std::vector<Block> blocks) {
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
      if (p.mover != NONE && p.mover == q.mover) continue;  // found in the frame of the body
      const ShapeInfo &one = b_.shape_infos[p.shape], &other = b_.shape_infos[q.shape];
      if (one.category != other.category || one.mask != other.mask) continue;  // not the same bodies feel both
      add_seams(p, q);
    }
  }
}

template <class real>
void SeamFinder<real>::add_seams(const Block& p, const Block& q) {
  const bool moves = p.mover != q.mover;
  const double tolerance = (moves ? flush_moving : flush) * std::min(p.smallest, q.smallest) + p.rounding + q.rounding;
  const double span = std::min({span_, p.width, q.width});  // nothing spans a gap of the size of the blocks
  const Solid solid_p = solid_of(b_, p.shape), solid_q = solid_of(b_, q.shape);
  for (const bool swapped : {false, true}) {
    const Block &one = swapped ? q : p, &other = swapped ? p : q;
    const Frame frame = seen_from(other.frame, one.frame);
    const Solid &own = swapped ? solid_q : solid_p, &covering = swapped ? solid_p : solid_q;
    const bool touches = touches_an_edge(own, covering, frame, tolerance);
    if (!touches && moves) continue;
    if (!touches && !(touches_an_edge(own, covering, frame, span) &&
                      continues(covering, own, seen_from(one.frame, other.frame), tolerance, span)))
      continue;
    const Shape<real>& shape = b_.shapes[other.shape];
    Seam<real> seam = {};
    for (unsigned k = 0; k < 3; ++k) seam.offset[k] = static_cast<real>(frame.position[k]);
    seam.tolerance = static_cast<real>(tolerance);
    seam.has_gap = touches ? 0 : 1;
    for (unsigned k = 0; k < 4; ++k) {
      seam.rotation[k] = static_cast<real>(frame.rotation[k]);
      seam.size[k] = shape.size[k];
    }
    seam.kind = b_.shape_infos[other.shape].kind;
    seam.hull = b_.shape_infos[other.shape].hull;
    seams_[one.shape][other.shape] = {seam, moves};
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
    const bool covered = std::ranges::any_of(seams_.at(shape), [&](const auto& entry) {
      const Seam<real>& seam = entry.second.seam;
      if (seam.has_gap != 0 || entry.second.moves) return false;
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
  for (const auto& [shape, neighbours] : seams_) {
    ShapeInfo& info = b_.shape_infos[shape];
    if (!is_facet(info)) continue;
    const Solid solid = solid_of(b_, shape);
    Facet<real> facet = b_.facets[info.hull & ~HULL_IS_FACET];  // of this shape alone from here on
    bool changed = false;
    for (u32 edge = 0; edge < 3; ++edge) {
      const u32 kind = facet.flags >> FACET_EDGE_SHIFT(edge) & 3;
      const real* across = facet.normal;
      if (kind == FACET_EDGE_ROOF) across = b_.facets[facet.next[edge] >> 2].normal;
      if (kind == FACET_EDGE_STORED) across = b_.facet_edges[facet.next[edge]].across;
      if (vector(across) == solid.planes[0].first || !goes_on(shape, solid, edge)) continue;
      if (kind == FACET_EDGE_STORED) facet.next[edge] = b_.facet_edges[facet.next[edge]].next;
      facet.flags &= ~(3u << FACET_EDGE_SHIFT(edge));
      changed = true;
    }
    if (!changed) continue;
    info.hull = HULL_IS_FACET | static_cast<u32>(b_.facets.size());
    b_.facets.push_back(facet);
  }
}

// Bodies that do not meet all that other static bodies meet: a joint or a rule keeps them from touching some.
std::set<u32> filtered_bodies(const Scene& scene) {
  std::set<u32> bodies;
  for (const JointDescription& joint : scene.joints) bodies.insert({joint.body_a, joint.body_b});
  for (const auto& pair : scene.passing) bodies.insert(pair.begin(), pair.end());
  return bodies;
}

// Shapes one behind the other: the facets of a surface, or one that is none.
struct Member {
  u32 first, count;
  bool surface;
};

// What may lie flush with each other: static bodies and kinematic ones that move as they do, all by one velocity; or
// the shapes of one body, in its frame.
using Group = std::vector<Member>;

// Blocks of a group: all but the facets that are in no box around another surface or block. `block_of` makes one of a
// shape and the number of its surface, or NONE.
template <class BlockOf>
std::vector<Block> near_others(const Group& group, BlockOf&& block_of) {
  std::vector<Block> near;
  if (group.size() < 2) return near;
  std::vector<Extents> boxes(group.size());
  const auto for_each_block = [&](u32 m, auto&& function) {
    for (u32 i = group[m].first; i < group[m].first + group[m].count; ++i)
      function(block_of(i, group[m].surface ? m : NONE));
  };
  for (u32 m = 0; m < group.size(); ++m) for_each_block(m, [&](const Block& block) { boxes[m].unite(block.box); });
  for (u32 m = 0; m < group.size(); ++m) {
    std::vector<Extents> others;
    for (u32 other = 0; group[m].surface && other < group.size(); ++other)
      if (other != m && boxes[m].meets(boxes[other])) others.push_back(boxes[other]);
    if (group[m].surface && others.empty()) continue;
    for_each_block(m, [&](const Block& block) {
      const auto meets = [&](const Extents& box) { return block.box.meets(box); };
      if (!group[m].surface || std::ranges::any_of(others, meets)) near.push_back(block);
    });
  }
  return near;
}

template <class real>
Frame frame_in_body(const Buffers<real>& b, u32 i) {
  const Shape<real>& shape = b.shapes[i];
  return {vector(shape.offset),
          {double(shape.rotation[0]), double(shape.rotation[1]), double(shape.rotation[2]), double(shape.rotation[3])}};
}

// Those of a world whose shapes begin with `first`.
template <class real>
void find_seams(const Scene& scene, u32 first, const Buffers<real>& b, SeamFinder<real>& finder) {
  const std::set<u32> filtered = filtered_bodies(scene);
  std::map<Vector3, Group> of_velocity;
  std::map<u32, Group> of_body;
  double largest = 0;  // of those that come
  for (u32 index = 0; index < scene.bodies.size(); ++index) {
    const BodyDescription& body = scene.bodies[index];
    for (const ShapeDescription& shape : body.shapes) {
      const Member member = {first, static_cast<u32>(simulated_shapes(shape)), shape.kind == SHAPE_FACET};
      first += member.count;
      for (u32 i = member.first; body.kind == BODY_DYNAMIC && i < first; ++i)
        largest = std::max(largest, length(vector(b.shapes[i].size)));
      const ShapeInfo& info = b.shape_infos[member.first];
      const bool hull = is_facet(info) || (info.kind == SHAPE_HULL && b.hulls[info.hull].edge_count > 0);
      if (body.kind == BODY_DYNAMIC || shape.trigger || (info.kind != SHAPE_BOX && !hull)) continue;
      const bool alone = filtered.contains(index), rotates = body.angular_velocity != Vector3{0, 0, 0};
      if (alone || body.kind == BODY_KINEMATIC) of_body[index].push_back(member);
      if (alone || (body.kind == BODY_KINEMATIC && rotates)) continue;
      of_velocity[body.kind == BODY_KINEMATIC ? body.velocity : Vector3{0, 0, 0}].push_back(member);
    }
  }
  finder.set_span(SEAM_SPAN * largest);
  for (const auto& [velocity, group] : of_velocity)
    finder.find(near_others(group, [&](u32 i, u32 surface) {
      const u32 index = b.shape_infos[i].body;
      const Vec4<real>& q = b.orientations[index];
      const Frame body = {vector(b.positions[index]), {double(q.x), double(q.y), double(q.z), double(q.w)}};
      const u32 mover = b.body_infos[index].kind == BODY_KINEMATIC ? index : NONE;
      return finder.block_of(i, mover, surface, within(body, frame_in_body(b, i)));
    }));
  for (const auto& [body, group] : of_body)
    finder.find(
        near_others(group, [&](u32 i, u32 surface) { return finder.block_of(i, NONE, surface, frame_in_body(b, i)); }));
}

}  // namespace

template <class real>
void compile_seams(std::span<const Scene> worlds, InitialState<real>& state) {
  Buffers<real>& b = state.buffers;
  SeamFinder<real> finder(b);
  for (u32 world = 0; world < worlds.size(); ++world)
    find_seams(worlds[world], b.world_ranges[world].first_shape, b, finder);
  finder.join_surfaces();
  finder.store();
  if (b.seams.empty()) return;
  state.features = with(state.features, Feature::seams);
  if (!b.seam_sides.empty()) state.features = with(state.features, Feature::moving_seams);
  state.sizes.seams = static_cast<u32>(b.seams.size());
}

template void compile_seams<float>(std::span<const Scene>, InitialState<float>&);
template void compile_seams<double>(std::span<const Scene>, InitialState<double>&);

}  // namespace lockstep
