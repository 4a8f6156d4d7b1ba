// From scenes to buffers: mass properties, poses and motions against closed forms, features, batches, and refusals.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"

namespace lockstep::scene_compile_test {
namespace {

Scene scene_of(const std::string& bodies, const std::string& more = "") {
  return parse_scene("{\"bodies\": [" + bodies + "]" + more + "}", "test.json");
}

InitialState<double> compiled(const std::string& bodies, const std::string& more = "") {
  return compile<double>(scene_of(bodies, more));
}

template <class real = float>
std::string refusal(const Scene& scene) {
  try {
    compile<real>(scene);
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::input);
    return error.what();
  }
  return "accepted";
}

const std::string ball = R"({"name": "ball", "mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]})";
const std::string ground = R"({"type": "static", "shapes": [{"type": "plane"}]})";
const std::string brick = R"({"mass": 1, "inertia": [1, 2, 3]})";
const std::string off_center_ball =
    R"({"mass": 1, "inertia": [1, 1, 1], "shapes": [{"type": "sphere", "radius": 1, "offset": [0, 0, 1]}]})";

bool has(const InitialState<double>& state, Feature feature) { return lockstep::has(state.features, feature); }

// ---- bodies --------------------------------------------------------------------------------------------------------

TEST(SceneCompile, ABallHasItsMassProperties) {
  const auto state = compiled(ball);
  const Mass<double>& mass = state.buffers.masses[0];
  EXPECT_EQ(mass.mass, 2);
  EXPECT_EQ(mass.inverse_mass, 0.5);
  for (unsigned i = 0; i < 3; ++i) {
    EXPECT_DOUBLE_EQ(mass.inertia[i], 0.2);
    EXPECT_DOUBLE_EQ(mass.inverse_inertia[i], 5);
  }
  EXPECT_EQ(state.buffers.body_infos[0].isotropic, 1u);
  const Motion<double>& motion = state.buffers.motions[0];
  EXPECT_EQ(motion.inverse_mass, 0.5);
  EXPECT_EQ(motion.inertia_xx, mass.inverse_inertia[0]);
  EXPECT_EQ(motion.inertia_xy, 0);
}

TEST(SceneCompile, InverseInertiaIsRotatedToTheWorld) {
  // a quarter turn about z swaps x and y
  const auto quarter =
      compiled(R"({"mass": 1, "inertia": [1, 2, 2.5], "orientation": {"axis": [0, 0, 1], "angle_deg": 90}})");
  const Motion<double>& m = quarter.buffers.motions[0];
  EXPECT_NEAR(m.inertia_xx, 1 / 2.0, 1e-15);
  EXPECT_NEAR(m.inertia_yy, 1, 1e-15);
  EXPECT_NEAR(m.inertia_zz, 1 / 2.5, 1e-15);
  EXPECT_NEAR(m.inertia_xy, 0, 1e-15);
  // 45 degrees about z: xx = yy = (1 + 1/2) / 2, xy = (1 - 1/2) / 2
  const auto eighth =
      compiled(R"({"mass": 1, "inertia": [1, 2, 2.5], "orientation": {"axis": [0, 0, 1], "angle_deg": 45}})");
  const Motion<double>& n = eighth.buffers.motions[0];
  EXPECT_NEAR(n.inertia_xx, 0.75, 1e-15);
  EXPECT_NEAR(n.inertia_yy, 0.75, 1e-15);
  EXPECT_NEAR(n.inertia_xy, 0.25, 1e-15);
  EXPECT_NEAR(n.inertia_xz, 0, 1e-15);
  EXPECT_NEAR(n.inertia_yz, 0, 1e-15);
}

