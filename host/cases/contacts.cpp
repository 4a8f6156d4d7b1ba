// A few bodies in contact: friction and bounces, with answers in closed form.
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "host/cases/hard_case.hpp"
#include "host/scene/read.hpp"

namespace lockstep {

namespace {

using exact::length;
using exact::subtract;

constexpr double g = 9.81, frame = 1.0 / 60;

/// Where an answer turns from no to yes, by halving what lies between: the least yes that is known then.
double bisect(double no, double yes, int halvings, const std::function<bool(double)>& answer) {
  for (int i = 0; i < halvings; ++i) {
    const double middle = (no + yes) / 2;
    (answer(middle) ? yes : no) = middle;
  }
  return yes;
}

/// A ball that bounces for ever shorter times: when it comes to rest, and how far it travelled.
std::vector<CaseError> zeno_ball(const std::string& name, double restitution, Trial& trial) {
  const Scene scene = read_scene(name);
  const u32 ball = first_dynamic(scene);
  const double h = 1, fall = std::sqrt(2 * h / g), rest = fall * (1 + restitution) / (1 - restitution);
  const double path = h * (1 + restitution * restitution) / (1 - restitution * restitution);
  const double dt = trial.settings_for(scene).dt;
  double travelled = 0, last_moving = 0, last_z = 0;
  trial.run(scene, rest + 1, [&](Seen& seen) {
    const BodyState s = seen.body(ball);
    if (seen.time > 0) travelled += std::abs(s.x[2] - last_z);
    last_z = s.x[2];
    if (length(s.v) > 2 * g * dt) last_moving = seen.time;
    return true;
  });
  return {compare("path", "m", path, travelled), compare("time to rest", "s", rest, last_moving)};
}

/// A sphere that starts sliding and ends rolling.
std::vector<CaseError> slide_to_roll(Trial& trial) {
  const Scene scene = read_scene("slide_to_roll");
  const u32 ball = first_dynamic(scene);
  const double v0 = 5, mu = 0.2, radius = scene.bodies[ball].shapes[0].radius;
  const double rolls = 2 * v0 / (7 * mu * g), distance = 12 * v0 * v0 / (49 * mu * g);
  const double dt = trial.settings_for(scene).dt;
  double start = 0, speed = 0, time = -1, travel = 0, last_slip = v0, last_x = 0;
  trial.run(scene, 1.0, [&](Seen& seen) {
    const BodyState s = seen.body(ball);
    if (seen.time == 0) last_x = start = s.x[0];
    const double slip = s.v[0] - s.w[1] * radius;
    if (time < 0 && slip < 1e-4 * v0) {  // when the slip, falling at a steady rate, came to nothing
      const double rate = 3.5 * mu * g;
      const double fraction = std::min(1.0, last_slip / (rate * dt));
      time = seen.time - dt + fraction * dt;
      travel = last_x + fraction * (s.x[0] - last_x) - start;
    }
    last_slip = slip;
    last_x = s.x[0];
    speed = s.v[0];
    return true;
  });
  return {compare("rolls after", "m", distance, travel), compare("rolls from", "s", rolls, time),
          compare("speed at the end", "m/s", 5.0 / 7.0 * v0, speed)};
}

/// A sphere on a slope of 30 degrees that is rough enough to roll.
std::vector<CaseError> sphere_on_slope(Trial& trial) {
  const Scene scene = read_scene("sphere_on_slope");
  const u32 ball = first_dynamic(scene);
  const double exact = 5.0 / 7.0 * g * std::sin(std::numbers::pi / 6);
  Vector3 start = {};
  double travel = 0, speed = 0;
  trial.run(scene, 1.0, [&](Seen& seen) {
    const BodyState s = seen.body(ball);
    if (seen.time == 0) start = s.x;
    travel = length(subtract(s.x, start));
    speed = length(s.v);
    return true;
  });
  return {compare("acceleration from the speed", "m/s^2", exact, speed),
          compare("acceleration from the way", "m/s^2", exact, 2 * travel)};
}

/// A slope of 20 degrees made of triangles: what rolls and what slides goes down it as on a plane.
std::vector<CaseError> slope_of_triangles(Trial& trial) {
  const Scene scene = read_scene("slope_of_triangles");
  const double angle = std::numbers::pi / 9, duration = 1.5;
  const double rolls = 5.0 / 7.0 * g * std::sin(angle), slides = g * (std::sin(angle) - 0.2 * std::cos(angle));
  constexpr u32 ball = 1, box = 2, drum = 3;
  std::array<double, 4> speed = {};
  double aside = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    for (const u32 body : {ball, box, drum}) {
      const BodyState s = seen.body(body);
      speed[body] = s.v[0] * std::cos(angle) - s.v[2] * std::sin(angle);
      const double off = std::abs(s.v[0] * std::sin(angle) + s.v[2] * std::cos(angle));
      aside = std::max({aside, std::abs(s.v[1]), off});
    }
    return true;
  });
  return {compare("acceleration of the ball", "m/s^2", rolls, speed[ball] / duration),
          compare("acceleration of the box", "m/s^2", slides, speed[box] / duration),
          compare("acceleration of the drum", "m/s^2", slides, speed[drum] / duration),
          compare("fastest to the side or off the slope", "m/s", 0, aside)};
}

