// A Lockstep scene in Bullet, to be timed beside it. Bullet's own defaults, no sleeping, one thread.
#pragma once

#include <memory>
#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep::bench {

class BulletWorld {
 public:
  /// Spheres centred in their bodies and planes; throws Error (input) for any other scene.
  explicit BulletWorld(const Scene& scene);
  ~BulletWorld();

  /// One step of the scene's dt, split into the scene's sub-steps.
  void step();

  /// Centres of mass in scene order, m.
  std::vector<Vector3> positions() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace lockstep::bench
