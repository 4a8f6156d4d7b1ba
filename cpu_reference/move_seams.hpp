// Where the neighbours of shapes are that belong to other bodies, one of the two kinematic: in the frame of the shape,
// at the poses with which the step begins. With x and q of the shapes' frames,
//
//   offset = q_a^-1 (x_b - x_a),   rotation = q_a^-1 q_b
//
// Other seams stay as they were compiled.
#pragma once

#include "cpu_reference/rigid_body.hpp"
#include "cpu_reference/shapes/manifold.hpp"
#include "host/buffers.hpp"

namespace lockstep::reference {

template <class real>
Pose<real> pose_of_body_of(const Buffers<real>& b, u32 shape) {
  const u32 body = b.shape_infos[shape].body;
  return make_pose(b.positions[body], b.orientations[body]);
}

template <class real>
void move_seams(Buffers<real>& b, const StepParams<real>&) {
  for (std::size_t i = 0; i < b.seams.size(); ++i) {
    Seam<real>& seam = b.current_seams[i] = b.seams[i];
    const SeamSides sides = b.seam_sides[i];
    if (sides.neighbour == NONE) continue;
    const Shape<real>&own = b.shapes[sides.shape], &neighbour = b.shapes[sides.neighbour];
    const Pose<real> pose = pose_of_body_of(b, sides.shape), other_pose = pose_of_body_of(b, sides.neighbour);
    const Quat<real> q = shape_rotation(pose, own), back = {-q.x, -q.y, -q.z, q.w};
    const Vec3<real> arms =
        sub3(rotate3(other_pose.orientation, vec3(neighbour.offset)), rotate3(pose.orientation, vec3(own.offset)));
    store3(seam.offset, rotate3(back, add3(sub3(other_pose.position, pose.position), arms)));
    const Quat<real> rotation = multiply4(back, shape_rotation(other_pose, neighbour));
    seam.rotation[0] = rotation.x;
    seam.rotation[1] = rotation.y;
    seam.rotation[2] = rotation.z;
    seam.rotation[3] = rotation.w;
  }
}

}  // namespace lockstep::reference
