// What the reader makes of good scenes, and the exact line it refuses each kind of bad one with.
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "host/error.hpp"
#include "host/scene/read.hpp"

namespace lockstep::scene_reader_test {
namespace {

const std::string source_dir = LOCKSTEP_SOURCE_DIR;

std::string slurp(const std::string& path) {
  std::ifstream file(path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// The line with which reading fails, or a text that no error has.
std::string refusal(const std::string& text, const std::string& path = "bad.json") {
  try {
    parse_scene(text, path);
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::input);
    return error.what();
  }
  return "accepted";
}

Scene with_bodies(const std::string& bodies, const std::string& more = "") {
  return parse_scene("{\"bodies\": [" + bodies + "]" + more + "}", "good.json");
}

void expect_near(const Vector3& actual, const Vector3& expected, double tolerance = 1e-15) {
  for (unsigned i = 0; i < 3; ++i) EXPECT_NEAR(actual[i], expected[i], tolerance) << "component " << i;
}

// ---- good scenes ---------------------------------------------------------------------------------------------------

TEST(SceneReader, DefaultsAreThoseOfTheDescription) {
  const Scene scene = with_bodies(R"({"type": "static"})");
  EXPECT_EQ(scene.name, "good");
  EXPECT_EQ(scene.source, "good.json");
  EXPECT_EQ(scene.gravity, (Vector3{0, 0, -9.81}));
  EXPECT_EQ(scene.settings.dt, 1.0 / 60);
  EXPECT_EQ(scene.settings.integrator, Integrator::semi_implicit_euler);
  EXPECT_EQ(scene.settings.gyroscopic, Gyroscopic::midpoint);
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].friction, 0.5);
  EXPECT_EQ(scene.materials[0].restitution, 0);
}

TEST(SceneReader, EverySettingIsRead) {
  const Scene scene = with_bodies(R"({"type": "static"})", R"(, "gravity": [1, 2, 3], "settings": {
      "dt": 0.125, "steps": 7, "substeps": 3, "iterations": 4, "relaxations": 6, "tolerance": 0.03125, "integrator": "trapezoidal", "gyroscopic": "midpoint",
      "restitution_threshold": 0.5, "correction": 0.25, "correction_limit": 2,
      "joint_solver": "direct", "stabilization": "velocities", "position_sweeps": 5, "cell_size": 1.5, "slop": 0.001, "margin": 0.01,
      "speed_limit": 50, "broad_phase": "bvh", "precision": "double"})");
  const Settings& s = scene.settings;
  EXPECT_EQ(scene.gravity, (Vector3{1, 2, 3}));
  EXPECT_EQ(s.dt, 0.125);
  EXPECT_EQ(s.steps, 7u);
  EXPECT_EQ(s.substeps, 3u);
  EXPECT_EQ(s.iterations, 4u);
  EXPECT_EQ(s.relaxations, 6u);
  EXPECT_EQ(s.tolerance, 0.03125);
  EXPECT_EQ(s.integrator, Integrator::trapezoidal);
  EXPECT_EQ(s.gyroscopic, Gyroscopic::midpoint);
  EXPECT_EQ(s.restitution_threshold, 0.5);
  EXPECT_EQ(s.correction, 0.25);
  EXPECT_EQ(s.correction_limit, 2);
  EXPECT_EQ(s.joint_solver, JointSolver::direct);
  EXPECT_EQ(s.stabilization, Stabilization::velocities);
  EXPECT_EQ(s.position_sweeps, 5u);
  EXPECT_EQ(s.cell_size, 1.5);
  EXPECT_EQ(s.slop, 0.001);
  EXPECT_EQ(s.margin, 0.01);
  EXPECT_EQ(s.speed_limit, 50);
  EXPECT_EQ(s.broad_phase, BroadPhase::bvh);
  EXPECT_EQ(s.precision, "double");
}

TEST(SceneReader, SleepingIsASwitchOrNumbers) {
  const auto sleeping = [](const std::string& value) {
    return with_bodies(R"({"type": "static"})", R"(, "settings": {"sleeping": )" + value + "}").settings.sleeping;
  };
  EXPECT_FALSE(sleeping("false"));
  ASSERT_TRUE(sleeping("true"));
  EXPECT_EQ(sleeping("true")->after, 0.5);
  EXPECT_EQ(sleeping("true")->speed, std::nullopt);
  EXPECT_EQ(sleeping("true")->angular_speed, 0.8);
  const auto told = sleeping(R"({"after": 2, "speed": 0.125, "angular_speed": 0})");
  EXPECT_EQ(told->after, 2);
  EXPECT_EQ(told->speed, 0.125);
  EXPECT_EQ(told->angular_speed, 0);
}

