// What a world tells between two steps: contacts, events, rays and volumes.
#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "host/scene/read.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::world_queries_test {
namespace {

TEST(World, ContactsCarryTheWeight) {
  World world(ground_scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 0.5}, 3));
  world.step(200);
  Vector3 sum = {0, 0, 0};
  EXPECT_EQ(world.contacts().size(), 4u);
  for (const BodyContact& contact : world.contacts()) {
    EXPECT_EQ(contact.a, box);
    EXPECT_EQ(contact.b, *world.find("floor"));
    EXPECT_NEAR(contact.normal[2], 1, 1e-9);
    EXPECT_NEAR(contact.point[2], 0, 1e-3);
    EXPECT_NEAR(std::abs(contact.point[0]), 0.5, 1e-3);
    sum = exact::add(sum, contact.impulse);
  }
  EXPECT_NEAR(sum[2] / 0.01, 3 * 9.81, 1e-3);
  const std::vector<BodyContact> before(world.contacts().begin(), world.contacts().end());
  world.add(box_at({9, 0, 9}));
  world.poses();  // made anew; the last step is still the last step
  EXPECT_EQ(world.contacts().size(), before.size());
}

TEST(World, ErrorsTellEnergyMomentumAndOverlap) {
  World world(ground_scene(), in_double());
  const BodyHandle box = world.add(box_at({0, 0, 2}, 3));
  world.set_velocity(box, {{1, 0, 0}, {0, 0, 2}});
  const StepErrors flying = world.errors();
  EXPECT_NEAR(flying.kinetic, 0.5 * 3 + 0.5 * world.description(box).inertia[2] * 4, 1e-12);
  EXPECT_NEAR(flying.potential, 3 * 9.81 * 2, 1e-12);
  EXPECT_NEAR(flying.momentum[0], 3, 1e-12);
  EXPECT_FALSE(flying.residual);
  EXPECT_FALSE(flying.joint_separation);
  world.teleport(box, {.position = {0, 0, 0.5}});
  world.step(100);
  const StepErrors lying = world.errors();
  EXPECT_EQ(lying.contacts, 4u);
  EXPECT_NEAR(lying.max_penetration, 0.5 - world.pose(box).position[2], 1e-6) << "it lies flat";
  ASSERT_TRUE(lying.residual);
  EXPECT_LT(*lying.residual, 1e-3);
  EXPECT_LT(lying.kinetic, 1e-6);
}

// What joints do for two bodies: they do not collide, whatever else does.
TEST(World, PassingBodiesStayThoseThatTheyWere) {
  Scene scene = ground_scene();
  const auto dynamic = [&](const Vector3& at) { return box_at(at); };
  scene.bodies.push_back(dynamic({0, 0, 0.5}));
  scene.bodies.push_back(dynamic({8, 0, 0.5}));
  scene.bodies.push_back(dynamic({0.5, 0, 0.5}));  // overlaps the first
  JointDescription pin;
  pin.body_a = 2;
  pin.anchor_a = pin.anchor_b = {8, 0, 0.5};
  scene.joints.push_back(pin);
  scene.passing.push_back({1, 3});
  World world(scene, in_double());
  const BodyHandle first = world.bodies()[1], pinned = world.bodies()[2], last = world.bodies()[3];
  world.step(20);
  EXPECT_NEAR(world.pose(last).position[0], 0.5, 1e-4) << "they pass";
  const BodyHandle anchored = world.add(dynamic({16, 0, 0.5}));
  pin.anchor_a = pin.anchor_b = {16, 0, 0.5};
  world.add(pin, anchored);
  world.remove(pinned);
  world.step(20);
  EXPECT_NEAR(world.pose(last).position[0], 0.5, 1e-4) << "the others have moved up the list";
  world.remove(first);
  world.step();
  EXPECT_EQ(world.bodies().size(), 3u);
}

