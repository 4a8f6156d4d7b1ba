// The scan of kernels/scan.cl against the standard library's.
#include <gtest/gtest.h>

#include <numeric>

#include "tests/launcher_bench.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test::scan_test {
namespace {

// A device with the scan kernels alone. With one lane a chunk is a work-group's, with more a work-item's.
LauncherBench scan_bench(u32 work_group, u32 lanes) {
  return {KernelSources::embedded(), "scan.cl", work_group, false, lanes};
}

std::vector<u32> random_words(u32 count) {
  Random random(count + 1);
  std::vector<u32> words(count);
  for (u32& word : words) word = random.bits();  // sums wrap
  return words;
}

// What lies behind the scanned words keeps its value.
std::vector<u32> scanned(std::vector<u32> words, u32 count) {
  std::exclusive_scan(words.begin(), words.begin() + count, words.begin(), 0u);
  return words;
}

TEST(Scan, EqualsTheStandardLibrarys) {
  for (const auto& [work_group, lanes] :
       {std::pair{0u, 1u}, {0u, 16u}, {1u, 1u}, {1u, 8u}, {7u, 1u}, {7u, 8u}, {256u, 1u}, {300u, 1u}}) {
    LauncherBench bench = scan_bench(work_group, lanes);
    for (const u32 count : {0u, 1u, 2u, 255u, 256u, 257u, 4096u, 4097u, 65536u + 3, 1000003u}) {
      std::vector<u32> words = random_words(count + 5);
      bench.write("values", words);
      bench.launcher.scan("values", count);
      ASSERT_EQ(bench.read("values", words.size()), scanned(words, count))
          << count << " words, group " << work_group << ", lanes " << lanes;
    }
  }
}

// The number of words stands in a counter; how many were expected makes no difference.
TEST(Scan, TakesItsLengthFromTheDevice) {
  LauncherBench bench = scan_bench(0, 1);
  for (const u32 known : {0u, 1u, 255u, 300u, 9999u, 99999u}) {
    for (const u32 expected : {0u, 500u, 100000u}) {
      std::vector<u32> counters(COUNTER_COUNT, 0);
      counters[COUNTER_PAIRS] = known;
      bench.queue.enqueueWriteBuffer(bench.memory.find("counters")->buffer, CL_TRUE, 0, COUNTER_COUNT * sizeof(u32),
                                     counters.data());
      const std::vector<u32> words = random_words(10001);
      bench.write("values", words);
      bench.launcher.scan("values", 10000, COUNTER_PAIRS, expected);
      ASSERT_EQ(bench.read("values", words.size()), scanned(words, std::min(known + 1, 10000u)))
          << known << " expected " << expected;
    }
  }
}

}  // namespace
}  // namespace lockstep::test::scan_test
