// Contacts and joints: colours, blocks, sweeps. A small scene takes one launch a stage, in one work-group.
#include <algorithm>
#include <initializer_list>
#include <ranges>
#include <string_view>

#include "host/device/launcher.hpp"
#include "host/device/launches/gradient.hpp"

namespace lockstep {

namespace {

constexpr u32 rounds_per_color = 2;  // what colouring usually needs; the last work-group does the rest

// Places for cells, those of all phases.
u32 cell_count(const LaunchPlan& plan) { return CELL_PHASES * cells_in_phase(plan.sizes.bodies, plan.sizes.worlds); }

// A launch for each phase of the cells.
void sweep_cells(Launcher& launcher, std::string_view kernel) {
  const LaunchPlan& plan = launcher.plan();
  if (!has(plan.features, Feature::partitions)) return;
  const u32 items = cell_count(plan) / CELL_PHASES * (plan.lanes > 1 ? 1 : PACK);
  for (u32 phase = 0; phase < CELL_PHASES; ++phase) launcher.run(kernel, items, {{"phase", phase}});
}

// The first phase of the contacts that has no launch of its own.
u32 first_tail_phase(const LaunchPlan& plan) {
  return plan.colors + (has(plan.features, Feature::partitions) ? CELL_PHASES : 0);
}

// A launch for each colour that is worth one, then one work-group for the small colours and the overflow.
void sweep(Launcher& launcher, std::string_view color_kernel, std::string_view tail_kernel,
           std::initializer_list<Argument> tail_arguments) {
  const LaunchPlan& plan = launcher.plan();
  if (!has(plan.features, Feature::contacts)) return;
  const u32 items = plan.blocks * (PACK / plan.lanes);
  for (u32 color = 0; color < plan.colors; ++color) launcher.run(color_kernel, items / plan.colors, {{"color", color}});
  launcher.run_group(tail_kernel, tail_arguments);
}

bool is_large(const LaunchPlan& plan, u32 joint_phase) {
  return !plan.one_team && plan.joint_phases[joint_phase + 1] - plan.joint_phases[joint_phase] >= LARGE_COLOR;
}

// The same for phases of joints, which are known: the large ones come first.
void launch_joint_phases(Launcher& launcher, u32 phase, u32 phases, std::string_view phase_kernel,
                         std::string_view tail_kernel) {
  const LaunchPlan& plan = launcher.plan();
  for (; phase < phases && is_large(plan, phase); ++phase) {
    const u32 begin = plan.joint_phases[phase], end = plan.joint_phases[phase + 1];
    launcher.run(phase_kernel, (end - begin) * (PACK / plan.lanes), {{"begin", begin}, {"end", end}});
  }
  if (phase < phases) launcher.run_group(tail_kernel, {{"first_phase", phase}, {"phases", phases}});
}

// Those that no articulation solves alone.
void sweep_joints(Launcher& launcher, std::string_view phase_kernel, std::string_view tail_kernel) {
  launch_joint_phases(launcher, 0, launcher.plan().swept_joint_phases, phase_kernel, tail_kernel);
}

// All of them, in one work-group.
void sweep_couplings(Launcher& launcher, std::string_view kernel) {
  const LaunchPlan& plan = launcher.plan();
  if (has(plan.features, Feature::couplings))
    launcher.run_group(kernel, {{"coupling_phase_count", plan.sizes.coupling_phases}});
}

void warm_joints(Launcher& launcher) {
  const u32 swept = launcher.plan().swept_joint_phases, all = launcher.plan().sizes.joint_phases;
  launch_joint_phases(launcher, 0, swept, "warm_joints", "warm_joint_tail");
  launch_joint_phases(launcher, swept, all, "warm_joints", "warm_joint_tail");
  sweep_couplings(launcher, "warm_couplings");
}

// A pass of Jacobi's method: all pairs at once on copies of their bodies, then the bodies whole again.
void pass_over_body_copies(Launcher& launcher, std::string_view kernel) {
  const LaunchPlan& plan = launcher.plan();
  launcher.run(kernel, plan.blocks * (PACK / plan.lanes));
  launcher.run("average_body_copies", plan.sizes.bodies, {{"bodies", plan.sizes.bodies}});
}

// Room for a velocity of each side of each pair.
void make_room_for_body_copies(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.scratch("body_copies", std::size_t{plan.sizes.contacts} * 2 * 8 * plan.real_words);
}

// Whether one work-group does all sweeps, or a team.
bool is_fused(const LaunchPlan& plan) {
  if (plan.one_team) return true;
  const bool in_cells = has(plan.features, Feature::partitions);
  const bool few = in_cells ? plan.blocks < LARGE_COLOR * CELL_PHASES : plan.colors == 0;
  const auto is_large_phase = [&](u32 phase) { return is_large(plan, phase); };
  return (plan.small || few) && plan.sizes.links < LARGE_COLOR * PACK &&
         std::ranges::none_of(std::views::iota(0u, plan.sizes.joint_phases), is_large_phase);
}

// What links answer to the rows of joints that close loops.
void make_room_for_closures(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const std::size_t words = sizeof(LinkMotion<float>) / sizeof(float) * plan.real_words;
  launcher.scratch("closure_columns", std::max<std::size_t>(1, plan.sizes.closure_columns * words));
}

// Behind each sweep of several launches.
void end_sweep(Launcher& launcher, u32 sweep) {
  const LaunchPlan& plan = launcher.plan();
  if (!has(plan.features, Feature::tolerance)) return;
  launcher.run("end_sweep", 1, {{"is_last", sweep + 1 == plan.counts.iterations ? 1u : 0u}});
}

void solve_by_body_copies(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  make_room_for_body_copies(launcher);
  if (is_fused(plan))
    return launcher.run_group("solve_body_copies_group", {{"bodies", plan.sizes.bodies},
                                                          {"joint_phase_count", plan.swept_joint_phases},
                                                          {"coupling_phase_count", plan.sizes.coupling_phases},
                                                          {"sweeps", plan.counts.iterations}});
  for (u32 i = 0; i < plan.counts.iterations; ++i) {
    sweep_joints(launcher, "solve_joints", "solve_joint_tail");
    sweep_couplings(launcher, "solve_couplings");
    pass_over_body_copies(launcher, "solve_body_copies");
    end_sweep(launcher, i);
  }
}

// The dense matrix, sweeps by it, and bodies that get what impulses have changed by. Joints take turns with the sweeps;
// where no joint does, and no tolerance asks after each of them, one launch makes all.
void solve_by_dense_matrix(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const std::size_t block_reals = std::size_t{9} * PACK * PACK, tile_reals = std::size_t{10} * PACK;
  launcher.scratch("dense_blocks", plan.sizes.coupled_tiles * block_reals * plan.real_words);
  launcher.scratch("dense_tiles", tile_count(plan.sizes.contacts, plan.sizes.worlds) * tile_reals * plan.real_words);
  launcher.scratch("dense_changes", std::size_t{plan.sizes.rows} * 3 * PACK * plan.real_words);
  const bool jointed = plan.sizes.joint_phases > 0, one_by_one = jointed || has(plan.features, Feature::tolerance);
  const u32 rounds = one_by_one ? plan.counts.iterations : 1, sweeps = one_by_one ? 1 : plan.counts.iterations;
  if (is_fused(plan))
    return launcher.run_group("solve_dense_group",
                              {{"rounds", rounds}, {"sweeps", sweeps}, {"joint_phase_count", plan.swept_joint_phases}});

  const auto measure = [&] { launcher.run("dense_measure", std::max(plan.contacts, plan.blocks * PACK)); };
  const auto apply_to_bodies = [&] {
    launcher.run("dense_finish", plan.contacts);
    sweep(launcher, "dense_apply_color", "dense_apply_tail", {{"first_color", plan.colors}});
  };
  launcher.run("dense_matrix", plan.sizes.coupled_tiles * (PACK / plan.lanes));
  measure();
  for (u32 i = 0; i < rounds; ++i) {
    sweep_joints(launcher, "solve_joints", "solve_joint_tail");
    if (jointed) measure();
    launcher.run_groups("dense_sweep", plan.sizes.worlds, {{"sweeps", sweeps}});
    if (jointed) apply_to_bodies();
    if (one_by_one) end_sweep(launcher, i);
  }
  if (!jointed) apply_to_bodies();
}

}  // namespace

void launch_color_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  if (plan.lanes > 1) {  // a CPU: few threads, quick ones
    const bool sleeping = has(plan.features, Feature::sleeping);
    if (sleeping) launcher.scratch("color_order", plan.sizes.contacts);
    return launcher.run("color_worlds", plan.sizes.worlds,
                        {{"color_order", std::string_view(sleeping ? "color_order" : "contact_colors")}});
  }
  launcher.scratch("color_bids", std::size_t{3} * plan.sizes.bodies);
  launcher.scratch("colorless", plan.sizes.contacts);
  launcher.scratch("colorless_count", 1);
  launcher.run("color_start", 2 * plan.sizes.bodies);
  const u32 rounds = plan.small ? 0 : rounds_per_color * plan.colors + 1;
  for (u32 round = 0; round < rounds; ++round) launcher.run("color_round", plan.contacts, {{"round", round}});
  launcher.run("color_gather", plan.contacts);
  launcher.run_group("color_tail", {{"first_round", rounds}});
}