TEST(SceneCompile, ImmovableBodiesHaveNoInverseMass) {
  const auto state = compiled(R"({"type": "static", "position": [1, 2, 3]},
                                 {"type": "kinematic", "velocity": [4, 5, 6], "angular_velocity": [0, 0, 7]})");
  for (unsigned body = 0; body < 2; ++body) {
    const Motion<double>& motion = state.buffers.motions[body];
    EXPECT_EQ(motion.inverse_mass, 0);
    EXPECT_EQ(motion.inertia_xx, 0);
    EXPECT_EQ(state.buffers.masses[body].inverse_mass, 0);
    EXPECT_EQ(state.buffers.masses[body].inverse_inertia[2], 0);
  }
  EXPECT_EQ(state.buffers.positions[0].z, 3);
  EXPECT_EQ(state.buffers.motions[1].v[1], 5);
  EXPECT_EQ(state.buffers.motions[1].w[2], 7);
}

TEST(SceneCompile, TheNullBodyBehindTheLastOneIsAllZero) {
  const auto state = compiled(ball + "," + ground);
  ASSERT_EQ(state.buffers.motions.size(), 3u);
  const Motion<double> zero = {};
  EXPECT_EQ(std::memcmp(&state.buffers.motions[2], &zero, sizeof zero), 0);
}

TEST(SceneCompile, APivotedBodyRotatesAboutItsPivot) {
  // 3 kg at 2 m along its y axis: 12 kg m^2 more about x and z; spinning about world x, the mass moves along z
  const auto state = compiled(
      R"({"mass": 3, "inertia": [0.5, 0.25, 0.5], "pivot": [1, 0, 0], "com_offset": [0, 2, 0],
          "angular_velocity": [5, 0, 0]})");
  const Mass<double>& mass = state.buffers.masses[0];
  EXPECT_EQ(mass.inertia[0], 12.5);
  EXPECT_EQ(mass.inertia[1], 0.25);
  EXPECT_EQ(mass.inertia[2], 12.5);
  const Pivot<double>& pivot = state.buffers.pivots[0];
  EXPECT_EQ(pivot.pivoted, 1);
  EXPECT_EQ(pivot.point_world[0], 1);
  EXPECT_EQ(pivot.point_world[1], 0);
  EXPECT_EQ(pivot.com_offset_body[1], 2);
  EXPECT_EQ(state.buffers.positions[0].y, 2);
  EXPECT_EQ(state.buffers.motions[0].v[2], 10);
  EXPECT_EQ(state.buffers.motions[0].inertia_xx, 1 / 12.5);
  EXPECT_EQ(state.buffers.body_infos[0].isotropic, 0u);
  EXPECT_TRUE(has(state, Feature::pivots));
}

// ---- shapes and materials
// --------------------------------------------------------------------------------------------

TEST(SceneCompile, ShapesKnowTheirBodyMaterialAndFrame) {
  const auto state = compiled(ball + R"(,{"type": "static", "shapes": [
                    {"type": "plane", "offset": [0, 0, -1], "normal": [0, 1, 0], "material": "ice", "category": "wall"},
                    {"type": "sphere", "radius": 3}]})",
                              R"(, "materials": [{"name": "wood"}, {"name": "ice"}])");
  const ShapeInfo& plane = state.buffers.shape_infos[1];
  EXPECT_EQ(plane.body, 1u);
  EXPECT_EQ(plane.id, 1u);
  EXPECT_EQ(plane.kind, u32{SHAPE_PLANE});
  EXPECT_EQ(plane.material, 1u);
  EXPECT_EQ(plane.category, 2u);
  EXPECT_EQ(plane.flags, 0u);
  EXPECT_EQ(state.buffers.shapes[1].offset[2], -1);
  EXPECT_EQ(state.buffers.shapes[1].rotation[0], -0.5);
  EXPECT_EQ(state.buffers.shape_infos[2].flags, u32{SHAPE_IS_CENTRAL});
  EXPECT_EQ(state.buffers.shapes[2].size[0], 3);
  ASSERT_EQ(state.buffers.planes.size(), 1u);
  EXPECT_EQ(state.buffers.planes[0], 1u);
}

