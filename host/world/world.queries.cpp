// What is in a world, between two steps.
#include "host/scene/sensors.hpp"
#include "host/world/impl.hpp"

namespace lockstep {

std::span<const Pose> World::poses() { return impl_->current_poses(); }
std::span<const Twist> World::velocities() { return impl_->current_velocities(); }

Pose World::pose(BodyHandle body) {
  const u32 index = impl_->bodies.index(body);
  return poses()[index];
}

Twist World::velocity(BodyHandle body) {
  const u32 index = impl_->bodies.index(body);
  return velocities()[index];
}

bool World::is_asleep(BodyHandle body) {
  const u32 index = impl_->bodies.index(body);
  return impl_->ready().asleep()[index] && !impl_->new_velocities.contains(index);
}

std::span<const BodyContact> World::contacts() {
  impl_->keep_contacts_and_events();
  return impl_->contacts;
}

Vector3 World::contact_force(BodyHandle body, std::optional<u32> shape) {
  const std::size_t shapes = description(body).shapes.size();
  if (shape && *shape >= shapes)
    throw Error(Failure::input, impl_->called(body),
                "has no shape " + std::to_string(*shape) + ", its shapes are " + std::to_string(shapes));
  Vector3 impulse = {0, 0, 0};
  for (const BodyContact& contact : contacts()) {
    if (contact.a == body && (!shape || contact.shape_a == *shape)) impulse = exact::add(impulse, contact.impulse);
    if (contact.b == body && (!shape || contact.shape_b == *shape)) impulse = exact::subtract(impulse, contact.impulse);
  }
  return exact::scale(1 / impulse_time(impl_->scene), impulse);
}

std::span<const BodyEvent> World::events() {
  impl_->keep_contacts_and_events();
  return impl_->events;
}

std::optional<BodyHit> World::cast_ray(const Vector3& origin, const Vector3& direction, double length, u32 mask) {
  const BodyRay ray = {origin, direction, length, mask};
  return cast_rays({&ray, 1})[0];
}

std::vector<std::optional<BodyHit>> World::cast_rays(std::span<const BodyRay> rays) {
  impl_->ask_for_shapes();
  std::vector<RayQuery> queries;
  for (const BodyRay& ray : rays) queries.push_back({ray.origin, ray.direction, ray.length, ray.mask});
  std::vector<std::optional<BodyHit>> hits;
  for (const std::optional<EngineHit>& hit : impl_->ready().cast_rays(queries)) {
    hits.emplace_back();
    if (hit)
      hits.back() = {impl_->bodies[hit->of.body], hit->of.shape, hit->distance, hit->point, hit->normal,
                     Impl::triangle_of(hit->of)};
  }
  return hits;
}

std::vector<BodyHandle> World::overlapping_sphere(const Vector3& center, double radius, u32 mask) {
  return impl_->bodies_in({.kind = SHAPE_SPHERE, .center = center, .radius = radius, .mask = mask});
}

std::vector<BodyHandle> World::overlapping_box(const Pose& pose, const Vector3& half_extents, u32 mask) {
  return impl_->bodies_in({.kind = SHAPE_BOX,
                           .center = pose.position,
                           .rotation = pose.orientation,
                           .half_extents = half_extents,
                           .mask = mask});
}

JointState World::state(JointHandle joint) {
  const u32 index = impl_->joints.index(joint);
  Engine& engine = impl_->ready();
  impl_->hand_over_velocities();
  return engine.joint_state(index);
}

StepErrors World::errors() {
  Engine& engine = impl_->ready();
  impl_->hand_over_velocities();
  return engine.errors();
}

WorldDevice World::device() { return impl_->ready().device(); }

std::uint64_t World::state_hash() {
  Engine& engine = impl_->ready();
  impl_->hand_over_velocities();
  return engine.state_hash();
}

}  // namespace lockstep
