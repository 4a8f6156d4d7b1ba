#include "host/world/migrate_state.hpp"

#include <algorithm>

#include "host/scene/joint_angles.hpp"
#include "host/scene/step_params.hpp"
#include "host/scene/touching.hpp"
#include "host/sleepers.hpp"

namespace lockstep {

namespace {

constexpr u32 in_blocks(u32 count) { return (count + PACK - 1) / PACK * PACK; }

// Whether a shape may be the same one described otherwise.
bool is_of_same_kind(const ShapeInfo& a, const ShapeInfo& b) {
  const auto is_facet = [](const ShapeInfo& info) { return info.kind == SHAPE_HULL && (info.hull & HULL_IS_FACET); };
  return a.kind == b.kind && is_facet(a) == is_facet(b) && ((a.flags ^ b.flags) & SHAPE_IS_TRIGGER) == 0;
}

// Which shape each old one has become. The shapes of a body stand together, in their order.
template <class real>
std::vector<u32> new_shapes(const InitialState<real>& old, const IndexMap& index_map,
                            const InitialState<real>& current) {
  std::vector<u32> first(current.sizes.bodies, NONE);
  for (u32 s = current.sizes.shapes; s-- > 0;) first[current.buffers.shape_infos[s].body] = s;
  std::vector<u32> became(old.sizes.shapes, NONE);
  u32 of_body = 0;
  for (u32 s = 0; s < old.sizes.shapes; ++s) {
    const u32 body = old.buffers.shape_infos[s].body, is = index_map.bodies[body];
    of_body = s > 0 && old.buffers.shape_infos[s - 1].body == body ? of_body + 1 : 0;
    if (is == NONE || first[is] == NONE || first[is] + of_body >= current.sizes.shapes) continue;
    const ShapeInfo& info = current.buffers.shape_infos[first[is] + of_body];
    if (info.body == is && is_of_same_kind(old.buffers.shape_infos[s], info)) became[s] = first[is] + of_body;
  }
  return became;
}

template <class real>
ShapeClass class_of(const Buffers<real>& b, u32 shape) {
  const ShapeInfo& info = b.shape_infos[shape];
  return {info.category, info.mask, info.kind == SHAPE_PLANE, b.body_infos[info.body].kind == BODY_DYNAMIC,
          (info.flags & SHAPE_IS_TRIGGER) != 0};
}

// Which pairs have become which.
template <class real>
class PairRename {
 public:
  PairRename(const InitialState<real>& old, const IndexMap& index_map, const InitialState<real>& current)
      : new_shape_(new_shapes(old, index_map, current)), current_(current.buffers) {}

  /// Of a pair that is a record's, the one it has become; false where it is gone.
  template <class Record>
  bool operator()(Record& record) const {
    record.shape_a = new_shape_[record.shape_a];
    record.shape_b = new_shape_[record.shape_b];
    return record.shape_a != NONE && record.shape_b != NONE &&
           can_touch(class_of(current_, record.shape_a), class_of(current_, record.shape_b));
  }

