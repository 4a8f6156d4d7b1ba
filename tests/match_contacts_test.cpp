#include <gtest/gtest.h>

#include <map>
#include <set>

#include "tests/collision_states.hpp"

namespace lockstep::test::match_contacts_test {
namespace {

template <class real>
class MatchContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(MatchContacts, Precisions);

using Key = std::array<u32, 3>;  // shape a, shape b, feature

std::set<Key> random_keys(Random& random, u32 count) {
  std::set<Key> keys;
  while (keys.size() < count) keys.insert({random.bits() % 30, random.bits() % 30, random.bits() % 3});
  return keys;
}

template <class real>
InitialState<real> contacts_and_cache(const std::set<Key>& current, const std::set<Key>& before) {
  InitialState<real> state = make_worlds<real>({std::vector<BodyDescription>(30, sphere_body({0, 0, 0}, 1))}, 1024);
  Buffers<real>& b = state.buffers;
  std::ranges::fill(b.counters, 0u);
  for (const Key& key : current) b.contacts[b.counters[COUNTER_CONTACTS]++] = {key[0], key[1], key[2], 0, 0, 0, 0, 0};
  for (const Key& key : before) {
    const u32 i = b.cached_count[0]++;
    b.cached_keys[i] = {key[0], key[1], key[2], 0};
    b.cached_impulses[i] = {real(i + 1), real(0.25 * i), real(-0.5 * i), 7};
  }
  return state;
}

// The same where contacts are soft, so that pairs hand over what they have lost.
template <class real>
InitialState<real> soft_contacts_and_cache(const std::set<Key>& current, const std::set<Key>& before) {
  InitialState<real> state = contacts_and_cache<real>(current, before);
  state.features = with(state.features, Feature::soft_contacts);
  resize(state.buffers, state.sizes, state.features);
  return state;
}

template <class real>
void expect_matched(InitialState<real>& state) {
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::match_contacts, b, state.params);
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i) {
    ContactImpulse<real> expected = {0, 0, 0, 0};
    for (u32 k = 0; k < b.cached_count[0]; ++k) {
      const ContactKey& key = b.cached_keys[k];
      if (key.shape_a == b.contacts[i].shape_a && key.shape_b == b.contacts[i].shape_b &&
          key.feature == b.contacts[i].feature)
        expected = b.cached_impulses[k];
    }
    EXPECT_EQ(b.start_impulses[i].normal, expected.normal);
    EXPECT_EQ(b.start_impulses[i].tangent_x, expected.tangent_x);
    EXPECT_EQ(b.start_impulses[i].tangent_y, expected.tangent_y);
    EXPECT_EQ(b.start_impulses[i].tangent_z, expected.tangent_z);
  }
}

TYPED_TEST(MatchContacts, FindsWhatASearchThroughAllFinds) {
  using real = TypeParam;
  Random random(30);
  for (const u32 cached : {0u, 1u, 2u, 3u, 64u, 500u, 1000u}) {
    const std::set<Key> before = random_keys(random, cached);
    std::set<Key> current = random_keys(random, 200);
    for (const Key& key : before) {
      if (random.bits() % 2 == 0 && current.size() < 1000) current.insert(key);
    }
    InitialState<real> state = contacts_and_cache<real>(current, before);
    expect_matched(state);
  }
}

// The first and the last of the cache, and what lies outside of it.
TYPED_TEST(MatchContacts, FindsTheEnds) {
  using real = TypeParam;
  const std::set<Key> before = {{3, 4, 0}, {3, 4, 1}, {3, 5, 0}, {4, 0, 0}};
  std::set<Key> current = before;
  current.insert({{0, 0, 0}, {3, 3, 9}, {3, 4, 2}, {4, 0, 1}, {9, 9, 9}});
  InitialState<real> state = contacts_and_cache<real>(current, before);
  expect_matched(state);
  EXPECT_EQ(state.buffers.start_impulses[2].normal, 1);
  EXPECT_EQ(state.buffers.start_impulses[6].normal, 4);
  EXPECT_EQ(state.buffers.start_impulses[8].normal, 0);
}

