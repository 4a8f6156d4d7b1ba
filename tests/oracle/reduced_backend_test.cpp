// Scenes stepped in reduced coordinates: against closed forms, against Lagrange's equations, against maximal
// coordinates.
#include "host/steppers/reduced_backend.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "host/error.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"
#include "host/steppers/oracles.hpp"
#include "tests/command_line.hpp"

namespace lockstep::reduced_backend_test {
namespace {

constexpr double g = 9.81;

class Stepper {
 public:
  Stepper(Scene scene, const std::string& oracle) {
    const u32 substeps = substeps_of(scene.settings);
    replace_solver(scene.settings, *find_solver(oracle));
    if (scene.settings.solver == Solver::gauss_seidel) scene.settings.substeps = std::min(substeps, 8u);
    const InitialState<double> state = compile<double>(scene);
    simulation_ = std::make_unique<Simulation<double>>(make_oracle(state), state.params);
  }

  void step() { simulation_->step(); }
  const Buffers<double>& buffers() {
    Backend<double>& backend = simulation_->backend();
    return backend.download(measured_buffers(backend.features()));
  }
  Measures measures() {
    Backend<double>& backend = simulation_->backend();
    Measures m =
        measure(buffers(), backend.sizes(), backend.features(), simulation_->params(), simulation_->counters());
    backend.take_own_residual(m);
    return m;
  }
  Vector3 x(u32 body) {
    const Vec4<double>& p = buffers().positions[body];
    return {p.x, p.y, p.z};
  }
  Quaternion q(u32 body) {
    const Vec4<double>& p = buffers().orientations[body];
    return {p.x, p.y, p.z, p.w};
  }
  Vector3 w(u32 body) {
    const Motion<double>& m = buffers().motions[body];
    return {m.w[0], m.w[1], m.w[2]};
  }
  Vector3 v(u32 body) {
    const Motion<double>& m = buffers().motions[body];
    return {m.v[0], m.v[1], m.v[2]};
  }
  const OracleBackend& backend() { return static_cast<OracleBackend&>(simulation_->backend()); }