// What is not asked for is not there; a trigger needs events, has no mass, and makes no contact general.
TEST(SceneCompile, EventsTriggersAndFastBodiesAreFeatures) {
  const auto plain = compiled(ground + ", " + ball);
  for (const Feature feature : {Feature::events, Feature::triggers, Feature::continuous, Feature::queries})
    EXPECT_FALSE(has(plain, feature));
  EXPECT_TRUE(plain.buffers.events.empty() && plain.buffers.touching.empty() && plain.buffers.rays.empty());
  EXPECT_TRUE(has(compiled(ground + ", " + ball, R"(, "settings": {"events": true})"), Feature::events));

  const std::string feeler = R"({"type": "sphere", "radius": 2, "offset": [1, 0, 0], "trigger": true})";
  const auto trigger =
      compiled(ball + R"(, {"mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}, )" + feeler + "]}");
  EXPECT_TRUE(has(trigger, Feature::triggers) && has(trigger, Feature::events));
  EXPECT_FALSE(has(trigger, Feature::general_contacts));
  EXPECT_EQ(trigger.buffers.masses[1].inertia[1], trigger.buffers.masses[0].inertia[1]);
  EXPECT_EQ(trigger.buffers.shape_infos[1].flags, u32{SHAPE_IS_CENTRAL});
  EXPECT_EQ(trigger.buffers.shape_infos[2].flags, u32{SHAPE_IS_TRIGGER});
  // triggers feel neither each other nor what is not dynamic
  const std::string still = R"({"type": "static", "shapes": [)" + feeler + "]}";
  EXPECT_FALSE(has(compiled(still + ", " + still + ", " + ground), Feature::contacts));

  const auto fast =
      compiled(ground + R"(, {"mass": 1, "continuous": true, "shapes": [{"type": "sphere", "radius": 1}]})");
  EXPECT_TRUE(has(fast, Feature::continuous));
  EXPECT_EQ(fast.buffers.shape_infos[1].flags, u32{SHAPE_IS_CENTRAL | SHAPE_IS_CONTINUOUS});
}

TEST(SceneCompile, MaterialsCombineUnlessARuleOverrides) {
  const auto state = compiled(ball + "," + ground, R"(, "materials": [
      {"name": "a", "friction": 0.2, "restitution": 0.1}, {"name": "b", "friction": 0.8, "restitution": 0.6},
      {"name": "c", "friction": 1, "restitution": 0}],
      "material_pairs": [{"materials": ["c", "a"], "friction": 0.3, "restitution": 0.9}])");
  const auto& pairs = state.buffers.material_pairs;
  ASSERT_EQ(pairs.size(), 9u);
  EXPECT_EQ(pairs[0].friction, 0.2);  // of two equal ones, to the bit
  EXPECT_DOUBLE_EQ(pairs[0 * 3 + 1].friction, 0.4);
  EXPECT_EQ(pairs[0 * 3 + 1].restitution, 0.6);
  for (const unsigned index : {0u * 3 + 2, 2u * 3 + 0}) {
    EXPECT_EQ(pairs[index].friction, 0.3);
    EXPECT_EQ(pairs[index].restitution, 0.9);
  }
  EXPECT_EQ(pairs[1 * 3 + 2].friction, pairs[2 * 3 + 1].friction);
}

// ---- features and parameters
// -----------------------------------------------------------------------------------------

