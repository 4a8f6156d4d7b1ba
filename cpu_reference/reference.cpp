#include "cpu_reference/reference.hpp"

#include "cpu_reference/add_geometric_stiffness.hpp"
#include "cpu_reference/begin_step.hpp"
#include "cpu_reference/bound_particles.hpp"
#include "cpu_reference/build_tree.hpp"
#include "cpu_reference/cast_rays.hpp"
#include "cpu_reference/close_joints.hpp"
#include "cpu_reference/collide.hpp"
#include "cpu_reference/color_contacts.hpp"
#include "cpu_reference/compare_shapes.hpp"
#include "cpu_reference/couple_contacts.hpp"
#include "cpu_reference/end_step.hpp"
#include "cpu_reference/factor_articulations.hpp"
#include "cpu_reference/fall_asleep.hpp"
#include "cpu_reference/find_events.hpp"
#include "cpu_reference/find_neighbours.hpp"
#include "cpu_reference/find_overlaps.hpp"
#include "cpu_reference/find_pairs.hpp"
#include "cpu_reference/hash_state.hpp"
#include "cpu_reference/integrate_free_flight.hpp"
#include "cpu_reference/integrate_positions.hpp"
#include "cpu_reference/integrate_velocities.hpp"
#include "cpu_reference/mark_touching.hpp"
#include "cpu_reference/match_contacts.hpp"
#include "cpu_reference/match_springs.hpp"
#include "cpu_reference/move_seams.hpp"
#include "cpu_reference/pack_contacts.hpp"
#include "cpu_reference/pack_points.hpp"
#include "cpu_reference/partition_contacts.hpp"
#include "cpu_reference/prepare_contacts.hpp"
#include "cpu_reference/prepare_couplings.hpp"
#include "cpu_reference/prepare_joints.hpp"
#include "cpu_reference/project_planar_joints.hpp"
#include "cpu_reference/push_particles.hpp"
#include "cpu_reference/relax_constraints.hpp"
#include "cpu_reference/schedule_contacts.hpp"
#include "cpu_reference/search_tree.hpp"
#include "cpu_reference/separate_contacts.hpp"
#include "cpu_reference/solve_constraints.hpp"
#include "cpu_reference/sort_cells.hpp"
#include "cpu_reference/sort_particles.hpp"
#include "cpu_reference/sort_shapes.hpp"
#include "cpu_reference/split_bodies.hpp"
#include "cpu_reference/spread_patches.hpp"
#include "cpu_reference/store_impulses.hpp"
#include "cpu_reference/store_springs.hpp"
#include "cpu_reference/sum_impulses.hpp"
#include "cpu_reference/sum_particles.hpp"
#include "cpu_reference/update_bounds.hpp"
#include "cpu_reference/update_particles.hpp"
#include "cpu_reference/wake_islands.hpp"
#include "cpu_reference/warm_start.hpp"

namespace lockstep::reference {

template <class real>
void run_stage(Stage stage, Buffers<real>& buffers, const StepParams<real>& params) {
  switch (stage) {
#define STAGE(name, ...) \
  case Stage::name:      \
    return name(buffers, params);
#include "host/stages.def"
#undef STAGE
    case Stage::count: return;
  }
}

template void run_stage<float>(Stage, Buffers<float>&, const StepParams<float>&);
template void run_stage<double>(Stage, Buffers<double>&, const StepParams<double>&);

}  // namespace lockstep::reference
