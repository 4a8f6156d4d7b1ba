// A Lockstep scene in Bullet, to be timed beside it. Bullet's own defaults, no sleeping, one thread.
#pragma once

#include <memory>
#include <vector>

#include "bench/overlap.hpp"
#include "host/scene/scene.hpp"

namespace lockstep::bench {

class BulletWorld {
 public:
  /// Spheres and boxes centred in their bodies, planes and ball joints; throws Error (input) for any other scene.
  explicit BulletWorld(const Scene& scene);
  ~BulletWorld();

  /// One step of the scene's dt, undivided and with Bullet's own number of iterations, 10.
  void step();

  /// In scene order.
  std::vector<BodyPose> poses() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace lockstep::bench