TEST(SceneReader, MassOfASphereFollowsFromItsDensity) {
  const Scene scene = with_bodies(R"({"density": 1000, "shapes": [{"type": "sphere", "radius": 0.1}]},
                     {"mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]},
                     {"mass": 2, "inertia": [1, 1, 1], "shapes": [{"type": "sphere", "radius": 0.5}]})");
  EXPECT_DOUBLE_EQ(scene.bodies[0].mass, 4.18879020478639098);
  EXPECT_DOUBLE_EQ(scene.bodies[0].inertia[2], 0.4 * 4.18879020478639098 * 0.01);
  EXPECT_EQ(scene.bodies[1].inertia, (Vector3{0.2, 0.2, 0.2}));
  EXPECT_EQ(scene.bodies[2].inertia, (Vector3{1, 1, 1}));
}

TEST(SceneReader, OrientationsInEveryForm) {
  const char* quarter_rotations_about_z[] = {
      R"({"type": "static", "orientation": [0, 0, 0.70710678118654757, 0.70710678118654757]})",
      R"({"type": "static", "orientation": {"axis": [0, 0, 2], "angle_deg": 90}})",
      R"({"type": "static", "orientation": {"axis": [0, 0, -1], "angle": -1.5707963267948966}})",
      R"({"type": "static", "orientation": {"euler_deg": [0, 0, 450]}})",
  };
  for (const char* body : quarter_rotations_about_z) {
    const Quaternion q = with_bodies(body).bodies[0].orientation;
    expect_near(exact::rotate(q, {1, 0, 0}), {0, 1, 0});
    EXPECT_NEAR(exact::length(q), 1, 1e-15);
  }
}

TEST(SceneReader, AQuaternionOfFewDigitsIsMadeUnit) {
  const Quaternion q =
      with_bodies(R"({"type": "static", "orientation": [0, 0, 0.7071068, 0.7071068]})").bodies[0].orientation;
  EXPECT_NEAR(exact::length(q), 1, 1e-15);
}

TEST(SceneReader, BodyRatesAreRotatedToTheWorld) {
  const Scene scene = with_bodies(
      R"({"mass": 1, "inertia": [1, 1, 1], "orientation": {"axis": [0, 1, 0], "angle_deg": 90},
          "angular_velocity_body": [0, 0, 3]})");
  expect_near(scene.bodies[0].angular_velocity, {3, 0, 0});
}

TEST(SceneReader, APivotPutsTheCenterOfMassAtItsOffset) {
  const Scene scene = with_bodies(
      R"({"mass": 1, "inertia": [1, 1, 1], "pivot": [1, 2, 3], "com_offset": [0, 0, 0.5],
          "orientation": {"axis": [0, 1, 0], "angle_deg": 90}})");
  EXPECT_TRUE(scene.bodies[0].pivoted);
  expect_near(scene.bodies[0].position, {1.5, 2, 3});
}

TEST(SceneReader, PlanesFaceTheirNormal) {
  const Scene scene = with_bodies(
      R"({"type": "static", "shapes": [{"type": "plane", "normal": [0, -3, 0]},
                                       {"type": "plane", "rotation": {"axis": [0, 1, 0], "angle_deg": 30}}]})");
  EXPECT_EQ(exact::rotate(scene.bodies[0].shapes[0].rotation, {0, 0, 1}), (Vector3{0, -1, 0}));
  expect_near(exact::rotate(scene.bodies[0].shapes[1].rotation, {0, 0, 1}), {0.5, 0, std::sqrt(0.75)});
}

TEST(SceneReader, CategoriesAreBitsInOrderOfAppearance) {
  const Scene scene = with_bodies(
      R"({"type": "static", "shapes": [
          {"type": "plane"},
          {"type": "sphere", "radius": 1, "category": "balls", "collides_with": ["default", "walls"]},
          {"type": "sphere", "radius": 1, "category": "walls", "collides_with": []}]})");
  const auto& shapes = scene.bodies[0].shapes;
  EXPECT_EQ(shapes[0].category, 1u);
  EXPECT_EQ(shapes[0].mask, 0xffffffffu);
  EXPECT_EQ(shapes[1].category, 2u);
  EXPECT_EQ(shapes[1].mask, 1u | 4u);
  EXPECT_EQ(shapes[2].category, 4u);
  EXPECT_EQ(shapes[2].mask, 0u);
}

