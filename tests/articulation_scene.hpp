// Trees of bodies whose joints are solved directly.
#pragma once

#include "tests/joints/joint_scene.hpp"

namespace lockstep::test {

inline Scene solved_directly(Scene scene) {
  scene.settings.joint_solver = JointSolver::direct;
  return scene;
}

/// Bodies in motion, each held by one that came before it, or by the world, or by a kinematic body; one tree floats.
/// Joints are of all kinds, hard, some with springs; none has a motor or limits that are apart.
inline Scene random_tree(u32 seed, u32 bodies) {
  Random random(seed);
  Scene scene = random_joints(seed, bodies, 0);
  for (BodyDescription& body : scene.bodies) {
    body.kind = BODY_DYNAMIC;
    if (body.mass == 0) body.mass = 1;
  }
  BodyDescription& mover = scene.bodies[0];
  mover.kind = BODY_KINEMATIC;
  mover.mass = 0;
  for (u32 i = 2; i < bodies; ++i) {
    const u32 draw = random.bits() % 8;
    const u32 parent = draw == 0 ? NONE : draw == 1 ? 0 : 1 + random.bits() % (i - 1);
    u32 kind = random.bits() % JOINT_KINDS;
    JointDescription joint = joint_of(static_cast<JointKind>(kind), parent, i, random.vector(2), random.vector(1));
    if (random.bits() % 2 == 0) std::swap(joint.body_a, joint.body_b);
    joint.second_axis = {joint.axis[1], -joint.axis[0], 0};
    if (joint.kind == JOINT_DISTANCE) joint.anchor_b = random.vector(2);
    if (joint.kind == JOINT_SCREW) joint.pitch = random.between(0.5, 2) * (random.bits() % 2 == 0 ? 1 : -1);
    if (joint.kind == JOINT_ROLLING) joint.radius = random.between(0.2, 1);
    if (free_of(joint.kind) != FREE_NOTHING && random.bits() % 2 == 0)
      joint.spring = {random.between(0, 100), random.between(0.1, 2), random.between(0, 0.3)};
    scene.joints.push_back(joint);
  }
  return solved_directly(scene);
}

}  // namespace lockstep::test
