// Bodies as particles: speed against number, and error against radius.
//   particles_bench speed [COUNT...]   balls of about 150 particles each that touch their six neighbours, float, one
//                                      sub-step a step; default 10000 100000 1000000
//   particles_bench error              balls on each other and on a slope, boxes on slopes, double, on the reference
#include <fmt/format.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <chrono>
#include <cmath>

#include "host/backends/device_backend.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"
#include "host/scene/sample_particles.hpp"
#include "host/scene/solid_body.hpp"
#include "host/simulation.hpp"

namespace lockstep::bench {
namespace {

/// Processor time of all threads: what is left of a measurement on a machine that others use too.
double processor_time() {
  timespec time;
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &time);
  return double(time.tv_sec) + 1e-9 * double(time.tv_nsec);
}

double clock_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

BodyDescription ball(double radius, double mass, Vector3 position) {
  BodyDescription body;
  body.shapes.emplace_back();
  body.shapes[0].radius = radius;
  make_solid_of_mass(body, mass);
  body.position = position;
  return body;
}

/// A block of balls, turned each its own way, that overlap their neighbours by a hundredth.
Scene block_of_balls(u32 particles) {
  Scene scene;
  scene.source = "particles_bench";
  scene.particles = {.radius = 0.0125, .stiffness = 2000, .restitution = 0.5};
  scene.settings = {.dt = 2e-4, .margin = 0.003};
  std::string refusal;
  ParticleSampler sampler(*scene.particles);
  const std::size_t each = sampler.of(ball(0.1, 2, {}), refusal)[0].size();
  const u32 bodies = static_cast<u32>((particles + each - 1) / each);
  const u32 side = static_cast<u32>(std::ceil(std::cbrt(bodies)));
  for (u32 i = 0; i < bodies; ++i) {
    const double x = i % side, y = i / side % side, z = i / (side * side);
    scene.bodies.push_back(ball(0.1, 2, {0.198 * x, 0.198 * y, 0.198 * z}));
    exact::LcgByIndex random(i);
    const double angle = 3 * random.next();
    const Vector3 axis = {random.next_symmetric(), random.next_symmetric(), 1};
    scene.bodies.back().orientation = exact::rotation(axis, std::sin(angle), std::cos(angle));
  }
  return scene;
}

/// Of all buffers of the table, without the scratch arrays of a device.
double buffer_bytes(const InitialState<float>& state) {
  double bytes = 0;
  for_each_buffer(state.buffers,
                  [&](Buffer, const auto& elements) { bytes += double(elements.size() * sizeof(elements[0])); });
  return bytes;
}

double peak_bytes() {
  rusage usage = {};
  getrusage(RUSAGE_SELF, &usage);
  return 1024.0 * double(usage.ru_maxrss);
}

void measure_speed(u32 count, std::unique_ptr<Backend<float>> backend, const InitialState<float>& state, double bytes,
                   const char* name) {
  Simulation<float> simulation(std::move(backend), state.params);
  for (u32 i = 0; i < 2; ++i) simulation.step();  // the first finds the room that lists need
  const u32 steps = count > 500000 ? 5 : 20;
  double best = 1e9, processor = 1e9;
  for (u32 i = 0; i < steps; ++i) {
    const double start = clock_seconds(), start_processor = processor_time();
    simulation.step();
    best = std::min(best, clock_seconds() - start);
    processor = std::min(processor, processor_time() - start_processor);
  }
  const u32 particles = state.sizes.particles;
  fmt::print("{},{},{},{:.3f},{:.3g},{:.1f},{:.1f},{},{:.0f},{:.0f}\n", name, particles, state.sizes.bodies, 1e3 * best,
             particles / best, 1e9 * best / particles, 1e9 * processor / particles,
             simulation.counters()[COUNTER_PAIRS], bytes / 1e6, peak_bytes() / 1e6);
  std::fflush(stdout);
}

void speed(const std::vector<u32>& counts) {
  fmt::print(
      "device,particles,bodies,ms_per_step,particles_per_s,ns_per_particle,processor_ns_per_particle,neighbours,"
      "buffers_mb,peak_rss_mb\n");
  const auto device = select_device("auto");
  for (const u32 count : counts) {
    InitialState<float> state = compile<float>(block_of_balls(count));
    const double bytes = buffer_bytes(state);
    if (device)
      measure_speed(count, std::make_unique<DeviceBackend<float>>(state, *device, DeviceOptions{}), state, bytes,
                    "pocl");
    measure_speed(count, std::make_unique<ReferenceBackend<float>>(state), state, bytes, "reference");
  }
}

BodyDescription slope_of(double sine, double cosine) {
  BodyDescription slope;
  slope.kind = BODY_STATIC;
  slope.shapes.emplace_back();
  slope.shapes[0].kind = SHAPE_PLANE;
  slope.shapes[0].rotation = exact::rotation_from_z_to({sine, 0, cosine});
  return slope;
}

/// On the reference in double.
struct Trial {
  explicit Trial(const Scene& scene) : Trial(compile<double>(scene)) {}
  explicit Trial(const InitialState<double>& state)
      : Trial(std::make_unique<ReferenceBackend<double>>(state), state.params) {}
  Trial(std::unique_ptr<ReferenceBackend<double>> backend, const StepParams<double>& params)
      : current(backend->buffers()), simulation(std::move(backend), params) {}

