// Counts for how many steps each dynamic body has been still, and lets islands fall asleep at the end of a step.
//
// A body is still, at the ends of steps, while it trembles at the most: while |v| <= speed and |w| <= angular_speed
// (SleepLaw), and it is where it was when it began to be still, but for REST_JITTER of its radius. Whoever has been
// still for as many steps as the world says is a sleep candidate if it is at rest, else it begins anew. At rest is what
// neither keeps moving, in the time T since it began, nor falls, nor is moved by its load:
//
//   keeps moving  |(dx - (v0 (T - h) + v1 (T + h)) / 2) . v| <= v.v T / 4, v the faster one of v0 and v1: along it the
//                 displacement dx in T is that of an even acceleration from v0 to v1 in sub-steps h, zero among them:
//                 what trembles comes back, and what comes to rest has been there for most of T. Across it a body may
//                 settle meanwhile. And it has been as far as |v| T / 8 from where it began. Below REST_DRIFT no
//                 motion matters. The same holds with v1 for v0, after a blow at the beginning, and for angles
//   falls         |v1 - v0| > |g + f / m| dt / 2: constraints have not carried it in the last step
//   is moved      the velocity changes along f / m by what the load alone would make in T, or by half as much more or
//                 less; and so by a torque
//
// A sleep candidate is asked again each time that it has been one for as many steps.
//
// An island is what contacts and joints hold together, through dynamic bodies only; it falls asleep when all of its
// bodies are sleep candidates and none of them touches, or is held to, a kinematic body that moves. It then has no
// velocity. An island is named by the smallest index of its bodies, so that it has one name however it is found: the
// kernels hook trees of bodies onto each other (Jaiganesh and Burtscher, A High-Performance Connected Components
// Implementation for GPUs, 2018).
//
// The impulses that its contacts end with join those of other sleepers, and wait there for match_contacts; those of
// islands that have woken go. With them is where they are, for who asks what sleepers carry. Both lists are ordered by
// (shape a, shape b, feature), and so is what they become.
#pragma once

#include <numeric>
#include <tuple>
#include <vector>

#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/sleep.hpp"
#include "kernels/rest_bounds.h"

