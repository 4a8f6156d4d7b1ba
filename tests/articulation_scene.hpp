// Trees of bodies whose joints are solved directly.
#pragma once

#include <algorithm>
#include <cmath>

#include "cpu_reference/articulations/closures.hpp"
#include "cpu_reference/joints/solve_joint.hpp"
#include "tests/contact_scene.hpp"
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

/// The same with this many joints more, each of which closes a loop. Joints leave their bodies free to turn about at
/// least one axis, so that hardly any row depends on others.
inline Scene random_mechanism(u32 seed, u32 bodies, u32 loops) {
  Random random(seed);
  Scene scene = random_tree(seed, bodies);
  for (JointDescription& joint : scene.joints) {
    joint.kind = joint.body_a == NONE || random.bits() % 3 > 0 ? JOINT_BALL : JOINT_UNIVERSAL;
    joint.spring = {};
  }
  for (u32 i = 0; i < loops; ++i) {
    const JointKind kinds[] = {JOINT_BALL, JOINT_HINGE, JOINT_DISTANCE, JOINT_SKATE};
    const u32 a = 2 + random.bits() % (bodies - 2), b = 2 + (a - 1 + random.bits() % (bodies - 3)) % (bodies - 2);
    JointDescription joint =
        joint_of(kinds[random.bits() % 4], i % 3 == 0 ? NONE : a, b, random.vector(2), random.vector(1));
    joint.second_axis = {joint.axis[1], -joint.axis[0], 0};
    if (joint.kind == JOINT_DISTANCE) {
      joint.anchor_b = random.vector(2);
      joint.spring = {random.between(0, 100), random.between(0.1, 2), random.between(0, 0.3)};
    }
    scene.joints.push_back(joint);
  }
  return scene;
}

/// A state in which impulses have gathered, just before the stage.
template <class real>
InitialState<real> state_before(Stage stage, const Scene& scene) {
  InitialState<real> state = compile<real>(scene);
  ReferenceBackend<real> backend(state);
  step(backend, state.params);
  for (const Stage each :
       {Stage::begin_step, Stage::integrate_velocities, Stage::prepare_joints, Stage::factor_articulations,
        Stage::warm_start, Stage::solve_constraints, Stage::integrate_positions, Stage::close_joints}) {
    if (each == stage) break;
    backend.run(each, state.params);
  }
  state.buffers = backend.buffers();
  return state;
}

/// The stages that solve trees and close them, on the device beside the reference.
template <class real>
void expect_stages_agree(const Scene& scene, Feature feature) {
  for (const Stage stage : {Stage::factor_articulations, Stage::solve_constraints, Stage::close_joints}) {
    SCOPED_TRACE(info(stage).name);
    const InitialState<real> state = state_before<real>(stage, scene);
    ASSERT_TRUE(has(state.features, feature));
    ASSERT_EQ(state.buffers.counters[COUNTER_STATUS], 0u);
    run_twins(stage, state);
  }
}

/// What the rows of trees, and of joints that close their loops, are off by: the largest, m/s and rad/s. Springs push
/// against what they give way by.
template <class real>
double most_off(const Buffers<real>& b) {
  double most = 0;
  std::vector<LinkInfo> links = b.links;
  for (const ClosureInfo& closure : b.closures) links.push_back(reference::as_link(b, closure));
  for (const LinkInfo& link : links) {
    if (link.joint == NONE) continue;
    const JointInfo& info = b.joint_infos[link.joint];
    const JointBlock<real>& block = b.joint_blocks[link.slot / PACK];
    const u32 lane = link.slot % PACK;
    const Motion<real>&body_a = b.motions[info.body_a], &body_b = b.motions[info.body_b];
    const auto u = reference::velocity_at(reference::joint_vector(block.arm_b, lane),
                                          reference::joint_vector(block.arm_a, lane), body_b, body_a);
    const auto w = reference::sub3(reference::vec3(body_b.w), reference::vec3(body_a.w));
    for (u32 row = 0; row < JOINT_ROWS; ++row) {
      if ((info.locked >> row & 1) == 0) continue;
      const auto axis = reference::joint_vector(block.axes + 3 * (row % 3), lane);
      double off = double(reference::dot3(axis, row < 3 ? u : w)) + double(block.bias[row][lane]) +
                   double(block.velocity_product[row][lane]);
      if (row == 2) off -= double(block.lead[lane]) * double(reference::dot3(axis, w));
      most = std::max(most, std::abs(off));
    }
    const bool impedance = reference::has_impedance(block, lane);
    if (info.free == FREE_NOTHING || (block.slowest[lane] != block.fastest[lane] && !impedance)) continue;
    const auto along = reference::joint_vector(block.free_axis, lane);
    const double free = double(reference::dot3(along, info.free == FREE_ANGLE ? w : u));
    const JointImpulseBlock<real>& impulses = b.joint_impulses[link.slot / PACK];
    const double push = impedance ? double(block.impedance_compliance[lane]) * double(impulses.impedance[lane])
                                  : double(block.spring_compliance[lane]) * double(impulses.free[lane]);
    most =
        std::max(most, std::abs(free - double(impedance ? block.impedance_speed[lane] : block.slowest[lane]) + push));
  }
  return most;
}

/// One sweep leaves nothing off, and M (v - v before) is what the impulses of the joints push with: together the one
/// solution.
template <class real>
void expect_one_solve_is_exact(Scene scene, double rounding) {
  scene.settings.iterations = 1;
  InitialState<real> state = state_before<real>(Stage::solve_constraints, scene);
  Buffers<real> pushed = state.buffers;
  EXPECT_GT(most_off(state.buffers), 0.1);
  reference::run_stage(Stage::solve_constraints, state.buffers, state.params);
  EXPECT_LT(most_off(state.buffers), rounding);
  reference::for_each_joint_slot(pushed, [&](const JointLanes& lanes, u32 block, u32 lane) {
    real change[JOINT_ROWS];
    for (u32 row = 0; row < JOINT_ROWS; ++row)
      change[row] =
          state.buffers.joint_impulses[block].locked[row][lane] - pushed.joint_impulses[block].locked[row][lane];
    const auto whole = [&](const Buffers<real>& b) {
      return reference::whole_free_impulse(pushed.joint_blocks[block], lane, b.joint_impulses[block]);
    };
    const real free = whole(state.buffers) - whole(pushed);
    reference::push_joint(pushed.joint_blocks[block], lanes.free[lane], lane, change, free,
                          pushed.motions[lanes.body_a[lane]], pushed.motions[lanes.body_b[lane]]);
  });
  for (u32 i = 0; i < state.params.bodies; ++i) {
    for (u32 k = 0; k < 3; ++k) {
      EXPECT_NEAR(double(state.buffers.motions[i].v[k]), double(pushed.motions[i].v[k]), rounding) << i;
      EXPECT_NEAR(double(state.buffers.motions[i].w[k]), double(pushed.motions[i].w[k]), rounding) << i;
    }
  }
}

}  // namespace lockstep::test
