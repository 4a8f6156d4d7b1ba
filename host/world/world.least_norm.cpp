// The contact impulses that do the same with the least norm.
#include <limits>
#include <tuple>

#include "host/report/least_norm.hpp"
#include "host/scene/friction_pairs.hpp"
#include "host/world/impl.hpp"

namespace lockstep {

namespace {

using Eigen::Vector3d;

// What is this close, in parts of its distance from the centre of mass, touches: as near as solvers let resting bodies
// be (the slop of a cube is 2e-4 of half its edge).
constexpr double touching_share = 2e-4;

Vector3d vector(const Vector3& v) { return {v[0], v[1], v[2]}; }

Vector3d x_axis_of(const Pose& pose, const ShapeDescription& shape) {
  return vector(exact::rotate(pose.orientation, exact::rotate(shape.rotation, {1, 0, 0})));
}

}  // namespace

std::vector<BodyContact> World::least_norm_contacts() {
  const std::span<const BodyContact> told = contacts();
  std::vector<BodyContact> all(told.begin(), told.end());
  if (all.empty()) return all;
  const Scene& scene = impl_->scene;
  const std::vector<Pose>& poses = impl_->current_poses();
  const std::vector<PairFriction> frictions = friction_pairs_of(scene);
  const std::size_t materials = std::max<std::size_t>(scene.materials.size(), 1);

  std::vector<SharedContact> shared;
  std::vector<std::size_t> index_of;  // into all
  for (std::size_t i = 0; i < all.size(); ++i) {
    const BodyContact& contact = all[i];
    if (!contains(contact.a) || !contains(contact.b)) continue;
    const u32 a = impl_->bodies.index(contact.a), b = impl_->bodies.index(contact.b);
    const BodyDescription &body_a = scene.bodies[a], &body_b = scene.bodies[b];
    if (contact.shape_a >= body_a.shapes.size() || contact.shape_b >= body_b.shapes.size()) continue;
    SharedContact one = {.point = vector(contact.point), .normal = vector(contact.normal)};
    double arm = std::numeric_limits<double>::infinity();
    for (const auto& [body, index, id] : {std::tuple(&body_a, a, &one.body_a), std::tuple(&body_b, b, &one.body_b)}) {
      if (body->kind != BODY_DYNAMIC) continue;
      *id = index;
      arm = std::min(arm, (one.point - vector(poses[index].position)).norm());
    }
    one.impulse = vector(contact.impulse);
    const bool carries = one.impulse.dot(one.normal) > 0;
    if (!carries && !(one.impulse == Vector3d::Zero() && contact.gap <= touching_share * arm)) continue;
    const ShapeDescription &shape_a = body_a.shapes[contact.shape_a], &shape_b = body_b.shapes[contact.shape_b];
    const PairFriction& friction = frictions[shape_a.material * materials + shape_b.material];
    one.axis = friction.axis_of_b ? x_axis_of(poses[b], shape_b) : x_axis_of(poses[a], shape_a);
    one.along = friction.perpendicular ? 0 : friction.static_friction;
    one.across = friction.static_friction * (friction.perpendicular ? 1 : friction.across);
    shared.push_back(one);
    index_of.push_back(i);
  }
  const std::vector<Vector3d> impulses = least_norm_impulses(shared);
  for (std::size_t k = 0; k < impulses.size(); ++k)
    all[index_of[k]].impulse = {impulses[k].x(), impulses[k].y(), impulses[k].z()};
  return all;
}

}  // namespace lockstep
