// A contact as it is reported after a step.
#pragma once

#include "host/scene/described_shapes.hpp"

namespace lockstep {

struct ReportedContact {
  u32 world;
  DescribedShape a, b;
  Vector3 point;    // on the surface of a, m, world frame
  Vector3 normal;   // from b to a, unit
  Vector3 impulse;  // on a, N s
  double gap = 0;   // m; negative where they overlap
};

}  // namespace lockstep
