// How the sub-steps of a step are launched on a device; nothing here can change a bit.
#pragma once

#include <string_view>

#include "host/device/devices.hpp"
#include "host/features.hpp"

namespace lockstep {

struct DeviceOptions;
struct Sizes;

/// A launch for each phase of each stage; or all sub-steps as one launch, of one work-group, or of as many as the
/// device runs at once, which meet at barriers of their own (kernels/team.h).
enum class SubstepPlan { launches, one_group, all_groups };

inline constexpr std::string_view substep_plan_names[] = {"launches", "one_group", "all_groups"};

/// How a backend made with these options runs sub-steps. Throws Error (input) for a plan that the scene or the device
/// does not allow.
SubstepPlan substep_plan(const Sizes& sizes, Features features, const DeviceInfo& device, const DeviceOptions& options);

/// Whether all_groups is worth a trial beside the launches that it runs by.
bool may_try_all_groups(const Sizes& sizes, Features features, const DeviceInfo& device, u32 compute_units,
                        const DeviceOptions& options);

/// Compute units of a CPU device for this scene, as open_device() takes them: 1 where it is small, else `asked`.
u32 threads_for(const DeviceInfo& device, const Sizes& sizes, Features features, u32 asked);

}  // namespace lockstep
