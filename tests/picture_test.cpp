// What pictures are made of and what is written on them: cameras, meshes, colours, legends, files. No EGL is needed.
#include <gtest/gtest.h>
#include <png.h>

#include <cmath>
#include <set>

#include "host/backends/reference_backend.hpp"
#include "host/render/legend.hpp"
#include "host/render/marks.hpp"
#include "host/render/mesh.hpp"
#include "host/render/scene_model.hpp"
#include "host/render/text.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"
#include "host/simulation.hpp"

namespace lockstep::picture_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

TEST(Camera, SeesItsTargetInTheMiddleAndUpUp) {
  const Camera camera = {Vector3d(3, -4, 2), Vector3d(1, 1, 0), 50};
  const Vector3d middle = camera.project(camera.target, 640, 480);
  EXPECT_NEAR(middle.x(), 320, 1e-9);
  EXPECT_NEAR(middle.y(), 240, 1e-9);
  EXPECT_NEAR(middle.z(), (camera.target - camera.position).norm(), 1e-9);
  EXPECT_LT(camera.project(camera.target + Vector3d(0, 0, 0.1), 640, 480).y(), 240);
  // what is half the angle of view above the axis is at the upper edge
  const double distance = middle.z();
  const Vector3d edge = camera.target + distance * std::tan(25 * EIGEN_PI / 180) * camera.axes().col(1);
  EXPECT_NEAR(camera.project(edge, 640, 480).y(), 0, 1e-9);
}

TEST(Camera, TheMatrixSaysWhatProjectSays) {
  const Camera camera = {Vector3d(3, -4, 2), Vector3d(1, 1, 0), 50};
  const Vector3d point(0.3, 0.7, -0.4);
  const Eigen::Vector4d clip = camera.view_projection(640.0 / 480, 0.1, 100) * point.homogeneous();
  const Vector3d pixel = camera.project(point, 640, 480);
  EXPECT_NEAR(320 * (1 + clip.x() / clip.w()), pixel.x(), 1e-9);
  EXPECT_NEAR(240 * (1 - clip.y() / clip.w()), pixel.y(), 1e-9);
}

TEST(Camera, FramesAllOfARegion) {
  for (const Vector3d& half : {Vector3d(1, 1, 1), Vector3d(10, 0.1, 2), Vector3d(0.1, 8, 0.2), Vector3d(1, 1, 30)}) {
    Region region;
    region.extend(Vector3d(5, 6, 7) - half);
    region.extend(Vector3d(5, 6, 7) + half);
    const Camera camera = frame_region(region, 16.0 / 9);
    double widest = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const Vector3d at = camera.project(region.corner(static_cast<Region::CornerType>(corner)), 1280, 720);
      EXPECT_GT(at.z(), 0);
      widest = std::max({widest, std::abs(at.x() - 640) / 640, std::abs(at.y() - 360) / 360});
    }
    EXPECT_LT(widest, 0.95) << half.transpose();
    EXPECT_GT(widest, 0.8) << half.transpose();
  }
}

TEST(Camera, LeavesOutWhatFlewOffAndWhatIsHuge) {
  std::vector<Extent> extents;
  for (int i = 0; i < 100; ++i) extents.push_back({Vector3d(i % 10, i / 10, 0.5), Vector3d::Constant(0.5), true});
  const Region pile = region_of(extents);
  EXPECT_TRUE(pile.isApprox(Region(Vector3d(-0.5, -0.5, 0), Vector3d(9.5, 9.5, 1))));
  extents.push_back({Vector3d(5000, 0, 900), Vector3d::Constant(0.5), true});
  extents.push_back({Vector3d(0, 0, -50), Vector3d::Constant(50), false});
  EXPECT_TRUE(region_of(extents).isApprox(pile));
  extents.push_back({Vector3d(11, 5, 0.5), Vector3d(0.1, 2, 0.5), false});  // a low wall beside them
  EXPECT_NEAR(region_of(extents).max().x(), 11.1, 1e-9);
  EXPECT_TRUE(region_of({}).isEmpty());
}

