// `lockstep render` as a user meets it. It needs EGL: where there is none the tests fail, and say what to install.
#include <dlfcn.h>
#include <link.h>

#include <set>
#include <utility>

#include "include/lockstep/world.hpp"
#include "kernels/types.h"
#include "tests/command_line.hpp"

namespace lockstep::render_cli_test {
namespace {

class RenderCommand : public CommandLine {
 protected:
  static constexpr const char* small = " --size 160x120 --device reference ";

  std::string folder(const std::string& name) const { return file(name).string(); }

  // Runs a command that has to succeed.
  Outcome render(const std::string& arguments) const {
    const Outcome outcome = run("render " + arguments);
    EXPECT_EQ(outcome.status, 0) << arguments << "\n" << outcome.err;
    return outcome;
  }

  // The width and the height that a PNG file says it has.
  static std::pair<u32, u32> size_of(const std::string& png) {
    const auto number = [&](std::size_t at) {
      u32 value = 0;
      for (std::size_t i = at; i < at + 4; ++i) value = value << 8 | static_cast<unsigned char>(png.at(i));
      return value;
    };
    EXPECT_EQ(png.substr(1, 3), "PNG");
    return {number(16), number(20)};
  }

  std::set<std::string> files_in(const std::string& name) const {
    std::set<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder(name))) names.insert(entry.path().filename().string());
    return names;
  }

  // A folder with a program called ffmpeg that keeps what it is given.
  std::string fake_ffmpeg() const {
    const fs::path bin = file("bin");
    fs::create_directory(bin);
    std::ofstream(bin / "ffmpeg") << "#!/bin/sh\necho \"$@\" > " << folder("ffmpeg_arguments") << "\ncat > "
                                  << folder("ffmpeg_frames") << "\n";
    fs::permissions(bin / "ffmpeg", fs::perms::owner_all);
    return bin.string();
  }
};

// Whatever steps a scene, its pictures are those of a recording of it.
TEST_F(RenderCommand, DrawsWhatOraclesStep) {
  for (const auto& [scene, solver] :
       {std::pair("rag_doll", "nsgs"), std::pair("rag_doll", "proximal_point"), std::pair("rag_doll", "mixed_ldlt"),
        std::pair("rag_doll", "impulse_based"), std::pair("chain64", "reduced_auto")}) {
    SCOPED_TRACE(solver);
    const std::string by = std::string(scene) + " --solver " + solver + " --steps 6 ";
    render(by + small + "--at 6 --out " + folder("stepped"));
    EXPECT_EQ(run("run " + by + "--quiet --record " + folder("x.h5")).status, 0);
    render(folder("x.h5") + " --size 160x120 --at 6 --out " + folder("recorded"));
    const std::string picture = std::string("/") + scene + "_000006.png";
    EXPECT_EQ(read_file(folder("stepped") + picture), read_file(folder("recorded") + picture));
  }
  expect_refused("render box_stack --solver nsgs --device cpu --out " + folder("none"), 2,
                 "--device: nsgs is an oracle");
}

TEST_F(RenderCommand, DrawsTheStepsThatAreAskedFor) {
  const std::string common = std::string("spheres_small") + small + "--steps 12 --out ";
  const Outcome outcome = render(common + folder("a") + " --at 12,0,5");
  EXPECT_NE(outcome.out.find("3 pictures in"), std::string::npos) << outcome.out;
  EXPECT_EQ(files_in("a"), (std::set<std::string>{"spheres_small_000000.png", "spheres_small_000005.png",
                                                  "spheres_small_000012.png"}));
  EXPECT_EQ(size_of(read_file(folder("a") + "/spheres_small_000005.png")), std::pair(160u, 120u));
  render(common + folder("b") + " --frames 3");
  EXPECT_EQ(files_in("b"), (std::set<std::string>{"spheres_small_000000.png", "spheres_small_000006.png",
                                                  "spheres_small_000012.png"}));
  render(common + folder("c") + " --every 5");
  EXPECT_EQ(files_in("c"), (std::set<std::string>{"spheres_small_000000.png", "spheres_small_000005.png",
                                                  "spheres_small_000010.png"}));
  render(common + folder("d") + " --fps 25");  // of 0.01 s a step
  EXPECT_EQ(files_in("d"), (std::set<std::string>{"spheres_small_000000.png", "spheres_small_000004.png",
                                                  "spheres_small_000008.png", "spheres_small_000012.png"}));
  render(std::string("slide_to_roll") + small + "--dt 0.01 --steps 400 --fps 0.5 --out " + folder("e"));
  EXPECT_EQ(files_in("e"), (std::set<std::string>{"slide_to_roll_000000.png", "slide_to_roll_000200.png",
                                                  "slide_to_roll_000400.png"}));
}

