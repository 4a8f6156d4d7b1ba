// What a recording holds (docs/how_to/record_and_verify.md): who made it and how, the compiled scene and the state that
// the run began with, and a row of each table below for each step.
#pragma once

#include <compare>
#include <cstdint>
#include <string>

#include "kernels/types.h"

namespace lockstep {

// Formats up to 7 know no cold starts but the first, those up to 5 no gravity that changes, 3 and 4 no restores, and
// format 3 no oracles; all are read all the same.
inline constexpr u32 recording_format = 8, oldest_recording_format = 3, restores_format = 5;

/// What a recording says of itself.
struct RecordingLabel {
  std::string scene, device;
  std::string options;      // as the command line gave them
  std::string scene_text;   // of the scene file; empty of a world that was made in code
  std::string source = {};  // the path of that file, from which meshes are looked for
  double dt = 0;            // of a step, s; 0 where the recording does not say, which holds it in the run's precision
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

/// A row of `contact_forces`: what a contact does to body a. World frame, SI units.
struct ContactForceRow {
  u32 body_a = 0, body_b = 0, shape_a = 0, shape_b = 0;  // as in compiled_scene
  double gap = 0;                                        // m, < 0 of overlap
  double point[3] = {0, 0, 0}, normal[3] = {0, 0, 0};    // from b to a
  double force[3] = {0, 0, 0};  // N, friction with it: the mean of the time of the setting `forces`
};

/// What `joint_forces` has of a joint: what it does to its second body, world frame.
struct JointForceRow {
  double force[3] = {0, 0, 0}, torque[3] = {0, 0, 0};  // of what it locks, at and about that one's anchor, N and N m
  double drive = 0;                                    // of motor, friction, limits or spring, N or N m
};

/// What a recording has beside the motion.
struct Recorded {
  bool inputs = false;  // what is done to bodies from outside
  bool forces = false;  // of contacts and joints
};

enum class InputKind : u32 { velocity = 0, load = 1, motor = 2, restore = 3, gravity = 4, rest = 5, cold_start = 6 };

/// A row of `inputs`: what was done to a body, a joint or the whole state from outside before a step. A velocity
/// replaces that of the body; a load acts from this step on, until another one does; a joint's motor is this one until
/// it is another, and so are gravity, m/s^2, and where the spring of a joint rests, m or rad. A restore puts back the
/// state that there was before row `body` of `steps`, when as many inputs as linear[0] says had been done. A cold start
/// gives the step the sweeps of a first one: what acts or a mass has changed, and the impulses it starts from balance
/// something else.
struct InputRow {
  u32 step = 0;  // the number of the step that is the first to feel it, as in StepRow
  u32 body = 0;  // of a motor and a rest, the joint; of a restore, a row of `steps`; of gravity, the world
  InputKind kind = InputKind::velocity;
  u32 row = 0;  // the row of `steps` that is the first to feel it: steps are told again after a restore
  // As the run holds them: m/s and rad/s, or N and N m, world frame; of a motor its speed and force (Joint) in linear,
  // as gravity is, and the rest of a spring the first of these.
  double linear[3] = {0, 0, 0}, angular[3] = {0, 0, 0};
};

/// A moment of a recording: so many steps and inputs were there.
struct RecordingPosition {
  u32 rows = 0, inputs = 0;
  auto operator<=>(const RecordingPosition&) const = default;
};

/// Where a restore goes back to.
inline RecordingPosition restored_position(const InputRow& restore) {
  return {restore.body, static_cast<u32>(restore.linear[0])};
}

}  // namespace lockstep
