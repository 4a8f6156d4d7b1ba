// How deep the spheres and boxes of a scene overlap, how far they have come and how far joints have parted, from poses
// alone: the same measure for every engine.
#pragma once

#include <vector>

#include "host/scene/scene.hpp"

namespace lockstep::bench {

/// Of a centre of mass, m, and its body.
struct BodyPose {
  Vector3 position;
  Quaternion orientation;
};

struct Overlap {
  u32 pairs = 0;                 // that overlap at all
  double deepest = 0, mean = 0;  // m; the mean over those pairs
};

/// Bodies of one sphere or one box, centred in their bodies, against each other and against planes of bodies that have
/// not moved; shapes that collide with nothing do not count. Boxes by the separating axis theorem (Gottschalk, Lin,
/// Manocha 1996).
Overlap measure_overlap(const Scene& scene, const std::vector<BodyPose>& poses);

/// Of the dynamic body that has come farthest from where the scene puts it, m.
double farthest_moved(const Scene& scene, const std::vector<BodyPose>& poses);

/// Largest distance of the two anchors of a ball joint, m.
double joint_separation(const Scene& scene, const std::vector<BodyPose>& poses);

}  // namespace lockstep::bench
