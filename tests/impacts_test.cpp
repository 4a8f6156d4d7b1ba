// Impacts of several contacts in one step: Newton's law with Moreau's reading of it keeps what a common e promises.
#include <gtest/gtest.h>

#include <random>
#include <string>
#include <vector>

#include "host/cases/trial.hpp"
#include "host/scene/read.hpp"

namespace lockstep::impacts_test {
namespace {

// Two balls of 1 kg, no gravity: the lower one has just left the ground at 1 m/s when the upper one, at 3 m/s, meets
// it.
Scene hit_while_rising(double e) {
  Scene scene = parse_scene(R"({
    "description": "a ball leaves the ground, and another one comes down on it", "gravity": [0, 0, 0],
    "settings": {"dt": 0.01, "iterations": 100},
    "materials": [{"name": "all", "friction": 0}],
    "bodies": [
      {"name": "ground", "type": "static", "shapes": [{"type": "plane"}]},
      {"name": "lower", "mass": 1, "position": [0, 0, 0.5], "velocity": [0, 0, 1],
       "shapes": [{"type": "sphere", "radius": 0.5}]},
      {"name": "upper", "mass": 1, "position": [0, 0, 1.5], "velocity": [0, 0, -3],
       "shapes": [{"type": "sphere", "radius": 0.5}]}
    ]})",
                            "impacts_test");
  scene.materials[0].restitution = e;
  return scene;
}

struct Case {
  double e;
  Integrator integrator;
  std::string precision;
};

class Impacts : public testing::TestWithParam<Case> {};

// The law at both contacts: the balls part at 4 e, and the lower one comes to the ground at e. With e = 1 that is all
// the energy there was; had the lower one been stopped at the ground instead, it would be 8 J of 5.
TEST_P(Impacts, OfSeveralContactsGiveNoEnergy) {
  const auto [e, integrator, precision] = GetParam();
  Scene scene = hit_while_rising(e);
  scene.settings.integrator = integrator;
  const Method hard = {.name = "gauss_seidel", .ladder = {}};
  Trial trial(hard, {}, precision, std::nullopt);
  std::vector<double> lower, upper;
  trial.run(scene, 0.02, [&](Seen& sample) {
    lower.push_back(sample.body(1).v[2]);
    upper.push_back(sample.body(2).v[2]);
    return true;
  });
  ASSERT_EQ(lower.size(), 3u);
  EXPECT_NEAR(lower[1], -e, 1e-5);
  EXPECT_NEAR(upper[1], 3 * e, 1e-5);
  EXPECT_NEAR(lower[2], e * e, 1e-5);  // and bounces
  EXPECT_NEAR(upper[2], 3 * e, 1e-5);
}

// 64 balls that all touch, with velocities at random: in one step the energy stays with e = 1, and falls below.
TEST(Impacts, OfALatticeKeepTheEnergyThatTheyPromise) {
  Scene scene = parse_scene(R"({
    "description": "a lattice of balls that touch", "gravity": [0, 0, 0],
    "settings": {"dt": 0.001, "iterations": 2000, "precision": "double"},
    "materials": [{"name": "all", "friction": 0}],
    "bodies": [{"generator": "grid", "counts": [4, 4, 4], "spacing": [1, 1, 1],
                "bodies": [{"name": "ball", "mass": 1, "shapes": [{"type": "sphere", "radius": 0.5}]}]}]})",
                            "impacts_test");
  std::mt19937 random(1);
  for (BodyDescription& ball : scene.bodies)
    for (double& v : ball.velocity) v = static_cast<double>(random()) / 2147483648.0 - 1;
  const Method hard = {.name = "gauss_seidel", .ladder = {}};
  for (const double e : {1.0, 0.7, 0.3}) {
    scene.materials[0].restitution = e;
    Trial trial(hard, {}, "double", std::nullopt);
    double before = 0, after = 0;
    trial.run(scene, 0.001, [&](Seen& sample) {
      (sample.time == 0 ? before : after) = sample.measures().energy();
      return true;
    });
    if (e == 1)
      EXPECT_NEAR(after, before, 1e-9 * before);
    else
      EXPECT_LT(after, 0.98 * before) << e;
    EXPECT_GT(after, 0.99 * e * e * before) << e;
  }
}

