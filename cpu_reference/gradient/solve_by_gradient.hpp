// The schedule of a descent (cpu_reference/gradient/descent.hpp), `iterations` times: all contacts and joints step from
// y at once; each body adds up what its sides give it, in their order, which moves it by M^-1 J^T d; the world judges
// the step; impulses and bodies take it, or stay where they were. A body's part of d W d is what it was given times how
// that moved it. kernels/solve_by_gradient.cl is the twin.
#pragma once

#include "cpu_reference/gradient/gradient_joints.hpp"

namespace lockstep::reference {

template <class real>
class GradientDescent {
 public:
  GradientDescent(Buffers<real>& buffers, const StepParams<real>& params);
  void run();

 private:
  Descent<real>& world_of(const BlockBodies& bodies, u32 lane) {
    return worlds_[buffers_.contacts[bodies.contact[lane]].world];
  }
  Descent<real>& world_of(const JointLanes& lanes, u32 lane) {
    return worlds_[buffers_.joint_infos[lanes.joint[lane]].world];
  }
  real sides_of(u32 body) const;
  void measure_pairs();
  void measure_joints();
  void step_pairs();
  void step_joints();
  void move_body(u32 body);
  void take_steps();
  bool is_over() const;
  void finish();

  Buffers<real>& buffers_;
  const StepParams<real>& params_;
  bool accelerated_;
  std::vector<Descent<real>> worlds_;
  std::vector<real> pair_metrics_, joint_metrics_;  // D of each lane of each row; sides of each joint
  std::vector<ImpulseBlock<real>> y_, next_;
  std::vector<JointImpulseBlock<real>> joint_y_, joint_next_;
  std::vector<GradientContribution<real>> pair_contributions_, joint_contributions_;
  std::vector<Motion<real>> at_, ahead_;  // bodies at r and at r'; those of the buffers are at y
  std::vector<DescentSums<real>> sums_;
};

template <class real>
GradientDescent<real>::GradientDescent(Buffers<real>& buffers, const StepParams<real>& params)
    : buffers_(buffers),
      params_(params),
      accelerated_(buffers.gradient_laws[0].accelerated != 0),
      worlds_(params.worlds),
      pair_metrics_(buffers.contact_blocks.size() * PACK),
      joint_metrics_(buffers.joint_blocks.size() * PACK),
      y_(buffers.impulse_blocks),
      next_(buffers.impulse_blocks),
      joint_y_(buffers.joint_impulses),
      joint_next_(buffers.joint_impulses),
      pair_contributions_(buffers.body_copy_starts.empty() ? 0 : buffers.body_copy_starts.back()),
      joint_contributions_(buffers.joint_side_starts.back()),
      at_(buffers.motions),
      ahead_(buffers.motions),
      sums_(params.bodies) {
  measure_pairs();
  measure_joints();
}

/// Of a body that can move: pairs in contact and joints.
template <class real>
real GradientDescent<real>::sides_of(u32 body) const {
  if (body >= params_.bodies || buffers_.body_infos[body].kind != BODY_DYNAMIC) return 0;
  const u32 pairs =
      buffers_.body_copy_starts.empty() ? 0 : buffers_.body_copy_starts[body + 1] - buffers_.body_copy_starts[body];
  return real(pairs + (buffers_.joint_side_starts[body + 1] - buffers_.joint_side_starts[body]));
}

template <class real>
void GradientDescent<real>::measure_pairs() {
  for_each_pair_slot(buffers_, [&](const BlockBodies& bodies, u32 block, u32 lane) {
    const BodyCopyBlock<real>& copies = buffers_.body_copy_blocks[block];
    const real share = larger(joined_share(buffers_, bodies.body_a[lane], copies.copies_a[lane]),
                              joined_share(buffers_, bodies.body_b[lane], copies.copies_b[lane]));
    const u32 first = buffers_.block_rows[block].first, count = bodies.count[lane];
    for (u32 row = first; row < first + count; ++row)
      pair_metrics_[row * PACK + lane] = contact_metric(buffers_.contact_blocks[row], lane, count, share);
  });
}

template <class real>
void GradientDescent<real>::measure_joints() {
  for_each_joint_slot(buffers_, [&](const JointLanes& lanes, u32 block, u32 lane) {
    joint_metrics_[block * PACK + lane] = larger(sides_of(lanes.body_a[lane]), sides_of(lanes.body_b[lane]));
  });
}

template <class real>
void store_contributions(PairStep<real> step, u32 slot_a, u32 slot_b,
                         std::vector<GradientContribution<real>>& contributions) {
  GradientContribution<real>& counted =
      slot_a != NONE ? step.a : step.b;  // one side alone has what the step adds up to
  counted.length = step.length;
  counted.uphill = step.uphill;
  if (slot_a != NONE) contributions[slot_a] = step.a;
  if (slot_b != NONE) contributions[slot_b] = step.b;
}

template <class real>
void GradientDescent<real>::step_pairs() {
  for_each_pair_slot(buffers_, [&](const BlockBodies& bodies, u32 block, u32 lane) {
    Descent<real>& world = world_of(bodies, lane);
    if (world.settled) return;
    PairStep<real> step;
    const u32 first = buffers_.block_rows[block].first, end = first + bodies.count[lane];
    for (u32 row = first; row < end; ++row) {
      ImpulseBlock<real>& r = buffers_.impulse_blocks[row];
      if (world.moved) take_contact_step(world.beta, next_[row], lane, r, y_[row]);
      step_contact(buffers_.contact_blocks[row], contact_law(Purpose::solve, buffers_, row, lane).bias,
                   pair_metrics_[row * PACK + lane], world.step, lane, buffers_.motions[bodies.body_a[lane]],
                   buffers_.motions[bodies.body_b[lane]], r, y_[row], next_[row], step);
    }
    world.change = larger(step.change, world.change);
    const BodyCopyBlock<real>& copies = buffers_.body_copy_blocks[block];
    store_contributions(step, copies.slot_a[lane], copies.slot_b[lane], pair_contributions_);
  });
}

template <class real>
void GradientDescent<real>::step_joints() {
  for_each_joint_slot(buffers_, [&](const JointLanes& lanes, u32 block, u32 lane) {
    Descent<real>& world = world_of(lanes, lane);
    if (world.settled) return;
    JointImpulseBlock<real>& r = buffers_.joint_impulses[block];
    if (world.moved) take_joint_step(world.beta, joint_next_[block], lane, r, joint_y_[block]);
    const PairStep<real> step =
        step_joint(buffers_.joint_blocks[block], lanes.free[lane], lane, joint_metrics_[block * PACK + lane],
                   world.step, buffers_.motions[lanes.body_a[lane]], buffers_.motions[lanes.body_b[lane]], r,
                   joint_y_[block], joint_next_[block]);
    world.change = larger(step.change, world.change);
    const JointSideSlots& slots = buffers_.joint_side_slots[block];
    store_contributions(step, slots.slot_a[lane], slots.slot_b[lane], joint_contributions_);
  });
}

/// What all sides give a body, and how that moves it; nothing moves those that cannot move.
template <class real>
void GradientDescent<real>::move_body(u32 body) {
  if (buffers_.body_infos[body].kind != BODY_DYNAMIC) {
    sums_[body] = {};
    return;
  }
  GradientContribution<real> sum = {};
  const auto add = [&](const std::vector<GradientContribution<real>>& contributions, u32 begin, u32 end) {
    for (u32 k = begin; k < end; ++k)
      sum = {add3(sum.impulse, contributions[k].impulse), add3(sum.moment, contributions[k].moment),
             sum.length + contributions[k].length, sum.uphill + contributions[k].uphill};
  };
  if (!buffers_.body_copy_starts.empty())
    add(pair_contributions_, buffers_.body_copy_starts[body], buffers_.body_copy_starts[body + 1]);
  add(joint_contributions_, buffers_.joint_side_starts[body], buffers_.joint_side_starts[body + 1]);
  const Motion<real>& motion = buffers_.motions[body];
  const Vec3<real> dv = scale3(motion.inverse_mass, sum.impulse), dw = apply_inverse_inertia(motion, sum.moment);
  store3(ahead_[body].v, add3(vec3(motion.v), dv));
  store3(ahead_[body].w, add3(vec3(motion.w), dw));
  sums_[body] = {sum.length, sum.uphill, dot3(sum.impulse, dv) + dot3(sum.moment, dw)};
}

template <class real>
void GradientDescent<real>::take_steps() {
  for (u32 body = 0; body < params_.bodies; ++body) {
    const Descent<real>& world = worlds_[buffers_.body_infos[body].world];
    if (buffers_.body_infos[body].kind != BODY_DYNAMIC || !world.moved) continue;
    for (u32 k = 0; k < 3; ++k) {
      take_step(world.beta, ahead_[body].v[k], at_[body].v[k], buffers_.motions[body].v[k]);
      take_step(world.beta, ahead_[body].w[k], at_[body].w[k], buffers_.motions[body].w[k]);
    }
  }
}

template <class real>
bool GradientDescent<real>::is_over() const {
  return std::ranges::all_of(worlds_, [](const Descent<real>& world) { return world.settled; });
}

template <class real>
void GradientDescent<real>::run() {
  for (u32 iteration = 0; iteration < params_.iterations && !is_over(); ++iteration) {
    step_pairs();
    step_joints();
    for (u32 body = 0; body < params_.bodies; ++body) {
      if (!worlds_[buffers_.body_infos[body].world].settled) move_body(body);
    }
    for (u32 w = 0; w < params_.worlds; ++w) {
      const WorldRange& range = buffers_.world_ranges[w];
      if (worlds_[w].settled) continue;
      decide(worlds_[w], sum_of_world(sums_, range.first_body, range.body_count), accelerated_, params_.tolerance);
    }
    take_steps();
    if (params_.tolerance > 0) ++buffers_.counters[COUNTER_SWEEPS];
  }
  if (params_.tolerance > 0 && !is_over()) ++buffers_.counters[COUNTER_UNSOLVED];
  finish();
}

/// Impulses and bodies at r, which the last step that was good led to.
template <class real>
void GradientDescent<real>::finish() {
  for_each_pair_slot(buffers_, [&](const BlockBodies& bodies, u32 block, u32 lane) {
    if (!world_of(bodies, lane).moved) return;
    const u32 first = buffers_.block_rows[block].first, end = first + bodies.count[lane];
    for (u32 row = first; row < end; ++row)
      take_contact_step(real(0), next_[row], lane, buffers_.impulse_blocks[row], y_[row]);
  });
  for_each_joint_slot(buffers_, [&](const JointLanes& lanes, u32 block, u32 lane) {
    if (world_of(lanes, lane).moved)
      take_joint_step(real(0), joint_next_[block], lane, buffers_.joint_impulses[block], joint_y_[block]);
  });
  for (u32 body = 0; body < params_.bodies; ++body) {
    if (buffers_.body_infos[body].kind != BODY_DYNAMIC) continue;
    store3(buffers_.motions[body].v, vec3(at_[body].v));
    store3(buffers_.motions[body].w, vec3(at_[body].w));
  }
}

}  // namespace lockstep::reference
