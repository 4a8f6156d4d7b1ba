#pragma OPENCL FP_CONTRACT OFF
// Counts how long bodies have been still, and lets islands fall asleep (cpu_reference/fall_asleep.hpp).
#include "common.h"
#include "rest_bounds.h"
#include "rigid_body.h"
#include "sleep.h"
#include "types.h"

static inline bool is_sleep_candidate(u32 body, u32 bodies, global const BodyInfo* body_infos,
                                      global const u32* sleep_steps, global const Sleeper* sleepers) {
  if (body >= bodies || body_infos[body].kind != BODY_DYNAMIC) return false;
  return sleepers[body].island == NONE && sleepers[body].still >= sleep_steps[body_infos[body].world];
}

static inline bool is_slow(SleepLaw law, Vec3 v, Vec3 w) {
  return dot3(v, v) <= law.speed * law.speed && dot3(w, w) <= law.angular_speed * law.angular_speed;
}

static inline bool keeps_moving(Vec3 displacement, Vec3 v0, Vec3 v1, real farthest2, real time, real dt, real radius) {
  const real square0 = dot3(v0, v0), square1 = dot3(v1, v1);
  const Vec3 v = square0 > square1 ? v0 : v1;
  const real square = square0 > square1 ? square0 : square1, largest = square * (time * time);
  const Vec3 even = add3(scale3((real)0.5f * (time - dt), v0), scale3((real)0.5f * (time + dt), v1));
  const Vec3 miss = sub3(displacement, even);
  const real drift = (real)REST_DRIFT * radius;
  return largest > drift * drift && largest <= (real)64 * farthest2 && (real)4 * fabs(dot3(miss, v)) <= square * time;
}

static inline bool falls(Vec3 gravity, Vec3 load, Vec3 change, real step_time) {
  const Vec3 sum = add3(gravity, load);
  const real square = dot3(sum, sum);
  return square > (real)REST_BALANCE * (dot3(gravity, gravity) + dot3(load, load)) &&
         (real)4 * dot3(change, change) > step_time * step_time * square;
}

static inline bool is_moved_by(Vec3 acceleration, Vec3 change, real time) {
  const real along = dot3(change, acceleration), full = dot3(acceleration, acceleration) * time;
  return full > (real)0 && along >= (real)0.5f * full && along <= (real)1.5f * full;
}

static inline Vec3 angle_between(Quat before, Quat after) {
  const Quat delta = multiply4(after, make4(-before.x, -before.y, -before.z, before.w));
  const real twice = delta.w < (real)0 ? (real)-2 : (real)2;
  return scale3(twice, make3(delta.x, delta.y, delta.z));
}

static inline bool is_at_rest(const StepParams* params, u32 steps, real radius, Vec3 displacement, Vec3 angle,
                              Motion motion, StillStart start, Vec3 gravity, Load load) {
  const real step_time = params->dt * (real)params->substeps, time = (real)steps * step_time;
  const Vec3 v0 = vec3(start.v), w0 = vec3(start.w), v1 = vec3(motion.v), w1 = vec3(motion.w);
  const Vec3 change = sub3(v1, v0);
  const Vec3 acceleration = scale3(motion.inverse_mass, vec3(load.force));
  const Vec3 angular_acceleration = apply_inverse_inertia(motion, vec3(load.torque));
  return !keeps_moving(displacement, v0, v1, start.farthest2, time, params->dt, radius) &&
         !keeps_moving(displacement, v1, v1, start.farthest2, time, params->dt, radius) &&
         !keeps_moving(angle, w0, w1, start.largest_angle2, time, params->dt, (real)1) &&
         !keeps_moving(angle, w1, w1, start.largest_angle2, time, params->dt, (real)1) &&
         !falls(gravity, acceleration, change, step_time) && !is_moved_by(acceleration, change, time) &&
         !is_moved_by(angular_acceleration, sub3(w1, w0), time);
}

static inline u32 still_steps(const StepParams* params, u32 still, u32 steps, SleepLaw law, Motion motion, Vec3 gravity,
                              Load load, Vec4 position, Vec4 orientation, global StillStart* start) {
  const Vec3 v = vec3(motion.v), w = vec3(motion.w);
  if (!is_slow(law, v, w)) return 0u;
  const u32 next = (still < NONE - 1u ? still : NONE - 1u) + 1u;
  const Vec3 x = vec3_of(position);
  const Quat q = quat(orientation);
  StillStart was = *start;
  const Vec3 displacement = sub3(x, vec3(was.position));
  const Vec3 angle =
      angle_between(make4(was.orientation[0], was.orientation[1], was.orientation[2], was.orientation[3]), q);
  const real bound = (real)REST_JITTER * law.radius;
  const real distance2 = dot3(displacement, displacement), angle2 = dot3(angle, angle);
  const bool stays = still != 0u && distance2 < bound * bound && angle2 < (real)REST_JITTER * (real)REST_JITTER;
  was.farthest2 = distance2 > was.farthest2 ? distance2 : was.farthest2;
  was.largest_angle2 = angle2 > was.largest_angle2 ? angle2 : was.largest_angle2;
  const bool first = next == steps, asked = first || (next > steps && next - steps >= steps);
  if (stays && !asked) {
    start->farthest2 = was.farthest2;
    start->largest_angle2 = was.largest_angle2;
    return next;
  }
  const bool rests = stays && is_at_rest(params, first ? steps - 1u : steps, law.radius, displacement, angle, motion,
                                         was, gravity, load);
  for (u32 k = 0u; k < 3u; ++k) {
    start->v[k] = motion.v[k];
    start->w[k] = motion.w[k];
  }
  start->farthest2 = (real)0;
  start->largest_angle2 = (real)0;
  start->position[0] = x.x;
  start->position[1] = x.y;
  start->position[2] = x.z;
  start->orientation[0] = q.x;
  start->orientation[1] = q.y;
  start->orientation[2] = q.z;
  start->orientation[3] = q.w;
  return rests ? steps : 1u;
}

// The first of five: those who are awake count on. Each body is a tree of its own, and nobody is disturbed.
kernel void sleep_count(const StepParams params, global const BodyInfo* body_infos, global const SleepLaw* sleep_laws,
                        global const u32* sleep_steps, global const Vec4* gravities, global const Load* loads,
                        global const Vec4* positions, global const Vec4* orientations, global const Motion* motions,
                        global Sleeper* sleepers, global StillStart* still_starts, global u32* island_parents,
                        global u32* disturbed_bodies, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  bool any_candidate = false, changed = false;
  FOR_EACH(i, params.bodies) {
    island_parents[i] = i;
    disturbed_bodies[i] = 0u;
    if (body_infos[i].kind != BODY_DYNAMIC || is_asleep(sleepers, i)) continue;
    changed = changed || sleepers[i].island == ISLAND_WAKES;
    const u32 world = body_infos[i].world;
#if FEATURE_LOADS
    const Load load = loads[i];
#else
    const Load load = {{(real)0, (real)0, (real)0}, (real)0, {(real)0, (real)0, (real)0}, (real)0};
#endif
    const u32 still = still_steps(&params, sleepers[i].still, sleep_steps[world], sleep_laws[i], motions[i],
                                  vec3_of(gravities[world]), load, positions[i], orientations[i], &still_starts[i]);
    sleepers[i].island = NONE;
    sleepers[i].still = still;
    any_candidate = any_candidate || is_sleep_candidate(i, params.bodies, body_infos, sleep_steps, sleepers);
  }
  if (any_candidate) atomic_or(&counters[COUNTER_SLEEP_CANDIDATES], 1u);
  if (changed) atomic_or(&counters[COUNTER_CHANGED], 1u);
}

// ---- trees of bodies: a parent has a smaller index, a root is its own. Work-items hook them together beside each
// other, so that words are read and written by atomics alone; the smallest body of an island ends as its root whatever
// the order.

static inline u32 island_parent(u32 body, global u32* parents) { return atomic_or(&parents[body], 0u); }

// The root as it is now; what is on the way is hung closer to it.
static inline u32 island_root(u32 body, global u32* parents) {
  u32 parent = island_parent(body, parents);
  while (parent != body) {
    const u32 above = island_parent(parent, parents);
    atomic_min(&parents[body], above);
    body = parent;
    parent = above;
  }
  return body;
}

// Hooks the larger root under the smaller one; where that has been hooked by somebody else meanwhile, tries again.
static inline void island_join(u32 a, u32 b, global u32* parents) {
  u32 root_a = island_root(a, parents), root_b = island_root(b, parents);
  while (root_a != root_b) {
    const u32 high = root_a > root_b ? root_a : root_b, low = root_a > root_b ? root_b : root_a;
    if (atomic_cmpxchg(&parents[high], high, low) == high) return;
    root_a = island_root(high, parents);
    root_b = island_root(low, parents);
  }
}

static inline void sleep_meet(u32 a, u32 b, u32 bodies, global const BodyInfo* body_infos,
                              global const u32* sleep_steps, global const Motion* motions,
                              global const Sleeper* sleepers, global u32* island_parents,
                              global u32* disturbed_bodies) {
  const bool candidate_a = is_sleep_candidate(a, bodies, body_infos, sleep_steps, sleepers);
  const bool candidate_b = is_sleep_candidate(b, bodies, body_infos, sleep_steps, sleepers);
  if (candidate_a && candidate_b) {
    island_join(a, b, island_parents);
  } else if (candidate_a) {
    if (is_moving(b, bodies, body_infos, motions, sleepers)) atomic_or(&disturbed_bodies[a], 1u);
  } else if (candidate_b) {
    if (is_moving(a, bodies, body_infos, motions, sleepers)) atomic_or(&disturbed_bodies[b], 1u);
  }
}

kernel void sleep_join(const StepParams params, global const BodyInfo* body_infos, global const u32* sleep_steps,
                       global const Motion* motions, global const Contact* contacts,
                       global const JointLanes* joint_lanes, global const Sleeper* sleepers, global u32* island_parents,
                       global u32* disturbed_bodies, global const u32* counters) {
  if (STEP_ABORTED(counters) || counters[COUNTER_SLEEP_CANDIDATES] == 0u) return;
#if FEATURE_CONTACTS
  FOR_EACH(i, counters[COUNTER_CONTACTS]) {
    sleep_meet(contacts[i].body_a, contacts[i].body_b, params.bodies, body_infos, sleep_steps, motions, sleepers,
               island_parents, disturbed_bodies);
  }
#endif
#if FEATURE_JOINTS
  FOR_EACH(slot, params.joint_blocks * PACK) {
    global const JointLanes* lanes = joint_lanes + slot / PACK;
    if (lanes->joint[slot % PACK] == NONE) continue;
    sleep_meet(lanes->body_a[slot % PACK], lanes->body_b[slot % PACK], params.bodies, body_infos, sleep_steps, motions,
               sleepers, island_parents, disturbed_bodies);
  }
#endif
}

// Who is disturbed disturbs the island.
kernel void sleep_roots(const StepParams params, global u32* island_parents, global u32* disturbed_bodies,
                        global const u32* counters) {
  if (STEP_ABORTED(counters) || counters[COUNTER_SLEEP_CANDIDATES] == 0u) return;
  FOR_EACH(i, params.bodies) {
    const u32 root = island_root(i, island_parents);
    if (root != i && atomic_or(&disturbed_bodies[i], 0u) != 0u) atomic_or(&disturbed_bodies[root], 1u);
  }
}

