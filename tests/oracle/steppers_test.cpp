// Whatever computes a step, its motion is recorded, replayed, resumed and exported, and the library steps by it too.
#include <gtest/gtest.h>

#include <set>

#include "cpu_reference/oracle/cone/solvers.hpp"
#include "cpu_reference/oracle/joints/mixed.hpp"
#include "host/record/checkpoint.hpp"
#include "host/record/record_step.hpp"
#include "host/record/recording_reader.hpp"
#include "host/record/replay.hpp"
#include "host/report/report.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracles.hpp"
#include "host/steppers/stepper.hpp"
#include "include/lockstep/world.hpp"
#include "tests/command_line.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::steppers_test {
namespace {

Scene scene_by(const std::string& scene, const std::string& solver) {
  Scene read = read_scene(scene);
  replace_solver(read.settings, find_solver(solver).value());
  return read;
}

Simulation<double> simulate(const InitialState<double>& state) {
  return {make_stepper(state, StepTarget()).backend, state.params, state.buffers.step_index.front()};
}

std::uint64_t hash_of(Simulation<double>& simulation) { return combined_state_hash(simulation.world_hashes()); }

TEST(Steppers, TheTableOfOraclesIsThatOfTheirMakers) {
  const std::vector<std::string> made = oracle_names();
  std::set<std::string> rows;
  for (const SolverInfo& row : solver_infos)
    if (row.is_oracle) rows.insert(row.name);
  EXPECT_EQ(rows, std::set<std::string>(made.begin(), made.end()));
  EXPECT_EQ(rows.size(), made.size());
  for (const oracle::ConeSolver& solver : oracle::cone_solvers())
    EXPECT_EQ(info(*find_solver(solver.name)).what, std::string(solver.description));
  for (const oracle::MixedSolver& solver : oracle::mixed_solvers())
    EXPECT_EQ(info(*find_solver(solver.name)).what, std::string(solver.description));
}

// What an oracle keeps between steps is in the state: one that is made anew goes on with the same bits.
TEST(Steppers, EveryOracleGoesOnFromItsCheckpoint) {
  constexpr u32 steps = 6;
  for (const std::string& name : oracle_names()) {
    const bool reduced = name.starts_with("reduced_"), jointed = reduced || name.starts_with("mixed_");
    const std::string where = jointed || name == "impulse_based" ? "pendulum_chain" : "slide_to_roll";
    SCOPED_TRACE(name + " in " + where);
    const InitialState<double> state = compile<double>(scene_by(where, name));
    Simulation<double> whole = simulate(state);
    std::vector<unsigned char> checkpoint;
    while (whole.steps_done() < steps) {
      if (whole.steps_done() == steps / 2) {
        Backend<double>& backend = whole.backend();
        const CheckpointLabel label = {where, backend.name(), identity_of(state), hash_of(whole), state.oracle.name};
        checkpoint = encode_checkpoint(label, backend.download(persistent_buffers(state.features)), state.features);
      }
      whole.step();
    }
    InitialState<double> resumed = state;
    resume_from(checkpoint, "x.h5", where, resumed);
    Simulation<double> rest = simulate(resumed);
    while (rest.steps_done() < steps) rest.step();
    EXPECT_EQ(hash_of(rest), hash_of(whole));
  }
}

TEST(Steppers, ACheckpointIsOfItsOracle) {
  const InitialState<double> by_nsgs = compile<double>(scene_by("slide_to_roll", "nsgs"));
  const InitialState<double> by_newton = compile<double>(scene_by("slide_to_roll", "newton"));
  EXPECT_NE(identity_of(by_nsgs).settings, identity_of(by_newton).settings);
  Scene of_six = scene_by("slide_to_roll", "pyramid_lemke"), of_four = of_six;
  of_six.settings.directions = 6;
  EXPECT_NE(identity_of(compile<double>(of_six)).settings, identity_of(compile<double>(of_four)).settings);
}

class StepperCommand : public CommandLine {
 protected:
  std::string path(const std::string& name) const { return file(name).string(); }

