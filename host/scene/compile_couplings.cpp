#include "host/scene/compile_couplings.hpp"

#include <algorithm>

#include "host/error.hpp"
#include "host/scene/couplings.hpp"
#include "host/scene/joint_springs.hpp"
#include "host/scene/spring.hpp"

namespace lockstep {

namespace {

void expect_sweeps(const Scene& scene) {
  const Settings& settings = scene.settings;
  constexpr Solver sweeping[] = {Solver::gauss_seidel, Solver::cell_gauss_seidel, Solver::jacobi, Solver::small_steps};
  if (std::ranges::find(sweeping, settings.solver) == std::end(sweeping))
    throw Error(
        Failure::input, scene.source + ": /settings/solver",
        "couplings of joints are solved by sweeps; take gauss_seidel, cell_gauss_seidel, jacobi or small_steps");
  if (settings.sleeping)
    throw Error(Failure::input, scene.source + ": /settings/sleeping",
                "an island that sleeps would not feel a coupling of its joints; leave it out in scenes with couplings");
}

template <class real>
Coupling<real> make_coupling(const Settings& settings, const CouplingDescription& in, const Origin& origin) {
  Correction correction = {settings.correction, 0};
  if (settings.solver == Solver::small_steps)
    correction =
        spring_correction(settings.dt / substeps_of(settings), settings.joint_frequency, settings.joint_damping);
  Coupling<real> out = {};
  out.low = rounded<real>(in.low, "the limits of a coupling", origin);
  out.high = rounded<real>(in.high, "the limits of a coupling", origin);
  out.limited = in.limited;
  out.correction = rounded<real>(correction.share, "the correction of a coupling", origin);
  out.softness = rounded<real>(correction.softness, "the softness of a coupling", origin);
  if (!in.spring) return out;
  const Spring<real> spring = make_spring<real>(settings, *in.spring, origin);
  out.rate = spring.rate;
  out.compliance = spring.compliance;
  out.rest = spring.rest;
  return out;
}

// A coupling with all that its phase is found by.
struct Entry {
  u32 world, id, first_joint;  // of the world
  u32 phase;
};

// Greedy in the order of ids, so that a world has the phases it has alone: of one phase no two couplings share a body
// that can move, or a joint. Those that no colour is left for have a phase each.
template <class real>
std::vector<Entry> in_phases(std::span<const Scene> worlds, const Buffers<real>& b, std::vector<u32>& phases) {
  std::vector<std::uint64_t> taken(b.body_infos.size() + 1, 0);
  std::vector<Entry> entries;
  u32 first_joint = 0;
  for (u32 world = 0; world < worlds.size(); ++world) {
    u32 more = MAX_COLORS;
    for (u32 id = 0; id < worlds[world].couplings.size(); ++id) {
      std::vector<u32> bodies;
      for (const CoupledCoordinate& coupled : worlds[world].couplings[id].joints)
        for (const u32 body :
             {b.joint_infos[first_joint + coupled.joint].body_a, b.joint_infos[first_joint + coupled.joint].body_b})
          if (body < b.body_infos.size() && b.body_infos[body].kind == BODY_DYNAMIC) bodies.push_back(body);
      std::uint64_t used = 0;
      for (const u32 body : bodies) used |= taken[body];
      u32 color = 0;
      while (color < MAX_COLORS && (used >> color & 1) != 0) ++color;
      for (const u32 body : bodies)
        if (color < MAX_COLORS) taken[body] |= std::uint64_t{1} << color;
      entries.push_back({world, id, first_joint, color < MAX_COLORS ? color : more++});
    }
    first_joint += static_cast<u32>(worlds[world].joints.size());
  }
  std::ranges::stable_sort(entries, {}, &Entry::phase);
  for (u32 i = 0; i < entries.size(); ++i)
    if (i == 0 || entries[i].phase != entries[i - 1].phase) phases.push_back(i);
  phases.push_back(static_cast<u32>(entries.size()));
  return entries;
}

template <class real>
std::vector<u32> joint_slots(const Buffers<real>& b) {
  std::vector<u32> slots(b.joints.size());
  for (u32 slot = 0; slot < b.joint_lanes.size() * PACK; ++slot)
    if (const u32 joint = b.joint_lanes[slot / PACK].joint[slot % PACK]; joint != NONE) slots[joint] = slot;
  return slots;
}

}  // namespace

template <class real>
void compile_couplings(std::span<const Scene> worlds, InitialState<real>& state) {
  if (std::ranges::all_of(worlds, [](const Scene& scene) { return scene.couplings.empty(); })) return;
  expect_sweeps(worlds[0]);
  Buffers<real>& b = state.buffers;
  const std::vector<u32> slots = joint_slots(b);
  for (const Entry& entry : in_phases(worlds, b, b.coupling_phases)) {
    const Scene& scene = worlds[entry.world];
    const CouplingDescription& coupling = scene.couplings[entry.id];
    const Origin origin = {scene, nullptr, &scene.joints[coupling.joints[0].joint]};
    b.couplings.push_back(make_coupling<real>(worlds[0].settings, coupling, origin));
    b.coupling_infos.push_back(
        {static_cast<u32>(b.coupled_joints.size()), static_cast<u32>(coupling.joints.size()), entry.world, entry.id});
    for (const CoupledCoordinate& coupled : coupling.joints) {
      const u32 joint = entry.first_joint + coupled.joint;
      const JointInfo& info = b.joint_infos[joint];
      b.coupled_joints.push_back({joint, slots[joint], info.body_a, info.body_b, info.free});
      b.coupling_ratios.push_back(rounded<real>(coupled.ratio, "a ratio of a coupling", origin));
    }
    if (coupling.spring) state.features = with(state.features, Feature::joint_springs);
  }
  state.features = with(state.features, Feature::couplings);
  state.sizes.couplings = static_cast<u32>(b.couplings.size());
  state.sizes.coupled_joints = static_cast<u32>(b.coupled_joints.size());
  state.sizes.coupling_phases = static_cast<u32>(b.coupling_phases.size()) - 1;
}

template void compile_couplings(std::span<const Scene>, InitialState<float>&);
template void compile_couplings(std::span<const Scene>, InitialState<double>&);

}  // namespace lockstep
