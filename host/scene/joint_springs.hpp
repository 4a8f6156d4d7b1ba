// The spring of a coordinate as a sub-step takes it: at its end, or in its middle where the integrator is of second
// order and energy is to stay (cpu_reference/prepare_joints.hpp).
#pragma once

#include "host/scene/rounding.hpp"
#include "host/scene/step_params.hpp"

namespace lockstep {

template <class real>
struct Spring {
  real rate, compliance, rest;
};

template <class real>
Spring<real> make_spring(const Settings& settings, const JointSpring& in, const Origin& origin) {
  const double h = settings.dt / substeps_of(settings);
  const double theta = settings.integrator == Integrator::trapezoidal ? 0.5 : 1;
  const double stiff = theta * h * in.stiffness + in.damping;
  rounded_positive<real>(h * stiff, "dt (dt stiffness + damping) of a spring", origin);
  if (!(in.forces[0] < in.forces[1]))
    throw Error(Failure::input, "a spring", "the least of its forces must be below the most");
  return {rounded<real>(in.stiffness / stiff, "the stiffness of a spring", origin), static_cast<real>(1 / (h * stiff)),
          rounded<real>(in.rest, "the rest of a spring", origin)};
}

}  // namespace lockstep