namespace lockstep::reference {

template <class real>
bool is_sleep_candidate(const Buffers<real>& b, u32 body) {
  if (body >= b.body_infos.size() || b.body_infos[body].kind != BODY_DYNAMIC) return false;
  return b.sleepers[body].island == NONE && b.sleepers[body].still >= b.sleep_steps[b.body_infos[body].world];
}

template <class real>
bool is_slow(const SleepLaw<real>& law, const Motion<real>& m) {
  return dot3(vec3(m.v), vec3(m.v)) <= law.speed * law.speed &&
         dot3(vec3(m.w), vec3(m.w)) <= law.angular_speed * law.angular_speed;
}

/// Of a displacement or an angle that the velocity has made while it changed from v0 to v1.
template <class real>
bool keeps_moving(Vec3<real> displacement, Vec3<real> v0, Vec3<real> v1, real farthest2, real time, real dt,
                  real radius) {
  const real square0 = dot3(v0, v0), square1 = dot3(v1, v1);
  const Vec3<real> v = square0 > square1 ? v0 : v1;
  const real square = square0 > square1 ? square0 : square1, largest = square * (time * time);
  const Vec3<real> even = add3(scale3(real(0.5f) * (time - dt), v0), scale3(real(0.5f) * (time + dt), v1));
  const Vec3<real> miss = sub3(displacement, even);
  const real drift = real(REST_DRIFT) * radius;
  return largest > drift * drift && largest <= real(64) * farthest2 &&
         real(4) * std::abs(dot3(miss, v)) <= square * time;
}

/// Whether the velocity has changed by more than half of what gravity and the load make in one step, if they do not
/// balance each other.
template <class real>
bool falls(Vec3<real> gravity, Vec3<real> load, Vec3<real> change, real step_time) {
  const Vec3<real> sum = add3(gravity, load);
  const real square = dot3(sum, sum);
  return square > real(REST_BALANCE) * (dot3(gravity, gravity) + dot3(load, load)) &&
         real(4) * dot3(change, change) > step_time * step_time * square;
}

template <class real>
bool is_moved_by(Vec3<real> acceleration, Vec3<real> change, real time) {
  const real along = dot3(change, acceleration), full = dot3(acceleration, acceleration) * time;
  return full > 0 && along >= real(0.5f) * full && along <= real(1.5f) * full;
}

/// By how much a body has rotated, for small angles.
template <class real>
Vec3<real> angle_between(Quat<real> before, Quat<real> after) {
  const Quat<real> delta = multiply4(after, Quat<real>{-before.x, -before.y, -before.z, before.w});
  const real twice = delta.w < 0 ? real(-2) : real(2);
  return scale3(twice, Vec3<real>{delta.x, delta.y, delta.z});
}

/// Whether a body is at rest that has been still for some steps.
template <class real>
bool is_at_rest(const Buffers<real>& b, const StepParams<real>& params, u32 i, u32 steps, Vec3<real> displacement,
                Vec3<real> angle) {
  const Motion<real>& m = b.motions[i];
  const StillStart<real>& start = b.still_starts[i];
  const real step_time = params.dt * static_cast<real>(params.substeps), time = static_cast<real>(steps) * step_time;
  const Vec3<real> v0 = vec3(start.v), w0 = vec3(start.w), v1 = vec3(m.v), w1 = vec3(m.w);
  const Vec3<real> change = sub3(v1, v0);
  Vec3<real> load = {}, angular_load = {};
  if (!b.loads.empty()) {
    load = scale3(m.inverse_mass, vec3(b.loads[i].force));
    angular_load = apply_inverse_inertia(m, vec3(b.loads[i].torque));
  }
  const real radius = b.sleep_laws[i].radius;
  return !keeps_moving(displacement, v0, v1, start.farthest2, time, params.dt, radius) &&
         !keeps_moving(displacement, v1, v1, start.farthest2, time, params.dt, radius) &&
         !keeps_moving(angle, w0, w1, start.largest_angle2, time, params.dt, real(1)) &&
         !keeps_moving(angle, w1, w1, start.largest_angle2, time, params.dt, real(1)) &&
         !falls(vec3_of(b.gravities[b.body_infos[i].world]), load, change, step_time) &&
         !is_moved_by(load, change, time) && !is_moved_by(angular_load, sub3(w1, w0), time);
}

/// The steps in a row that a body has been still for, this one among them; who has been for `steps` is a sleep
/// candidate, and twice as many are as good.
template <class real>
u32 still_steps(Buffers<real>& b, const StepParams<real>& params, u32 i, u32 still) {
  const SleepLaw<real>& law = b.sleep_laws[i];
  const Motion<real>& m = b.motions[i];
  if (!is_slow(law, m)) return 0;
  StillStart<real>& start = b.still_starts[i];
  const u32 steps = b.sleep_steps[b.body_infos[i].world], next = std::min(still, NONE - 1) + 1;
  const Vec3<real> x = vec3_of(b.positions[i]);
  const Quat<real> q = quat(b.orientations[i]);
  const Vec3<real> displacement = sub3(x, vec3(start.position));
  const Vec3<real> angle = angle_between(
      Quat<real>{start.orientation[0], start.orientation[1], start.orientation[2], start.orientation[3]}, q);
  const real bound = real(REST_JITTER) * law.radius;
  const real distance2 = dot3(displacement, displacement), angle2 = dot3(angle, angle);
  const bool stays = still != 0 && distance2 < bound * bound && angle2 < real(REST_JITTER) * real(REST_JITTER);
  start.farthest2 = distance2 > start.farthest2 ? distance2 : start.farthest2;
  start.largest_angle2 = angle2 > start.largest_angle2 ? angle2 : start.largest_angle2;
  const bool first = next == steps, asked = first || (next > steps && next - steps >= steps);
  if (stays && !asked) return next;
  const bool rests = stays && is_at_rest(b, params, i, first ? steps - 1 : steps, displacement, angle);
  start.farthest2 = start.largest_angle2 = 0;
  store3(start.position, x);
  start.orientation[0] = q.x, start.orientation[1] = q.y, start.orientation[2] = q.z, start.orientation[3] = q.w;
  store3(start.v, vec3(m.v));
  store3(start.w, vec3(m.w));
  return rests ? steps : 1;
}

/// Those who are awake count on; whoever was woken is awake by now.
template <class real>
void count_still_steps(Buffers<real>& b, const StepParams<real>& params) {
  for (u32 i = 0; i < b.sleepers.size(); ++i) {
    Sleeper& sleeper = b.sleepers[i];
    if (b.body_infos[i].kind != BODY_DYNAMIC || is_asleep(b, i)) continue;
    if (sleeper.island == ISLAND_WAKES) b.counters[COUNTER_CHANGED] = 1;
    sleeper.island = NONE;
    sleeper.still = still_steps(b, params, i, sleeper.still);
    if (is_sleep_candidate(b, i)) b.counters[COUNTER_SLEEP_CANDIDATES] = 1;
  }
}

/// Trees of bodies: the root of each is the smallest of its bodies.
struct Islands {
  std::vector<u32> parents;
  std::vector<bool> disturbed;  // by root, once all are joined

