// Mechanisms that motors drive against springs, with answers from equations without joints.
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "host/cases/fly_ball.hpp"
#include "host/cases/hard_case.hpp"
#include "host/error.hpp"
#include "host/report/joints.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

u32 body_called(const Scene& scene, const std::string& name) {
  const auto found = std::ranges::find(scene.bodies, name, &BodyDescription::name);
  if (found == scene.bodies.end()) throw Error(Failure::input, scene.name, "has no body " + name);
  return static_cast<u32>(found - scene.bodies.begin());
}

/// The angle of a body about z, rad, counted on through whole turns.
class AngleCounter {
 public:
  double at(const BodyState& body) {
    const double angle = 2 * std::atan2(body.q[2], body.q[3]);
    whole_ += std::remainder(angle - last_, 2 * std::numbers::pi);
    last_ = angle;
    return whole_;
  }

 private:
  double whole_ = 0, last_ = 0;
};

/// Andrews' squeezing mechanism: its seven angles after 0.03 s, as the test set for initial value problem solvers gives
/// them (Mazzia, Magherini, Test Set for IVP Solvers, release 2.4), in its order and as it counts them: the angles of
/// the cranks K1, K3, K5 and K7 from the x axis, those of the couplers K2, K4 and K6 from the cranks that carry them.
/// The error is the root of the sum of their squared errors.
std::vector<CaseError> squeezer(Trial& trial) {
  const Scene scene = read_scene("squeezer");
  // beta, Theta, gamma, Phi, delta, Omega, epsilon
  constexpr std::array start = {-0.0617138900142764496, 0.0,
                                0.455279819163070380,   0.222668390165885885,
                                0.487364979543842550,   -0.222668390165885885,
                                1.23054744454982119};
  constexpr std::array exact_end = {15.81077119629904,  -15.75637105984298, 0.04082224013073101, -0.5347301163226948,
                                    0.5244099658805304, 0.5347301163226948, 1.048080741042263};
  std::array<AngleCounter, 7> counters;
  std::array<double, 7> angle = {};
  trial.run(scene, 0.03, [&](Seen& seen) {
    std::array<double, 7> k = {};
    for (u32 i = 0; i < 7; ++i) k[i] = counters[i].at(seen.body(body_called(scene, "k" + std::to_string(i + 1))));
    angle = {k[0], k[1] - k[0], k[2], k[3] - k[4], k[4], k[5] - k[6], k[6]};
    return true;
  });
  double squares = 0;
  for (std::size_t i = 0; i < 7; ++i) squares += std::pow(start[i] + angle[i] - exact_end[i], 2);
  return {{"angles after 0.03 s", "rad", exact_end[0], std::sqrt(squares)}};
}

/// What the bodies and joints of the scene are in the governor's own coordinates.
FlyBallParameters parameters_of(const Scene& scene) {
  const BodyDescription& spindle = scene.bodies[body_called(scene, "spindle")];
  const BodyDescription& collar = scene.bodies[body_called(scene, "collar")];
  const BodyDescription& ball = scene.bodies[body_called(scene, "ball_right")];
  const JointDescription &drive = scene.joints[0], &guide = scene.joints[1], &hinge = scene.joints[2],
                         &link = scene.joints[3];
  const Vector3 arm = exact::subtract(ball.position, hinge.anchor_a);
  return {.ball_mass = ball.mass,
          .ball_inertia = ball.inertia[0],
          .collar_mass = collar.mass,
          .spindle_inertia = spindle.inertia[2] + collar.inertia[2],
          .arm = exact::length(arm),
          .link = exact::length(exact::subtract(link.anchor_b, link.anchor_a)),
          .offset = hinge.anchor_a[0],
          .angle = std::atan2(arm[0], -arm[2]),
          .angular_velocity = spindle.angular_velocity[2],
          .torque = drive.motor_force,
          .stiffness = guide.spring->stiffness,
          .damping = guide.spring->damping,
          .gravity = -scene.gravity[2]};
}

/// A governor that a constant torque spins up for five seconds, against a fine solution in its own two coordinates.
std::vector<CaseError> governor(Trial& trial) {
  const Scene scene = read_scene("governor");
  const u32 spindle = body_called(scene, "spindle"), collar = body_called(scene, "collar");
  const double start = scene.bodies[collar].position[2];
  FlyBall exact(parameters_of(scene));
  double travel = 0, off_angular_velocity = 0;
  trial.run(scene, 5, [&](Seen& seen) {
    exact.run_to(seen.time, 1e-4);
    travel = std::max(travel, std::abs(seen.body(collar).x[2] - start - exact.travel()));
    off_angular_velocity = std::max(off_angular_velocity, std::abs(seen.body(spindle).w[2] - exact.angular_velocity()));
    return true;
  });
  return {{"way of the collar, at worst in 5 s", "m", exact.travel(), travel},
          {"spin, at worst in 5 s", "rad/s", exact.angular_velocity(), off_angular_velocity}};
}

