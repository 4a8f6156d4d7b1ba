#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "types.h"

// The definition of the hash is in cpu_reference/hash_state.hpp.

static inline ulong hash_mix(ulong h) {
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9UL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebUL;
  return h ^ (h >> 31);
}
static inline ulong hash_word(ulong h, u32 word) { return hash_mix((h + 0x9e3779b97f4a7c15UL) ^ (ulong)word); }
static inline ulong hash_start(u32 record) { return hash_word(0UL, record); }
static inline ulong hash_words(ulong h, global const u32* words, u32 count) {
  for (u32 i = 0u; i < count; ++i) h = hash_word(h, words[i]);
  return h;
}

#if EACH_TAKES_NEIGHBOURS
// The same of sixteen neighbours at once, whose records of `count` words follow each other.
static inline ulong16 hash_word_16(ulong16 h, uint16 word) {
  h = (h + 0x9e3779b97f4a7c15UL) ^ convert_ulong16(word);
  h = (h ^ (h >> 30)) * 0xbf58476d1ce4e5b9UL;
  h = (h ^ (h >> 27)) * 0x94d049bb133111ebUL;
  return h ^ (h >> 31);
}
static inline uint16 hash_load_16(global const u32* words, u32 count) {
  uint16 loaded;
  loaded.lo = (uint8)(words[0], words[count], words[2u * count], words[3u * count], words[4u * count],
                      words[5u * count], words[6u * count], words[7u * count]);
  words += 8u * count;
  loaded.hi = (uint8)(words[0], words[count], words[2u * count], words[3u * count], words[4u * count],
                      words[5u * count], words[6u * count], words[7u * count]);
  return loaded;
}
static inline ulong16 hash_words_16(ulong16 h, global const u32* words, u32 count) {
  for (u32 i = 0u; i < count; ++i) h = hash_word_16(h, hash_load_16(words + i, count));
  return h;
}
static inline u32 hash_total_16(uint16 x) {
  const uint8 half_sums = x.lo + x.hi;
  const uint4 quarters = half_sums.lo + half_sums.hi;
  return quarters.x + quarters.y + quarters.z + quarters.w;
}
#endif

// What a work-item has of one world: its neighbours mostly belong to the same, and an atomic costs as much as the hash
// of a body.
typedef struct HashSum {
  u32 world, state_low, state_high, pose_low, pose_high;
} HashSum;

static inline HashSum hash_nothing(void) {
  const HashSum nothing = {NONE, 0u, 0u, 0u, 0u};
  return nothing;
}
static inline void hash_hand_over(const HashSum* sum, global WorldHash* world_hashes) {
  if (sum->world == NONE) return;
  global WorldHash* hash = &world_hashes[sum->world];
  atomic_add((volatile global u32*)&hash->state_low, sum->state_low);
  atomic_add((volatile global u32*)&hash->state_high, sum->state_high);
  if ((sum->pose_low | sum->pose_high) == 0u) return;
  atomic_add((volatile global u32*)&hash->pose_low, sum->pose_low);
  atomic_add((volatile global u32*)&hash->pose_high, sum->pose_high);
}
static inline void hash_enter(HashSum* sum, u32 world, global WorldHash* world_hashes) {
  if (sum->world == world) return;
  hash_hand_over(sum, world_hashes);
  *sum = hash_nothing();
  sum->world = world;
}
static inline void hash_add_state(HashSum* sum, ulong h) {
  sum->state_low += (u32)h;
  sum->state_high += (u32)(h >> 32);
}
static inline void hash_add_pose(HashSum* sum, ulong h) {
  sum->pose_low += (u32)h;
  sum->pose_high += (u32)(h >> 32);
}

#if EACH_TAKES_NEIGHBOURS
static inline void hash_add_state_16(HashSum* sum, ulong16 h) {
  sum->state_low += hash_total_16(convert_uint16(h));
  sum->state_high += hash_total_16(convert_uint16(h >> 32));
}
static inline void hash_add_pose_16(HashSum* sum, ulong16 h) {
  sum->pose_low += hash_total_16(convert_uint16(h));
  sum->pose_high += hash_total_16(convert_uint16(h >> 32));
}
#endif

