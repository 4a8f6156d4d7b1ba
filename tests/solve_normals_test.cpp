// The normals of a pair together: the complementarity problem against all its sets one by one, stages against their
// kernels, and what comes down flat.
#include "cpu_reference/solve_normals.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/cases/trial.hpp"
#include "host/scene/read.hpp"
#include "tests/contact_scene.hpp"

namespace lockstep::test::solve_normals_test {
namespace {

template <class real>
class SolveNormals : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SolveNormals, Precisions);

// ---- twins ----------------------------------------------------------------------------------------------------------

/// A heap of boxes and spheres that overlap, in motion, with impulses to start from: pairs of one to four points.
template <class real>
InitialState<real> coupled_pile(bool soft) {
  Random random(31);
  InitialState<real> state = make_worlds<real>({overlapping_bodies(random)}, 4096);
  state.features = with(with(state.features, Feature::coupled_normals), Feature::general_contacts);
  if (soft) {
    state.features = with(state.features, Feature::soft_contacts);
    state.params.softness = real(0.3);
  }
  resize(state.buffers, state.sizes, state.features);
  set_material(state, 0.4, 0.3);
  state.params.theta = 1;
  return started(state);
}

TYPED_TEST(SolveNormals, KernelMatchesReference) {
  using real = TypeParam;
  for (const bool soft : {false, true}) {
    InitialState<real> state = coupled_pile<real>(soft);
    u32 several = 0;
    for (const BlockBodies& block : state.buffers.block_bodies)
      for (const u32 count : block.count) several += count > 1 ? 1 : 0;
    EXPECT_GT(several, 50u);
    run_twins(Stage::prepare_contacts, state);
    run_twins(Stage::solve_constraints, state);
    if (soft) run_twins(Stage::relax_constraints, state);
  }
}

// ---- the problem ----------------------------------------------------------------------------------------------------

template <class real>
struct Problem {
  reference::NormalMatrix<real> a;
  reference::PerPoint<real> q;
};

/// The points of a face, at corners of a rectangle or nearly, seen from a body with a mass and an inertia: rank three,
/// and the proximal term.
template <class real>
Problem<real> face(Random& random) {
  const double x = random.between(0.1, 2), y = random.between(0.1, 2), off = random.bits() % 2 == 0 ? 0 : 0.3;
  double at[4][2] = {{-x, -y}, {x, -y}, {x, y}, {-x, y}};
  for (auto& corner : at)
    for (double& c : corner) c += random.between(-off, off);
  const double i_x = random.between(0.3, 10), i_y = random.between(0.3, 10), eps = reference::normal_proximity<real>;
  const auto g = [&](int i, int j) { return 1 + i_x * at[i][0] * at[j][0] + i_y * at[i][1] * at[j][1]; };
  Problem<real> p;
  for (int i = 0; i < 4; ++i) {
    p.a.diagonal[i] = real((1 + eps) * g(i, i));
    p.q[i] = real(random.between(-3, 1));
  }
  p.a.w_01 = real(g(0, 1)), p.a.w_02 = real(g(0, 2)), p.a.w_03 = real(g(0, 3));
  p.a.w_12 = real(g(1, 2)), p.a.w_13 = real(g(1, 3)), p.a.w_23 = real(g(2, 3));
  return p;
}

TYPED_TEST(SolveNormals, OfAFaceAreComplementary) {
  using real = TypeParam;
  Random random(4);
  const double rounding = sizeof(real) == 4 ? 2e-4 : 1e-9;
  for (int n = 0; n < 20000; ++n) {
    const Problem<real> p = face<real>(random);
    std::array<bool, MANIFOLD_POINTS> presses;
    for (bool& x : presses) x = random.bits() % 2 == 0;
    std::optional<reference::NormalFactor<real>> factor;
    const auto r = reference::solve_normal_problem(p.a, p.q, presses, factor);
    auto u = reference::times(p.a, r);
    for (u32 i = 0; i < MANIFOLD_POINTS; ++i) {
      const double residual = double(u[i]) + p.q[i];
      EXPECT_GE(r[i], 0) << n;
      EXPECT_GT(residual, -4 * rounding) << n;
      EXPECT_TRUE(!(r[i] > 0) || residual < 4 * rounding) << n << " " << i << " r " << r[i];
    }
  }
}

// ---- what comes down flat -------------------------------------------------------------------------------------------

struct Run {
  Solver solver;
  const char* precision;
};
constexpr Run runs_of_all[] = {{Solver::gauss_seidel, "float"},
                               {Solver::gauss_seidel, "double"},
                               {Solver::small_steps, "float"},
                               {Solver::small_steps, "double"},
                               {Solver::automatic, "double"}};

class ComesDownFlat : public testing::TestWithParam<Run> {
 protected:
  /// The largest rotation rate, rad/s, and distance from the vertical line of the start, m, of body 1, and its height
  /// at the end of each step.
  struct Path {
    double rotation_rate = 0, aside = 0;
    std::vector<double> z;
    double top(std::size_t from) const { return *std::max_element(z.begin() + std::ptrdiff_t(from), z.end()); }
  };
  Path path(Scene scene, double duration, u32 body = 1) const {
    scene.settings.solver = GetParam().solver;
    const Method method = {.name = "sweeps", .ladder = {}};
    Trial trial(method, {}, GetParam().precision, std::nullopt);
    Path seen;
    std::optional<Vector3> start;
    trial.run(scene, duration, [&](Seen& sample) {
      const BodyState state = sample.body(body);
      if (!start) start = state.x;
      for (const double w : state.w) seen.rotation_rate = std::max(seen.rotation_rate, std::fabs(w));
      seen.aside = std::max(seen.aside, std::hypot(state.x[0] - (*start)[0], state.x[1] - (*start)[1]));
      seen.z.push_back(state.x[2]);
      return true;
    });
    return seen;
  }
  double rounding() const { return std::string(GetParam().precision) == "float" ? 2e-3 : 1e-6; }
};
INSTANTIATE_TEST_SUITE_P(Sweeps, ComesDownFlat, testing::ValuesIn(runs_of_all), [](const auto& test) {
  return std::string(name_of(test.param.solver)) + "_" + test.param.precision;
});

Scene box_over(const std::string& floor, const std::string& box, double friction, double restitution) {
  Scene scene = parse_scene(
      R"({"description": "a box falls flat", "settings": {"dt": 0.016666666666666666},
      "materials": [{"name": "all"}], "bodies": [)" +
          floor + "," + box + "]}",
      "solve_normals_test");
  scene.materials[0].friction = friction;
  scene.materials[0].restitution = restitution;
  return scene;
}

// e = 1 on a smaller block, or beside its middle but with the centre of mass above it: the pieces of floor under a box
// are its only contacts. In the middle it goes straight up to where it came from, as energy and symmetry have it.
TEST_P(ComesDownFlat, OnASmallerBlockAndGoesStraightUp) {
  const struct {
    const char *floor, *box;
    double friction, top;
  } variants[] = {
      {R"("position": [0, 0, -0.5], "shapes": [{"type": "box", "size": [0.2, 0.2, 1]}])",
       R"("position": [0, 0, 2.5], "shapes": [{"type": "box", "size": [1, 1, 1]}])", 0.6, 2.5},
      {R"("position": [0, 0, -0.5], "shapes": [{"type": "box", "size": [0.5, 0.3, 1]}])",
       R"("position": [0, 0, 1.5], "shapes": [{"type": "box", "size": [1, 2, 0.5]}])", 0, 1.5},
      {R"("position": [3, -2, -1], "shapes": [{"type": "box", "size": [0.1, 0.1, 2]}])",
       R"("position": [3, -2, 1], "shapes": [{"type": "box", "size": [0.4, 0.4, 0.4]}])", 1, 1},
      {R"("position": [0, 0, -0.5], "orientation": {"axis": [0, 0, 1], "angle_deg": 30},
          "shapes": [{"type": "box", "size": [0.4, 0.4, 1]}])",
       R"("position": [0, 0, 2], "shapes": [{"type": "box", "size": [1, 1, 0.2]}])", 0.3, 2},
      {R"("position": [0, 0, -0.5], "shapes": [{"type": "cylinder", "radius": 0.2, "length": 1}])",
       R"("position": [0, 0, 1.2], "shapes": [{"type": "box", "size": [1, 1, 1]}])", 0.6, 1.2},
  };
  for (const auto& v : variants) {
    SCOPED_TRACE(v.box);
    const Scene scene = box_over(std::string(R"({"name": "floor", "type": "static", )") + v.floor + "}",
                                 std::string(R"({"name": "box", "density": 1000, )") + v.box + "}", v.friction, 1);
    const Path seen = path(scene, 2);
    EXPECT_LT(seen.rotation_rate, rounding());
    EXPECT_LT(seen.aside, rounding());
    // dt g v of the energy of semi-implicit steps, and where the top falls between two steps
    EXPECT_NEAR(seen.top(50), v.top, 0.03);
    EXPECT_LT(seen.top(50), v.top + 0.005);
  }
}