/// Boxes on a slope of 20 degrees: those with less friction than tan(20) slide, the others stick.
std::vector<CaseError> incline(Trial& trial) {
  const Scene scene = read_scene("incline");
  const double angle = std::numbers::pi / 9, duration = 2;
  struct Box {
    u32 body;
    double friction;
    Vector3 start;
    double travel = 0, speed = 0;
  };
  std::vector<Box> boxes;
  for (const MaterialPairRule& pair : scene.material_pairs) {
    const auto body = std::ranges::find(scene.bodies, scene.materials[pair.material_b].name, &BodyDescription::name);
    boxes.push_back({static_cast<u32>(body - scene.bodies.begin()), pair.friction, body->position});
  }
  trial.run(scene, duration, [&](Seen& seen) {
    for (Box& box : boxes) {
      const BodyState s = seen.body(box.body);
      box.travel = length(subtract(s.x, box.start));
      box.speed = length(s.v);
    }
    return true;
  });
  CaseError slides = {"acceleration of the worst that slides", "m/s^2", 0, -1},
            sticks = {"way of the worst that sticks", "m", 0, -1};
  for (const Box& box : boxes) {
    const double exact = g * (std::sin(angle) - box.friction * std::cos(angle));
    CaseError& worst = exact > 0 ? slides : sticks;
    const CaseError error = exact > 0 ? compare(worst.quantity, worst.unit, exact, box.speed / duration)
                                      : compare(worst.quantity, worst.unit, 0, box.travel);
    if (error.error > worst.error) worst = error;
  }
  return {slides, sticks};
}

/// The smallest friction at which the sphere on the slope rolls without slipping, found by bisection.
std::vector<CaseError> rolling_threshold(Trial& trial) {
  Scene scene = read_scene("sphere_on_slope");
  const u32 ball = first_dynamic(scene);
  const double radius = scene.bodies[ball].shapes[0].radius, dt = trial.settings_for(scene).dt;
  const double least = bisect(0.1, 0.3, 20, [&](double mu) {
    for (Material& material : scene.materials) material.friction = mu;
    scene.material_pairs.clear();
    double slip = 0;
    trial.run(scene, 0.5, [&](Seen& seen) {
      const BodyState s = seen.body(ball);
      slip = length(s.v) - length(s.w) * radius;
      return true;
    });
    return !(slip > 1e-3 * g * dt + 1e-5);
  });
  return {compare("least friction that rolls", "", 2.0 / 7.0 * std::tan(std::numbers::pi / 6), least)};
}

