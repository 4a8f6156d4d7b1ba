#include "host/world/migrate_state.hpp"

#include <algorithm>

#include "host/scene/step_params.hpp"
#include "host/sleepers.hpp"

namespace lockstep {

namespace {

constexpr u32 in_blocks(u32 count) { return (count + PACK - 1) / PACK * PACK; }

// Which shape each old one has become. The shapes of a body stand together, in their order.
template <class real>
std::vector<u32> new_shapes(const InitialState<real>& old, std::span<const u32> new_body,
                            const InitialState<real>& current) {
  std::vector<u32> first(current.sizes.bodies, NONE);
  for (u32 s = current.sizes.shapes; s-- > 0;) first[current.buffers.shape_infos[s].body] = s;
  std::vector<u32> became(old.sizes.shapes, NONE);
  u32 of_body = 0;
  for (u32 s = 0; s < old.sizes.shapes; ++s) {
    const u32 body = old.buffers.shape_infos[s].body;
    of_body = s > 0 && old.buffers.shape_infos[s - 1].body == body ? of_body + 1 : 0;
    if (new_body[body] != NONE && first[new_body[body]] != NONE) became[s] = first[new_body[body]] + of_body;
  }
  return became;
}

// Of a pair that is a record's, the one it has become; false where it is gone.
template <class Record>
bool rename(Record& record, const std::vector<u32>& new_shape) {
  record.shape_a = new_shape[record.shape_a];
  record.shape_b = new_shape[record.shape_b];
  return record.shape_a != NONE && record.shape_b != NONE;
}

// Impulses of contacts, and their moments and places where they are kept, by pairs of shapes.
template <class real>
struct KeptImpulses {
  std::vector<ContactKey> keys;
  std::vector<ContactImpulse<real>> impulses;
  std::vector<Vec4<real>> moments;
  std::vector<ContactPoint<real>> points;

  // Those of pairs that are still there.
  KeptImpulses(u32 count, const std::vector<ContactKey>& from_keys, const std::vector<ContactImpulse<real>>& from,
               const std::vector<Vec4<real>>& from_moments, const std::vector<ContactPoint<real>>& from_points,
               const std::vector<u32>& new_shape) {
    for (u32 k = 0; k < count; ++k) {
      ContactKey key = from_keys[k];
      if (!rename(key, new_shape)) continue;
      keys.push_back(key);
      impulses.push_back(from[k]);
      if (!from_moments.empty()) moments.push_back(from_moments[k]);
      if (!from_points.empty()) points.push_back(from_points[k]);
    }
  }

  u32 count() const { return static_cast<u32>(keys.size()); }