void launch_partition_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 cells = cell_count(plan);
  launcher.scratch("pair_cells", plan.sizes.contacts);
  launcher.scratch("pair_arrivals", plan.sizes.contacts);
  launcher.scratch("cell_ends", cells);
  launcher.scratch("body_cells", std::size_t{plan.sizes.bodies} * 4);
  launcher.run("partition_bodies", std::max({plan.sizes.bodies, cells + 1, plan.contacts}));
  launcher.run("partition_count", plan.contacts);
  launcher.scan("cell_starts", cells + 1);
  if (plan.lanes > 1) return launcher.run("partition_fill_worlds", plan.sizes.worlds);  // a CPU: few threads
  launcher.run("partition_fill", plan.contacts);
  launcher.run("partition_order", cells);
}

void launch_schedule_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 cells = cell_count(plan);
  launcher.scratch("body_batches", std::size_t{plan.sizes.bodies} * CELL_PHASES * 2);
  launcher.run("schedule_clear", plan.contacts);
  if (plan.lanes > 1) {  // a CPU: few threads, quick ones
    launcher.run("schedule_cells", cells);
  } else {
    launcher.scratch("pair_ranks", plan.sizes.contacts);
    launcher.run("schedule_cells_by_groups", cells * PACK);
  }
  launcher.scan("cell_blocks", cells + 1);
  launcher.scan("cell_rows", cells + 1);
}

