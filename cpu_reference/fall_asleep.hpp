// Counts for how many steps each dynamic body has been slow, and lets islands fall asleep at the end of a step.
//
// A body is slow while |v| <= speed and |w| <= angular_speed (SleepLaw), at the ends of steps; a sleep candidate, when
// it has been for as many steps as the world says. An island is what contacts and joints hold together, through dynamic
// bodies only; it falls asleep when all of its bodies are sleep candidates and none of them touches, or is held to, a
// kinematic body that moves. It then has no velocity. An island is named by the smallest index of its bodies, so that
// it has one name however it is found: the kernels hook trees of bodies onto each other (Jaiganesh and Burtscher, A
// High-Performance Connected Components Implementation for GPUs, 2018).
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

namespace lockstep::reference {

template <class real>
bool is_slow(const SleepLaw<real>& law, const Motion<real>& m) {
  return dot3(vec3(m.v), vec3(m.v)) <= law.speed * law.speed &&
         dot3(vec3(m.w), vec3(m.w)) <= law.angular_speed * law.angular_speed;
}

template <class real>
bool is_sleep_candidate(const Buffers<real>& b, u32 body) {
  if (body >= b.body_infos.size() || b.body_infos[body].kind != BODY_DYNAMIC) return false;
  return b.sleepers[body].island == NONE && b.sleepers[body].still >= b.sleep_steps[b.body_infos[body].world];
}

/// Those who are awake count on; whoever was woken is awake by now.
template <class real>
void count_still_steps(Buffers<real>& b) {
  for (u32 i = 0; i < b.sleepers.size(); ++i) {
    Sleeper& sleeper = b.sleepers[i];
    if (b.body_infos[i].kind != BODY_DYNAMIC || is_asleep(b, i)) continue;
    if (sleeper.island == ISLAND_WAKES) b.counters[COUNTER_CHANGED] = 1;
    sleeper.island = NONE;
    const bool slow = is_slow(b.sleep_laws[i], b.motions[i]);
    sleeper.still = slow ? std::min(sleeper.still, NONE - 1) + 1 : 0;
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
void fall_asleep(Buffers<real>& b, const StepParams<real>&) {
  if (step_aborted(b.counters)) return;
  count_still_steps(b);
  if (b.counters[COUNTER_SLEEP_CANDIDATES] != 0) put_to_sleep(b, find_islands(b));
  count_sleepers(b);
  if (b.counters[COUNTER_CHANGED] != 0) keep_impulses(b);
}

}  // namespace lockstep::reference
