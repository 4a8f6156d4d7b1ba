// Many worlds of one scene from the command line, alone and shared out over ranks of MPI.
#include <gtest/gtest.h>

#include <fstream>

#include "tests/command_line.hpp"

namespace lockstep::worlds_cli_test {
namespace {

class Worlds : public CommandLine {
 protected:
  // What a run that ends well reports. `before`: what starts it.
  nlohmann::json report(const std::string& arguments, const std::string& before = "") const {
    const Outcome outcome = run_command(before + LOCKSTEP_PROGRAM " run " + arguments + " --quiet --report " +
                                        file("report.json").string());
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(read_file(file("report.json")), nullptr, false);
  }

  // A heap that a seed draws otherwise: balls of two layers over a plane.
  std::string seeded_scene() const {
    std::ofstream(file("heap.json")) << R"({"settings": {"steps": 60}, "bodies": [
      {"type": "static", "shapes": [{"type": "plane"}]},
      {"generator": "grid", "counts": [3, 3, 2], "spacing": [0.6, 0.6, 0.7], "origin": [0, 0, 0.6],
       "jitter": {"generator": "lcg_by_index", "seed": 7, "amplitude": [0.2, 0.2, 0.05]},
       "bodies": [{"density": 500, "shapes": [{"type": "sphere", "radius": 0.25}]}]}]})";
    return file("heap.json").string();
  }
};

TEST_F(Worlds, EachHasTheBitsThatItHasAlone) {
  const std::string scene = seeded_scene();
  for (const std::string device : {"reference", "auto"}) {
    const nlohmann::json batch = report(scene + " --worlds 3 --seed 5 --device " + device);
    EXPECT_EQ(batch["worlds"], 3);
    EXPECT_EQ(batch["bodies"], 3 * 19);
    EXPECT_GT(batch["body_steps_per_second"], 0);
    ASSERT_EQ(batch["world_state_hashes"].size(), 3u);
    for (unsigned k = 0; k < 3; ++k) {
      const nlohmann::json alone = report(scene + " --device reference --seed " + std::to_string(5 + k));
      EXPECT_EQ(batch["world_state_hashes"][k], alone["state_hash"]) << device << " " << k;
    }
    EXPECT_NE(batch["world_state_hashes"][0], batch["world_state_hashes"][1]) << "a seed draws another heap";
  }
}

// A tolerance ends the sweeps of a batch at once, and is refused; along a gradient each world ends by itself.
TEST_F(Worlds, EachEndsByItselfOrNotAtAll) {
  const std::string scene = seeded_scene() + " --steps 60 --tolerance 0.02 --iterations 60 --device reference";
  for (const char* solver : {"gauss_seidel", "small_steps", "jacobi", "dense_gauss_seidel", "cell_gauss_seidel"})
    expect_refused("run " + scene + " --worlds 2 --solver " + solver, 2,
                   "/settings/tolerance: ends the sweeps of all worlds at once, so that one would change the bits of "
                   "another");
  for (const std::string solver : {"gradient", "accelerated_gradient"}) {
    const nlohmann::json batch = report(scene + " --worlds 3 --seed 5 --solver " + solver);
    for (unsigned k = 0; k < 3; ++k)
      EXPECT_EQ(batch["world_state_hashes"][k],
                report(scene + " --seed " + std::to_string(5 + k) + " --solver " + solver)["state_hash"]);
  }
}

TEST_F(Worlds, SeedZeroIsTheSceneOfTheFile) {
  const std::string scene = seeded_scene();
  EXPECT_EQ(report(scene + " --device reference")["state_hash"],
            report(scene + " --device reference --seed 0")["state_hash"]);
}

TEST_F(Worlds, OfASceneWithoutChanceAllAreAlike) {
  const nlohmann::json batch = report("slide_to_roll --steps 50 --worlds 4 --device reference");
  const nlohmann::json alone = report("slide_to_roll --steps 50 --device reference");
  for (const nlohmann::json& hash : batch["world_state_hashes"]) EXPECT_EQ(hash, alone["state_hash"]);
  EXPECT_TRUE(alone["world_state_hashes"].empty());
}

TEST_F(Worlds, WhatIsOfOneWorldIsRefusedForSeveral) {
  expect_refused("run slide_to_roll --worlds 2 --events x", 2, "is of one world");
  expect_refused("run slide_to_roll --worlds 2 --record x.h5", 2, "say which by --record-worlds");
  expect_refused("run slide_to_roll --worlds 2 --record x.h5 --record-worlds 1,2", 2, "has world 2, the last one is 1");
  expect_refused("run slide_to_roll --record x.h5 --record-worlds 0", 2, "is of a batch");
  expect_refused("run slide_to_roll --worlds 2 --record x.h5 --record-worlds 0 --resume y", 2, "leave out --resume");
  expect_refused("run slide_to_roll --worlds 2 --record-worlds 0", 2, "--record");
  expect_refused("run slide_to_roll --worlds 2 --solver auto", 2, "an oracle solves one world");
  expect_refused("run slide_to_roll --worlds 0", 2, "--worlds");
  expect_refused("run spheres8000 --worlds 100000", 2, "--worlds: that is");
}

