// A run need not wait for kernels: the reference has the same bits.
#pragma once

#include <future>
#include <memory>
#include <set>

#include "host/backends/device_backend.hpp"
#include "host/backends/reference_backend.hpp"

namespace lockstep {

/// Whether this device has built, here or in an earlier process, all that a step of such a scene runs.
template <class real>
bool has_built(const InitialState<real>& state, const DeviceInfo& device, const DeviceOptions& options);

/// Steps on the reference while another thread builds the kernels of the device and runs its canary, then moves to the
/// device between two steps. Stays on the reference where the canary finds a bit that differs, or the device fails,
/// which is told on stderr. Its destructor waits for the build.
template <class real>
class StartingBackend final : public Backend<real> {
 public:
  StartingBackend(const InitialState<real>& state, const DeviceInfo& device, const DeviceOptions& options);

  void run(Stage stage, const StepParams<real>& params) override;
  Counters counters() override { return current().counters(); }
  void grow(const Sizes& sizes) override { current().grow(sizes); }
  void enable(Feature feature) override;
  const Buffers<real>& download(std::span<const Buffer> wanted) override { return current().download(wanted); }
  void upload(Buffer buffer, const Buffers<real>& buffers) override;
  std::unique_ptr<SavedBuffers> save(std::span<const Buffer> wanted) override;
  void restore(SavedBuffers& saved) override;
  const Sizes& sizes() const override { return current().sizes(); }
  Features features() const override { return current().features(); }
  std::string name() const override { return current().name(); }
  StageSeconds stage_seconds() const override { return current().stage_seconds(); }
  std::vector<std::pair<std::string, u32>> steps_by_plan() const override;

 private:
  Backend<real>& current() const;
  void move_to_device();

  std::unique_ptr<ReferenceBackend<real>> reference_;  // until the device takes over
  std::unique_ptr<DeviceBackend<real>> device_;
  std::future<std::unique_ptr<DeviceBackend<real>>> building_;
  std::set<Buffer> uploaded_;  // to the reference
  std::set<Feature> enabled_;  // on the reference
  u32 steps_on_reference_ = 0;
  std::vector<std::pair<std::string, u32>> steps_before_;  // of the device, to build its kernels
};

}  // namespace lockstep
