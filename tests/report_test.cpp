// The measures of docs/reference/error_measures.md on states small enough to be measured by hand.
#include "host/report/report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "host/backends/reference_backend.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep::report_test {
namespace {

using Eigen::Vector3d;

// One ball of radius 0.5 at height `z` over the plane z = 0, in contact, with its impulse in lane 3 of the second
// block.
Buffers<double> ball_on_plane(double z) {
  Buffers<double> b;
  b.world_ranges = {{0, 2, 0, 2, 0, 1, 0, 1}};
  b.gravities = {{0, 0, -10, 0}};
  b.body_infos = {{0, 7, BODY_DYNAMIC, 1}, {0, 9, BODY_STATIC, 1}};
  b.masses = {{2, 0.5, {0.2, 0.2, 0.2}, {5, 5, 5}}, {}};
  b.positions = {{1, 2, z, 0}, {0, 0, 0, 0}};
  b.orientations = {{0, 0, 0, 1}, {0, 0, 0, 1}};
  b.motions.resize(3);
  b.motions[0].inverse_mass = 0.5;
  b.motions[0].inertia_xx = b.motions[0].inertia_yy = b.motions[0].inertia_zz = 5;
  b.motions[0].v[2] = 0.25;
  b.shape_infos = {{0, 3, SHAPE_SPHERE, 0, 1, 1, 1, 0}, {1, 4, SHAPE_PLANE, 0, 1, 1, 1, 0}};
  b.shapes = {{{0, 0, 0}, 0.5, {0, 0, 0, 1}, {0.5, 0, 0, 0}}, {{0, 0, 0}, 0, {0, 0, 0, 1}, {0, 0, 0, 0}}};
  b.contacts = {{0, 1, 0, 0, 1, 0, 0, NORMAL_OF_B}};
  b.contact_points = {{{0, 0, 0}, 0.5, {0, 0, 0}, 0, {0, 0, 1, 0}}};
  b.contact_slots = {PACK + 3};
  b.contact_blocks.resize(2);
  ContactBlock<double>& block = b.contact_blocks[1];
  block.normal_z[3] = 1;
  block.arm_a_z[3] = -0.5;
  block.bias[3] = -0.25;
  block.friction[3] = 0.5;
  b.cached_impulses = {{1.5, 0, 0, 0}};
  return b;
}

constexpr Features ball_features =
    static_cast<Features>(Feature::contacts) | static_cast<Features>(Feature::time_stepping);
constexpr Sizes ball_sizes = {.worlds = 1,
                              .bodies = 2,
                              .shapes = 2,
                              .planes = 1,
                              .material_pairs = 1,
                              .buckets = 4,
                              .pairs = 4,
                              .contacts = 4,
                              .blocks = 4};

std::vector<u32> one_contact() {
  std::vector<u32> counters(COUNTER_COUNT);
  counters[COUNTER_CONTACTS] = 1;
  return counters;
}

TEST(Measures, ReadTheContactOfABallOnAPlane) {
  const Measures m = measure(ball_on_plane(0.49), ball_sizes, ball_features, {}, one_contact());
  EXPECT_NEAR(m.penetration.max, 0.01, 1e-15);
  EXPECT_NEAR(m.penetration.mean, 0.01, 1e-15);
  EXPECT_EQ(m.penetration.touching, 1u);
  ASSERT_TRUE(m.residual);
  EXPECT_NEAR(m.residual->defect_max, 0, 1e-15) << "leaves at just the bias";
  EXPECT_NEAR(m.residual->scale, 0.75, 1e-15) << "q = u - W r = 0 - 1.5 / 2";
  ASSERT_TRUE(m.worst);
  EXPECT_EQ(m.worst->body_a, 7u);
  EXPECT_EQ(m.worst->shape_b, 4u);
}

// From the buffers of a real step: more iterations bring the residual down to rounding, few do not.
TEST(Measures, ResidualOfAStackFallsWithIterations) {
  Scene scene = read_scene("sphere_stack");
  const auto residual_after = [&](u32 iterations) {
    scene.settings.iterations = iterations;
    const InitialState<double> state = compile<double>(scene);
    Simulation<double> simulation(std::make_unique<ReferenceBackend<double>>(state), state.params);
    for (int i = 0; i < 3; ++i) simulation.step();
    Backend<double>& backend = simulation.backend();
    const Buffers<double>& buffers = backend.download(measured_buffers(backend.features()));
    const Measures m = measure(buffers, backend.sizes(), backend.features(), state.params, simulation.counters());
    EXPECT_EQ(m.contacts, 10u);
    return m.residual ? m.residual->relative : 1;
  };
  EXPECT_GT(residual_after(2), 1e-2);
  EXPECT_LT(residual_after(1000), 1e-14);
}

TEST(Measures, DoNotCountAGapAsPenetration) {
  const Measures m = measure(ball_on_plane(0.51), ball_sizes, ball_features, {}, one_contact());
  EXPECT_EQ(m.penetration.touching, 0u);
  EXPECT_EQ(m.penetration.max, 0);
}

TEST(Measures, MechanicsOfARotatingBall) {
  Buffers<double> b = ball_on_plane(3);
  b.motions[0].w[0] = 4;
  const Measures m = measure(b, ball_sizes, ball_features, {}, std::vector<u32>(COUNTER_COUNT));
  ASSERT_EQ(m.worlds.size(), 1u);
  EXPECT_DOUBLE_EQ(m.worlds[0].kinetic, 0.5 * 2 * 0.0625 + 0.5 * 0.2 * 16);
  EXPECT_DOUBLE_EQ(m.worlds[0].potential, 2 * 10 * 3);
  EXPECT_DOUBLE_EQ(m.worlds[0].momentum.z(), 0.5);
  EXPECT_DOUBLE_EQ(m.worlds[0].angular_momentum.x(), 0.8);
  EXPECT_DOUBLE_EQ(m.worlds[0].weight.z(), -20);
  EXPECT_FALSE(m.residual);
  EXPECT_FALSE(momentum_is_conserved(b, ball_features)) << "the plane is fixed";
}

TEST(Measures, AngularMomentumIncludesTheOrbit) {
  Buffers<double> b = ball_on_plane(0);
  b.body_infos[1].kind = BODY_DYNAMIC;
  b.masses[1] = b.masses[0];
  b.positions = {{1, 0, 0, 0}, {-1, 0, 0, 0}};
  b.motions[0].v[1] = 3;
  b.motions[0].v[2] = 0;
  b.motions[1].v[1] = -3;
  const Measures m = measure(b, ball_sizes, ball_features, {}, std::vector<u32>(COUNTER_COUNT));
  EXPECT_DOUBLE_EQ(m.worlds[0].momentum.norm(), 0);
  EXPECT_DOUBLE_EQ(m.worlds[0].angular_momentum.z(), 2 * 2 * 3);
}

TEST(Measures, APivotedBodyRotatesAboutItsPivot) {
  Buffers<double> b = ball_on_plane(0);
  b.pivots.resize(2);
  b.pivots[0] = {{1, 2, 1}, 1, {0, 0, -1}, 0};  // hangs one metre below, moments about the pivot
  b.masses[0].inertia[0] = 2.2;
  b.motions[0] = {};
  b.motions[0].w[0] = 3;
  b.motions[0].v[1] = 3;  // w x com_offset
  const Features features = with(ball_features, Feature::pivots);
  const Measures m = measure(b, ball_sizes, features, {}, std::vector<u32>(COUNTER_COUNT));
  EXPECT_DOUBLE_EQ(m.worlds[0].kinetic, 0.5 * 2.2 * 9);
  ASSERT_TRUE(m.pivot_drift);
  EXPECT_NEAR(*m.pivot_drift, 0, 1e-15);
  b.positions[0].z = 0.125;
  EXPECT_NEAR(*measure(b, ball_sizes, features, {}, std::vector<u32>(COUNTER_COUNT)).pivot_drift, 0.125, 1e-15);
}

Measures moving(double momentum, double kinetic, double potential) {
  Measures m;
  WorldMeasures world;
  world.mass = 1;
  world.kinetic = kinetic;
  world.potential = potential;
  world.momentum = Vector3d(0, 0, momentum);
  world.momentum_size = std::abs(momentum);
  world.weight = Vector3d(0, 0, -10);
  m.worlds = {world};
  return m;
}

TEST(Recorder, MomentumErrorAllowsForGravity) {
  Recorder recorder(moving(4, 8, 0), true, true);
  recorder.observe(1, 0.1, moving(3, 4.5, 3.5));     // exact
  recorder.observe(2, 0.2, moving(2.04, 2.1, 6.0));  // 0.04 too much, 0.1 J too much
  Report report;
  recorder.finish(report);
  ASSERT_TRUE(report.momentum_error && report.energy_error);
  EXPECT_NEAR(*report.momentum_error, 0.04 / 4, 1e-12);
  EXPECT_NEAR(*report.energy_error, 0.1 / 8, 1e-12);
  EXPECT_DOUBLE_EQ(report.energy_initial_j, 8);
  EXPECT_DOUBLE_EQ(report.energy_final_j, 8.1);
}

TEST(Recorder, FiguresThatDoNotApplyAreEmpty) {
  const Recorder recorder(moving(4, 8, 0), false, false);
  Report report;
  recorder.finish(report);
  EXPECT_FALSE(report.momentum_error || report.energy_error || report.residual_median || report.joint_drift_max_m);
}

TEST(Recorder, SpeedLeavesTheFirstStepOut) {
  Recorder recorder(moving(0, 0, 0), false, false);
  recorder.time(500, 3);
  for (int i = 1; i <= 100; ++i) recorder.time(i, 10 + static_cast<u32>(i));
  Report report;
  recorder.finish(report);
  EXPECT_EQ(report.ms_first_step, 500);
  EXPECT_EQ(report.ms_per_step_median, 50);
  EXPECT_EQ(report.ms_per_step_p99, 99);
  EXPECT_EQ(report.ms_total, 500 + 5050);
  EXPECT_EQ(report.contacts_max, 110u);
}

TEST(Recorder, SweepsAreThoseThatWereTold) {
  Recorder recorder(moving(0, 0, 0), false, false);
  Report report;
  for (const u32 sweeps : {3u, 9u, 4u}) {
    recorder.time(1, 0);
    recorder.finish(report);
    EXPECT_EQ(report.sweeps_max.has_value(), sweeps != 3u);
    recorder.sweeps(sweeps);
  }
  recorder.finish(report);
  EXPECT_EQ(report.sweeps_median, 4);
  EXPECT_EQ(report.sweeps_max, 9);
}

TEST(Recorder, ContactFiguresAreTheLargestAndTheMedian) {
  Recorder recorder(moving(0, 0, 0), false, false);
  for (const double scale : {1.0, 3.0, 2.0}) {
    Measures m = moving(0, 0, 0);
    m.penetration = {0.01 * scale, 0.001 * scale, 2};
    m.residual = Residual{0.1 * scale, 5 * scale, scale, 0, 1, 1e-7, 0};
    m.worst = WorstContact{0, static_cast<u32>(scale), 0, 0, 0};
    recorder.observe(static_cast<u32>(10 * scale), scale, m);
  }
  Report report;
  recorder.finish(report);
  EXPECT_DOUBLE_EQ(report.max_penetration_m, 0.03);
  EXPECT_DOUBLE_EQ(report.mean_penetration_m, 0.002);
  EXPECT_DOUBLE_EQ(*report.residual_median, 0.2);
  EXPECT_DOUBLE_EQ(*report.residual_max, 0.3);
  EXPECT_EQ(report.worst_step, 30u);
  EXPECT_EQ(report.worst->body_a, 3u);
}

TEST(ReportFile, HasTheDocumentedKeys) {
  Report report;
  report.state_hash = 0xabc;
  report.stage_ms = {{"collide", 0.5}};
  const nlohmann::json json = nlohmann::json::parse(to_json(report));
  for (const char* key : {"scene",
                          "device",
                          "precision",
                          "solver",
                          "bodies",
                          "steps",
                          "dt",
                          "substeps",
                          "contacts_max",
                          "ms_per_step_median",
                          "ms_per_step_p99",
                          "ms_total",
                          "sweeps_median",
                          "sweeps_max",
                          "stage_ms",
                          "steps_by_plan",
                          "max_penetration_m",
                          "mean_penetration_m",
                          "residual_median",
                          "residual_max",
                          "joint_drift_max_m",
                          "energy_initial_j",
                          "energy_final_j",
                          "momentum_error",
                          "model_error",
                          "residual_floor",
                          "state_hash",
                          "pose_hash"})
    EXPECT_TRUE(json.contains(key)) << key;
  EXPECT_TRUE(json["model_error"].is_null());
  EXPECT_EQ(json["state_hash"], "0000000000000abc");
  EXPECT_EQ(json["stage_ms"]["collide"], 0.5);
}

TEST(Hashes, OfWorldsCombineInOrder) {
  const WorldHash one = {1, 2, 3, 4}, two = {5, 6, 7, 8};
  const WorldHash lone[] = {one}, forward[] = {one, two}, backward[] = {two, one};
  EXPECT_EQ(combined_state_hash(lone), 0x0000000200000001u);
  EXPECT_EQ(combined_pose_hash(lone), 0x0000000400000003u);
  EXPECT_NE(combined_state_hash(forward), combined_state_hash(backward));
  EXPECT_NE(combined_pose_hash(forward), combined_state_hash(forward));
}

}  // namespace
}  // namespace lockstep::report_test