TEST(SceneReader, MaterialsAreFoundByName) {
  const Scene scene =
      with_bodies(R"({"type": "static", "shapes": [{"type": "plane", "material": "ice"}]})",
                  R"(, "materials": [{"name": "wood"}, {"name": "ice", "friction": 0.02, "restitution": 0.1}],
           "material_pairs": [{"materials": ["ice", "wood"], "friction": 0.03, "restitution": 0.2}])");
  EXPECT_EQ(scene.bodies[0].shapes[0].material, 1u);
  EXPECT_EQ(scene.materials[1].friction, 0.02);
  ASSERT_EQ(scene.material_pairs.size(), 1u);
  EXPECT_EQ(scene.material_pairs[0].material_a, 0u);
  EXPECT_EQ(scene.material_pairs[0].material_b, 1u);
  EXPECT_EQ(scene.material_pairs[0].friction, 0.03);
}

// ---- generators ----------------------------------------------------------------------------------------------------

TEST(SceneReader, AGridRunsFastestAlongX) {
  const Scene scene = with_bodies(
      R"({"generator": "grid", "counts": [2, 3, 2], "spacing": [1, 10, 100], "origin": [0.5, 0, 0],
          "centered": [false, true, false], "bodies": [{"name": "b", "type": "static", "position": [0, 0, 7]}]})");
  ASSERT_EQ(scene.bodies.size(), 12u);
  EXPECT_EQ(scene.bodies[0].position, (Vector3{0.5, -10, 7}));
  EXPECT_EQ(scene.bodies[1].position, (Vector3{1.5, -10, 7}));
  EXPECT_EQ(scene.bodies[2].position, (Vector3{0.5, 0, 7}));
  EXPECT_EQ(scene.bodies[11].position, (Vector3{1.5, 10, 107}));
  EXPECT_EQ(scene.bodies[11].name, "b_11");
}

TEST(SceneReader, LinesNestAndNumberTheirCopies) {
  const Scene scene = with_bodies(
      R"({"type": "static"},
         {"generator": "line", "count": 2, "step": [10, 0, 0], "bodies": [
            {"name": "post", "type": "static"},
            {"generator": "line", "count": 3, "step": [0, 1, 0], "origin": [0, 5, 0],
             "bodies": [{"name": "bead", "type": "static"}]}]})");
  ASSERT_EQ(scene.bodies.size(), 9u);
  EXPECT_EQ(scene.bodies[1].name, "post_0");
  EXPECT_EQ(scene.bodies[4].name, "bead_2_0");
  EXPECT_EQ(scene.bodies[8].name, "bead_2_1");
  EXPECT_EQ(scene.bodies[8].position, (Vector3{10, 7, 0}));
}

TEST(SceneReader, APyramidIsCenteredRowByRow) {
  const Scene scene = with_bodies(
      R"({"generator": "pyramid", "rows": 3, "spacing": [1, 0, 2], "origin": [10, 0, 0.5],
          "bodies": [{"name": "b", "type": "static"}]})");
  ASSERT_EQ(scene.bodies.size(), 6u);
  EXPECT_EQ(scene.bodies[0].position, (Vector3{9, 0, 0.5}));
  EXPECT_EQ(scene.bodies[3].position, (Vector3{9.5, 0, 2.5}));
  EXPECT_EQ(scene.bodies[5].position, (Vector3{10, 0, 4.5}));
  EXPECT_EQ(scene.bodies[5].name, "b_5");
}

TEST(SceneReader, AnArcRotatesItsCopies) {
  const Scene scene = with_bodies(
      R"({"generator": "arc", "count": 3, "axis": [0, 3, 0], "start_deg": -90, "step_deg": 90, "origin": [0, 0, 5],
          "bodies": [{"name": "b", "mass": 1, "inertia": [1, 1, 1], "position": [0, 1, 2], "velocity": [1, 0, 0],
                      "angular_velocity": [0, 0, 3], "orientation": {"axis": [0, 1, 0], "angle_deg": 90}}]})");
  ASSERT_EQ(scene.bodies.size(), 3u);
  expect_near(scene.bodies[0].position, {-2, 1, 5});
  EXPECT_EQ(scene.bodies[1].position, (Vector3{0, 1, 7}));
  expect_near(scene.bodies[2].position, {2, 1, 5});
  expect_near(scene.bodies[2].velocity, {0, 0, -1});
  expect_near(scene.bodies[2].angular_velocity, {3, 0, 0});
  expect_near(exact::rotate(scene.bodies[0].orientation, {1, 0, 0}), {1, 0, 0});
  expect_near(exact::rotate(scene.bodies[1].orientation, {1, 0, 0}), {0, 0, -1});
  EXPECT_EQ(scene.bodies[2].name, "b_2");
}

