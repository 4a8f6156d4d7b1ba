// Scenes of bodies and joints for the tests, without a file.
#pragma once

#include "host/scene/joint_kinds.hpp"
#include "tests/stage_harness.hpp"
#include "tests/worlds.hpp"

namespace lockstep::test {

/// A body of 1 kg without shapes.
inline BodyDescription bare_body(const Vector3& position, const Vector3& inertia = {0.1, 0.1, 0.1}) {
  BodyDescription body;
  body.mass = 1;
  body.inertia = inertia;
  body.position = position;
  return body;
}

inline JointDescription joint_of(JointKind kind, u32 body_a, u32 body_b, const Vector3& anchor,
                                 const Vector3& axis = {0, 0, 1}) {
  JointDescription joint;
  joint.kind = kind;
  joint.body_a = body_a;
  joint.body_b = body_b;
  joint.anchor_a = joint.anchor_b = anchor;
  joint.axis = axis;
  return joint;
}

inline Scene joint_scene(std::vector<BodyDescription> bodies, std::vector<JointDescription> joints, double dt) {
  Scene scene;
  scene.bodies = std::move(bodies);
  scene.joints = std::move(joints);
  scene.settings.dt = dt;
  return scene;
}

inline Scene with_small_steps(Scene scene, u32 substeps) {
  replace_solver(scene.settings, Solver::small_steps);
  scene.settings.substeps = substeps;
  return scene;
}

/// Steps on the reference; `watch(buffers, step)` sees the buffers after each step.
template <class real, class Watch>
void watch_steps(const Scene& scene, u32 steps, Watch&& watch) {
  const InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  for (u32 i = 0; i < steps; ++i) {
    step(backend, state.params);
    ASSERT_EQ(backend.buffers().counters[COUNTER_STATUS], 0u) << "step " << i;
    watch(backend.buffers(), i);
  }
}

template <class real>
Buffers<real> after_steps(const Scene& scene, u32 steps) {
  Buffers<real> last;
  watch_steps<real>(scene, steps, [&](const Buffers<real>& b, u32 i) {
    if (i + 1 == steps) last = b;
  });
  return last;
}

/// Bodies in motion, one of five of them static, and joints of all kinds between random pairs of them and the world:
/// with limits, motors, friction and springs. Where the geometry is nonsense only twins can be compared.
inline Scene random_joints(u32 seed, u32 bodies, u32 joints) {
  Random random(seed);
  Scene scene;
  for (u32 i = 0; i < bodies; ++i) {
    BodyDescription body =
        bare_body(random.vector(2), {random.between(1, 2), random.between(1, 2), random.between(1, 2)});
    if (random.bits() % 3 == 0) body.inertia = {1, 1, 1};
    body.mass = random.between(0.5, 3);
    body.orientation = random.rotation();
    if (random.bits() % 5 == 0 && i > 0) {
      body.kind = BODY_STATIC;
      body.mass = 0;
    } else {
      body.velocity = random.vector(1);
      body.angular_velocity = random.vector(1);
    }
    scene.bodies.push_back(body);
  }
  for (u32 i = 0; i < joints; ++i) {
    u32 a = random.bits() % bodies, b = random.bits() % bodies;
    if (a == b || scene.bodies[a].kind == BODY_STATIC) a = NONE;
    if (a == NONE && scene.bodies[b].kind == BODY_STATIC) b = 0;  // the first is dynamic
    if (random.bits() % 2 == 0) std::swap(a, b);
    JointDescription joint =
        joint_of(static_cast<JointKind>(i % JOINT_KINDS), a, b, random.vector(2), {1, random.between(-1, 1), 0.3});
    joint.second_axis = {joint.axis[1], -1, 0};
    if (joint.kind == JOINT_DISTANCE) joint.anchor_b = random.vector(2);
    if (joint.kind == JOINT_SCREW) joint.pitch = random.between(0.5, 2) * (random.bits() % 2 == 0 ? 1 : -1);
    if (joint.kind == JOINT_ROLLING) joint.radius = random.between(0.2, 1);
    const bool is_free = free_of(joint.kind) != FREE_NOTHING;
    if (is_free && random.bits() % 2 == 0) {
      joint.limited = true;
      joint.low = random.between(-0.2, 0.1);
      joint.high = random.bits() % 4 == 0 ? joint.low : joint.low + random.between(0, 0.3);
    }
    if (is_free && !joint.limited && random.bits() % 2 == 0)
      joint.spring = {random.between(0, 100), random.between(0.1, 2), random.between(0, 0.3)};
    if (is_free && random.bits() % 2 == 0) {
      joint.motor_speed = random.between(-2, 2);
      joint.motor_force = random.between(1, 50);
    } else if (is_free && random.bits() % 2 == 0) {
      joint.friction = random.between(1, 20);
    }
    if (random.bits() % 4 == 0 && !is_non_holonomic(joint.kind)) joint.frequency = random.between(1, 10);
    scene.joints.push_back(joint);
  }
  return scene;
}

/// With armature on two of three joints that have a coordinate, and a spring beside every second pair of limits.
inline Scene with_impedances(Scene scene) {
  Random random(17);
  for (JointDescription& joint : scene.joints) {
    if (free_of(joint.kind) == FREE_NOTHING) continue;
    if (random.bits() % 3 > 0) joint.armature = random.between(0.01, 4);
    if (joint.limited && random.bits() % 2 == 0)
      joint.spring = {random.between(0, 100), random.between(0.1, 2), random.between(0, 0.3)};
  }
  return scene;
}

/// Two bodies, the second of which can move, and one joint between them; one sweep.
inline Scene one_random_joint(u32 seed) {
  Scene scene = random_joints(seed, 2, JOINT_KINDS);
  scene.bodies[1].kind = BODY_DYNAMIC;
  if (scene.bodies[1].mass == 0) scene.bodies[1].mass = 1;
  scene.joints = {scene.joints[seed % JOINT_KINDS]};
  scene.joints[0].body_a = 0;
  scene.joints[0].body_b = 1;
  scene.settings.iterations = 1;
  return scene;
}

}  // namespace lockstep::test
