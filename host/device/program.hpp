// Builds the kernels of a scene into one OpenCL program.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "host/device/device.hpp"
#include "host/device/kernel_source.hpp"

namespace lockstep {

struct ProgramOptions {
  Features features = 0;
  bool double_precision = false;
  u32 lanes = 1;
  bool optimize = true;
  bool team_is_grid = false;  // kernels/team.h
};

/// The -D and -cl options of a build of `text` on this device; $LOCKSTEP_CL_OPTIONS is appended (oclgrind needs
/// -cl-opt-disable). Only what the text names is defined, so that scenes share the programs in which they do not
/// differ.
std::string build_options(const DeviceInfo& device, const ProgramOptions& options, std::string_view text);

/// By what kernels differ from scene to scene: by the first of these that `text` names a feature of. Kernels that
/// differ alike make one program, so that a scene takes from the driver's cache what others before it have built; a
/// program for each file would share more, but a driver takes its time to find each.
enum class Differ { by_shapes, by_contacts, by_bodies, in_nothing };
Differ differ(std::string_view text);

/// What every program starts with: contraction off, and double where it is asked for.
std::string program_preamble(const ProgramOptions& options);

/// Builds the text on the device, or takes the program that this process or an earlier one has built from the same text
/// (ProgramCache::of_user()). Throws Error (device) with the whole build log, and for double precision on a device that
/// has none.
BuiltProgram& build_program(Device& device, const std::string& text, const ProgramOptions& options);

/// Puts the program on disk, unless it came from there or the driver keeps what it builds itself, as pocl does. After
/// kernels have run, so that what a driver built only then is among it.
void save_program(const Device& device, BuiltProgram& built);

}  // namespace lockstep