// Joints within a copy, to the next one, and to what is outside; in nested lines each joint belongs to its own line.
TEST(SceneReader, LinesMakeChains) {
  const Scene scene = with_bodies(
      R"({"name": "post", "type": "static"},
         {"generator": "line", "count": 2, "step": [0, 10, 0], "bodies": [
            {"generator": "line", "count": 3, "step": [1, 0, 0], "origin": [0.5, 0, 0],
             "bodies": [{"name": "link", "mass": 1, "inertia": [1, 1, 1]}],
             "joints": [{"type": "ball", "bodies": ["link", "link+1"], "anchor": [0.5, 0, 0]}]}],
          "joints": [{"type": "hinge", "bodies": ["post", "link_0"], "anchor": [0, 0, 0], "axis": [0, 0, 2],
                      "limits_deg": [-90, 180], "motor": {"speed_deg": 180, "max_torque": 3}}]})");
  ASSERT_EQ(scene.joints.size(), 6u);
  // copy 0: two links of the chain, then its hinge
  EXPECT_EQ(scene.joints[0].body_a, 1u);
  EXPECT_EQ(scene.joints[0].body_b, 2u);
  EXPECT_EQ(scene.joints[0].anchor_a, (Vector3{1, 0, 0}));
  EXPECT_EQ(scene.joints[1].anchor_b, (Vector3{2, 0, 0}));
  EXPECT_EQ(scene.joints[2].kind, JOINT_HINGE);
  EXPECT_EQ(scene.joints[2].body_a, 0u);
  EXPECT_EQ(scene.joints[2].body_b, 1u);
  EXPECT_NEAR(scene.joints[2].high, 3.141592653589793, 1e-15);
  EXPECT_NEAR(scene.joints[2].motor_speed, 3.141592653589793, 1e-15);
  EXPECT_EQ(scene.joints[5].body_b, 4u);
  EXPECT_EQ(scene.joints[4].body_a, 5u);
  EXPECT_EQ(scene.joints[4].anchor_a, (Vector3{2, 10, 0}));
}

TEST(SceneReader, JitterIsDrawnInTheOrderAskedForFromASequenceOfEachCopy) {
  const Scene scene = with_bodies(
      R"({"generator": "line", "count": 4, "step": [1, 0, 0],
          "jitter": {"generator": "lcg_by_index", "seed": 5, "amplitude": [0.1, 0.2, 0.3], "order": "zxy"},
          "bodies": [{"type": "static"}]})");
  exact::LcgByIndex random(5 + 3);
  const double z = 0.3 * random.next_symmetric(), x = 0.1 * random.next_symmetric(), y = 0.2 * random.next_symmetric();
  EXPECT_EQ(scene.bodies[3].position, (Vector3{3 + x, y, z}));
}

// ---- bad scenes ----------------------------------------------------------------------------------------------------

// Each file of tests/bad_scenes/*.json is an array of {"scene", "error"}; a scene is JSON, or a text that is not, in
// that folder. The name of the folder is left out of what is said.
TEST(SceneReader, BadScenesAreRefusedWithOneLine) {
  std::size_t cases = 0;
  const std::string folder = source_dir + "/tests/bad_scenes/";
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().extension() != ".json") continue;
    const nlohmann::json table = nlohmann::json::parse(slurp(entry.path()));
    for (const auto& row : table) {
      const nlohmann::json& scene = row.at("scene");
      const std::string text = scene.is_string() ? scene.get<std::string>() : scene.dump();
      std::string line = refusal(text, folder + "bad.json");
      for (std::size_t at; (at = line.find(folder)) != std::string::npos;) line.erase(at, folder.size());
      const std::string expected = "bad.json: " + row.at("error").get<std::string>();
      // after line and column come the words of the JSON library, which differ between its versions
      const bool not_json = expected.find(": not JSON: ") != std::string::npos;
      EXPECT_EQ(not_json ? line.substr(0, expected.size()) : line, expected) << text;
      EXPECT_EQ(line.find('\n'), std::string::npos) << line;
      ++cases;
    }
  }
  EXPECT_GE(cases, 100u);
}

