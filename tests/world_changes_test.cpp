// What can be another while a world runs, against closed forms.
#include <cmath>

#include "tests/library_worlds.hpp"

namespace lockstep::world_changes_test {
namespace {

constexpr double g = 9.81;

JointDescription joint_at(JointKind kind, const Vector3& anchor, const Vector3& axis) {
  return {.name = "joint", .kind = kind, .anchor_a = anchor, .anchor_b = anchor, .axis = axis};
}

Scene with_gravity(double dt = 0.01) {
  Scene scene = empty_scene(dt);
  scene.gravity = {0, 0, -g};
  return scene;
}

// ---- gravity

// By trapezoidal steps a parabola is exact: 1 s on Earth, then 2 s on the Moon.
TEST(WorldChanges, WhatFallsFallsByTheCurrentGravity) {
  for (const char* device : {"reference", "auto"}) {
    Scene scene = with_gravity();
    scene.settings.integrator = Integrator::trapezoidal;
    World world(scene, {.device = device, .precision = "double"});
    const BodyHandle ball = world.add(ball_at({0, 0, 0}));
    world.step(100);
    EXPECT_EQ(world.gravity(), (Vector3{0, 0, -g}));
    world.set_gravity({1, 0, -1.62});
    EXPECT_EQ(world.gravity(), (Vector3{1, 0, -1.62}));
    world.step(200);
    EXPECT_NEAR(world.velocity(ball).linear[2], -g - 2 * 1.62, 1e-11);
    EXPECT_NEAR(world.velocity(ball).linear[0], 2, 1e-11);
    EXPECT_NEAR(world.pose(ball).position[2], -g / 2 - 2 * g - 2 * 1.62, 1e-10);
    world.add(ball_at({9, 0, 0}));  // a world made anew has the gravity of now
    world.step(100);
    EXPECT_NEAR(world.velocity(ball).linear[0], 3, 1e-11);
  }
}

TEST(WorldChanges, EnergyThatGravityGivesIsNoGain) {
  World world(with_gravity(), in_double());
  world.add(ball_at({0, 0, 100}));
  world.step(10);
  world.set_gravity({0, 0, -3 * g});
  world.step(10);
  EXPECT_TRUE(world.verdict().good()) << in_words(world.verdict());
}

// ---- materials

// It stands on a slope of 3:4:5, with mu above tan = 3/4, and slides by g (sin - mu cos) once mu is 1/4.
TEST(WorldChanges, WhereFrictionIsLoweredASlopeIsSlidDown) {
  for (const bool as_pair : {false, true}) {
    Scene scene = ground_scene(1.0);
    scene.materials.push_back({.name = "wood", .friction = 1});
    const Quaternion tilt = exact::rotation({0, 1, 0}, std::sqrt(0.1), std::sqrt(0.9));  // cos 4/5, sin 3/5
    scene.bodies[0].orientation = tilt;
    World world(scene, in_double());
    BodyDescription box = box_at(exact::rotate(tilt, {0, 0, 0.5}));
    box.orientation = tilt;
    box.shapes[0].material = world.material("wood");
    const BodyHandle slider = world.add(box);
    world.step(100);
    EXPECT_LT(exact::length(world.velocity(slider).linear), 1e-3);
    if (as_pair)
      world.set_material_pair({.material_a = 0, .material_b = 1, .friction = 0.25, .restitution = 0});
    else
      world.set_material(1, {.friction = 0.0625});  // with the ground's: the root of both
    EXPECT_EQ(world.materials()[1].name, "wood");
    world.step(100);
    EXPECT_NEAR(exact::length(world.velocity(slider).linear), g * (0.6 - 0.25 * 0.8), 0.02);
  }
}

// Without materials there is one that has no name.
TEST(WorldChanges, ABallThatHasBecomeElasticBouncesToItsHeight) {
  Scene scene = ground_scene();
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.dt = 0.0005;
  scene.materials.clear();
  World world(scene, in_double());
  const BodyHandle ball = world.add(ball_at({0, 0, 1.5}));  // 1 m above the floor
  world.step(800);
  world.set_material(0, {.restitution = 0.8});
  double height = 0;
  while (world.time() < 1.2) {
    world.step();
    if (world.time() > 0.5) height = std::max(height, world.pose(ball).position[2] - 0.5);
  }
  EXPECT_NEAR(height, 0.64, 0.01);
}

// ---- bodies

// It hangs m g / k below, and 2 m g / k when it weighs twice as much.
TEST(WorldChanges, AHeavierWeightStretchesItsSpring) {
  World world(with_gravity(0.005), in_double());
  const BodyHandle weight = world.add(box_at({0, 0, 0}));
  JointDescription slider = joint_at(JOINT_SLIDER, {0, 0, 0}, {0, 0, -1});
  slider.spring = {.stiffness = 100, .damping = 30};
  world.add(slider, weight);
  world.step(1000);
  EXPECT_NEAR(world.pose(weight).position[2], -2 * g / 100, 1e-9);
  world.change(weight, box_at({5, 5, 5}, 4));
  EXPECT_NEAR(world.pose(weight).position[2], -2 * g / 100, 1e-9) << "it stays where it is";
  world.step(2000);
  EXPECT_NEAR(world.pose(weight).position[2], -4 * g / 100, 1e-9);
}

// A lever with 1 m arms: what weighs 2 against 3 goes up, and down when it weighs 4; M = I w' at first.
TEST(WorldChanges, ALeverTipsToTheHeavierSide) {
  World world(with_gravity(0.001), in_double());
  BodyDescription bar;
  bar.mass = 1, bar.inertia = {1, 1, 1};
  const BodyHandle beam = world.add(bar), left = world.add(box_at({-1, 0, 0}, 2)),
                   right = world.add(box_at({1, 0, 0}, 3));
  world.add(joint_at(JOINT_HINGE, {0, 0, 0}, {0, 1, 0}), beam);
  world.add(joint_at(JOINT_FIXED, {-1, 0, 0}, {0, 0, 1}), beam, left);
  world.add(joint_at(JOINT_FIXED, {1, 0, 0}, {0, 0, 1}), beam, right);
  const auto moment_of = [](double mass) { return mass / 6 + mass; };  // of a cube at 1 m
  world.step(10);
  EXPECT_NEAR(world.velocity(beam).angular[1], 0.01 * g * 1 / (1 + moment_of(2) + moment_of(3)), 2e-4);
  world.set_velocity(beam, {}), world.set_velocity(left, {}), world.set_velocity(right, {});
  world.change(left, box_at({0, 0, 0}, 4));
  world.step(10);
  EXPECT_NEAR(world.velocity(beam).angular[1], -0.01 * g * 1 / (1 + moment_of(4) + moment_of(3)), 2e-4);
}

TEST(WorldChanges, ABodyHangsWhereItIsStaticGoesOnWhereItIsKinematicAndFallsWhereItIsDynamic) {
  for (const char* device : {"reference", "auto"}) {
    World world(with_gravity(), {.device = device, .precision = "double"});
    const BodyHandle box = world.add(box_at({0, 0, 0}));
    world.set_velocity(box, {{1, 0, 0}, {0, 0, 2}});
    world.set_load(box, [](double) { return Wrench{{0, 1, 0}, {0, 0, 0}}; });
    world.step(10);
    const BodyDescription dynamic = world.description(box);
    BodyDescription driven = dynamic;
    driven.mass = 0, driven.inertia = {0, 0, 0};
    driven.kind = BODY_KINEMATIC;
    world.change(box, driven);
    const Pose then = world.pose(box);
    const Twist with = world.velocity(box);
    EXPECT_LT(with.linear[2], -0.9);
    world.step(20);
    for (unsigned k = 0; k < 3; ++k)
      EXPECT_NEAR(world.pose(box).position[k], then.position[k] + 0.2 * with.linear[k], 1e-12);
    EXPECT_EQ(world.velocity(box).linear, with.linear);

    driven.kind = BODY_STATIC;
    world.change(box, driven);
    const Pose there = world.pose(box);
    world.step(20);
    EXPECT_EQ(world.pose(box).position, there.position);
    EXPECT_EQ(world.pose(box).orientation, there.orientation);
    EXPECT_EQ(world.velocity(box).linear, (Vector3{0, 0, 0}));

    world.change(box, dynamic);
    world.step(20);
    EXPECT_NEAR(world.velocity(box).linear[2], -0.2 * g, 1e-12);
    EXPECT_EQ(world.velocity(box).linear[0], 0);
    EXPECT_EQ(world.velocity(box).linear[1], 0) << "what acted on it went when it was not dynamic";
  }
}

// A platform that is told where to go is let go: it keeps the velocity that it has.
TEST(WorldChanges, APlatformThatIsMadeDynamicFliesOn) {
  World world(with_gravity(), in_double());
  BodyDescription platform = box_at({0, 0, 0});
  platform.kind = BODY_KINEMATIC, platform.mass = 0, platform.inertia = {0, 0, 0};
  const BodyHandle lift = world.add(platform);
  world.set_kinematic_target(lift, {{0.02, 0, 0}});
  world.step();
  world.set_kinematic_target(lift, {{9, 9, 9}});
  world.change(lift, box_at({0, 0, 0}));
  world.step(10);
  EXPECT_NEAR(world.velocity(lift).linear[0], 2, 1e-12);
  EXPECT_NEAR(world.velocity(lift).linear[2], -0.1 * g, 1e-12);
}

// The body spins on with its angular velocity, and an impulse turns it by its new moments.
TEST(WorldChanges, NewMomentsAnswerToImpulses) {
  World world(empty_scene(), in_double());
  BodyDescription book;
  book.mass = 1, book.inertia = {1, 2, 2.5};
  const BodyHandle body = world.add(book);
  world.set_velocity(body, {{0, 0, 0}, {0, 0, 1}});
  world.step(50);
  book.inertia = {4, 4, 4};
  world.change(body, book);
  EXPECT_NEAR(world.velocity(body).angular[2], 1, 1e-12);
  world.apply_impulse(body, {0, 1, 0}, exact::add(world.pose(body).position, {1, 0, 0}));
  world.step();
  EXPECT_NEAR(world.velocity(body).angular[2], 1.25, 1e-12);
  EXPECT_NEAR(world.velocity(body).linear[1], 1, 1e-12);
}

// A box that has grown is pushed out of the floor, gently, and rests on it.
TEST(WorldChanges, AShapeThatHasGrownIsPushedOut) {
  World world(ground_scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0.5})), top = world.add(box_at({0, 0, 1.5}));
  world.step(50);
  BodyDescription larger = world.description(box);
  larger.shapes[0].half_extents = {0.6, 0.6, 0.6};
  world.change(box, larger);
  double fastest = 0;
  for (int i = 0; i < 300; ++i) {
    world.step();
    fastest = std::max(fastest, world.velocity(box).linear[2]);
  }
  EXPECT_LT(fastest, 1);
  EXPECT_NEAR(world.pose(box).position[2], 0.6, 2e-3);
  EXPECT_NEAR(world.pose(top).position[2], 1.7, 4e-3);
}

