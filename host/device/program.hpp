// Builds the kernels of a scene into one OpenCL program.
#pragma once

#include <string>
#include <vector>

#include "host/device/device.hpp"
#include "host/device/kernel_source.hpp"

namespace lockstep {

struct ProgramOptions {
  Features features = 0;
  bool double_precision = false;
  u32 lanes = 1;
};

/// The -D and -cl options of a build on this device; $LOCKSTEP_CL_OPTIONS is appended (oclgrind needs -cl-opt-disable).
std::string build_options(const DeviceInfo& device, const ProgramOptions& options);

/// What every program starts with: contraction off, and double where it is asked for.
std::string program_preamble(const ProgramOptions& options);

/// Builds the text on the device, or takes the program that this process or an earlier one has built from the same text
/// (ProgramCache::of_user()). Throws Error (device) with the whole build log, and for double precision on a device that
/// has none.
BuiltProgram& build_program(Device& device, const std::string& text, const ProgramOptions& options);

/// Puts the program on disk, unless it came from there. After kernels have run: pocl adds the code that it specialised
/// for their work-group sizes. (pocl also takes some seconds to add code for all other sizes: not before a step.)
void save_program(const Device& device, BuiltProgram& built);

}  // namespace lockstep