// A batch goes on with the bits of one that was not interrupted, and not as a batch of other worlds.
TEST_F(Worlds, GoOnFromACheckpoint) {
  const std::string scene = seeded_scene(), state = file("state.h5").string();
  for (const std::string device : {"reference", "auto"}) {
    const std::string arguments = scene + " --worlds 4 --seed 5 --device " + device;
    const nlohmann::json whole = report(arguments + " --steps 20");
    report(arguments + " --steps 8 --checkpoint " + state);
    const nlohmann::json rest = report(arguments + " --steps 20 --resume " + state);
    EXPECT_EQ(rest["world_state_hashes"], whole["world_state_hashes"]);
    EXPECT_EQ(rest["first_step"], 8);
  }
  expect_refused("run " + scene + " --worlds 3 --seed 5 --steps 20 --resume " + state, 2, "state.h5");
  expect_refused("run " + scene + " --seed 5 --steps 20 --resume " + state, 2, "state.h5");
}

TEST_F(Worlds, ThoseThatAreChosenAreRecordedAsAlone) {
  const std::string scene = seeded_scene(), recording = file("r.h5").string();
  const nlohmann::json batch =
      report(scene + " --worlds 4 --steps 12 --device auto --record " + recording + " --record-worlds 3,1,3");
  EXPECT_FALSE(fs::exists(recording));
  EXPECT_FALSE(fs::exists(file("r.0.h5")));
  for (const unsigned world : {1u, 3u}) {
    const std::string one = file("r." + std::to_string(world) + ".h5").string();
    const Outcome verified = run("verify " + one + " --device reference");
    EXPECT_EQ(verified.status, 0) << verified.err;
    EXPECT_NE(verified.out.find("12 steps"), std::string::npos) << verified.out;
  }
}

#ifdef LOCKSTEP_MPIRUN
// As root and on few cores, as a build machine is.
std::string on_ranks(unsigned ranks) {
  return "OMPI_ALLOW_RUN_AS_ROOT=1 OMPI_ALLOW_RUN_AS_ROOT_CONFIRM=1 " LOCKSTEP_MPIRUN
         " --oversubscribe --bind-to none -n " +
         std::to_string(ranks) + " ";
}

TEST_F(Worlds, HashesDoNotDependOnTheRanks) {
  const std::string scene = seeded_scene();
  for (const std::string device : {"reference", "auto"}) {
    const std::string arguments = scene + " --worlds 7 --device " + device;
    const nlohmann::json alone = report(arguments);
    for (const unsigned ranks : {1u, 2u, 3u}) {
      const nlohmann::json shared = report(arguments, on_ranks(ranks));
      EXPECT_EQ(shared["ranks"], ranks);
      for (const char* key : {"state_hash", "pose_hash", "world_state_hashes", "worlds", "bodies"})
        EXPECT_EQ(shared[key], alone[key]) << key << " on " << ranks << " ranks, " << device;
      EXPECT_EQ(shared["max_penetration_m"], alone["max_penetration_m"]);
      EXPECT_NEAR(double(shared["energy_final_j"]), double(alone["energy_final_j"]),
                  1e-9 * double(alone["energy_final_j"]));
    }
  }
}

TEST_F(Worlds, FiguresOfParticlesAreThoseOfAllRanks) {
  const std::string arguments = "particles_rest --steps 2 --worlds 3 --device reference";
  const nlohmann::json alone = report(arguments), shared = report(arguments, on_ranks(2));
  for (const char* key : {"particles", "particle_center_error_m", "particle_inertia_error"})
    EXPECT_EQ(shared[key], alone[key]) << key;
  EXPECT_GT(alone["particles"], 0);
}

TEST_F(Worlds, RanksMayHaveNothingToDo) {
  const nlohmann::json shared = report("slide_to_roll --steps 20 --device reference", on_ranks(3));
  EXPECT_EQ(shared["ranks"], 3);
  EXPECT_EQ(shared["state_hash"], report("slide_to_roll --steps 20 --device reference")["state_hash"]);
}

TEST_F(Worlds, WhatGoesWrongIsToldOnce) {
  const Outcome missing = run_command(on_ranks(2) + LOCKSTEP_PROGRAM " run nothing_of_the_kind --worlds 4");
  EXPECT_EQ(missing.status, 2) << missing.err;
  const std::string line = "lockstep: nothing_of_the_kind: no such file";
  const std::size_t at = missing.err.find(line);
  ASSERT_NE(at, std::string::npos) << missing.err;
  EXPECT_EQ(missing.err.find(line, at + 1), std::string::npos) << missing.err;
}
#endif

}  // namespace
}  // namespace lockstep::worlds_cli_test
