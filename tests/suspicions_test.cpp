// Each suspicion with a scene that raises it, and a sound one beside it that is much the same.
#include "host/scene/suspicions.hpp"

#include <gtest/gtest.h>

#include "host/backends/first_contacts.hpp"
#include "host/scene/read.hpp"
#include "include/lockstep/world.hpp"
#include "tests/command_line.hpp"

namespace lockstep::suspicions_test {
namespace {

using Lines = std::vector<std::string>;

Lines lines_of(const Scene& scene) { return suspicions_of(scene, first_contacts(scene)); }

Scene scene_of(const std::string& text) { return parse_scene(text, "scene.json"); }

Lines lines_of(const std::string& bodies, const std::string& rest = "") {
  return lines_of(scene_of("{\"bodies\": [" + bodies + "]" + (rest.empty() ? "" : ", " + rest) + "}"));
}

// One line, with all of these in it, in their order.
void expect_line(const Lines& lines, const std::vector<std::string>& words) {
  ASSERT_EQ(lines.size(), 1u) << testing::PrintToString(lines);
  std::size_t from = 0;
  for (const std::string& word : words) {
    from = lines[0].find(word, from);
    ASSERT_NE(from, std::string::npos) << "no " << word << " in: " << lines[0];
  }
}

void expect_silence(const Lines& lines) { EXPECT_EQ(lines, Lines()); }

const std::string ground = R"({"type": "static", "shapes": [{"type": "plane"}]})";

std::string box(const std::string& size, const std::string& height, const std::string& mass = "1",
                const std::string& rest = "") {
  return "{\"mass\": " + mass + ", \"position\": [0, 0, " + height + R"(], "shapes": [{"type": "box", "size": [)" +
         size + "]}]" + rest + "}";
}

TEST(Suspicions, SizesOfAHundredMetresBesideTheGravityOfTheEarth) {
  const std::string large = box("100, 100, 100", "60", "2.7e9");
  expect_line(lines_of(ground + "," + large), {"bodies of about 100 m", "9.81", "divide lengths by 1000"});
  expect_silence(lines_of(large, R"("gravity": [0, 0, 0])"));
  expect_silence(lines_of(ground + "," + large, R"("gravity": [0, 0, -9810])"));
  // ground may be of any size, and so may one body of many
  const std::string slab = R"({"type": "static", "position": [0, 0, -1],
    "shapes": [{"type": "box", "size": [200, 200, 2]}]})";
  expect_silence(lines_of(slab + "," + box("1, 1, 1", "0.5", "800")));
  expect_silence(lines_of(slab + "," + box("1, 1, 1", "0.5", "800") + "," + box("1, 1, 1", "1.5", "800") + R"(,
    {"mass": 2e5, "position": [40, 0, 1], "shapes": [{"type": "capsule", "radius": 1, "length": 60, "rotation": {"euler_deg": [0, 90, 0]}}]})"));
}

TEST(Suspicions, DensitiesOfNoMaterial) {
  expect_line(lines_of(box("20, 20, 20", "30", "0.06")), {"density of about 7.5e-06 kg/m^3", "kilograms"});
  expect_line(lines_of(box("0.01, 0.01, 0.01", "1", "7.8")), {"density of about 7.8e+06"});
  expect_silence(lines_of(box("0.02, 0.02, 0.02", "1", "0.06")));
  expect_silence(lines_of(box("1, 1, 1", "1", "0.1")));  // a balloon
  // the shape of a link may be a small share of it
  expect_silence(lines_of(box("0.01, 0.01, 0.01", "1", "7.8", R"(, "name": "link")"),
                          R"("joints": [{"type": "ball", "bodies": ["world", "link"], "anchor": [0, 0, 1]}])"));
}

TEST(Suspicions, GravityAlongTheGround) {
  const std::string crate = box("1, 1, 1", "0.5", "800");
  const std::string along_y = R"("gravity": [0, -9.81, 0])";
  const std::string slab = R"({"type": "static", "position": [0, 0, -0.5],
    "shapes": [{"type": "box", "size": [20, 20, 1]}]})";
  expect_line(lines_of(ground + "," + crate, along_y),
              {"gravity of [0, -9.81, 0]", "along the ground", "z is up", "[0, 0, -9.81]"});
  expect_line(lines_of(slab + "," + crate, along_y), {"along the ground"});
  expect_line(lines_of(ground + "," + crate, R"("gravity": [0, 0, 9.81])"), {"points up"});
  // one that is built for it, one in a room, one that has no ground, and one that is tilted
  expect_silence(lines_of(R"({"type": "static", "shapes": [{"type": "plane", "normal": [0, 1, 0]}]},
                              {"mass": 800, "position": [0, 0.5, 0],
                              "shapes": [{"type": "box", "size": [1, 1, 1]}]})",
                          along_y));
  expect_silence(lines_of(ground + R"(, {"type": "static", "position": [0, -3, 0],
    "shapes": [{"type": "plane", "normal": [0, 1, 0]}]},)" +
                              crate,
                          along_y));
  expect_silence(lines_of(crate, along_y));
  expect_silence(lines_of(ground + "," + crate, R"("gravity": [3, 0, -9.3])"));
}

