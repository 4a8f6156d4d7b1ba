// Runs every stage on the device and in the reference, and compares every word that the stage wrote.
#pragma once

#include <memory>
#include <set>

#include "host/backends/device_backend.hpp"
#include "host/backends/reference_backend.hpp"
#include "host/error.hpp"

namespace lockstep {

/// The first word that differs.
struct Difference {
  u32 step = 0;                // steps done before this one
  Stage stage = Stage::count;  // count: seen at the end of a step whose sub-steps were one launch
  Buffer buffer = Buffer::count;
  std::size_t element = 0;
  u32 word = 0;  // within the element, in words of `real` (or of u32, where the buffer holds integers)
  std::string device_value, reference_value;  // as hex and as a number
};

/// A comparison failed: "step 3, integrate_velocities: motions[17] word 2: device 0x3f800000 (1), reference ...".
class Mismatch : public Error {
 public:
  explicit Mismatch(Difference difference);
  const Difference& difference() const { return difference_; }

 private:
  Difference difference_;
};

struct CheckOptions {
  /// Where the device would run all sub-steps as one launch: runs them so too, on buffers of their own, and compares
  /// what is there at the end of each step.
  bool fused = false;

  /// Before a stage that is the first to write a transient buffer, fills the buffer with other bytes on the device than
  /// in the reference, so that a word that the stage leaves out differs.
  bool poison = false;
};

template <class real>
class CheckedBackend final : public Backend<real> {
 public:
  CheckedBackend(InitialState<real> state, const DeviceInfo& device, const DeviceOptions& options = {},
                 CheckOptions check = {});

  /// Throws Mismatch at the first word that differs. Two NaNs are equal.
  void run(Stage stage, const StepParams<real>& params) override;

  Counters counters() override;
  void grow(const Sizes& sizes) override;
  void enable(Feature feature) override;
  const Buffers<real>& download(std::span<const Buffer> wanted) override { return device_.download(wanted); }
  void upload(Buffer buffer, const Buffers<real>& buffers) override;
  const Sizes& sizes() const override { return device_.sizes(); }
  Features features() const override { return device_.features(); }
  std::string name() const override { return device_.name() + " against the reference"; }
  StageSeconds stage_seconds() const override { return device_.stage_seconds(); }

  /// Words found equal so far.
  std::size_t words_compared() const { return words_compared_; }

  const Buffers<real>& reference_buffers() { return reference_.buffers(); }
  /// What the device has that differed.
  const Buffers<real>& device_buffers(const Difference& difference, std::span<const Buffer> wanted) {
    return difference.stage == Stage::count ? fused_->download(wanted) : device_.download(wanted);
  }

 private:
  void poison_outputs(Stage stage, const StepParams<real>& params);
  void run_fused(Stage stage, const StepParams<real>& params, std::span<const Buffer> written);
  void compare(DeviceBackend<real>& backend, Stage stage, std::span<const Buffer> written);

  DeviceBackend<real> device_;                  // stage by stage
  std::unique_ptr<DeviceBackend<real>> fused_;  // null where it is not asked for
  std::set<Buffer> written_in_step_;
  ReferenceBackend<real> reference_;
  CheckOptions check_;
  std::size_t words_compared_ = 0;
};

}  // namespace lockstep