TEST(SceneCompile, FeaturesFollowFromWhatTheSceneContains) {
  EXPECT_EQ(compiled(brick, R"(, "settings": {"gyroscopic": "none"})").features, u32(Feature::time_stepping));
  EXPECT_TRUE(has(compiled(brick), Feature::gyroscopic));
  EXPECT_FALSE(has(compiled(ball), Feature::gyroscopic));
  EXPECT_TRUE(has(compiled(brick, R"(, "settings": {"integrator": "runge_kutta"})"), Feature::runge_kutta));
  EXPECT_FALSE(has(compiled(brick, R"(, "settings": {"integrator": "runge_kutta"})"), Feature::time_stepping));
  EXPECT_TRUE(has(compiled(ball + "," + ground), Feature::contacts));
  EXPECT_FALSE(has(compiled(ball + "," + ground), Feature::general_contacts));
  EXPECT_FALSE(has(compiled(ball + "," + ground), Feature::jacobi));
  const std::string by_jacobi = R"(, "settings": {"solver": "jacobi"})";
  EXPECT_TRUE(has(compiled(ball + "," + ground, by_jacobi), Feature::jacobi));
  EXPECT_EQ(compiled(ball + "," + ground, by_jacobi).params.iterations, 30u);
  EXPECT_FALSE(has(compiled(ball, by_jacobi), Feature::jacobi));  // nothing can touch
  for (const bool accelerated : {false, true}) {
    const std::string name = accelerated ? "accelerated_gradient" : "gradient";
    const std::string settings = R"(, "settings": {"solver": ")" + name + "\"";
    const auto state = compiled(ball + "," + ground, settings + "}");
    EXPECT_TRUE(has(state.features, Feature::gradient));
    EXPECT_TRUE(has(state.features, Feature::jacobi));  // on copies of bodies, without colours
    EXPECT_EQ(state.params.iterations, accelerated ? 50u : 100u);
    ASSERT_EQ(state.buffers.gradient_laws.size(), 1u);
    EXPECT_EQ(state.buffers.gradient_laws[0].accelerated, accelerated ? 1u : 0u);
    EXPECT_FALSE(has(compiled(ball, settings + "}"), Feature::gradient));
    EXPECT_EQ(
        refusal(scene_of(ball + "," + ground, settings + R"(, "friction_model": "patches"})")),
        "test.json: /settings/friction_model: solvers along a gradient have a cone for each contact; leave patches "
        "out, or take gauss_seidel");
  }
  const std::string dense = R"(, "settings": {"solver": "dense_gauss_seidel")";
  EXPECT_TRUE(has(compiled(ball + "," + ground, dense + "}"), Feature::dense));
  EXPECT_TRUE(has(compiled(ball + "," + ground, dense + "}"), Feature::general_contacts));
  EXPECT_GT(compiled(ball + "," + ground, dense + "}").sizes.coupled_tiles, 0u);
  EXPECT_EQ(compiled(ball + "," + ground).sizes.coupled_tiles, 0u);
  EXPECT_FALSE(has(compiled(ball, dense + "}"), Feature::dense));  // nothing can touch
  EXPECT_EQ(refusal(scene_of(ball + "," + ground, dense + R"(, "friction_model": "patches"})")),
            "test.json: /settings/friction_model: dense_gauss_seidel has a cone for each contact; leave patches out, "
            "or take gauss_seidel");
  const std::string rubber = R"(, "materials": [{"name": "rubber", "friction": 1, "rolling_friction": 0.01}])";
  EXPECT_EQ(refusal(scene_of(ball + "," + ground, rubber + dense + "}")),
            "test.json: /settings/solver: dense_gauss_seidel knows round cones of slip alone, and materials of this "
            "scene have torsional, rolling or anisotropic friction; take gauss_seidel");
  EXPECT_TRUE(compiled(ball + "," + ground, by_jacobi).buffers.joint_side_starts.empty());
  EXPECT_TRUE(compiled(ball + "," + ground, by_jacobi).buffers.cell_sizes.empty());
  EXPECT_TRUE(has(compiled(off_center_ball + "," + ground), Feature::general_contacts));
  EXPECT_TRUE(
      has(compiled(R"({"mass": 1, "inertia": [1, 1, 1.5], "shapes": [{"type": "sphere", "radius": 1}]},)" + ground),
          Feature::general_contacts));
}