// A filter lets it through the floor; the next one holds it above a second floor.
TEST(WorldChanges, ShapesMeetWhatTheirFiltersSay) {
  Scene scene = ground_scene();
  scene.bodies[0].shapes[0].category = 2;
  scene.bodies.push_back(level_floor());
  scene.bodies[1].name = "cellar";
  scene.bodies[1].position = {0, 0, -2};
  scene.bodies[1].shapes[0].category = 4;
  World world(scene, in_double());
  const BodyHandle ball = world.add(ball_at({0, 0, 0.5}));
  world.step(50);
  EXPECT_NEAR(world.pose(ball).position[2], 0.5, 2e-3);
  BodyDescription described = world.description(ball);
  described.shapes[0].mask = 4;
  world.change(ball, described);
  world.step(150);
  EXPECT_NEAR(world.pose(ball).position[2], -1.5, 2e-3);
}

// One particle on a floor that yields: it sinks in by m g / k.
TEST(WorldChanges, AHeavierParticleSinksDeeper) {
  Scene scene = ground_scene();
  replace_solver(scene.settings, Solver::gauss_seidel);
  scene.settings.dt = 0.001;
  scene.particles = ParticleSettings{.radius = 0.1, .stiffness = 4000, .restitution = 0.1, .shear_stiffness = 2000};
  World world(scene, in_double());
  BodyDescription pebble;
  pebble.position = {0, 0, 0.1};
  pebble.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.1});
  make_solid_of_mass(pebble, 2);
  const BodyHandle body = world.add(pebble);
  world.step(2000);
  EXPECT_NEAR(world.pose(body).position[2], 0.1 - 2 * g / 4000, 1e-6);
  make_solid_of_mass(pebble, 6);
  world.change(body, pebble);
  world.step(4000);
  EXPECT_NEAR(world.pose(body).position[2], 0.1 - 6 * g / 4000, 1e-6);
}

