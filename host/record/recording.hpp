// What a recording holds (docs/recordings.md): who made it and how, the compiled scene and the state that the run began
// with, and a row of each table below for each step.
#pragma once

#include <cstdint>
#include <string>

#include "kernels/types.h"

namespace lockstep {

// Format 3 knows no oracles, and is read all the same.
inline constexpr u32 recording_format = 4, oldest_recording_format = 3;

/// What a recording says of itself.
struct RecordingLabel {
  std::string scene, device;
  std::string options;      // as the command line gave them
  std::string scene_text;   // of the scene file; empty of a world that was made in code
  std::string source = {};  // the path of that file, from which meshes are looked for
};

/// A row of `steps`.
struct StepRow {
  u32 step = 0;  // the number of the step, from 1: steps that the state after it has behind it
  u32 pairs = 0, contacts = 0;
  u32 redone = 0;  // steps that had to be redone up to here
  double milliseconds = 0;
};

/// A row of `measures`, for the steps that the report measures. NaN: does not apply.
struct MeasureRow {
  double step = 0;  // as in StepRow
  double energy_j = 0, kinetic_j = 0;
  double max_penetration_m = 0, mean_penetration_m = 0;
  double residual = 0, defect_velocity_max = 0;
  double joint_drift_m = 0, joint_angle_rad = 0;
};

/// Whether a recording has a table of what is done to bodies from outside.
enum class Inputs { none, recorded };

enum class InputKind : u32 { velocity = 0, load = 1, motor = 2 };

/// A row of `inputs`: what was done to a body or a joint from outside before a step. A velocity replaces that of the
/// body; a load acts from this step on, until another one does; a joint's motor is this one until it is another.
struct InputRow {
  u32 step = 0;  // the number of the step that is the first to feel it, as in StepRow
  u32 body = 0;  // of a motor, the joint
  InputKind kind = InputKind::velocity;
  u32 reserved = 0;  // 0
  // As the run holds them: m/s and rad/s, or N and N m, world frame; of a motor its speed and force (Joint) in linear.
  double linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
};

}  // namespace lockstep
