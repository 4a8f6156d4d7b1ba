// Two 64-bit hashes of each world: of all persistent state, and of the poses alone. Equal hashes mean equal bits.
//
// A record is what a persistent buffer says about one body, one contact, one joint or one spring. Its words are
// chained through a mixer, after the kind of record and the world-local id (of a contact: the ids of its two shapes and
// the feature; of a spring: its two particles by their bodies), so that nothing depends on where in an array a record
// or a world stands, nor on capacities. A float is one word, a double two, low word first. The hash is the sum of the
// records, taken for the low and for the high 32 bits on its own, without a carry between them: a sum has no order, and
// OpenCL 1.2 adds atomically in 32 bits only.
//
// The mixer is the finaliser of SplitMix64 (Steele, Lea, Flood 2014, with the multipliers of Stafford's variant 13).
#pragma once

#include <array>
#include <bit>

#include "cpu_reference/math.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

using u64 = std::uint64_t;

inline u64 hash_mix(u64 h) {
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebu;
  return h ^ (h >> 31);
}
inline u64 hash_word(u64 h, u32 word) { return hash_mix((h + 0x9e3779b97f4a7c15u) ^ u64{word}); }
inline u64 hash_start(HashedRecord record) { return hash_word(0, record); }
template <class Record>
u64 hash_words(u64 h, const Record& record) {
  static_assert(std::endian::native == std::endian::little, "the low word of a double comes first");
  for (const u32 word : std::bit_cast<std::array<u32, sizeof(Record) / sizeof(u32)>>(record)) h = hash_word(h, word);
  return h;
}

inline void hash_add_state(WorldHash& hash, u64 h) {
  hash.state_low += static_cast<u32>(h);
  hash.state_high += static_cast<u32>(h >> 32);
}
inline void hash_add_pose(WorldHash& hash, u64 h) {
  hash.pose_low += static_cast<u32>(h);
  hash.pose_high += static_cast<u32>(h >> 32);
}

/// Every world starts from the step index alone.
template <class real>
void hash_state_steps(Buffers<real>& b, const StepParams<real>& params) {
  const u64 h = hash_word(hash_start(HASHED_STEP), b.step_index[0]);
  for (u32 i = 0; i < params.worlds; ++i) {
    b.world_hashes[i] = {static_cast<u32>(h), static_cast<u32>(h >> 32), 0, 0};
  }
}

template <class real>
void hash_state_bodies(Buffers<real>& b, const StepParams<real>& params) {
  for (u32 i = 0; i < params.bodies; ++i) {
    const u32 id = b.body_infos[i].id;
    WorldHash& hash = b.world_hashes[b.body_infos[i].world];
    const u64 position = hash_words(hash_word(hash_start(HASHED_POSITION), id), b.positions[i]);
    const u64 orientation = hash_words(hash_word(hash_start(HASHED_ORIENTATION), id), b.orientations[i]);
    const u64 motion = hash_words(hash_word(hash_start(HASHED_MOTION), id), b.motions[i]);
    hash_add_state(hash, position);
    hash_add_state(hash, orientation);
    hash_add_state(hash, motion);
    hash_add_pose(hash, position);
    hash_add_pose(hash, orientation);
  }
}

/// Contacts by their keys: those of the cache, or of sleepers.
template <class real>
void hash_state_keys(Buffers<real>& b, HashedRecord record, const std::vector<u32>& count,
                     const std::vector<ContactKey>& keys, const std::vector<ContactImpulse<real>>& impulses,
                     const std::vector<Vec4<real>>& moments) {
  for (u32 i = 0; i < (count.empty() ? 0 : count[0]); ++i) {
    const ContactKey key = keys[i];
    const ShapeInfo shape_a = b.shape_infos[key.shape_a];
    u64 h = hash_start(record);
    h = hash_word(h, shape_a.id);
    h = hash_word(h, b.shape_infos[key.shape_b].id);
    h = hash_word(h, key.feature);
    h = hash_word(h, key.normal);
    h = hash_words(h, impulses[i]);
    if (!moments.empty()) h = hash_words(h, moments[i]);
    hash_add_state(b.world_hashes[b.body_infos[shape_a.body].world], h);
  }
}

template <class real>
void hash_state_contacts(Buffers<real>& b) {
  hash_state_keys(b, HASHED_CONTACT, b.cached_count, b.cached_keys, b.cached_impulses, b.cached_moments);
}

