// Overlap that poses take back, and contacts that foresee the sub-step: twins, and what keeps its energy.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "host/scene/read.hpp"
#include "tests/contact_scene.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::test::separate_contacts_test {
namespace {

template <class real>
class SeparateContacts : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(SeparateContacts, Precisions);

// ---- twins ----------------------------------------------------------------------------------------------------------

/// A heap of boxes, spheres and cylinders that overlap, in motion, with impulses to start from.
template <class real>
InitialState<real> overlapping_pile(u32 copies, double theta) {
  Random random(31);
  std::vector<std::vector<BodyDescription>> worlds;
  for (u32 i = 0; i < copies; ++i) {
    worlds.push_back(overlapping_bodies(random));
    for (u32 k = 0; k < 20; ++k)
      worlds.back().push_back(round_body(SHAPE_CYLINDER, random.vector(1.5), 0.3, 0.2, random.rotation()));
  }
  InitialState<real> state = make_worlds<real>(worlds, 4096 * copies);
  state.features = with(state.features, Feature::separated_contacts);
  resize(state.buffers, state.sizes, state.features);
  set_material(state, 0.4, 0.3);
  state.params.theta = real(theta);
  state.params.separation = real(0.2);
  state.params.correction = 0;
  state.params.position_sweeps = 2;
  return started(state);
}

TYPED_TEST(SeparateContacts, KernelMatchesReference) {
  using real = TypeParam;
  for (const double theta : {1.0, 0.5}) {
    for (const u32 copies : {1u, 12u}) {
      const InitialState<real> state = overlapping_pile<real>(copies, theta);
      run_twins(Stage::pack_points, state);
      run_twins(Stage::prepare_contacts, state);
      const Buffers<real> after = run_twins(Stage::separate_contacts, state);
      u32 moved = 0;
      for (std::size_t i = 0; i < after.positions.size(); ++i)
        moved += after.positions[i].x != state.buffers.positions[i].x ? 1 : 0;
      EXPECT_GT(moved, 20u * copies);
    }
  }
}

TYPED_TEST(SeparateContacts, AbortedStepsWriteNothing) {
  using real = TypeParam;
  InitialState<real> state = overlapping_pile<real>(1, 1);
  state.buffers.counters[COUNTER_STATUS] = STATUS_ROWS_FULL;
  const Buffers<real> after = run_twins(Stage::separate_contacts, state);
  for (std::size_t i = 0; i < after.positions.size(); ++i)
    EXPECT_EQ(after.positions[i].z, state.buffers.positions[i].z);
}

// ---- what is taken back ---------------------------------------------------------------------------------------------

struct Method {
  const char *solver, *integrator, *precision;
};
void PrintTo(const Method& m, std::ostream* out) { *out << m.solver << ", " << m.integrator << ", " << m.precision; }

class Separated : public testing::TestWithParam<Method> {
 protected:
  World world(const std::string& bodies, double dt, double gravity, double friction) const {
    const std::string text = fmt::format(
        R"({{"gravity": [0, 0, {}], "settings": {{"dt": {}, "integrator": "{}"}},
            "materials": [{{"name": "m", "friction": {}}}], "bodies": [{}]}})",
        -gravity, dt, GetParam().integrator, friction, bodies);
    return World(parse_scene(text, "separate_contacts_test"),
                 {.device = "reference", .precision = GetParam().precision, .solver = GetParam().solver});
  }
  bool is_float() const { return std::string(GetParam().precision) == "float"; }
};
INSTANTIATE_TEST_SUITE_P(Methods, Separated,
                         testing::Values(Method{"gauss_seidel", "semi_implicit_euler", "float"},
                                         Method{"gauss_seidel", "semi_implicit_euler", "double"},
                                         Method{"gauss_seidel", "trapezoidal", "float"},
                                         Method{"gauss_seidel", "trapezoidal", "double"},
                                         Method{"dense_gauss_seidel", "trapezoidal", "double"},
                                         Method{"auto", "trapezoidal", "double"}));

std::string on_ground(const char* body) {
  return fmt::format(R"({{"name": "ground", "type": "static", "shapes": [{{"type": "plane"}}]}}, {})", body);
}

// A box that starts 10 mm deep comes out to the slop, and stands: its velocity is never other than 0.
TEST_P(Separated, ADeepBoxComesOutWithoutAVelocity) {
  World w = world(on_ground(R"({"name": "box", "mass": 1, "position": [0, 0, 0.09],
                  "shapes": [{"type": "box", "size": [0.2, 0.2, 0.2]}]})"),
                  0.001, 0, 0);
  w.step(200);
  EXPECT_NEAR(w.pose(*w.find("box")).position[2], 0.1, 1e-4);
  for (const double v : w.velocity(*w.find("box")).linear) EXPECT_NEAR(v, 0, 1e-6);
}

