// The tables of a recording: names, rows and columns.
#pragma once

#include "host/record/hdf5.hpp"
#include "host/record/recording.hpp"

namespace lockstep {

/// The types of rows in files; they are laid out as in memory.
h5::Handle step_row_type();
h5::Handle measure_row_type();
h5::Handle input_row_type();

/// Columns of the tables of bodies, rows (steps) x bodies x columns.
struct BodyTable {
  const char* name;
  hsize_t columns;
};
inline constexpr BodyTable body_tables[] = {
    {"positions", 3}, {"orientations", 4}, {"velocities", 3}, {"angular_velocities", 3}};

}  // namespace lockstep
