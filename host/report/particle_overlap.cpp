#include "host/report/particle_overlap.hpp"

#include <algorithm>

#include "host/in_double.hpp"

namespace lockstep {

namespace {

using Eigen::Vector3d;

// Depths that were met so far.
struct Depths {
  double most = 0, sum = 0, ratio = 0;
  u32 count = 0;

  void add(double depth, double radius) {
    if (depth <= 0) return;
    most = std::max(most, depth);
    ratio = std::max(ratio, depth / radius);
    sum += depth;
    ++count;
  }
};

// Of a particle at x.
template <class real>
double depth_in_plane(const Buffers<real>& b, u32 plane, const Vector3d& x, double radius) {
  const u32 body = b.plane_bodies[plane];
  const auto orientation = rotation(b.orientations[body]);
  const Vector3d point = vector3(b.positions[body]) + orientation * vector3(b.particle_planes[plane].point);
  return radius - (orientation * vector3(b.particle_planes[plane].normal)).dot(x - point);
}

}  // namespace

template <class real>
Penetration particle_overlap(const Buffers<real>& b) {
  Depths depths;
  std::vector<Vector3d> centers;
  for (std::size_t i = 0; i < b.particle_bodies.size(); ++i) {
    const u32 body = b.particle_bodies[i];
    centers.push_back(vector3(b.positions[body]) + rotation(b.orientations[body]) * vector3(b.particle_offsets[i]));
  }
  for (u32 i = 0; i < centers.size(); ++i) {
    const BodyInfo& info = b.body_infos[b.particle_bodies[i]];
    if (info.kind != BODY_DYNAMIC) continue;
    const double radius = double(b.particle_laws[info.world].radius);
    for (u32 k = b.neighbour_starts[i]; k < b.neighbour_starts[i + 1]; ++k) {
      const u32 j = b.neighbours[k];
      if (j >= centers.size()) {
        depths.add(depth_in_plane(b, j - static_cast<u32>(centers.size()), centers[i], radius), radius);
        continue;
      }
      const bool is_twice = b.body_infos[b.particle_bodies[j]].kind == BODY_DYNAMIC;
      if (!is_twice || i < j) depths.add(2 * radius - (centers[j] - centers[i]).norm(), radius);
    }
  }
  return {depths.most, depths.count > 0 ? depths.sum / depths.count : 0, depths.count, depths.ratio};
}

template Penetration particle_overlap<float>(const Buffers<float>&);
template Penetration particle_overlap<double>(const Buffers<double>&);

}  // namespace lockstep
