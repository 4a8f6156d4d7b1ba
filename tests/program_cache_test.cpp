// Binaries on disk: what was stored comes back, and nothing else ever does.
#include "host/device/program_cache.hpp"

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>

#include "host/device/program.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::program_cache_test {
namespace {

using Bytes = std::vector<unsigned char>;

// A folder of its own for each test, gone afterwards.
class ProgramCacheTest : public testing::Test {
 protected:
  ProgramCacheTest()
      : folder_(std::filesystem::path(testing::TempDir()) /
                ("lockstep_cache_" + std::to_string(getpid()) + "_" +
                 testing::UnitTest::GetInstance()->current_test_info()->name())) {
    std::filesystem::remove_all(folder_);
  }
  ~ProgramCacheTest() override { std::filesystem::remove_all(folder_); }

  std::size_t files() const {
    std::size_t count = 0;
    for ([[maybe_unused]] const auto& entry : std::filesystem::directory_iterator(folder_)) ++count;
    return count;
  }

  const std::filesystem::path folder_;
  const ProgramCache cache_{folder_};
  const CacheKey key_ = make_cache_key({"source", "options"});
  const Bytes binary_ = {1, 2, 3, 250, 0, 7};
};

TEST_F(ProgramCacheTest, GivesBackWhatWasStored) {
  EXPECT_FALSE(cache_.load(key_));
  cache_.store(key_, binary_);
  EXPECT_EQ(cache_.load(key_), binary_);
  cache_.store(key_, {9});
  EXPECT_EQ(cache_.load(key_), Bytes{9});
  EXPECT_EQ(files(), 1u) << "no temporary file stays";
  EXPECT_FALSE(cache_.load(make_cache_key({"source", "other options"})));
}

TEST_F(ProgramCacheTest, KeysDependOnEveryInput) {
  EXPECT_EQ(make_cache_key({"ab", "c"}), make_cache_key({"ab", "c"}));
  EXPECT_NE(make_cache_key({"ab", "c"}), make_cache_key({"a", "bc"}));
  EXPECT_NE(make_cache_key({"ab", "c"}), make_cache_key({"ab", "c", ""}));
  EXPECT_NE(make_cache_key({"ab", "c"}), make_cache_key({"ab", "d"}));
  EXPECT_EQ(make_cache_key({"ab"}).hex().size(), 32u);
}

TEST_F(ProgramCacheTest, IgnoresATornFileAtEveryLength) {
  cache_.store(key_, binary_);
  const auto whole = std::filesystem::file_size(cache_.file(key_));
  for (std::uintmax_t length = whole; length-- > 0;) {
    std::filesystem::resize_file(cache_.file(key_), length);
    EXPECT_FALSE(cache_.load(key_)) << length;
  }
  cache_.store(key_, binary_);
  EXPECT_EQ(cache_.load(key_), binary_);
}

TEST_F(ProgramCacheTest, IgnoresAFileWithAnyByteChanged) {
  cache_.store(key_, binary_);
  std::fstream file(cache_.file(key_), std::ios::in | std::ios::out | std::ios::binary);
  const auto whole = std::filesystem::file_size(cache_.file(key_));
  for (std::uintmax_t at = 0; at < whole; ++at) {
    const auto flip = [&] {
      file.seekg(static_cast<std::streamoff>(at));
      const char byte = static_cast<char>(file.get() ^ 0x10);
      file.seekp(static_cast<std::streamoff>(at));
      file.put(byte).flush();
    };
    flip();
    EXPECT_FALSE(cache_.load(key_)) << at;
    flip();
  }
  EXPECT_EQ(cache_.load(key_), binary_);
}

TEST_F(ProgramCacheTest, IgnoresTheFileOfAnotherKey) {
  const CacheKey other = make_cache_key({"another"});
  cache_.store(other, binary_);
  std::filesystem::copy_file(cache_.file(other), cache_.file(key_));
  EXPECT_FALSE(cache_.load(key_));
}

TEST_F(ProgramCacheTest, AFolderThatCannotBeWrittenIsNoCache) {
  std::ofstream(folder_) << "a file where the folder should be";
  cache_.store(key_, binary_);
  EXPECT_FALSE(cache_.load(key_));
  const ProgramCache none{std::filesystem::path()};
  none.store(key_, binary_);
  EXPECT_FALSE(none.load(key_));
}

TEST_F(ProgramCacheTest, AProgramFromDiskRunsAsTheOneThatWasBuilt) {
  ::setenv("LOCKSTEP_CACHE", folder_.c_str(), 1);
  ::setenv("POCL_KERNEL_CACHE", "0", 1);  // else it is pocl that keeps programs
  const std::string text =
      "kernel void seven(global uint* out) { out[get_global_id(0)] = 7u * (uint)get_global_id(0); }\n";
  const auto run = [&](bool expected_from_disk) {
    Device device = open_device(test_device());  // a copy, with no programs of its own
    device.programs.clear();
    BuiltProgram& built = build_program(device, text, {});
    EXPECT_EQ(built.on_disk, expected_from_disk);
    std::vector<u32> out(100);
    const cl::CommandQueue queue(device.context, device.handle);
    const cl::Buffer buffer(device.context, CL_MEM_READ_WRITE, out.size() * sizeof(u32));
    cl::Kernel kernel(built.program, "seven");
    kernel.setArg(0, buffer);
    queue.enqueueNDRangeKernel(kernel, cl::NullRange, 100, 10);
    queue.enqueueReadBuffer(buffer, CL_TRUE, 0, out.size() * sizeof(u32), out.data());
    for (u32 i = 0; i < 100; ++i) EXPECT_EQ(out[i], 7 * i);
    save_program(device, built);
    return built.key;
  };
  const CacheKey key = run(false);
  run(true);
  // a binary that the driver refuses is built anew, and replaced
  ProgramCache(folder_).store(key, {1, 2, 3});
  run(false);
  run(true);
  ProgramCache(folder_).store(key, {1, 2, 3});
  ::unsetenv("POCL_KERNEL_CACHE");
  run(false);
  EXPECT_EQ(ProgramCache(folder_).load(key)->size(), 3u) << "pocl keeps its own";
  ::unsetenv("LOCKSTEP_CACHE");
}

}  // namespace
}  // namespace lockstep::program_cache_test
