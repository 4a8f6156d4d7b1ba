// Sensors of force, torque and touch against closed forms, and what they do when bodies, joints and shapes go.
#include "host/scene/sensors.hpp"

#include <cmath>

#include "host/report/report.hpp"
#include "host/scene/read.hpp"
#include "tests/command_line.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::sensors_test {
namespace {

constexpr double g = 9.81;

World world_of(const std::string& text, const std::string& precision = "double") {
  return World(parse_scene(text, "sensors.json"), {.device = "reference", .precision = precision});
}

void expect_near(const SensorReading& reading, const std::vector<double>& expected, double tolerance) {
  ASSERT_EQ(reading.values.size(), expected.size()) << reading.name;
  for (std::size_t i = 0; i < expected.size(); ++i)
    EXPECT_NEAR(reading.values[i], expected[i], tolerance) << reading.name << ", " << i;
}

// A crate of 10 kg, 0.3 m beside the middle of a table, on which a weight of 2 kg lies.
const std::string table = R"({
  "settings": {"dt": 0.01, "solver": "small_steps"},
  "bodies": [
    {"name": "table", "type": "static", "shapes": [{"type": "box", "size": [2, 2, 0.2]}]},
    {"name": "crate", "mass": 10, "position": [0.3, 0, 0.2], "shapes": [{"type": "box", "size": [0.2, 0.2, 0.2]}]},
    {"name": "weight", "mass": 2, "position": [0.3, 0, 0.35], "shapes": [{"type": "box", "size": [0.1, 0.1, 0.1]}]}
  ],
  "sensors": [
    {"name": "scale", "kind": "touch", "body": "table"},
    {"name": "load", "kind": "force", "body": "table"},
    {"name": "tilt", "kind": "torque", "body": "table"},
    {"name": "crate touch", "kind": "touch", "body": "crate"},
    {"name": "crate force", "kind": "force", "body": "crate", "shape": 0},
    {"name": "crate torque", "kind": "torque", "body": "crate"}
  ]})";

// The crate is pressed from above and from below, and what it gives is the weight of both.
TEST(Sensors, ATableIsAScale) {
  for (const char* precision : {"float", "double"}) {
    World world = world_of(table, precision);
    for (const SensorReading& before : world.sensors()) expect_near(before, std::vector(before.values.size(), 0.0), 0);
    world.step(200);
    const double error = 12 * g * 1e-3;
    expect_near(world.sensor("scale"), {12 * g}, error);
    expect_near(world.sensor("load"), {0, 0, -12 * g}, error);
    expect_near(world.sensor("tilt"), {0, 0.3 * 12 * g, 0}, error);
    expect_near(world.sensor("crate touch"), {14 * g}, error);
    expect_near(world.sensor("crate force"), {0, 0, 10 * g}, error);
    expect_near(world.sensor("crate torque"), {0, 0, 0}, error);
    const std::vector<SensorReading> all = world.sensors();
    ASSERT_EQ(all.size(), 6u);
    EXPECT_EQ(all[2].name, "tilt");
    EXPECT_EQ(all[2].kind, SensorKind::torque);
    EXPECT_EQ(all[2].values, world.sensor("tilt").values);
  }
}

TEST(Sensors, WhatSleepsIsStillWeighed) {
  std::string text = table;
  text.replace(text.find("\"dt\""), 0, "\"sleeping\": true, ");
  World world = world_of(text);
  world.step(300);
  ASSERT_TRUE(world.is_asleep(*world.find("crate")));
  expect_near(world.sensor("scale"), {12 * g}, 0.1);
  expect_near(world.sensor("crate touch"), {14 * g}, 0.1);
}

// A beam on three feet, its centre of mass a quarter of its length from two of them. With friction they might brace
// against each other: mechanics does not say whether they do.
TEST(Sensors, AShapeOfACompoundHasItsShare) {
  World world = world_of(R"({
    "settings": {"dt": 0.01, "solver": "small_steps"},
    "materials": [{"name": "ice", "friction": 0}],
    "bodies": [
      {"type": "static", "shapes": [{"type": "plane"}]},
      {"name": "beam", "mass": 8, "inertia": [1, 1, 1], "position": [0, 0, 0.1], "shapes": [
        {"type": "sphere", "radius": 0.1, "offset": [-0.5, -0.2, 0]}, {"type": "sphere", "radius": 0.1, "offset": [-0.5, 0.2, 0]},
        {"type": "sphere", "radius": 0.1, "offset": [1.5, 0, 0]}]}
    ],
    "sensors": [
      {"name": "left", "kind": "touch", "body": "beam", "shape": 0},
      {"name": "right", "kind": "touch", "body": "beam", "shape": 1},
      {"name": "far", "kind": "force", "body": "beam", "shape": 2},
      {"name": "far moment", "kind": "torque", "body": "beam", "shape": 2}
    ]})");
  world.step(300);
  expect_near(world.sensor("left"), {3 * g}, 0.05);
  expect_near(world.sensor("right"), {3 * g}, 0.05);
  expect_near(world.sensor("far"), {0, 0, 2 * g}, 0.05);
  expect_near(world.sensor("far moment"), {0, -1.5 * 2 * g, 0}, 0.1);
}

