#include "host/backends/substep_plan.hpp"

#include <algorithm>

#include "host/backends/device_backend.hpp"
#include "host/error.hpp"

namespace lockstep {

namespace {

// Up to this many bodies, shapes, particles and joints one work-group does all sub-steps, and no thread of a CPU device
// is woken (docs/lab/performance.md).
constexpr u32 few_items = 512;

bool has_few_items(const Sizes& sizes) {
  return std::max({sizes.bodies, sizes.shapes, sizes.joints, sizes.particles}) <= few_items;
}

// Pairs of cylinders and hulls take microseconds each: of more shapes than this they are worth a thread to wake.
constexpr u32 few_expensive_shapes = 128;

bool is_for_one_thread(const Sizes& sizes, Features features) {
  const bool expensive = has(features, Feature::cylinders) || has(features, Feature::hulls);
  return has_few_items(sizes) && (!expensive || sizes.shapes <= few_expensive_shapes);
}

// Whether the kernels of all its stages meet as teams.
bool can_meet(Features features) {
  return !has(features, Feature::partitions) && !has(features, Feature::gradient) && !has(features, Feature::dense);
}

}  // namespace

SubstepPlan substep_plan(const Sizes& sizes, Features features, const DeviceInfo& device,
                         const DeviceOptions& options) {
  if (!options.only.empty()) return SubstepPlan::launches;
  const bool small = !options.profile && has_few_items(sizes);
  const SubstepPlan plan = options.substeps.value_or(small ? SubstepPlan::one_group : SubstepPlan::launches);
  if (plan != SubstepPlan::all_groups) return plan;
  // OpenCL 1.2 does not promise that the groups of a launch run at once, and see what others write
  if (device.type != DeviceType::cpu)
    throw Error(Failure::input, "--plan", "all_groups is for CPU devices; take launches or one_group");
  if (!can_meet(features))
    throw Error(Failure::input, "--plan",
                "all_groups is not for cell_gauss_seidel, gradients and dense matrices; take launches or one_group");
  return plan;
}

bool may_try_all_groups(const Sizes& sizes, Features features, const DeviceInfo& device, u32 compute_units,
                        const DeviceOptions& options) {
  return !options.substeps && !options.profile && options.only.empty() && device.type == DeviceType::cpu &&
         compute_units > 1 && !has_few_items(sizes) && can_meet(features);
}

u32 threads_for(const DeviceInfo& device, const Sizes& sizes, Features features, u32 asked) {
  return asked == 0 && is_for_one_thread(sizes, features) && runs_in_caller(device) ? 1 : asked;
}

}  // namespace lockstep