// e = 0.8 from a height h over a plane: back to 0.64 h, without a turn; cylinders and hulls as well as boxes.
TEST_P(ComesDownFlat, OnAPlaneAndBouncesByItsRestitution) {
  const char* shapes[] = {
      R"("position": [0, 0, 1.4], "shapes": [{"type": "box", "size": [1.2, 1.2, 1.2]}])",
      R"("position": [0, 0, 0.9], "shapes": [{"type": "box", "size": [2, 0.5, 0.2]}])",
      R"("position": [0, 0, 0.85], "shapes": [{"type": "cylinder", "radius": 0.3, "length": 0.1}])",
      R"("position": [0, 0, 1.2], "orientation": {"axis": [1, 0, 0], "angle_deg": 90},
         "shapes": [{"type": "capsule", "radius": 0.4, "length": 1}])",
      R"("position": [0, 0, 1], "shapes": [{"type": "hull", "points": [[-0.3, -0.3, -0.2], [0.3, -0.3, -0.2],
         [0.3, 0.3, -0.2], [-0.3, 0.3, -0.2], [0, 0, 0.6]]}])"};
  for (const char* shape : shapes) {
    SCOPED_TRACE(shape);
    const Scene scene = box_over(R"({"name": "ground", "type": "static", "shapes": [{"type": "plane"}]})",
                                 std::string(R"({"name": "box", "density": 400, )") + shape + "}", 0.3, 0.8);
    const Path seen = path(scene, 1.2);
    const double lowest = *std::min_element(seen.z.begin(), seen.z.end()), start = seen.z[0];
    EXPECT_LT(seen.rotation_rate, rounding());
    EXPECT_LT(seen.aside, rounding());
    EXPECT_NEAR(seen.top(40) - lowest, 0.64 * (start - lowest), 0.05 * (start - lowest));
  }
}