// ---- joints

std::string cantilever(const std::string& bodies, const std::string& joint, const std::string& more = "") {
  return R"({"settings": {"dt": 0.005, "solver": "small_steps"}, "bodies": [
      {"name": "beam", "mass": 3, "inertia": [0.1, 0.4, 0.4], "position": [0.5, 0, 0])" +
         more + R"(}],
    "joints": [{"name": "root", "bodies": )" +
         bodies + ", " + joint + R"(}],
    "sensors": [{"name": "force", "kind": "force", "joint": "root"}, {"name": "torque", "kind": "torque", "joint": "root"}]})";
}

// m g, and m g l about the root; on the wall the opposite. The axes of a fixed joint are those of the world at load.
TEST(Sensors, ACantileverPullsAtItsRoot) {
  const std::string joint = R"("type": "fixed", "anchor": [0, 0, 0])";
  World beam = world_of(cantilever(R"(["world", "beam"])", joint)),
        wall = world_of(cantilever(R"(["beam", "world"])", joint));
  beam.step(200);
  wall.step(200);
  expect_near(beam.sensor("force"), {0, 0, 3 * g}, 0.01);
  expect_near(beam.sensor("torque"), {0, -3 * g * 0.5, 0}, 0.01);
  expect_near(wall.sensor("force"), {0, 0, -3 * g}, 0.01);
  expect_near(wall.sensor("torque"), {0, 3 * g * 0.5, 0}, 0.01);
}

// The frame goes with the second body: a beam that is fixed to one that rotates by a quarter about y meanwhile.
TEST(Sensors, TheFrameOfAJointGoesWithItsSecondBody) {
  const double quarter = std::acos(-1.0) / 2;
  World world = world_of(R"({"gravity": [0, 0, 0], "settings": {"dt": 0.001, "solver": "small_steps"}, "bodies": [
      {"name": "rotor", "mass": 100, "inertia": [10, 10, 10], "angular_velocity": [0, 2, 0]},
      {"name": "bob", "mass": 1, "inertia": [0.01, 0.01, 0.01], "position": [1, 0, 0], "velocity": [0, 0, -2], "angular_velocity": [0, 2, 0]}],
    "joints": [{"name": "axle", "type": "hinge", "bodies": ["world", "rotor"], "anchor": [0, 0, 0], "axis": [0, 1, 0]},
               {"name": "arm", "type": "fixed", "bodies": ["rotor", "bob"], "anchor": [1, 0, 0]}],
    "sensors": [{"name": "pull", "kind": "force", "joint": "arm"}]})");
  world.step(static_cast<u32>(std::lround(quarter / 2 / 0.001)));
  EXPECT_NEAR(world.pose(*world.find("bob")).position[2], -1, 0.01);
  expect_near(world.sensor("pull"), {-4, 0, 0}, 0.05);  // m w^2 r inwards, wherever that is
}

// z of the joint is its axis, here the world's y, and what drives it counts.
TEST(Sensors, AMotorThatKeepsAnArmUpGivesItsTorque) {
  World world = world_of(cantilever(
      R"(["world", "beam"])",
      R"("type": "hinge", "anchor": [0, 0, 0], "axis": [0, 1, 0], "motor": {"speed": 0, "max_torque": 100})"));
  world.step(200);
  expect_near(world.sensor("force"), {3 * g, 0, 0}, 0.02);  // x of the joint is then the world's z
  expect_near(world.sensor("torque"), {0, 0, -3 * g * 0.5}, 0.02);
}

