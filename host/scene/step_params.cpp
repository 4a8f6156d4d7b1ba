#include "host/scene/step_params.hpp"

#include <limits>

#include "host/scene/rounding.hpp"
#include "host/scene/shape_tolerances.hpp"
#include "host/scene/spring.hpp"

namespace lockstep {

namespace {

// How a sub-step takes overlap back.
Correction correction_of(const Settings& settings) {
  if (settings.solver != Solver::small_steps) return {settings.correction, 0};
  const double frequency = settings.contact_frequency.value_or(std::numeric_limits<double>::max());
  return spring_correction(settings.dt / substeps_of(settings), frequency, settings.contact_damping);
}

// Of settings that are resolved.
double number_of(const BySolver<double>& setting) { return *setting; }
u32 count_of(const BySolver<u32>& setting) { return *setting; }

}  // namespace

template <class real>
void set_sizes(StepParams<real>& p, const Sizes& sizes) {
  p.bodies = sizes.bodies;
  p.shapes = sizes.shapes;
  p.tree_shapes = sizes.tree_shapes;
  p.worlds = sizes.worlds;
  p.buckets = sizes.buckets;
  p.pair_capacity = sizes.pairs;
  p.contact_capacity = sizes.contacts;
  p.block_capacity = sizes.blocks;
  p.row_capacity = sizes.rows;
  p.joint_blocks = sizes.joint_blocks;
}

template void set_sizes<float>(StepParams<float>&, const Sizes&);
template void set_sizes<double>(StepParams<double>&, const Sizes&);

template <class real>
StepParams<real> make_params(const Scene& scene, const Sizes& sizes, Features features) {
  const Settings settings = resolved(scene.settings);
  const Origin origin = {scene};
  StepParams<real> p = {};
  p.dt = rounded_positive<real>(settings.dt / substeps_of(settings), "dt / substeps", origin);
  switch (settings.integrator) {
    case Integrator::explicit_euler: p.theta = 0; break;
    case Integrator::trapezoidal: p.theta = real(0.5); break;
    case Integrator::semi_implicit_euler:
    case Integrator::runge_kutta: p.theta = 1; break;
  }
  switch (settings.gyroscopic) {
    case Gyroscopic::none:
    case Gyroscopic::explicit_: p.gyroscopic_theta = 0; break;
    case Gyroscopic::midpoint: p.gyroscopic_theta = real(0.5); break;
    case Gyroscopic::implicit: p.gyroscopic_theta = 1; break;
  }
  p.gyroscopic = has(features, Feature::gyroscopic);
  const Correction correction = correction_of(settings);
  const bool separated = has(features, Feature::separated_contacts);
  const real share = rounded<real>(correction.share, "correction", origin);
  p.correction = separated ? real(0) : share;
  p.separation = separated ? share : real(0);
  p.softness = rounded<real>(correction.softness, "contact_frequency, contact_damping: the softness", origin);
  real* const given[] = {&p.slop, &p.margin, &p.correction_limit};
  real* const shares[] = {&p.slop_share, &p.margin_share, &p.correction_limit_share};
  for (std::size_t i = 0; const ShapeTolerance& tolerance : shape_tolerances(settings, features)) {
    *given[i] = rounded<real>(tolerance.given.value_or(0), tolerance.name, origin);
    *shares[i++] = tolerance.given ? real(0) : real(tolerance.share);
  }
#define STEP_NUMBER(type, name, initial, bounds, unit, group, meaning) \
  p.name = rounded<real>(number_of(settings.name), #name, origin);
#define STEP_COUNT(type, name, initial, bounds, unit, group, meaning) p.name = count_of(settings.name);
#include "kernels/step_settings.def"
  if (*settings.tolerance > 0) p.tolerance = rounded_positive<real>(*settings.tolerance, "tolerance", origin);
  if (!has(features, Feature::closed_joints) && !separated) p.position_sweeps = 0;
  set_sizes(p, sizes);
  return p;
}

template StepParams<float> make_params<float>(const Scene&, const Sizes&, Features);
template StepParams<double> make_params<double>(const Scene&, const Sizes&, Features);

}  // namespace lockstep