// Two balls of restitution 0 meet at 1 m/s each, anywhere within a step: they stand together afterwards.
TEST_P(Separated, ADeadBlowIsDead) {
  for (const double off : {0.0, 0.0002, 0.0005, 0.0008}) {
    World w = world(fmt::format(R"({{"name": "a", "mass": 1, "position": [0, {}, 0], "velocity": [0, -1, 0],
                                     "shapes": [{{"type": "sphere", "radius": 0.5}}]}},
                                   {{"name": "b", "mass": 1, "position": [0, -0.625, 0], "velocity": [0, 1, 0],
                                     "shapes": [{{"type": "sphere", "radius": 0.5}}]}})",
                                0.625 + off),
                    0.001, 0, 0.3);
    w.step(500);
    for (const char* name : {"a", "b"}) EXPECT_NEAR(w.velocity(*w.find(name)).linear[1], 0, 1e-5) << off;
  }
}

// ---- what is foreseen -----------------------------------------------------------------------------------------------

/// How far z of the body is from the vertical, rad.
double tilt(World& w, const char* name) {
  const Quaternion q = w.pose(*w.find(name)).orientation;
  return std::acos(std::clamp(1 - 2 * (q[0] * q[0] + q[1] * q[1]), -1.0, 1.0));
}

// A tumbler toy rocks by 5 degrees without losses: it still does after 23 swings.
TEST_P(Separated, ATumblerKeepsItsSwing) {
  for (const double dt : {0.001, 0.004, 1. / 60}) {
    World w = world(on_ground(R"({"name": "tumbler", "mass": 1, "inertia": [0.004, 0.004, 0.004],
        "position": [-0.00784401685, 0, 0.01034247717], "orientation": {"axis": [0, 1, 0], "angle_deg": 5},
        "shapes": [{"type": "sphere", "radius": 0.1, "offset": [0, 0, 0.09]}]})"),
                    dt, 9.81, 1);
    w.step(unsigned(9.5 / dt));
    double most = 0;
    for (unsigned k = 0; k < unsigned(0.5 / dt); ++k) {
      w.step(1);
      most = std::max(most, tilt(w, "tumbler"));
    }
    EXPECT_NEAR(most * 180 / 3.14159265, 5, 0.05) << dt;
  }
}

// Euler's disk leans at 10 degrees and rolls on its rim 12 times a second, its centre at rest; it goes on so.
TEST_P(Separated, EulersDiskKeepsItsEnergy) {
  World w = world(on_ground(R"({"name": "disk", "mass": 1, "position": [0, 0, 0.0070042105390159919],
      "orientation": {"axis": [0, 1, 0], "angle_deg": 10},
      "angular_velocity": [-13.257871838850194, 0, 2.5204177050696965],
      "shapes": [{"type": "cylinder", "radius": 0.0375, "length": 0.001}]})"),
                  0.0005, 9.81, 1);
  const auto energy = [&] {
    const StepErrors errors = w.errors();
    return errors.kinetic + errors.potential;
  };
  const double start = energy();
  w.step(2000);
  EXPECT_NEAR(energy() / start, 1, 0.025);  // of first order: 2.3 % by the trapezoidal rule, 1.5 % by the other
  const double degrees = tilt(w, "disk") * 180 / 3.14159265;
  EXPECT_NEAR(std::min(degrees, 180 - degrees), 10, 0.5);
  const Vector3 x = w.pose(*w.find("disk")).position;
  EXPECT_LT(std::hypot(x[0], x[1]), 0.002);
}

// A coin that rolls upright on its rim goes straight on.
TEST_P(Separated, ACoinRollsStraightOn) {
  World w = world(on_ground(R"({"name": "coin", "density": 7800, "position": [0, 0, 0.1],
      "orientation": {"axis": [1, 0, 0], "angle_deg": 90}, "velocity": [0.5, 0, 0], "angular_velocity": [0, 5, 0],
      "shapes": [{"type": "cylinder", "radius": 0.1, "length": 0.04}]})"),
                  0.002, 9.81, 0.8);
  w.step(1000);
  const Vector3 x = w.pose(*w.find("coin")).position;
  EXPECT_NEAR(x[0], 1, 2e-3);
  EXPECT_NEAR(x[1], 0, 2e-3);
  EXPECT_NEAR(x[2], 0.1, 1e-4);
}

}  // namespace
}  // namespace lockstep::test::separate_contacts_test
