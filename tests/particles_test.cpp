// What bodies of particles do, against closed forms.
#include "host/error.hpp"
#include "host/scene/particle_law.hpp"
#include "host/scene/read.hpp"
#include "host/scene/sample_particles.hpp"
#include "host/simulation.hpp"
#include "tests/bodies.hpp"
#include "tests/particle_scenes.hpp"

namespace lockstep::particles_test {
namespace {

constexpr double g = 9.81;

/// Steps a scene on the reference in double.
struct Trial {
  explicit Trial(const Scene& scene) : state(compile<double>(scene)), simulation(backend(), state.params) {}

  std::unique_ptr<Backend<double>> backend() {
    auto made = std::make_unique<ReferenceBackend<double>>(state);
    reference = made.get();
    return made;
  }
  void steps(u32 count) {
    for (u32 i = 0; i < count; ++i) simulation.step();
  }
  const Buffers<double>& buffers() const { return reference->buffers(); }

  InitialState<double> state;
  ReferenceBackend<double>* reference;
  Simulation<double> simulation;
};

Scene head_on(double restitution, double dt) {
  BodyDescription a = solid_body(ball_shape(0.1), 1, {0, 0, 0}), b = solid_body(ball_shape(0.1), 2, {0.2 + 1e-9, 0, 0});
  a.velocity = {1, 0, 0};
  Scene scene = particle_scene({a, b}, {.radius = 0.1, .stiffness = 1e4, .restitution = restitution}, dt);
  scene.gravity = {0, 0, 0};
  return scene;
}

// Two particles part with e times the speed at which they met: the closed form of the damped spring gives the damping
// (particle_law_test.cpp), and the steps converge to it.
TEST(Particles, TwoSeparateWithTheirRestitution) {
  for (const double e : {0.2, 0.5, 0.8, 1.0}) {
    SCOPED_TRACE(e);
    const auto error = [&](u32 steps) {
      Trial run(head_on(e, 0.08 / steps));
      run.steps(steps);
      return std::abs(velocity(run.buffers(), 1)[0] - velocity(run.buffers(), 0)[0] - e);
    };
    EXPECT_LT(error(400), 0.02);
    EXPECT_LT(error(4000), 0.002);
  }
}

// Balls, whose inertia is the same about all axes: no gyroscopic moment that is taken at one of several times.
TEST(Particles, MomentumIsConservedToRounding) {
  BodyDescription a = solid_body(ball_shape(0.3), 1.3, {0, 0, 0}),
                  b = solid_body(ball_shape(0.25), 0.7, {0.53, 0.2, 0});
  a.velocity = {1, 0, 0.3}, b.velocity = {-1, 0.2, 0};
  a.angular_velocity = {3, 0, 5}, b.angular_velocity = {0, -4, 2};
  Scene scene = particle_scene({a, b}, {.radius = 0.05, .stiffness = 1e4, .restitution = 0.5}, 2e-4);
  scene.gravity = {0, 0, 0};
  Trial run(scene);
  const auto momentum = [&] {
    Vector3 linear = {0, 0, 0}, angular = {0, 0, 0};
    for (u32 i = 0; i < 2; ++i) {
      const Vector3 p = run.buffers().masses[i].mass * velocity(run.buffers(), i);
      linear = linear + p;
      angular = angular + cross(position(run.buffers(), i), p) + angular_momentum(run.buffers(), i);
    }
    return std::pair(linear, angular);
  };
  const auto before = momentum();
  const Vector3 v = velocity(run.buffers(), 0);
  run.steps(1000);
  const auto after = momentum();
  EXPECT_GT(length(velocity(run.buffers(), 0) - v), 0.5) << "they have met";
  EXPECT_LT(length(after.first - before.first), 1e-13);
  EXPECT_LT(length(after.second - before.second), 1e-12);
}

// m g = n k overlap
TEST(Particles, ABoxRestsOnTheSpringsOfItsFace) {
  Scene scene = particle_scene({floor_body(), solid_body(box_shape({0.2, 0.2, 0.1}), 4, {0, 0, 0.1})},
                               {.radius = 0.05, .stiffness = 1e4, .restitution = 0.3}, 2e-4);
  Trial run(scene);
  run.steps(4000);
  const double corners = 16;  // of 4 x 4 particles
  EXPECT_NEAR(position(run.buffers(), 1)[2], 0.1 - 4 * g / (corners * 1e4), 1e-9);
  EXPECT_LT(length(velocity(run.buffers(), 1)), 1e-9);
}

/// A block on a slope of this tangent, at rest in its springs.
Scene block_on_slope(double tangent, double friction, double shear_stiffness = 0) {
  const double cosine = 1 / std::sqrt(1 + tangent * tangent), sine = tangent * cosine;
  const double overlap = 4 * g * cosine / (16 * 1e4);
  BodyDescription block = solid_body(box_shape({0.2, 0.2, 0.1}), 4, {0, 0, 0});
  block.position = {(0.1 - overlap) * sine, 0, (0.1 - overlap) * cosine};
  block.orientation = exact::rotation_from_z_to({sine, 0, cosine});
  return particle_scene(
      {floor_body({0, 0, 0}, {sine, 0, cosine}), block},
      {.radius = 0.05, .stiffness = 1e4, .restitution = 0.3, .friction = friction, .shear_stiffness = shear_stiffness},
      2e-4);
}

// Below tan(alpha) = mu the dampers hold the block back to a creep that does not grow, and springs along the surface
// stop it; beyond it slides with g (sin - mu cos).
void expect_slip_at_the_angle_of_friction(double shear_stiffness) {
  const double mu = 0.5;
  for (const double fraction : {0.98, 1.02}) {
    SCOPED_TRACE(fraction);
    Trial run(block_on_slope(fraction * mu, mu, shear_stiffness));
    run.steps(2500);
    const double first = length(velocity(run.buffers(), 1));
    run.steps(2500);
    const double second = length(velocity(run.buffers(), 1));
    const double cosine = 1 / std::sqrt(1 + fraction * mu * fraction * mu), sine = fraction * mu * cosine;
    if (fraction < 1 && shear_stiffness > 0) {
      EXPECT_LT(second, 1e-9);
    } else if (fraction < 1) {
      EXPECT_LT(first, 0.1);
      EXPECT_NEAR(second, first, 1e-5);
    } else {
      EXPECT_NEAR((second - first) / 0.5, g * (sine - mu * cosine), 0.02 * g * (sine - mu * cosine));
    }
  }
}

TEST(Particles, ABlockSlipsAtTheAngleOfFriction) {
  expect_slip_at_the_angle_of_friction(0);
  expect_slip_at_the_angle_of_friction(5e3);
}

// m g sin is carried by the 16 springs of the particles below: each is stretched by m g sin / 16 k_t.
TEST(Particles, SpringsAlongTheSurfaceCarryABlockOnASlope) {
  const double tangent = 0.2, stiffness = 5e3;
  Trial run(block_on_slope(tangent, 0.5, stiffness));
  run.steps(4000);
  EXPECT_LT(length(velocity(run.buffers(), 1)), 1e-12);
  ASSERT_EQ(run.buffers().spring_count[0], 16u);
  double carried = 0;
  for (u32 k = 0; k < 16; ++k) {
    const Vec4<double>& stretch = run.buffers().spring_stretches[k];
    carried += stiffness * length({stretch.x, stretch.y, stretch.z});
  }
  EXPECT_NEAR(carried, 4 * g * tangent / std::sqrt(1 + tangent * tangent), 1e-6);
}

TEST(Particles, ABallOfParticlesRollsDownASlope) {
  const double sine = std::sin(M_PI / 18), cosine = std::cos(M_PI / 18), radius = 0.3;
  BodyDescription ball = solid_body(ball_shape(radius), 4, {radius * sine, 0, radius * cosine});
  Scene scene = particle_scene({floor_body({0, 0, 0}, {sine, 0, cosine}), ball},
                               {.radius = 0.01, .stiffness = 2e4, .restitution = 1, .friction = 0.8}, 2e-4);
  Trial run(scene);
  run.steps(500);
  const double first = length(velocity(run.buffers(), 1));
  run.steps(2500);
  const double second = length(velocity(run.buffers(), 1));
  EXPECT_NEAR((second - first) / 0.5, 5.0 / 7 * g * sine, 0.02 * g * sine);
  EXPECT_NEAR(length(angular_velocity(run.buffers(), 1)) * radius, second, 0.03 * second)
      << "what drives the spin slips a little: dampers hold it";
}

TEST(Particles, ATimeStepThatIsTooLongIsRefusedWithOneThatWillDo) {
  Scene scene = particle_scene({floor_body(), solid_body(box_shape({0.2, 0.2, 0.1}), 4, {0, 0, 0.11})},
                               {.radius = 0.05, .stiffness = 1e4, .restitution = 0.3}, 0.01);
  std::string message;
  try {
    compile<double>(scene);
  } catch (const Error& error) {
    message = error.what();
  }
  const std::size_t at = message.find("set dt to ");
  ASSERT_NE(at, std::string::npos) << message;
  Scene more_substeps = scene;
  more_substeps.settings.substeps = static_cast<u32>(std::stoul(message.substr(message.find("substeps to ") + 12)));
  EXPECT_NO_THROW(compile<double>(more_substeps));
  scene.settings.dt = std::stod(message.substr(at + 10));
  Trial run(scene);
  run.steps(2000);
  EXPECT_LT(length(velocity(run.buffers(), 1)), 1e-6) << "it comes to rest";
}

// The bound is for the worst of contacts; a stack has them.
TEST(Particles, TheLongestStepKeepsAStackStill) {
  std::vector<BodyDescription> bodies = {floor_body()};
  for (u32 i = 0; i < 5; ++i) bodies.push_back(solid_body(box_shape({0.2, 0.2, 0.1}), 4, {0.01 * i, 0, 0.1 + 0.2 * i}));
  const ParticleSettings particles = {.radius = 0.05, .stiffness = 1e4, .restitution = 0.5, .friction = 0.5};
  std::string refusal;
  ParticleSampler sampler(particles);
  const double longest =
      longest_stable_step(bodies[1], sampler.of(bodies[1], refusal), particles, damping_ratio(particles.restitution));
  Trial run(particle_scene(bodies, particles, longest));
  run.steps(6000);
  for (u32 i = 1; i <= 5; ++i) EXPECT_LT(length(velocity(run.buffers(), i)), 0.02) << i;
}

// The same box by constraints: its particles are spheres of the shapes' pipeline, and no spring gives.
TEST(Particles, ByConstraintsABoxRestsOnTheFaceThatItsShapeHas) {
  Scene scene = particle_scene({floor_body(), solid_body(box_shape({0.2, 0.2, 0.1}), 4, {0, 0, 0.1})},
                               {.radius = 0.05, .model = ParticleModel::constraints}, 1.0 / 240);
  scene.materials = {{"default", 0.5, 0}};
  Trial run(scene);
  EXPECT_FALSE(has(run.state.features, Feature::particles));
  EXPECT_EQ(run.state.sizes.shapes, 1u + 2 * 16) << "a plane, and two layers of particles";
  EXPECT_EQ(run.state.buffers.masses[1].mass, 4);
  run.steps(240);
  EXPECT_EQ(run.simulation.counters()[COUNTER_CONTACTS], 16u);
  EXPECT_NEAR(position(run.buffers(), 1)[2], 0.1, 2 * run.state.params.slop);
  EXPECT_LT(length(velocity(run.buffers(), 1)), 1e-3);
}

TEST(Particles, PicturesShowShapesParticlesOrBoth) {
  const Scene scene = read_scene("particles_rest");
  const u32 particles = compile<float>(scene).sizes.particles, shapes = 5, planes = 1;
  EXPECT_GT(particles, 100u);
  EXPECT_EQ(compile_shapes<float>(scene).shapes.size(), shapes);
  EXPECT_EQ(compile_shapes<float>(scene, Shown::particles).shapes.size(), planes + particles);
  const Buffers<float> both = compile_shapes<float>(scene, Shown::both);
  EXPECT_EQ(both.shapes.size(), shapes + particles);
  u32 translucent = 0;
  for (const ShapeInfo& shape : both.shape_infos) translucent += (shape.flags & SHAPE_IS_TRIGGER) != 0;
  EXPECT_EQ(translucent, shapes - planes);
  EXPECT_EQ(both.hulls.size(), 1u) << "the mesh";
}

// A world of constraints and one of springs cannot be one batch.
TEST(Particles, ABatchHasOneModel) {
  std::vector<Scene> worlds = {lively_particles(), lively_particles()};
  worlds[1].particles.reset();
  EXPECT_THROW(compile<float>(worlds), Error);
}

// A list that was too short costs the step again and no bit.
TEST(Particles, AStepThatRanOutOfRoomIsRedoneToTheSameBits) {
  InitialState<float> state = compile<float>(sprung(lively_particles(2)));
  const auto hashes = [](InitialState<float> from) {
    Simulation<float> simulation(std::make_unique<ReferenceBackend<float>>(from), from.params);
    for (u32 i = 0; i < 3; ++i) simulation.step();
    return std::pair(simulation.world_hashes()[0].state_low, simulation.redone());
  };
  const auto roomy = hashes(state);
  state.sizes.pairs = state.params.pair_capacity = 16;
  resize(state.buffers, state.sizes, state.features);
  const auto tight = hashes(state);
  EXPECT_EQ(roomy.second, 0u);
  EXPECT_GT(tight.second, 0u);
  EXPECT_EQ(roomy.first, tight.first);
}

// A world in a batch has the bits that it has alone.
TEST(Particles, AWorldOfABatchIsAsItIsAlone) {
  const std::vector<Scene> worlds = {sprung(lively_particles(1, 2)), sprung(lively_particles(1, 3))};
  const auto hash = [](const InitialState<float>& state, u32 world) {
    Simulation<float> simulation(std::make_unique<ReferenceBackend<float>>(state), state.params);
    for (u32 i = 0; i < 5; ++i) simulation.step();
    const WorldHash h = simulation.world_hashes()[world];
    return std::pair(h.state_low, h.state_high);
  };
  EXPECT_EQ(hash(compile<float>(worlds), 1), hash(compile<float>(worlds[1]), 0));
}

TEST(Particles, TwinsAgreeThroughWholeSteps) {
  expect_twins_agree(compile<float>(lively_particles(2)), 5);
  expect_twins_agree(compile<double>(lively_particles(3)), 5);
  expect_twins_agree(compile<float>(sprung(lively_particles(2))), 5);
}

// Forces of a user come on top of those of particles, and joined bodies do not push each other.
TEST(Particles, TwinsAgreeWithLoadsAndJoints) {
  Scene scene = lively_particles(1, 2);
  scene.settings.loads = true;
  scene.joints.push_back({.name = "", .body_a = 2, .body_b = 3, .anchor_a = {0.1, 0, 0.1}, .anchor_b = {0.1, 0, 0.1}});
  InitialState<float> state = compile<float>(scene);
  for (u32 i = 0; i < state.sizes.bodies; ++i)
    state.buffers.loads[i].force[1] = 3, state.buffers.loads[i].torque[2] = 1;
  expect_twins_agree(state, 3, launch_options({{1, 0}, {16, 7}}));
  const auto speed_of = [](const InitialState<float>& from) { return velocity(run_steps(from, 1), 5)[1]; };
  const double pushed = speed_of(state);
  for (Load<float>& load : state.buffers.loads) load = {};
  EXPECT_NEAR(pushed - speed_of(state), state.params.dt * state.params.substeps * 3 / state.buffers.masses[5].mass,
              1e-5);
}

TEST(Particles, WhatParticlesCannotDoIsRefused) {
  const auto refusal = [](Scene scene) {
    try {
      compile<float>(scene);
    } catch (const Error& error) {
      return std::string(error.what());
    }
    return std::string("nothing");
  };
  Scene events = lively_particles(), trigger = events, filter = events, continuous = events, thin = events,
        euler = events;
  events.settings.events = true;
  EXPECT_EQ(refusal(events),
            "test: /settings/events: are of shapes that touch; the particle model penalty has none, leave them out");
  trigger.bodies[2].shapes[0].trigger = true;
  EXPECT_EQ(refusal(trigger), "test: body 2: has a trigger, and the particle model penalty has none; use constraints");
  filter.bodies[2].shapes[0].category = 2;
  EXPECT_EQ(refusal(filter),
            "test: body 2: has a collision filter, and the particle model penalty has none; use constraints");
  continuous.bodies[3].continuous = true;
  EXPECT_NE(refusal(continuous).find("test: body 3: is continuous"), std::string::npos);
  thin.particles->radius = 0.11;
  EXPECT_EQ(refusal(thin),
            "test: body 2: shape 0 is too thin for particles of the radius 0.11 m; make them 0.1 m at most");
  euler.settings.integrator = Integrator::trapezoidal;
  EXPECT_NE(refusal(euler).find("/settings/integrator"), std::string::npos);
}

}  // namespace
}  // namespace lockstep::particles_test
