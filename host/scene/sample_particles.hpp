// Bodies as particles: spheres of one radius that lie within a solid and touch its surface. In exact arithmetic
// (exact_math.hpp), so that every compiler finds the same ones in the same order. docs/theory/particles.md says how.
#pragma once

#include <map>
#include <string>

#include "host/scene/scene.hpp"

namespace lockstep {

/// That a scene can have; lists are several times as long.
inline constexpr u32 most_particles = NONE >> 8;

/// About how many a bounded shape will have: those of the box about it.
double expected_particles(const ShapeDescription& shape, const ParticleSettings& settings);

/// The centres of the particles of one bounded shape, in the frame of its body, m. Where particles of this radius do
/// not fit, none, and `refusal` says why and what to do.
std::vector<Vector3> sample_particles(const ShapeDescription& shape, const ParticleSettings& settings,
                                      std::string& refusal);

/// The particles of bodies; equal ones, such as the copies of a generator, are sampled once.
class ParticleSampler {
 public:
  explicit ParticleSampler(const ParticleSettings& settings) : settings_(settings) {}

  /// Of each shape of the body that has particles: planes have none. `refusal` as above.
  const std::vector<std::vector<Vector3>>& of(const BodyDescription& body, std::string& refusal);

 private:
  ParticleSettings settings_;
  std::map<std::vector<double>, std::vector<std::vector<Vector3>>> known_;
};

/// How particles of equal masses stand for a body: their number, how far their centre of mass is from that of the body,
/// m, and by which part of itself its inertia matrix differs from theirs (Frobenius norms), each particle taken as a
/// solid sphere.
struct ParticleFit {
  std::size_t count = 0;
  double center_error = 0, inertia_error = 0;
};
ParticleFit fit_of(const BodyDescription& body, const std::vector<std::vector<Vector3>>& particles, double radius);

}  // namespace lockstep
