#include "host/record/measure_row.hpp"

#include <limits>

namespace lockstep {

MeasureRow measure_row(u32 step, const Measures& measures) {
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  MeasureRow row;
  row.step = step;
  row.energy_j = measures.energy();
  for (const WorldMeasures& world : measures.worlds) row.kinetic_j += world.kinetic;
  row.max_penetration_m = measures.penetration.max;
  row.mean_penetration_m = measures.penetration.mean;
  row.residual = measures.residual ? measures.residual->relative : none;
  row.defect_velocity_max = measures.residual ? measures.residual->defect_max : none;
  row.joint_drift_m = measures.joint_drift ? measures.joint_drift->separation : measures.pivot_drift.value_or(none);
  row.joint_angle_rad = measures.joint_drift ? measures.joint_drift->angle : none;
  return row;
}

}  // namespace lockstep
