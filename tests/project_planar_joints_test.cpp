// Bodies that planar joints to the world keep in a plane: twins, and 2-D worlds that stay 2-D.
#include "host/scene/read.hpp"
#include "tests/bodies.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/library_worlds.hpp"

namespace lockstep::test::project_planar_joints_test {
namespace {

template <class real>
class ProjectPlanarJoints : public testing::Test {};
using Precisions = testing::Types<float, double>;
TYPED_TEST_SUITE(ProjectPlanarJoints, Precisions);

ShapeDescription ball_of(double radius) {
  ShapeDescription shape;
  shape.kind = SHAPE_SPHERE;
  shape.radius = radius;
  return shape;
}

// A heap of boxes, capsules and spheres of a 2-D world, somewhat out of line with each other: contacts push across.
Scene flat_heap(u32 columns, u32 rows) {
  std::string bodies = R"({"type": "static", "shapes": [{"type": "plane"}]})";
  Random random(7);
  for (u32 i = 0; i < columns * rows; ++i) {
    const char* const shapes[] = {R"({"type": "box", "size": [0.4, 0.2, 0.3]})",
                                  R"({"type": "sphere", "radius": 0.15})",
                                  R"({"type": "capsule", "radius": 0.1, "length": 0.3})"};
    bodies += R"(, {"dof": "xz", "mass": )" + std::to_string(random.between(1, 4)) + R"(, "position": [)" +
              std::to_string(0.5 * (i % columns) + random.between(-0.1, 0.1)) + ", " +
              std::to_string(random.between(-0.05, 0.05)) + ", " + std::to_string(0.5 + 0.5 * (i / columns)) +
              R"(], "orientation": {"axis": [0, 1, 0], "angle": )" + std::to_string(random.between(-1, 1)) +
              R"(}, "shapes": [)" + shapes[i % 3] + "]}";
  }
  return parse_scene(R"({"settings": {"dt": 0.01}, "bodies": [)" + bodies + "]}", "flat_heap.json");
}

template <class real>
void run_twins(const Scene& scene, u32 steps) {
  InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  for (u32 i = 0; i < steps; ++i) step(backend, state.params);
  Buffers<real> off = backend.buffers();
  Random random(3);
  for (std::size_t i = 0; i < off.motions.size() - 1; ++i) {
    off.positions[i].y += static_cast<real>(random.between(-0.01, 0.01));
    off.motions[i].v[1] = off.motions[i].w[0] = static_cast<real>(random.between(-1, 1));
  }
  run_one_stage<real>(Stage::project_planar_joints, off, state.sizes, state.features, state.params);
}

TYPED_TEST(ProjectPlanarJoints, KernelMatchesReference) {
  using real = TypeParam;
  run_twins<real>(flat_heap(5, 5), 20);
  run_twins<real>(flat_heap(40, 3), 3);
  run_twins<real>(random_joints(5, 200, 300), 2);
}

TYPED_TEST(ProjectPlanarJoints, TwoDimensionsStayTwo) {
  using real = TypeParam;
  const Scene heap = flat_heap(5, 6);
  for (const Solver solver : {Solver::gauss_seidel, Solver::small_steps, Solver::jacobi}) {
    SCOPED_TRACE(name_of(solver));
    Scene scene = heap;
    replace_solver(scene.settings, solver);
    watch_steps<real>(scene, 300, [&](const Buffers<real>& b, u32 step) {
      for (std::size_t i = 1; i < scene.bodies.size(); ++i) {
        const double rounding = sizeof(real) == 4 ? 1e-7 : 1e-16;
        ASSERT_NEAR(double(b.positions[i].y), scene.bodies[i].position[1], rounding)
            << "body " << i << " step " << step;
        ASSERT_NEAR(double(b.motions[i].v[1]), 0, 20 * rounding);
        const Vector3 y = rotate({double(b.orientations[i].x), double(b.orientations[i].y), double(b.orientations[i].z),
                                  double(b.orientations[i].w)},
                                 {0, 1, 0});
        ASSERT_NEAR(std::hypot(y[0], y[2]), 0, 20 * rounding) << "body " << i << " step " << step;
      }
    });
  }
}

// In its plane a body moves as one that is free: thrown, it is where the closed form of the integrator says.
TYPED_TEST(ProjectPlanarJoints, LeavesThePlaneAlone) {
  using real = TypeParam;
  Scene scene = joint_scene({bare_body({0, 0, 0}, {0.1, 0.2, 0.3})},
                            {joint_of(JOINT_PLANAR, NONE, 0, {0, 0, 0}, {0, 1, 0})}, 0.01);
  scene.bodies[0].velocity = {2, 0, 5};
  scene.bodies[0].angular_velocity = {0, 3, 0};
  Scene free = scene;
  free.joints.clear();
  const Buffers<real> b = after_steps<real>(scene, 100), other = after_steps<real>(free, 100);
  const double rounding = sizeof(real) == 4 ? 2e-6 : 1e-14;
  for (int k = 0; k < 3; ++k) {
    EXPECT_NEAR(position(b, 0)[k], position(other, 0)[k], rounding);
    EXPECT_NEAR(double(b.motions[0].w[k]), double(other.motions[0].w[k]), rounding);
  }
}

// A ball that meets one of another plane off centre is pushed along its own plane alone: between the two, of mass m
// each, the normal n takes (n_x^2 + n_z^2) / m of each, and e = 0 leaves no speed along n.
TYPED_TEST(ProjectPlanarJoints, ABallIsPushedAlongItsPlane) {
  using real = TypeParam;
  const double across = 0.1, radius = 0.25;
  Scene scene = joint_scene({bare_body({0, 0, 0}), bare_body({2, across, 0})},
                            {joint_of(JOINT_PLANAR, NONE, 0, {0, 0, 0}, {0, 1, 0}),
                             joint_of(JOINT_PLANAR, NONE, 1, {2, across, 0}, {0, 1, 0})},
                            0.002);
  scene.gravity = {0, 0, 0};
  scene.materials = {{"smooth", 0, 0}};
  for (BodyDescription& body : scene.bodies) body.shapes = {ball_of(radius)};
  scene.bodies[0].velocity = {1, 0, 0};
  scene.settings.iterations = 40;
  const Buffers<real> b = after_steps<real>(scene, 1500);
  EXPECT_NEAR(double(b.motions[0].v[0]), 0.5, 1e-3);
  EXPECT_NEAR(double(b.motions[1].v[0]), 0.5, 1e-3);
  EXPECT_NEAR(position(b, 1)[1], across, 1e-7);
}

// Each has one joint, which goes with it.
TEST(PlanarBodies, HaveOneJointEach) {
  World world(flat_heap(2, 2), in_double());
  EXPECT_EQ(world.joints().size(), 4u);
  BodyDescription ball = ball_at({0, 0, 4});
  ball.plane_normal = {0, 1, 0};
  const BodyHandle added = world.add(ball);
  EXPECT_EQ(world.joints().size(), 5u);
  world.set_velocity(added, {{1, 1, 0}, {1, 1, 1}});
  world.step(20);
  EXPECT_EQ(world.velocity(added).linear[1], 0);
  EXPECT_EQ(world.pose(added).position[1], 0);
  world.remove(added);
  EXPECT_EQ(world.joints().size(), 4u);
}

}  // namespace
}  // namespace lockstep::test::project_planar_joints_test
