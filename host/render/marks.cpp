#include "host/render/marks.hpp"

#include <algorithm>

#include "host/contact_geometry.hpp"
#include "host/render/in_float.hpp"

namespace lockstep {

using Eigen::Quaternionf;
using Eigen::Vector3f;

namespace {

// A contact that is not the first of its pair has the colour of the first.
u32 color_of(const std::vector<u32>& colors, u32 contact) {
  while (contact > 0 && colors[contact] == COLOR_OF_FIRST) --contact;
  return colors[contact];
}

float pixel_at(const Drawing& drawing, u32 height, const Vector3f& point) {
  const double distance = (point.cast<double>() - drawing.camera.position).norm();
  return static_cast<float>(2 * drawing.camera.half_height() / height * distance);
}

}  // namespace

std::vector<Buffer> contact_mark_buffers(Features features) {
  std::vector<Buffer> buffers = {Buffer::contact_colors};
  add_contact_impulse_buffers(features, buffers);
  return buffers;
}

template <class real>
std::vector<ContactMark> contact_marks(const Buffers<real>& buffers, u32 contacts, double dt) {
  std::vector<ContactMark> marks(contacts);
  for (u32 i = 0; i < contacts; ++i) {
    const ContactGeometry geometry = contact_geometry(buffers, i);
    const Eigen::Vector3d force = contact_impulse(buffers, i, geometry) / dt;
    marks[i] = {geometry.point().cast<float>(), force.cast<float>(),
                buffers.contact_colors.empty() ? 0 : color_of(buffers.contact_colors, i)};
  }
  return marks;
}

template <class real>
std::vector<JointMark> joint_marks(const Buffers<real>& constants, const std::vector<Vec4<real>>& positions,
                                   const std::vector<Vec4<real>>& orientations) {
  std::vector<JointMark> marks;
  for (std::size_t i = 0; i < constants.joints.size(); ++i) {
    const JointInfo& info = constants.joint_infos[i];
    const Joint<real>& joint = constants.joints[i];
    const auto side = [&](u32 body, const real* anchor, Vector3f& center, Vector3f& at) {
      const bool is_world = body >= positions.size();
      center = is_world ? vector3f(anchor) : vector3f(positions[body]);
      at = is_world ? vector3f(anchor) : Vector3f(center + rotationf(orientations[body]) * vector3f(anchor));
    };
    JointMark mark = {};
    side(info.body_a, joint.anchor_a, mark.center_a, mark.anchor_a);
    side(info.body_b, joint.anchor_b, mark.center_b, mark.anchor_b);
    if (info.kind == JOINT_SKATE || info.kind == JOINT_ROLLING) {  // nothing of a stays beside what skates or rolls
      mark.center_a = mark.center_b;
      mark.anchor_a = mark.anchor_b;
    }
    mark.axis.setZero();
    if (info.free == FREE_ANGLE || info.free == FREE_TRAVEL) {
      const real* q = joint.frame_a;
      const Quaternionf frame = rotationf(q);
      const Quaternionf body =
          info.body_a < positions.size() ? rotationf(orientations[info.body_a]) : Quaternionf::Identity();
      mark.axis = body * (frame * Vector3f::UnitZ());
    }
    marks.push_back(mark);
  }
  return marks;
}

void add_ball(Drawing& drawing, u32 height, const Vector3f& at, float pixels, const Color& color) {
  Solid ball;
  ball.position = at;
  ball.scale.setConstant(0.5f * pixels * pixel_at(drawing, height, at));
  ball.color = color;
  drawing.marks.push_back(ball);
}

void add_line(Drawing& drawing, u32 height, const Vector3f& from, const Vector3f& to, float pixels,
              const Color& color) {
  const Vector3f along = to - from;
  const float length = along.norm();
  if (!(length > 0)) return;
  Solid line;
  line.form = Form::cylinder;
  line.position = 0.5f * (from + to);
  line.rotation = Quaternionf::FromTwoVectors(Vector3f::UnitZ(), along);
  const float radius = 0.5f * pixels * pixel_at(drawing, height, line.position);
  line.scale = {radius, radius, 0.5f * length};
  line.color = color;
  drawing.marks.push_back(line);
}

#define INSTANTIATE(real)                                                                           \
  template std::vector<ContactMark> contact_marks(const Buffers<real>&, u32, double);               \
  template std::vector<JointMark> joint_marks(const Buffers<real>&, const std::vector<Vec4<real>>&, \
                                              const std::vector<Vec4<real>>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
