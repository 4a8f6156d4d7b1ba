#include "host/render/renderer.hpp"

#include <algorithm>
#include <cmath>

#include "host/render/egl_context.hpp"
#include "host/render/instances.hpp"
#include "host/render/shaders.hpp"
#include "host/render/targets.hpp"

namespace lockstep {

using Eigen::Matrix4f;
using Eigen::Vector3d;
using Eigen::Vector3f;
using Eigen::Vector4f;

namespace {

// A plane is a floor where it rises by less than 70 degrees.
constexpr float floor_slope = 0.35f;

// How far the camera and the things in the picture are from each other, and what follows from it.
struct View {
  float distance;  // m: to the middle of the region
  float radius;    // m: of the region
  Vector3f center;
  Matrix4f to_clip, to_shadow;
  float nearest_texel;  // m: size of a texel of the shadow map
};

View view_of(const Drawing& drawing, double aspect) {
  View view;
  const bool nothing = drawing.region.isEmpty();
  const Vector3d center = nothing ? drawing.camera.target : drawing.region.center();
  const double radius = std::max(nothing ? 1.0 : 0.5 * drawing.region.diagonal().norm(), 1e-3);
  const Camera& camera = drawing.camera;
  const double distance =
      std::max({(center - camera.position).norm(), (camera.target - camera.position).norm(), 0.5 * radius});
  view.distance = static_cast<float>(distance);
  view.radius = static_cast<float>(radius);
  view.center = center.cast<float>();
  view.to_clip = camera.view_projection(aspect, 0.01 * distance, 150 * distance).cast<float>();

  // the light sees the region, and what stands between the region and the sun
  const double half_width = 1.15 * radius;
  const Vector3d into = -drawing.to_light.cast<double>().normalized();
  const Vector3d right = into.cross(std::abs(into.z()) > 0.99 ? Vector3d::UnitY() : Vector3d::UnitZ()).normalized();
  Eigen::Matrix4d shadow = Eigen::Matrix4d::Identity();
  shadow.block<1, 3>(0, 0) = right.transpose() / half_width;
  shadow.block<1, 3>(1, 0) = right.cross(into).transpose() / half_width;
  shadow.block<1, 3>(2, 0) = into.transpose() / (4 * half_width);
  shadow.block<3, 1>(0, 3) = -shadow.block<3, 3>(0, 0) * center;
  view.to_shadow = shadow.cast<float>();
  view.nearest_texel = static_cast<float>(2 * half_width / ShadowMap::size);
  return view;
}

// What is behind a plane.
Vector4f cut(const PlaneSurface& plane, float slack) {
  const Vector3f n = plane.normal();
  return {n.x(), n.y(), n.z(), n.dot(plane.origin) - slack};
}

}  // namespace

struct Renderer::Impl {
  Impl(u32 w, u32 h)
      : width(w),
        height(h),
        gl(context.gl()),
        target(gl, w, h),
        shadow_map(gl),
        sky(gl, Shader::sky),
        plane(gl, Shader::plane),
        solid(gl, Shader::solid),
        shadow(gl, Shader::shadow),
        mark(gl, Shader::mark),
        instances(gl) {
    gl.GenVertexArrays(1, &no_vertices);
  }

  void set_common(const Program& program, const Drawing& drawing, const View& view) const {
    program.use();
    program.set("u_view_projection", view.to_clip);
    program.set("u_eye", Vector3f(drawing.camera.position.cast<float>()));
    program.set("u_to_light", Vector3f(drawing.to_light.normalized()));
    program.set("u_to_shadow", view.to_shadow);
    program.set("u_shadow", 0);
    program.set("u_texel", 1.0f / ShadowMap::size);
    program.set("u_bias", 1.6f * view.nearest_texel);
    program.set("u_pixel", static_cast<float>(2 * drawing.camera.half_height() / height));
    program.set("u_fog", 5 * view.distance);
    program.set("u_line", std::max(1.0f, static_cast<float>(height) / 720));
  }

  void draw_shadows(const View& view) const {
    shadow_map.begin();
    shadow.use();
    shadow.set("u_view_projection", view.to_shadow);
    gl.Enable(GL_CULL_FACE);
    gl.Enable(GL_POLYGON_OFFSET_FILL);
    gl.PolygonOffset(1.5f, 2);
    instances.draw();
    gl.Disable(GL_POLYGON_OFFSET_FILL);
    gl.Disable(GL_CULL_FACE);
  }

  void draw_sky(const Drawing& drawing, const View& view) const {
    set_common(sky, drawing, view);
    const Eigen::Matrix3f axes = drawing.camera.axes().cast<float>();
    const float up = static_cast<float>(drawing.camera.half_height());
    sky.set("u_right", Vector3f(up * static_cast<float>(width) / static_cast<float>(height) * axes.col(0)));
    sky.set("u_up", Vector3f(up * axes.col(1)));
    sky.set("u_into", Vector3f(axes.col(2)));
    gl.DepthMask(GL_FALSE);
    gl.BindVertexArray(no_vertices);
    gl.DrawArrays(GL_TRIANGLES, 0, 3);
    gl.DepthMask(GL_TRUE);
  }