/// An island by the id of the body that it is named by.
template <class real>
void hash_state_sleepers(Buffers<real>& b) {
  for (u32 i = 0; i < b.sleepers.size(); ++i) {
    const Sleeper sleeper = b.sleepers[i];
    u64 h = hash_word(hash_start(HASHED_SLEEPER), b.body_infos[i].id);
    h = hash_word(h, sleeper.still);
    h = hash_word(h, sleeper.island < ISLAND_WAKES ? b.body_infos[sleeper.island].id : sleeper.island);
    if (sleeper.still != 0) h = hash_words(h, b.still_starts[i]);
    hash_add_state(b.world_hashes[b.body_infos[i].world], h);
  }
  hash_state_keys(b, HASHED_SLEPT, b.slept_count, b.slept_keys, b.slept_impulses, b.slept_moments);
  for (u32 i = 0; i < (b.slept_count.empty() ? 0 : b.slept_count[0]); ++i) {
    const ContactKey key = b.slept_keys[i];
    const ShapeInfo shape_a = b.shape_infos[key.shape_a];
    u64 h = hash_word(hash_start(HASHED_SLEPT_POINT), shape_a.id);
    h = hash_word(h, b.shape_infos[key.shape_b].id);
    h = hash_words(hash_word(h, key.feature), b.slept_points[i]);
    hash_add_state(b.world_hashes[b.body_infos[shape_a.body].world], h);
  }
}

template <class real>
void hash_state_touching(Buffers<real>& b) {
  const u32 count = b.touching_count.empty() ? 0 : b.touching_count[0];
  for (u32 i = 0; i < count; ++i) {
    const ShapeInfo shape_a = b.shape_infos[b.touching[i].shape_a];
    u64 h = hash_start(HASHED_TOUCH);
    h = hash_word(h, shape_a.id);
    h = hash_word(h, b.shape_infos[b.touching[i].shape_b].id);
    hash_add_state(b.world_hashes[b.body_infos[shape_a.body].world], h);
  }
}

template <class real>
void hash_state_joints(Buffers<real>& b) {
  for (u32 slot = 0; slot < b.joint_lanes.size() * PACK; ++slot) {
    const u32 lane = slot % PACK, joint = b.joint_lanes[slot / PACK].joint[lane];
    if (joint == NONE) continue;
    const JointImpulseBlock<real>& impulses = b.joint_impulses[slot / PACK];
    u64 h = hash_word(hash_start(HASHED_JOINT), b.joint_infos[joint].id);
    for (u32 i = 0; i < JOINT_ROWS; ++i) h = hash_words(h, impulses.locked[i][lane]);
    h = hash_words(h, impulses.free[lane]);
    if (impulses.impedance[lane] != 0) h = hash_words(h, impulses.impedance[lane]);
    if (!b.joint_angles.empty() && COUNTS_REVOLUTIONS(b.joint_infos[joint])) h = hash_words(h, b.joint_angles[joint]);
    hash_add_state(b.world_hashes[b.joint_infos[joint].world], h);
  }
}

template <class real>
void hash_state_couplings(Buffers<real>& b) {
  for (u32 k = 0; k < b.coupling_infos.size(); ++k) {
    const u64 h = hash_word(hash_start(HASHED_COUPLING), b.coupling_infos[k].id);
    hash_add_state(b.world_hashes[b.coupling_infos[k].world], hash_words(h, b.coupling_impulses[k]));
  }
}

/// A particle, or a plane, by the id of its body and its number there.
template <class real>
u64 hash_spring_end(const Buffers<real>& b, u64 h, u32 end) {
  const u32 particles = static_cast<u32>(b.particle_bodies.size());
  if (end < particles) {
    const u32 body = b.particle_bodies[end];
    return hash_word(hash_word(h, b.body_infos[body].id), end - b.body_particles[body]);
  }
  const u32 plane = end - particles, body = b.plane_bodies[plane];
  u32 before = 0;
  while (before < plane && b.plane_bodies[plane - before - 1] == body) ++before;
  return hash_word(hash_word(h, b.body_infos[body].id), NONE - before);
}

template <class real>
void hash_state_springs(Buffers<real>& b) {
  const u32 count = b.spring_count.empty() ? 0 : b.spring_count[0];
  for (u32 k = 0; k < count; ++k) {
    const SpringKey key = b.spring_keys[k];
    u64 h = hash_spring_end(b, hash_start(HASHED_SPRING), key.particle);
    h = hash_words(hash_spring_end(b, h, key.partner), b.spring_stretches[k]);
    hash_add_state(b.world_hashes[b.body_infos[b.particle_bodies[key.particle]].world], h);
  }
}

template <class real>
void hash_state(Buffers<real>& b, const StepParams<real>& params) {
  hash_state_steps(b, params);
  hash_state_bodies(b, params);
  hash_state_contacts(b);
  hash_state_sleepers(b);
  hash_state_touching(b);
  hash_state_joints(b);
  hash_state_couplings(b);
  hash_state_springs(b);
}

}  // namespace lockstep::reference
