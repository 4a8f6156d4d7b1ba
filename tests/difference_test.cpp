// The picture of a difference that `lockstep check` found. It needs EGL: where there is none the tests fail, and say
// what to install.
#include "host/render/difference.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <optional>

#include "host/backends/checked_backend.hpp"
#include "host/scene/read.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep::difference_test {
namespace {

constexpr u32 width = 480, height = 320;

struct Found {
  DifferenceLocation location;
  Difference difference;
  Picture picture;
  std::vector<RenderPose> device_poses, reference_poses;
};

// What stepping a scene under a patch finds, drawn.
std::optional<Found> find_and_draw(const std::string& name, const KernelPatch& patch, int steps) {
  const Scene scene = read_scene(name);
  const InitialState<float> state = compile<float>(scene);
  DeviceOptions options;
  options.patches = {patch};
  CheckedBackend<float> backend(state, test_device(), options);
  try {
    for (int i = 0; i < steps; ++i) step(backend, state.params);
  } catch (const Mismatch& mismatch) {
    const Difference& d = mismatch.difference();
    const Buffers<float>& reference = backend.reference_buffers();
    const Buffers<float>& device = backend.device_buffers(d, difference_buffers(backend.features()));
    const DifferenceLocation location = location_of(d.buffer, d.element, d.word, reference);
    return Found{location, d,
                 draw_difference(device, reference, SceneModel(compile_shapes<float>(scene)), location,
                                 {mismatch.what()}, width, height),
                 poses_of(device.positions, device.orientations),
                 poses_of(reference.positions, reference.orientations)};
  }
  return std::nullopt;
}

// Pixels in which a colour's strongest part stands out.
int count_like(const Picture& picture, const Color& color) {
  int count = 0;
  const std::size_t most = static_cast<std::size_t>(std::max_element(color.begin(), color.end()) - color.begin());
  const std::size_t least = static_cast<std::size_t>(std::min_element(color.begin(), color.end()) - color.begin());
  for (u32 y = height / 4; y < height; ++y) {  // below the legend
    for (u32 x = 0; x < width; ++x) count += picture.at(x, y)[most] > picture.at(x, y)[least] + 60;
  }
  return count;
}

TEST(DifferencePicture, ShowsABodyAtAnotherPoseInBothColours) {
  const KernelPatch moved = {"integrate_positions.cl", "positions[i] = position;",
                             "if (i == 3u) position.x += 1.5f;\n    positions[i] = position;"};
  const auto found = find_and_draw("spheres_small", moved, 2);
  ASSERT_TRUE(found) << "the patch changed nothing";
  EXPECT_EQ(found->difference.buffer, Buffer::positions);
  EXPECT_EQ(found->location.bodies, std::vector<u32>{3});
  EXPECT_NEAR((found->device_poses[3].position - found->reference_poses[3].position).x(), 1.5f, 1e-4f);
  EXPECT_GT(count_like(found->picture, device_color), 500);
  EXPECT_GT(count_like(found->picture, reference_color), 500);
}

TEST(DifferencePicture, ShowsWhatDiffersByLessThanIsSeen) {
  const KernelPatch wrong = {"integrate_velocities.cl", "motions[i] = motion;",
                             "if (i == 3u) motion.w[1] = 1.5f;\n    motions[i] = motion;"};
  const auto found = find_and_draw("spheres_small", wrong, 1);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->location.bodies, std::vector<u32>{3});
  EXPECT_GT(count_like(found->picture, shared_color), 500);
}

TEST(DifferencePicture, FindsTheBodiesOfAContact) {
  const KernelPatch wrong = {"pack_points.cl", "block->anchor_a_x[lane] = point.anchor_a[0];",
                             "block->anchor_a_x[lane] = 1.0f + point.anchor_a[0];"};
  const auto found = find_and_draw("spheres_small", wrong, 200);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->difference.stage, Stage::pack_points);
  EXPECT_NE(found->location.contact, NONE);
  EXPECT_EQ(found->location.bodies.size(), 2u);
}

// From tables by hand: each domain leads to its bodies.
TEST(DifferencePicture, KnowsWhatAWordBelongsTo) {
  Buffers<float> state;
  state.positions.resize(4);
  state.shape_infos.resize(3);
  state.shape_infos[2].body = 1;
  state.contacts.resize(2);
  state.contacts[1].body_a = 3;
  state.contacts[1].body_b = 2;
  state.block_bodies.resize(2);
  state.block_bodies[1].contact[5] = 1;
  state.block_rows = {{0, 2}, {2, 3}};
  const auto bodies = [&](Buffer buffer, std::size_t element, u32 word) {
    return location_of(buffer, element, word, state).bodies;
  };
  EXPECT_EQ(bodies(Buffer::positions, 2, 1), std::vector<u32>{2});
  EXPECT_EQ(bodies(Buffer::motions, 4, 0), std::vector<u32>()) << "the null body behind the last one";
  EXPECT_EQ(bodies(Buffer::bounds, 2, 0), std::vector<u32>{1});
  EXPECT_EQ(bodies(Buffer::contact_points, 1, 0), (std::vector<u32>{3, 2}));
  EXPECT_EQ(bodies(Buffer::contact_blocks, 4, 3 * PACK + 5), (std::vector<u32>{3, 2})) << "row 4 is of block 1";
  EXPECT_EQ(bodies(Buffer::contact_blocks, 9, 0), std::vector<u32>()) << "of no block";
  EXPECT_EQ(bodies(Buffer::counters, 3, 0), std::vector<u32>());
}

}  // namespace
}  // namespace lockstep::difference_test
