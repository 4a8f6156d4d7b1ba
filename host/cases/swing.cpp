#include "host/cases/swing.hpp"

#include <algorithm>

namespace lockstep {

Swung swing(const Scene& scene, double duration, Trial& trial) {
  double range = 0, first = 0;  // J
  for (const BodyDescription& body : scene.bodies)
    range += body.mass * exact::length(scene.gravity) * exact::length(body.position);
  Swung swung;
  trial.run(scene, duration, [&](Seen& sample) {
    const Measures& measures = sample.measures();
    if (sample.time == 0) first = measures.energy();
    const double change = (measures.energy() - first) / range;
    swung.gained = std::max(swung.gained, change);
    swung.lost = std::max(swung.lost, -change);
    if (!measures.joint_drift) return true;
    swung.separation = std::max(swung.separation, measures.joint_drift->separation);
    swung.angle = std::max(swung.angle, measures.joint_drift->angle);
    return true;
  });
  return swung;
}

}  // namespace lockstep
