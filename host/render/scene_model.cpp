#include "host/render/scene_model.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "host/render/in_float.hpp"

namespace lockstep {

using Eigen::Quaternionf;
using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

Pattern pattern_of(ShapeKind kind) {
  switch (kind) {
    case SHAPE_SPHERE: return Pattern::fields;
    case SHAPE_BOX: return Pattern::edges;
    case SHAPE_CYLINDER: return Pattern::wedges;
    default: return Pattern::none;
  }
}

// Half the edges of the box around a shape, in its frame; of a sphere in any.
Vector3f half_size(ShapeKind kind, const Vector3f& size) {
  switch (kind) {
    case SHAPE_SPHERE: return Vector3f::Constant(size.x());
    case SHAPE_CAPSULE: return {size.x(), size.x(), size.x() + size.y()};
    case SHAPE_CYLINDER: return {size.x(), size.x(), size.y()};
    default: return size;
  }
}

template <class real>
bool is_facet(const Buffers<real>& scene, std::size_t shape) {
  const ShapeInfo& info = scene.shape_infos[shape];
  return info.kind == SHAPE_HULL && (info.hull & HULL_IS_FACET) != 0;
}

// Half the edges of the box of this mass and these moments about its centre; none shorter than a twentieth of the
// longest, so that what has no thickness is seen.
Vector3f box_of_moments(double mass, const Vector3d& moments) {
  const double sum = 0.5 * moments.sum();
  Vector3d half;
  for (int i = 0; i < 3; ++i) half[i] = std::sqrt(std::max(3 * (sum - moments[i]) / mass, 0.0));
  return half.cwiseMax(0.05 * half.maxCoeff()).cast<float>();
}

}  // namespace

template <class real>
std::vector<RenderPose> poses_of(const std::vector<Vec4<real>>& positions,
                                 const std::vector<Vec4<real>>& orientations) {
  std::vector<RenderPose> poses(positions.size());
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const Vec4<real>& q = orientations[i];
    poses[i] = {vector3f(positions[i]), rotationf(q)};
  }
  return poses;
}

template <class real>
SceneModel::SceneModel(const Buffers<real>& scene) {
  for (const BodyInfo& info : scene.body_infos) {
    movable_.push_back(info.kind == BODY_DYNAMIC);
    ids_.push_back(info.id);
  }
  const Vector3f gravity = scene.gravities.empty() ? Vector3f::Zero() : vector3f(scene.gravities[0]);
  if (gravity.norm() > 0) up_ = -gravity.normalized();
  add_hulls(scene);
  add_shapes(scene);
  add_surfaces(scene);
  std::vector<bool> has_shape(movable_.size(), false);
  for (const DrawnShape& drawn : drawn_shapes_) has_shape[drawn.body] = true;
  for (u32 body = 0; body < bodies(); ++body) {
    if (!has_shape[body] && movable_[body]) add_bare_body(scene, body);
  }
}

template <class real>
void SceneModel::add_shapes(const Buffers<real>& scene) {
  for (std::size_t i = 0; i < scene.shapes.size(); ++i) {
    if (is_facet(scene, i)) continue;
    const Shape<real>& shape = scene.shapes[i];
    const ShapeInfo& info = scene.shape_infos[i];
    const real* q = shape.rotation;
    drawn_shapes_.push_back({info.body, static_cast<ShapeKind>(info.kind), info.hull, vector3f(shape.offset),
                             rotationf(q), vector3f(shape.size), (info.flags & SHAPE_IS_TRIGGER) != 0});
  }
}

