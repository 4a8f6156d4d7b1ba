#include "host/backends/launch_plan.hpp"

#include <algorithm>

namespace lockstep {

namespace {

// Up to this many contacts, and joints, one work-group solves the whole scene: launches and colours cost more than they
// share out.
constexpr u32 small_contacts = 1024;

bool is_small(const Sizes& sizes, u32 contacts) { return contacts <= small_contacts && sizes.joints <= small_contacts; }

// Phases of joints that are not left to their articulations alone: the first ones.
template <class real>
u32 swept_joint_phases(const Buffers<real>& b) {
  u32 phases = 0;
  while (phases + 1 < b.joint_phases.size()) {
    const u32 first_joint = b.joint_lanes[b.joint_phases[phases]].joint[0];
    if (b.joint_infos[first_joint].direct != 0) break;
    ++phases;
  }
  return phases;
}

}  // namespace

template <class real>
LaunchPlan first_plan(const InitialState<real>& state, u32 lanes) {
  const Sizes& sizes = state.sizes;
  LaunchPlan plan;
  plan.sizes = sizes;
  plan.features = state.features;
  plan.pairs = sizes.pairs;
  plan.contacts = sizes.contacts;
  plan.blocks = sizes.blocks;
  plan.colors = 16;
  plan.real_words = sizeof(real) / sizeof(u32);
  plan.lanes = lanes;
  plan.small = is_small(sizes, has(plan.features, Feature::contacts) ? sizes.contacts : 0);
  plan.joint_phases = state.buffers.joint_phases;
  plan.swept_joint_phases = swept_joint_phases(state.buffers);
  plan.counts = counts_of(state.params);
  return plan;
}

LaunchPlan fused_plan(LaunchPlan plan) {
  plan.small = plan.one_team = true;
  plan.pairs = plan.contacts = plan.blocks = plan.colors = 0;
  return plan;
}

void update_plan(LaunchPlan& plan, const Counters& counters) {
  plan.pairs = counters[COUNTER_PAIRS];
  plan.contacts = counters[COUNTER_CONTACTS];
  plan.blocks = counters[COUNTER_BLOCKS];
  plan.colors = counters[COUNTER_LARGE_COLORS];
  plan.small = is_small(plan.sizes, plan.contacts);
}

std::vector<Buffer> state_of(const FusedSubsteps& fused, Features features) {
  std::vector<Buffer> buffers;
  for (const Stage stage : fused.stages)
    for (const Buffer buffer : info(stage).writes)
      if (info(buffer).lifetime == Lifetime::persistent && has(features, info(buffer).feature) &&
          std::ranges::count(buffers, buffer) == 0)
        buffers.push_back(buffer);
  return buffers;
}

template LaunchPlan first_plan(const InitialState<float>&, u32);
template LaunchPlan first_plan(const InitialState<double>&, u32);

}  // namespace lockstep