  explicit Islands(std::size_t bodies) : parents(bodies), disturbed(bodies, false) {
    std::iota(parents.begin(), parents.end(), 0u);
  }
  u32 root(u32 body) const {
    while (parents[body] != body) body = parents[body];
    return body;
  }
  void join(u32 a, u32 b) {
    const u32 root_a = root(a), root_b = root(b);
    parents[std::max(root_a, root_b)] = std::min(root_a, root_b);
  }
};

template <class real>
Islands find_islands(const Buffers<real>& b) {
  Islands islands(b.sleepers.size());
  std::vector<bool> disturbed(b.sleepers.size(), false);
  const auto meet = [&](u32 body_a, u32 body_b) {
    const bool candidate_a = is_sleep_candidate(b, body_a), candidate_b = is_sleep_candidate(b, body_b);
    if (candidate_a && candidate_b) islands.join(body_a, body_b);
    if (candidate_a && !candidate_b && is_moving(b, body_b)) disturbed[body_a] = true;
    if (candidate_b && !candidate_a && is_moving(b, body_a)) disturbed[body_b] = true;
  };
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) meet(b.contacts[i].body_a, b.contacts[i].body_b);
  for_each_joined_pair(b, meet);
  for (u32 i = 0; i < disturbed.size(); ++i) {
    if (disturbed[i]) islands.disturbed[islands.root(i)] = true;
  }
  return islands;
}

template <class real>
void put_to_sleep(Buffers<real>& b, const Islands& islands) {
  std::vector<u32> resting;
  for (u32 i = 0; i < b.sleepers.size(); ++i) {
    if (is_sleep_candidate(b, i) && !islands.disturbed[islands.root(i)]) resting.push_back(i);
  }
  for (const u32 i : resting) {
    b.sleepers[i] = {0, islands.root(i)};
    store3(b.motions[i].v, Vec3<real>{0, 0, 0});
    store3(b.motions[i].w, Vec3<real>{0, 0, 0});
    b.counters[COUNTER_CHANGED] = 1;
  }
}

template <class real>
void count_sleepers(Buffers<real>& b) {
  for (u32 i = 0; i < b.sleepers.size(); ++i) {
    if (is_asleep(b, i)) ++b.counters[COUNTER_ASLEEP];
    if (b.sleepers[i].island == i) ++b.counters[COUNTER_ISLANDS];
    if (is_moving(b, i)) ++b.counters[COUNTER_MOVING];
  }
}

/// What sleepers wake up with: of those that sleep on, and of those that have fallen asleep now.
template <class real>
void keep_impulses(Buffers<real>& b) {
  std::vector<ContactKey> keys;
  std::vector<ContactImpulse<real>> impulses;
  std::vector<Vec4<real>> moments;
  std::vector<ContactPoint<real>> points;
  const u32 count = b.counters[COUNTER_CONTACTS], slept = b.slept_count[0];
  const auto sleeps = [&](u32 shape_a, u32 shape_b) {
    return is_asleep(b, b.shape_infos[shape_a].body) || is_asleep(b, b.shape_infos[shape_b].body);
  };
  const auto as_tuple = [](const auto& contact) { return std::tie(contact.shape_a, contact.shape_b, contact.feature); };
  for (u32 i = 0, k = 0; i < count || k < slept;) {
    const bool is_new = k == slept || (i < count && as_tuple(b.contacts[i]) < as_tuple(b.slept_keys[k]));
    const ContactKey key =
        is_new ? ContactKey{b.contacts[i].shape_a, b.contacts[i].shape_b, b.contacts[i].feature, b.contacts[i].normal}
               : b.slept_keys[k];
    const ContactImpulse<real>& impulse = is_new ? b.cached_impulses[i] : b.slept_impulses[k];
    if (sleeps(key.shape_a, key.shape_b)) {
      keys.push_back(key);
      impulses.push_back(impulse);
      points.push_back(is_new ? b.contact_points[i] : b.slept_points[k]);
      if (!b.slept_moments.empty()) moments.push_back(is_new ? b.cached_moments[i] : b.slept_moments[k]);
    }
    is_new ? ++i : ++k;
  }
  b.slept_count[0] = static_cast<u32>(keys.size());
  std::copy(keys.begin(), keys.end(), b.slept_keys.begin());
  std::copy(impulses.begin(), impulses.end(), b.slept_impulses.begin());
  std::copy(moments.begin(), moments.end(), b.slept_moments.begin());
  std::copy(points.begin(), points.end(), b.slept_points.begin());
}

template <class real>
void fall_asleep(Buffers<real>& b, const StepParams<real>& params) {
  if (step_aborted(b.counters)) return;
  count_still_steps(b, params);
  if (b.counters[COUNTER_SLEEP_CANDIDATES] != 0) put_to_sleep(b, find_islands(b));
  count_sleepers(b);
  if (b.counters[COUNTER_CHANGED] != 0) keep_impulses(b);
}

}  // namespace lockstep::reference
