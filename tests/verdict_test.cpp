// What is measured in every step against closed forms, and the verdict that a run comes to by it.
#include <gtest/gtest.h>

#include <bit>
#include <cmath>
#include <fstream>

#include "cpu_reference/measure.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/report/monitor.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"
#include "host/scene/verdict_bounds.hpp"
#include "host/simulation.hpp"
#include "include/lockstep/world.hpp"
#include "tests/command_line.hpp"

namespace lockstep::verdict_test {
namespace {

template <class real>
Simulation<real> simulation_of(const Scene& scene) {
  const InitialState<real> state = compile<real>(std::span(&scene, 1));
  return {std::make_unique<ReferenceBackend<real>>(state), state.params};
}

double maximum(const Counters& counters, u32 counter) { return std::bit_cast<float>(counters[counter]); }

template <class real>
double joules(const Simulation<real>& simulation, u32 counter) {
  const Counters& counters = simulation.counters();
  const std::uint64_t units = std::uint64_t{counters[counter + 1]} << 32 | counters[counter];
  return double(static_cast<std::int64_t>(units)) / double(simulation.params().units_per_joule);
}

// A step measures the state that it starts from: after so many steps of semi-implicit Euler v = n g dt, and the height
// is what these add up to.
TEST(StepMeasures, OfAFallingBallAreThoseOfTheClosedForm) {
  Scene scene = parse_scene(R"({"gravity": [0, 0, -10], "settings": {"dt": 0.01}, "bodies": [
    {"mass": 2, "position": [0, 0, 3], "angular_velocity": [0, 0, 5], "shapes": [{"type": "sphere", "radius": 0.5}]}]})",
                            "ball");
  Simulation<double> simulation = simulation_of<double>(scene);
  for (u32 n = 0; n < 50; ++n) {
    simulation.step();
    const double v = 10 * 0.01 * n, z = 3 - 10 * 0.01 * 0.01 * n * (n + 1) / 2;
    const double kinetic = 0.5 * 2 * v * v + 0.5 * (0.4 * 2 * 0.25) * 25;
    EXPECT_NEAR(maximum(simulation.counters(), COUNTER_MAX_SPEED), v, 1e-6 * v);
    EXPECT_NEAR(joules(simulation, COUNTER_KINETIC), kinetic, 1e-4);
    EXPECT_NEAR(joules(simulation, COUNTER_ENERGY), kinetic + 2 * 10 * z, 1e-4);
  }
}

TEST(StepMeasures, OfBallsThatOverlapAreTheDepthAndItsRatioToTheSmallerRadius) {
  Scene scene = parse_scene(R"({"gravity": [0, 0, 0], "bodies": [
    {"mass": 1, "position": [0, 0, 0], "shapes": [{"type": "sphere", "radius": 0.5}]},
    {"mass": 1, "position": [0.7, 0, 0], "shapes": [{"type": "sphere", "radius": 0.25}]}]})",
                            "balls");
  Simulation<double> simulation = simulation_of<double>(scene);
  simulation.step();
  EXPECT_NEAR(maximum(simulation.counters(), COUNTER_MAX_OVERLAP), 0.05, 1e-7);
  EXPECT_NEAR(maximum(simulation.counters(), COUNTER_MAX_OVERLAP_RATIO), 0.2, 1e-7);
}

// Of a box the inner radius is half its least edge; a plane has no inside.
TEST(StepMeasures, OfAPlateInAPlaneAreRatiosToHalfItsThickness) {
  Scene scene = parse_scene(R"({"gravity": [0, 0, 0], "bodies": [
    {"type": "static", "shapes": [{"type": "plane"}]},
    {"mass": 1, "position": [0, 0, 0.08], "shapes": [{"type": "box", "size": [2, 1, 0.2]}]}]})",
                            "plate");
  Simulation<float> simulation = simulation_of<float>(scene);
  simulation.step();
  EXPECT_NEAR(maximum(simulation.counters(), COUNTER_MAX_OVERLAP), 0.02, 1e-6);
  EXPECT_NEAR(maximum(simulation.counters(), COUNTER_MAX_OVERLAP_RATIO), 0.2, 1e-5);
}