 private:
  std::unique_ptr<Simulation<double>> simulation_;
};

Scene stepped(Scene scene, double dt, Integrator integrator = Integrator::trapezoidal) {
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.dt = dt;
  scene.settings.substeps = 1;
  scene.settings.integrator = integrator;
  return scene;
}

Scene stepped(const std::string& name, double dt, Integrator integrator = Integrator::trapezoidal) {
  return stepped(read_scene(name), dt, integrator);
}

// Rods of 1 m and 1 kg hinged end to end about y, from the origin, each at an angle from straight down.
Scene rods(const std::vector<double>& angles, double dt) {
  Scene scene;
  Vector3 end = {0, 0, 0};
  for (u32 i = 0; i < angles.size(); ++i) {
    const Vector3 along = {std::sin(angles[i]), 0, -std::cos(angles[i])};
    BodyDescription rod;
    rod.mass = 1;
    rod.inertia = {1.0 / 12, 1.0 / 12, 1e-3};
    // turned about y by -angle: z of the body is along the rod's way up
    rod.orientation = {0, -std::sin(angles[i] / 2), 0, std::cos(angles[i] / 2)};
    for (unsigned k = 0; k < 3; ++k) rod.position[k] = end[k] + along[k] / 2;
    JointDescription joint;
    joint.kind = JOINT_HINGE;
    joint.body_a = i == 0 ? NONE : i - 1;
    joint.body_b = i;
    joint.anchor_a = joint.anchor_b = end;
    joint.axis = {0, 1, 0};
    for (unsigned k = 0; k < 3; ++k) end[k] += along[k];
    scene.bodies.push_back(rod);
    scene.joints.push_back(joint);
  }
  return stepped(scene, dt);
}

double angle_of(Stepper& run, u32 rod) {
  const Quaternion q = run.q(rod);
  return -2 * std::atan2(q[1], q[3]);
}

// Half a period: from where the rod is let go to where it stands still on the other side, and back through the middle.
double measured_period(double angle, double dt) {
  Stepper run(rods({angle}, dt), "reduced_auto");
  std::vector<double> passages;
  double last = angle;
  for (u32 i = 1; passages.size() < 3; ++i) {
    run.step();
    const double current = angle_of(run, 0);
    if ((current < 0) != (last < 0)) passages.push_back(dt * (i - 1 + last / (last - current)));
    last = current;
  }
  return passages[2] - passages[0];
}

TEST(ReducedCoordinates, APendulumHasItsPeriod) {
  // 4 K(sin(a / 2)) sqrt(I / (m g d)), I = 1/3, d = 1/2; K by the arithmetic-geometric mean
  const double angle = std::numbers::pi / 2;
  double a = 1, b = std::cos(angle / 2);
  while (a - b > 1e-15) {
    const double mean = (a + b) / 2;
    b = std::sqrt(a * b);
    a = mean;
  }
  const double exact = 2 * std::numbers::pi / a * std::sqrt(1.0 / 3 / (g / 2));
  const double coarse = std::abs(measured_period(angle, 8e-3) - exact),
               fine = std::abs(measured_period(angle, 2e-3) - exact);
  EXPECT_LT(fine, 2e-5);
  EXPECT_NEAR(coarse / fine, 16, 3) << "second order";
}

// From the level, where it has none: the projections of 20,000 steps take little, and it does not gain.
TEST(ReducedCoordinates, APendulumKeepsItsEnergy) {
  for (const auto& [dt, bound] : {std::pair(0.02, 0.2), std::pair(0.005, 2e-3)}) {
    Stepper run(rods({std::numbers::pi / 2}, dt), "reduced_auto");
    double gained = 0, lost = 0;
    for (int i = 0; i < 20000; ++i) {
      run.step();
      const double energy = run.measures().energy();
      gained = std::max(gained, energy);
      lost = std::max(lost, -energy);
    }
    EXPECT_LT(gained, 0.1 * bound) << dt << ": it swings with the angle";
    EXPECT_LT(lost, bound) << dt << ", of 4.9 J";
    EXPECT_LT(run.measures().joint_drift->separation, 1e-14);
  }
}

// Two rods by Lagrange's equations: with angles p, q from straight down, I = 1/12 + 1/4,
//   (I + 1) p'' + cos(p - q) / 2 q'' = -sin(p - q) / 2 q'^2 - 3/2 g sin p
//   cos(p - q) / 2 p'' + I q''      =  sin(p - q) / 2 p'^2 - 1/2 g sin q
std::array<double, 4> double_pendulum(std::array<double, 4> s, double time, int steps) {
  const auto rate = [](const std::array<double, 4>& y) {
    const double c = std::cos(y[0] - y[1]) / 2, d = std::sin(y[0] - y[1]) / 2, inertia = 1.0 / 3;
    const double e = -d * y[3] * y[3] - 1.5 * g * std::sin(y[0]), f = d * y[2] * y[2] - 0.5 * g * std::sin(y[1]);
    const double det = (inertia + 1) * inertia - c * c;
    return std::array<double, 4>{y[2], y[3], (inertia * e - c * f) / det, ((inertia + 1) * f - c * e) / det};
  };
  const auto plus = [](std::array<double, 4> y, double h, const std::array<double, 4>& r) {
    for (unsigned i = 0; i < 4; ++i) y[i] += h * r[i];
    return y;
  };
  const double h = time / steps;
  for (int i = 0; i < steps; ++i) {
    const auto a = rate(s), b = rate(plus(s, h / 2, a)), c = rate(plus(s, h / 2, b)), d = rate(plus(s, h, c));
    for (unsigned k = 0; k < 4; ++k) s[k] += h / 6 * (a[k] + 2 * b[k] + 2 * c[k] + d[k]);
  }
  return s;
}

TEST(ReducedCoordinates, ADoublePendulumFollowsLagrangesEquations) {
  const double time = 1.6;
  const std::array<double, 4> exact = double_pendulum({1.2, -0.4, 0, 0}, time, 16000);
  const auto error = [&](double dt) {
    Stepper run(rods({1.2, -0.4}, dt), "reduced_auto");
    for (int i = 0; i < std::lround(time / dt); ++i) run.step();
    return std::hypot(angle_of(run, 0) - exact[0], angle_of(run, 1) - exact[1]);
  };
  const double coarse = error(4e-3), fine = error(1e-3);
  EXPECT_LT(fine, 5e-6);
  EXPECT_GT(coarse / fine, 12) << "second order";
}

// For any length of run and any step.
TEST(ReducedCoordinates, JointsOfTreesNeverOpen) {
  for (const auto& [name, dt, steps] : {std::tuple("chain64", 1.0 / 60, 300), std::tuple("pendulum_chain", 0.02, 2000),
                                        std::tuple("rag_doll", 0.02, 100)}) {
    for (const Integrator integrator : {Integrator::semi_implicit_euler, Integrator::trapezoidal}) {
      Stepper run(stepped(name, dt, integrator), "reduced_auto");
      double separation = 0, angle = 0;
      for (int i = 0; i < steps; ++i) {
        run.step();
        const Measures m = run.measures();
        separation = std::max(separation, m.joint_drift->separation);
        angle = std::max(angle, m.joint_drift->angle);
      }
      EXPECT_LT(separation, 5e-15 * (std::string(name) == "chain64" ? 32 : 1)) << name;
      EXPECT_LT(angle, 1e-14) << name;
    }
  }
}

// A free chain with a joint of each kind: nothing from outside, so momentum stays, and angular momentum to second
// order.
Scene free_chain(double dt) {
  Scene scene;
  scene.gravity = {0, 0, 0};
  const JointKind kinds[] = {JOINT_BALL,        JOINT_HINGE,  JOINT_SLIDER,    JOINT_FIXED,
                             JOINT_CYLINDRICAL, JOINT_PLANAR, JOINT_UNIVERSAL, JOINT_SCREW};
  for (u32 i = 0; i <= std::size(kinds); ++i) {
    BodyDescription body;
    body.mass = 1 + 0.2 * i;
    body.inertia = {0.1, 0.15, 0.2};
    body.position = {0.5 * i, 0.1 * (i % 3), 0};
    body.velocity = {0.1 * (i % 2), -0.2, 0.3 * (i % 3)};
    body.angular_velocity = {0.5, 1.0 - 0.3 * i, 0.2 * i};
    scene.bodies.push_back(body);
    if (i == 0) continue;
    JointDescription joint;
    joint.kind = kinds[i - 1];
    joint.body_a = i % 2 ? i - 1 : i;
    joint.body_b = i % 2 ? i : i - 1;
    joint.anchor_a = joint.anchor_b = {0.5 * i - 0.25, 0.05, 0.1};
    joint.axis = {0, 0.6, 0.8};
    joint.second_axis = {1, 0, 0};
    joint.pitch = 0.7;
    scene.joints.push_back(joint);
  }
  return stepped(scene, dt);
}

TEST(ReducedCoordinates, AFreeMechanismKeepsMomentumAndEnergy) {
  const auto lost = [](double dt) {
    Stepper run(free_chain(dt), "reduced_auto");
    run.step();
    const Measures first = run.measures();
    for (int i = 1; i < std::lround(1 / dt); ++i) run.step();
    const Measures last = run.measures();
    EXPECT_LT((last.worlds[0].momentum - first.worlds[0].momentum).norm(), 1e-11) << dt;
    EXPECT_LT(last.joint_drift->separation, 1e-14);
    return std::array{(last.worlds[0].angular_momentum - first.worlds[0].angular_momentum).norm(),
                      std::abs(last.energy() - first.energy()),
                      (last.worlds[0].momentum - first.worlds[0].momentum).norm()};
  };
  const auto coarse = lost(4e-3), fine = lost(1e-3);
  for (unsigned k = 0; k < 3; ++k) {
    EXPECT_LT(fine[k], 1e-7) << k;
    EXPECT_LT(fine[k], 0.1 * coarse[k] + 1e-12) << k << ": second order";
  }
}

// Both coordinates are of second order, and come to the same.
TEST(ReducedCoordinates, ComeToWhatMaximalCoordinatesComeTo) {
  for (const char* name : {"pendulum_chain", "cardan_shaft", "screw_nut", "slider_crank"}) {
    const auto largest_distance = [&](double dt) {
      Scene scene = stepped(name, dt);
      scene.settings.iterations = 2000;
      for (JointDescription& joint : scene.joints) joint.limited = false;
      Stepper reduced(scene, "reduced_auto");
      const InitialState<double> state = compile<double>(scene);
      Simulation<double> maximal(std::make_unique<ReferenceBackend<double>>(state), state.params);
      for (int i = 0; i < std::lround(0.1 / dt); ++i) {
        reduced.step();
        maximal.step();
      }
      const Buffer wanted[] = {Buffer::positions};
      const auto& positions = maximal.backend().download(wanted).positions;
      double most = 0;
      for (u32 i = 0; i < positions.size(); ++i) {
        const Vector3 mine = reduced.x(i), other = {positions[i].x, positions[i].y, positions[i].z};
        most = std::max(most, exact::length(exact::subtract(mine, other)));
      }
      return most;
    };
    const double coarse = largest_distance(4e-3), fine = largest_distance(1e-3);
    EXPECT_LT(fine, 1e-5) << name;
    EXPECT_LT(fine, 0.3 * coarse + 1e-6) << name;
  }
}

// The piston's place follows from the crank's angle; the closure of the loop is held by projection.
TEST(ReducedCoordinates, ACrankDrivesItsPistonWhereItShould) {
  for (const char* oracle : {"reduced_auto", "reduced_pyramid_lemke"}) {
    Stepper run(stepped("slider_crank", 0.002), oracle);
    double open = 0, off = 0, uneven = 0;
    for (int i = 0; i < 800; ++i) {
      run.step();
      const Quaternion q = run.q(0);
      const double angle = 2 * std::atan2(q[1], q[3]), r = 0.5, l = 1.5;
      const double x = r * std::cos(angle) + std::sqrt(l * l - r * r * std::sin(angle) * std::sin(angle));
      off = std::max(off, std::abs(run.x(2)[0] - x));
      open = std::max(open, run.measures().joint_drift->separation);
      if (i > 100) uneven = std::max(uneven, std::abs(run.w(0)[1] - 6));
    }
    EXPECT_LT(off, 1e-12) << oracle;
    EXPECT_LT(open, 1e-12) << oracle;
    EXPECT_LT(uneven, 0.02) << oracle << ": the motor's speed is met half way through a step";
    EXPECT_EQ(run.backend().unsolved().count, 0u) << oracle;
  }
}

// A ring of six hinges with four rows too many.
TEST(ReducedCoordinates, BricardsLinkageSwings) {
  for (const auto& [integrator, bound] :
       {std::pair(Integrator::trapezoidal, 0.02), std::pair(Integrator::semi_implicit_euler, 2.0)}) {
    Stepper run(stepped("bricard", 2e-3, integrator), "reduced_auto");
    const double first = 24.525;
    double open = 0, lost = 0, moved = 0;
    for (int i = 0; i < 2000; ++i) {
      run.step();
      const Measures m = run.measures();
      open = std::max(open, m.joint_drift->separation);
      lost = std::max(lost, std::abs(m.energy() - first));
      moved = std::max(moved, exact::length(run.v(2)));
    }
    EXPECT_LT(open, 1e-12);
    EXPECT_LT(lost, bound);
    EXPECT_GT(moved, 1);
  }
}

// Boxes hinged in a row on the ground: what is under them holds their weight, and they lie still.
TEST(ReducedCoordinates, WhatIsJointedLiesOnTheGround) {
  Scene scene;
  BodyDescription ground;
  ground.kind = BODY_STATIC;
  ground.shapes.emplace_back().kind = SHAPE_PLANE;
  scene.bodies.push_back(ground);
  for (u32 i = 0; i < 3; ++i) {
    BodyDescription box;
    box.mass = 1;
    box.inertia = {1.0 / 60, 1.0 / 60, 1.0 / 60};
    box.position = {0.6 * i, 0, 0.15};
    box.shapes.emplace_back().kind = SHAPE_BOX;
    box.shapes[0].half_extents = {0.15, 0.15, 0.15};
    scene.bodies.push_back(box);
    if (i == 0) continue;
    JointDescription joint;
    joint.kind = JOINT_HINGE;
    joint.body_a = i;
    joint.body_b = i + 1;
    joint.anchor_a = joint.anchor_b = {0.6 * i - 0.3, 0, 0.15};
    joint.axis = {0, 1, 0};
    scene.joints.push_back(joint);
  }
  for (const char* oracle : {"reduced_auto", "reduced_pyramid_lemke"}) {
    Stepper run(stepped(scene, 0.01, Integrator::semi_implicit_euler), oracle);
    for (int i = 0; i < 100; ++i) run.step();
    const Measures m = run.measures();
    EXPECT_EQ(m.contacts, 12u) << oracle;
    EXPECT_LT(m.residual->relative, 1e-12) << oracle;
    double load = 0;
    const Buffers<double>& b = run.buffers();
    for (const ContactImpulse<double>& impulse : b.cached_impulses) load += impulse.normal;
    EXPECT_NEAR(load, 3 * g * 0.01, 1e-8) << oracle;
    for (u32 i = 1; i < 4; ++i) EXPECT_LT(exact::length(run.v(i)), 1e-13) << oracle;
  }
}

// What a joint carries: the weights under it; and its motor the moment of a rod held level.
TEST(ReducedCoordinates, TellWhatJointsCarry) {
  Scene scene = rods({0, 0, 0}, 0.01);
  Stepper hanging(scene, "reduced_auto");
  for (int i = 0; i < 3; ++i) hanging.step();
  const Buffers<double>& b = hanging.buffers();
  const StepParams<double> params = compile<double>(scene).params;
  for (u32 joint = 0; joint < 3; ++joint)
    EXPECT_NEAR(measure_joint(b, params, joint).force[2], (3 - joint) * g, 1e-9) << joint;

  Scene stiff = rods({std::numbers::pi / 2}, 0.01);
  stiff.joints[0].friction = 10;
  for (const char* oracle : {"reduced_auto", "reduced_pyramid_lemke"}) {
    Stepper level(stiff, oracle);
    for (int i = 0; i < 3; ++i) level.step();
    EXPECT_NEAR(std::abs(measure_joint(level.buffers(), params, 0).drive), g / 2, 1e-6) << oracle;
    EXPECT_LT(exact::length(level.w(0)), 1e-15) << oracle;
  }
  stiff.joints[0].friction = 2;  // too little: it falls with what is left
  for (const char* oracle : {"reduced_auto", "reduced_pyramid_lemke"}) {
    Stepper falling(stiff, oracle);
    falling.step();
    EXPECT_NEAR(exact::length(falling.w(0)), 0.01 * (g / 2 - 2) * 3, 1e-6) << oracle;
  }
}

// A spring of stiffness k on a slider: m x'' = -k x; and stops that it does not pass.
TEST(ReducedCoordinates, KnowSpringsAndLimits) {
  Scene scene;
  scene.gravity = {0, 0, 0};
  BodyDescription body;
  body.mass = 2;
  body.inertia = {1, 1, 1};
  body.velocity = {1, 0, 0};
  scene.bodies.push_back(body);
  JointDescription joint;
  joint.kind = JOINT_SLIDER;
  joint.body_b = 0;
  joint.axis = {1, 0, 0};
  joint.spring = {50, 0, 0};
  scene.joints.push_back(joint);
  Stepper sprung(stepped(scene, 1e-3), "reduced_auto");
  for (int i = 0; i < 1000; ++i) {
    sprung.step();
    EXPECT_NEAR(sprung.x(0)[0], std::sin(5 * 1e-3 * (i + 1)) / 5, 1e-5);
  }
  scene.joints[0].spring.reset();
  scene.joints[0].limited = true;
  scene.joints[0].low = -0.5;
  scene.joints[0].high = 0.25;
  for (const char* oracle : {"reduced_auto", "reduced_pyramid_lemke"}) {
    Stepper stopped(stepped(scene, 1e-2, Integrator::semi_implicit_euler), oracle);
    for (int i = 0; i < 100; ++i) stopped.step();
    EXPECT_NEAR(stopped.x(0)[0], 0.25, 1e-12) << oracle;
    EXPECT_NEAR(stopped.v(0)[0], 0, 1e-12) << oracle;
  }
}

TEST_F(CommandLine, RunsInReducedCoordinates) {
  const nlohmann::json report = report_of("chain64 --solver reduced_auto --steps 60");
  EXPECT_EQ(report["solver"], "reduced_auto");
  EXPECT_LE(report["joint_drift_max_m"], 1e-12);
  EXPECT_LE(report_of("rag_doll --solver reduced_auto --steps 80")["residual_max"], 1.1e-10);
  EXPECT_LE(report_of("rag_doll --solver reduced_pyramid_lemke --steps 20")["joint_drift_max_m"], 1e-12);
  EXPECT_NE(run("run --help").out.find("reduced_pyramid_NAME"), std::string::npos);
  expect_refused("run pendulum_chain --solver reduced_magic", 2, "unknown solver \"reduced_magic\"");
  expect_refused("run pendulum_chain --solver reduced_auto --device cpu", 2, "--device: reduced_auto is an oracle");
}

TEST(ReducedCoordinates, RefuseSoftJoints) {
  Scene scene = rods({1}, 0.01);
  scene.joints[0].frequency = 3;
  EXPECT_THROW(Stepper(scene, "reduced_auto"), Error);
}

}  // namespace
}  // namespace lockstep::reduced_backend_test
