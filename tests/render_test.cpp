// Pictures against what light and perspective say must be in them. They need EGL: where there is none the tests fail,
// and say what to install.
#include <gtest/gtest.h>

#include <cmath>

#include "host/render/renderer.hpp"

namespace lockstep::render_test {
namespace {

using Eigen::Vector3d;
using Eigen::Vector3f;

constexpr u32 width = 480, height = 320;

Renderer& renderer() {
  static Renderer shared(width, height);
  return shared;
}

const unsigned char* pixel_at(const Picture& picture, const Camera& camera, const Vector3d& point) {
  const Vector3d at = camera.project(point, picture.width, picture.height);
  EXPECT_GT(at.z(), 0);
  return picture.at(static_cast<u32>(at.x()), static_cast<u32>(at.y()));
}

int brightness(const unsigned char* pixel) { return pixel[0] + pixel[1] + pixel[2]; }

bool is_red(const unsigned char* pixel) { return pixel[0] > 60 && pixel[0] > 2 * pixel[1] && pixel[0] > 2 * pixel[2]; }

constexpr double radius = 0.4;
const Vector3d ball_center(0.6, -0.5, 1.2);

Drawing red_ball() {
  Drawing drawing;
  drawing.camera = {Vector3d(4, -6, 3), Vector3d(0, 0, 0.5), 40};
  Solid ball;
  ball.position = ball_center.cast<float>();
  ball.scale.setConstant(static_cast<float>(radius));
  ball.color = {0.9f, 0.1f, 0.1f};
  drawing.solids.push_back(ball);
  drawing.region.extend(Vector3d(-1, -1, 0));
  drawing.region.extend(Vector3d(1, 1, 2));
  return drawing;
}

Drawing red_ball_over_floor() {
  Drawing drawing = red_ball();
  drawing.planes.emplace_back();
  return drawing;
}

// A ball is seen under the angle asin(radius / distance): the tangent cone, a little wider than the great circle.
TEST(Render, ABallIsWhereTheCameraSays) {
  const Drawing drawing = red_ball();
  const Picture picture = renderer().draw(drawing);
  const Camera& camera = drawing.camera;
  const Vector3d sight = ball_center - camera.position;
  const double rim = sight.norm() * std::tan(std::asin(radius / sight.norm()));
  const Vector3d right = sight.cross(Vector3d::UnitZ()).normalized(), up = right.cross(sight).normalized();
  EXPECT_TRUE(is_red(pixel_at(picture, camera, ball_center)));
  for (const Vector3d& direction : {right, Vector3d(-right), up, Vector3d(-up)}) {
    EXPECT_TRUE(is_red(pixel_at(picture, camera, ball_center + 0.94 * rim * direction))) << direction.transpose();
    EXPECT_FALSE(is_red(pixel_at(picture, camera, ball_center + 1.06 * rim * direction))) << direction.transpose();
  }
}

TEST(Render, WhatIsInFrontHidesWhatIsBehind) {
  Drawing drawing = red_ball();
  Solid wall;
  wall.form = Form::box;
  wall.position = (0.5 * (ball_center + drawing.camera.position)).cast<float>();
  wall.scale.setConstant(0.5f);
  drawing.solids.push_back(wall);
  EXPECT_FALSE(is_red(pixel_at(renderer().draw(drawing), drawing.camera, ball_center)));
  drawing.solids.back().position = (ball_center + 0.3 * (ball_center - drawing.camera.position)).cast<float>();
  EXPECT_TRUE(is_red(pixel_at(renderer().draw(drawing), drawing.camera, ball_center)));
}

// The shadow of a ball at height h has its middle h / l_z along the light from the point under it.
TEST(Render, TheShadowLiesWhereTheLightSays) {
  const Drawing with = red_ball_over_floor();
  Drawing without = with;
  without.solids.clear();
  const Picture shaded = renderer().draw(with), bare = renderer().draw(without);
  const Vector3d light = with.to_light.cast<double>();
  const Vector3d shadow = ball_center - ball_center.z() / light.z() * light;
  const Vector3d along = Vector3d(light.x(), light.y(), 0).normalized(), across(-along.y(), along.x(), 0);
  const double long_half = radius / light.normalized().z();  // of the ellipse, along the light
  const auto is_dark = [&](const Vector3d& point) {
    return brightness(pixel_at(shaded, with.camera, point)) < 0.8 * brightness(pixel_at(bare, with.camera, point));
  };
  EXPECT_TRUE(is_dark(shadow));
  for (const double side : {-1.0, 1.0}) {
    EXPECT_TRUE(is_dark(shadow + 0.85 * side * long_half * along));
    EXPECT_FALSE(is_dark(shadow + 1.15 * side * long_half * along));
    EXPECT_TRUE(is_dark(shadow + 0.85 * side * radius * across));
    EXPECT_FALSE(is_dark(shadow + 1.15 * side * radius * across));
  }
}

TEST(Render, TheSideTowardsTheSunIsBrighter) {
  Drawing drawing = red_ball();
  const Vector3d light = drawing.to_light.normalized().cast<double>();
  drawing.camera.position = ball_center + 5 * Vector3d(light.y(), -light.x(), 0.2);  // from the side
  drawing.camera.target = ball_center;
  const Picture picture = renderer().draw(drawing);
  EXPECT_GT(brightness(pixel_at(picture, drawing.camera, ball_center + 0.7 * radius * light)),
            1.3 * brightness(pixel_at(picture, drawing.camera, ball_center - 0.7 * radius * light)));
}

TEST(Render, FloorsHaveALineAtEachMetre) {
  Drawing drawing;
  drawing.planes.push_back({Vector3f(0, 0, -1), Eigen::Quaternionf::Identity()});
  drawing.camera = {Vector3d(0.5, 0.5, 5), Vector3d(0.5, 0.5, -1), 35};
  const Picture picture = renderer().draw(drawing);
  for (const double line : {-1.0, 0.0, 1.0, 2.0}) {
    const int on = brightness(pixel_at(picture, drawing.camera, {line, 0.53, -1}));
    for (const double away : {-0.33, -0.05, 0.05, 0.33})
      EXPECT_GT(brightness(pixel_at(picture, drawing.camera, {line + away, 0.53, -1})), on + 20) << line << " " << away;
    EXPECT_LT(brightness(pixel_at(picture, drawing.camera, {0.53, line, -1})),
              brightness(pixel_at(picture, drawing.camera, {0.53, line + 0.33, -1})) - 20);
  }
}

// A valley of two planes: each ends where the other begins, so that nothing of it is seen behind the other.
TEST(Render, FloorsEndWhereTheyMeet) {
  Drawing drawing;
  for (const float side : {-1.0f, 1.0f})
    drawing.planes.push_back({Vector3f::Zero(), Eigen::Quaternionf(Eigen::AngleAxisf(side * 0.6f, Vector3f::UnitY()))});
  drawing.camera = {Vector3d(0, -0.01, 6), Vector3d(0, 0, 0), 35};
  drawing.to_light = {0.5f, 0, 1};
  const Picture picture = renderer().draw(drawing);
  // the light comes from +x: the slope that faces it, on the left, is the brighter one
  const int left = brightness(pixel_at(picture, drawing.camera, {-1.03, 0.03, 1.03 * std::tan(0.6)}));
  const int right = brightness(pixel_at(picture, drawing.camera, {1.03, 0.03, 1.03 * std::tan(0.6)}));
  EXPECT_GT(left, right + 60);
}

TEST(Render, TheSameDrawingGivesTheSameBytes) {
  const Drawing drawing = red_ball_over_floor();
  const std::vector<unsigned char> first = encode_png(renderer().draw(drawing));
  EXPECT_EQ(encode_png(renderer().draw(drawing)), first);
}

TEST(Render, EdgesAreSmooth) {
  const Picture picture = renderer().draw(red_ball());
  // along a row through the ball's rim there are pixels of neither colour
  int mixed = 0;
  for (u32 y = 0; y < height; ++y) {
    for (u32 x = 1; x + 1 < width; ++x) {
      const int before = picture.at(x - 1, y)[1], here = picture.at(x, y)[1], after = picture.at(x + 1, y)[1];
      mixed += std::abs(before - after) > 100 && std::min(std::abs(here - before), std::abs(here - after)) > 20;
    }
  }
  EXPECT_GT(mixed, 20);
}

TEST(Render, MarksAreSeenThroughWhatIsInFront) {
  Drawing drawing = red_ball();
  const Picture without = renderer().draw(drawing);
  Solid mark;
  mark.position = ball_center.cast<float>();
  mark.scale.setConstant(0.1f);
  mark.color = {0, 0, 1};
  drawing.marks.push_back(mark);
  const Picture hidden = renderer().draw(drawing);
  const unsigned char* faint = pixel_at(hidden, drawing.camera, ball_center);
  EXPECT_GT(faint[2], pixel_at(without, drawing.camera, ball_center)[2] + 30);
  EXPECT_LT(faint[2], 160);
  drawing.solids.clear();
  EXPECT_GT(pixel_at(renderer().draw(drawing), drawing.camera, ball_center)[2], 230);
}

}  // namespace
}  // namespace lockstep::render_test