void launch_pack_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  if (has(plan.features, Feature::partitions)) launcher.run("pack_cells", cell_count(plan));
  const u32 keys = (MAX_COLORS + 1) * (has(plan.features, Feature::manifolds) ? MANIFOLD_POINTS : 1);
  const u32 words = keys * (plan.sizes.contacts / CHUNK + 1) + 1;  // the sum of all behind them
  launcher.scratch("pack_counts", words);
  launcher.scratch("pack_offsets", keys);
  launcher.scratch("pack_rows", keys);
  if (plan.small && plan.lanes > 1) return launcher.run_group("pack_small");
  const u32 chunks = plan.contacts / CHUNK + 1;
  launcher.run_chunks("pack_count", chunks);
  launcher.scan("pack_counts", words);
  launcher.run_group("pack_starts");
  launcher.run_chunks("pack_scatter", chunks);
  launcher.run("pack_find", plan.blocks * PACK);
}

void launch_split_bodies(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 sides = plan.blocks * 2 * PACK;
  launcher.scratch("copy_arrivals", std::size_t{plan.sizes.blocks} * 2 * PACK);
  launcher.scratch("copy_sides", std::size_t{plan.sizes.contacts} * 2);
  launcher.run("split_clear", plan.sizes.bodies + 1);
  launcher.run("split_count", sides);
  launcher.scan("body_copy_starts", plan.sizes.bodies + 1);
  launcher.run("split_fill", sides);
  launcher.run("split_order", plan.sizes.bodies);
}

void launch_couple_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 tiles = tile_count(plan.sizes.contacts, plan.sizes.worlds);
  const u32 words = plan.sizes.bodies * (DENSE_CONTACTS / PACK / 32);
  launcher.scratch("body_tiles", words);
  launcher.run("couple_clear", std::max(tiles, words));
  launcher.run("couple_mark", plan.contacts);
  launcher.run("couple_count", tiles);
  launcher.scan("tile_starts", tiles + 1);
  launcher.run("couple_fill", tiles, {{"coupled_tile_capacity", plan.sizes.coupled_tiles}});
}

void launch_pack_points(Launcher& launcher) { launcher.run("pack_points", launcher.plan().blocks * PACK); }

void launch_prepare_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.run("prepare_contacts", plan.blocks * (PACK / plan.lanes));
}

void launch_add_geometric_stiffness(Launcher& launcher) {
  launcher.run("add_geometric_stiffness", launcher.plan().sizes.bodies);
}

void launch_project_planar_joints(Launcher& launcher) {
  const u32 planar_joints = launcher.plan().sizes.planar_joints;
  launcher.run("project_planar_joints", planar_joints, {{"planar_count", planar_joints}});
}

void launch_prepare_joints(Launcher& launcher) {
  launcher.run("prepare_joints", launcher.plan().sizes.joint_blocks * PACK);
}

void launch_prepare_couplings(Launcher& launcher) {
  const u32 count = launcher.plan().sizes.couplings;
  launcher.run("prepare_couplings", count, {{"coupling_count", count}});
}

void launch_factor_articulations(Launcher& launcher) {
  const u32 count = launcher.plan().sizes.articulations;
  make_room_for_closures(launcher);
  launcher.run_groups("factor_articulations", count, {{"articulation_count", count}});
}