// ---- joints

TEST(WorldChanges, ALimitThatIsNarrowedOrWidenedStopsWhereItIs) {
  for (const char* device : {"reference", "auto"}) {
    World world(empty_scene(), {.device = device, .precision = "double"});
    JointDescription hinge = joint_at(JOINT_HINGE, {0, 0, 0}, {0, 0, 1});
    hinge.limited = true, hinge.low = -1, hinge.high = 1;
    hinge.motor_speed = 1, hinge.motor_force = 5;
    const JointHandle axle = world.add(hinge, world.add(box_at({0, 0, 0})));
    world.step(20);
    EXPECT_LT(world.state(axle).coordinate, 0.3);
    hinge.high = 0.5;
    hinge.anchor_a = hinge.anchor_b = {7, 7, 7}, hinge.axis = {1, 0, 0};  // which stay what they were
    world.change(axle, hinge);
    EXPECT_EQ(world.description(axle).anchor_a, (Vector3{0, 0, 0}));
    world.step(100);
    EXPECT_NEAR(world.state(axle).coordinate, 0.5, 1e-9);
    hinge.high = 0.75;
    world.change(axle, hinge);
    world.step(100);
    EXPECT_NEAR(world.state(axle).coordinate, 0.75, 1e-9);
    hinge.high = 0.25;  // which it is beyond
    world.change(axle, hinge);
    world.step(200);
    EXPECT_NEAR(world.state(axle).coordinate, 0.25, 1e-6);
  }
}