// The facets of a body in a row are drawn as one mesh, in its frame but for the middle.
template <class real>
void SceneModel::add_surfaces(const Buffers<real>& scene) {
  const std::size_t shapes = scene.shapes.size();
  for (std::size_t i = 0; i < shapes;) {
    const u32 body = scene.shape_infos[i].body;
    std::vector<Vector3f> points;
    std::vector<u32> first = {0}, corners;
    for (; i < shapes && scene.shape_infos[i].body == body && is_facet(scene, i); ++i) {
      const Facet<real>& facet = scene.facets[scene.shape_infos[i].hull & ~HULL_IS_FACET];
      const Shape<real>& shape = scene.shapes[i];
      for (u32 k = 0; k < 3; ++k) {
        corners.push_back(static_cast<u32>(points.size()));
        points.push_back(vector3f(shape.offset) + rotationf(&shape.rotation[0]) * vector3f(facet.corners + 3 * k));
      }
      first.push_back(static_cast<u32>(corners.size()));
    }
    if (points.empty()) {
      ++i;
      continue;
    }
    Eigen::AlignedBox3f box;
    for (const Vector3f& p : points) box.extend(p);
    for (Vector3f& p : points) p -= box.center();
    drawn_shapes_.push_back({body, SHAPE_HULL, static_cast<u32>(hulls_.size()), box.center(), Quaternionf::Identity(),
                             0.5f * box.sizes(), false});
    hulls_.push_back(polytope_mesh(points, first, corners));
  }
}

template <class real>
void SceneModel::add_hulls(const Buffers<real>& scene) {
  for (const Hull& hull : scene.hulls) {
    std::vector<Vector3f> points;
    for (u32 i = 0; i < hull.vertex_count; ++i) points.push_back(vector3f(scene.hull_vertices[hull.first_vertex + i]));
    std::vector<u32> first = {0}, corners;
    for (u32 i = 0; i < hull.face_count; ++i) {
      const HullFace& face = scene.hull_faces[hull.first_face + i];
      for (u32 k = 0; k < face.corner_count; ++k) corners.push_back(scene.hull_corners[face.first_corner + k]);
      first.push_back(static_cast<u32>(corners.size()));
    }
    hulls_.push_back(polytope_mesh(points, first, corners));
  }
}

template <class real>
void SceneModel::add_bare_body(const Buffers<real>& scene, u32 body) {
  const Mass<real>& mass = scene.masses[body];
  Vector3d moments(double(mass.inertia[0]), double(mass.inertia[1]), double(mass.inertia[2]));
  Vector3f com_offset = Vector3f::Zero();
  if (!scene.pivots.empty() && scene.pivots[body].pivoted != real(0)) {
    com_offset = vector3f(scene.pivots[body].com_offset_body);
    const Vector3d l = com_offset.cast<double>();
    for (int i = 0; i < 3; ++i) moments[i] -= double(mass.mass) * (l.squaredNorm() - l[i] * l[i]);
  }
  const float length = com_offset.norm();
  // moments that rounding left of a point, seen from a pivot, are no size
  Vector3f half = box_of_moments(double(mass.mass), moments.cwiseMax(0));
  const bool is_point = half.maxCoeff() < 0.02f * length;
  if (is_point) half.setConstant(0.06f * length);
  drawn_shapes_.push_back(
      {body, is_point ? SHAPE_SPHERE : SHAPE_BOX, 0, Vector3f::Zero(), Quaternionf::Identity(), half, false});
  if (length <= 0) return;
  drawn_shapes_.push_back({body, SHAPE_CYLINDER, 0, -0.5f * com_offset,
                           Quaternionf::FromTwoVectors(Vector3f::UnitZ(), com_offset),
                           Vector3f(0.015f * length, 0.5f * length, 0), false});
}

void SceneModel::add_meshes_to(Renderer& renderer) {
  hull_numbers_.clear();
  for (const Mesh& hull : hulls_) hull_numbers_.push_back(hull.indices.empty() ? 0 : renderer.add_hull(hull));
}

bool SceneModel::has_planes() const {
  return std::any_of(drawn_shapes_.begin(), drawn_shapes_.end(),
                     [](const DrawnShape& drawn) { return drawn.kind == SHAPE_PLANE; });
}

std::vector<Extent> SceneModel::extents(std::span<const RenderPose> poses) const {
  std::vector<u32> all(bodies());
  std::iota(all.begin(), all.end(), 0u);
  return extents(poses, all);
}

