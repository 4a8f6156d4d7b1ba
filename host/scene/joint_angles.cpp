#include "host/scene/joint_angles.hpp"

#include "host/scene/exact_math.hpp"

namespace lockstep {

template <class real>
std::vector<double> angles_of_substep(const Buffers<real>& buffers, double dt) {
  std::vector<double> angles;
  for (u32 j = 0; j < buffers.joint_infos.size(); ++j) {
    const JointInfo& info = buffers.joint_infos[j];
    if (!COUNTS_REVOLUTIONS(info)) {
      angles.push_back(0);
      continue;
    }
    Quaternion q = {0, 0, 0, 1};
    if (info.body_a < buffers.body_infos.size()) {
      const Vec4<real>& at = buffers.orientations[info.body_a];
      q = {at.x, at.y, at.z, at.w};
    }
    const real(&frame)[4] = buffers.joints[j].frame_a;
    const Vector3 axis = exact::rotate(q, exact::rotate({frame[0], frame[1], frame[2], frame[3]}, {0, 0, 1}));
    const real(&w_a)[3] = buffers.motions[info.body_a].w;
    const real(&w_b)[3] = buffers.motions[info.body_b].w;
    angles.push_back(dt * exact::dot(axis, exact::subtract({w_b[0], w_b[1], w_b[2]}, {w_a[0], w_a[1], w_a[2]})));
  }
  return angles;
}

template <class real>
void set_joint_angles(std::span<const double> angles, double dt, Buffers<real>& buffers) {
  const std::vector<double> growths = angles_of_substep(buffers, dt);
  buffers.joint_angles.resize(growths.size());
  for (std::size_t j = 0; j < growths.size(); ++j) {
    const bool counts = COUNTS_REVOLUTIONS(buffers.joint_infos[j]);
    buffers.joint_angles[j] = counts ? static_cast<real>(angles[j] - growths[j]) : real(0);
  }
}

#define INSTANTIATE(real)                                                       \
  template std::vector<double> angles_of_substep(const Buffers<real>&, double); \
  template void set_joint_angles(std::span<const double>, double, Buffers<real>&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep
