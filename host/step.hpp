// The pipeline. This is the whole simulator on one screen.
#pragma once

#include "host/stages.hpp"

namespace lockstep {

/// One time step. Each line is one stage: a kernel and a reference function of the same name. A stage that the scene's
/// features do not ask for is skipped by the backend. A step that runs out of room, or wakes somebody (STATUS_ABORTED),
/// leaves the persistent buffers as they were but for who sleeps, so that it can be redone.
template <class Backend, class real>
void step(Backend& backend, StepParams<real> p) {
  backend.run(Stage::begin_step, p);

  // which shapes touch, and what the last step knew about it: pairs come from a grid, a tree of boxes, or all of few
  backend.run(Stage::update_bounds, p);
  backend.run(Stage::move_seams, p);
  backend.run(Stage::sort_cells, p);
  backend.run(Stage::find_pairs, p);
  backend.run(Stage::compare_shapes, p);
  backend.run(Stage::sort_shapes, p);
  backend.run(Stage::build_tree, p);
  backend.run(Stage::search_tree, p);
  backend.run(Stage::collide, p);
  backend.run(Stage::wake_islands, p);
  backend.run(Stage::match_contacts, p);

  // contacts of one colour share no movable body, so that a colour is solved at once; before them, where they are
  // wanted, come cells of space, of which every second one along each axis is; or all contacts are, on copies of
  // bodies; or one after another, by the matrix of those that share bodies
  backend.run(Stage::partition_contacts, p);
  backend.run(Stage::schedule_contacts, p);
  backend.run(Stage::color_contacts, p);
  backend.run(Stage::pack_contacts, p);
  backend.run(Stage::split_bodies, p);
  backend.run(Stage::couple_contacts, p);
  backend.run(Stage::pack_points, p);

  // or bodies push each other by their particles
  backend.run(Stage::bound_particles, p);
  backend.run(Stage::sort_particles, p);
  backend.run(Stage::find_neighbours, p);
  backend.run(Stage::match_springs, p);

  for (p.substep = 0; p.substep < p.substeps; ++p.substep) {
    backend.run(Stage::push_particles, p);
    backend.run(Stage::sum_particles, p);
    backend.run(Stage::integrate_velocities, p);
    backend.run(Stage::add_geometric_stiffness, p);
    backend.run(Stage::prepare_joints, p);
    backend.run(Stage::prepare_couplings, p);
    backend.run(Stage::factor_articulations, p);
    backend.run(Stage::prepare_contacts, p);
    backend.run(Stage::warm_start, p);
    backend.run(Stage::solve_constraints, p);
    backend.run(Stage::integrate_positions, p);
    backend.run(Stage::close_joints, p);
    backend.run(Stage::separate_contacts, p);
    backend.run(Stage::relax_constraints, p);
    backend.run(Stage::project_planar_joints, p);
    backend.run(Stage::sum_impulses, p);
    backend.run(Stage::integrate_free_flight, p);
    backend.run(Stage::update_particles, p);
    backend.run(Stage::mark_touching, p);
  }

  backend.run(Stage::spread_patches, p);
  backend.run(Stage::store_impulses, p);
  backend.run(Stage::store_springs, p);
  backend.run(Stage::find_events, p);
  backend.run(Stage::fall_asleep, p);
  backend.run(Stage::end_step, p);
}

}  // namespace lockstep