// Islands of sleep candidates that nobody disturbs sleep; and who does is counted.
kernel void sleep_apply(const StepParams params, global const BodyInfo* body_infos, global const u32* sleep_steps,
                        global u32* island_parents, global const u32* disturbed_bodies, global Motion* motions,
                        global Sleeper* sleepers, global u32* counters) {
  if (STEP_ABORTED(counters)) return;
  u32 asleep = 0u, islands = 0u, moving = 0u;
  bool changed = false;
  FOR_EACH(i, params.bodies) {
    if (is_sleep_candidate(i, params.bodies, body_infos, sleep_steps, sleepers)) {
      const u32 root = island_root(i, island_parents);
      if (disturbed_bodies[root] == 0u) {
        sleepers[i].still = 0u;
        sleepers[i].island = root;
        for (u32 k = 0u; k < 3u; ++k) {
          motions[i].v[k] = (real)0;
          motions[i].w[k] = (real)0;
        }
        changed = true;
      }
    }
    asleep += is_asleep(sleepers, i) ? 1u : 0u;
    islands += sleepers[i].island == i ? 1u : 0u;
    moving += is_moving(i, params.bodies, body_infos, motions, sleepers) ? 1u : 0u;
  }
  if (asleep != 0u) atomic_add(&counters[COUNTER_ASLEEP], asleep);
  if (islands != 0u) atomic_add(&counters[COUNTER_ISLANDS], islands);
  if (moving != 0u) atomic_add(&counters[COUNTER_MOVING], moving);
  if (changed) atomic_or(&counters[COUNTER_CHANGED], 1u);
}

// ---- what sleepers wake up with -----------------------------------------------------------------------------------

#if FEATURE_CONTACTS
static inline bool keep_is_before(u32 shape_a, u32 shape_b, u32 feature, u32 than_a, u32 than_b, u32 than_feature) {
  if (shape_a != than_a) return shape_a < than_a;
  return shape_b != than_b ? shape_b < than_b : feature < than_feature;
}

// How many of `count` keys are before a contact.
static inline u32 keep_keys_before(global const ContactKey* keys, u32 count, Contact contact) {
  u32 low = 0u, high = count;
  while (low < high) {
    const u32 middle = low + (high - low) / 2u;
    const ContactKey key = keys[middle];
    if (keep_is_before(key.shape_a, key.shape_b, key.feature, contact.shape_a, contact.shape_b, contact.feature))
      low = middle + 1u;
    else
      high = middle;
  }
  return low;
}

// How many of `count` contacts are before a key.
static inline u32 keep_contacts_before(global const Contact* contacts, u32 count, ContactKey key) {
  u32 low = 0u, high = count;
  while (low < high) {
    const u32 middle = low + (high - low) / 2u;
    const Contact c = contacts[middle];
    if (keep_is_before(c.shape_a, c.shape_b, c.feature, key.shape_a, key.shape_b, key.feature))
      low = middle + 1u;
    else
      high = middle;
  }
  return low;
}

static inline bool keep_sleeps(u32 body_a, u32 body_b, global const Sleeper* sleepers) {
  return is_asleep(sleepers, body_a) || is_asleep(sleepers, body_b);
}