TEST(World, EventsAndRaysNameBodies) {
  Scene scene = ground_scene();
  scene.settings.events = true;
  World world(scene, in_double());
  const BodyHandle first = world.add(box_at({0, 0, 0.51})), gone = world.add(box_at({5, 0, 0.51}));
  const BodyHandle last = world.add(box_at({9, 0, 2.5}));
  world.remove(gone);
  std::vector<BodyHandle> landed;
  for (int i = 0; i < 100; ++i) {
    world.step();
    for (const BodyEvent& event : world.events()) {
      EXPECT_EQ(event.kind, EVENT_CONTACT_BEGIN);
      const bool floor_first = event.a == *world.find("floor");
      landed.push_back(floor_first ? event.b : event.a);
    }
  }
  EXPECT_EQ(landed, (std::vector<BodyHandle>{first, last}));
  const std::optional<BodyHit> hit = world.cast_ray({9, 0, 10}, {0, 0, -2});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->body, last);
  EXPECT_NEAR(hit->distance, 9, 1e-3);
  EXPECT_NEAR(hit->normal[2], 1, 1e-9);
  EXPECT_EQ(world.cast_ray({5, 0, 10}, {0, 0, -1})->body, *world.find("floor"));
  EXPECT_FALSE(world.cast_ray({5, 0, 10}, {0, 0, 1}));
}

// A dumbbell lies across a floor: two of its three shapes touch it.
// Nothing can touch the ball, and whoever asks for it finds it; what comes and goes later changes nothing in that.
TEST(World, AnswersRaysAtABodyAlone) {
  World world(empty_scene(), in_double());
  BodyDescription ball = ball_at({0, 0, 0});
  ball.kind = BODY_STATIC;
  const BodyHandle alone = world.add(ball);
  world.step(3);
  const auto distance = [&] { return world.cast_ray({-2, 0, 0}, {1, 0, 0})->distance; };
  EXPECT_NEAR(distance(), 1.5, 1e-12);
  EXPECT_EQ(world.overlapping_sphere({0, 0.7, 0}, 0.3), std::vector<BodyHandle>{alone});
  world.step(3);
  const BodyHandle before = world.add(ball_at({-1, 0, 0}));
  EXPECT_NEAR(distance(), 0.5, 1e-12);
  world.remove(before);
  EXPECT_NEAR(distance(), 1.5, 1e-12);
  EXPECT_FALSE(world.cast_ray({-2, 0, 1}, {1, 0, 0}));
}

// Runge-Kutta steps know no shapes: who asks is refused, and the world goes on as it was.
TEST(World, ThatKeepsNoShapesGoesOnWhenAsked) {
  Scene scene = empty_scene();
  scene.settings.integrator = Integrator::runge_kutta;
  World world(scene, in_double());
  BodyDescription ball = ball_at({0, 0, 0});
  ball.velocity = {1, 0, 0};
  const BodyHandle body = world.add(ball);
  EXPECT_EQ(refusal([&] {
              world.cast_ray({-2, 0, 0}, {1, 0, 0});
            }),
            "query: this scene keeps no shapes: no two can touch, or their particles do in their place");
  world.step(10);
  EXPECT_NEAR(world.pose(body).position[0], 0.1, 1e-12);
}

