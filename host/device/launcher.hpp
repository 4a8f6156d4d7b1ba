// How a stage becomes launches. Each stage has a function launch_<stage> (host/device/launches/) that enqueues its
// kernels.
#pragma once

#include <initializer_list>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "host/stages.hpp"

namespace lockstep {

/// The settings of a step that count something (kernels/step_settings.def).
struct StepCounts {
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) u32 name = 0;
#include "kernels/step_settings.def"
  bool operator==(const StepCounts&) const = default;
};

template <class real>
StepCounts counts_of(const StepParams<real>& params) {
  StepCounts counts;
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) counts.name = params.name;
#include "kernels/step_settings.def"
  return counts;
}

/// Sizes the launches of a step, from the counts of the step before. It can change speed only, never a bit: kernels
/// loop over what is there (FOR_EACH), whatever the grid.
struct LaunchPlan {
  Sizes sizes;
  Features features = 0;
  u32 pairs = 0, contacts = 0, blocks = 0;  // expected
  u32 colors = 0;                           // expected colours that are worth a launch each
  std::vector<u32> joint_phases;            // the first block of each phase of the joints, and the end
  u32 swept_joint_phases = 0;               // of them: those that sweeps solve, the first ones
  StepCounts counts;                        // of sweeps
  u32 real_words = 1;                       // u32 words of a real: 1 in float, 2 in double
  u32 lanes = 1;                            // contacts per work-item in the solve kernels: 1, 8 or 16
  bool small = false;                       // the whole contact solve fits one work-group
  bool one_team = false;                    // all sub-steps are one launch (kernels/team.h)
};

/// A value for a kernel parameter that is not a buffer: `{"color", 3u}`, or an alias: `{"values", "pair_starts"}` binds
/// the parameter `values` to that buffer or scratch array.
struct Argument {
  std::string_view parameter;
  std::variant<u32, std::string_view> value;
  bool operator==(const Argument&) const = default;
};

/// Arrays of u32 words for a sort: what is to be sorted, and as much room besides.
struct SortArrays {
  std::string_view keys, values, spare_keys, spare_values;
};

/// Kernel parameters are bound by their names: a buffer of the table, a scratch array made with scratch(), `params`, or
/// one of `arguments`. Everything is enqueued in order; nothing waits for the host.
class Launcher {
 public:
  virtual ~Launcher() = default;
  virtual const LaunchPlan& plan() const = 0;
  /// One work-item an item, in work-groups of the device's usual size.
  virtual void run(std::string_view kernel, u32 items, std::initializer_list<Argument> arguments = {}) = 0;
  /// One work-group, for what must be fused with barriers.
  virtual void run_group(std::string_view kernel, std::initializer_list<Argument> arguments = {}) = 0;
  /// So many work-groups of that kind, each of which has a part of the work for itself.
  virtual void run_groups(std::string_view kernel, u32 groups, std::initializer_list<Argument> arguments = {}) = 0;
  /// A chunk of some list for each work-item of a CPU device, and for each work-group of another.
  void run_chunks(std::string_view kernel, u32 chunks, std::initializer_list<Argument> arguments = {});
  /// Makes sure that a scratch array of u32 words exists and is at least that long; it is no part of the state and not
  /// compared.
  virtual void scratch(std::string_view name, std::size_t words) = 0;
  /// Replaces the `count` first words of a u32 array by their exclusive prefix sums (kernels/scan.cl).
  void scan(std::string_view array, u32 count);
  /// The same where only the device knows the number of words: counters[counter] + 1, at most `count` and probably
  /// about `expected`.
  void scan(std::string_view array, u32 count, u32 counter, u32 expected);
  /// Sorts `count` keys of at most `bits` bits with their values; what is equal stays in order (kernels/radix_sort.cl).
  /// Returns the arrays in the roles that they have then: after an odd number of passes the spare ones hold the result.
  SortArrays sort(SortArrays arrays, u32 count, u32 bits);
  /// Passes of a sort of so many bits.
  u32 sort_passes(u32 bits) const;
};

/// Launches a stage: the function launch_<stage>.
void launch(Stage stage, Launcher& launcher);

}  // namespace lockstep
