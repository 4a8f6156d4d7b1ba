// The canary: does this device compute the reference's bits? (contract rules 1, 2 and 7)
#pragma once

#include <span>
#include <string>

#include "host/device/devices.hpp"
#include "host/device/kernel_source.hpp"

namespace lockstep {

struct CanaryVerdict {
  bool host_ok = true;         // this thread rounds to nearest and keeps denormals
  bool contraction_ok = true;  // no product and sum became one operation
  bool division_ok = true;     // correctly rounded
  bool sqrt_ok = true;
  bool denormals_ok = true;   // kept, as operands and as results
  bool algebra_ok = true;     // no formula became another that is the same of real numbers
  std::string first_failure;  // "a * b + c of operand set 17: device 0x... (..), reference 0x... (..)", or empty

  bool bit_exact() const { return host_ok && contraction_ok && division_ok && sqrt_ok && denormals_ok && algebra_ok; }
};

/// "bit-exact", or "not bit-exact: division; ...the first failure".
std::string describe(const CanaryVerdict& verdict);

/// Runs the canary for programs of this precision and lane count on every compute unit of the device, or on as many
/// `threads` of it as open_device() gives. The verdict is kept for the process; `patches` are for tests and make it run
/// anew. Throws Error (device) where the device cannot run it at all.
CanaryVerdict run_canary(const DeviceInfo& device, bool double_precision, u32 lanes, u32 threads = 0,
                         std::span<const KernelPatch> patches = {});

/// "bit-exact", or what is not, of programs of this precision over all lane counts, on all compute units.
std::string verdict_in_words(const DeviceInfo& device, bool double_precision);

}  // namespace lockstep
