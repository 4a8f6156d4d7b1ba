#include "bench/closed_forms.hpp"

#include <algorithm>
#include <cmath>
#include <memory>

#include "host/backends/reference_backend.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep::bench {

namespace {

constexpr double g = 9.81;

Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}
double length(const Vector3& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

Vector3 rotate(const Quaternion& q, const Vector3& v) {
  const Vector3 u = {q[0], q[1], q[2]};
  Vector3 t = cross(u, v);
  for (int k = 0; k < 3; ++k) t[k] += q[3] * v[k];
  const Vector3 s = cross(u, t);
  return {v[0] + 2 * s[0], v[1] + 2 * s[1], v[2] + 2 * s[2]};
}

/// The state of one body, whatever the precision of the run.
struct BodyState {
  double time;
  Vector3 x, v, w;
  Quaternion q;

  Vector3 w_body() const { return rotate({-q[0], -q[1], -q[2], q[3]}, w); }
};

template <class real>
void run_in(const Scene& scene, u32 body, double duration, const std::function<bool(const BodyState&)>& visit) {
  auto state = compile<real>(scene);
  const StepParams<real> params = state.params;
  Simulation<real> simulation(std::make_unique<ReferenceBackend<real>>(std::move(state)), params);
  const auto steps = static_cast<u32>(std::lround(duration / scene.settings.dt));
  constexpr Buffer wanted[] = {Buffer::positions, Buffer::orientations, Buffer::motions};
  for (u32 i = 0; i <= steps; ++i) {
    if (i > 0) simulation.step();
    const Buffers<real>& b = simulation.backend().download(wanted);
    const auto &x = b.positions[body], &q = b.orientations[body];
    const auto& m = b.motions[body];
    if (!visit({i * scene.settings.dt,
                {x.x, x.y, x.z},
                {m.v[0], m.v[1], m.v[2]},
                {m.w[0], m.w[1], m.w[2]},
                {q.x, q.y, q.z, q.w}}))
      return;
  }
}

/// Calls `visit` with the state of a body at time 0 and after each step, until it returns false or the time is over.
void run(Scene scene, double dt, const std::string& precision, u32 body, double duration,
         const std::function<bool(const BodyState&)>& visit) {
  scene.settings.dt = dt;
  if (precision == "double") {
    run_in<double>(scene, body, duration, visit);
  } else {
    run_in<float>(scene, body, duration, visit);
  }
}

u32 first_dynamic(const Scene& scene) {
  u32 i = 0;
  while (scene.bodies[i].kind != BODY_DYNAMIC) ++i;
  return i;
}

CaseError compare(const std::string& quantity, double exact, double computed) {
  return {quantity, exact, std::abs(computed - exact)};
}

/// The parabola x0 + v0 t + g t^2 / 2 after one second, and the angular momentum.
std::vector<CaseError> free_flight(Integrator integrator, double dt, const std::string& precision) {
  Scene scene = read_scene("free_flight");
  scene.settings.integrator = integrator;
  const BodyDescription& body = scene.bodies[0];
  const auto momentum = [&](const BodyState& s) {
    const Vector3 w = s.w_body();
    return rotate(s.q, {body.inertia[0] * w[0], body.inertia[1] * w[1], body.inertia[2] * w[2]});
  };
  Vector3 exact, start, end;
  double error = 0;
  run(scene, dt, precision, 0, 1.0, [&](const BodyState& s) {
    if (s.time == 0) start = momentum(s);
    for (int k = 0; k < 3; ++k)
      exact[k] = body.position[k] + body.velocity[k] * s.time + scene.gravity[k] * s.time * s.time / 2;
    error = length({s.x[0] - exact[0], s.x[1] - exact[1], s.x[2] - exact[2]});
    end = momentum(s);
    return true;
  });
  return {{"position after 1 s (m)", length(exact), error},
          {"angular momentum after 1 s (kg m^2/s)", length(start),
           length({end[0] - start[0], end[1] - start[1], end[2] - start[2]})}};
}

/// Time between every second sign change of the middle body rate: the period of the tumbling.
std::vector<CaseError> dzhanibekov(Integrator integrator, Gyroscopic gyroscopic, double dt,
                                   const std::string& precision) {
  Scene scene = read_scene("dzhanibekov");
  scene.settings.integrator = integrator;
  scene.settings.gyroscopic = gyroscopic;
  const Vector3 inertia = scene.bodies[0].inertia;
  std::vector<double> changes;
  double old_rate = 0, old_time = 0, energy = 0, drift = 0;
  run(scene, dt, precision, 0, 30.0, [&](const BodyState& s) {
    const Vector3 w = s.w_body();
    if (s.time > 0 && (w[1] < 0) != (old_rate < 0)) {
      changes.push_back(old_time + (s.time - old_time) * old_rate / (old_rate - w[1]));
    }
    old_rate = w[1];
    old_time = s.time;
    const double e = (inertia[0] * w[0] * w[0] + inertia[1] * w[1] * w[1] + inertia[2] * w[2] * w[2]) / 2;
    if (s.time == 0) energy = e;
    drift = std::max(drift, std::abs(e - energy));
    return true;
  });
  const double period = changes.size() > 2 ? changes[2] - changes[0] : 0;
  return {compare("period of the middle rate (s)", 13.722675, period), {"energy (J)", energy, drift}};
}

/// Simo and Wong's fast top: the Hamiltonian is constant.
std::vector<CaseError> heavy_top(double dt, const std::string& precision) {
  const Scene scene = read_scene("heavy_top");
  const BodyDescription& body = scene.bodies[0];
  const double m = body.mass, l = length(body.lever), along = 1269.975005;
  double drift = 0;
  run(scene, dt, precision, 0, 10.0, [&](const BodyState& s) {
    const Vector3 w = s.w_body();
    const double energy = ((body.inertia[0] + m * l * l) * w[0] * w[0] + (body.inertia[1] + m * l * l) * w[1] * w[1] +
                           body.inertia[2] * w[2] * w[2]) /
                              2 -
                          m * (scene.gravity[2]) * rotate(s.q, body.lever)[2];
    drift = std::max(drift, std::abs(energy - along));
    return true;
  });
  return {{"largest drift of the Hamiltonian in 10 s (J)", along, drift}};
}

/// A top in steady precession: rate of the azimuth of its axis, and how far the tilt strays.
std::vector<CaseError> steady_precession(bool fast, double dt, const std::string& precision) {
  const double rate = fast ? 22.245322 : 0.848689, tilt = std::acos(-1.0) / 6, spin = 60, duration = 2.0;
  Scene scene = read_scene("steady_precession");
  // the angular velocity of the steady motion: precession about z, total rate `spin` along the axis of the body
  const Vector3 axis = rotate(scene.bodies[0].orientation, {0, 0, 1});
  Vector3& w = scene.bodies[0].angular_velocity;
  w = {0, 0, rate};
  for (int k = 0; k < 3; ++k) w[k] += (spin - rate * std::cos(tilt)) * axis[k];
  double turned = 0, last = 0, nutation = 0, time = 0;
  run(scene, dt, precision, 0, duration, [&](const BodyState& s) {
    const Vector3 a = rotate(s.q, {0, 0, 1});
    const double azimuth = std::atan2(a[1], a[0]);
    if (s.time > 0) turned += std::remainder(azimuth - last, 2 * std::acos(-1.0));
    last = azimuth;
    time = s.time;
    nutation = std::max(nutation, std::abs(std::acos(a[2]) - tilt));
    return true;
  });
  return {compare("rate of precession (rad/s)", rate, turned / time), {"tilt (rad)", tilt, nutation}};
}

/// A pendulum released from the horizontal: where it is after 10 s.
std::vector<CaseError> pendulum(double dt, const std::string& precision) {
  const Scene scene = read_scene("pendulum_a01");
  Vector3 start = {}, end = {};
  run(scene, dt, precision, 0, 10.0, [&](const BodyState& s) {
    if (s.time == 0) start = s.x;
    end = s.x;
    return true;
  });
  // released along +-x from a pivot at the height of the start; the exact point is for a release along +x
  const double side = start[0] - rotate(scene.bodies[0].orientation, scene.bodies[0].lever)[0];
  const double sign = start[0] >= side ? 1 : -1, x = sign * (end[0] - side), z = end[2] - start[2];
  const double exact_x = 0.2750874626, exact_z = -0.9614192051;
  return {{"place after 10 s (m)", 1.0, std::sqrt((x - exact_x) * (x - exact_x) + (z - exact_z) * (z - exact_z))}};
}

/// A ball that bounces for ever shorter times: when it comes to rest, and how far it travelled.
std::vector<CaseError> zeno_ball(const std::string& name, double restitution, double dt, const std::string& precision) {
  const Scene scene = read_scene(name);
  const u32 ball = first_dynamic(scene);
  const double h = 1, fall = std::sqrt(2 * h / g), rest = fall * (1 + restitution) / (1 - restitution);
  const double path = h * (1 + restitution * restitution) / (1 - restitution * restitution);
  double travelled = 0, last_moving = 0, last_z = 0;
  run(scene, dt, precision, ball, rest + 1, [&](const BodyState& s) {
    if (s.time > 0) travelled += std::abs(s.x[2] - last_z);
    last_z = s.x[2];
    if (length(s.v) > 2 * g * dt) last_moving = s.time;
    return true;
  });
  return {compare("time to rest (s)", rest, last_moving), compare("path (m)", path, travelled)};
}

/// A sphere that starts sliding and ends rolling.
std::vector<CaseError> slide_to_roll(double dt, const std::string& precision) {
  const Scene scene = read_scene("slide_to_roll");
  const u32 ball = first_dynamic(scene);
  const double v0 = 5, mu = 0.2, radius = scene.bodies[ball].shapes[0].radius;
  const double rolls = 2 * v0 / (7 * mu * g), distance = 12 * v0 * v0 / (49 * mu * g);
  double start = 0, speed = 0, time = -1, way = 0, last_slip = v0, last_x = 0;
  run(scene, dt, precision, ball, 1.0, [&](const BodyState& s) {
    if (s.time == 0) last_x = start = s.x[0];
    const double slip = s.v[0] - s.w[1] * radius;
    if (time < 0 && slip < 1e-4 * v0) {  // when the slip, falling at a steady rate, came to nothing
      const double rate = 3.5 * mu * g;
      const double part = std::min(1.0, last_slip / (rate * dt));
      time = s.time - dt + part * dt;
      way = last_x + part * (s.x[0] - last_x) - start;
    }
    last_slip = slip;
    last_x = s.x[0];
    speed = s.v[0];
    return true;
  });
  return {compare("rolls from (s)", rolls, time), compare("rolls after (m)", distance, way),
          compare("speed at the end (m/s)", 5.0 / 7.0 * v0, speed)};
}

/// A sphere on a slope of 30 degrees that is rough enough to roll.
std::vector<CaseError> sphere_on_slope(double dt, const std::string& precision) {
  const Scene scene = read_scene("sphere_on_slope");
  const u32 ball = first_dynamic(scene);
  const double exact = 5.0 / 7.0 * g * std::sin(std::acos(-1.0) / 6);
  Vector3 start = {};
  double way = 0, speed = 0;
  run(scene, dt, precision, ball, 1.0, [&](const BodyState& s) {
    if (s.time == 0) start = s.x;
    way = length({s.x[0] - start[0], s.x[1] - start[1], s.x[2] - start[2]});
    speed = length(s.v);
    return true;
  });
  return {compare("acceleration from the speed (m/s^2)", exact, speed),
          compare("acceleration from the way (m/s^2)", exact, 2 * way)};
}

/// Boxes on a slope of 20 degrees: those with less friction than tan(20) slide, the others stick.
std::vector<CaseError> incline(double dt, const std::string& precision) {
  const Scene scene = read_scene("incline");
  const double angle = std::acos(-1.0) / 9, duration = 2;
  CaseError slides = {"acceleration of the worst that slides (m/s^2)", 0, -1},
            sticks = {"way of the worst that sticks (m)", 0, -1};
  for (const MaterialPairRule& pair : scene.material_pairs) {
    const auto body = std::ranges::find(scene.bodies, scene.materials[pair.material_b].name, &BodyDescription::name);
    Vector3 start = {};
    double speed = 0, way = 0;
    run(scene, dt, precision, static_cast<u32>(body - scene.bodies.begin()), duration, [&](const BodyState& s) {
      if (s.time == 0) start = s.x;
      way = length({s.x[0] - start[0], s.x[1] - start[1], s.x[2] - start[2]});
      speed = length(s.v);
      return true;
    });
    const double exact = g * (std::sin(angle) - pair.friction * std::cos(angle));
    CaseError& worst = exact > 0 ? slides : sticks;
    const CaseError error =
        exact > 0 ? compare(worst.quantity, exact, speed / duration) : compare(worst.quantity, 0, way);
    if (error.error > worst.error) worst = error;
  }
  return {slides, sticks};
}

/// The smallest friction at which the sphere on the slope rolls without slipping, found by bisection.
std::vector<CaseError> rolling_threshold(double dt, const std::string& precision) {
  Scene scene = read_scene("sphere_on_slope");
  const u32 ball = first_dynamic(scene);
  const double radius = scene.bodies[ball].shapes[0].radius;
  double slips = 0.1, rolls = 0.3;
  for (int i = 0; i < 20; ++i) {
    const double mu = (slips + rolls) / 2;
    for (Material& material : scene.materials) material.friction = mu;
    scene.material_pairs.clear();
    double slip = 0;
    run(scene, dt, precision, ball, 0.5, [&](const BodyState& s) {
      slip = length(s.v) - length(s.w) * radius;
      return true;
    });
    (slip > 1e-3 * g * dt + 1e-5 ? slips : rolls) = mu;
  }
  return {compare("least friction that rolls", 2.0 / 7.0 * std::tan(std::acos(-1.0) / 6), rolls)};
}

}  // namespace