// Cells are six times as wide as the median of the bodies that can move.
TEST(SceneCompile, CellsAreAsLargeAsTheSceneOrItsBodiesSay) {
  const std::string settings = R"(, "settings": {"solver": "cell_gauss_seidel")";
  const std::string large = R"({"mass": 1, "shapes": [{"type": "sphere", "radius": 7}]})";
  const std::string small = R"({"mass": 1, "shapes": [{"type": "sphere", "radius": 0.125}]})";
  const std::string still = R"({"type": "kinematic", "shapes": [{"type": "sphere", "radius": 3}]})";
  const std::string bodies = ground + "," + small + "," + still + "," + small + "," + large + "," + small;
  const auto state = compiled(bodies, settings + "}");
  EXPECT_TRUE(has(state.features, Feature::partitions));
  ASSERT_EQ(state.buffers.cell_sizes.size(), 1u);
  EXPECT_EQ(state.buffers.cell_sizes[0], 1.5);
  const std::string brick_of_2 = R"({"mass": 1, "shapes": [{"type": "box", "size": [1, 2, 3]}]})";
  EXPECT_EQ(compiled(brick_of_2 + "," + ground, settings + "}").buffers.cell_sizes[0], 12);
  EXPECT_EQ(compiled(bodies, settings + R"(, "cell_size": 0.75})").buffers.cell_sizes[0], 0.75);
  EXPECT_FALSE(has(compiled(ball, settings + "}"), Feature::partitions));  // nothing can touch
  EXPECT_EQ(refusal(scene_of(bodies, settings + R"(, "sleeping": true})")),
            "test.json: /settings/sleeping: cell_gauss_seidel schedules all pairs of a cell together, and an island "
            "that sleeps would change the others; take gauss_seidel, jacobi or small_steps");
}