TEST(SceneReader, FilesThatCannotBeReadAreNamed) {
  const auto refusal_of_path = [](const std::string& path) -> std::string {
    try {
      read_scene(path);
    } catch (const Error& error) {
      EXPECT_EQ(error.failure(), Failure::input);
      return error.what();
    }
    return "accepted";
  };
  EXPECT_EQ(refusal_of_path("zeno_bal"),
            "zeno_bal: no such file, and no built-in scene has this name; did you mean \"zeno_ball\"?");
  EXPECT_EQ(refusal_of_path("nowhere/free_flight.json"),
            "nowhere/free_flight.json: no such file; 'lockstep scenes' lists the built-in ones");
  EXPECT_EQ(refusal_of_path(source_dir), source_dir + ": is a directory, must be a JSON file");
  EXPECT_EQ(refusal_of_path(""), "\"\": no such file; 'lockstep scenes' lists the built-in ones");
}

TEST(SceneReader, TenMegabytesOfBracketsAreRefused) {
  const std::string brackets(10u << 20, '[');
  EXPECT_EQ(refusal(brackets), "bad.json: nested deeper than 64 levels; no scene needs that");
  std::string objects;
  for (int i = 0; i < 1000000; ++i) objects += "{\"a\":";
  EXPECT_EQ(refusal(objects), "bad.json: nested deeper than 64 levels; no scene needs that");
  const std::string endless = refusal("{\"name\": \"" + std::string(10u << 20, 'x'));
  EXPECT_EQ(endless.substr(0, 43), "bad.json: not JSON: line 1, column 10485771");
  EXPECT_LT(endless.size(), 300u);
}

TEST(SceneReader, BytesThatAreNoTextAreNotPrinted) {
  const std::string line = refusal("{\"name\": \"\x1b[31m\xff\"}");
  EXPECT_EQ(line.substr(0, 42), "bad.json: not JSON: line 1, column 11: syn");
  for (const char c : line) EXPECT_TRUE(c >= 0x20 && c < 0x7f) << line;
}

TEST(SceneReader, ManyGeneratorsTogetherAreRefusedToo) {
  const std::string many =
      R"({"generator": "line", "count": 1500000, "step": [1, 0, 0], "bodies": [{"type": "static"}]})";
  EXPECT_EQ(refusal("{\"bodies\": [" + many + "," + many + "]}"),
            "bad.json: /bodies/1: would bring the scene to 3000000 bodies and 0 shapes, it can have 2000000 of each; "
            "lower the counts");
}

// Old names of keys are read, and each is told once.
TEST(SceneReader, ReadsKeysByTheirOldNames) {
  const std::string text = R"({"materials": [{"name": "wood", "static_friction": 0.6, "holding_speed": 0.01}],
    "bodies": [{"mass": 1, "inertia": [1, 1, 1], "lever": [0, 0, 1]},
               {"mass": 1, "inertia": [1, 1, 1], "lever": [0, 0, 2]},
               {"mass": 1, "shapes": [{"type": "sphere", "radius": 1},
                                      {"type": "sphere", "radius": 2, "sensor": true}]}]})";
  const Scene scene = parse_scene(text, "old.json");
  EXPECT_EQ(scene.materials[0].further.stick_speed, 0.01);
  EXPECT_EQ(scene.bodies[0].com_offset, (Vector3{0, 0, 1}));
  EXPECT_EQ(scene.bodies[1].com_offset, (Vector3{0, 0, 2}));
  EXPECT_TRUE(scene.bodies[2].shapes[1].trigger);
  std::vector<std::string> notes = scene.notes;
  std::sort(notes.begin(), notes.end());
  EXPECT_EQ(notes, (std::vector<std::string>{R"(the key "holding_speed" is called "stick_speed" now)",
                                             R"(the key "lever" is called "com_offset" now)",
                                             R"(the key "sensor" is called "trigger" now)"}));
}

TEST(SceneReader, RefusesAKeyGivenByBothOfItsNames) {
  const std::string text = R"({"bodies": [{"mass": 1, "lever": [0, 0, 1], "com_offset": [0, 0, 1]}]})";
  EXPECT_EQ(refusal(text),
            "bad.json: /bodies/0: has the key \"com_offset\" by its old name too, \"lever\"; remove that");
}

// What is wrong with a key is said by the name that the file has.
TEST(SceneReader, RefusesAnOldKeyByTheNameInTheFile) {
  EXPECT_EQ(refusal(R"({"bodies": [{"mass": 1, "inertia": [1, 1, 1], "lever": 3}]})"),
            "bad.json: /bodies/0/lever: must be an array of 3 numbers, is 3");
  EXPECT_NE(refusal(R"({"bodies": [{"mass": 1, "sensor": true}]})").find("unknown key \"sensor\""), std::string::npos);
}

}  // namespace
}  // namespace lockstep::scene_reader_test