// The first of three: every world starts from the step index alone.
kernel void hash_state_steps(const StepParams params, global const u32* step_index, global WorldHash* world_hashes) {
  const ulong h = hash_word(hash_start(HASHED_STEP), step_index[0]);
  FOR_EACH(i, params.worlds) {
    world_hashes[i].state_low = (u32)h;
    world_hashes[i].state_high = (u32)(h >> 32);
    world_hashes[i].pose_low = 0u;
    world_hashes[i].pose_high = 0u;
  }
}

kernel void hash_state_bodies(const StepParams params, global const BodyInfo* body_infos, global const Vec4* positions,
                              global const Vec4* orientations, global const Motion* motions,
                              global WorldHash* world_hashes) {
  HashSum sum = hash_nothing();
  FOR_EACH(i, params.bodies) {
    const u32 id = body_infos[i].id;
    const u32 vec4_words = (u32)(sizeof(Vec4) / sizeof(u32));
    const u32 motion_words = (u32)(sizeof(Motion) / sizeof(u32));
    hash_enter(&sum, body_infos[i].world, world_hashes);
#if EACH_TAKES_NEIGHBOURS
    // the bodies of a world follow each other
    if (i_end - i >= 16u && body_infos[i + 15u].world == sum.world) {
      const uint16 ids = hash_load_16(&body_infos[i].id, (u32)(sizeof(BodyInfo) / sizeof(u32)));
      const ulong16 positions_16 = hash_words_16(hash_word_16((ulong16)(hash_start(HASHED_POSITION)), ids),
                                                 (global const u32*)&positions[i], vec4_words);
      const ulong16 orientations_16 = hash_words_16(hash_word_16((ulong16)(hash_start(HASHED_ORIENTATION)), ids),
                                                    (global const u32*)&orientations[i], vec4_words);
      const ulong16 motions_16 = hash_words_16(hash_word_16((ulong16)(hash_start(HASHED_MOTION)), ids),
                                               (global const u32*)&motions[i], motion_words);
      hash_add_state_16(&sum, positions_16);
      hash_add_state_16(&sum, orientations_16);
      hash_add_state_16(&sum, motions_16);
      hash_add_pose_16(&sum, positions_16);
      hash_add_pose_16(&sum, orientations_16);
      i += 15u;
      continue;
    }
#endif
    const ulong position =
        hash_words(hash_word(hash_start(HASHED_POSITION), id), (global const u32*)&positions[i], vec4_words);
    const ulong orientation =
        hash_words(hash_word(hash_start(HASHED_ORIENTATION), id), (global const u32*)&orientations[i], vec4_words);
    const ulong motion =
        hash_words(hash_word(hash_start(HASHED_MOTION), id), (global const u32*)&motions[i], motion_words);
    hash_add_state(&sum, position);
    hash_add_state(&sum, orientation);
    hash_add_state(&sum, motion);
    hash_add_pose(&sum, position);
    hash_add_pose(&sum, orientation);
  }
  hash_hand_over(&sum, world_hashes);
}

// Contacts by their keys: those of the cache, or of sleepers.
static inline void hash_keys(u32 record, u32 count, global const BodyInfo* body_infos,
                             global const ShapeInfo* shape_infos, global const ContactKey* keys,
                             global const ContactImpulse* key_impulses, global const Vec4* key_moments,
                             global WorldHash* world_hashes) {
  HashSum sum = hash_nothing();
  FOR_EACH(i, count) {
    const ContactKey key = keys[i];
    const ShapeInfo shape_a = shape_infos[key.shape_a];
    const u32 impulse_words = (u32)(sizeof(ContactImpulse) / sizeof(u32));
    const u32 moment_words = (u32)(sizeof(Vec4) / sizeof(u32));
    hash_enter(&sum, body_infos[shape_a.body].world, world_hashes);
#if EACH_TAKES_NEIGHBOURS
    // contacts are ordered by shape a, and shapes by world
    if (i_end - i >= 16u && body_infos[shape_infos[keys[i + 15u].shape_a].body].world == sum.world) {
      u32 id_a[16], id_b[16];
      for (u32 k = 0u; k < 16u; ++k) {
        id_a[k] = shape_infos[keys[i + k].shape_a].id;
        id_b[k] = shape_infos[keys[i + k].shape_b].id;
      }
      const u32 key_words = (u32)(sizeof(ContactKey) / sizeof(u32));
      ulong16 contacts_16 = hash_word_16((ulong16)(hash_start(record)), vload16(0, id_a));
      contacts_16 = hash_word_16(contacts_16, vload16(0, id_b));
      contacts_16 = hash_word_16(contacts_16, hash_load_16(&keys[i].feature, key_words));
      contacts_16 = hash_word_16(contacts_16, hash_load_16(&keys[i].normal, key_words));
      contacts_16 = hash_words_16(contacts_16, (global const u32*)&key_impulses[i], impulse_words);
#if FEATURE_ANGULAR_FRICTION
      contacts_16 = hash_words_16(contacts_16, (global const u32*)&key_moments[i], moment_words);
#endif
      hash_add_state_16(&sum, contacts_16);
      i += 15u;
      continue;
    }
#endif
    ulong h = hash_start(record);
    h = hash_word(h, shape_a.id);
    h = hash_word(h, shape_infos[key.shape_b].id);
    h = hash_word(h, key.feature);
    h = hash_word(h, key.normal);
    h = hash_words(h, (global const u32*)&key_impulses[i], impulse_words);
#if FEATURE_ANGULAR_FRICTION
    h = hash_words(h, (global const u32*)&key_moments[i], moment_words);
#endif
    hash_add_state(&sum, h);
  }
  hash_hand_over(&sum, world_hashes);
}