const std::vector<ClosedForm>& closed_forms() {
  using std::bind_front;
  static const std::vector<ClosedForm> cases = {
      {"free flight: explicit Euler", {0.01, 0.005}, bind_front(free_flight, Integrator::explicit_euler)},
      {"free flight: semi-implicit Euler", {0.01, 0.005}, bind_front(free_flight, Integrator::semi_implicit_euler)},
      {"free flight: trapezoidal", {0.01, 0.005}, bind_front(free_flight, Integrator::trapezoidal)},
      {"free flight: Runge-Kutta 4", {0.01, 0.005}, bind_front(free_flight, Integrator::runge_kutta)},
      {"Dzhanibekov: Runge-Kutta 4",
       {0.04, 0.02},
       bind_front(dzhanibekov, Integrator::runge_kutta, Gyroscopic::implicit)},
      {"Dzhanibekov: midpoint", {0.01, 0.005}, bind_front(dzhanibekov, Integrator::trapezoidal, Gyroscopic::midpoint)},
      {"Dzhanibekov: implicit",
       {0.001, 0.0005},
       bind_front(dzhanibekov, Integrator::semi_implicit_euler, Gyroscopic::implicit)},
      {"Dzhanibekov: explicit",
       {0.001, 0.0005},
       bind_front(dzhanibekov, Integrator::explicit_euler, Gyroscopic::explicit_)},
      {"heavy top", {0.009, 0.0045}, heavy_top},
      {"steady precession: slow", {0.004, 0.002}, bind_front(steady_precession, false)},
      {"steady precession: fast", {0.004, 0.002}, bind_front(steady_precession, true)},
      {"pendulum A01", {0.02, 0.01}, pendulum},
      {"Zeno ball: e = 0.5", {0.004, 0.002, 0.001, 0.0005}, bind_front(zeno_ball, "zeno_ball", 0.5)},
      {"Zeno ball: e = 0.8", {0.004, 0.002, 0.001, 0.0005}, bind_front(zeno_ball, "zeno_ball_bouncy", 0.8)},
      {"slide to roll", {0.01, 0.005}, slide_to_roll},
      {"sphere on a slope of 30 degrees", {0.01, 0.005}, sphere_on_slope},
      {"least friction that rolls", {0.01, 0.005}, rolling_threshold},
      {"boxes on a slope of 20 degrees", {0.01, 0.005}, incline},
  };
  return cases;
}

}  // namespace lockstep::bench
