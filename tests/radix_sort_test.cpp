// The sort of kernels/radix_sort.cl against the standard library's stable sort.
#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>

#include "tests/launcher_bench.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test::radix_sort_test {
namespace {

// A device with the sort and the scan that it needs. More lanes than one stand for a CPU: a chunk is a work-item's, and
// digits and chunks are others.
struct SortBench : LauncherBench {
  SortBench(u32 work_group, u32 lanes)
      : LauncherBench(KernelSources::embedded(), std::vector<std::string>{"radix_sort.cl", "scan.cl"}, work_group,
                      false, lanes) {}
};

// Sorts on the device, from arrays with something behind their ends, which must stay as it is.
void expect_sorted(LauncherBench& bench, std::vector<u32> keys, u32 bits) {
  const u32 count = u32(keys.size());
  std::vector<u32> order(count), values(count);
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](u32 i, u32 j) { return keys[i] < keys[j]; });
  Random random(count);
  for (u32& value : values) value = random.bits();
  const std::vector<u32> room(count + 5, 0xabcdu);
  bench.write("keys", keys);
  bench.write("values", values);
  bench.write("more_keys", room);
  bench.write("more_values", room);
  const SortArrays sorted = bench.launcher.sort({"keys", "values", "more_keys", "more_values"}, count, bits);
  const std::vector<u32> got_keys = bench.read(sorted.keys, count), got_values = bench.read(sorted.values, count);
  for (u32 i = 0; i < count; ++i) {
    ASSERT_EQ(got_keys[i], keys[order[i]]) << i << " of " << count << ", bits " << bits;
    ASSERT_EQ(got_values[i], values[order[i]]) << i << " of " << count << ", bits " << bits;
  }
  for (const char* name : {"more_keys", "more_values"}) {
    const std::vector<u32> behind = bench.read(name, room.size());
    EXPECT_TRUE(std::all_of(behind.begin() + count, behind.end(), [](u32 word) { return word == 0xabcdu; }));
  }
}

TEST(RadixSort, EqualsTheStandardLibrarys) {
  for (const auto& [work_group, lanes] : {std::pair{0u, 16u}, {0u, 1u}, {1u, 1u}, {7u, 8u}, {64u, 1u}, {300u, 1u}}) {
    SortBench bench(work_group, lanes);
    for (const u32 count : {0u, 1u, 2u, 255u, 1023u, 1024u, 1025u, 5000u, 60001u}) {
      for (const u32 bits : {1u, 8u, 9u, 10u, 24u, 27u, 32u}) {
        Random random(count + bits);
        std::vector<u32> keys(count);
        for (u32& key : keys) key = random.bits() >> (32 - bits);
        expect_sorted(bench, std::move(keys), bits);
      }
    }
  }
}

// Few different keys: the order of what is equal is the whole answer.
TEST(RadixSort, KeepsTheOrderOfEqualKeys) {
  SortBench bench(0, 16);
  for (const u32 different : {1u, 2u, 3u, 100u}) {
    Random random(different);
    std::vector<u32> keys(20000);
    for (u32& key : keys) key = 0xdeadbeefu * (random.bits() % different);
    expect_sorted(bench, keys, 32);
    std::ranges::sort(keys);
    expect_sorted(bench, keys, 32);
    std::ranges::reverse(keys);
    expect_sorted(bench, keys, 32);
  }
}

// Two words make a key of 64 bits: the low one first, then the high one in the order that there is then.
TEST(RadixSort, TwoSortsMakeA64BitKey) {
  SortBench bench(0, 1);
  Random random(3);
  const u32 count = 10000;
  std::vector<u32> low(count), high(count), order(count), items(count);
  for (u32 i = 0; i < count; ++i) low[i] = random.bits(), high[i] = random.bits() % 500;
  std::iota(order.begin(), order.end(), 0u);
  items = order;
  std::stable_sort(order.begin(), order.end(),
                   [&](u32 i, u32 j) { return std::pair(high[i], low[i]) < std::pair(high[j], low[j]); });
  bench.write("keys", low);
  bench.write("values", items);
  bench.write("more_keys", items);
  bench.write("more_values", items);
  SortArrays arrays = bench.launcher.sort({"keys", "values", "more_keys", "more_values"}, count, 32);
  std::vector<u32> next = bench.read(arrays.values, count);
  for (u32& item : next) item = high[item];
  bench.write(arrays.keys, next);
  arrays = bench.launcher.sort(arrays, count, 9);
  EXPECT_EQ(bench.read(arrays.values, count), order);
}

}  // namespace
}  // namespace lockstep::test::radix_sort_test
