// How many unknowns each model of the survey has for a scene (its tables in 3.6 and 3.7; joints with one degree of
// freedom and dry friction in it, orientations as quaternions).
#pragma once

#include <cstddef>

namespace lockstep::oracle::models {

struct SceneSize {
  std::size_t bodies = 0;           // that move
  std::size_t touching_bodies = 0;  // of these, with a unilateral contact
  std::size_t joints = 0;
  std::size_t contacts = 0;
  std::size_t directions = 4;  // n_d
};

struct ModelSizes {
  std::size_t dncp = 0, mncp = 0, mlcp = 0, lcp = 0;  // 3.6
  std::size_t dca_mlcp1 = 0, dca_mlcp2 = 0,
              dca_lcp = 0;  // 3.7, reduced coordinates; the survey's are without joint friction
};

/// The 3.7 models count 3 unknowns a joint with dry friction, as the survey's text says below its table.
constexpr ModelSizes model_sizes(const SceneSize& s) {
  const std::size_t pyramids = (2 + s.directions) * s.contacts, dry = 3 * s.joints;
  ModelSizes m;
  m.dncp = m.mncp = 7 * s.joints + 4 * s.contacts + 13 * s.bodies;
  m.mlcp = 8 * s.joints + pyramids + 6 * s.bodies;
  m.lcp = dry + pyramids;
  m.dca_mlcp1 = dry + pyramids + 12 + 6 * s.touching_bodies;
  m.dca_mlcp2 = dry + pyramids + 12;
  m.dca_lcp = dry + pyramids;
  return m;
}

}  // namespace lockstep::oracle::models
