// The scan of kernels/scan.cl against the standard library's.
#include <gtest/gtest.h>

#include <numeric>

#include "host/device/device_launcher.hpp"
#include "host/device/program.hpp"
#include "tests/stage_harness.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {
namespace {

// A device with the scan kernels alone.
struct ScanBench {
  explicit ScanBench(u32 work_group)
      : device(open_device(test_device())),
        queue(device.context, device.handle),
        sources(KernelSources::embedded()),
        names({"scan.cl"}),
        signatures(sources.signatures(names)),
        memory(device, queue),
        launcher(device, queue, build_program(device, sources.assemble(names), {}).program, signatures, memory,
                 work_group, false) {
    memory.allocate(Buffer::counters, COUNTER_COUNT * sizeof(u32), 0);
    launcher.begin(Stage::begin_step, {});
  }

  void write(std::string_view array, const std::vector<u32>& words) {
    launcher.scratch(array, std::max<std::size_t>(words.size(), 1));
    if (!words.empty())
      queue.enqueueWriteBuffer(memory.find(array)->buffer, CL_TRUE, 0, words.size() * sizeof(u32), words.data());
  }
  std::vector<u32> read(std::string_view array, std::size_t count) {
    std::vector<u32> words(count);
    if (count > 0) queue.enqueueReadBuffer(memory.find(array)->buffer, CL_TRUE, 0, count * sizeof(u32), words.data());
    return words;
  }

  Device& device;
  cl::CommandQueue queue;
  KernelSources sources;
  std::vector<std::string> names;
  std::vector<KernelSignature> signatures;
  DeviceMemory memory;
  DeviceLauncher launcher;
};

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
  for (const u32 work_group : {0u, 1u, 7u, 256u, 300u}) {
    ScanBench bench(work_group);
    for (const u32 count : {0u, 1u, 2u, 255u, 256u, 257u, 4096u, 4097u, 65536u + 3, 1000003u}) {
      std::vector<u32> words = random_words(count + 5);
      bench.write("values", words);
      bench.launcher.scan("values", count);
      ASSERT_EQ(bench.read("values", words.size()), scanned(words, count)) << count << " words, group " << work_group;
    }
  }
}

// The number of words stands in a counter; how many were expected makes no difference.
TEST(Scan, TakesItsLengthFromTheDevice) {
  ScanBench bench(0);
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
}  // namespace lockstep::test
