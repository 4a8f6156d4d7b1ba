// Many worlds of one scene, shared out over ranks: which each rank has, and one report of all.
#pragma once

#include <vector>

#include "host/app/options.hpp"
#include "host/app/ranks.hpp"
#include "host/report/report.hpp"

namespace lockstep::app {

/// The worlds that a rank has: so many from the first on. Rank 0 has the most, and at least one.
struct Share {
  u32 first = 0, count = 1;
};
Share share_of(u32 worlds, const Ranks& ranks);

/// The scenes of a share: world k is the scene that `--seed` of the options plus k gives. Throws Error (input) for more
/// bodies than a batch can have.
std::vector<Scene> read_worlds(const SceneOptions& options, const Share& share);

/// Gives each rank of a machine a GPU of its own where there are several, or its part of the threads of a CPU device.
void spread_devices(const Ranks& ranks, TargetOptions& options);

/// The report of all worlds on rank 0: counts and energies are summed, of times and errors those of the worst rank
/// stand; hashes are combined in the order of the worlds. On other ranks, their own.
Report merged(const Ranks& ranks, const Report& mine, const std::vector<WorldHash>& hashes);

}  // namespace lockstep::app
