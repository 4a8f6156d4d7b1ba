#include "host/scene/compile_oracle.hpp"

#include <algorithm>

#include "host/error.hpp"
#include "host/scene/compile_particles.hpp"
#include "host/scene/friction_pairs.hpp"

namespace lockstep {

void expect_oracle_takes(std::span<const Scene> worlds, bool doubles) {
  const Scene& scene = worlds[0];
  const Settings& settings = scene.settings;
  if (!is_oracle(settings.solver)) return;
  const auto expect = [&](bool good, const char* setting, const char* what) {
    if (!good)
      throw Error(Failure::input, scene.source + ": /settings/" + setting,
                  std::string(name_of(settings.solver)) + " is an oracle, " + what);
  };
  expect(worlds.size() == 1, "solver", "which solves one world; leave --worlds out");
  expect(doubles, "precision", "which works in double only; leave precision out");
  expect(settings.friction_model == FrictionModel::cones, "friction_model",
         "for which friction is at each contact; leave friction_model out");
  expect(settings.joint_solver != JointSolver::direct, "joint_solver",
         "which solves joints too; leave joint_solver out");
  expect(tolerance_of(settings) > 0, "tolerance", "which needs a residual > 0 to end at");
  expect(!settings.sleeping, "sleeping", "and solves for everybody; take sleeping away (--sleeping off)");
  expect(!is_penalty(scene), "solver",
         "and springs between particles leave it nothing to solve; take one of the solvers that sweep");
  expect(std::ranges::none_of(friction_pairs_of(scene), &PairFriction::has_further_friction), "solver",
         "whose cones know no torsional, rolling or anisotropic friction, which materials of this scene have; take "
         "one of the solvers that sweep");
}

}  // namespace lockstep