TEST(Sensors, ASpringIsAScale) {
  World slider =
      world_of(cantilever(R"(["world", "beam"])", R"("type": "slider", "anchor": [0.5, 0, 0], "axis": [0, 0, 1],
                                     "spring": {"stiffness": 2000, "damping": 200})"));
  World distance =
      world_of(cantilever(R"(["world", "beam"])", R"("type": "distance", "anchors": [[0.5, 0, 1], [0.5, 0, 0]],
                                       "spring": {"stiffness": 2000, "damping": 200})"));
  slider.step(2000);
  distance.step(2000);
  EXPECT_NEAR(slider.pose(*slider.find("beam")).position[2], -3 * g / 2000, 1e-5);
  expect_near(slider.sensor("force"), {0, 0, 3 * g}, 0.01);
  expect_near(distance.sensor("force"), {0, 0, 3 * g}, 0.01);
}

// ---- what goes

TEST(Sensors, GoWithWhatTheyMeasure) {
  World world = world_of(table);
  world.step(100);
  const Snapshot before = world.save();
  world.remove(*world.find("table"));
  EXPECT_EQ(refusal([&] { world.sensor("scale"); }), "sensor \"scale\": measured body \"table\", which was removed");
  ASSERT_EQ(world.sensors().size(), 3u);
  EXPECT_EQ(world.sensors()[0].name, "crate touch");
  expect_near(world.sensor("crate touch"), {14 * g}, 1);  // still of the last step
  world.step();
  expect_near(world.sensor("crate touch"), {0}, 3 * g);  // it falls
  world.restore(before);
  expect_near(world.sensor("scale"), {12 * g}, 1);
}

TEST(Sensors, OfAJointGoWithIt) {
  World world = world_of(cantilever(R"(["world", "beam"])", R"("type": "fixed", "anchor": [0, 0, 0])"));
  world.step();
  world.remove(*world.find_joint("root"));
  EXPECT_TRUE(world.sensors().empty());
  EXPECT_EQ(refusal([&] { world.sensor("force"); }), "sensor \"force\": measured joint \"root\", which was removed");
}

TEST(Sensors, KeepTheirShapes) {
  World world = world_of(table);
  BodyDescription crate = world.description(*world.find("crate"));
  crate.shapes.clear();
  EXPECT_EQ(refusal([&] { world.change(*world.find("crate"), crate); }),
            "body \"crate\": must keep the shape that the sensor \"crate force\" measures");
}

TEST(Sensors, AreRefusedInOneLine) {
  World world = world_of(table);
  EXPECT_EQ(refusal([&] { world.sensor("scal"); }), "sensor \"scal\": is not in this world; did you mean \"scale\"?");
  EXPECT_EQ(refusal([&] { World(empty_scene(), in_double()).sensor("a"); }),
            "sensor \"a\": is not in this world; there are none");
  Scene scene = parse_scene(table, "sensors.json");
  scene.sensors[1].body = 7;
  EXPECT_EQ(refusal([&] { World(scene, in_double()); }),
            "sensor \"load\": measures a body that the scene does not have");
}

TEST(Sensors, AskForForcesOfTheStep) {
  EXPECT_TRUE(wants_step_forces(parse_scene(table, "sensors.json")));
  EXPECT_FALSE(wants_step_forces(ground_scene()));
}

// ---- the report

using SensorsOfARun = CommandLine;

TEST_F(SensorsOfARun, AreInItsReportAndItsTable) {
  std::ofstream(file("table.json")) << table;
  const std::string scene = file("table.json").string() + " --device reference --precision double --steps 200";
  const nlohmann::json sensors = report_of(scene)["sensors"];
  ASSERT_EQ(sensors.size(), 6u);
  EXPECT_EQ(sensors["scale"]["kind"], "touch");
  EXPECT_EQ(sensors["scale"]["unit"], "N");
  EXPECT_EQ(sensors["tilt"]["unit"], "N m");
  World world = world_of(table);
  world.step(200);
  for (const SensorReading& reading : world.sensors()) EXPECT_EQ(sensors[reading.name]["values"], reading.values);
  EXPECT_EQ(report_of(scene + " --worlds 2")["sensors"], sensors);
  const Outcome shown = run("run " + scene);
  EXPECT_NE(shown.out.find("scale"), std::string::npos) << shown.out;
  EXPECT_NE(shown.out.find("touch 117.7"), std::string::npos) << shown.out;
  EXPECT_TRUE(report_of("spheres_small --steps 1 --device reference")["sensors"].is_null());
}

}  // namespace
}  // namespace lockstep::sensors_test