TEST(World, NamesTheShapesOfCompounds) {
  World world(ground_scene(), in_double());
  BodyDescription dumbbell;
  dumbbell.position = {0, 0, 0.5};
  dumbbell.shapes = {{.kind = SHAPE_BOX, .half_extents = {1, 0.1, 0.1}},
                     {.kind = SHAPE_SPHERE, .offset = {1, 0, 0}, .radius = 0.5},
                     {.kind = SHAPE_SPHERE, .offset = {-1, 0, 0}, .radius = 0.5}};
  make_solid(dumbbell, 1000);
  world.add(box_at({9, 0, 0.5}));
  const BodyHandle body = world.add(dumbbell);
  world.step(10);
  std::vector<u32> touching;
  for (const BodyContact& contact : world.contacts()) {
    if (contact.a == body) touching.push_back(contact.shape_a);
    if (contact.b == body) touching.push_back(contact.shape_b);
  }
  std::ranges::sort(touching);
  EXPECT_EQ(touching, (std::vector<u32>{1, 2}));
  const std::vector<BodyRay> rays = {{.origin = {-1, 0, 5}, .direction = {0, 0, -1}},
                                     {.origin = {0, 0, 5}, .direction = {0, 0, -1}},
                                     {.origin = {9, 0, 5}, .direction = {0, 0, 1}},
                                     {.origin = {1, 0, 5}, .direction = {0, 0, -1}}};
  const std::vector<std::optional<BodyHit>> hits = world.cast_rays(rays);
  ASSERT_EQ(hits.size(), 4u);
  EXPECT_EQ(hits[0]->shape, 2u);
  EXPECT_EQ(hits[1]->shape, 0u);
  EXPECT_FALSE(hits[2]);
  EXPECT_EQ(hits[3]->shape, 1u);
  EXPECT_EQ(hits[3]->body, body);
  EXPECT_TRUE(world.cast_rays({}).empty());
}

// A box, a grid of two by one cells beside it, and behind that a ball: the triangles are no shapes.
TEST(World, TellsShapesAndTheirTriangles) {
  Scene scene = ground_scene();
  BodyDescription yard;
  yard.kind = BODY_STATIC;
  yard.position = {0, 0, 1};
  std::string flaw;
  yard.shapes = {{.kind = SHAPE_BOX, .offset = {-5, 0, -0.5}, .half_extents = {0.5, 0.5, 0.5}},
                 {.kind = SHAPE_FACET, .surface = make_surface(height_field({{0, 0, 0}, {0, 0, 0}}, 1), flaw)},
                 {.kind = SHAPE_SPHERE, .offset = {5, 0, -0.5}, .radius = 0.5}};
  ASSERT_EQ(flaw, "");
  World world(scene, in_double());
  const BodyHandle body = world.add(yard);
  BodyDescription pebble = ball_at({0, 0, 0});
  pebble.shapes[0].radius = 0.05;
  const std::pair<Vector3, std::optional<u32>> spots[] = {{{-5, 0, 1.05}, std::nullopt}, {{-0.2, -0.3, 1.05}, 0},
                                                          {{-0.8, 0.3, 1.05}, 1},        {{0.8, -0.3, 1.05}, 2},
                                                          {{0.2, 0.3, 1.05}, 3},         {{5, 0, 1.05}, std::nullopt}};
  std::map<u32, std::size_t> spot_of;
  for (std::size_t i = 0; i < std::size(spots); ++i) {
    pebble.position = spots[i].first;
    spot_of[world.add(pebble).id] = i;
  }
  world.step();
  const auto shape_at = [](std::size_t spot) { return spot == 0 ? 0u : spot == 5 ? 2u : 1u; };
  std::set<std::size_t> told;
  for (const BodyContact& contact : world.contacts()) {
    const bool is_a = contact.a == body;
    const std::size_t spot = spot_of.at((is_a ? contact.b : contact.a).id);
    EXPECT_EQ(is_a ? contact.shape_a : contact.shape_b, shape_at(spot)) << spot;
    EXPECT_EQ(is_a ? contact.triangle_a : contact.triangle_b, spots[spot].second) << spot;
    EXPECT_EQ(is_a ? contact.triangle_b : contact.triangle_a, std::nullopt);
    told.insert(spot);
  }
  EXPECT_EQ(told.size(), 6u);
  for (std::size_t i = 0; i < std::size(spots); ++i) {
    const Vector3& at = spots[i].first;
    const std::optional<BodyHit> hit = world.cast_ray({at[0] + 0.07, at[1], 3}, {0, 0, -1});
    ASSERT_TRUE(hit) << i;
    EXPECT_EQ(hit->body, body) << i;
    EXPECT_EQ(hit->shape, shape_at(i)) << i;
    EXPECT_EQ(hit->triangle, spots[i].second) << i;
  }
}