  // Floors or walls. A floor ends where another one is above it, a wall at every other plane.
  void draw_planes(const Drawing& drawing, const View& view, bool floors) const {
    set_common(plane, drawing, view);
    const auto is_floor = [&](const PlaneSurface& p) { return p.normal().dot(drawing.up) > floor_slope; };
    gl.BindVertexArray(no_vertices);
    for (const PlaneSurface& p : drawing.planes) {
      if (is_floor(p) != floors) continue;
      std::vector<Vector4f> cuts;
      for (const PlaneSurface& other : drawing.planes) {
        if (&other != &p && cuts.size() < most_cutting_planes && (is_floor(other) || !floors))
          cuts.push_back(cut(other, 1e-4f * view.distance));
      }
      plane.set("u_cuts", cuts);
      plane.set("u_cut_count", static_cast<int>(cuts.size()));
      plane.set("u_normal", p.normal());
      plane.set("u_origin", p.origin);
      plane.set("u_along_x", Vector3f(p.rotation * Vector3f::UnitX()));
      plane.set("u_along_y", Vector3f(p.rotation * Vector3f::UnitY()));
      plane.set("u_center", Vector3f(p.rotation.conjugate() * (view.center - p.origin)));
      plane.set("u_center_world", view.center);
      plane.set("u_half_size", floors ? 40 * view.distance : 4 * view.radius);
      plane.set("u_is_floor", floors ? 1 : 0);
      plane.set("u_top",
                static_cast<float>(drawing.region.isEmpty() ? 1 : drawing.region.max().z()) + 0.1f * view.radius);
      plane.set("u_fade", 0.15f * view.radius);
      plane.set("u_range", 2.5f * view.radius);
      gl.DrawArrays(GL_TRIANGLE_STRIP, 0, 4);
    }
  }

  void draw_solids(const Drawing& drawing, const View& view) const {
    set_common(solid, drawing, view);
    gl.Enable(GL_CULL_FACE);
    instances.draw();
    gl.Disable(GL_CULL_FACE);
  }

  // Once faintly through everything, once where nothing is in front.
  void draw_marks(const Drawing& drawing, const View& view) {
    if (drawing.marks.empty()) return;
    instances.set(drawing.marks, drawing.camera, height);
    set_common(mark, drawing, view);
    gl.Enable(GL_CULL_FACE);
    gl.Disable(GL_DEPTH_TEST);
    mark.set("u_alpha", 0.28f);
    instances.draw();
    gl.Enable(GL_DEPTH_TEST);
    mark.set("u_alpha", 1.0f);
    instances.draw();
    gl.Disable(GL_CULL_FACE);
  }

  Picture draw(const Drawing& drawing);

  u32 width, height;
  EglContext context;
  const Gl& gl;
  PictureTarget target;
  ShadowMap shadow_map;
  Program sky, plane, solid, shadow, mark;
  Instances instances;
  GLuint no_vertices = 0;
};

Picture Renderer::Impl::draw(const Drawing& drawing) {
  const View view = view_of(drawing, static_cast<double>(width) / height);
  std::vector<Solid> opaque, glass;
  for (const Solid& s : drawing.solids) (s.alpha < 1 ? glass : opaque).push_back(s);
  // what is in front first: what is behind it need not be lit
  const Vector3f eye = drawing.camera.position.cast<float>();
  const auto square_distance = [&](const Solid& s) { return (s.position - eye).squaredNorm(); };
  const auto nearer = [&](const Solid& a, const Solid& b) { return square_distance(a) < square_distance(b); };
  std::stable_sort(opaque.begin(), opaque.end(), nearer);
  std::stable_sort(glass.rbegin(), glass.rend(), nearer);

  gl.Enable(GL_DEPTH_TEST);
  gl.DepthFunc(GL_LEQUAL);
  instances.set(opaque, drawing.camera, height);
  draw_shadows(view);
  shadow_map.bind();
  target.begin();
  draw_solids(drawing, view);
  draw_planes(drawing, view, true);
  draw_sky(drawing, view);
  gl.Enable(GL_BLEND);
  gl.BlendFunc(GL_SRC_ALPHA, GL_ONE_MINUS_SRC_ALPHA);
  gl.DepthMask(GL_FALSE);
  draw_planes(drawing, view, false);
  instances.set(glass, drawing.camera, height);
  draw_solids(drawing, view);
  gl.DepthMask(GL_TRUE);
  draw_marks(drawing, view);
  gl.Disable(GL_BLEND);
  return target.read();
}

Renderer::Renderer(u32 width, u32 height) : impl_(std::make_unique<Impl>(width, height)) {}
Renderer::~Renderer() = default;

const std::string& Renderer::driver() const { return impl_->context.renderer(); }

u32 Renderer::add_hull(const Mesh& mesh) { return impl_->instances.add_hull(mesh); }

Picture Renderer::draw(const Drawing& drawing) { return impl_->draw(drawing); }

std::string picture_driver() {
  const EglContext context;
  return context.renderer() + ", " + context.version();
}

}  // namespace lockstep
