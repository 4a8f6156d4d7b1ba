#pragma OPENCL FP_CONTRACT OFF
// Where the neighbours are that belong to other bodies (cpu_reference/move_seams.hpp states the method).
#include "common.h"
#include "rigid_body.h"
#include "shapes/manifold.h"
#include "types.h"

kernel void move_seams(const u32 seam_count, global const ShapeInfo* shape_infos, global const Shape* shapes,
                       global const Vec4* positions, global const Vec4* orientations, global const Seam* seams,
                       global const SeamSides* seam_sides, global Seam* current_seams) {
  FOR_EACH(i, seam_count) {
    Seam seam = seams[i];
    const SeamSides sides = seam_sides[i];
    if (sides.neighbour != NONE) {
      global const Shape* own = shapes + sides.shape;
      global const Shape* neighbour = shapes + sides.neighbour;
      const u32 body = shape_infos[sides.shape].body, other = shape_infos[sides.neighbour].body;
      const Pose pose = make_pose(positions[body], orientations[body]);
      const Pose other_pose = make_pose(positions[other], orientations[other]);
      const Quat q = shape_rotation(pose, own), back = make4(-q.x, -q.y, -q.z, q.w);
      const Vec3 own_offset = make3(own->offset[0], own->offset[1], own->offset[2]);
      const Vec3 other_offset = make3(neighbour->offset[0], neighbour->offset[1], neighbour->offset[2]);
      const Vec3 arms = sub3(rotate3(other_pose.orientation, other_offset), rotate3(pose.orientation, own_offset));
      store3(seam.offset, rotate3(back, add3(sub3(other_pose.position, pose.position), arms)));
      const Quat rotation = multiply4(back, shape_rotation(other_pose, neighbour));
      seam.rotation[0] = rotation.x;
      seam.rotation[1] = rotation.y;
      seam.rotation[2] = rotation.z;
      seam.rotation[3] = rotation.w;
    }
    current_seams[i] = seam;
  }
}
