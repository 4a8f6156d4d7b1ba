// Kernels that are built before they are needed: other engines of the same state do what is expected, and are let go
// of.
#include "host/world/impl.hpp"

namespace lockstep {

// The first step is planned by what lists can hold, those after it by what the first one had in them.
void World::Impl::warm_up(const Scene& like, bool questions) {
  const std::unique_ptr<Engine> other = make_engine(like, options, engine.get(), index_map, true);
  try {
    for (int step = 0; step < 2; ++step) other->step(namer());
  } catch (const Error& error) {
    if (error.failure() != Failure::comparison) throw;  // a state that goes bad has built what there is to build
    return;
  }
  other->state_hash();
  if (!questions) return;
  const RayQuery ray = {.direction = {0, 0, -1}};
  other->cast_rays({&ray, 1});
  other->bodies_in({.kind = SHAPE_SPHERE, .radius = 1});
}

void World::Impl::warm_up(const Expected& expected) {
  if (scene.bodies.empty() && expected.bodies.empty())
    throw Error(Failure::input, "world", "has no bodies to be warmed up for; add one, or say which are expected");
  for (const BodyDescription& body : expected.bodies) validate(body, scene);
  if (!scene.bodies.empty() && !ready().has_kernels()) return;
  const bool questions = expected.questions && can_keep_shapes(scene);
  const auto with_and_without_forces = [&](Scene like) {
    if (like.bodies.empty()) return;
    warm_up(like, questions && (like.settings.keeps_shapes || shapes_can_touch(like)));
    if (questions && !like.settings.keeps_shapes && !shapes_can_touch(like)) {
      like.settings.keeps_shapes = true;
      warm_up(like, true);
    }
    if (!expected.forces || std::exchange(like.settings.loads, true)) return;
    warm_up(like, questions);
  };
  with_and_without_forces(scene);
  if (expected.bodies.empty()) return;
  Scene more = scene;
  more.bodies.insert(more.bodies.end(), expected.bodies.begin(), expected.bodies.end());
  with_and_without_forces(more);
}

void World::warm_up(const Expected& expected) { impl_->warm_up(expected); }

}  // namespace lockstep
