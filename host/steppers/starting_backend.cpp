#include "host/steppers/starting_backend.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/backends/canary.hpp"
#include "host/device/kernel_source.hpp"
#include "host/device/program_cache.hpp"
#include "host/error.hpp"
#include "host/step.hpp"

namespace lockstep {

namespace {

template <class real>
CacheKey key_of(Features features, const DeviceInfo& device, const DeviceOptions& options) {
  const KernelSources sources = KernelSources::embedded(options.patches);
  const std::vector<std::string> files = stage_files(sources, features);
  const std::string text = sources.assemble(files);
  const std::string how = fmt::format("{} {} {} {}", features, sizeof(real), options.lanes, options.threads);
  return make_cache_key({"has built", text, how, device.name, device.platform, device.driver_version});
}

// What this process has built, whether or not there is a cache.
struct BuiltHere {
  std::mutex mutex;
  std::set<std::string> keys;
};
BuiltHere& built_here() {
  static auto& built = *new BuiltHere;
  return built;
}

void remember(const CacheKey& key) {
  ProgramCache::of_user().store(key, {});
  const std::lock_guard lock(built_here().mutex);
  built_here().keys.insert(key.hex());
}

// Made, and every kernel of a step built: a driver may build each only when it runs. The step is thrown away.
template <class real>
std::unique_ptr<DeviceBackend<real>> build(InitialState<real> state, const DeviceInfo& device, DeviceOptions options) {
  options.tell_building = nullptr;  // nobody waits
  const CacheKey key = key_of<real>(state.features, device, options);
  const StepParams<real> params = state.params;
  try {
    auto backend = std::make_unique<DeviceBackend<real>>(std::move(state), device, options);
    const CanaryVerdict verdict =
        run_canary(device, sizeof(real) == sizeof(double), backend->lanes(), backend->threads());
    if (!verdict.bit_exact()) {
      fmt::print(stderr, "lockstep: {}: {}; the plain C++ reference goes on\n", device.name, describe(verdict));
      return nullptr;
    }
    step(*backend, params);
    backend->counters();
    remember(key);
    return backend;
  } catch (const Error& error) {
    fmt::print(stderr, "lockstep: {}; the plain C++ reference goes on\n", error.what());
    return nullptr;
  }
}

struct Kept final : SavedBuffers {
  bool on_device = false;
  std::unique_ptr<SavedBuffers> copy;
};

}  // namespace

template <class real>
bool has_built(const InitialState<real>& state, const DeviceInfo& device, const DeviceOptions& options) {
  const CacheKey key = key_of<real>(state.features, device, options);
  {
    const std::lock_guard lock(built_here().mutex);
    if (built_here().keys.contains(key.hex())) return true;
  }
  return ProgramCache::of_user().load(key).has_value();
}

template <class real>
StartingBackend<real>::StartingBackend(const InitialState<real>& state, const DeviceInfo& device,
                                       const DeviceOptions& options)
    : reference_(std::make_unique<ReferenceBackend<real>>(state)),
      building_(std::async(std::launch::async, build<real>, state, device, options)) {}

template <class real>
Backend<real>& StartingBackend<real>::current() const {
  if (device_) return *device_;
  return *reference_;
}

template <class real>
void StartingBackend<real>::run(Stage stage, const StepParams<real>& params) {
  if (stage == Stage::begin_step && reference_) {
    const bool is_built = building_.valid() && building_.wait_for(std::chrono::seconds(0)) == std::future_status::ready;
    if (is_built && (device_ = building_.get())) move_to_device();
    if (!device_) ++steps_on_reference_;
  }
  current().run(stage, params);
}

// All that the last step has left, and what somebody has written since the start.
template <class real>
void StartingBackend<real>::move_to_device() {
  for (const Feature feature : enabled_) device_->enable(feature);
  device_->grow(reference_->sizes());
  const Buffers<real>& state = reference_->buffers();
  for (u32 i = 0; i < buffer_count; ++i) {
    const auto buffer = static_cast<Buffer>(i);
    if (!has(reference_->features(), info(buffer).feature)) continue;
    if (info(buffer).lifetime == Lifetime::persistent || uploaded_.contains(buffer)) device_->upload(buffer, state);
  }
  steps_before_ = device_->steps_by_plan();
  reference_.reset();
}

template <class real>
void StartingBackend<real>::enable(Feature feature) {
  if (reference_) enabled_.insert(feature);
  current().enable(feature);
}

template <class real>
void StartingBackend<real>::upload(Buffer buffer, const Buffers<real>& buffers) {
  ++this->uploads_;
  if (reference_) uploaded_.insert(buffer);
  current().upload(buffer, buffers);
}

template <class real>
std::unique_ptr<SavedBuffers> StartingBackend<real>::save(std::span<const Buffer> wanted) {
  auto kept = std::make_unique<Kept>();
  kept->on_device = device_ != nullptr;
  kept->copy = current().save(wanted);
  return kept;
}

// A copy that the reference made is one of the host, which any backend takes.
template <class real>
void StartingBackend<real>::restore(SavedBuffers& saved) {
  const auto& kept = static_cast<const Kept&>(saved);
  if (!kept.on_device) return Backend<real>::restore(*kept.copy);
  ++this->uploads_;
  device_->restore(*kept.copy);
}

template <class real>
std::vector<std::pair<std::string, u32>> StartingBackend<real>::steps_by_plan() const {
  std::vector<std::pair<std::string, u32>> steps = {{"reference", steps_on_reference_}};
  if (!device_) return steps;
  for (const auto& [plan, made] : device_->steps_by_plan()) {
    const auto before = std::ranges::find(steps_before_, plan, &std::pair<std::string, u32>::first);
    steps.emplace_back(plan, made - (before == steps_before_.end() ? 0 : before->second));
  }
  return steps;
}

template bool has_built(const InitialState<float>&, const DeviceInfo&, const DeviceOptions&);
template bool has_built(const InitialState<double>&, const DeviceInfo&, const DeviceOptions&);
template class StartingBackend<float>;
template class StartingBackend<double>;

}  // namespace lockstep