TEST(WorldChanges, ASpringSettlesAtItsNewTarget) {
  World world(empty_scene(0.005), in_double());
  JointDescription slider = joint_at(JOINT_SLIDER, {0, 0, 0}, {1, 0, 0});
  slider.spring = {.stiffness = 100, .damping = 30};
  const BodyHandle box = world.add(box_at({0, 0, 0}));
  const JointHandle rail = world.add(slider, box);
  world.step(10);
  slider.spring->rest = 0.5;
  world.change(rail, slider);
  world.step(1000);
  EXPECT_NEAR(std::abs(world.pose(box).position[0]), 0.5, 1e-9);
  EXPECT_NEAR(world.state(rail).coordinate, 0.5, 1e-9);
  slider.spring.reset();
  world.change(rail, slider);
  world.set_velocity(box, {{1, 0, 0}, {0, 0, 0}});
  world.step(100);
  EXPECT_NEAR(world.velocity(box).linear[0], 1, 1e-9) << "nothing pulls any more";
}

// 0.1 N m, then 0.3, on 1/3 kg m^2.
TEST(WorldChanges, FrictionOfAJointSlowsByItsNewTorque) {
  World world(empty_scene(), in_double());
  JointDescription hinge = joint_at(JOINT_HINGE, {0, 0, 0}, {0, 0, 1});
  hinge.friction = 0.1;
  const BodyHandle wheel = world.add(box_at({0, 0, 0}));
  const JointHandle axle = world.add(hinge, wheel);
  world.set_velocity(wheel, {{0, 0, 0}, {0, 0, 1}});
  world.step(50);
  EXPECT_NEAR(world.velocity(wheel).angular[2], 1 - 0.5 * 0.1 * 3, 1e-12);
  hinge.friction = 0.3;
  world.change(axle, hinge);
  world.step(50);
  EXPECT_NEAR(world.velocity(wheel).angular[2], 0.85 - 0.5 * 0.3 * 3, 1e-12);
}

// ---- the bound on speeds

