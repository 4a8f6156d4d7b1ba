// What acts on bodies or the mass of one changes: the next step starts cold and gets the sweeps of a first one, so
// that impulses which balanced something else do not shake what rests.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "host/record/recording_tables.hpp"
#include "host/record/replay.hpp"
#include "include/lockstep/world.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::cold_start_test {
namespace {

// Cubes of 1 m and 1 kg that stand on each other, by all defaults.
struct Stack {
  Stack(int cubes, const char* precision) : world(ground(), {.device = "reference", .precision = precision}) {
    for (int i = 0; i < cubes; ++i) all.push_back(world.add(cube(1, 0.5 + i)));
    world.step(120);
  }

  static Scene ground() {
    Scene scene;
    scene.name = scene.source = "stack";
    BodyDescription floor;
    floor.kind = BODY_STATIC;
    floor.shapes.push_back({.kind = SHAPE_PLANE});
    scene.bodies.push_back(floor);
    return scene;
  }

  static BodyDescription cube(double mass, double height) {
    BodyDescription body;
    body.position = {0, 0, height};
    body.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.5, 0.5, 0.5}});
    make_solid_of_mass(body, mass);
    return body;
  }

  // How far the top is from where it was, m, after so many steps.
  double moved_after(int steps) {
    const Vector3 before = world.pose(all.back()).position;
    world.step(steps);
    return exact::length(exact::subtract(world.pose(all.back()).position, before));
  }

  World world;
  std::vector<BodyHandle> all;
};

class ColdStart : public testing::TestWithParam<const char*> {};
INSTANTIATE_TEST_SUITE_P(, ColdStart, testing::Values("float", "double"), [](const auto& p) { return p.param; });

TEST_P(ColdStart, AStackIsStillWhereGravityChanges) {
  for (const int cubes : {4, 7}) {
    Stack heavier(cubes, GetParam()), lighter(cubes, GetParam());
    heavier.world.set_gravity({0, 0, -15});
    lighter.world.set_gravity({0, 0, -5});
    EXPECT_LT(heavier.moved_after(240), 2e-4) << cubes;
    EXPECT_LT(lighter.moved_after(240), 2e-4) << cubes;
  }
}

TEST_P(ColdStart, AStackIsStillWhereItsTopGetsHeavier) {
  Stack stack(7, GetParam());
  BodyDescription heavy = Stack::cube(3, 6.5);
  heavy.position = stack.world.pose(stack.all.back()).position;
  heavy.orientation = stack.world.pose(stack.all.back()).orientation;
  stack.world.change(stack.all.back(), heavy);
  EXPECT_LT(stack.moved_after(240), 1e-3);
}

class ColdStartRecording : public testing::Test {
 protected:
  u32 cold_starts() const {
    const std::vector<InputRow> inputs = RecordingReader(path).inputs();
    return static_cast<u32>(std::ranges::count(inputs, InputKind::cold_start, &InputRow::kind));
  }

  TemporaryFolder folder;
  const std::string path = folder.file("run.h5");
};

// What changes before each step is a scene that runs: it costs no more than it did.
TEST_F(ColdStartRecording, IsOneOfALoadThatChangesWithEachStep) {
  {
    Stack stack(2, "float");
    const double start = stack.world.time() + 0.1;
    const auto push = [=](double t) -> Wrench { return {.force = {t < start ? 0 : std::sin(10 * (t - start)), 0, 0}}; };
    stack.world.set_load(stack.all[1], push);
    stack.world.step();
    stack.world.record(path);
    stack.world.step(30);
  }
  EXPECT_EQ(cold_starts(), 1u);
  replay<float>(RecordingReader(path), {}, [](u32) {});
}

TEST_F(ColdStartRecording, IsReplayedAlsoBehindARestore) {
  std::uint64_t hashes[2];
  {
    Stack stack(4, "double");
    stack.world.record(path);
    const Snapshot before = stack.world.save();
    for (std::uint64_t& hash : hashes) {
      stack.world.set_gravity({0, 0, -12});
      stack.world.step(5);
      hash = stack.world.state_hash();
      if (&hash == hashes) stack.world.restore(before);
    }
  }
  EXPECT_EQ(hashes[0], hashes[1]);
  EXPECT_EQ(cold_starts(), 2u);
  replay<double>(RecordingReader(path), {}, [](u32) {});
}

}  // namespace
}  // namespace lockstep::cold_start_test