/// Two crosses between three shafts, the first of which a motor turns evenly. With theta its angle from where the arm
/// of its cross lies in the plane of the shafts, and cos(beta) = 4/5, the slanting one has w cos(beta) / (1 -
/// sin(beta)^2 cos(theta)^2) (Cardan's joint), and the last turns as the first does.
std::vector<CaseError> cardan_shaft(Trial& trial) {
  const Scene scene = read_scene("cardan_shaft");
  const u32 middle = body_called(scene, "middle"), driven = body_called(scene, "driven");
  const double w = scene.joints[0].motor_speed, c = 0.8, s = 0.6;
  double slanting = 0, last = 0, separation = 0;
  trial.run(scene, 5, [&](Seen& seen) {
    const double across = std::cos(w * seen.time), exact = w * c / (1 - s * s * across * across);
    slanting = std::max(slanting, std::abs(exact::dot(seen.body(middle).w, {c, 0, s}) - exact));
    last = std::max(last, std::abs(seen.body(driven).w[0] - w));
    separation = std::max(separation, seen.measures().joint_drift->separation);
    return true;
  });
  return {{"rate of the slanting shaft, at worst in 5 s", "rad/s", w / c, slanting},
          {"rate of the last shaft, at worst in 5 s", "rad/s", w, last},
          {"largest separation of a joint", "m", 0, separation}};
}

/// Nuts on vertical spindles, each with the acceleration (g - 2 pi M / (m pitch)) / (1 + I (2 pi / pitch)^2 / m) by its
/// weight m g and its dry friction M, where that does not hold it. In 1.5 s none gets to the foot.
std::vector<CaseError> screw_nut(Trial& trial) {
  const Scene scene = read_scene("screw_nut");
  const double duration = 1.5;
  std::vector<double> exact;
  for (const JointDescription& joint : scene.joints) {
    const BodyDescription& nut = scene.bodies[joint.body_b];
    const Quaternion& q = nut.orientation;
    const Vector3 axis = exact::rotate({-q[0], -q[1], -q[2], q[3]}, {0, 0, 1});
    double moment = 0;
    for (unsigned k = 0; k < 3; ++k) moment += axis[k] * axis[k] * nut.inertia[k];
    const double radians_per_metre = 2 * exact::pi / std::abs(joint.pitch);  // rad/m
    const double pull = std::max(-scene.gravity[2] - radians_per_metre * joint.friction / nut.mass, 0.0);
    exact.push_back(pull / (1 + moment * radians_per_metre * radians_per_metre / nut.mass) * duration * duration / 2);
  }
  std::vector<double> travel(exact.size());
  trial.run(scene, duration, [&](Seen& seen) {
    for (u32 i = 0; i < travel.size(); ++i) {
      const u32 body = scene.joints[i].body_b;
      travel[i] = scene.bodies[body].position[2] - seen.body(body).x[2];
    }
    return true;
  });
  return {compare("way of the free nut in 1.5 s", "m", exact[0], travel[0]),
          compare("way of the left-handed nut in 1.5 s", "m", exact[1], travel[1]),
          compare("way of the rubbed nut in 1.5 s", "m", exact[2], travel[2]),
          compare("way of the locked nut in 1.5 s", "m", exact[3], travel[3])};
}

}  // namespace

std::vector<HardCase> driven_cases() {
  return {
      {"squeezer",
       "Andrews' mechanism of seven bodies: where a torque has turned it after 0.03 s",
       {small_steps(1e-4, {1, 4, 16, 64}), trapezoidal({1e-4, 5e-5, 2.5e-5, 1.25e-5}),
        reduced({1e-4, 5e-5, 2.5e-5, 1.25e-5})},
       squeezer},
      {"governor",
       "A fly-ball governor is spun up against a stiff spring and damper: its collar and its spin",
       {small_steps(0.005, {4, 16, 64}), trapezoidal({2e-3, 1e-3, 5e-4, 2.5e-4}), reduced({2e-3, 1e-3, 5e-4})},
       governor},
      {"cardan_shaft",
       "Three shafts and two crosses: the slanting shaft turns by Cardan's formula, the last as evenly as the first",
       {small_steps(0.005, {1, 4, 16, 64}), trapezoidal({1e-2, 5e-3, 2.5e-3, 1.25e-3}),
        reduced({1e-2, 5e-3, 2.5e-3, 1.25e-3})},
       cardan_shaft},
      {"screw_nut",
       "Nuts run down their threads as their weight, their moment and dry friction let them",
       {small_steps(0.01, {1, 4, 16, 64}), trapezoidal({2e-2, 1e-2, 5e-3, 2.5e-3}),
        reduced({2e-2, 1e-2, 5e-3, 2.5e-3})},
       screw_nut},
  };
}

}  // namespace lockstep