 private:
  std::vector<u32> new_shape_;
  const Buffers<real>& current_;
};

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
               const PairRename<real>& rename) {
    for (u32 k = 0; k < count; ++k) {
      ContactKey key = from_keys[k];
      if (!rename(key)) continue;
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
void migrate_contacts(const Buffers<real>& from, const PairRename<real>& rename, InitialState<real>& state) {
  const KeptImpulses<real> cached(from.cached_count[0], from.cached_keys, from.cached_impulses, from.cached_moments, {},
                                  rename);
  const bool sleeping = !from.slept_count.empty() && has(state.features, Feature::sleeping);
  const KeptImpulses<real> slept(sleeping ? from.slept_count[0] : 0, from.slept_keys, from.slept_impulses,
                                 from.slept_moments, from.slept_points, rename);
  std::vector<Pair> touching;
  const bool told = !from.touching_count.empty() && has(state.features, Feature::events);
  for (u32 k = 0; told && k < from.touching_count[0]; ++k) {
    Pair pair = from.touching[k];
    if (rename(pair)) touching.push_back(pair);
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

// Who is held by a joint that has come, gone or changed, or that holds a body that has.
template <class real>
void wake_by_joints(const InitialState<real>& old, const IndexMap& index_map, const InitialState<real>& current,
                    std::vector<Sleeper>& sleepers) {
  std::vector<u32> old_body(current.sizes.bodies, NONE);
  for (u32 i = 0; i < index_map.bodies.size(); ++i)
    if (index_map.bodies[i] != NONE) old_body[index_map.bodies[i]] = i;
  std::vector<bool> had(current.sizes.joints, false);
  for (u32 j = 0; j < old.sizes.joints; ++j) {
    const JointInfo& joint = old.buffers.joint_infos[j];
    const bool stays = index_map.joints[j] != NONE;
    if (stays) had[index_map.joints[j]] = true;
    if (stays && !index_map.changed_joints.contains(j) && !index_map.changed_bodies.contains(joint.body_a) &&
        !index_map.changed_bodies.contains(joint.body_b))
      continue;
    for (const u32 body : {joint.body_a, joint.body_b}) wake_island_of(sleepers, body);
  }
  for (u32 j = 0; j < current.sizes.joints; ++j) {
    if (had[j]) continue;
    for (const u32 body : {current.buffers.joint_infos[j].body_a, current.buffers.joint_infos[j].body_b})
      if (body < current.sizes.bodies && old_body[body] != NONE) wake_island_of(sleepers, old_body[body]);
  }
}

// Those that have changed, and those whose support has, or is gone or another: so do all where something that cannot
// move has come or changed, for what it touches is known only when they look.
template <class real>
void wake_by_bodies(const InitialState<real>& old, const Buffers<real>& from, const IndexMap& index_map,
                    const InitialState<real>& current, std::vector<Sleeper>& sleepers) {
  const auto is_other = [&](u32 body) {
    return index_map.bodies[body] == NONE || index_map.changed_bodies.contains(body);
  };
  const auto meet_otherwise = [&](u32 a, u32 b) {
    return std::ranges::any_of(index_map.changed_materials, [&](const std::array<u32, 2>& pair) {
      const auto are = [&](u32 first, u32 second) {
        return (pair[0] == first || pair[0] == NONE) && (pair[1] == second || pair[1] == NONE);
      };
      return are(a, b) || are(b, a);
    });
  };
  for (u32 i = 0; i < old.sizes.bodies; ++i)
    if (is_other(i)) wake_island_of(sleepers, i);
  for (u32 k = 0; k < from.slept_count[0]; ++k) {
    const ShapeInfo& a = old.buffers.shape_infos[from.slept_keys[k].shape_a];
    const ShapeInfo& b = old.buffers.shape_infos[from.slept_keys[k].shape_b];
    const bool otherwise = meet_otherwise(a.material, b.material);
    if (otherwise || is_other(a.body)) wake_island_of(sleepers, b.body);
    if (otherwise || is_other(b.body)) wake_island_of(sleepers, a.body);
  }
  std::vector<bool> had(current.sizes.bodies, false);
  for (u32 i = 0; i < old.sizes.bodies; ++i)
    if (!is_other(i)) had[index_map.bodies[i]] = true;
  bool comes = false;
  for (u32 i = 0; i < current.sizes.bodies; ++i)
    comes = comes || (!had[i] && current.buffers.body_infos[i].kind != BODY_DYNAMIC);
  if (comes) wake_all(sleepers);
}

// Islands that sleep on have the name of the body that is their first by now.
template <class real>
void migrate_sleepers(const InitialState<real>& old, const Buffers<real>& from, const IndexMap& index_map,
                      InitialState<real>& state) {
  const std::vector<u32>& new_body = index_map.bodies;
  std::vector<Sleeper> sleepers = from.sleepers;
  sleepers.resize(old.sizes.bodies);
  wake_by_bodies(old, from, index_map, state, sleepers);
  wake_by_joints(old, index_map, state, sleepers);
  std::vector<u32> names(old.sizes.bodies, NONE);
  for (u32 i = 0; i < old.sizes.bodies; ++i) {
    if (new_body[i] == NONE || !is_asleep(sleepers[i])) continue;
    u32& name = names[sleepers[i].island];
    name = std::min(name, new_body[i]);
  }
  for (u32 i = 0; i < old.sizes.bodies; ++i) {
    if (new_body[i] == NONE) continue;
    if (index_map.changed_bodies.contains(i) && state.buffers.body_infos[new_body[i]].kind != BODY_DYNAMIC) continue;
    Sleeper& current = state.buffers.sleepers[new_body[i]];
    current = sleepers[i];
    state.buffers.still_starts[new_body[i]] = from.still_starts[i];
    if (is_asleep(current)) current.island = names[current.island];
  }
}

// Which particle or plane each old one has become: those of a body stand together, in their order.
template <class real>
std::vector<u32> new_spring_ends(const InitialState<real>& old, const IndexMap& index_map,
                                 const InitialState<real>& current) {
  std::vector<u32> new_body = index_map.bodies, became;
  for (const u32 body : index_map.changed_bodies) new_body[body] = NONE;  // their particles are others
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
    const Joint<real>& joint = state.buffers.joints[new_joint[j]];
    if (joint.armature > 0 || joint.side_compliance > 0) target.impedance[is.lane] = source.impedance[was.lane];
  }
}

// A world has no others, so that the ids are indices into its scene.
template <class real>
void migrate_couplings(const InitialState<real>& old, const Buffers<real>& from, std::span<const u32> new_coupling,
                       InitialState<real>& state) {
  for (u32 k = 0; k < old.sizes.couplings; ++k) {
    const u32 id = new_coupling[old.buffers.coupling_infos[k].id];
    for (u32 i = 0; i < state.sizes.couplings; ++i)
      if (state.buffers.coupling_infos[i].id == id) state.buffers.coupling_impulses[i] = from.coupling_impulses[k];
  }
}

// Joints that have come start where they are, those that were there go on.
template <class real>
void migrate_angles(std::span<const double> starts, const std::vector<real>& angles, std::span<const u32> new_joint,
                    InitialState<real>& state) {
  set_joint_angles(starts, double(state.params.dt), state.buffers);
  for (std::size_t j = 0; j < angles.size(); ++j)
    if (new_joint[j] != NONE) state.buffers.joint_angles[new_joint[j]] = angles[j];
}

// Its mass is the new one; what it makes of the inertia in the world frame each sub-step computes for itself.
template <class real>
Motion<real> with_velocity_of(const Motion<real>& old, u32 kind, Motion<real> motion) {
  if (kind == BODY_STATIC) return motion;
  std::ranges::copy(old.v, motion.v);
  std::ranges::copy(old.w, motion.w);
  return motion;
}

}  // namespace

template <class real>
void migrate_state(const InitialState<real>& old, const Buffers<real>& persistent, const IndexMap& index_map,
                   InitialState<real>& state) {
  Buffers<real>& to = state.buffers;
  const bool counts = has(state.features, Feature::joint_angles);
  std::vector<double> starts = counts ? angles_of_substep(to, double(state.params.dt)) : std::vector<double>();
  for (std::size_t j = 0; j < starts.size(); ++j) starts[j] += double(to.joint_angles[j]);
  to.step_index = persistent.step_index;
  for (u32 i = 0; i < old.sizes.bodies; ++i) {
    const u32 is = index_map.bodies[i];
    if (is == NONE) continue;
    to.positions[is] = persistent.positions[i];
    to.orientations[is] = persistent.orientations[i];
    to.motions[is] = index_map.changed_bodies.contains(i)
                         ? with_velocity_of(persistent.motions[i], to.body_infos[is].kind, to.motions[is])
                         : persistent.motions[i];
  }
  if (has(old.features, Feature::contacts) && has(state.features, Feature::contacts))
    migrate_contacts(persistent, PairRename<real>(old, index_map, state), state);
  if (has(old.features, Feature::sleeping) && has(state.features, Feature::sleeping))
    migrate_sleepers(old, persistent, index_map, state);
  if (has(old.features, Feature::shear_springs) && has(state.features, Feature::shear_springs))
    migrate_springs(persistent, new_spring_ends(old, index_map, state), state);
  if (has(old.features, Feature::joints) && has(state.features, Feature::joints))
    migrate_joints(old, persistent, index_map.joints, state);
  if (has(old.features, Feature::couplings) && has(state.features, Feature::couplings))
    migrate_couplings(old, persistent, index_map.couplings, state);
  if (counts) migrate_angles(starts, persistent.joint_angles, index_map.joints, state);
}

template <class real>
std::vector<bool> pairs_gone(const InitialState<real>& old, std::span<const Pair> touching, const IndexMap& index_map,
                             const InitialState<real>& current) {
  if (!has(current.features, Feature::events)) return std::vector<bool>(touching.size(), true);
  const PairRename<real> rename(old, index_map, current);
  std::vector<bool> gone;
  for (Pair pair : touching) gone.push_back(!rename(pair));
  return gone;
}

#define INSTANTIATE(real)                                                                                        \
  template void migrate_state<real>(const InitialState<real>&, const Buffers<real>&, const IndexMap&,            \
                                    InitialState<real>&);                                                        \
  template std::vector<bool> pairs_gone<real>(const InitialState<real>&, std::span<const Pair>, const IndexMap&, \
                                              const InitialState<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
