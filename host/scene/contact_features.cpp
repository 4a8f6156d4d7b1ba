#include "host/scene/contact_features.hpp"

namespace lockstep {

bool couples_normals(const Settings& settings, Features features) {
  return has(features, Feature::manifolds) && has(features, Feature::general_contacts) && settings.coupled_normals &&
         !(tolerance_of(settings) > 0);
}

bool separates_contacts(const Settings& settings, Features features) {
  // these close joints by the velocities that they find, and bodies that are moved after that would open them
  const bool closes_joints = settings.solver == Solver::impulse_based || is_reduced(settings.solver);
  return has(features, Feature::contacts) && !has(features, Feature::jacobi) && !has(features, Feature::partitions) &&
         !has(features, Feature::pivots) && settings.solver != Solver::small_steps && !closes_joints &&
         settings.stabilization == Stabilization::positions && settings.correction > 0;
}

}  // namespace lockstep
