#include "host/device/device_launcher.hpp"

#include <algorithm>
#include <atomic>

#include "host/device/pocl_cache.hpp"

namespace lockstep {

namespace {

// pocl specialises a kernel for each local size and for large grids: one size for all, and a grid that stays small. A
// work-item of a CPU device is a turn of a loop, so that groups are cheap and as many as there is work for.
constexpr std::size_t cpu_work_group = 16, gpu_work_group = 64;
constexpr std::size_t cpu_fused_work_group = 16, gpu_fused_work_group = 256;
constexpr std::size_t largest_cpu_grid = 0x8000;
// Of a CPU device, which has the variables of a whole group on the stack of a thread, whatever it says it takes.
constexpr std::size_t largest_cpu_work_group = 128;
constexpr std::size_t gpu_groups_per_unit = 32;

// Some that were launched for the first time: their libraries stay loaded from the step after on, when they have run.
std::atomic<bool> has_new_kernels = false;

}  // namespace

DeviceLauncher::DeviceLauncher(Device& device, cl::CommandQueue queue, DeviceMemory& memory, BuildClock& builds,
                               u32 work_group, bool profile)
    : device_(device), queue_(std::move(queue)), memory_(memory), builds_(builds), profile_(profile) {
  const bool cpu = device.info.type == DeviceType::cpu;
  work_group_ = work_group > 0 ? work_group : cpu ? cpu_work_group : gpu_work_group;
  fused_work_group_ = work_group > 0 ? work_group : cpu ? cpu_fused_work_group : gpu_fused_work_group;
  if (!cpu) return;
  work_group_ = std::min(work_group_, largest_cpu_work_group);
  fused_work_group_ = std::min(fused_work_group_, largest_cpu_work_group);
}

void DeviceLauncher::add(const cl::Program& program, std::span<const KernelSignature> signatures) {
  for (const KernelSignature& signature : signatures) {
    const auto [kernel, is_new] = kernels_.try_emplace(signature.name);
    if (!is_new) continue;
    kernel->second.signature = signature;
    kernel->second.program = program;
  }
}

std::string DeviceLauncher::where(std::string_view kernel) const {
  const std::string_view stage_name = stage_ == Stage::count ? "sub-steps" : info(stage_).name;
  return std::string(stage_name) + ", kernel " + std::string(kernel) + " on " + device_.info.name;
}

void DeviceLauncher::begin(Stage stage, std::span<const std::byte> params) {
  if (stage == Stage::begin_step && is_pocl(device_.info) && has_new_kernels.exchange(false)) keep_loaded_kernels();
  stage_ = stage;
  stage_has_begun_ = true;
  params_.assign(params.begin(), params.end());
}

void DeviceLauncher::run(std::string_view name, u32 items, std::initializer_list<Argument> arguments) {
  Kernel& kernel = find(name);
  bind(kernel, arguments);
  const std::size_t local = std::min(work_group_, kernel.max_work_group);
  const std::size_t most =
      device_.info.type == DeviceType::cpu ? largest_cpu_grid / local : device_.compute_units * gpu_groups_per_unit;
  const std::size_t groups = (std::max(items, 1u) + local - 1) / local;
  enqueue(kernel, std::min(groups, std::max<std::size_t>(most, 1)) * local, local);
}

void DeviceLauncher::run_group(std::string_view name, std::initializer_list<Argument> arguments) {
  run_groups(name, 1, arguments);
}

void DeviceLauncher::run_groups(std::string_view name, u32 groups, std::initializer_list<Argument> arguments) {
  Kernel& kernel = find(name);
  bind(kernel, arguments);
  const std::size_t local = std::min(fused_work_group_, kernel.max_work_group);
  enqueue(kernel, std::max(groups, 1u) * local, local);
}

void DeviceLauncher::scratch(std::string_view name, std::size_t words) {
  opencl_guard([&] { return where(name); }, [&] { memory_.scratch(name, words); });
}

DeviceLauncher::Kernel& DeviceLauncher::find(std::string_view name) {
  const auto found = kernels_.find(name);
  if (found == kernels_.end()) throw Error(Failure::device, where(name), "there is no such kernel in the program");
  Kernel& kernel = found->second;
  if (kernel.handle() != nullptr) return kernel;
  opencl_guard([&] { return where(name); },
               [&] {
                 kernel.handle = cl::Kernel(kernel.program, kernel.signature.name.c_str());
                 kernel.max_work_group = kernel.handle.getWorkGroupInfo<CL_KERNEL_WORK_GROUP_SIZE>(device_.handle);
                 kernel.max_work_group = std::clamp<std::size_t>(kernel.max_work_group, 1, device_.max_work_group);
               });
  for (const KernelParameter& parameter : kernel.signature.parameters) {
    kernel.bound.emplace_back();
    kernel.bound.back().buffer = buffer_named(parameter.name);
  }
  return kernel;
}

bool DeviceLauncher::is_bound(const Kernel& kernel, std::initializer_list<Argument> arguments) const {
  const std::optional<Binding>& last = kernel.binding;
  return last && last->stage == stage_ && last->memory == memory_.version() &&
         std::ranges::equal(last->arguments, arguments) && last->params == params_;
}

void DeviceLauncher::bind(Kernel& kernel, std::initializer_list<Argument> arguments) {
  if (is_bound(kernel, arguments)) return;
  kernel.binding.reset();
  for (const Argument& argument : arguments)
    if (std::ranges::find(kernel.signature.parameters, argument.parameter, &KernelParameter::name) ==
        kernel.signature.parameters.end())
      throw Error(Failure::device, where(kernel.signature.name), "has no parameter " + std::string(argument.parameter));
  opencl_guard([&] { return where(kernel.signature.name); },
               [&] {
                 for (u32 i = 0; i < kernel.bound.size(); ++i) bind_parameter(kernel, i, arguments);
               });
  kernel.binding = {stage_, memory_.version(), arguments, params_};
}

void DeviceLauncher::bind_parameter(Kernel& kernel, u32 index, std::initializer_list<Argument> arguments) {
  const KernelParameter& parameter = kernel.signature.parameters[index];
  if (parameter.kind == KernelParameter::Kind::params) {
    kernel.handle.setArg(index, params_.size(), params_.data());
    return;
  }
  const auto* given = std::find_if(arguments.begin(), arguments.end(),
                                   [&](const Argument& argument) { return argument.parameter == parameter.name; });
  if (given == arguments.end()) given = nullptr;
  if (parameter.kind == KernelParameter::Kind::value)
    bind_value(kernel, index, given);
  else
    bind_array(kernel, index, given);
}

void DeviceLauncher::bind_value(Kernel& kernel, u32 index, const Argument* given) {
  const u32* value = given ? std::get_if<u32>(&given->value) : nullptr;
  if (!value)
    throw Error(Failure::device, where(kernel.signature.name),
                "no value for the parameter " + kernel.signature.parameters[index].name);
  if (kernel.bound[index].value == *value) return;
  kernel.handle.setArg(index, *value);
  kernel.bound[index].value = *value;
}

void DeviceLauncher::bind_array(Kernel& kernel, u32 index, const Argument* given) {
  const KernelParameter& parameter = kernel.signature.parameters[index];
  Bound& bound = kernel.bound[index];
  const std::string_view* alias = given ? std::get_if<std::string_view>(&given->value) : nullptr;
  const std::string_view name = alias ? *alias : parameter.name;
  const std::optional<Buffer> buffer = alias ? buffer_named(name) : bound.buffer;
  const DeviceArray* array = buffer ? &memory_.of(*buffer) : memory_.find(name);
  if (!array)
    throw Error(Failure::device, where(kernel.signature.name),
                "the parameter " + parameter.name + " names no buffer and no scratch array");
  if (bound.array == array->id && bound.stage == stage_) return;
  if (buffer && stage_ != Stage::count) check_access(stage_, kernel.signature, parameter, *buffer);
  bound.stage = stage_;
  if (bound.array == array->id) return;
  kernel.handle.setArg(index, array->buffer);
  bound.array = array->id;
}

void DeviceLauncher::enqueue(Kernel& kernel, std::size_t global, std::size_t local) {
  cl::Event event;
  const auto launch = [&] {
    queue_.enqueueNDRangeKernel(kernel.handle, cl::NullRange, global, local, nullptr, profile_ ? &event : nullptr);
  };
  opencl_guard([&] { return where(kernel.signature.name); },
               [&] {
                 if (!std::exchange(kernel.is_new, false)) return launch();
                 has_new_kernels = true;
                 if (!builds_.is_heard()) return launch();
                 builds_.time([&] {
                   launch();
                   queue_.finish();  // a driver that builds it now may do so in a thread of its own
                 });
               });
  if (!profile_) return;
  if (stage_has_begun_) spans_.push_back({stage_, event, event});
  stage_has_begun_ = false;
  spans_.back().last = event;
}

}  // namespace lockstep
