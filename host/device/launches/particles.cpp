// Launches of the stages of bodies as particles.
#include <bit>
#include <utility>

#include "host/device/launcher.hpp"

namespace lockstep {

namespace {

// Few enough work-items not to fight over the largest extent.
constexpr u32 bounds_per_item = 16;

}  // namespace

void launch_bound_particles(Launcher& launcher) {
  launcher.run("bound_particles", (launcher.plan().sizes.particles + bounds_per_item - 1) / bounds_per_item);
}

void launch_sort_particles(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  for (const char* name : {"particle_keys", "spare_keys", "spare_items"}) launcher.scratch(name, sizes.particles);
  // the last pass ends in particle_items; what has no bucket has a key of one bit more
  const u32 bits = static_cast<u32>(std::bit_width(sizes.buckets));
  SortArrays arrays = {"particle_keys", "particle_items", "spare_keys", "spare_items"};
  if (sizes.particles > 1 && launcher.sort_passes(bits) % 2 == 1) std::swap(arrays.values, arrays.spare_values);
  launcher.run("sort_particles_keys", sizes.particles, {{"keys", arrays.keys}, {"values", arrays.values}});
  arrays = launcher.sort(arrays, sizes.particles, bits);
  launcher.run("sort_particles_starts", sizes.particles + 1, {{"keys", arrays.keys}});
}

void launch_find_neighbours(Launcher& launcher) {
  const Sizes& sizes = launcher.plan().sizes;
  launcher.scratch("bucket_owners", sizes.buckets);
  launcher.run("find_neighbours_owners", sizes.buckets);
  launcher.run("find_neighbours_count", sizes.particles + 1);
  launcher.scan("neighbour_starts", sizes.particles + 1);
  launcher.run("find_neighbours_write", sizes.particles);
}

void launch_match_springs(Launcher& launcher) {
  const LaunchPlan& plan = launcher.plan();
  launcher.scratch("spring_starts", std::size_t{plan.sizes.particles} + 1);
  launcher.run("match_springs_index", plan.pairs + 1);
  launcher.run("match_springs", plan.sizes.particles);
}

void launch_push_particles(Launcher& launcher) { launcher.run("push_particles", launcher.plan().sizes.particles); }

void launch_sum_particles(Launcher& launcher) { launcher.run("sum_particles", launcher.plan().sizes.bodies); }

void launch_update_particles(Launcher& launcher) { launcher.run("update_particles", launcher.plan().sizes.particles); }

void launch_store_springs(Launcher& launcher) { launcher.run("store_springs", launcher.plan().sizes.particles); }

}  // namespace lockstep
