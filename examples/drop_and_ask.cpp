// Bodies that come and go, what they tell, and rays: a pile that is fed from above and cleared from below.
#include <cstdio>
#include <lockstep/world.hpp>
#include <vector>

using namespace lockstep;

int main() {
  Scene scene;
  scene.name = "pile";
  scene.settings.events = true;
  BodyDescription floor;
  floor.kind = BODY_STATIC;
  floor.shapes.push_back({.kind = SHAPE_PLANE});
  scene.bodies.push_back(floor);
  World world(scene);

  BodyDescription ball;
  ball.shapes.push_back({.kind = SHAPE_SPHERE, .radius = 0.25});
  make_solid(ball, 1000);

  std::vector<BodyHandle> balls;
  int touches = 0;
  for (int step = 0; step < 240; ++step) {
    if (step % 30 == 0) {
      ball.position = {0, 0, 4};
      balls.push_back(world.add(ball));
    }
    world.step();
    for (const BodyEvent& event : world.events()) touches += event.kind == EVENT_CONTACT_BEGIN;
  }
  if (const auto hit = world.cast_ray({0, 0, 10}, {0, 0, -1}))
    std::printf("from above a ray meets body %u, %.2f m over the floor\n", hit->body.id, 10 - hit->distance);

  double weight = 0;
  for (const BodyContact& contact : world.contacts())
    if (!(world.description(contact.b).kind == BODY_DYNAMIC)) weight += contact.impulse[2] / scene.settings.dt;
  std::printf("%d touches began; the floor carries %.0f N\n", touches, weight);

  world.remove(balls.front());
  world.step();
  std::printf("%zu bodies are left, and the first ball is %s\n", world.bodies().size(),
              world.contains(balls.front()) ? "there" : "gone");
}