// A sixth of the sum of the corners' triple products: positive where triangles turn outwards.
double volume(const Mesh& mesh) {
  double sum = 0;
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const auto corner = [&](std::size_t k) {
      return mesh.vertices[mesh.indices[i + k]].position.cast<double>().eval();
    };
    sum += corner(0).dot(corner(1).cross(corner(2))) / 6;
  }
  return sum;
}

TEST(Meshes, HaveTheVolumeOfTheirShape) {
  EXPECT_NEAR(volume(box_mesh()), 8, 1e-6);
  EXPECT_NEAR(volume(sphere_mesh(4)), 4 * EIGEN_PI / 3, 0.02);
  EXPECT_EQ(sphere_mesh(2).indices.size(), 3u * 320);
  // a prism of n sides: n sin(2 pi / n) / 2 times its height
  EXPECT_NEAR(volume(cylinder_mesh(24, true)), 24 * std::sin(2 * EIGEN_PI / 24), 1e-5);
  // open below, but the plane of the hole goes through the origin
  EXPECT_NEAR(volume(hemisphere_mesh(96)), 2 * EIGEN_PI / 3, 0.01);
  // a tetrahedron
  const std::vector<Vector3f> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  EXPECT_NEAR(volume(polytope_mesh(points, {0, 3, 6, 9, 12}, {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3})), 1.0 / 6, 1e-7);
}

TEST(Meshes, NormalsPointOutwards) {
  for (const Mesh& mesh : {box_mesh(), sphere_mesh(1), cylinder_mesh(12, true), hemisphere_mesh(12)}) {
    for (const Vertex& v : mesh.vertices) {
      EXPECT_NEAR(v.normal.norm(), 1, 1e-6);
      EXPECT_GT(v.normal.dot(v.position), 0.2f);
    }
  }
}

TEST(Colors, GoFromDarkToBright) {
  EXPECT_EQ(scale_color(-1), scale_color(0));
  EXPECT_EQ(scale_color(7), scale_color(1));
  double last = -1;
  for (int i = 0; i <= 50; ++i) {  // luminance, Rec. 709
    const Color c = scale_color(i / 50.0);
    const double luminance = 0.2126 * double(c[0]) + 0.7152 * double(c[1]) + 0.0722 * double(c[2]);
    EXPECT_GT(luminance, last);
    last = luminance;
  }
}

TEST(Colors, OfEightRunningBodiesAllDiffer) {
  std::set<std::vector<Color>> orders;
  for (u32 first = 0; first < 800; first += 8) {
    std::vector<Color> order;
    for (u32 id = first; id < first + 8; ++id) order.push_back(body_color(id));
    EXPECT_EQ(std::set<Color>(order.begin(), order.end()).size(), body_colors().size());
    orders.insert(order);
  }
  EXPECT_GT(orders.size(), 16u) << "no stripes";
}

TEST(Legend, RoundsItsScaleUp) {
  for (const auto& [value, rounded] : {std::pair(1.0, 1.0),
                                       {1.1, 2.0},
                                       {2.2, 2.5},
                                       {3.0, 5.0},
                                       {7.0, 10.0},
                                       {0.00031, 0.0005},
                                       {0.0, 1.0},
                                       {-3.0, 1.0}})
    EXPECT_NEAR(round_scale(value), rounded, 1e-12 * rounded) << value;
}

TEST(Legend, ShowsTheColoursOfItsScale) {
  Picture picture(1280, 720);
  Legend legend;
  legend.title = "speed, m/s";
  legend.scale = Legend::Scale{0, 5, true, false};
  const PixelRect bar = draw_legend(picture, legend);
  ASSERT_GT(bar.x1 - bar.x0, 100);
  ASSERT_GT(bar.y1 - bar.y0, 8);
  EXPECT_LT(bar.x1, 1280);
  for (int x = bar.x0; x < bar.x1; x += 7) {
    const Color wanted = scale_color((x - bar.x0 + 0.5) / (bar.x1 - bar.x0));
    for (const int y : {bar.y0, bar.y1 - 1}) {
      for (std::size_t i = 0; i < 3; ++i)
        EXPECT_NEAR(picture.at(static_cast<u32>(x), static_cast<u32>(y))[i], 255 * double(wanted[i]), 0.51);
    }
  }
}