/// A disk of radius r and thickness 2 d that leans at `lean` and rolls on its rim, its centre at rest. It turns about
/// the line from the centre to the contact, and the weight turns its angular momentum round:
///   W^2 = m g (r cos - d sin) / (sin (I_d cos - I_a (d / r) sin)),  4 g / (r sin) of a thin one.
std::vector<CaseError> euler_disk(Trial& trial) {
  const Scene scene = read_scene("euler_disk");
  const u32 disk = first_dynamic(scene);
  const BodyDescription& body = scene.bodies[disk];
  const double lean = std::numbers::pi / 18, duration = 0.2;
  const double s = std::sin(lean), c = std::cos(lean), r = body.shapes[0].radius, d = body.shapes[0].half_length;
  const double rate =
      std::sqrt(body.mass * g * (r * c - d * s) / (s * (body.inertia[0] * c - body.inertia[2] * (d / r) * s)));
  double azimuth_change = 0, last = 0, strayed = 0;
  trial.run(scene, duration, [&](Seen& seen) {
    const BodyState state = seen.body(disk);
    const Vector3 axis = exact::rotate(state.q, {0, 0, 1});
    const double azimuth = std::atan2(axis[1], axis[0]);
    if (seen.time > 0) azimuth_change += std::remainder(azimuth - last, 2 * std::numbers::pi);
    last = azimuth;
    strayed = std::max(strayed, length(subtract(state.x, body.position)));
    return true;
  });
  return {compare("rate of the lean", "rad/s", rate, azimuth_change / duration),
          {"way of the centre, the farthest", "m", 0, strayed}};
}

/// The slope at which a box topples, found by bisection of the direction of gravity.
std::vector<CaseError> leaning_box(Trial& trial) {
  Scene scene = read_scene("leaning_box");
  const u32 box = first_dynamic(scene);
  const Vector3 half = scene.bodies[box].shapes[0].half_extents;
  const double topples = bisect(0.4, 0.55, 22, [&](double slope) {
    scene.gravity = {g * std::sin(slope), 0, -g * std::cos(slope)};
    double upright = 1;
    trial.run(scene, 4, [&](Seen& seen) {
      upright = exact::rotate(seen.body(box).q, {0, 0, 1})[2];
      return upright > 0.8;
    });
    return !(upright > 0.8);
  });
  return {compare("slope at which it topples", "rad", std::atan(half[0] / half[2]), topples)};
}

/// A rope of 20 beads half round a bollard: the ratio of the pulls at its ends at which it slips, found by bisection.
/// At each bead the rope turns by d, and the friction there carries what the pull grows by:
///   (1 + mu tan d/2) / (1 - mu tan d/2),  e^(mu pi) for a rope without beads.
/// It is loaded at once, so that a rope that gives takes up its stretch first, and soft contacts let it creep: it slips
/// if after a while it gathers speed. (One that draws itself together slows down by that.)
std::vector<CaseError> capstan(Trial& trial) {
  Scene scene = read_scene("capstan");
  const u32 last = first_dynamic(scene) + 19;
  const double wrap_angle = std::numbers::pi / 20, mu_tan = 0.3 * std::tan(wrap_angle / 2), quarter = 0.1, most = 0.03;
  const double slips = bisect(2.2, 3, 22, [&](double ratio) {
    scene.joints.back().motor_force = ratio;
    double travel = 0;                   // m
    std::array<double, 5> travels = {};  // at the ends of the quarters
    trial.run(scene, 4 * quarter, [&](Seen& seen) {
      travel = length(subtract(seen.body(last).x, scene.bodies[last].position));
      travels[static_cast<std::size_t>(std::ceil(seen.time / quarter - 1e-9))] = travel;
      return travel < most;
    });
    const double before = std::max(0.0, (travels[2] - travels[1]) / quarter),
                 after = (travels[4] - travels[3]) / quarter;  // m/s
    const bool gathers = after > 1.05 * before && after - before > 2e-6;
    return travel >= most || gathers;
  });
  return {compare("ratio of pulls at which it slips", "", std::pow((1 + mu_tan) / (1 - mu_tan), 20), slips)};
}

/// Two plates that nothing stops close in on a box until there is no room for it: no velocity of it is right. It is to
/// be no faster than the plates make it, and the report is to say that the contacts were not solved.
std::vector<CaseError> squeezed(Trial& trial) {
  const Scene scene = read_scene("squeezed");
  const u32 box = first_dynamic(scene);
  const double closing = 0.1;  // m/s, of each plate
  double fastest = 0, told = 0;
  trial.run(scene, 2, [&](Seen& seen) {
    fastest = std::max(fastest, length(seen.body(box).v));
    if (const auto& residual = seen.measures().residual) told = std::max(told, residual->defect_max);
    return true;
  });
  return {{"speed of the box beyond that of the plates", "m/s", closing, std::max(0.0, fastest - closing)},
          {"defect that the report does not tell", "m/s", closing, std::max(0.0, closing - told)}};
}

}  // namespace

