// All sub-steps of a step as one launch: a kernel that calls the kernels of their stages one after another, by one team
// (kernels/team.h) with a barrier behind each. It is written from the launches of the stages themselves, so that it
// holds whatever they hold; kernels loop over what is there, whatever the grid, so that it cannot change a bit. For
// scenes so small that launches cost more than work-groups share out.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "host/device/kernel_source.hpp"
#include "host/device/launcher.hpp"

namespace lockstep {

struct FusedSubsteps {
  struct Scratch {
    std::string name;
    std::size_t words;
  };

  std::vector<Stage> stages;  // that it stands for, in the order of a sub-step
  KernelSignature signature;
  std::vector<std::string> files;  // whose kernels it calls
  std::string text;                // of the kernel; follows that of the files
  std::vector<u32> values;         // the numbers that launches give their kernels; a scratch array, `fused_values`
  std::vector<Scratch> scratch;    // the arrays that the launches ask for, and that of the values

  bool replaces(Stage stage) const;
};

/// `plan.features` say which stages run; the text depends on the plan only where the launches do.
FusedSubsteps fuse_substeps(std::span<const KernelSignature> kernels, const LaunchPlan& plan);

}  // namespace lockstep
