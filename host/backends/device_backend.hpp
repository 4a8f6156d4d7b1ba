// Runs the pipeline on an OpenCL device.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "host/backends/backend.hpp"
#include "host/backends/substep_plan.hpp"
#include "host/device/build_clock.hpp"
#include "host/device/devices.hpp"
#include "host/device/kernel_source.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

/// How to run; nothing here can change a bit. Zeros: chosen for the device.
struct DeviceOptions {
  u32 lanes = 0;                   // contacts per work-item in the solve kernels: 1, 8 or 16
  u32 work_group = 0;              // work-items per work-group
  u32 threads = 0;                 // compute units of a CPU device; unset, a small scene takes the thread that calls
  bool profile = false;            // measure stage_seconds(); sub-steps are launches unless `substeps` says otherwise
  BuildClock::Tell tell_building;  // told where building kernels takes longer than `patience`; unset: nobody
  double patience = 1;             // s
  bool waits_for_kernels = false;  // rather than begin on the reference, where nobody asks for a device
  std::optional<SubstepPlan> substeps;  // unset: by the size of the scene and the device

  // for tests
  std::vector<KernelPatch> patches;  // changes to the kernels
  std::vector<Stage> only;           // build the kernels of these stages alone
  bool optimize = true;              // false: kernels that are built sooner and run slower
};

template <class real>
class DeviceBackend final : public Backend<real> {
 public:
  /// Builds the kernels and uploads the state. Throws Error (device) with the build log, Error (input) for options that
  /// there are not.
  DeviceBackend(const InitialState<real>& state, const DeviceInfo& device, const DeviceOptions& options = {});
  /// The same of a state that nobody else needs: its buffers are let go of one by one.
  DeviceBackend(InitialState<real>&& state, const DeviceInfo& device, const DeviceOptions& options = {});
  ~DeviceBackend() override;

  /// Where sub-steps are one launch, it is made in place of the first stage of the first one: what the stages of
  /// sub-steps write is there when the last one has run.
  void run(Stage stage, const StepParams<real>& params) override;
  Counters counters() override;
  void grow(const Sizes& sizes) override;
  void enable(Feature feature) override;
  const Buffers<real>& download(std::span<const Buffer> wanted) override;
  void upload(Buffer buffer, const Buffers<real>& buffers) override;
  std::unique_ptr<SavedBuffers> save(std::span<const Buffer> wanted) override;
  void restore(SavedBuffers& saved) override;
  const Sizes& sizes() const override;
  Features features() const override;
  std::string name() const override;
  StageSeconds stage_seconds() const override;
  std::vector<std::pair<std::string, u32>> steps_by_plan() const override;

  u32 lanes() const;
  u32 threads() const;  // as open_device() takes them

  /// Fills a buffer with a byte, to see that a stage writes all of it.
  void poison(Buffer buffer, unsigned char byte);

 private:
  struct Impl;  // keeps OpenCL out of this header
  std::unique_ptr<Impl> impl_;
};

}  // namespace lockstep
