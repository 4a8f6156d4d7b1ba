#include "host/scene/compile_sleeping.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "host/error.hpp"
#include "host/scene/exact_math.hpp"
#include "host/scene/rounding.hpp"
#include "host/scene/shape_tolerances.hpp"

namespace lockstep {

u32 sleep_steps(double after, double dt) {
  const double steps = after / dt, whole = std::floor(steps);
  // what is a whole number but for the rounding of both is meant to be one
  const double wanted = steps - whole <= 1e-9 * whole ? whole : whole + 1;
  return wanted < 2 ? 2u : wanted < double(NONE) ? static_cast<u32>(wanted) : NONE;
}

namespace {

// The radius of a body about its centre of mass, of its shapes or of gyration; the speed up to which it is still
// follows it, unless it is given.
template <class real>
void follow_bodies(Buffers<real>& buffers, bool has_speed) {
  std::vector<double> radii(buffers.body_infos.size(), 0);
  for (std::size_t i = 0; i < buffers.shapes.size(); ++i) {
    const Shape<real>& shape = buffers.shapes[i];
    const Vector3 offset = {double(shape.offset[0]), double(shape.offset[1]), double(shape.offset[2])};
    double& radius = radii[buffers.shape_infos[i].body];
    radius = std::max(radius, exact::length(offset) + double(shape.bounding_radius));
  }
  for (std::size_t i = 0; i < radii.size(); ++i) {
    const Mass<real>& mass = buffers.masses[i];
    const double inertia = double(std::max({mass.inertia[0], mass.inertia[1], mass.inertia[2]}));
    if (mass.mass > 0) radii[i] = std::max(radii[i], exact::square_root(inertia / double(mass.mass)));
    buffers.sleep_laws[i].radius = static_cast<real>(radii[i]);
    if (!has_speed) buffers.sleep_laws[i].speed = static_cast<real>(sleep_speed_share * radii[i]);
  }
}

}  // namespace

template <class real>
void compile_sleeping(const Scene& scene, InitialState<real>& state) {
  const Settings& settings = scene.settings;
  const std::string location = scene.source + ": /settings/sleeping";
  if (has(state.features, Feature::gradient))
    throw Error(
        Failure::input, location,
        "solvers along a gradient step all islands by one length, and an island that sleeps would change the others; "
        "take gauss_seidel, jacobi or small_steps");
  if (has(state.features, Feature::partitions))
    throw Error(Failure::input, location,
                "cell_gauss_seidel schedules all pairs of a cell together, and an island that sleeps would change the "
                "others; take gauss_seidel, jacobi or small_steps");
  if (settings.integrator == Integrator::runge_kutta)
    throw Error(Failure::input, location, "bodies of runge_kutta never rest; use another integrator or leave it out");
  if (has(state.features, Feature::particles))
    throw Error(Failure::input, location,
                "does not go with particles of the model penalty; use constraints or leave it out");
  if (has(state.features, Feature::tolerance))
    throw Error(Failure::input, location,
                "does not go with a tolerance, which ends the sweeps of all islands at once, so "
                "that one would change the bits of another; leave out one of the two");
  state.features = with(state.features, Feature::sleeping);
  const Origin origin = {scene};
  const SleepSettings& law = *settings.sleeping;
  const SleepLaw<real> given = {rounded<real>(law.speed.value_or(0), "sleeping/speed", origin),
                                rounded<real>(law.angular_speed, "sleeping/angular_speed", origin), 0, 0};
  state.buffers.sleep_laws.assign(state.buffers.body_infos.size(), given);
  follow_bodies(state.buffers, law.speed.has_value());
  state.buffers.sleep_steps.assign(state.sizes.worlds, sleep_steps(law.after, settings.dt));
  state.buffers.sleepers.assign(state.buffers.body_infos.size(), {0, NONE});
  state.buffers.still_starts.assign(state.buffers.body_infos.size(), {});
}

template void compile_sleeping<float>(const Scene&, InitialState<float>&);
template void compile_sleeping<double>(const Scene&, InitialState<double>&);

}  // namespace lockstep
