// pocl's cache of kernels, torn in many ways and on full disks: the run goes on, with the same bits, and says so.
#include "host/device/pocl_cache.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <iterator>
#include <set>
#include <vector>

#include "host/scene/read.hpp"
#include "include/lockstep/world.hpp"
#include "tests/command_line.hpp"

namespace lockstep::pocl_cache_test {
namespace {

bool has_pocl() { return std::ranges::any_of(list_devices(), is_pocl); }

class PoclCache : public CommandLine {
 protected:
  void SetUp() override {
    if (!has_pocl()) GTEST_SKIP() << "no pocl here";
  }

  std::string hash_by(const std::string& environment, const std::string& more, std::string& told) const {
    const Outcome outcome =
        run_command(environment + " " LOCKSTEP_PROGRAM " run slide_to_roll --steps 20 --device cpu --report " +
                    file("report.json").string() + " --quiet " + more);
    told = outcome.err;
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(read_file(file("report.json")))["state_hash"];
  }
  std::string cached(std::string& told, const std::string& more = "") const {
    return hash_by("POCL_CACHE_DIR=" + file("cache").string(), more, told);
  }

  std::vector<fs::path> files(const std::string& ending) const {
    std::vector<fs::path> found;
    for (const auto& entry : fs::recursive_directory_iterator(file("cache")))
      if (entry.path().extension() == ending) found.push_back(entry.path());
    return found;
  }
};

TEST_F(PoclCache, TornFilesAreBuiltAgain) {
  std::string told;
  const std::string hash = cached(told);
  EXPECT_EQ(told, "");
  ASSERT_FALSE(files(".so").empty());
  ASSERT_FALSE(files(".bc").empty());
  EXPECT_EQ(cached(told), hash);
  EXPECT_EQ(told, "") << "whole files are left alone";
  for (const std::string ending : {".so", ".bc"}) {
    for (const unsigned percent : {0u, 50u}) {
      for (const fs::path& path : files(ending)) fs::resize_file(path, fs::file_size(path) * percent / 100);
      EXPECT_EQ(cached(told), hash) << percent << " % of each " << ending;
      EXPECT_NE(told.find("had torn files"), std::string::npos) << told;
      EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1) << told;
      EXPECT_EQ(cached(told), hash);
      EXPECT_EQ(told, "");
    }
  }
}

TEST_F(PoclCache, EveryLengthOfAFileIsToldFromTheWhole) {
  std::string told;
  cached(told);
  for (const std::string ending : {".so", ".bc"}) {
    const auto is_whole = ending == ".so" ? is_whole_library : is_whole_bitcode;
    const fs::path path = files(ending).front(), copy = file("copy" + ending);
    EXPECT_TRUE(is_whole(path));
    fs::copy_file(path, copy);
    const std::uintmax_t size = fs::file_size(path);
    for (std::uintmax_t length = size; length-- > 0; length -= length > 300 + size / 97 ? size / 97 : 0) {
      fs::resize_file(copy, length);
      EXPECT_FALSE(is_whole(copy)) << length << " of " << size << ' ' << ending;
    }
  }
}

TEST_F(PoclCache, WhereThereIsNoRoomItIsElsewhere) {
  std::string told;
  const std::string hash = cached(told);
  // a folder that cannot be one; HOME that may not be written is the same
  std::ofstream(file("in_the_way")) << "a file";
  EXPECT_EQ(hash_by("POCL_CACHE_DIR=" + file("in_the_way/cache").string(), "", told), hash);
  EXPECT_NE(told.find("set POCL_CACHE_DIR"), std::string::npos) << told;
  EXPECT_EQ(std::count(told.begin(), told.end(), '\n'), 1) << told;
}

// Needs a file system of its own, which not every container gives.
TEST_F(PoclCache, OnAFullDiskItIsElsewhere) {
  std::string told;
  const std::string hash = cached(told);
  const fs::path disk = file("disk");
  fs::create_directory(disk);
  const std::string mounted = "unshare -rm sh -c 'mount -t tmpfs -o size=2m none " + disk.string();
  if (run_command(mounted + "'").status != 0) GTEST_SKIP() << "no file system of its own to be had here";
  const Outcome outcome =
      run_command(mounted + " && POCL_CACHE_DIR=" + disk.string() +
                  "/cache " LOCKSTEP_PROGRAM " run slide_to_roll --steps 20 --device cpu --quiet --report " +
                  file("report.json").string() + "'");
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_NE(outcome.err.find("the disk is full or may not be written"), std::string::npos) << outcome.err;
  EXPECT_EQ(nlohmann::json::parse(read_file(file("report.json")))["state_hash"], hash);
}

TEST_F(PoclCache, LargeWorkGroupsHaveTheSameBits) {
  std::string told;
  const std::string hash = cached(told);
  for (const char* size : {"1", "1024", "4096", "65536", "4294967295"})
    EXPECT_EQ(cached(told, std::string("--plan launches --work-group ") + size), hash) << size;
}

std::size_t open_files() {
  return static_cast<std::size_t>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

// Scenes of unlike features, each of which has kernels of its own.
Scene scene_of(unsigned kind) {
  const std::string shapes[] = {R"({"type": "sphere", "radius": 0.5})", R"({"type": "box", "size": [1, 1, 1]})",
                                R"({"type": "capsule", "radius": 0.4, "length": 0.5})",
                                R"({"type": "cylinder", "radius": 0.4, "length": 0.8})"};
  const std::string settings[] = {"", R"("solver": "small_steps")", R"("events": true)", R"("broad_phase": "grid")",
                                  R"("solver": "jacobi")"};
  const std::string text =
      R"({"settings": {)" + settings[kind / 4 % 5] +
      R"(}, "bodies": [{"type": "static", "shapes": [{"type": "plane"}]}, {"mass": 1, "position": [0, 0, 0.45], "shapes": [)" +
      shapes[kind % 4] + "]}]}";
  return parse_scene(text, "scene.json");
}

constexpr unsigned kinds = 16;  // of scenes, together of 141 kernels

// pocl unloads the libraries of kernels when there are more than 128, and would load them again for each launch.
TEST_F(PoclCache, ManyWorldsLeaveNothingOpenAndKeepTheirKernels) {
  const auto make = [](unsigned kind) {
    WorldOptions options;
    options.device = "cpu";
    options.quiet = true;
    World world(scene_of(kind), options);
    world.step(2);
  };
  for (unsigned kind = 0; kind < kinds; ++kind) make(kind);
  const std::size_t files = open_files();
  std::set<std::string> loaded;
  const auto kernels_loaded = [] {
    std::ifstream maps("/proc/self/maps");
    std::set<std::string> found;
    for (std::string line; std::getline(maps, line);)
      if (line.ends_with(".so") && line.find(pocl_cache_folder().string()) != std::string::npos)
        found.insert(line.substr(line.find('/')));
    return found;
  };
  loaded = kernels_loaded();
  EXPECT_GT(loaded.size(), 128u) << "too few for the test to be of anything";
  for (unsigned world = 0; world < 100; ++world) make(world % kinds);
  EXPECT_EQ(kernels_loaded(), loaded);
  EXPECT_LE(open_files(), files);
}

}  // namespace
}  // namespace lockstep::pocl_cache_test