kernel void hash_state_contacts(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                                global const u32* cached_count, global const ContactKey* cached_keys,
                                global const ContactImpulse* cached_impulses, global const Vec4* cached_moments,
                                global WorldHash* world_hashes) {
  hash_keys(HASHED_CONTACT, cached_count[0], body_infos, shape_infos, cached_keys, cached_impulses, cached_moments,
            world_hashes);
}

kernel void hash_state_slept(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                             global const u32* slept_count, global const ContactKey* slept_keys,
                             global const ContactImpulse* slept_impulses, global const Vec4* slept_moments,
                             global const ContactPoint* slept_points, global WorldHash* world_hashes) {
  hash_keys(HASHED_SLEPT, slept_count[0], body_infos, shape_infos, slept_keys, slept_impulses, slept_moments,
            world_hashes);
  HashSum sum = hash_nothing();
  FOR_EACH(i, slept_count[0]) {
    const ContactKey key = slept_keys[i];
    const ShapeInfo shape_a = shape_infos[key.shape_a];
    hash_enter(&sum, body_infos[shape_a.body].world, world_hashes);
    ulong h = hash_word(hash_start(HASHED_SLEPT_POINT), shape_a.id);
    h = hash_word(h, shape_infos[key.shape_b].id);
    h = hash_word(h, key.feature);
    h = hash_words(h, (global const u32*)&slept_points[i], (u32)(sizeof(ContactPoint) / sizeof(u32)));
    hash_add_state(&sum, h);
  }
  hash_hand_over(&sum, world_hashes);
}

kernel void hash_state_sleepers(const StepParams params, global const BodyInfo* body_infos,
                                global const Sleeper* sleepers, global const StillStart* still_starts,
                                global WorldHash* world_hashes) {
  HashSum sum = hash_nothing();
  FOR_EACH(i, params.bodies) {
    const Sleeper sleeper = sleepers[i];
    hash_enter(&sum, body_infos[i].world, world_hashes);
    ulong h = hash_word(hash_start(HASHED_SLEEPER), body_infos[i].id);
    h = hash_word(h, sleeper.still);
    h = hash_word(h, sleeper.island < ISLAND_WAKES ? body_infos[sleeper.island].id : sleeper.island);
    if (sleeper.still != 0u)
      h = hash_words(h, (global const u32*)&still_starts[i], (u32)(sizeof(StillStart) / sizeof(u32)));
    hash_add_state(&sum, h);
  }
  hash_hand_over(&sum, world_hashes);
}

kernel void hash_state_touching(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                                global const u32* touching_count, global const Pair* touching,
                                global WorldHash* world_hashes) {
  HashSum sum = hash_nothing();
  FOR_EACH(i, touching_count[0]) {
    const ShapeInfo shape_a = shape_infos[touching[i].shape_a];
    hash_enter(&sum, body_infos[shape_a.body].world, world_hashes);
    ulong h = hash_start(HASHED_TOUCH);
    h = hash_word(h, shape_a.id);
    h = hash_word(h, shape_infos[touching[i].shape_b].id);
    hash_add_state(&sum, h);
  }
  hash_hand_over(&sum, world_hashes);
}