// A pair that has lost two of three contacts and gained two: those take what the two carried, half of it each.
TYPED_TEST(MatchContacts, NewContactsOfAPairTakeWhatItLost) {
  using real = TypeParam;
  InitialState<real> state =
      soft_contacts_and_cache<real>({{3, 4, 1}, {3, 4, 5}, {3, 4, 7}, {3, 5, 0}}, {{3, 4, 0}, {3, 4, 5}, {3, 4, 6}});
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::match_contacts, b, state.params);
  const real half_normal = real(0.5) * (b.cached_impulses[0].normal + b.cached_impulses[2].normal);
  const real half_tangent = real(0.5) * (b.cached_impulses[0].tangent_y + b.cached_impulses[2].tangent_y);
  for (const u32 fresh : {0u, 2u}) {
    EXPECT_EQ(b.start_impulses[fresh].normal, half_normal);
    EXPECT_EQ(b.start_impulses[fresh].tangent_y, half_tangent);
  }
  EXPECT_EQ(b.start_impulses[1].normal, b.cached_impulses[1].normal);  // what stays keeps its own
  EXPECT_EQ(b.start_impulses[3].normal, 0);                            // another pair
}

// Four contacts become one of them: it takes the rest.
TYPED_TEST(MatchContacts, ContactsThatStayTakeWhatTheirPairLost) {
  using real = TypeParam;
  InitialState<real> state = soft_contacts_and_cache<real>(
      {{3, 4, 2}, {5, 6, 0}, {5, 6, 1}}, {{3, 4, 0}, {3, 4, 1}, {3, 4, 2}, {3, 4, 3}, {5, 6, 0}, {5, 6, 1}, {5, 6, 9}});
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::match_contacts, b, state.params);
  EXPECT_EQ(b.start_impulses[0].normal, 1 + 2 + 3 + 4);
  EXPECT_EQ(b.start_impulses[1].normal, 5 + real(3.5));
  EXPECT_EQ(b.start_impulses[2].normal, 6 + real(3.5));
}

// Whatever comes and goes, a pair that still touches starts from the sum that it ended with.
TYPED_TEST(MatchContacts, PairsKeepTheirSums) {
  using real = TypeParam;
  Random random(32);
  const std::set<Key> before = random_keys(random, 900), current = random_keys(random, 900);
  InitialState<real> state = soft_contacts_and_cache<real>(current, before);
  Buffers<real>& b = state.buffers;
  reference::run_stage(Stage::match_contacts, b, state.params);
  std::map<std::pair<u32, u32>, double> were, are;
  for (u32 k = 0; k < b.cached_count[0]; ++k)
    were[{b.cached_keys[k].shape_a, b.cached_keys[k].shape_b}] += double(b.cached_impulses[k].normal);
  for (u32 i = 0; i < b.counters[COUNTER_CONTACTS]; ++i)
    are[{b.contacts[i].shape_a, b.contacts[i].shape_b}] += double(b.start_impulses[i].normal);
  ASSERT_GT(are.size(), 100u);
  for (const auto& [pair, sum] : are) EXPECT_NEAR(sum, were[pair], 1e-6 * (1 + sum));
}

TYPED_TEST(MatchContacts, KernelMatchesReference) {
  using real = TypeParam;
  Random random(31);
  for (const u32 cached : {0u, 1u, 1000u}) {
    const std::set<Key> before = random_keys(random, cached);
    std::set<Key> current = random_keys(random, 20);
    for (const Key& key : before) {
      if (random.bits() % 2 == 0) current.insert(key);
    }
    const InitialState<real> state = contacts_and_cache<real>(current, before);
    run_one_stage(Stage::match_contacts, state.buffers, state.sizes, state.features, state.params, launches());
    const InitialState<real> soft = soft_contacts_and_cache<real>(current, before);
    run_one_stage(Stage::match_contacts, soft.buffers, soft.sizes, soft.features, soft.params, launches());
  }
}

}  // namespace
}  // namespace lockstep::test::match_contacts_test