TEST_F(RenderCommand, GivesTheSameBytesAgain) {
  const std::string common = std::string("cylinders_and_hulls") + small + "--at 8 --show contacts,forces --out ";
  render(common + folder("a"));
  render(common + folder("b"));
  const std::string first = read_file(folder("a") + "/cylinders_and_hulls_000008.png");
  EXPECT_GT(first.size(), 2000u);
  EXPECT_EQ(first, read_file(folder("b") + "/cylinders_and_hulls_000008.png"));
}

TEST_F(RenderCommand, ChangesNoBitOfTheSimulation) {
  const nlohmann::json report = report_of("cylinders_and_hulls --steps 25 --device reference");
  for (const char* color : {"body", "speed", "contacts", "color", "penetration", "residual"}) {
    const Outcome outcome =
        render("cylinders_and_hulls --steps 25 --every 5 --show contacts,forces,joints --color-by " +
               std::string(color) + small + "--out " + folder(color));
    EXPECT_NE(outcome.out.find("state hash " + report["state_hash"].get<std::string>()), std::string::npos)
        << color << "\n"
        << outcome.out << report["state_hash"];
  }
  EXPECT_NE(read_file(folder("body") + "/cylinders_and_hulls_000025.png"),
            read_file(folder("speed") + "/cylinders_and_hulls_000025.png"));
}

TEST_F(RenderCommand, ARecordingLooksAsTheRunDid) {
  // the last one's shape is not simulated: it can touch nothing
  std::ofstream(file("ball.json")) << R"({"camera": {"position": [0, -9, 3], "target": [0, 0, 1]},
                                          "bodies": [{"mass": 1, "shapes": [{"type": "sphere", "radius": 1}]}]})";
  for (const std::string& scene :
       {std::string("spheres_small"), std::string("rag_doll"), std::string("particles_rest"), folder("ball.json")}) {
    SCOPED_TRACE(scene);
    const std::string record = folder("x.h5"), name = "/" + fs::path(scene).stem().string() + "_000007.png";
    EXPECT_EQ(run("run " + scene + " --steps 10 --quiet --device reference --record " + record).status, 0);
    render(scene + small + "--at 0,7 --color-by speed --show joints --out " + folder("scene"));
    render(record + " --size 160x120 --at 0,7 --color-by speed --show joints --out " + folder("record"));
    EXPECT_EQ(read_file(folder("scene") + name), read_file(folder("record") + name));
  }
}

// There is no scene file then.
TEST_F(RenderCommand, DrawsTheRecordingOfAWorldMadeInCode) {
  Scene scene;
  scene.name = "thrown";
  BodyDescription ball;
  ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 1});
  make_solid(ball, 1000);
  World world(scene, {.device = "reference"});
  world.set_velocity(world.add(ball), {.linear = {1, 0, 9}});
  world.record(folder("thrown.h5"));
  world.step(5);
  world.end_recording();
  render(folder("thrown.h5") + " --size 160x120 --at 1,5 --out " + folder("out"));
  EXPECT_NE(read_file(folder("out") + "/thrown_000001.png"), read_file(folder("out") + "/thrown_000005.png"));
  EXPECT_EQ(run("verify --device reference " + folder("thrown.h5")).status, 0);
}

TEST_F(RenderCommand, TakesTheCameraOfTheSceneOrOfTheCommand) {
  const auto scene = [&](const char* name, const char* camera) {
    std::ofstream(file(name)) << R"({"name": "ball", )" << camera
                              << R"("bodies": [{"mass": 1, "shapes": [{"type": "sphere", "radius": 1}]}]})";
    return folder(name);
  };
  const std::string plain = scene("plain.json", "");
  const std::string framed = scene("framed.json", R"("camera": {"position": [0, -20, 3], "target": [0, 0, 1]}, )");
  const std::string end = std::string(small) + "--at 1 --out ";
  render(plain + end + folder("a"));
  render(framed + end + folder("b"));
  render(plain + " --from 0,-20,3 --to 0,0,1" + end + folder("c"));
  const auto picture = [&](const char* name) { return read_file(folder(name) + "/ball_000001.png"); };
  EXPECT_NE(picture("a"), picture("b"));
  EXPECT_EQ(picture("b"), picture("c"));
  const Outcome with = run("run " + framed + " --steps 3 --quiet --device reference --report " + folder("with.json"));
  const Outcome without =
      run("run " + plain + " --steps 3 --quiet --device reference --report " + folder("without.json"));
  EXPECT_EQ(with.status + without.status, 0);
  EXPECT_EQ(nlohmann::json::parse(read_file(folder("with.json")))["state_hash"],
            nlohmann::json::parse(read_file(folder("without.json")))["state_hash"]);
}

