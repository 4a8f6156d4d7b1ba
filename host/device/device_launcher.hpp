// Launches kernels with their parameters bound by name (host/device/launcher.hpp).
#pragma once

#include <map>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/device/build_clock.hpp"
#include "host/device/device_memory.hpp"
#include "host/device/kernel_source.hpp"
#include "host/device/launcher.hpp"

namespace lockstep {

class DeviceLauncher final : public Launcher {
 public:
  /// `work_group` 0: chosen for the device. `profile`: keep the events of what is launched. `builds` is told what
  /// kernels take that are launched for the first time, which is when some drivers build them.
  DeviceLauncher(Device& device, cl::CommandQueue queue, DeviceMemory& memory, BuildClock& builds, u32 work_group,
                 bool profile);

  /// Kernels of a program; those that are known by name stay as they are.
  void add(const cl::Program& program, std::span<const KernelSignature> signatures);

  /// Before the launches of a stage, or of all sub-steps (Stage::count): their parameters, and what they are a part of.
  void begin(Stage stage, std::span<const std::byte> params);

  LaunchPlan& plan() { return plan_; }
  const LaunchPlan& plan() const override { return plan_; }
  u32 fused_work_group() const { return static_cast<u32>(fused_work_group_); }
  void run(std::string_view kernel, u32 items, std::initializer_list<Argument> arguments = {}) override;
  void run_group(std::string_view kernel, std::initializer_list<Argument> arguments = {}) override;
  void run_groups(std::string_view kernel, u32 groups, std::initializer_list<Argument> arguments = {}) override;
  void scratch(std::string_view name, std::size_t words) override;

  /// The first and the last command of each stage since the last call, where `profile` was asked for.
  struct Span {
    Stage stage;
    cl::Event first, last;
  };
  std::vector<Span> take_spans() { return std::exchange(spans_, {}); }

 private:
  // What a parameter is bound to now, to leave alone what has not changed.
  struct Bound {
    std::optional<Buffer> buffer;  // of that name
    std::uint64_t array = 0;       // its number, 0 for none yet
    std::optional<u32> value;
    Stage stage = Stage::count;  // whose access was checked
  };
  // What all of them were bound for: for the same again there is nothing to look at.
  struct Binding {
    Stage stage;
    std::uint64_t memory;
    std::vector<Argument> arguments;
    std::vector<std::byte> params;
  };
  struct Kernel {
    KernelSignature signature;
    cl::Program program;
    cl::Kernel handle;
    std::size_t max_work_group = 1;
    bool is_new = true;  // has not been launched
    std::vector<Bound> bound;
    std::optional<Binding> binding;
  };

  std::string where(std::string_view kernel) const;
  Kernel& find(std::string_view name);
  void bind(Kernel& kernel, std::initializer_list<Argument> arguments);
  bool is_bound(const Kernel& kernel, std::initializer_list<Argument> arguments) const;
  void bind_parameter(Kernel& kernel, u32 index, std::initializer_list<Argument> arguments);
  void bind_value(Kernel& kernel, u32 index, const Argument* given);
  void bind_array(Kernel& kernel, u32 index, const Argument* given);
  void enqueue(Kernel& kernel, std::size_t global, std::size_t local);

  Device& device_;
  cl::CommandQueue queue_;
  DeviceMemory& memory_;
  BuildClock& builds_;
  std::size_t work_group_, fused_work_group_;
  bool profile_;
  std::map<std::string, Kernel, std::less<>> kernels_;
  LaunchPlan plan_;
  Stage stage_ = Stage::count;
  bool stage_has_begun_ = false;
  std::vector<std::byte> params_;
  std::vector<Span> spans_;
};

}  // namespace lockstep