TEST(WorldChanges, WhatIsFasterThanTheNewBoundEndsTheRun) {
  World world(empty_scene(), in_double());
  BodyDescription bullet = ball_at({0, 0, 0});
  bullet.name = "bullet";
  bullet.velocity = {50, 0, 0};
  world.add(bullet);
  world.step();
  world.set_speed_limit(60);
  EXPECT_EQ(world.speed_limit(), 60);
  world.step();
  world.set_speed_limit(40);
  try {
    world.step();
    ADD_FAILURE() << "went on";
  } catch (const Error& error) {
    EXPECT_EQ(error.failure(), Failure::comparison);
    EXPECT_NE(std::string(error.what()).find("\"bullet\""), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("40"), std::string::npos) << error.what();
  }
}

// ---- what makes no sense

TEST(WorldChanges, RefuseWhatANewOneIsRefusedFor) {
  Scene scene = ground_scene();
  BodyDescription top;
  top.name = "top", top.mass = 1, top.inertia = {1, 1, 1};
  top.pivoted = true, top.com_offset = {0, 0, 1};
  scene.bodies.push_back(top);
  World world(scene, in_double());
  BodyDescription box = box_at({3, 0, 0.5});
  box.name = "box";
  const BodyHandle body = world.add(box), on_pivot = *world.find("top");
  const JointHandle nail = world.add(joint_at(JOINT_HINGE, {3, 0, 1}, {0, 0, 1}), body);
  world.step();
  const std::uint64_t before = world.state_hash();

  BodyDescription bad = box;
  bad.mass = 0;
  EXPECT_EQ(refusal([&] { world.change(body, bad); }),
            "body \"box\": must have a mass > 0; make_solid() gives it that of its shapes");
  bad = box, bad.kind = BODY_STATIC;
  EXPECT_EQ(refusal([&] { world.change(body, bad); }),
            "body \"box\": must stay dynamic while joint \"joint\" holds it to what is not; remove that first");
  bad = box, bad.shapes[0].material = 7;
  EXPECT_EQ(refusal([&] { world.change(body, bad); }), "body \"box\": has a material that the scene does not");
  bad = top, bad.pivoted = false;
  EXPECT_EQ(refusal([&] { world.change(on_pivot, bad); }),
            "body \"top\": stays on its pivot, or without one, as it is; remove it and add another");
  bad = box, bad.name = "top";
  EXPECT_EQ(refusal([&] { world.change(body, bad); }),
            "body \"box\": cannot be called \"top\" as another body is; names must differ");
  JointDescription joint = world.description(nail);
  joint.limited = true, joint.low = 2, joint.high = 1;
  EXPECT_EQ(refusal([&] { world.change(nail, joint); }),
            "joint \"joint\": must not have a low limit above the high one");
  joint = world.description(nail), joint.kind = JOINT_BALL;
  EXPECT_EQ(refusal([&] { world.change(nail, joint); }),
            "joint \"joint\": stays a hinge of its pitch and radius; remove it and add another");
  EXPECT_EQ(refusal([&] {
              world.set_gravity({0, std::nan(""), 0});
            }),
            "gravity: must be finite and fit double, is nan");
  EXPECT_EQ(refusal([&] { world.material("stufe"); }), "world: unknown material \"stufe\"; did you mean \"stuff\"?");
  EXPECT_EQ(refusal([&] { world.set_material(0, {.friction = -1}); }),
            "material \"stuff\": must have no negative friction");
  EXPECT_EQ(refusal([&] { world.set_material(0, {.restitution = 2}); }),
            "material \"stuff\": must have a restitution of 0 .. 1");
  EXPECT_EQ(refusal([&] { world.set_material(1, {}); }), "material: is not in this world");
  EXPECT_EQ(
      refusal([&] { world.set_material_pair({.material_a = 0, .material_b = 1, .friction = 1, .restitution = 0}); }),
      "material pair: has a material that is not in this world");
  EXPECT_EQ(refusal([&] { world.set_speed_limit(0); }), "settings.speed_limit: must be > 0, is 0");
  EXPECT_EQ(refusal([&] { world.set_speed_limit(HUGE_VAL); }), "speed_limit: must be finite and fit double, is inf");
  EXPECT_EQ(world.state_hash(), before);
  world.remove(body);
  EXPECT_EQ(refusal([&] { world.change(body, box); }), "body \"box\": is not in this world any more");
}

