// What errors say of bodies and joints: their names, or handles where they have none, and what the cause is.
#include <fstream>

#include "host/record/recording_reader.hpp"
#include "tests/command_line.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::messages_test {
namespace {

std::string failure_of_step(World& world, u32 steps = 1) {
  try {
    world.step(steps);
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::comparison);
    return error.what();
  }
  return "goes on";
}

// A world in which indices are no handles any more: two bodies and a joint that came before have gone.
struct Changed {
  World world;
  BodyHandle floor, lift;

  Changed(const WorldOptions& options, const std::string& name) : world(ground_scene(), options) {
    const BodyHandle a = world.add(ball_at({5, 0, 2})), b = world.add(ball_at({9, 0, 2}));
    BodyDescription moved = box_at({0, 0, 3});
    moved.name = name;
    moved.kind = BODY_KINEMATIC, moved.mass = 0, moved.inertia = {0, 0, 0};
    lift = world.add(moved);
    world.step();
    world.remove(a);
    world.remove(b);
  }
};

TEST(WorldMessages, AKinematicBodyTooFastIsCalledByItsNameAndSoIsTheSettingThatStopsIt) {
  for (const char* device : {"reference", "auto"}) {
    for (const char* precision : {"float", "double"}) {
      const WorldOptions options = {.device = device, .precision = precision};
      const std::string cause =
          ": was told to move at 1e+06 m/s, above the setting \"speed_limit\" of 1e+05 m/s; give it a lower velocity, "
          "or raise the limit";
      Changed named(options, "lift");
      named.world.set_velocity(named.lift, {{1e6, 0, 0}, {0, 0, 0}});
      EXPECT_EQ(failure_of_step(named.world), "step 1, integrate_positions: body \"lift\"" + cause);
      Changed unnamed(options, "");
      unnamed.world.set_velocity(unnamed.lift, {{1e6, 0, 0}, {0, 0, 0}});
      EXPECT_EQ(failure_of_step(unnamed.world), "step 1, integrate_positions: body with the handle 3" + cause);
    }
  }
}

TEST(WorldMessages, WhatForcesMakeTooFastIsNotCalledInfinite) {
  for (const char* device : {"reference", "auto"}) {
    World fast(empty_scene(), {.device = device, .precision = "double"});
    BodyDescription ball = ball_at({0, 0, 0});
    ball.name = "shot";
    const BodyHandle shot = fast.add(ball);
    const double mass = fast.description(shot).mass;
    fast.apply(shot, {{3e7 * mass, 0, 0}, {0, 0, 0}});  // for 0.01 s
    EXPECT_EQ(failure_of_step(fast),
              "step 0, integrate_velocities: body \"shot\": the forces leave it at 3e+05 m/s, above the setting "
              "\"speed_limit\" of 1e+05 m/s; try a shorter time step or a lower velocity, or raise the limit");
    World infinite(empty_scene(), {.device = device, .precision = "float"});
    make_solid_of_mass(ball, 1e-4);
    infinite.apply(infinite.add(ball), {{3e38, 0, 0}, {0, 0, 0}});
    EXPECT_EQ(failure_of_step(infinite),
              "step 0, integrate_velocities: body \"shot\": the forces make its velocity infinite or not a number; try "
              "a shorter time step");
  }
}

TEST(WorldMessages, JointsThatAnOracleRefusesAreCalledByTheirNames) {
  Scene scene = empty_scene();
  replace_solver(scene.settings, Solver::reduced_nsgs);
  World world(scene, in_double());
  const BodyHandle first = world.add(box_at({0, 0, 0})), second = world.add(box_at({1, 0, 0}));
  JointDescription joint;
  joint.kind = JOINT_BALL;
  world.remove(world.add(joint, first));
  joint.frequency = 3;
  joint.name = "hip";
  world.add(joint, first, second);
  const std::string rule = ": has a \"frequency\": in reduced coordinates joints are rigid; take it away";
  EXPECT_EQ(refusal([&] { world.step(); }), "joint \"hip\"" + rule);
  world.remove(*world.find_joint("hip"));
  joint.name.clear();
  world.add(joint, first, second);
  EXPECT_EQ(refusal([&] { world.step(); }), "joint with the handle 2" + rule);
}

using ProgramMessages = CommandLine;

TEST_F(ProgramMessages, TheProgramAndItsRecordingCallABodyByItsName) {
  std::ofstream(file("fast.json")) << R"({"settings": {"speed_limit": 1, "dt": 0.01}, "bodies": [
    {"name": "anvil", "type": "static"}, {"name": "feather", "mass": 1, "inertia": [1, 1, 1]}]})";
  const std::string scene = file("fast.json").string(), record = file("x.h5").string();
  const std::string line =
      "step 10, integrate_velocities: body \"feather\": the forces leave it at 1.08 m/s, above the setting "
      "\"speed_limit\" of 1 m/s; try a shorter time step or a lower velocity, or raise the limit";
  for (const char* device : {"reference", "auto"}) {
    const Outcome outcome = run("run " + scene + " --quiet --device " + device + " --record " + record);
    EXPECT_EQ(outcome.status, 1);
    EXPECT_EQ(outcome.err, "lockstep: " + line + "\n");
    EXPECT_EQ(RecordingReader(record).outcome(), line);
  }
  EXPECT_EQ(run("check " + scene).err, "lockstep: " + line + "\n");
}

TEST_F(ProgramMessages, OfSeveralWorldsTheWorldIsToldToo) {
  std::ofstream(file("fast.json")) << R"({"settings": {"speed_limit": 1, "dt": 0.01}, "bodies": [
    {"name": "feather", "mass": 1, "inertia": [1, 1, 1]}]})";
  const Outcome outcome = run("run " + file("fast.json").string() + " --quiet --worlds 2 --device reference");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("integrate_velocities: body \"feather\" of world "), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace lockstep::messages_test