TEST(Suspicions, AQuaternionWithWFirst) {
  const std::string about_x = R"(, "orientation": [1, 0, 0, 0])";
  expect_line(lines_of(ground + "," + box("1, 1, 1", "0.5", "800", about_x)),
              {"body 1", "[1, 0, 0, 0]", "w comes last", "[0, 0, 0, 1]"});
  expect_silence(lines_of(ground + "," + box("1, 1, 1", "0.5", "800", R"(, "orientation": [0, 0, 0, 1])")));
  // half a rotation about z, and that of a body which looks another way after one about x
  expect_silence(lines_of(ground + "," + box("1, 1, 1", "0.5", "800", R"(, "orientation": [0, 0, 1, 0])")));
  expect_silence(lines_of(ground + R"(, {"mass": 800, "position": [0, 0, 1], "orientation": [1, 0, 0, 0],
    "shapes": [{"type": "hull", "points": [[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]}]})"));
}

TEST(Suspicions, AStepOfATenthOfASecond) {
  const std::string crate = box("0.2, 0.2, 0.2", "0.1", "6");
  expect_line(lines_of(ground + "," + crate, R"("settings": {"dt": 0.1})"),
              {"a step of 0.1 s", "falls 0.0981 m", "0.2 m thick", "substeps"});
  expect_silence(lines_of(ground + "," + crate, R"("settings": {"dt": 0.1, "solver": "small_steps", "substeps": 10})"));
  expect_silence(lines_of(crate, R"("settings": {"dt": 0.1})"));  // it meets nothing
  expect_silence(lines_of(ground + "," + crate, R"("settings": {"dt": 0.1}, "gravity": [0, 0, -0.1])"));
  expect_silence(lines_of(ground + "," + crate, R"("settings": {"dt": 0.0334})"));
}

TEST(Suspicions, BodiesThatStartInsideEachOther) {
  const std::string lower = box("1, 1, 1", "0.5", "800");
  expect_line(lines_of(ground + "," + lower + "," + box("1, 1, 1", "1.1", "800")),
              {"body 1", "0.4 m inside body 2", "40 %", "move it"});
  expect_silence(lines_of(ground + "," + lower + "," + box("1, 1, 1", "1.5", "800")));
  expect_silence(lines_of(ground + "," + lower + "," + box("1, 1, 1", "1.49", "800")));  // a little is harmless
  // exact shapes, not the boxes around them: two spheres side by side on a diagonal
  const std::string ball = R"("shapes": [{"type": "sphere", "radius": 0.5}])";
  expect_silence(
      lines_of("{\"mass\": 500, " + ball + "}, {\"mass\": 500, \"position\": [0.75, 0.75, 0], " + ball + "}"));
  // what a filter or a joint exempts
  expect_silence(lines_of(lower + R"(, {"mass": 800, "position": [0, 0, 1.1], "shapes": [
    {"type": "box", "size": [1, 1, 1], "category": "ghost", "collides_with": ["ghost"]}]})"));
  expect_silence(lines_of(
      box("1, 1, 1", "0.5", "800", R"(, "name": "lower")") + "," + box("1, 1, 1", "1.1", "800", R"(, "name": "upper")"),
      R"("joints": [{"type": "ball", "bodies": ["lower", "upper"], "anchor": [0, 0, 0.8]}])"));
}

TEST(Suspicions, BodiesThatStartInTheGround) {
  expect_line(lines_of(ground + "," + box("1, 1, 1", "0", "800")), {"body 1", "0.5 m below body 0", "50 %", "up"});
  expect_line(lines_of(ground + "," + box("1, 1, 1", "-3", "800")), {"body 1", "3.5 m below body 0"});
  const std::string slab = R"({"type": "static", "position": [0, 0, -0.5],
    "shapes": [{"type": "box", "size": [20, 20, 1]}]})";
  expect_line(lines_of(slab + "," + box("1, 1, 1", "0.3", "800")), {"body 1", "0.2 m inside body 0"});
  expect_silence(lines_of(slab + "," + box("1, 1, 1", "0.5", "800")));
}

TEST(Suspicions, BodiesThatStartBelowASurface) {
  const auto field = [](const std::string& height) {
    return R"({"type": "static", "position": [0, 0, )" + height +
           R"(], "shapes": [{"type": "height_field", "spacing": 5,
      "heights": [[0, 0, 0], [0, 1, 0], [0, 0, 0]]}]})";
  };
  const std::string crate =
      R"({"mass": 800, "position": [1, 1.5, -2], "shapes": [{"type": "box", "size": [1, 1, 1]}]})";
  expect_line(lines_of(field("0") + "," + crate), {"body 1", "below body 0", "falls for ever", "above it"});
  expect_silence(lines_of(field("-5") + "," + crate));
  // beside it, in a room with a floor, and over what has a floor of its own
  expect_silence(lines_of(field("0") + R"(, {"mass": 800, "position": [9, 1.5, -2],
    "shapes": [{"type": "box", "size": [1, 1, 1]}]})"));
  expect_silence(lines_of(field("0") + "," + field("-5") + "," + crate));
  expect_silence(lines_of(R"({"type": "static", "position": [0, 0, -2.5], "shapes": [{"type": "plane"}]},)" +
                          field("0") + "," + crate));
}