// Beside the paper, and in the margins of it, there is no ink.
TEST(Legend, FitsTheLongNumbersOfItsScale) {
  Picture picture(960, 540);
  Legend legend = {"short", Legend::Scale{0, 1.25e-4, true, false}, {}};
  const PixelRect bar = draw_legend(picture, legend);
  const u32 below = static_cast<u32>(bar.y1) + 12;  // among the numbers
  u32 first = 960, last = 0, paper_from = 960, paper_to = 0;
  for (u32 x = 0; x < 960; ++x) {
    for (u32 y = below - 4; y < below + 4; ++y) {
      const int shade = picture.at(x, y)[0];
      if (shade > 150) paper_from = std::min(paper_from, x), paper_to = std::max(paper_to, x);
      if (shade > 20 && shade < 150) first = std::min(first, x), last = std::max(last, x);
    }
  }
  EXPECT_GT(first, paper_from + 4);
  EXPECT_LT(first, static_cast<u32>(bar.x0));
  EXPECT_GT(last, static_cast<u32>(bar.x1));
  EXPECT_LT(last + 4, paper_to);
}

TEST(Legend, FitsIntoASmallPicture) {
  Picture picture(64, 64);
  Legend legend = {"a title that is much too long for it", Legend::Scale(), {{{still_color}, "an entry"}}};
  draw_legend(picture, legend);
  draw_caption(picture, {"a scene with a long name", "and more"});
}

TEST(Text, IsAsWideAsItSays) {
  Picture picture(400, 60);
  const std::string text = "Hg (0.25 m/s), Wq_";
  draw_text(picture, 10, 10, 20, {1, 1, 1}, text);
  u32 left = 400, right = 0, top = 60;
  for (u32 y = 0; y < 60; ++y) {
    for (u32 x = 0; x < 400; ++x) {
      if (picture.at(x, y)[0] < 128) continue;
      left = std::min(left, x), right = std::max(right, x), top = std::min(top, y);
    }
  }
  EXPECT_NEAR(left, 10, 1.5);
  EXPECT_NEAR(right, 10 + text_width(text, 20), 1.5);
  EXPECT_NEAR(top, 10, 1.5);
}

TEST(Png, StoresThePicture) {
  Picture picture(37, 21);
  for (std::size_t i = 0; i < picture.bytes.size(); ++i) picture.bytes[i] = static_cast<unsigned char>(i * i / 7);
  const std::vector<unsigned char> file = encode_png(picture);
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  ASSERT_NE(png_image_begin_read_from_memory(&image, file.data(), file.size()), 0);
  EXPECT_EQ(image.width, 37u);
  EXPECT_EQ(image.height, 21u);
  image.format = PNG_FORMAT_RGB;
  std::vector<unsigned char> bytes(PNG_IMAGE_SIZE(image));
  ASSERT_NE(png_image_finish_read(&image, nullptr, bytes.data(), 0, nullptr), 0);
  EXPECT_EQ(bytes, picture.bytes);
}

// The box of a body without shapes has the moments it was given: those of 1 x 2 x 3 m and 12 kg are m (b^2 + c^2) / 12.
TEST(SceneModel, DrawsABareBodyAsTheBoxOfItsMoments) {
  const Scene scene = parse_scene(R"({"bodies": [{"mass": 12, "inertia": [13, 10, 5], "position": [1, 2, 3]}]})", "");
  const Buffers<double> buffers = compile_shapes<double>(scene);
  const SceneModel model(buffers);
  const std::vector<Extent> extents = model.extents(poses_of(buffers.positions, buffers.orientations));
  ASSERT_EQ(extents.size(), 1u);
  EXPECT_TRUE(extents[0].half.isApprox(Vector3d(0.5, 1, 1.5), 1e-5)) << extents[0].half.transpose();
  EXPECT_TRUE(extents[0].center.isApprox(Vector3d(1, 2, 3)));
}