kernel void hash_state_joints(const StepParams params, global const JointInfo* joint_infos,
                              global const JointLanes* joint_lanes, global const JointImpulseBlock* joint_impulses,
                              global const real* joint_angles, global WorldHash* world_hashes) {
  const u32 real_words = (u32)(sizeof(real) / sizeof(u32));
  HashSum sum = hash_nothing();
  FOR_EACH(slot, params.joint_blocks * PACK) {
    const u32 lane = slot % PACK, joint = joint_lanes[slot / PACK].joint[lane];
    if (joint == NONE) continue;
    hash_enter(&sum, joint_infos[joint].world, world_hashes);
    global const JointImpulseBlock* impulses = joint_impulses + slot / PACK;
    ulong h = hash_word(hash_start(HASHED_JOINT), joint_infos[joint].id);
    for (u32 i = 0u; i < JOINT_ROWS; ++i) h = hash_words(h, (global const u32*)&impulses->locked[i][lane], real_words);
    h = hash_words(h, (global const u32*)&impulses->free[lane], real_words);
#if FEATURE_JOINT_IMPEDANCES
    if (impulses->impedance[lane] != (real)0)
      h = hash_words(h, (global const u32*)&impulses->impedance[lane], real_words);
#endif
#if FEATURE_JOINT_ANGLES
    if (COUNTS_REVOLUTIONS(joint_infos[joint]))
      h = hash_words(h, (global const u32*)(joint_angles + joint), real_words);
#endif
    hash_add_state(&sum, h);
  }
  hash_hand_over(&sum, world_hashes);
}

kernel void hash_state_couplings(const u32 coupling_count, global const CouplingInfo* coupling_infos,
                                 global const CouplingImpulse* coupling_impulses, global WorldHash* world_hashes) {
  const u32 words = (u32)(sizeof(CouplingImpulse) / sizeof(u32));
  HashSum sum = hash_nothing();
  FOR_EACH(k, coupling_count) {
    hash_enter(&sum, coupling_infos[k].world, world_hashes);
    const ulong h = hash_word(hash_start(HASHED_COUPLING), coupling_infos[k].id);
    hash_add_state(&sum, hash_words(h, (global const u32*)(coupling_impulses + k), words));
  }
  hash_hand_over(&sum, world_hashes);
}

static inline ulong hash_spring_end(ulong h, u32 end, u32 particles, global const BodyInfo* body_infos,
                                    global const u32* body_particles, global const u32* particle_bodies,
                                    global const u32* plane_bodies) {
  if (end < particles) {
    const u32 body = particle_bodies[end];
    return hash_word(hash_word(h, body_infos[body].id), end - body_particles[body]);
  }
  const u32 plane = end - particles, body = plane_bodies[plane];
  u32 before = 0u;
  while (before < plane && plane_bodies[plane - before - 1u] == body) ++before;
  return hash_word(hash_word(h, body_infos[body].id), NONE - before);
}

kernel void hash_state_springs(const StepParams params, global const BodyInfo* body_infos,
                               global const u32* body_particles, global const u32* particle_bodies,
                               global const u32* plane_bodies, global const u32* spring_count,
                               global const SpringKey* spring_keys, global const Vec4* spring_stretches,
                               global WorldHash* world_hashes) {
  const u32 particles = body_particles[params.bodies], stretch_words = (u32)(sizeof(Vec4) / sizeof(u32));
  HashSum sum = hash_nothing();
  FOR_EACH(k, spring_count[0]) {
    const SpringKey key = spring_keys[k];
    hash_enter(&sum, body_infos[particle_bodies[key.particle]].world, world_hashes);
    ulong h = hash_start(HASHED_SPRING);
    h = hash_spring_end(h, key.particle, particles, body_infos, body_particles, particle_bodies, plane_bodies);
    h = hash_spring_end(h, key.partner, particles, body_infos, body_particles, particle_bodies, plane_bodies);
    hash_add_state(&sum, hash_words(h, (global const u32*)&spring_stretches[k], stretch_words));
  }
  hash_hand_over(&sum, world_hashes);
}