TEST(Suspicions, AreNamedThreeAtATimeAndTheOthersCounted) {
  expect_line({lines_of(ground + R"(, {"generator": "line", "count": 100, "step": [2, 0, 0], "bodies": [
    {"mass": 800, "shapes": [{"type": "box", "size": [1, 1, 1]}]}]})")
                   .back()},
              {"body 3", "and 97 more"});
}

TEST(Suspicions, ALightBodyUnderAHeavyOne) {
  const std::string light = box("0.1, 0.1, 0.1", "0.05", "0.001"), heavy = box("1, 1, 1", "0.6", "1000");
  expect_line(lines_of(ground + "," + light + "," + heavy),
              {"body 2 of 1e+03 kg stands on body 1 of 0.001 kg", "small_steps"});
  expect_silence(
      lines_of(ground + "," + light + "," + heavy, R"("settings": {"solver": "small_steps", "substeps": 2000})"));
  expect_silence(lines_of(ground + "," + light + "," + heavy, R"("settings": {"solver": "nsgs"})"));
  // a hundred times is no matter, nor a light one on a heavy one
  expect_silence(lines_of(ground + "," + box("0.1, 0.1, 0.1", "0.05", "10") + "," + heavy));
  expect_silence(lines_of(ground + "," + box("1, 1, 1", "0.5", "1000") + "," + box("0.1, 0.1, 0.1", "1.05", "0.001")));
}

TEST(Suspicions, AHeavyBodyThatHangsOnALightOne) {
  const std::string light =
      R"({"name": "light", "mass": 0.001, "position": [0, 0, 1.5], "shapes": [{"type": "sphere", "radius": 0.01}]})";
  const std::string heavy =
      R"({"name": "heavy", "mass": 1000, "position": [0, 0, 0.5], "shapes": [{"type": "sphere", "radius": 0.3}]})";
  const std::string to_heavy = R"({"type": "ball", "bodies": ["light", "heavy"], "anchor": [0, 0, 1]})";
  const std::string to_world = R"({"type": "ball", "bodies": ["world", "light"], "anchor": [0, 0, 2]})";
  const std::string joints = "\"joints\": [" + to_world + "," + to_heavy + "]";
  expect_line(lines_of(light + "," + heavy, R"("settings": {"joint_solver": "sweeps"}, )" + joints),
              {"body 1 (\"heavy\") of 1e+03 kg is carried by a joint to body 0 (\"light\") of 0.001 kg"});
  expect_silence(lines_of(light + "," + heavy, joints));  // solved at once
  // a light one that is carried
  expect_silence(lines_of(light + "," + heavy, "\"joints\": [" + to_heavy + "]"));
}

TEST(Suspicions, OfBuiltInScenesThereIsNoneThatIsNotTrue) {
  for (const SceneListing& listing : built_in_scenes()) {
    SCOPED_TRACE(listing.name);
    const Lines lines = lines_of(read_scene(listing.name));
    if (listing.name == "strider")  // it does stand in the step, by 25 mm
      expect_line(lines, {"strider/front_left_shin", "inside body 0"});
    else
      expect_silence(lines);
  }
}

TEST(Suspicions, OfAWorldAreThoseOfItsBodiesBeforeItIsStepped) {
  World world(scene_of("{\"bodies\": [" + ground + "]}"), {.device = "reference"});
  BodyDescription ball;
  ball.mass = 500;
  ball.inertia = {50, 50, 50};
  ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.5});
  world.add(ball);
  expect_line(world.suspicions(), {"body 1 starts 0.5 m below body 0"});
  world.step();
  expect_silence(world.suspicions());
}

class SuspicionsCli : public CommandLine {};

TEST_F(SuspicionsCli, AreToldOnStderrAndAreNoStatus) {
  const fs::path scene = file("scene.json");
  std::ofstream(scene) << "{\"bodies\": [" << ground << "," << box("1, 1, 1", "0", "800") << "]}";
  for (const std::string& command :
       {"run " + scene.string(), "check " + scene.string(), "export " + scene.string() + " --at 2 --sizes",
        "run " + scene.string() + " --worlds 3"}) {
    SCOPED_TRACE(command);
    const Outcome outcome =
        run(command + (command.starts_with("check") ? " --steps 3" : " --steps 3 --device reference"));
    EXPECT_EQ(outcome.status, 0);
    EXPECT_EQ(outcome.err.find("lockstep: " + scene.string() + ": body 1 starts 0.5 m below body 0"), 0u)
        << outcome.err;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  }
}

}  // namespace
}  // namespace lockstep::suspicions_test
