// Seams between bodies of which some are kinematic: twins, closed forms of where neighbours are, and grounds that move.
#include "cpu_reference/move_seams.hpp"

#include <gtest/gtest.h>

#include "tests/library_worlds.hpp"
#include "tests/shapes/seam_scenes.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::move_seams_test {
namespace {

using namespace seam_scenes;

template <class real>
class MoveSeams : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(MoveSeams, Precisions);

// Tiles of which every second one is kinematic, carried off to where they are askew.
template <class real>
InitialState<real> carried_tiles(int along, int across) {
  std::vector<BodyDescription> bodies = rotated(laid(tiles(0.4, along, across), box), askew);
  for (std::size_t i = 0; i < bodies.size(); i += 2) bodies[i].kind = BODY_KINEMATIC;
  bodies.push_back(solid(sphere(0.1), {0, 0, 0.1}));
  InitialState<real> state = compile<real>(scene_of(bodies, 0.5));
  return state;
}

TYPED_TEST(MoveSeams, KernelMatchesReference) {
  for (const int across : {1, 6, 40}) {
    InitialState<TypeParam> state = carried_tiles<TypeParam>(14, across);
    ASSERT_TRUE(has(state.features, Feature::moving_seams));
    run_one_stage<TypeParam>(Stage::move_seams, state.buffers, state.sizes, state.features, state.params);
  }
}

// The corners of a neighbour are where they are in the world, whichever way they are computed.
TYPED_TEST(MoveSeams, NeighboursAreWhereTheirBodiesAre) {
  using real = TypeParam;
  InitialState<real> state = carried_tiles<real>(6, 4);
  Buffers<real>& b = state.buffers;
  const Quaternion rotation = exact::multiply(exact::rotation({0.6, 0, 0.8}, std::sqrt(0.3), std::sqrt(0.7)), askew);
  for (std::size_t i = 0; i + 1 < b.positions.size(); i += 2) {
    b.positions[i].z += static_cast<real>(0.125 * static_cast<double>(i));
    b.orientations[i] = {static_cast<real>(rotation[0]), static_cast<real>(rotation[1]), static_cast<real>(rotation[2]),
                         static_cast<real>(rotation[3])};
  }
  b.current_seams.resize(b.seams.size());
  reference::move_seams(b, state.params);
  const auto position = [&](u32 body) {
    return Vector3{double(b.positions[body].x), double(b.positions[body].y), double(b.positions[body].z)};
  };
  const auto orientation = [&](u32 body) {
    const Vec4<real>& q = b.orientations[body];
    return Quaternion{double(q.x), double(q.y), double(q.z), double(q.w)};
  };
  const double rounding = 64 * double(std::numeric_limits<real>::epsilon());
  u32 checked = 0;
  for (std::size_t k = 0; k < b.seams.size(); ++k) {
    const auto [shape, neighbour] = b.seam_sides[k];
    if (neighbour == NONE) continue;
    const Seam<real>& seam = b.current_seams[k];
    const u32 body = b.shape_infos[shape].body, other = b.shape_infos[neighbour].body;
    const Quaternion q = {double(seam.rotation[0]), double(seam.rotation[1]), double(seam.rotation[2]),
                          double(seam.rotation[3])};
    for (const Vector3& corner : {Vector3{0.2, 0.2, 0.2}, Vector3{-0.2, 0.2, -0.2}}) {
      const Vector3 own = exact::add({double(seam.offset[0]), double(seam.offset[1]), double(seam.offset[2])},
                                     exact::rotate(q, corner));
      const Vector3 through = exact::add(position(body), exact::rotate(orientation(body), own));
      const Vector3 wanted = exact::add(position(other), exact::rotate(orientation(other), corner));
      for (unsigned axis = 0; axis < 3; ++axis) EXPECT_NEAR(through[axis], wanted[axis], rounding);
    }
    ++checked;
  }
  EXPECT_GT(checked, 20u);
}

// Static ground, and a kinematic body with no other beside it, have no such seams.
TEST(MovingSeams, OnlyWhatIsKinematicMoves) {
  EXPECT_FALSE(has(compile<float>(scene_of(laid(tiles(), box), 0.5)).features, Feature::moving_seams));
  const Scene alone = scene_of({compound(laid(tiles(), box), BODY_KINEMATIC), solid(sphere(0.1), {0, 0, 0.1})}, 0.5);
  EXPECT_TRUE(has(compile<float>(alone).features, Feature::seams));
  EXPECT_FALSE(has(compile<float>(alone).features, Feature::moving_seams));
}

// Kinematic tiles that move as one are one ground, askew and far from where they began, too: what slides on them
// without friction keeps its velocity, and stays as high above them.
TEST(MovingSeams, TilesThatMoveAsOneAreOneGround) {
  for (const char* precision : {"float", "double"}) {
    for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps}) {
      SCOPED_TRACE(std::string(precision) + ", " + std::string(name_of(solver)));
      std::vector<BodyDescription> bodies = rotated(laid(tiles(), box), askew);
      for (BodyDescription& body : bodies) {
        body.kind = BODY_KINEMATIC;
        body.velocity = {-3, 1, 0.5};
      }
      const Vector3 start = {0.5, 0.2, 0.1}, velocity = {-2, 1.1, 0.5};
      bodies.push_back(solid(box({0.1, 0.1, 0.1}), start, velocity, askew));
      World world(scene_of(bodies, 0, solver), {.device = "reference", .precision = precision});
      world.step(120);
      const Pose pose = world.pose(world.bodies().back());
      for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(pose.position[k], start[k] + 2 * velocity[k], 3e-3) << k;
      EXPECT_LT(exact::length(world.velocity(world.bodies().back()).angular), 1e-2);
    }
  }
}

// Where a kinematic tile sinks its neighbours end: a ball falls into the hole and is struck by the last edge; where it
// comes back the ground is whole again.
TEST(MovingSeams, ATileThatSinksLeavesEdgesUntilItComesBack) {
  std::vector<BodyDescription> bodies = laid(tiles(), box);
  std::size_t moved = 0;
  for (std::size_t i = 0; i < bodies.size(); ++i)
    if (std::abs(bodies[i].position[0] - 0.6) < 1e-9 && std::abs(bodies[i].position[1] - 0.2) < 1e-9) moved = i;
  bodies[moved].kind = BODY_KINEMATIC;
  bodies.push_back(solid(box({0.1, 0.1, 0.1}), {-0.9, 0.2, 0.1}, {1, 0, 0}));
  for (const bool back : {false, true}) {
    World world(scene_of(bodies, 0), in_double());
    const BodyHandle tile = world.bodies()[moved];
    world.set_velocity(tile, {{0, 0, -1}, {0, 0, 0}});
    world.step(30);
    world.set_velocity(tile, {{0, 0, back ? 1.0 : 0.0}, {0, 0, 0}});
    world.step(30);
    world.set_velocity(tile, {});
    world.step(60);
    const Pose pose = world.pose(world.bodies().back());
    if (back) {
      EXPECT_NEAR(pose.position[0], -0.9 + 120.0 / 60, 1e-3);
      EXPECT_NEAR(pose.position[2], 0.1, 1e-3);
    } else {
      EXPECT_LT(pose.position[2], 0.05);
      EXPECT_LT(pose.position[0], 0.8);
    }
  }
}

}  // namespace
}  // namespace lockstep::move_seams_test
