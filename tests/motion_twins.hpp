// Bodies of every sort under every scheme, for the KernelMatchesReference half of the tests of the motion stages.
#pragma once

#include "tests/bodies.hpp"
#include "tests/stage_harness.hpp"

namespace lockstep {

/// Motion stages have no lanes: these say only whether a work-item takes neighbours.
inline std::vector<DeviceOptions> motion_launches() { return launch_options({{0, 0}, {1, 7}}); }

/// Runs the stage, on the device and in the reference, on mixed_bodies() in full flight: every way to take the
/// gyroscopic moment, with and without pivots, some bodies gone bad.
template <class real>
void expect_motion_twins_agree(Stage stage, const std::vector<Integrator>& integrators) {
  for (const auto& [pivots, loads] : {std::pair(false, false), std::pair(true, false), std::pair(true, true)}) {
    for (const Gyroscopic gyroscopic :
         {Gyroscopic::none, Gyroscopic::explicit_, Gyroscopic::implicit, Gyroscopic::midpoint}) {
      for (const Integrator integrator : integrators) {
        SCOPED_TRACE("pivots " + std::to_string(pivots) + ", loads " + std::to_string(loads) + ", gyroscopic " +
                     std::to_string(static_cast<int>(gyroscopic)) + ", integrator " +
                     std::to_string(static_cast<int>(integrator)));
        std::vector<BodySetup> bodies = mixed_bodies(pivots, 100);
        for (std::size_t i = 0; loads && i < bodies.size(); i += 3)
          bodies[i].force = {0.3 * double(i), -2, 5}, bodies[i].torque = {1, 0.1 * double(i), -3};
        InitialState<real> state = make_bodies<real>(bodies, {.dt = 0.05,
                                                              .integrator = integrator,
                                                              .gyroscopic = gyroscopic,
                                                              .gravities = {{0, 0.1, -9.81}, {1, 0, -3}}});
        // whole steps first, so that every buffer that a stage reads holds something
        state.buffers = run_steps(state, 3);
        state.buffers.motions[6].v[0] = real(2e5);
        state.buffers.motions[11].v[2] = real(3e5);
        run_one_stage(stage, state.buffers, state.sizes, state.features, state.params, motion_launches());
      }
    }
  }
}

}  // namespace lockstep