// A ball joint whose anchors are made to stand 0.03 apart by moving one body.
TEST(StepMeasures, OfAnOpenJointAreTheGapAndItsRatioToTheArm) {
  const Scene scene = parse_scene(R"({"gravity": [0, 0, 0], "bodies": [
    {"name": "a", "mass": 1, "position": [0, 0, 0], "shapes": [{"type": "sphere", "radius": 0.1}]},
    {"name": "b", "mass": 1, "position": [1, 0, 0], "shapes": [{"type": "sphere", "radius": 0.1}]}],
    "joints": [{"type": "ball", "bodies": ["a", "b"], "anchor": [0.6, 0, 0]}]})",
                                  "pair");
  InitialState<double> state = compile<double>(std::span(&scene, 1));
  state.buffers.positions[1].y = 0.03;
  Simulation<double> simulation(std::make_unique<ReferenceBackend<double>>(state), state.params);
  simulation.step();
  EXPECT_NEAR(maximum(simulation.counters(), COUNTER_MAX_JOINT_SEPARATION), 0.03, 1e-7);
  EXPECT_NEAR(maximum(simulation.counters(), COUNTER_MAX_JOINT_SEPARATION_RATIO), 0.03 / 0.4, 1e-6)
      << "b's arm is the shorter";
}

// Sums of whole units wrap around and carry; in any order, and with any signs, they are those of 64 bits.
TEST(StepMeasures, AddEnergiesExactlyWhateverTheirSigns) {
  std::vector<u32> counters(COUNTER_COUNT);
  std::int64_t sum = 0;
  for (const std::int64_t units : {std::int64_t{1} << 45, -(std::int64_t{1} << 33) - 7, std::int64_t{0xffffffff},
                                   std::int64_t{-5}, std::int64_t{12}, -(std::int64_t{1} << 45)}) {
    reference::add_energy(counters, COUNTER_ENERGY, units);
    sum += units;
    const std::uint64_t words = std::uint64_t{counters[COUNTER_ENERGY + 1]} << 32 | counters[COUNTER_ENERGY];
    EXPECT_EQ(static_cast<std::int64_t>(words), sum);
  }
}

// ---- of a monitor -------------------------------------------------------------------------------------------------

Measures state(double kinetic, double potential) {
  Measures measures;
  measures.worlds.resize(1);
  measures.worlds[0].kinetic = kinetic;
  measures.worlds[0].potential = potential;
  return measures;
}

// As a step tells them, in units of a millijoule.
void tell(Monitor& monitor, double kinetic, double potential, double overlap, u32 step) {
  Counters counters = {};
  counters[COUNTER_MAX_OVERLAP_RATIO] = std::bit_cast<u32>(static_cast<float>(overlap));
  counters[COUNTER_ENERGY] = static_cast<u32>(1000 * (kinetic + potential));
  counters[COUNTER_KINETIC] = static_cast<u32>(1000 * kinetic);
  StepParams<double> params = {};
  params.units_per_joule = 1000;
  monitor.observe(counters, params, step);
}

TEST(Monitor, TellsTheFirstAndTheWorstStepAboveTheBound) {
  Monitor monitor(verdict_bounds({}), 0.1, {});
  const double overlaps[] = {0.1, 0.4, 0.6, 0.9, 0.7};
  for (u32 step = 0; step < 5; ++step) tell(monitor, 1, 0, overlaps[step], step);
  const Judgement& j = monitor.verdict()[Criterion::overlap];
  EXPECT_FALSE(monitor.verdict().good());
  EXPECT_EQ(j.first_step, 2u);
  EXPECT_EQ(j.worst_step, 3u);
  EXPECT_EQ(in_words(monitor.verdict()), "overlap 0.9 after 3 steps, above 0.5 since 2");
}

TEST(Monitor, BlamesNoRunForHowItBegan) {
  Monitor monitor(verdict_bounds({}), 0.1, {});
  tell(monitor, 0, 10, 0.8, 0);
  tell(monitor, 0, 30, 0.7, 1);
  tell(monitor, 0, 50, 0.3, 2);
  tell(monitor, 0, 60, 0, 3);
  EXPECT_TRUE(monitor.verdict().good()) << in_words(monitor.verdict());
  tell(monitor, 0, 60, 0.95, 4);
  EXPECT_FALSE(monitor.verdict().good());
}

TEST(Monitor, FindsEnergyThatComesFromNowhere) {
  Monitor monitor(verdict_bounds({}), 0.1, {});
  monitor.observe(state(100, 0), 0);
  monitor.observe(state(60, 10), 1);  // 30 are lost
  monitor.observe(state(70, 20), 2);  // 20 of 100 come back
  EXPECT_TRUE(monitor.verdict().good());
  monitor.observe(state(80, 20), 3);
  EXPECT_FALSE(monitor.verdict().good());
  EXPECT_NEAR(monitor.verdict()[Criterion::energy_gain].worst, 0.3, 1e-12);
}

