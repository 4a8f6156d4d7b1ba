#pragma OPENCL FP_CONTRACT OFF
#include "common.h"
#include "gyroscopic.h"
#include "math.h"
#include "rigid_body.h"
#include "sleep.h"
#include "types.h"

// The formulas and their sources are in cpu_reference/integrate_positions.hpp.
kernel void integrate_positions(const StepParams params, global const BodyInfo* body_infos, global const Mass* masses,
                                global const Pivot* pivots, global const Sleeper* sleepers,
                                global const u32* body_joint_starts, global const Velocity* previous_velocities,
                                global FreeRotation* free_rotations, global Vec4* positions, global Vec4* orientations,
                                global Motion* motions, global u32* counters) {
  if (STEP_ABORTED(counters)) return;

  FOR_EACH(i, params.bodies) {
    const BodyInfo info = body_infos[i];
    if (info.kind == BODY_STATIC || is_asleep(sleepers, i)) continue;
    const bool dynamic = info.kind == BODY_DYNAMIC;
    const bool pivoted = dynamic && IS_PIVOTED(pivots, i);
    const bool gyroscopic = dynamic && IS_GYROSCOPIC(params, info);

    Motion motion = motions[i];
    Vec3 v = vec3(motion.v);
    Vec3 w = vec3(motion.w);
    if (is_bad_velocity(v, w, params.speed_limit)) report_bad(counters, STATUS_BAD_CONTACTS, i);
    const Velocity previous = previous_velocities[i];
    const Vec3 mean_v = mean3(params.theta, vec3(previous.v), v);

    const Quat old_q = quat(orientations[i]);
    bool free = false;
    Quat rotation;
    if (gyroscopic && !pivoted) {
      const FreeRotation own = free_rotations[i];
      free = is_free(own, w);
      if (free) rotation = free_rotation(own);
    }
    const bool in_middle = acts_in_middle(&params, info, pivoted);
    const bool jointed = gyroscopic && !pivoted && params.theta == (real)1 && IS_JOINTED(body_joint_starts, i);
    const Vec3 old_w = vec3(previous.w), solved_w = w;
    if ((in_middle || jointed) && !free) {
      FreeRotation own = free_rotations[i];
      const Quat acting_q = in_middle ? orientation_in_middle(old_q, old_w, params.dt) : old_q;
      w = correct_gyroscopic_moment(&params, masses[i], own, acting_q, old_w, w);
      store3(own.w, solved_w);
      own.slack = (real)-1;
      free_rotations[i] = own;
    }
    const Vec3 new_w = in_middle ? w : solved_w;
    if (!free) rotation = rotation_by(mean3(params.theta, old_w, new_w), params.dt);
    const Quat q = unit4(multiply4(rotation, old_q));
    const bool carried = free || jointed || (gyroscopic && params.theta != (real)1);
    if (in_middle) w = rotate_by(rotation_by(old_w, (real)-0.5 * params.dt), w);
    if (carried) w = rotate_by(rotation, w);

    Vec4 position = positions[i];
    Vec3 x = vec3_of(position);
    if (pivoted) {
      const Pivot pivot = pivots[i];
      const Vec3 com_offset = com_offset_world(pivot, q);
      x = add3(vec3(pivot.point_world), com_offset);
      v = cross3(w, com_offset);
    } else {
      x = add3(x, scale3(params.dt, mean_v));
    }
    if (is_bad_pose(x, q)) report_bad(counters, STATUS_BAD_POSE, i);

    position.x = x.x;
    position.y = x.y;
    position.z = x.z;
    positions[i] = position;
    orientations[i] = make_vec4(q);
    if (pivoted || carried) {
      store3(motion.v, v);
      store3(motion.w, w);
      motions[i] = motion;
    }
  }
}