// A plate meets a wall with a whole face while it turns: the corners at one end close, those at the other leave.
Scene plate_on_wall(double length, double speed, double rotation_rate, double e) {
  Scene scene =
      parse_scene(R"({
    "description": "a plate meets a wall", "gravity": [0, 0, 0],
    "settings": {"dt": 0.016666666666666666, "gyroscopic": "none"},
    "materials": [{"name": "steel", "friction": 0}],
    "bodies": [
      {"name": "wall", "type": "static", "position": [1.1, 0, 0], "shapes": [{"type": "box", "size": [2, 6, 8]}]},
      {"name": "plate", "density": 1000, "velocity": [)" +
                      std::to_string(speed) + R"(, 0, 0], "angular_velocity": [0, )" + std::to_string(rotation_rate) +
                      R"(, 0], "shapes": [{"type": "box", "size": [0.2, 1, )" + std::to_string(length) + "]}]}]}",
                  "impacts_test");
  scene.materials[0].restitution = e;
  return scene;
}

// Its closed form, of two points at +-z with W = ((1 + k), (1 - k)) / m, k = z^2 / i^2: compression stops both ends (or
// the closing one alone, where the other leaves all the same), restitution gives back e of each impulse, and an end
// that closes by that is stopped. So no end closes after the blow, and no energy is gained.
TEST(Impacts, LeaveACornerThatLeaves) {
  const struct {
    double length, speed, rotation_rate, e;
  } variants[] = {{3, 2, 2, 0.5}, {3, 2, 2, 1}, {2, 1, 1.5, 0.8}, {1, 1, 4, 1}, {4, 3, 1.8, 0.3}, {0.3, 1, 8, 0.9}};
  for (const auto& v : variants) {
    const double z = v.length / 2, k = z * z / ((v.length * v.length + 0.04) / 12);
    const double first[2] = {-(v.speed + v.rotation_rate * z),
                             -(v.speed - v.rotation_rate * z)};  // > 0: leaves; the first end closes
    ASSERT_GT(first[1], 0) << v.length;
    double p[2] = {-first[0] / (1 + k), 0};
    if (first[1] + (1 - k) * p[0] < 0) {  // both are stopped
      const double determinant = (1 + k) * (1 + k) - (1 - k) * (1 - k);
      p[0] = -((1 + k) * first[0] - (1 - k) * first[1]) / determinant;
      p[1] = -((1 + k) * first[1] - (1 - k) * first[0]) / determinant;
    }
    for (double& x : p) x *= 1 + v.e;
    double u[2] = {first[0] + (1 + k) * p[0] + (1 - k) * p[1], first[1] + (1 - k) * p[0] + (1 + k) * p[1]};
    if (u[1] < 0) {
      const double more = -u[1] / (1 + k);
      u[0] += (1 - k) * more;
      u[1] = 0;
    }
    for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps, Solver::dense_gauss_seidel}) {
      for (const std::string precision : {"float", "double"}) {
        SCOPED_TRACE(std::string(name_of(solver)) + " " + precision + " length " + std::to_string(v.length));
        Scene scene = plate_on_wall(v.length, v.speed, v.rotation_rate, v.e);
        scene.settings.solver = solver;
        scene.settings.iterations = solver == Solver::small_steps ? 1 : 100;
        const Method sweeps = {.name = "sweeps", .ladder = {}};
        Trial trial(sweeps, {}, precision, std::nullopt);
        double energy[2] = {0, 0};
        BodyState end;
        trial.run(scene, 2.0 / 60, [&](Seen& sample) {
          energy[sample.time > 0] = sample.measures().energy();
          end = sample.body(1);
          return true;
        });
        const double bound = precision == "float" ? 2e-3 : 1e-5;
        EXPECT_NEAR(-(end.v[0] + end.w[1] * z), u[0], bound);
        EXPECT_NEAR(-(end.v[0] - end.w[1] * z), u[1], bound);
        EXPECT_LT(energy[1], energy[0] * (1 + 1e-5));
      }
    }
  }
}