TEST(Monitor, LetsMotorsGiveWhatTheyCan) {
  Monitor monitor(verdict_bounds({}), 0.1, {EnergySource::none, 100, false, 0});  // 10 J a step
  for (u32 step = 0; step < 5; ++step) monitor.observe(state(10 * step, 0), step);
  EXPECT_TRUE(monitor.verdict().good());
  monitor.observe(state(100, 0), 5);
  EXPECT_FALSE(monitor.verdict().good());
}

TEST(Monitor, DoesNotJudgeEnergyThatNobodyCounts) {
  Monitor monitor(verdict_bounds({}), 0.1, {EnergySource::kinematic_bodies, 0, false, 0});
  monitor.observe(state(1, 0), 0);
  monitor.observe(state(1e6, 0), 1);
  EXPECT_TRUE(monitor.verdict().good());
  EXPECT_EQ(in_words(monitor.verdict().energy_source), "kinematic bodies move");
}

// Of a spring a step tells the energy at one of its ends, and not in the middle: only what rises above the start is
// made.
TEST(Monitor, LetsSpringsSwing) {
  Monitor monitor(verdict_bounds({}), 0.1, {EnergySource::none, 0, true, 0});
  for (u32 step = 0; step < 6; ++step) monitor.observe(state(step % 2 == 0 ? 0 : 30, step % 2 == 0 ? 100 : 10), step);
  EXPECT_TRUE(monitor.verdict().good()) << in_words(monitor.verdict());
  monitor.observe(state(60, 50), 6);
  EXPECT_TRUE(monitor.verdict().good());
  monitor.observe(state(60, 70), 7);
  EXPECT_FALSE(monitor.verdict().good());
}

// ---- of runs ------------------------------------------------------------------------------------------------------

class Verdicts : public CommandLine {
 protected:
  std::string scene(const std::string& text) const {
    std::ofstream(file("scene.json")) << text;
    return file("scene.json").string();
  }
  Outcome simulate(const std::string& arguments) const {
    return run("run " + arguments + " --quiet --report " + file("report.json").string());
  }
  nlohmann::json report() const { return nlohmann::json::parse(read_file(file("report.json"))); }
};

// The explicit gyroscopic moment drives a book that tumbles, as Euler's explicit method drives every oscillation.
TEST_F(Verdicts, OfARunThatGainsEnergyIsBadAndItsStatusOne) {
  const std::string book = scene(R"({"gravity": [0, 0, 0], "bodies": [
    {"mass": 1, "angular_velocity": [0.1, 12, 0.1], "shapes": [{"type": "box", "size": [0.3, 0.2, 0.04]}]}],
    "settings": {"dt": 0.02, "steps": 400, "gyroscopic": "explicit"}})");
  const Outcome outcome = simulate(book + " --device reference");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("energy gain"), std::string::npos) << outcome.err;
  const nlohmann::json verdict = report()["verdict"];
  EXPECT_FALSE(verdict["good"]);
  EXPECT_GT(verdict["energy_gain"]["worst"], 0.25);
  EXPECT_LE(verdict["energy_gain"]["first_step"], verdict["energy_gain"]["worst_step"]);
}

// A tonne on a gram, by one sweep: it sinks through.
TEST_F(Verdicts, OfARunInWhichBodiesSinkIntoEachOtherIsBad) {
  const std::string pile = scene(R"({"settings": {"steps": 200, "iterations": 1}, "bodies": [
    {"type": "static", "shapes": [{"type": "plane"}]},
    {"mass": 0.001, "position": [0, 0, 0.1], "shapes": [{"type": "box", "size": [0.2, 0.2, 0.2]}]},
    {"mass": 1000, "position": [0, 0, 0.7], "shapes": [{"type": "box", "size": [1, 1, 1]}]}]})");
  const Outcome outcome = simulate(pile);
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("overlap"), std::string::npos) << outcome.err;
}

