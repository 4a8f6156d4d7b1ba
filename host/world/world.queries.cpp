// What is in a world, between two steps.
#include "host/world/parts.hpp"

namespace lockstep {

std::span<const Pose> World::poses() { return parts_->current_poses(); }
std::span<const Twist> World::velocities() { return parts_->current_velocities(); }

Pose World::pose(BodyHandle body) {
  const u32 index = parts_->bodies.index(body);
  return poses()[index];
}

Twist World::velocity(BodyHandle body) {
  const u32 index = parts_->bodies.index(body);
  return velocities()[index];
}

bool World::is_asleep(BodyHandle body) {
  const u32 index = parts_->bodies.index(body);
  return parts_->ready().asleep()[index] && !parts_->new_velocities.contains(index);
}

std::span<const BodyContact> World::contacts() {
  parts_->keep_contacts_and_events();
  return parts_->contacts;
}

std::span<const BodyEvent> World::events() {
  parts_->keep_contacts_and_events();
  return parts_->events;
}

std::optional<BodyHit> World::cast_ray(const Vector3& origin, const Vector3& direction, double length, u32 mask) {
  const BodyRay ray = {origin, direction, length, mask};
  return cast_rays({&ray, 1})[0];
}

std::vector<std::optional<BodyHit>> World::cast_rays(std::span<const BodyRay> rays) {
  std::vector<RayQuery> queries;
  for (const BodyRay& ray : rays) queries.push_back({ray.origin, ray.direction, ray.length, ray.mask});
  std::vector<std::optional<BodyHit>> hits;
  for (const std::optional<EngineHit>& hit : parts_->ready().cast_rays(queries)) {
    hits.emplace_back();
    if (hit) hits.back() = {parts_->bodies[hit->body], hit->shape, hit->distance, hit->point, hit->normal};
  }
  return hits;
}

std::vector<BodyHandle> World::overlapping_sphere(const Vector3& center, double radius, u32 mask) {
  return parts_->bodies_in({.kind = SHAPE_SPHERE, .center = center, .radius = radius, .mask = mask});
}

std::vector<BodyHandle> World::overlapping_box(const Pose& pose, const Vector3& half_extents, u32 mask) {
  return parts_->bodies_in({.kind = SHAPE_BOX,
                            .center = pose.position,
                            .rotation = pose.orientation,
                            .half_extents = half_extents,
                            .mask = mask});
}

JointState World::state(JointHandle joint) {
  const u32 index = parts_->joints.index(joint);
  Engine& engine = parts_->ready();
  parts_->hand_over_velocities();
  return engine.joint_state(index);
}

StepErrors World::errors() {
  Engine& engine = parts_->ready();
  parts_->hand_over_velocities();
  return engine.errors();
}

WorldDevice World::device() { return parts_->ready().device(); }

std::uint64_t World::state_hash() {
  Engine& engine = parts_->ready();
  parts_->hand_over_velocities();
  return engine.state_hash();
}

}  // namespace lockstep