  Outcome succeed(const std::string& arguments) const {
    const Outcome outcome = run(arguments);
    EXPECT_EQ(outcome.status, 0) << arguments << "\n" << outcome.err;
    return outcome;
  }
};

struct Kind {
  const char *scene, *solver;
};
constexpr Kind kinds[] = {{"rag_doll", "nsgs"},
                          {"rag_doll", "proximal_point"},
                          {"rag_doll", "mixed_ldlt"},
                          {"rag_doll", "impulse_based"},
                          {"chain64", "reduced_auto"},
                          {"box_stack", "box_baraff"},
                          {"incline", "pyramid_lemke --directions 8"}};

TEST_F(StepperCommand, EachKindIsRecordedVerifiedResumedAndExported) {
  for (const auto& [scene, solver] : kinds) {
    SCOPED_TRACE(std::string(scene) + " by " + solver);
    const std::string by = std::string(scene) + " --solver " + solver;
    const std::string name = std::string(solver).substr(0, std::string(solver).find(' '));
    const nlohmann::json whole = report_of(by + " --steps 12 --record " + path("x.h5"));
    EXPECT_EQ(whole["solver"], name);
    EXPECT_EQ(whole["unsolved_substeps"], 0);
    EXPECT_TRUE(whole["unsolved_worst"].is_null());

    const Outcome verified = succeed("verify " + path("x.h5"));
    EXPECT_NE(verified.out.find("double by " + name + ", recorded on reference, replayed on reference: 12 steps"),
              std::string::npos)
        << verified.out;
    const RecordingReader recording(path("x.h5"));
    EXPECT_EQ(recording.oracle().name, name);
    EXPECT_EQ(recording.outcome(), "finished");

    succeed("run " + by + " --steps 5 --quiet --checkpoint " + path("five.h5"));
    EXPECT_EQ(report_of(by + " --steps 12 --resume " + path("five.h5"))["state_hash"], whole["state_hash"]);

    succeed("export " + path("x.h5") + " -o " + path("recorded.glb"));
    succeed("export " + by + " --steps 12 -o " + path("stepped.glb"));
    for (const char* motion : {"recorded.glb", "stepped.glb"}) EXPECT_EQ(read_file(path(motion)).substr(0, 4), "glTF");
  }
}

TEST_F(StepperCommand, TheSceneMayNameTheSolver) {
  std::ofstream(path("scene.json")) << R"({"settings": {"solver": "nsgs", "steps": 5}, "bodies": [
    {"type": "static", "shapes": [{"type": "plane"}]},
    {"mass": 1, "position": [0, 0, 0.5], "shapes": [{"type": "box", "size": [1, 1, 1]}]}]})";
  const nlohmann::json report = report_of(path("scene.json"));
  EXPECT_EQ(report["solver"], "nsgs");
  EXPECT_EQ(report["precision"], "double");
  EXPECT_EQ(report["tolerance"], 1e-10);
  EXPECT_EQ(report_of(path("scene.json") + " --solver gauss_seidel --device reference")["precision"], "float");
  expect_refused("run " + path("scene.json") + " --worlds 2", 2, "an oracle solves one world");
  expect_refused("check " + path("scene.json"), 2, "nsgs is an oracle that runs on the reference alone");
  std::ofstream(path("sleepy.json")) << R"({"settings": {"solver": "nsgs", "sleeping": true}, "bodies": [{"mass": 1,
    "shapes": [{"type": "sphere", "radius": 1}]}]})";
  expect_refused("run " + path("sleepy.json"), 2, "/settings/sleeping: nsgs is an oracle");
}

TEST_F(StepperCommand, ExportsTheSystemThatAnOracleSolved) {
  const Outcome exact = succeed("export box_stack --at 2 --solver nsgs -o " + path("x.hdf5"));
  const std::size_t at = exact.out.find("own impulses ");
  ASSERT_NE(at, std::string::npos) << exact.out;
  EXPECT_LE(std::stod(exact.out.substr(at + 13)), 1.1e-10);
}

TEST_F(StepperCommand, WhatIsLeftUnsolvedIsToldByEverybody) {
  const std::string by = "box_stack --solver nsgs --iterations 3 --steps 2 ";
  const std::string line = "nsgs left 2 sub-steps unsolved (2 at its limit)";
  const std::string report = path("r.json");
  const Outcome ran = run("run " + by + "--quiet --record " + path("x.h5") + " --report " + report);
  EXPECT_EQ(ran.status, 1);
  EXPECT_NE(ran.err.find(line), std::string::npos) << ran.err;
  const nlohmann::json json = nlohmann::json::parse(read_file(report));
  EXPECT_EQ(json["unsolved_substeps"], 2);
  EXPECT_EQ(json["unsolved_worst"]["stop"], "limit");
  EXPECT_GT(json["unsolved_worst"]["residual"], 1e-10);
  EXPECT_TRUE(report_of("box_stack --device reference --steps 2")["unsolved_substeps"].is_null());

  EXPECT_EQ(RecordingReader(path("x.h5")).outcome().rfind("unsolved: " + line, 0), 0u);
  EXPECT_NE(succeed("verify " + path("x.h5")).out.find(line), std::string::npos) << "every bit is there again";
  for (const std::string& command :
       {"export " + by + "-o " + path("x.glb"), "export " + by + "--at 2 -o " + path("x.hdf5")}) {
    const Outcome exported = run(command);
    EXPECT_EQ(exported.status, 1) << command;
    EXPECT_NE(exported.err.find("nsgs left 2 sub-steps unsolved (2 at its limit)"), std::string::npos) << exported.err;
  }
}

// ---- the library

Scene two_boxes() {
  Scene scene;
  scene.name = scene.source = "boxes";
  scene.settings.dt = 0.01;
  BodyDescription floor;
  floor.kind = BODY_STATIC;
  floor.shapes.push_back({.kind = SHAPE_PLANE});
  scene.bodies.push_back(floor);
  for (const double z : {0.3, 0.9}) {
    BodyDescription box;
    box.position = {0, 0, z};
    box.shapes.push_back({.kind = SHAPE_BOX, .half_extents = {0.3, 0.3, 0.3}});
    make_solid(box, 500);
    scene.bodies.push_back(box);
  }
  return scene;
}