// One work-group, the last: entry i of kept_contacts is the number of contacts before the i-th that stay, and so of
// kept_keys; then each goes to its own slot. keep_sums has two words a work-item and two more.
kernel void sleep_keep(global const ShapeInfo* shape_infos, global const Contact* contacts,
                       global const ContactPoint* contact_points, global const ContactImpulse* cached_impulses,
                       global const Vec4* cached_moments, global const Sleeper* sleepers, global u32* slept_count,
                       global ContactKey* slept_keys, global ContactImpulse* slept_impulses, global Vec4* slept_moments,
                       global ContactPoint* slept_points, global u32* kept_contacts, global u32* kept_keys,
                       global u32* keep_sums, global ContactKey* merged_keys, global ContactImpulse* merged_impulses,
                       global Vec4* merged_moments, global ContactPoint* merged_points, global const u32* counters) {
  const bool merges = !STEP_ABORTED(counters) && counters[COUNTER_CHANGED] != 0u;
  const u32 count = merges ? counters[COUNTER_CONTACTS] : 0u, slept = merges ? slept_count[0] : 0u;
  const u32 item = (u32)get_local_id(0), items = (u32)get_local_size(0);
  const u32 contact_share = count / items + 1u, key_share = slept / items + 1u;
  const u32 first_contact = min(item * contact_share, count), end_contact = min(first_contact + contact_share, count);
  const u32 first_key = min(item * key_share, slept), end_key = min(first_key + key_share, slept);

  u32 contact_sum = 0u, key_sum = 0u;
  for (u32 i = first_contact; i < end_contact; ++i) {
    kept_contacts[i] = contact_sum;
    contact_sum += keep_sleeps(contacts[i].body_a, contacts[i].body_b, sleepers) ? 1u : 0u;
  }
  for (u32 k = first_key; k < end_key; ++k) {
    kept_keys[k] = key_sum;
    key_sum += keep_sleeps(shape_infos[slept_keys[k].shape_a].body, shape_infos[slept_keys[k].shape_b].body, sleepers)
                   ? 1u
                   : 0u;
  }
  keep_sums[2u * item] = contact_sum;
  keep_sums[2u * item + 1u] = key_sum;
  barrier(CLK_GLOBAL_MEM_FENCE);
  if (item == 0u) {
    u32 contacts_before = 0u, keys_before = 0u;
    for (u32 n = 0u; n < items; ++n) {
      const u32 more_contacts = keep_sums[2u * n], more_keys = keep_sums[2u * n + 1u];
      keep_sums[2u * n] = contacts_before;
      keep_sums[2u * n + 1u] = keys_before;
      contacts_before += more_contacts;
      keys_before += more_keys;
    }
    kept_contacts[count] = contacts_before;
    kept_keys[slept] = keys_before;
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  for (u32 i = first_contact; i < end_contact; ++i) kept_contacts[i] += keep_sums[2u * item];
  for (u32 k = first_key; k < end_key; ++k) kept_keys[k] += keep_sums[2u * item + 1u];
  barrier(CLK_GLOBAL_MEM_FENCE);

  for (u32 i = item; i < count; i += items) {
    if (kept_contacts[i + 1u] == kept_contacts[i]) continue;
    const Contact contact = contacts[i];
    const u32 slot = kept_contacts[i] + kept_keys[keep_keys_before(slept_keys, slept, contact)];
    merged_keys[slot].shape_a = contact.shape_a;
    merged_keys[slot].shape_b = contact.shape_b;
    merged_keys[slot].feature = contact.feature;
    merged_keys[slot].normal = contact.normal;
    merged_impulses[slot] = cached_impulses[i];
    merged_points[slot] = contact_points[i];
#if FEATURE_ANGULAR_FRICTION
    merged_moments[slot] = cached_moments[i];
#endif
  }
  for (u32 k = item; k < slept; k += items) {
    if (kept_keys[k + 1u] == kept_keys[k]) continue;
    const u32 slot = kept_keys[k] + kept_contacts[keep_contacts_before(contacts, count, slept_keys[k])];
    merged_keys[slot] = slept_keys[k];
    merged_impulses[slot] = slept_impulses[k];
    merged_points[slot] = slept_points[k];
#if FEATURE_ANGULAR_FRICTION
    merged_moments[slot] = slept_moments[k];
#endif
  }
  barrier(CLK_GLOBAL_MEM_FENCE);
  const u32 kept = kept_contacts[count] + kept_keys[slept];
  for (u32 k = item; k < kept; k += items) {
    slept_keys[k] = merged_keys[k];
    slept_impulses[k] = merged_impulses[k];
    slept_points[k] = merged_points[k];
#if FEATURE_ANGULAR_FRICTION
    slept_moments[k] = merged_moments[k];
#endif
  }
  if (merges && item == 0u) slept_count[0] = kept;
}
#endif
