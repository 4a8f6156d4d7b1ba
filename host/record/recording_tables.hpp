// The tables of a recording: names, rows and columns.
#pragma once

#include "host/record/hdf5.hpp"
#include "host/record/recording.hpp"

namespace lockstep {

/// The types of rows in files; they are laid out as in memory.
h5::Handle step_row_type();
h5::Handle measure_row_type();
h5::Handle contact_force_row_type();
/// Before restores_format `row` is "reserved".
h5::Handle input_row_type(u32 format = recording_format);

/// Of `measures`, all of double.
struct MeasureColumn {
  const char* name;
  double MeasureRow::*member;
};
inline constexpr MeasureColumn measure_columns[] = {{"step", &MeasureRow::step},
                                                    {"energy_j", &MeasureRow::energy_j},
                                                    {"kinetic_j", &MeasureRow::kinetic_j},
                                                    {"max_penetration_m", &MeasureRow::max_penetration_m},
                                                    {"mean_penetration_m", &MeasureRow::mean_penetration_m},
                                                    {"residual", &MeasureRow::residual},
                                                    {"defect_velocity_max", &MeasureRow::defect_velocity_max},
                                                    {"joint_drift_m", &MeasureRow::joint_drift_m},
                                                    {"joint_angle_rad", &MeasureRow::joint_angle_rad}};

/// Columns of `joint_forces`, rows (steps) x joints x columns, of double.
inline constexpr hsize_t joint_force_columns = sizeof(JointForceRow) / sizeof(double);

/// Columns of the tables of bodies, rows (steps) x bodies x columns.
struct BodyTable {
  const char* name;
  hsize_t columns;
};
inline constexpr BodyTable body_tables[] = {
    {"positions", 3}, {"orientations", 4}, {"velocities", 3}, {"angular_velocities", 3}};

}  // namespace lockstep
