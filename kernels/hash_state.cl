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

static inline void hash_add_state(global WorldHash* hash, ulong h) {
  atomic_add((volatile global u32*)&hash->state_low, (u32)h);
  atomic_add((volatile global u32*)&hash->state_high, (u32)(h >> 32));
}
static inline void hash_add_pose(global WorldHash* hash, ulong h) {
  atomic_add((volatile global u32*)&hash->pose_low, (u32)h);
  atomic_add((volatile global u32*)&hash->pose_high, (u32)(h >> 32));
}

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
  FOR_EACH(i, params.bodies) {
    const u32 id = body_infos[i].id;
    global WorldHash* hash = &world_hashes[body_infos[i].world];
    const u32 vec4_words = (u32)(sizeof(Vec4) / sizeof(u32));
    const u32 motion_words = (u32)(sizeof(Motion) / sizeof(u32));
    const ulong position =
        hash_words(hash_word(hash_start(HASHED_POSITION), id), (global const u32*)&positions[i], vec4_words);
    const ulong orientation =
        hash_words(hash_word(hash_start(HASHED_ORIENTATION), id), (global const u32*)&orientations[i], vec4_words);
    const ulong motion =
        hash_words(hash_word(hash_start(HASHED_MOTION), id), (global const u32*)&motions[i], motion_words);
    hash_add_state(hash, position);
    hash_add_state(hash, orientation);
    hash_add_state(hash, motion);
    hash_add_pose(hash, position);
    hash_add_pose(hash, orientation);
  }
}

kernel void hash_state_contacts(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                                global const u32* cached_count, global const ContactKey* cached_keys,
                                global const ContactImpulse* cached_impulses, global WorldHash* world_hashes) {
  FOR_EACH(i, cached_count[0]) {
    const ContactKey key = cached_keys[i];
    const ShapeInfo shape_a = shape_infos[key.shape_a];
    ulong h = hash_start(HASHED_CONTACT);
    h = hash_word(h, shape_a.id);
    h = hash_word(h, shape_infos[key.shape_b].id);
    h = hash_word(h, key.feature);
    h = hash_word(h, key.pad);
    h = hash_words(h, (global const u32*)&cached_impulses[i], (u32)(sizeof(ContactImpulse) / sizeof(u32)));
    hash_add_state(&world_hashes[body_infos[shape_a.body].world], h);
  }
}

kernel void hash_state_touching(global const BodyInfo* body_infos, global const ShapeInfo* shape_infos,
                                global const u32* touching_count, global const Pair* touching,
                                global WorldHash* world_hashes) {
  FOR_EACH(i, touching_count[0]) {
    const ShapeInfo shape_a = shape_infos[touching[i].shape_a];
    ulong h = hash_start(HASHED_TOUCH);
    h = hash_word(h, shape_a.id);
    h = hash_word(h, shape_infos[touching[i].shape_b].id);
    hash_add_state(&world_hashes[body_infos[shape_a.body].world], h);
  }
}

#if FEATURE_JOINTS
kernel void hash_state_joints(const StepParams params, global const JointInfo* joint_infos,
                              global const JointLanes* joint_lanes, global const JointImpulseBlock* joint_impulses,
                              global WorldHash* world_hashes) {
  const u32 real_words = (u32)(sizeof(real) / sizeof(u32));
  FOR_EACH(slot, params.joint_blocks * PACK) {
    const u32 lane = slot % PACK, joint = joint_lanes[slot / PACK].joint[lane];
    if (joint == NONE) continue;
    global const JointImpulseBlock* impulses = joint_impulses + slot / PACK;
    ulong h = hash_word(hash_start(HASHED_JOINT), joint_infos[joint].id);
    for (u32 i = 0u; i < JOINT_ROWS; ++i) h = hash_words(h, (global const u32*)&impulses->locked[i][lane], real_words);
    h = hash_words(h, (global const u32*)&impulses->free[lane], real_words);
    hash_add_state(&world_hashes[joint_infos[joint].world], h);
  }
}
#endif