TEST_F(RenderCommand, FilmsThroughFfmpeg) {
  const Outcome outcome = run_command("PATH=" + fake_ffmpeg() + ":$PATH " LOCKSTEP_PROGRAM " render spheres_small" +
                                      small + "--steps 12 --fps 25 --video " + folder("a.mp4"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(fs::file_size(file("ffmpeg_frames")), 4u * 160 * 120 * 3);
  const std::string arguments = read_file(folder("ffmpeg_arguments"));
  EXPECT_NE(arguments.find("-s 160x120 -r 25 "), std::string::npos) << arguments;
  EXPECT_NE(arguments.find(folder("a.mp4")), std::string::npos) << arguments;
}

TEST_F(RenderCommand, SaysWhereThereIsNoFfmpeg) {
  const Outcome outcome =
      run_command("PATH=" + folder("empty") + " " LOCKSTEP_PROGRAM " render spheres_small --video " + folder("a.mp4"));
  EXPECT_EQ(outcome.status, 3);
  EXPECT_EQ(outcome.err.rfind("lockstep: --video: there is no ffmpeg here", 0), 0u) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
}

// A library of this name that is none stands in the way of the real one.
TEST_F(RenderCommand, SaysWhereThereIsNoEglAndWorksOtherwise) {
  fs::create_directory(file("lib"));
  std::ofstream(file("lib") / "libEGL.so.1") << "not a library";
  const std::string program = "LD_LIBRARY_PATH=" + folder("lib") + " " LOCKSTEP_PROGRAM " ";
  const Outcome outcome = run_command(program + "render spheres_small --at 1 --out " + folder("a") + small);
  EXPECT_EQ(outcome.status, 3);
  EXPECT_NE(outcome.err.find("libEGL.so.1"), std::string::npos) << outcome.err;
  EXPECT_NE(outcome.err.find("install libegl1"), std::string::npos) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_EQ(run_command(program + "run spheres_small --steps 2 --quiet --device reference").status, 0);
  const Outcome devices = run_command(program + "devices");
  EXPECT_EQ(devices.status, 0);
  EXPECT_NE(devices.out.find("pictures   none: "), std::string::npos) << devices.out;
}

// EGL 1.5 finds the functions of OpenGL ES by itself.
TEST_F(RenderCommand, NeedsNoLibraryOfOpenGlBesideEgl) {
  fs::create_directory(file("lib"));
  std::ofstream(file("lib") / "libGLESv2.so.2") << "not a library";
  const std::string options = std::string("render spheres_small --at 1") + small + "--out ";
  const Outcome outcome =
      run_command("LD_LIBRARY_PATH=" + folder("lib") + " " LOCKSTEP_PROGRAM " " + options + folder("a"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(run(options + folder("b")).status, 0);
  EXPECT_EQ(read_file(folder("a") + "/spheres_small_000001.png"), read_file(folder("b") + "/spheres_small_000001.png"));
}

// As on a server with a GPU: the driver has devices, with or without contexts that need no surface, and nothing else.
TEST_F(RenderCommand, DrawsOnADeviceOfEglWhereThereIsNoDisplay) {
  void* egl = dlopen("libEGL.so.1", RTLD_NOW | RTLD_LOCAL);
  const link_map* map = nullptr;
  ASSERT_TRUE(egl != nullptr && dlinfo(egl, RTLD_DI_LINKMAP, &map) == 0) << dlerror();
  const std::string options = std::string("render spheres_small --at 1") + small + "--out ",
                    picture = "/spheres_small_000001.png";
  EXPECT_EQ(run(options + folder("usual")).status, 0);
  const auto draw = [&](const std::string& lacks) {
    return run_command("LD_LIBRARY_PATH=" LOCKSTEP_HEADLESS_EGL " LOCKSTEP_EGL=" + std::string(map->l_name) +
                       " LOCKSTEP_EGL_LACKS='EGL_MESA_platform_surfaceless " + lacks + "' " LOCKSTEP_PROGRAM " " +
                       options + folder(lacks));
  };
  for (const std::string lacks : {"none", "EGL_KHR_surfaceless_context"}) {
    const Outcome outcome = draw(lacks);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_EQ(read_file(folder(lacks) + picture), read_file(folder("usual") + picture)) << lacks;
  }
  EXPECT_EQ(draw("EGL_EXT_platform_device").status, 3) << "the displays of devices are all that there is";
}

TEST_F(RenderCommand, RefusesInvalidOptions) {
  const std::string scene = "render spheres_small --device reference ";
  for (const char* size : {"12x12", "1280", "1280x", "x720", "axb", "3841x2160", "1280x-720", "1280x720x3"})
    expect_refused(scene + "--size " + size, 2, "--size: must be WIDTHxHEIGHT");
  expect_refused(scene + "--color-by mood", 2, "--color-by: must be one of body, speed, contacts, color, penetration");
  expect_refused(scene + "--show contacts,ghosts", 2,
                 "--show: must be some of contacts, forces, joints, particles, shapes");
  expect_refused(scene + "--at 100000", 2, "--at: there is no step 100000 here");
  expect_refused(scene + "--at 3 --every 2", 2, "--at");
  expect_refused(scene + "--frames 0", 2, "--frames");
  expect_refused(scene + "--fps 1000", 2, "--fps: there are only 100 steps in a second");
  expect_refused(scene + "--from 1,2,3", 2, "--from --to: go together");
  expect_refused(scene + "--from 1,2,3 --to 1,2,3", 2, "--to: must be another place");
  expect_refused(scene + "--scale 3", 2, "--scale: goes with");
  expect_refused(scene + "--video /nowhere/a.mp4", 2, "/nowhere/a.mp4: the film cannot be written");
  expect_refused(scene + "--size 161x120 --video " + folder("a.mp4"), 2, "must be even numbers");
  expect_refused(scene + "--video a.mp4 --out b", 2, "--out: is for pictures");
  expect_refused(scene + "--color-by color --solver jacobi", 2, "there are no colours");
  expect_refused("render no_such_scene", 2, "no_such_scene");
  expect_refused("render " + folder("none.h5"), 2, "none.h5: no such file");
}

TEST_F(RenderCommand, RefusesAFolderThatCannotBe) {
  const std::string scene = "render spheres_small --device reference --at 1 --out ";
  expect_refused(scene + "/nowhere/at/all", 2, "/nowhere/at/all: is no folder, and none can be made there");
  std::ofstream(file("file")) << "in the way";
  expect_refused(scene + folder("file"), 2, "is no folder");
  fs::create_directory(file("taken"));
  std::ofstream(file("taken") / "spheres_small_000001.png") << "something else";
  expect_refused(scene + folder("taken"), 2, "the picture does not overwrite it");
}

TEST_F(RenderCommand, RefusesWhatARecordingDoesNotContain) {
  const std::string record = folder("x.h5");
  EXPECT_EQ(run("run spheres_small --steps 5 --quiet --device reference --record " + record).status, 0);
  for (const char* color : {"contacts", "color", "penetration", "residual"})
    expect_refused("render " + record + " --color-by " + color, 2, "render its scene instead");
  expect_refused("render " + record + " --show forces", 2, "render its scene instead");
  expect_refused("render " + record + " --dt 0.1", 2, "--dt is for what is simulated");
  expect_refused("render " + record + " --device reference", 2, "--device is for what is simulated");
  expect_refused("render " + record + " --at 6", 2, "there is no step 6 here, only 0 to 5");
}

// A planted difference is in tests/difference_test.cpp; here there is none.
TEST_F(RenderCommand, CheckDrawsOnlyWhatDiffers) {
  const Outcome outcome = run("check spheres_small --steps 3 --picture " + folder("a.png"));
  EXPECT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_FALSE(fs::exists(file("a.png")));
  expect_refused("verify x.h5 --picture /nowhere/a.png", 2, "/nowhere/a.png: the picture cannot be written");
  expect_refused("check spheres_small --picture /nowhere/a.png", 2, "/nowhere/a.png: the picture cannot be written");
}

}  // namespace
}  // namespace lockstep::render_cli_test