TEST(SceneModel, KeepsShapesThatAreNotSimulated) {
  const Scene scene = parse_scene(R"({"bodies": [{"mass": 1, "shapes": [{"type": "sphere", "radius": 2}]}]})", "");
  EXPECT_TRUE(compile<float>(scene).buffers.shapes.empty());
  EXPECT_EQ(compile_shapes<float>(scene).shapes.size(), 1u);
}

TEST(SceneModel, DrawsEveryKindOfShape) {
  const Scene scene = read_scene("cylinders_and_hulls");
  const Buffers<float> buffers = compile_shapes<float>(scene);
  const SceneModel model(buffers);
  EXPECT_EQ(model.bodies(), buffers.body_infos.size());
  const std::vector<Extent> extents = model.extents(poses_of(buffers.positions, buffers.orientations));
  std::size_t bounded = 0;
  for (const ShapeInfo& info : buffers.shape_infos) bounded += info.kind != SHAPE_PLANE;
  EXPECT_EQ(extents.size(), bounded);
}

// What the floor gives to a ball of 3 kg at rest on it is m g, where they touch.
TEST(Marks, TellWhereContactsPushAndHowHard) {
  const Scene scene = parse_scene(
      R"({"settings": {"solver": "small_steps"}, "bodies": [
          {"type": "static", "shapes": [{"type": "plane"}]},
          {"mass": 3, "position": [0.2, 0.3, 0.5], "shapes": [{"type": "sphere", "radius": 0.5}]}]})",
      "");
  InitialState<double> state = compile<double>(scene);
  const StepParams<double> params = state.params;
  Simulation<double> simulation(std::make_unique<ReferenceBackend<double>>(std::move(state)), params);
  for (int i = 0; i < 60; ++i) simulation.step();
  const Buffers<double>& current = simulation.backend().download(contact_mark_buffers(state.features));
  const std::vector<ContactMark> marks = contact_marks(current, simulation.counters()[COUNTER_CONTACTS], params.dt);
  ASSERT_EQ(marks.size(), 1u);
  EXPECT_TRUE(marks[0].point.isApprox(Vector3f(0.2f, 0.3f, 0), 1e-3f)) << marks[0].point.transpose();
  EXPECT_TRUE(marks[0].force.isApprox(Vector3f(0, 0, 3 * 9.81f), 1e-3f)) << marks[0].force.transpose();
}

// A hinge stays where it was made while the first body turns about its axis.
TEST(Marks, TellWhereJointsAre) {
  const Scene scene = parse_scene(
      R"({"bodies": [{"name": "bar", "mass": 1, "position": [1, 0, 0], "shapes": [{"type": "box", "size": [2, 0.1, 0.1]}]}],
          "joints": [{"type": "hinge", "bodies": ["bar", "world"], "anchor": [0, 0, 0], "axis": [0, 2, 0]}]})",
      "");
  const InitialState<double> state = compile<double>(scene);
  const double half = std::sqrt(0.5);  // a quarter of a turn about y: the bar points down
  const std::vector<Vec4<double>> x = {{0, 0, -1, 0}}, q = {{0, half, 0, half}};
  const std::vector<JointMark> marks = joint_marks(state.buffers, x, q);
  ASSERT_EQ(marks.size(), 1u);
  EXPECT_LT(marks[0].anchor_a.norm(), 1e-6f) << marks[0].anchor_a.transpose();
  EXPECT_LT(marks[0].anchor_b.norm(), 1e-6f);
  EXPECT_NEAR(std::abs(marks[0].axis.y()), 1, 1e-6f) << marks[0].axis.transpose();
  EXPECT_TRUE(marks[0].center_a.isApprox(Vector3f(0, 0, -1)));
}

}  // namespace
}  // namespace lockstep::picture_test
