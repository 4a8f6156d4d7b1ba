// Marks in a drawing: where bodies touch, what pushes there, and what joints hold.
#pragma once

#include <span>
#include <vector>

#include "host/buffers.hpp"
#include "host/render/drawing.hpp"

namespace lockstep {

struct ContactMark {
  Eigen::Vector3f point;  // on the surface of shape a, world frame
  Eigen::Vector3f force;  // on a, N: the impulse of the step, or of its last sub-step, over its time
  u32 color;              // in which the solver solves it; MAX_COLORS: after all colours
};

struct JointMark {
  Eigen::Vector3f center_a, center_b;  // of mass; the anchor's where it is the world
  Eigen::Vector3f anchor_a, anchor_b;
  Eigen::Vector3f axis;  // unit; zero where it has none
};

/// What contact_marks() reads.
std::vector<Buffer> contact_mark_buffers(Features features);

/// The contacts of the last step, so many of them, in a scene that has contacts; `dt` is the time of their impulses
/// (impulse_time()).
template <class real>
std::vector<ContactMark> contact_marks(const Buffers<real>& buffers, u32 contacts, double dt);

/// From the constants of a scene and poses in `now`.
template <class real>
std::vector<JointMark> joint_marks(const Buffers<real>& constants, const std::vector<Vec4<real>>& positions,
                                   const std::vector<Vec4<real>>& orientations);

/// Adds balls and lines of so many pixels' width to a drawing whose camera is set; `height` is that of the picture.
void add_ball(Drawing& drawing, u32 height, const Eigen::Vector3f& at, float pixels, const Color& color);
void add_line(Drawing& drawing, u32 height, const Eigen::Vector3f& from, const Eigen::Vector3f& to, float pixels,
              const Color& color);

}  // namespace lockstep