TEST(WorldByOracle, HasTheBitsOfTheProgram) {
  for (const auto& [scene, solver] : {Kind{"rag_doll", "mixed_ldlt"}, Kind{"chain64", "reduced_auto"}}) {
    const InitialState<double> state = compile<double>(scene_by(scene, solver));
    Simulation<double> simulation = simulate(state);
    World world(scene_by(scene, solver));
    for (int i = 0; i < 10; ++i) simulation.step();
    world.step(10);
    EXPECT_EQ(world.state_hash(), hash_of(simulation)) << solver;
    EXPECT_EQ(world.device().name, "reference");
    EXPECT_EQ(world.unsolved().count, 0u);
  }
}

TEST(WorldByOracle, TheNameOfTheSolverIsEnough) {
  Scene scene = two_boxes();
  scene.settings.solver = Solver::nsgs;
  World world(std::move(scene));
  world.step(20);
  EXPECT_LE(*world.errors().residual, 1.1e-10);
  EXPECT_NEAR(world.poses()[2].position[2], 0.9, 2e-4);

  Scene in_float = two_boxes();
  in_float.settings.solver = Solver::nsgs;
  try {
    World refused(std::move(in_float), {.precision = "float"});
    ADD_FAILURE() << "made";
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()),
              "boxes: /settings/precision: nsgs is an oracle, which works in double only; "
              "leave precision out");
  }
  Scene on_device = two_boxes();
  on_device.settings.solver = Solver::nsgs;
  EXPECT_THROW(World(std::move(on_device), {.device = "gpu"}), Error);
}

// Loads, velocities, bodies that come: in several files, each of which is replayed by the oracle.
TEST(WorldByOracle, WhatIsDoneToItIsRecordedAndReplayed) {
  const TemporaryFolder folder;
  u32 unsolved = 0;
  {
    Scene scene = two_boxes();
    scene.settings.solver = Solver::mixed_ldlt;
    World world(std::move(scene));
    world.record(folder.file("run.h5"));
    const BodyHandle top = world.bodies()[2];
    world.step(3);
    world.set_velocity(top, {{1, 0, 0}, {0, 0, 1}});
    world.step(3);
    world.apply_force(top, {500, 0, 0}, {0, 0, 0.9});
    world.step(3);
    world.add(JointDescription{.kind = JOINT_BALL, .anchor_a = {0, 0, 2}, .anchor_b = {0, 0, 2}}, top);
    world.step(3);
    unsolved = world.unsolved().count;
  }
  u32 unsolved_again = 0;
  for (const auto& [name, steps] : {std::pair("run.h5", 6u), std::pair("run.2.h5", 3u), std::pair("run.3.h5", 3u)}) {
    const RecordingReader recording(folder.file(name));
    EXPECT_EQ(recording.steps(), steps);
    EXPECT_EQ(recording.oracle().name, "mixed_ldlt");
    unsolved_again += replay<double>(recording, {}, [](u32) {}).unsolved.count;
  }
  EXPECT_EQ(unsolved_again, unsolved);
}

TEST(WorldByOracle, TellsWhatIsUnsolvedAlsoAfterBodiesCame) {
  Scene scene = two_boxes();
  scene.settings.solver = Solver::nsgs;
  scene.settings.iterations = 1;
  scene.settings.tolerance = 1e-14;
  World world(std::move(scene));
  world.step(2);
  const u32 before = world.unsolved().count;
  EXPECT_GT(before, 0u);
  EXPECT_EQ(world.unsolved().tolerance, 1e-14);
  BodyDescription ball;
  ball.position = {3, 0, 1};
  ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.3});
  make_solid(ball, 500);
  world.add(ball);
  world.step(2);
  EXPECT_GT(world.unsolved().count, before);
}

// The recording says what stepped it: a replay by something else is told in its first line.
TEST(WorldByOracle, AReplayThatDiffersSaysWhatAnOraclePromises) {
  const TemporaryFolder folder;
  const InitialState<double> state = compile<double>(scene_by("box_stack", "nsgs"));
  {
    InitialState<double> other = state;
    other.oracle.name = "admm";  // steps of another solver under the name of nsgs
    Simulation<double> simulation = simulate(other);
    RecordingWriter<double> writer(folder.file("x.h5"), {"box_stack", "reference", "{}", ""}, state);
    for (int i = 0; i < 3; ++i) {
      simulation.step();
      record_step(writer, simulation, 0);
    }
    writer.close("finished");
  }
  try {
    replay<double>(RecordingReader(folder.file("x.h5")), {}, [](u32) {});
    ADD_FAILURE() << "replayed";
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::comparison);
    EXPECT_NE(std::string(error.what()).find("an oracle promises its bits to one build on one machine"),
              std::string::npos)
        << error.what();
  }
}

}  // namespace
}  // namespace lockstep::steppers_test