  void copy_to(std::vector<u32>& to_count, std::vector<ContactKey>& to_keys, std::vector<ContactImpulse<real>>& to,
               std::vector<Vec4<real>>& to_moments) const {
    to_count[0] = count();
    std::ranges::copy(keys, to_keys.begin());
    std::ranges::copy(impulses, to.begin());
    if (!to_moments.empty()) std::ranges::copy(moments, to_moments.begin());
  }
};

template <class real>
void migrate_contacts(const Buffers<real>& from, const std::vector<u32>& new_shape, InitialState<real>& state) {
  const KeptImpulses<real> cached(from.cached_count[0], from.cached_keys, from.cached_impulses, from.cached_moments, {},
                                  new_shape);
  const bool sleeping = !from.slept_count.empty() && has(state.features, Feature::sleeping);
  const KeptImpulses<real> slept(sleeping ? from.slept_count[0] : 0, from.slept_keys, from.slept_impulses,
                                 from.slept_moments, from.slept_points, new_shape);
  std::vector<Pair> touching;
  const bool told = !from.touching_count.empty() && has(state.features, Feature::events);
  for (u32 k = 0; told && k < from.touching_count[0]; ++k) {
    Pair pair = from.touching[k];
    if (rename(pair, new_shape)) touching.push_back(pair);
  }
  state.sizes.contacts = std::max(state.sizes.contacts, in_blocks(std::max(cached.count(), slept.count())));
  state.sizes.pairs = std::max(state.sizes.pairs, in_blocks(static_cast<u32>(touching.size())));
  set_sizes(state.params, state.sizes);
  resize(state.buffers, state.sizes, state.features);
  Buffers<real>& to = state.buffers;
  cached.copy_to(to.cached_count, to.cached_keys, to.cached_impulses, to.cached_moments);
  if (sleeping) {
    slept.copy_to(to.slept_count, to.slept_keys, to.slept_impulses, to.slept_moments);
    std::ranges::copy(slept.points, to.slept_points.begin());
  }
  if (!told) return;
  to.touching_count[0] = static_cast<u32>(touching.size());
  std::ranges::copy(touching, to.touching.begin());
}

// Who is held by a joint that has come or gone.
template <class real>
void wake_by_joints(const InitialState<real>& old, std::span<const u32> new_body, std::span<const u32> new_joint,
                    const InitialState<real>& current, std::vector<Sleeper>& sleepers) {
  std::vector<u32> old_body(current.sizes.bodies, NONE);
  for (u32 i = 0; i < new_body.size(); ++i)
    if (new_body[i] != NONE) old_body[new_body[i]] = i;
  std::vector<bool> had(current.sizes.joints, false);
  for (u32 j = 0; j < old.sizes.joints; ++j) {
    if (new_joint[j] != NONE) had[new_joint[j]] = true;
    if (new_joint[j] != NONE) continue;
    for (const u32 body : {old.buffers.joint_infos[j].body_a, old.buffers.joint_infos[j].body_b})
      wake_island_of(sleepers, body);
  }
  for (u32 j = 0; j < current.sizes.joints; ++j) {
    if (had[j]) continue;
    for (const u32 body : {current.buffers.joint_infos[j].body_a, current.buffers.joint_infos[j].body_b})
      if (body < current.sizes.bodies && old_body[body] != NONE) wake_island_of(sleepers, old_body[body]);
  }
}

// Those whose support has gone or is another wake, and so do all where something that cannot move has come: what it
// touches is known only when they look.
template <class real>
void wake_by_bodies(const InitialState<real>& old, const Buffers<real>& from, std::span<const u32> new_body,
                    const InitialState<real>& current, std::vector<Sleeper>& sleepers) {
  for (u32 i = 0; i < old.sizes.bodies; ++i)
    if (new_body[i] == NONE) wake_island_of(sleepers, i);
  for (u32 k = 0; k < from.slept_count[0]; ++k) {
    const u32 a = old.buffers.shape_infos[from.slept_keys[k].shape_a].body;
    const u32 b = old.buffers.shape_infos[from.slept_keys[k].shape_b].body;
    if (new_body[a] == NONE) wake_island_of(sleepers, b);
    if (new_body[b] == NONE) wake_island_of(sleepers, a);
  }
  std::vector<bool> had(current.sizes.bodies, false);
  for (const u32 i : new_body)
    if (i != NONE) had[i] = true;
  bool comes = false;
  for (u32 i = 0; i < current.sizes.bodies; ++i)
    comes = comes || (!had[i] && current.buffers.body_infos[i].kind != BODY_DYNAMIC);
  for (u32 i = 0; comes && i < sleepers.size(); ++i) wake_island_of(sleepers, i);
}

// Islands that sleep on have the name of the body that is their first by now.
template <class real>
void migrate_sleepers(const InitialState<real>& old, const Buffers<real>& from, std::span<const u32> new_body,
                      std::span<const u32> new_joint, InitialState<real>& state) {
  std::vector<Sleeper> sleepers = from.sleepers;
  sleepers.resize(old.sizes.bodies);
  wake_by_bodies(old, from, new_body, state, sleepers);
  wake_by_joints(old, new_body, new_joint, state, sleepers);
  std::vector<u32> names(old.sizes.bodies, NONE);
  for (u32 i = 0; i < old.sizes.bodies; ++i) {
    if (new_body[i] == NONE || !is_asleep(sleepers[i])) continue;
    u32& name = names[sleepers[i].island];
    name = std::min(name, new_body[i]);
  }
  for (u32 i = 0; i < old.sizes.bodies; ++i) {
    if (new_body[i] == NONE) continue;
    Sleeper& current = state.buffers.sleepers[new_body[i]];
    current = sleepers[i];
    state.buffers.still_starts[new_body[i]] = from.still_starts[i];
    if (is_asleep(current)) current.island = names[current.island];
  }
}

// Which particle or plane each old one has become: those of a body stand together, in their order.
template <class real>
std::vector<u32> new_spring_ends(const InitialState<real>& old, std::span<const u32> new_body,
                                 const InitialState<real>& current) {
  std::vector<u32> became;
  for (u32 i = 0; i < old.sizes.particles; ++i) {
    const u32 body = old.buffers.particle_bodies[i], is = new_body[body];
    became.push_back(is == NONE ? NONE : current.buffers.body_particles[is] + (i - old.buffers.body_particles[body]));
  }
  const std::vector<u32>&were = old.buffers.plane_bodies, &are = current.buffers.plane_bodies;
  for (u32 k = 0; k < were.size(); ++k) {
    const auto first = std::ranges::find(are, new_body[were[k]]);
    const auto of_body = std::ranges::find(were, were[k]);
    became.push_back(first == are.end() ? NONE
                                        : current.sizes.particles + static_cast<u32>(first - are.begin()) +
                                              (k - static_cast<u32>(of_body - were.begin())));
  }
  return became;
}

template <class real>
void migrate_springs(const Buffers<real>& from, const std::vector<u32>& new_end, InitialState<real>& state) {
  std::vector<SpringKey> keys;
  std::vector<Vec4<real>> stretches;
  for (u32 k = 0; k < from.spring_count[0]; ++k) {
    const SpringKey key = {new_end[from.spring_keys[k].particle], new_end[from.spring_keys[k].partner]};
    if (key.particle == NONE || key.partner == NONE) continue;
    keys.push_back(key);
    stretches.push_back(from.spring_stretches[k]);
  }
  state.sizes.pairs = std::max(state.sizes.pairs, in_blocks(static_cast<u32>(keys.size())));
  set_sizes(state.params, state.sizes);
  resize(state.buffers, state.sizes, state.features);
  state.buffers.spring_count[0] = static_cast<u32>(keys.size());
  std::ranges::copy(keys, state.buffers.spring_keys.begin());
  std::ranges::copy(stretches, state.buffers.spring_stretches.begin());
}

struct Lane {
  u32 block = NONE, lane = 0;
};

std::vector<Lane> lanes_of(const std::vector<JointLanes>& blocks, u32 joints) {
  std::vector<Lane> lanes(joints);
  for (u32 b = 0; b < blocks.size(); ++b)
    for (u32 l = 0; l < PACK; ++l)
      if (blocks[b].joint[l] != NONE) lanes[blocks[b].joint[l]] = {b, l};
  return lanes;
}

template <class real>
void migrate_joints(const InitialState<real>& old, const Buffers<real>& from, std::span<const u32> new_joint,
                    InitialState<real>& state) {
  const std::vector<Lane> before = lanes_of(old.buffers.joint_lanes, old.sizes.joints);
  const std::vector<Lane> after = lanes_of(state.buffers.joint_lanes, state.sizes.joints);
  for (u32 j = 0; j < old.sizes.joints; ++j) {
    if (new_joint[j] == NONE) continue;
    const Lane was = before[j], is = after[new_joint[j]];
    const JointImpulseBlock<real>& source = from.joint_impulses[was.block];
    JointImpulseBlock<real>& target = state.buffers.joint_impulses[is.block];
    for (u32 row = 0; row < JOINT_ROWS; ++row) target.locked[row][is.lane] = source.locked[row][was.lane];
    target.free[is.lane] = source.free[was.lane];
  }
}

}  // namespace

template <class real>
void migrate_state(const InitialState<real>& old, const Buffers<real>& persistent, std::span<const u32> new_body,
                   std::span<const u32> new_joint, InitialState<real>& state) {
  Buffers<real>& to = state.buffers;
  to.step_index = persistent.step_index;
  for (u32 i = 0; i < old.sizes.bodies; ++i) {
    if (new_body[i] == NONE) continue;
    to.positions[new_body[i]] = persistent.positions[i];
    to.orientations[new_body[i]] = persistent.orientations[i];
    to.motions[new_body[i]] = persistent.motions[i];
  }
  if (has(old.features, Feature::contacts) && has(state.features, Feature::contacts))
    migrate_contacts(persistent, new_shapes(old, new_body, state), state);
  if (has(old.features, Feature::sleeping) && has(state.features, Feature::sleeping))
    migrate_sleepers(old, persistent, new_body, new_joint, state);
  if (has(old.features, Feature::shear_springs) && has(state.features, Feature::shear_springs))
    migrate_springs(persistent, new_spring_ends(old, new_body, state), state);
  if (has(old.features, Feature::joints) && has(state.features, Feature::joints))
    migrate_joints(old, persistent, new_joint, state);
}

template void migrate_state<float>(const InitialState<float>&, const Buffers<float>&, std::span<const u32>,
                                   std::span<const u32>, InitialState<float>&);
template void migrate_state<double>(const InitialState<double>&, const Buffers<double>&, std::span<const u32>,
                                    std::span<const u32>, InitialState<double>&);

}  // namespace lockstep