// Three boxes let fall onto each other: they stay over each other and do not turn. Springs rock them while they push
// out what the blows left of overlap.
TEST_P(ComesDownFlat, OnEachOther) {
  const std::string box = R"("density": 400, "shapes": [{"type": "box", "size": [1, 1, 0.5]}]})";
  const Scene scene = box_over(R"({"name": "ground", "type": "static", "shapes": [{"type": "plane"}]})",
                               R"({"name": "low", "position": [0, 0, 0.35], )" + box +
                                   R"(,{"name": "middle", "position": [0, 0, 1.05], )" + box +
                                   R"(,{"name": "high", "position": [0, 0, 1.75], )" + box,
                               0.5, 0);
  const Path seen = path(scene, 3, 3);
  const bool has_springs = GetParam().solver == Solver::small_steps;
  EXPECT_LT(seen.rotation_rate, has_springs ? 2.5 : 0.01);
  EXPECT_LT(seen.aside, has_springs ? 0.1 : 2e-3);
  EXPECT_NEAR(seen.z.back(), 1.25, 2e-3);
}

// A coin that rolls upright goes straight on: it stands on the two ends of a line.
TEST_P(ComesDownFlat, AndACoinRollsStraightOn) {
  const struct {
    double radius, length, speed;
  } variants[] = {{0.1, 0.01, 1}, {0.1, 0.05, 2}, {0.5, 0.05, 3}, {0.05, 0.01, 0.5}, {0.2, 0.2, 1}};
  for (const auto& v : variants) {
    SCOPED_TRACE(v.radius);
    const auto number = [](double x) { return std::to_string(x); };
    Scene scene = box_over(
        R"({"name": "ground", "type": "static", "shapes": [{"type": "plane"}]})",
        R"({"name": "coin", "density": 1000, "orientation": {"axis": [1, 0, 0], "angle_deg": 90}, "position": [0, 0, )" +
            number(v.radius) + R"(], "velocity": [)" + number(v.speed) + R"(, 0, 0], "angular_velocity": [0, )" +
            number(v.speed / v.radius) + R"(, 0], "shapes": [{"type": "cylinder", "radius": )" + number(v.radius) +
            R"(, "length": )" + number(v.length) + "}]}",
        0.5, 0);
    double aside = 0, x = 0;
    scene.settings.solver = GetParam().solver;
    const Method method = {.name = "sweeps", .ladder = {}};
    Trial trial(method, {}, GetParam().precision, std::nullopt);
    trial.run(scene, 5, [&](Seen& sample) {
      aside = std::max(aside, std::fabs(sample.body(1).x[1]));
      x = sample.body(1).x[0];
      return true;
    });
    EXPECT_LT(aside, 0.01 * v.radius);
    EXPECT_NEAR(x, 5 * v.speed, 0.01 * v.speed);
  }
}

// Left out, points are solved one after another: the coin veers.
TEST(CoupledNormals, AreLeftOutWhereTheSceneSaysSo) {
  Scene scene = parse_scene(R"({
    "description": "a coin rolls", "settings": {"dt": 0.016666666666666666, "coupled_normals": false},
    "materials": [{"name": "all", "friction": 0.5}],
    "bodies": [{"name": "ground", "type": "static", "shapes": [{"type": "plane"}]},
      {"name": "coin", "density": 1000, "position": [0, 0, 0.1], "orientation": {"axis": [1, 0, 0], "angle_deg": 90},
       "velocity": [1, 0, 0], "angular_velocity": [0, 10, 0],
       "shapes": [{"type": "cylinder", "radius": 0.1, "length": 0.01}]}]})",
                            "solve_normals_test");
  const Method method = {.name = "sweeps", .ladder = {}};
  for (const bool coupled : {false, true}) {
    scene.settings.coupled_normals = coupled;
    Trial trial(method, {}, "double", std::nullopt);
    double aside = 0;
    trial.run(scene, 10, [&](Seen& sample) {
      aside = std::fabs(sample.body(1).x[1]);
      return true;
    });
    if (coupled)
      EXPECT_LT(aside, 1e-6);
    else
      EXPECT_GT(aside, 0.05);
  }
}

}  // namespace
}  // namespace lockstep::test::solve_normals_test
