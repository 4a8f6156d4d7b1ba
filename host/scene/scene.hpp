// The scene of the library's header (include/lockstep/scene.hpp), and what follows from it. Reading and compiling are
// in read.hpp and compile.hpp.
#pragma once

#include <utility>

#include "host/scene/actuators.hpp"
#include "host/scene/exact_math.hpp"
#include "host/scene/settings.hpp"
#include "host/sensor.hpp"
#include "include/lockstep/scene.hpp"
#include "kernels/types.h"

namespace lockstep {

inline constexpr std::pair<const char*, ImpactLaw> impact_law_names[] = {{"newton", IMPACT_NEWTON},
                                                                         {"poisson", IMPACT_POISSON},
                                                                         {"stronge", IMPACT_STRONGE},
                                                                         {"chatterjee_ruina", IMPACT_CHATTERJEE_RUINA}};

/// What drives the free coordinate of a joint: towards a speed, with at most a force.
struct JointDrive {
  double speed = 0, force = 0;
};

/// Its motor; or dry friction (Coulomb's, survey 3.1), which is a motor that wants it to stand still. A spring of
/// bounded force has the middle of its bounds instead of the speed, and the half of what is between them, below 0.
inline JointDrive drive_of(const JointDescription& joint) {
  if (joint.spring && joint.spring->forces != any_force) {
    const auto [least, most] = joint.spring->forces;
    return {0.5 * (least + most), -0.5 * (most - least)};
  }
  return joint.friction > 0 ? JointDrive{0, joint.friction} : JointDrive{joint.motor_speed, joint.motor_force};
}

/// Whether what contacts and joints give is summed over the sub-steps of a step (docs/reference/forces.md): where the
/// setting `forces` says so, and unless it says otherwise where impacts or sensors are told.
inline bool wants_step_forces(const Scene& scene) {
  const Settings& settings = scene.settings;
  if (settings.forces != Forces::automatic) return settings.forces == Forces::step;
  return settings.impact_speed.has_value() || !scene.sensors.empty();
}

}  // namespace lockstep