// 1,000 boxes, cylinders and capsules, upright, nearly flat and at random, thrown at the ground far from each other,
// each a blow or several of its own: none gains energy in a step by a law that promises it.
TEST(Impacts, OfAThousandDropsGainNoEnergy) {
  std::mt19937 random(7);
  const auto between = [&](double least, double most) {
    return least + (most - least) * (static_cast<double>(random()) / 4294967296.0);
  };
  Scene scene = parse_scene(R"({
    "description": "drops", "gravity": [0, 0, 0], "settings": {"dt": 0.0005, "gyroscopic": "midpoint"},
    "materials": [{"name": "all", "friction": 0}],
    "bodies": [{"name": "ground", "type": "static", "shapes": [{"type": "plane"}]}]})",
                            "impacts_test");
  std::string bodies;
  for (int i = 0; i < 1000; ++i) {
    const auto number = [&](double least, double most) { return std::to_string(between(least, most)); };
    const double tilts[] = {0, between(0, 3), between(0, 90), between(88, 90)};
    const std::string shapes[] = {
        R"("box", "size": [)" + number(0.2, 1.2) + "," + number(0.2, 1.2) + "," + number(0.2, 1.2) + "]",
        R"("cylinder", "radius": )" + number(0.1, 0.6) + R"(, "length": )" + number(0.1, 1.2),
        R"("capsule", "radius": )" + number(0.1, 0.4) + R"(, "length": )" + number(0.1, 1.2)};
    const auto vector = [&](double least, double most) {
      return "[" + number(least, most) + "," + number(least, most) + ",";
    };
    bodies += std::string(i > 0 ? "," : "") + R"({"density": 500, "position": [)" + std::to_string(8.0 * (i % 32)) +
              "," + std::to_string(8.0 * (i / 32)) + "," + number(1.2, 1.5) + R"(], "velocity": )" + vector(-2, 2) +
              number(-6, -3) + R"(], "angular_velocity": )" + vector(-3, 3) + number(-3, 3) +
              R"(], "orientation": {"axis": )" + vector(-1, 1) + R"(0.01], "angle_deg": )" +
              std::to_string(tilts[i % 4]) + R"(}, "shapes": [{"type": )" + shapes[i % 3] + "}]}";
  }
  const Scene drops = parse_scene(R"({"description": "drops", "bodies": [)" + bodies + "]}", "impacts_test");
  scene.bodies.insert(scene.bodies.end(), drops.bodies.begin(), drops.bodies.end());
  const Method sweeps = {.name = "sweeps", .ladder = {}};
  for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
    for (const auto& [name, law] : impact_law_names) {
      for (const double friction : {0.0, 0.6}) {
        if (law == IMPACT_NEWTON && friction > 0) continue;  // gains what its closed form gains
        SCOPED_TRACE(std::string(name) + " " + name_of(solver));
        scene.settings.solver = solver;
        scene.settings.dt = solver == Solver::small_steps ? 0.002 : 0.0005;
        scene.settings.iterations = solver == Solver::small_steps ? 2 : 30;
        scene.materials[0].impact_law = law;
        scene.materials[0].friction = friction;
        scene.materials[0].restitution = 0.9;
        scene.materials[0].tangential_restitution = {};
        if (law == IMPACT_CHATTERJEE_RUINA) scene.materials[0].tangential_restitution = 0.5;
        Trial trial(sweeps, {}, "double", std::nullopt);
        std::vector<double> before;
        double gain = 0, lost = 0;
        trial.run(scene, 0.4, [&](Seen& sample) {
          for (u32 i = 1; i < scene.bodies.size(); ++i) {
            const BodyState state = sample.body(i);
            const Vector3 w = state.w_body(), &inertia = scene.bodies[i].inertia;
            double energy = 0;
            for (u32 axis = 0; axis < 3; ++axis)
              energy += scene.bodies[i].mass * state.v[axis] * state.v[axis] + inertia[axis] * w[axis] * w[axis];
            if (sample.time == 0) {
              before.push_back(energy);
              continue;
            }
            gain = std::max(gain, energy / before[i - 1] - 1);
            lost += before[i - 1] - energy;
            before[i - 1] = energy;
          }
          return true;
        });
        EXPECT_GT(lost, 0);
        EXPECT_LT(gain, 1e-4);
      }
    }
  }
}