std::vector<HardCase> contact_cases() {
  // what the relaxation is off by goes with the step
  Method relaxed = accelerated_gradient(0.01, {20, 80, 320});
  relaxed.ladder.push_back({.dt = 0.0025, .iterations = 80});
  using std::bind_front;
  return {
      {"zeno_ball",
       "A ball bounces with e = 0.5: at rest after 1.354571 s, on a path of 5/3 m",
       {trapezoidal({0.004, 0.002, 0.001, 0.0005}), semi_implicit({0.004, 0.002, 0.001, 0.0005})},
       bind_front(zeno_ball, "zeno_ball", 0.5)},
      {"zeno_ball_bouncy",
       "The same with e = 0.8: at rest after 4.063713 s, on a path of 41/9 m",
       {trapezoidal({0.004, 0.002, 0.001, 0.0005}), semi_implicit({0.004, 0.002, 0.001, 0.0005})},
       bind_front(zeno_ball, "zeno_ball_bouncy", 0.8)},
      {"slide_to_roll",
       "A ball slides at 5 m/s, and rolls from 0.728120 s and 3.120514 m on with 5/7 of its speed",
       {trapezoidal({0.02, 0.01, 0.005, 0.0025}), semi_implicit({0.02, 0.01, 0.005, 0.0025}),
        soft({0.02, 0.01, 0.005, 0.0025}), by_oracle("auto", {0.02, 0.01, 0.005})},
       slide_to_roll},
      {"sphere_on_slope",
       "A ball rolls down 30 degrees with 3.503571 m/s^2",
       {trapezoidal({0.02, 0.01, 0.005, 0.0025}), semi_implicit({0.02, 0.01, 0.005, 0.0025}),
        soft({0.02, 0.01, 0.005, 0.0025}), by_oracle("auto", {0.02, 0.01, 0.005})},
       sphere_on_slope},
      {"rolling_threshold",
       "The least friction at which that ball rolls is 0.164957",
       {trapezoidal({0.02, 0.01, 0.005}), semi_implicit({0.02, 0.01, 0.005}), by_oracle("auto", {0.02, 0.01, 0.005})},
       rolling_threshold},
      {"incline",
       "Boxes on 20 degrees slide exactly where their friction is less than tan(20)",
       {gauss_seidel(0.01, {5, 20, 80, 320}), cell_gauss_seidel(0.01, {5, 20, 80, 320}), jacobi(0.01, {30, 120, 480}),
        gradient(0.01, {20, 80, 320}), relaxed, soft({0.02, 0.01, 0.005}), by_oracle("auto", {0.02, 0.01})},
       incline},
      {"slope_of_triangles",
       "A ball rolls and a box and a drum slide down 20 degrees of triangles as down a plane",
       {trapezoidal({0.02, 0.01, 0.005}), semi_implicit({0.02, 0.01, 0.005}), soft({0.02, 0.01, 0.005}),
        by_oracle("auto", {0.02, 0.01})},
       slope_of_triangles},
      {"euler_disk",
       "A disk that leans at 10 degrees rolls on its rim with its centre at rest: it goes round at 77.71 rad/s",
       {trapezoidal({0.001, 0.0005, 0.00025, 0.000125}), semi_implicit({0.001, 0.0005, 0.00025, 0.000125}),
        soft({0.001, 0.0005, 0.00025})},
       euler_disk},
      {"leaning_box",
       "A box half as wide as it is high topples on slopes of more than 26.565 degrees",
       {gauss_seidel(0.005, {10, 50}), soft({0.01, 0.005, 0.0025}), by_oracle("auto", {0.01, 0.005})},
       leaning_box},
      {"capstan",
       "A rope of 20 beads half round a bollard, mu = 0.3, slips where one end is drawn 2.571774 times as hard",
       {gauss_seidel(0.002, {10, 50, 200, 1000}), small_steps(0.002, {4, 16, 64}), jacobi(0.002, {30, 300}),
        accelerated_gradient(0.002, {50, 200, 1000}), dense_gauss_seidel(0.002, {10, 50, 200, 1000})},
       capstan},
      {"squeezed",
       "Two plates that nothing stops close in on a box: it is not shot away, and the report tells of it",
       {gauss_seidel(frame, {10, 100}), small_steps(frame, {4, 16}), jacobi(frame, {30})},
       squeezed},
  };
}

}  // namespace lockstep