std::vector<Extent> SceneModel::extents(std::span<const RenderPose> poses, std::span<const u32> bodies) const {
  std::vector<bool> asked(movable_.size(), false);
  for (const u32 body : bodies) asked[body] = true;
  std::vector<Extent> extents;
  for (const DrawnShape& drawn : drawn_shapes_) {
    if (drawn.kind == SHAPE_PLANE || !asked[drawn.body]) continue;
    const RenderPose& pose = poses[drawn.body];
    const Vector3f center = pose.position + pose.rotation * drawn.offset;
    if (!center.allFinite()) continue;
    Vector3f half = half_size(drawn.kind, drawn.size);
    if (drawn.kind != SHAPE_SPHERE) half = (pose.rotation * drawn.rotation).toRotationMatrix().cwiseAbs() * half;
    extents.push_back({center.cast<double>(), half.cast<double>(), movable_[drawn.body]});
  }
  return extents;
}

void SceneModel::draw_capsule(const DrawnShape& drawn, const Solid& solid, Drawing& drawing) const {
  const float radius = drawn.size.x(), half = drawn.size.y();
  Solid piece = solid;
  piece.form = Form::tube;
  piece.scale = {radius, radius, half};
  drawing.solids.push_back(piece);
  piece.form = Form::hemisphere;
  piece.scale.setConstant(radius);
  piece.position = solid.position + solid.rotation * Vector3f(0, 0, half);
  drawing.solids.push_back(piece);
  piece.position = solid.position - solid.rotation * Vector3f(0, 0, half);
  piece.rotation = solid.rotation * Quaternionf(0, 1, 0, 0);  // half a turn about x
  drawing.solids.push_back(piece);
}

void SceneModel::draw_shape(const DrawnShape& drawn, const RenderPose& pose, const Look& look, bool patterned,
                            Drawing& drawing) const {
  Solid solid;
  solid.position = pose.position + pose.rotation * drawn.offset;
  solid.rotation = pose.rotation * drawn.rotation;
  if (!solid.position.allFinite()) return;
  solid.color = look.color;
  solid.alpha = drawn.trigger ? 0.3f : look.alpha;
  const bool is_box = drawn.kind == SHAPE_BOX;  // stacked boxes of one colour need their edges
  solid.pattern = patterned || is_box ? pattern_of(drawn.kind) : Pattern::none;
  switch (drawn.kind) {
    case SHAPE_PLANE:
      if (!drawn.trigger) drawing.planes.push_back({solid.position, solid.rotation});
      return;
    case SHAPE_CAPSULE: draw_capsule(drawn, solid, drawing); return;
    case SHAPE_SPHERE: solid.scale.setConstant(drawn.size.x()); break;
    case SHAPE_BOX:
      solid.form = Form::box;
      solid.scale = drawn.size;
      break;
    case SHAPE_CYLINDER:
      solid.form = Form::cylinder;
      solid.scale = {drawn.size.x(), drawn.size.x(), drawn.size.y()};
      break;
    default:
      solid.form = Form::hull;
      solid.hull = drawn.hull;
      break;
  }
  drawing.solids.push_back(solid);
}

void SceneModel::draw(std::span<const RenderPose> poses, std::span<const Look> looks, bool patterned,
                      Drawing& drawing) const {
  drawing.up = up_;
  const std::size_t before = drawing.solids.size();
  for (const DrawnShape& drawn : drawn_shapes_) {
    if (looks[drawn.body].shown) draw_shape(drawn, poses[drawn.body], looks[drawn.body], patterned, drawing);
  }
  for (std::size_t i = before; i < drawing.solids.size(); ++i) {
    Solid& solid = drawing.solids[i];
    if (solid.form == Form::hull) solid.hull = hull_numbers_[solid.hull];
  }
}

std::vector<OwnSolids> SceneModel::own_solids(std::span<const Look> looks) const {
  std::vector<OwnSolids> own(bodies());
  for (const DrawnShape& drawn : drawn_shapes_) {
    if (!looks[drawn.body].shown) continue;
    Drawing drawing;
    draw_shape(drawn, {}, looks[drawn.body], false, drawing);
    OwnSolids& body = own[drawn.body];
    body.solids.insert(body.solids.end(), drawing.solids.begin(), drawing.solids.end());
    body.planes.insert(body.planes.end(), drawing.planes.begin(), drawing.planes.end());
  }
  return own;
}

#define INSTANTIATE(real)                                                                                    \
  template std::vector<RenderPose> poses_of(const std::vector<Vec4<real>>&, const std::vector<Vec4<real>>&); \
  template SceneModel::SceneModel(const Buffers<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