// Boxes thrown at the ground, a third of them flat, by each law: what a step gains of their energy, at most. Newton's
// law gains some, as it must with friction; the others promise nothing for several blows at once, and gain none here
// (docs/theory/impacts.md).
TEST(Impacts, OfThrownBoxesByEachLaw) {
  Scene scene = parse_scene(R"({
    "description": "boxes thrown at the ground", "gravity": [0, 0, 0],
    "settings": {"dt": 0.002, "iterations": 200, "precision": "double", "correction": 0},
    "materials": [{"name": "all", "friction": 0.5, "restitution": 0.8}],
    "bodies": [
      {"name": "ground", "type": "static", "shapes": [{"type": "plane"}]},
      {"generator": "grid", "counts": [8, 8, 1], "spacing": [0.6, 0.6, 1],
       "bodies": [{"name": "box", "density": 1000, "position": [0, 0, 0.5],
                   "shapes": [{"type": "box", "size": [0.4, 0.3, 0.2]}]}]}]})",
                            "impacts_test");
  std::mt19937 random(5);
  const auto any = [&] { return static_cast<double>(random()) / 2147483648.0 - 1; };
  for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
    BodyDescription& box = scene.bodies[i];
    box.velocity = {2 * any(), 2 * any(), -2 + any()};
    if (i % 3 == 0) continue;  // falls flat
    box.angular_velocity = {5 * any(), 5 * any(), 5 * any()};
  }
  const Method hard = {.name = "gauss_seidel", .ladder = {}};
  for (const auto& [name, law] : impact_law_names) {
    scene.materials[0].impact_law = law;
    scene.materials[0].tangential_restitution = {};
    if (law == IMPACT_CHATTERJEE_RUINA) scene.materials[0].tangential_restitution = 0.5;
    Trial trial(hard, {}, "double", std::nullopt);
    double first = 0, last = 0, gain = 0;
    trial.run(scene, 0.6, [&](Seen& sample) {
      const double energy = sample.measures().energy();
      if (sample.time == 0)
        first = energy;
      else
        gain = std::max(gain, energy - last);
      last = energy;
      return true;
    });
    EXPECT_LT(last, 0.8 * first) << name;
    EXPECT_GT(last, 0.2 * first) << name;
    if (law == IMPACT_NEWTON) {
      EXPECT_GT(gain, 3e-4 * first);
      EXPECT_LT(gain, 4e-3 * first);
    } else {
      EXPECT_LT(gain, 1e-12 * first) << name;
    }
    EXPECT_LT(*trial.residual(), 1e-4) << name;
  }
}

INSTANTIATE_TEST_SUITE_P(All, Impacts,
                         testing::Values(Case{1, Integrator::semi_implicit_euler, "float"},
                                         Case{1, Integrator::trapezoidal, "double"},
                                         Case{0.5, Integrator::semi_implicit_euler, "double"},
                                         Case{0.5, Integrator::trapezoidal, "float"}),
                         [](const testing::TestParamInfo<Case>& one) { return "case" + std::to_string(one.index); });

}  // namespace
}  // namespace lockstep::impacts_test