// A surface may be flat, and a body may be a mesh.
TEST(WorldChanges, FlatSurfacesFit) {
  Scene scene = empty_scene();
  scene.bodies.push_back(ball_at({0.5, -0.25, 0.5}));
  World world(scene, {.device = "reference", .precision = "float"});
  BodyDescription ground;
  ground.kind = BODY_STATIC;
  std::string flaw;
  ground.shapes.push_back(
      {.kind = SHAPE_FACET,
       .surface = make_surface(
           {.vertices = {{-1, -1, 0}, {1, -1, 0}, {1, 1, 0}, {-1, 1, 0}}, .triangles = {{0, 1, 2}, {0, 2, 3}}}, flaw)});
  ASSERT_EQ(flaw, "");
  world.add(ground);
  world.step(10);
  EXPECT_EQ(world.contacts().size(), 1u);
}

// What the precision of a run does not hold is refused where it is said, and the world goes on as though it were not.
TEST(WorldChanges, NumbersThatDoNotFitAreRefusedAtOnce) {
  World world(ground_scene(0.5), {.device = "reference", .precision = "float"});
  BodyDescription ball = ball_at({0, 0, 5});
  ball.name = "ball";
  const BodyHandle falling = world.add(ball);
  const JointHandle nail = world.add(joint_at(JOINT_HINGE, {0, 0, 5}, {0, 1, 0}), falling);
  world.step(3);
  const std::uint64_t before = world.state_hash();
  const auto changed = [&](auto change) {
    return refusal([&] {
      BodyDescription other = ball;
      change(other);
      world.change(falling, other);
    });
  };
  EXPECT_EQ(changed([](BodyDescription& b) { b.mass = 1e60; }), "body \"ball\": mass must fit float, is 1e+60");
  EXPECT_EQ(changed([](BodyDescription& b) {
              b.inertia = {1e-50, 1e-50, 1e-50};
            }),
            "body \"ball\": inertia and its inverse must fit float, is 1e-50");
  EXPECT_EQ(changed([](BodyDescription& b) { b.shapes[0].radius = 1e60; }),
            "body \"ball\": radius must fit float, is 1e+60");
  EXPECT_EQ(changed([](BodyDescription& b) {
              b.shapes[0].kind = SHAPE_HULL;
              b.shapes[0].points = {{0, 0, 0}, {1e60, 0, 0}, {0, 1e60, 0}, {0, 0, 1e60}};
            }),
            "body \"ball\": half the size must fit float, is 1e+60");
  BodyDescription far = ball;
  far.position = {0, 1e60, 0};
  EXPECT_EQ(refusal([&] { world.add(far); }), "body \"ball\": position must fit float, is 1e+60");
  JointDescription stiff = world.description(nail);
  stiff.friction = 1e60;
  EXPECT_EQ(refusal([&] { world.change(nail, stiff); }),
            "joint \"joint\": the force of a motor, or of friction must fit float, is 1e+60");
  EXPECT_EQ(refusal([&] { world.set_material(0, {.friction = 1e60}); }),
            "material \"stuff\": friction: must be finite and fit float, is 1e+60");
  const std::string line = "body \"ball\": must be finite and fit float, is 1e+60";
  EXPECT_EQ(refusal([&] { world.teleport(falling, {{1e60, 0, 0}}); }), line);
  EXPECT_EQ(refusal([&] { world.set_velocity(falling, {{1e60, 0, 0}}); }), line);
  EXPECT_EQ(refusal([&] { world.apply_force(falling, {1e60, 0, 0}, {0, 0, 5}); }), line);
  EXPECT_NE(refusal([&] { world.apply_impulse(falling, {1e60, 0, 0}); }), "accepted");
  EXPECT_EQ(world.state_hash(), before);
  world.step(3);
  EXPECT_TRUE(world.verdict().good()) << in_words(world.verdict());
}

}  // namespace
}  // namespace lockstep::world_changes_test