// A carriage that a load drags through the end of its slider.
TEST_F(Verdicts, OfARunThatLeavesTheLimitsOfAJointIsBad) {
  const std::string carriage = scene(R"({"settings": {"steps": 100, "iterations": 1}, "bodies": [
    {"name": "carriage", "mass": 0.1, "shapes": [{"type": "box", "size": [0.2, 0.2, 0.2]}]},
    {"name": "load", "mass": 1000, "position": [0, 0, -0.5], "shapes": [{"type": "box", "size": [0.2, 0.2, 0.2]}]}],
    "joints": [{"type": "slider", "bodies": ["world", "carriage"], "anchor": [0, 0, 0], "axis": [0, 0, 1], "limits": [-0.1, 0.1]},
      {"type": "ball", "bodies": ["carriage", "load"], "anchor": [0, 0, 0]}]})");
  const Outcome outcome = simulate(carriage + " --device reference");
  EXPECT_EQ(outcome.status, 1);
  EXPECT_NE(outcome.err.find("joint separation"), std::string::npos) << outcome.err;
}

// The textbook's oscillator: a soft joint takes the energy of the body up and gives it back.
TEST_F(Verdicts, OfASoftJointThatSwingsIsGood) {
  const std::string swing =
      scene(R"({"gravity": [0, 0, 0], "settings": {"dt": 0.001, "integrator": "trapezoidal", "steps": 600},
    "bodies": [{"name": "a", "mass": 1, "velocity": [0.3, 0, 0], "shapes": [{"type": "box", "size": [1, 1, 1]}]}],
    "joints": [{"type": "ball", "bodies": ["world", "a"], "anchor": [0, 0, 0], "frequency": 2, "damping": 0}]})");
  EXPECT_EQ(simulate(swing + " --device reference").status, 0);
  EXPECT_EQ(report()["verdict"]["not_judged_because"], "soft joints keep some");
}

// However deep it begins: pushed out, it rests.
TEST_F(Verdicts, OfACrateThatBeginsInTheGroundIsGood) {
  for (const char* height : {"0.4", "0.3", "0.2", "0.15"}) {
    const std::string crate = scene(std::string(R"({"settings": {"steps": 120}, "bodies": [
      {"type": "static", "shapes": [{"type": "plane"}]},
      {"mass": 1, "position": [0, 0, )") +
                                    height + R"(], "shapes": [{"type": "box", "size": [1, 1, 1]}]}]})");
    EXPECT_EQ(simulate(crate + " --device reference").status, 0) << height << report()["verdict"];
  }
}

TEST_F(Verdicts, AreJudgedByTheBoundsOfTheSettings) {
  EXPECT_EQ(simulate("incline").status, 0);
  const Outcome fast = simulate("incline --max-speed 1");
  EXPECT_EQ(fast.status, 1);
  EXPECT_NE(fast.err.find("speed"), std::string::npos) << fast.err;
  EXPECT_EQ(simulate("incline --max-speed 0").status, 2);
}

TEST_F(Verdicts, AreKeptByRecordings) {
  const std::string recording = file("run.h5").string();
  EXPECT_EQ(simulate("incline --steps 50 --max-speed 1 --record " + recording).status, 1);
  const Outcome verified = run("verify " + recording);
  EXPECT_EQ(verified.status, 0) << verified.err;
  EXPECT_NE(verified.out.find("the run was bad: speed"), std::string::npos) << verified.out;
}

TEST_F(Verdicts, AreToldOfWhatIsDrawn) {
  const Outcome drawn = run("export incline --steps 50 --max-speed 1 -o " + file("motion.glb").string());
  EXPECT_EQ(drawn.status, 0);
  EXPECT_NE(drawn.err.find("incline: speed"), std::string::npos) << drawn.err;
}

// ---- of worlds ----------------------------------------------------------------------------------------------------

TEST(WorldVerdict, IsOfAllStepsAndOfTheStateAsItIs) {
  Scene scene = read_scene("incline");
  scene.settings.max_speed = 1;
  World world(scene, {.device = "reference"});
  EXPECT_TRUE(world.verdict().good());
  world.step(100);
  EXPECT_FALSE(world.verdict().good());
  const Judgement speed = world.verdict()[Criterion::speed];
  EXPECT_EQ(speed.worst_step, 100u) << "it still slides faster";
  EXPECT_LT(speed.first_step, 100u);
}

TEST(WorldVerdict, CountsNoEnergyThatUsersGive) {
  World world(read_scene("slide_to_roll"), {.device = "reference"});
  for (const BodyHandle body : world.bodies()) {
    world.step(5);
    if (world.description(body).kind != BODY_DYNAMIC) continue;
    for (int push = 0; push < 5; ++push) {
      world.set_velocity(body, {{10.0 * push, 0, 0}, {0, 0, 0}});
      world.step(2);
    }
  }
  EXPECT_TRUE(world.verdict().good()) << in_words(world.verdict());
}

}  // namespace
}  // namespace lockstep::verdict_test