void launch_warm_start(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  if (has(plan.features, Feature::jacobi)) {
    make_room_for_body_copies(launcher);
    warm_joints(launcher);
    return pass_over_body_copies(launcher, "warm_body_copies");
  }
  if (is_fused(plan))
    return launcher.run_group("warm_tail", {{"first_phase", 0u},
                                            {"joint_phase_count", plan.sizes.joint_phases},
                                            {"coupling_phase_count", plan.sizes.coupling_phases}});
  warm_joints(launcher);
  sweep_cells(launcher, "warm_cells");
  sweep(launcher, "warm_color", "warm_tail",
        {{"first_phase", first_tail_phase(plan)}, {"joint_phase_count", 0u}, {"coupling_phase_count", 0u}});
}

void launch_solve_constraints(Launcher& launcher) {
  if (has(launcher.plan().features, Feature::gradient)) return solve_by_gradient(launcher, is_fused(launcher.plan()));
  if (has(launcher.plan().features, Feature::dense)) return solve_by_dense_matrix(launcher);
  if (has(launcher.plan().features, Feature::jacobi)) return solve_by_body_copies(launcher);
  const LaunchPlan& plan = launcher.plan();
  if (is_fused(plan))
    return launcher.run_group("solve_tail", {{"first_phase", 0u},
                                             {"articulation_count", plan.sizes.articulations},
                                             {"joint_phase_count", plan.swept_joint_phases},
                                             {"coupling_phase_count", plan.sizes.coupling_phases},
                                             {"sweeps", plan.counts.iterations},
                                             {"whole", 1u}});
  const u32 articulations = plan.sizes.articulations;
  for (u32 i = 0; i < plan.counts.iterations; ++i) {
    if (articulations > 0)
      launcher.run_groups("solve_articulations", articulations, {{"articulation_count", articulations}});
    sweep_joints(launcher, "solve_joints", "solve_joint_tail");
    sweep_couplings(launcher, "solve_couplings");
    sweep_cells(launcher, "solve_cells");
    sweep(launcher, "solve_color", "solve_tail",
          {{"first_phase", first_tail_phase(plan)},
           {"articulation_count", 0u},
           {"joint_phase_count", 0u},
           {"coupling_phase_count", 0u},
           {"sweeps", 1u},
           {"whole", 0u}});
    end_sweep(launcher, i);
  }
}

void launch_relax_constraints(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  if (is_fused(plan))
    return launcher.run_group("relax_tail", {{"first_phase", 0u},
                                             {"joint_phase_count", plan.swept_joint_phases},
                                             {"coupling_phase_count", plan.sizes.coupling_phases},
                                             {"sweeps", plan.counts.relaxations}});
  for (u32 i = 0; i < plan.counts.relaxations; ++i) {
    sweep_joints(launcher, "relax_joints", "relax_joint_tail");
    sweep_couplings(launcher, "relax_couplings");
    sweep(launcher, "relax_color", "relax_tail",
          {{"first_phase", plan.colors}, {"joint_phase_count", 0u}, {"coupling_phase_count", 0u}, {"sweeps", 1u}});
  }
}

// Articulations make all of theirs at once where nothing else is swept; so does a work-group that is alone.
void launch_close_joints(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 articulations = plan.sizes.articulations;
  const bool alone = plan.swept_joint_phases == 0 || (articulations == 0 && !is_large(plan, 0));
  const u32 passes = alone ? 1 : plan.counts.position_sweeps;
  if (articulations > 0) {
    launcher.scratch("articulation_angles", articulations);
    make_room_for_closures(launcher);
  }
  for (u32 i = 0; i < passes; ++i) {
    if (articulations > 0)
      launcher.run_groups("close_articulations", articulations,
                          {{"articulation_count", articulations}, {"sweeps", plan.counts.position_sweeps / passes}});
    sweep_joints(launcher, "close_joint_phase", "close_joint_tail");
  }
}

void launch_separate_contacts(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  const u32 sweeps = plan.counts.position_sweeps;
  if (is_fused(plan)) return launcher.run_group("separate_tail", {{"first_phase", 0u}, {"sweeps", sweeps}});
  for (u32 i = 0; i < sweeps; ++i)
    sweep(launcher, "separate_color", "separate_tail", {{"first_phase", plan.colors}, {"sweeps", 1u}});
}

void launch_sum_impulses(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  if (has(plan.features, Feature::contacts)) launcher.run("sum_contact_impulses", plan.blocks * (PACK / plan.lanes));
  if (has(plan.features, Feature::joints))
    launcher.run("sum_joint_impulses", plan.sizes.joint_blocks * (PACK / plan.lanes));
}

void launch_spread_patches(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.run("spread_patches", plan.blocks * (PACK / plan.lanes));
}

void launch_store_impulses(Launcher& launcher) { launcher.run("store_impulses", launcher.plan().contacts); }

}  // namespace lockstep