// Bits follow the order in which the file names categories first, whether a shape is of them or meets them.
TEST(World, NamesCategoriesInMasks) {
  World world(parse_scene(R"({"bodies": [
    {"name": "wall", "type": "static", "position": [1, 0, 0], "shapes": [
      {"type": "sphere", "radius": 0.1, "category": "walls", "collides_with": ["doors"]}]},
    {"name": "door", "type": "static", "position": [2, 0, 0], "shapes": [
      {"type": "sphere", "radius": 0.1, "category": "doors"}]},
    {"name": "ball", "mass": 1, "position": [3, 0, 0], "shapes": [{"type": "sphere", "radius": 0.1}]}]})",
                          "x.json"),
              in_double());
  EXPECT_EQ(world.category_mask({"default"}), 1u);
  EXPECT_EQ(world.category_mask({"walls"}), 2u);
  EXPECT_EQ(world.category_mask({"doors", "default"}), 5u);
  EXPECT_EQ(world.category_mask({}), 0u);
  const auto met = [&](const std::vector<std::string>& names) {
    const std::optional<BodyHit> hit = world.cast_ray({0, 0, 0}, {1, 0, 0}, 9, world.category_mask(names));
    return hit ? world.description(hit->body).name : "nothing";
  };
  EXPECT_EQ(met({"walls"}), "wall");
  EXPECT_EQ(met({"default", "doors"}), "door");
  EXPECT_EQ(met({"default"}), "ball");
  EXPECT_EQ(met({}), "nothing");
  EXPECT_EQ(world.overlapping_sphere({0, 0, 0}, 9, world.category_mask({"doors"})), std::vector{*world.find("door")});
  EXPECT_EQ(refusal([&] {
              world.category_mask({"walls", "door"});
            }),
            "mask: unknown category \"door\"; did you mean \"doors\"?");
  EXPECT_EQ(refusal([&] { World(empty_scene(), in_double()).category_mask({"walls"}); }),
            "mask: unknown category \"walls\"; known: default");
}

TEST(World, TellsWhoIsInAVolume) {
  World world(ground_scene(), in_double());
  const BodyHandle floor = *world.find("floor");
  const BodyHandle first = world.add(box_at({0, 0, 5})), second = world.add(box_at({1.2, 0, 5}));
  BodyDescription hidden = box_at({2.4, 0, 5});
  hidden.shapes[0].category = 4;
  const BodyHandle third = world.add(hidden);
  using Found = std::vector<BodyHandle>;
  EXPECT_EQ(world.overlapping_sphere({0.6, 0, 5}, 0.09), Found());  // gaps of 0.1 on either side
  EXPECT_EQ(world.overlapping_sphere({0.6, 0, 5}, 0.11), (Found{first, second}));
  EXPECT_EQ(world.overlapping_sphere({1.8, 0, 5}, 0.11, 4), Found{third});
  EXPECT_EQ(world.overlapping_sphere({0, 0, 0.2}, 0.3), Found{floor});
  // a rod through all three, straight and then turned by a right angle
  EXPECT_EQ(world.overlapping_box({.position = {1.2, 0, 5}}, {2, 0.1, 0.1}), (Found{first, second, third}));
  const Quaternion across = exact::rotation({0, 0, 1}, std::sqrt(0.5), std::sqrt(0.5));
  EXPECT_EQ(world.overlapping_box({{1.2, 0, 5}, across}, {2, 0.1, 0.1}), Found{second});
  EXPECT_EQ(refusal([&] { world.overlapping_sphere({0, 0, 0}, -1); }), "volume 0: must have a size > 0");
}

}  // namespace
}  // namespace lockstep::world_queries_test
