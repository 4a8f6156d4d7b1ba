// The list of devices, the choice among them, and buffers on a device.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <functional>

#include "tests/stage_harness.hpp"

namespace lockstep::device_test {
namespace {

Failure failure_of(const std::function<void()>& call) {
  try {
    call();
  } catch (const Error& error) {
    return error.failure();
  }
  ADD_FAILURE() << "nothing was thrown";
  return Failure::comparison;
}

TEST(Devices, AreNumberedInOrderAndDescribed) {
  const auto& devices = list_devices();
  ASSERT_FALSE(devices.empty()) << "these tests need an OpenCL device (Debian: pocl-opencl-icd)";
  for (u32 i = 0; i < devices.size(); ++i) {
    EXPECT_EQ(devices[i].index, i);
    EXPECT_FALSE(devices[i].name.empty());
    EXPECT_FALSE(devices[i].driver_version.empty());
    EXPECT_GT(devices[i].compute_units, 0u);
    EXPECT_EQ(select_device(std::to_string(i))->name, devices[i].name);
  }
}

TEST(Devices, AreChosenByWord) {
  EXPECT_FALSE(select_device("reference"));
  EXPECT_TRUE(select_device("auto"));
  for (const DeviceInfo& device : list_devices()) {
    if (device.type == DeviceType::cpu) {
      EXPECT_EQ(select_device("cpu")->type, DeviceType::cpu);
    }
    if (device.type == DeviceType::gpu) {
      EXPECT_EQ(select_device("auto")->type, DeviceType::gpu);
    }
  }
  EXPECT_EQ(failure_of([] { select_device("tpu"); }), Failure::input);
  EXPECT_EQ(failure_of([] { select_device("1x"); }), Failure::input);
  EXPECT_EQ(failure_of([] { select_device("99"); }), Failure::input);
}

// Drivers are loaded once in a process: a process of its own, in which this test runs again and finds none.
TEST(Devices, NoOpenClAtAllIsAnEmptyList) {
  const std::string nowhere = "/nonexistent/";
  const char* vendors = std::getenv("OCL_ICD_VENDORS");
  if (vendors && vendors == nowhere) {
    EXPECT_TRUE(list_devices().empty());
    EXPECT_FALSE(select_device("auto"));
    EXPECT_EQ(failure_of([] { select_device("cpu"); }), Failure::input);
    return;
  }
  const std::string self = std::filesystem::read_symlink("/proc/self/exe");
  const std::string command = "env -u LD_PRELOAD OCL_ICD_VENDORS=" + nowhere + " '" + self +
                              "' --gtest_filter=Devices.NoOpenClAtAllIsAnEmptyList > /dev/null";
  EXPECT_EQ(std::system(command.c_str()), 0);
}

InitialState<float> five_bodies() {
  InitialState<float> state;
  state.sizes.worlds = 1;
  state.sizes.bodies = 5;
  state.sizes.pairs = state.sizes.contacts = state.sizes.blocks = state.sizes.rows = 16;
  state.features = with(static_cast<Features>(Feature::contacts), Feature::time_stepping);
  resize(state.buffers, state.sizes, state.features);
  for (u32 i = 0; i < 5; ++i) state.buffers.positions[i] = {float(i), 1, 2, 3};
  for (u32 i = 0; i < 16; ++i) state.buffers.cached_keys[i] = {i, i, i, i};
  state.buffers.cached_count = {10};
  return state;
}

TEST(DeviceBackend, GivesBackWhatItWasGiven) {
  const InitialState<float> state = five_bodies();
  DeviceBackend<float> backend(state, test_device());
  const Buffer wanted[] = {Buffer::positions, Buffer::cached_count};
  const Buffers<float>& read = backend.download(wanted);
  for (u32 i = 0; i < 5; ++i) EXPECT_EQ(read.positions[i].x, float(i));
  EXPECT_EQ(read.cached_count[0], 10u);

  Buffers<float> changed = state.buffers;
  changed.positions[4].y = 42;
  backend.upload(Buffer::positions, changed);
  EXPECT_EQ(backend.download(wanted).positions[4].y, 42);
}

TEST(DeviceBackend, KeepsStateWhenListsGrow) {
  DeviceBackend<float> backend(five_bodies(), test_device());
  Sizes larger = backend.sizes();
  larger.contacts = 4000;
  backend.grow(larger);
  EXPECT_EQ(backend.sizes(), larger);
  const Buffer wanted[] = {Buffer::cached_keys, Buffer::positions};
  const Buffers<float>& read = backend.download(wanted);
  EXPECT_EQ(read.cached_keys.size(), 4000u);
  for (u32 i = 0; i < 10; ++i) EXPECT_EQ(read.cached_keys[i].shape_a, i);
  EXPECT_EQ(read.positions[4].x, 4);
}

TEST(DeviceBackend, FewBodiesTakeTheThreadThatCalls) {
  const DeviceInfo device = test_device();
  const auto name = [&](u32 bodies, u32 threads, u32 hulls = 0) {
    InitialState<float> state = five_bodies();
    state.sizes.bodies = bodies;
    state.sizes.shapes = hulls;
    if (hulls > 0) state.features = with(state.features, Feature::hulls);
    DeviceOptions options;
    options.threads = threads;
    options.only = {Stage::begin_step};
    return DeviceBackend<float>(state, device, options).name();
  };
  EXPECT_EQ(name(513, 0), device.name);
  EXPECT_EQ(name(5, 2), device.name);
  EXPECT_EQ(name(5, 0) != device.name, runs_in_caller(device));
  if (runs_in_caller(device)) {
    EXPECT_EQ(name(512, 0), name(513, 1));
    EXPECT_EQ(name(128, 0, 128), name(5, 0));
    EXPECT_EQ(name(129, 0, 129), device.name);  // two hulls take longer than a thread to wake
  }
  const bool is_pocl_3 = device.platform == "Portable Computing Language" && device.driver_version.starts_with("3.");
  if (is_pocl_3 && device.type == DeviceType::cpu && !std::getenv("POCL_DEVICES")) {
    EXPECT_TRUE(runs_in_caller(device));
  }
}

TEST(DeviceBackend, RefusesLanesThatThereAreNot) {
  DeviceOptions options;
  options.lanes = 3;
  EXPECT_EQ(failure_of([&] { DeviceBackend<float>(five_bodies(), test_device(), options); }), Failure::input);
}

}  // namespace
}  // namespace lockstep::device_test