  const Buffers<double>& current;
  Simulation<double> simulation;
};

/// A ball of radius 0.3 m on a slope of this sine, stepped for a second.
struct Rolling {
  double height, acceleration;
};
Rolling roll(double radius, double sine) {
  const double cosine = std::sqrt(1 - sine * sine);
  Scene scene;
  scene.source = "particles_bench";
  scene.particles = {.radius = radius, .stiffness = 1e5, .restitution = 1, .friction = 0.8};
  scene.settings = {.dt = 5e-5, .margin = 0.25 * radius};
  scene.bodies = {slope_of(sine, cosine), ball(0.3, 4, {0.3 * sine, 0, 0.3 * cosine})};
  // no symmetry of the particles lies along the slope
  scene.bodies[1].orientation = exact::rotation({1, 0.3, 0.2}, exact::sine(0.4), exact::cosine(0.4));
  Trial trial(scene);
  const Buffers<double>& b = trial.current;
  const auto steps = [&](u32 count, double& height) {
    for (u32 i = 0; i < count; ++i) {
      trial.simulation.step();
      height += (b.positions[1].x * sine + b.positions[1].z * cosine) / count;
    }
    return b.motions[1].v[0] * cosine - b.motions[1].v[2] * sine;
  };
  double height = 0, ignored = 0;
  const double first = steps(4000, ignored), second = steps(16000, height);
  return {height, (second - first) / 0.8};
}

/// How deep two balls of radius 0.3 m, turned at random, are in each other when their first particles touch.
struct Depth {
  double mean = 0, most = 0;
};
Depth depth_at_first_touch(double radius) {
  ParticleSampler sampler({.radius = radius});
  std::string refusal;
  const std::vector<Vector3> particles = sampler.of(ball(0.3, 4, {}), refusal)[0];
  const auto near_the_top = [&](u32 trial) {  // the two highest radii below it: what else there is comes later
    exact::LcgByIndex random(trial);
    const double angle = 3 * random.next();
    const Vector3 axis = {random.next_symmetric(), random.next_symmetric(), random.next_symmetric()};
    const Quaternion rotation = exact::rotation(axis, std::sin(angle), std::cos(angle));
    std::vector<Vector3> top;
    for (const Vector3& p : particles)
      if (const Vector3 rotated = exact::rotate(rotation, p); rotated[2] > 0.3 - 3 * radius) top.push_back(rotated);
    return top;
  };
  constexpr u32 trials = 500;
  Depth depth;
  for (u32 trial = 0; trial < trials; ++trial) {
    const std::vector<Vector3> below = near_the_top(2 * trial), above = near_the_top(2 * trial + 1);
    double farthest = 0;  // of the two centres, one above the other
    for (const Vector3& p : below) {
      for (const Vector3& q : above) {  // upside down
        const double x = p[0] - q[0], y = p[1] + q[1], rest = 4 * radius * radius - x * x - y * y;
        if (rest >= 0) farthest = std::max(farthest, p[2] + q[2] + std::sqrt(rest));
      }
    }
    depth.mean += (0.6 - farthest) / trials;
    depth.most = std::max(depth.most, 0.6 - farthest);
  }
  return depth;
}

/// The steepest slope, by its tangent, on which a box of 0.2 m x 0.2 m and this height still stands after 2 s.
double steepest(double radius, double height, double friction, double low, double high) {
  const auto stays_at_rest = [&](double tangent) {
    const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = tangent * cosine;
    Scene scene;
    scene.source = "particles_bench";
    // as stiff for the area at every radius, so that the springs give alike, and stiff for the weight of 0.8 kg: what
    // gives way at its lower edge tips sooner
    scene.particles = {.radius = radius,
                       .stiffness = 4e7 * radius * radius,
                       .restitution = 0.3,
                       .friction = friction,
                       .shear_stiffness = 2e7 * radius * radius};
    scene.settings = {.dt = 2e-4, .margin = 0.25 * radius};
    BodyDescription box;
    box.shapes.emplace_back();
    box.shapes[0].kind = SHAPE_BOX;
    box.shapes[0].half_extents = {0.1, 0.1, height / 2};
    make_solid_of_mass(box, 0.8);
    box.position = {height / 2 * sine, 0, height / 2 * cosine};
    box.orientation = exact::rotation_from_z_to({sine, 0, cosine});
    scene.bodies = {slope_of(sine, cosine), box};
    Trial trial(scene);
    const auto is_where_it_was = [&] {
      const Vec4<double>&x = trial.current.positions[1], &q = trial.current.orientations[1];
      const double down = x.x * cosine - x.z * sine,
                   tilt = std::abs(q.y * box.orientation[3] - q.w * box.orientation[1]);
      return std::abs(down) < 0.01 && tilt < 0.1;
    };
    for (u32 i = 0; i < 10000 && is_where_it_was(); ++i) trial.simulation.step();
    return is_where_it_was();
  };
  while (high - low > 5e-4) {
    const double middle = 0.5 * (low + high);
    (stays_at_rest(middle) ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

// Exact: the height is the radius but for what the springs give, the acceleration 5/7 g sin; balls touch when they do;
// a box slips at the coefficient of friction, and tips where its width is over its height.
void error() {
  fmt::print(
      "particle_radius_m,height_error_m,acceleration_error,touch_depth_mean_m,touch_depth_max_m,tipping_tangent_error,"
      "slipping_tangent_error\n");
  const double sine = std::sin(0.2), expected = 5.0 / 7 * 9.81 * sine;
  for (const double radius : {0.04, 0.02, 0.01, 0.005}) {
    const Rolling rolling = roll(radius, sine);
    const Depth depth = depth_at_first_touch(radius);
    fmt::print("{},{:.3g},{:.4f},{:.3g},{:.3g},{:.4f},{:.4f}\n", radius, 0.3 - rolling.height,
               rolling.acceleration / expected - 1, depth.mean, depth.most, steepest(radius, 0.4, 2, 0.1, 0.7) - 0.5,
               steepest(radius, 0.2, 0.4, 0.2, 0.6) - 0.4);
    std::fflush(stdout);
  }
}

}  // namespace
}  // namespace lockstep::bench

int main(int argc, char** argv) {
  CLI::App program("Bodies as particles: speed against number, and error against radius");
  std::vector<lockstep::u32> counts = {10000, 100000, 1000000};
  CLI::App* speed = program.add_subcommand("speed", "particles a second");
  speed->add_option("counts", counts, "Particles");
  CLI::App* error = program.add_subcommand("error", "a ball of particles against a ball");
  program.require_subcommand(1);
  CLI11_PARSE(program, argc, argv);
  try {
    if (*speed) lockstep::bench::speed(counts);
    if (*error) lockstep::bench::error();
  } catch (const lockstep::Error& failure) {
    fmt::print(stderr, "particles_bench: {}\n", failure.what());
    return 2;
  }
}