TEST(SceneCompile, UnequalSizesAreSearchedInATree) {
  const auto many = [](const std::string& radius) {
    return R"({"generator": "grid", "counts": [10, 10, 6], "spacing": [2, 2, 2],
        "bodies": [{"mass": 1, "shapes": [{"type": "sphere", "radius": )" +
           radius + "}]}]}";
  };
  const auto with_tree = [](const std::string& bodies, const std::string& settings) {
    const Features features = compiled(bodies, R"(, "settings": {)" + settings + "}").features;
    EXPECT_EQ(has(features, Feature::grid) + has(features, Feature::bvh) + has(features, Feature::all_pairs), 1);
    return has(features, Feature::bvh);
  };
  const std::string large = R"(,{"mass": 1, "position": [0, 0, 50], "shapes": [{"type": "sphere", "radius": 5}]})";
  const std::string fast =
      R"(,{"mass": 1, "position": [0, 0, 50], "velocity": [900, 0, 0], "shapes": [{"type": "sphere", "radius": 1}]})";
  EXPECT_FALSE(with_tree(many("1"), ""));
  EXPECT_TRUE(with_tree(many("1") + large, ""));
  EXPECT_TRUE(with_tree(many("1") + fast, ""));
  EXPECT_FALSE(with_tree(many("2") + large, ""));
  EXPECT_FALSE(with_tree(ball + large, ""));  // few
  EXPECT_TRUE(has(compiled(ball + large).features, Feature::all_pairs));
  EXPECT_TRUE(has(compiled(ball + large, R"(, "settings": {"broad_phase": "grid"})").features, Feature::grid));
  EXPECT_FALSE(with_tree(many("1") + large, R"("broad_phase": "grid")"));
  EXPECT_TRUE(with_tree(ball + large, R"("broad_phase": "bvh")"));
  EXPECT_FALSE(has(compiled(ball).features, Feature::all_pairs));  // nothing can touch
}

TEST(SceneCompile, ContactsNeedTwoShapesThatCanTouch) {
  const auto touching = [](const std::string& bodies) { return has(compiled(bodies), Feature::contacts); };
  EXPECT_FALSE(touching(ball));                   // alone
  EXPECT_FALSE(touching(ground + "," + ground));  // nothing moves
  EXPECT_FALSE(touching(off_center_ball));        // shapes of one body
  EXPECT_FALSE(touching(R"({"mass": 1, "inertia": [1, 1, 1], "shapes": [
      {"type": "sphere", "radius": 1, "offset": [1, 0, 0]}, {"type": "sphere", "radius": 1, "offset": [-1, 0, 0]}]})"));
  EXPECT_TRUE(touching(ball + R"(,{"mass": 1, "shapes": [{"type": "sphere", "radius": 1}]})"));
  const std::string shy =
      R"({"mass": 1, "shapes": [{"type": "sphere", "radius": 1, "category": "shy", "collides_with": ["shy"]}]})";
  EXPECT_FALSE(touching(shy + "," + ground));
  EXPECT_TRUE(touching(shy + "," + shy));
}

TEST(SceneCompile, ShapesThatNeverTouchAreNotSimulated) {
  const auto state = compiled(ball);
  EXPECT_EQ(state.sizes.shapes, 0u);
  EXPECT_EQ(state.params.shapes, 0u);
  EXPECT_TRUE(state.buffers.shapes.empty());
  EXPECT_TRUE(state.buffers.material_pairs.empty());
}

TEST(SceneCompile, ParametersFollowTheSettings) {
  const auto params = [](const std::string& settings) {
    return compile<float>(scene_of(brick, ", \"settings\": {" + settings + "}")).params;
  };
  EXPECT_EQ(params(R"("integrator": "explicit_euler")").theta, 0);
  EXPECT_EQ(params(R"("integrator": "trapezoidal")").theta, 0.5);
  EXPECT_EQ(params(R"("integrator": "semi_implicit_euler")").theta, 1);
  EXPECT_EQ(params(R"("gyroscopic": "explicit")").gyroscopic_theta, 0);
  EXPECT_EQ(params(R"("gyroscopic": "midpoint")").gyroscopic_theta, 0.5);
  EXPECT_EQ(params(R"("gyroscopic": "implicit")").gyroscopic_theta, 1);
  EXPECT_EQ(params(R"("gyroscopic": "implicit")").gyroscopic, 1u);
  EXPECT_EQ(params(R"("gyroscopic": "none")").gyroscopic, 0u);
  EXPECT_EQ(params(R"("dt": 0.01, "substeps": 3)").dt, static_cast<float>(0.01 / 3));
  EXPECT_EQ(params(R"("dt": 0.01, "substeps": 3)").substeps, 3u);
  EXPECT_EQ(params(R"("iterations": 17)").iterations, 17u);
  EXPECT_EQ(params(R"("relaxations": 3)").relaxations, 3u);
}

TEST(SceneCompile, BuffersHaveTheirCapacities) {
  const auto state =
      compiled(R"({"generator": "line", "count": 100, "step": [2, 0, 0], "bodies": [)" + ball + "]}," + ground,
               R"(, "settings": {"broad_phase": "grid"})");
  EXPECT_EQ(state.sizes.buckets, 256u);  // the power of two from 2 x 101 shapes on
  EXPECT_EQ(state.params.buckets, 256u);
  EXPECT_EQ(state.buffers.bucket_starts.size(), 257u);
  EXPECT_EQ(state.buffers.pairs.size(), state.params.pair_capacity);
  EXPECT_GE(state.params.block_capacity * PACK, state.params.contact_capacity);
  EXPECT_EQ(state.buffers.positions.size(), 101u);
  EXPECT_EQ(state.buffers.cached_keys.size(), state.sizes.contacts);
}

// ---- batches -------------------------------------------------------------------------------------------------------

// Element `first` and on of a batch against all of a lone compile.
template <class Element>
void expect_equal_range(const std::vector<Element>& batch, std::size_t first, const std::vector<Element>& lone,
                        std::size_t count) {
  ASSERT_LE(first + count, batch.size());
  EXPECT_EQ(std::memcmp(&batch[first], lone.data(), count * sizeof(Element)), 0);
}

TEST(SceneCompile, AWorldOfABatchHasItsLoneRecords) {
  const std::vector<Scene> worlds = {read_scene("ghosts"), read_scene("dumbbells"), read_scene("ghosts")};
  const auto batch = compile<float>(worlds);
  ASSERT_EQ(batch.sizes.worlds, 3u);
  for (u32 w = 0; w < 3; ++w) {
    const auto lone = compile<float>(worlds[w]);
    const WorldRange& range = batch.buffers.world_ranges[w];
    EXPECT_EQ(range.body_count, lone.sizes.bodies);
    EXPECT_EQ(range.shape_count, lone.sizes.shapes);
    EXPECT_EQ(range.plane_count, lone.sizes.planes);
    expect_equal_range(batch.buffers.masses, range.first_body, lone.buffers.masses, range.body_count);
    expect_equal_range(batch.buffers.positions, range.first_body, lone.buffers.positions, range.body_count);
    expect_equal_range(batch.buffers.orientations, range.first_body, lone.buffers.orientations, range.body_count);
    expect_equal_range(batch.buffers.motions, range.first_body, lone.buffers.motions, range.body_count);
    expect_equal_range(batch.buffers.shapes, range.first_shape, lone.buffers.shapes, range.shape_count);
    expect_equal_range(batch.buffers.material_pairs, range.first_material_pair, lone.buffers.material_pairs,
                       range.material_count * range.material_count);
    expect_equal_range(batch.buffers.gravities, w, lone.buffers.gravities, 1);
    for (u32 i = 0; i < range.body_count; ++i) {
      EXPECT_EQ(batch.buffers.body_infos[range.first_body + i].world, w);
      EXPECT_EQ(batch.buffers.body_infos[range.first_body + i].id, lone.buffers.body_infos[i].id);
    }
    for (u32 i = 0; i < range.shape_count; ++i) {
      ShapeInfo info = batch.buffers.shape_infos[range.first_shape + i];
      info.body -= range.first_body;
      EXPECT_EQ(std::memcmp(&info, &lone.buffers.shape_infos[i], sizeof info), 0);
    }
    for (u32 i = 0; i < range.plane_count; ++i) {
      EXPECT_EQ(batch.buffers.planes[range.first_plane + i] - range.first_shape, lone.buffers.planes[i]);
    }
  }
}

// ---- refusals ------------------------------------------------------------------------------------------------------

TEST(SceneCompile, RungeKuttaIsForBodiesThatCannotTouch) {
  EXPECT_EQ(
      refusal(scene_of(ball + "," + ground, R"(, "settings": {"integrator": "runge_kutta"})")),
      "test.json: /settings/integrator: runge_kutta is for bodies that cannot touch, and shapes of this scene can; "
      "use trapezoidal");
  EXPECT_EQ(refusal(scene_of(ball, R"(, "settings": {"integrator": "runge_kutta"})")), "accepted");
}

// Of two laws the later in the order of ImpactLaw holds, of tangential restitutions the larger, and rules override
// both.
TEST(SceneCompile, LawsOfImpactCombine) {
  const std::string bodies = ball + "," + ground;
  const InitialState<double> state = compile<double>(scene_of(bodies, R"(, "materials": [
      {"name": "a"}, {"name": "b", "impact_law": "stronge"},
      {"name": "c", "impact_law": "chatterjee_ruina", "tangential_restitution": -0.5}],
      "material_pairs": [{"materials": ["c", "a"], "friction": 1, "restitution": 0, "impact_law": "poisson"},
                         {"materials": ["c", "b"], "friction": 1, "restitution": 0, "tangential_restitution": 0.25}])"));
  EXPECT_TRUE(has(state.features, Feature::impact_laws));
  const u32 laws[] = {IMPACT_NEWTON,  IMPACT_STRONGE,          IMPACT_POISSON,
                      IMPACT_STRONGE, IMPACT_STRONGE,          IMPACT_CHATTERJEE_RUINA,
                      IMPACT_POISSON, IMPACT_CHATTERJEE_RUINA, IMPACT_CHATTERJEE_RUINA};
  const double tangential[] = {0, 0, 0, 0, 0, 0.25, 0, 0.25, -0.5};
  ASSERT_EQ(state.buffers.impact_pairs.size(), std::size(laws));
  for (std::size_t k = 0; k < std::size(laws); ++k) {
    EXPECT_EQ(state.buffers.impact_pairs[k].law, laws[k]) << k;
    EXPECT_EQ(state.buffers.impact_pairs[k].tangential_restitution, tangential[k]) << k;
  }
  const InitialState<double> plain = compile<double>(scene_of(bodies));
  EXPECT_FALSE(has(plain.features, Feature::impact_laws));
  EXPECT_TRUE(plain.buffers.impact_pairs.empty());
}

TEST(SceneCompile, PatchesKnowNewtonsLawAlone) {
  EXPECT_EQ(
      refusal(scene_of(ball + "," + ground, R"(, "settings": {"friction_model": "patches"},
                             "materials": [{"name": "a", "impact_law": "poisson"}])")),
      "test.json: /settings/friction_model: patches know Newton's law of impact alone, and materials of this scene "
      "have another; use cones");
}

TEST(SceneCompile, NumbersThatThePrecisionCannotRepresentAreRefused) {
  const std::string far = R"({"name": "far", "type": "static", "position": [0, 1e39, 0]})";
  EXPECT_EQ(refusal(scene_of(far)), "test.json: body 0 (\"far\"): position must fit float, is 1e+39");
  EXPECT_EQ(refusal<double>(scene_of(far)), "accepted");
  const std::string light = R"({"mass": 1e-40, "inertia": [1, 1, 1]})";
  EXPECT_EQ(refusal(scene_of(light)), "test.json: body 0: mass and its inverse must fit float, is 1e-40");
  EXPECT_EQ(refusal(scene_of(brick, R"(, "settings": {"dt": 1e-300})")),
            "test.json: dt / substeps and its inverse must fit float, is 1e-300");
  EXPECT_EQ(refusal(scene_of(brick, R"(, "gravity": [0, 0, -1e300])")),
            "test.json: gravity must fit float, is -1e+300");
  const auto sprung = [](const std::string& stiffness) {
    return scene_of(R"({"name": "a", "mass": 1, "inertia": [1, 2, 3]})",
                    R"(, "joints": [{"type": "slider", "bodies": ["world", "a"], "anchor": [0, 0, 0],
                                     "axis": [0, 0, 1], "spring": {"stiffness": )" +
                        stiffness + "}}]");
  };
  EXPECT_EQ(refusal(sprung("1e30")), "accepted");
  EXPECT_EQ(refusal<double>(sprung("1e60")), "accepted");
  EXPECT_EQ(refusal(sprung("1e60")),
            "test.json: joint 0: dt (dt stiffness + damping) of a spring must fit float, is 2.777777777777778e+56");
  // finite in the file, no longer so after the arithmetic
  EXPECT_EQ(refusal<double>(scene_of(R"({"density": 1e300, "shapes": [{"type": "sphere", "radius": 1e100}]})")),
            "test.json: body 0: mass must fit double, is inf");
  EXPECT_EQ(refusal<double>(scene_of(R"({"type": "kinematic", "orientation": {"axis": [1, 0, 0], "angle_deg": 90},
                                         "angular_velocity_body": [0, 1.7e308, 1.7e308]})")),
            "test.json: body 0: angular velocity must fit double, is not a number");
}

TEST(SceneCompile, ABatchNeedsAWorld) { EXPECT_THROW(compile<float>(std::span<const Scene>()), Error); }

}  // namespace
}  // namespace lockstep::scene_compile_test
