#include "host/backends/device_backend.hpp"

#include <algorithm>

#include "host/device/device_launcher.hpp"
#include "host/device/program.hpp"

namespace lockstep {

namespace {

// A contact per work-item on a GPU; as many as the vector unit holds on a CPU device, which does not vectorise across
// work-items by itself.
template <class real>
u32 lanes_for(const DeviceInfo& device, u32 asked) {
  if (asked != 0 && asked != 1 && asked != 8 && asked != 16)
    throw Error(Failure::input, "--lanes", "must be 1, 8 or 16, is " + std::to_string(asked));
  if (asked != 0) return asked;
  if (device.type != DeviceType::cpu) return 1;
  return sizeof(real) == 4 && device.float_width >= 16 ? 16 : 8;
}

// Up to this many contacts, and joints, one work-group solves the whole scene: launches and colours cost more than they
// share out.
constexpr u32 small_contacts = 1024;

bool is_small(const Sizes& sizes, u32 contacts) { return contacts <= small_contacts && sizes.joints <= small_contacts; }

LaunchPlan first_plan(const Sizes& sizes, Features features, u32 real_words, u32 lanes) {
  LaunchPlan plan;
  plan.sizes = sizes;
  plan.features = features;
  plan.pairs = sizes.pairs;
  plan.contacts = sizes.contacts;
  plan.blocks = sizes.blocks;
  plan.colors = 16;
  plan.real_words = real_words;
  plan.lanes = lanes;
  plan.small = is_small(sizes, has(features, Feature::contacts) ? sizes.contacts : 0);
  return plan;
}

void update_plan(LaunchPlan& plan, const Counters& counters) {
  plan.pairs = counters[COUNTER_PAIRS];
  plan.contacts = counters[COUNTER_CONTACTS];
  plan.blocks = counters[COUNTER_BLOCKS];
  plan.colors = counters[COUNTER_LARGE_COLORS];
  plan.small = is_small(plan.sizes, plan.contacts);
}

void launch(Stage stage, Launcher& launcher) {
  switch (stage) {
#define STAGE(name, ...) \
  case Stage::name:      \
    return launch_##name(launcher);
#include "host/stages.def"
#undef STAGE
    case Stage::count: return;
  }
}

// The bytes of a buffer's host copy.
template <class real, class Visitor>
void visit_buffer(Buffer wanted, Buffers<real>& buffers, Visitor&& visit) {
#define BUFFER(name, ...) \
  if (wanted == Buffer::name) visit(buffers.name);
#include "host/buffers.def"
#undef BUFFER
}

struct Built {
  BuiltProgram* program = nullptr;  // null where no stage has kernels
  std::vector<KernelSignature> signatures;
};

Built build(Device& device, Features features, bool double_precision, u32 lanes, const DeviceOptions& options) {
  const KernelSources sources = KernelSources::embedded(options.patches);
  const std::vector<std::string> files = stage_files(sources, features, options.only);
  Built built;
  built.signatures = sources.signatures(files);
  check_stage_table(built.signatures);
  if (!built.signatures.empty())
    built.program = &build_program(device, sources.assemble(files), {features, double_precision, lanes});
  return built;
}

cl::CommandQueue make_queue(Device& device, bool profile) {
  return opencl_guard("opening " + device.info.name, [&] {
    return cl::CommandQueue(device.context, device.handle, profile ? CL_QUEUE_PROFILING_ENABLE : 0);
  });
}

}  // namespace

template <class real>
struct DeviceBackend<real>::Parts {
  Parts(const InitialState<real>& state, const DeviceInfo& info, const DeviceOptions& options)
      : device(open_device(info, options.threads)),
        sizes(state.sizes),
        features(state.features),
        lanes(lanes_for<real>(info, options.lanes)),
        queue(make_queue(device, options.profile)),
        built(build(device, features, sizeof(real) == 8, lanes, options)),
        patches(options.patches),
        memory(device, queue),
        launcher(device, queue, built.program ? built.program->program : cl::Program(), built.signatures, memory,
                 options.work_group, options.profile) {
    resize(host, sizes, features);
    for_each_buffer(state.buffers, [&](Buffer buffer, const auto& elements) {
      if (elements.empty()) return;
      memory.allocate(buffer, elements.size() * sizeof(elements[0]), 0);
      write(buffer, elements.data(), elements.size() * sizeof(elements[0]));
    });
    launcher.plan() = first_plan(sizes, features, sizeof(real) / sizeof(u32), lanes);
    launcher.plan().joint_phases = state.buffers.joint_phases;
  }

  void write(Buffer buffer, const void* data, std::size_t bytes) {
    if (bytes > 0) queue.enqueueWriteBuffer(memory.of(buffer).buffer, CL_TRUE, 0, bytes, data);
  }
  void read(Buffer buffer, void* data, std::size_t bytes, bool blocking) {
    if (bytes > 0) queue.enqueueReadBuffer(memory.of(buffer).buffer, blocking, 0, bytes, data);
  }
  std::string where() const { return device.info.name; }
  void add_spans();

  Device& device;
  Sizes sizes;
  Features features;
  u32 lanes;
  cl::CommandQueue queue;
  Built built;
  std::vector<Built> enabled;  // programs of features that were added later
  std::vector<KernelPatch> patches;
  DeviceMemory memory;
  DeviceLauncher launcher;
  Buffers<real> host;
  std::array<double, stage_count> seconds = {};
};

// From the start of a stage's first command to the end of its last.
template <class real>
void DeviceBackend<real>::Parts::add_spans() {
  for (const DeviceLauncher::Span& span : launcher.take_spans()) {
    const cl_ulong start = span.first.getProfilingInfo<CL_PROFILING_COMMAND_START>();
    const cl_ulong end = span.last.getProfilingInfo<CL_PROFILING_COMMAND_END>();
    seconds[static_cast<u32>(span.stage)] += static_cast<double>(end - start) * 1e-9;
  }
}

template <class real>
DeviceBackend<real>::DeviceBackend(const InitialState<real>& state, const DeviceInfo& device,
                                   const DeviceOptions& options)
    : parts_(opencl_guard(device.name, [&] { return std::make_unique<Parts>(state, device, options); })) {}

// At the end, when every kernel that was wanted has run. A binary that cannot be had is built again next time.
template <class real>
DeviceBackend<real>::~DeviceBackend() {
  try {
    if (parts_->built.program) save_program(parts_->device, *parts_->built.program);
    for (Built& built : parts_->enabled) save_program(parts_->device, *built.program);
  } catch (const Error&) {
  }
}

template <class real>
void DeviceBackend<real>::run(Stage stage, const StepParams<real>& params) {
  if (!runs(stage, parts_->features)) return;
  parts_->launcher.plan().iterations = params.iterations;
  parts_->launcher.begin(stage, std::as_bytes(std::span(&params, 1)));
  launch(stage, parts_->launcher);
}

template <class real>
Counters DeviceBackend<real>::counters() {
  Counters counters;
  opencl_guard([&] { return parts_->where(); },
               [&] {
                 parts_->read(Buffer::counters, counters.data(), sizeof(counters), true);
                 parts_->add_spans();
               });
  update_plan(parts_->launcher.plan(), counters);
  return counters;
}

template <class real>
void DeviceBackend<real>::grow(const Sizes& sizes) {
  opencl_guard([&] { return parts_->where(); },
               [&] {
                 for_each_buffer(parts_->host, [&](Buffer buffer, auto& elements) {
                   const std::size_t wanted = capacity(info(buffer).domain, sizes);
                   if (!has(parts_->features, info(buffer).feature) || wanted <= elements.size()) return;
                   const std::size_t element = sizeof(elements[0]);
                   const bool kept = info(buffer).lifetime != Lifetime::transient;
                   parts_->memory.allocate(buffer, wanted * element, kept ? elements.size() * element : 0);
                 });
                 parts_->queue.finish();
               });
  parts_->sizes = sizes;
  parts_->launcher.plan().sizes = sizes;
  resize(parts_->host, sizes, parts_->features);
}

// Kernels of their own: those of a step are left as they are. Volumes may be boxes where no shape is one.
template <class real>
void DeviceBackend<real>::enable(Feature feature) {
  if (has(parts_->features, feature)) return;
  parts_->features = with(parts_->features, feature);
  DeviceOptions options;
  options.patches = parts_->patches;
  for (u32 s = 0; s < stage_count; ++s) {
    if (info(static_cast<Stage>(s)).feature == feature) options.only.push_back(static_cast<Stage>(s));
  }
  const Features compiled = with(with(parts_->features, Feature::manifolds), Feature::boxes);
  parts_->enabled.push_back(build(parts_->device, compiled, sizeof(real) == 8, parts_->lanes, options));
  parts_->launcher.add(parts_->enabled.back().program->program, parts_->enabled.back().signatures);
}

template <class real>
const Buffers<real>& DeviceBackend<real>::download(std::span<const Buffer> wanted) {
  Parts& parts = *parts_;
  opencl_guard([&] { return parts.where(); },
               [&] {
                 Counters now;
                 u32 cached = 0;
                 parts.read(Buffer::counters, now.data(), sizeof(now), true);
                 if (has(parts.features, Feature::contacts))
                   parts.read(Buffer::cached_count, &cached, sizeof(cached), true);
                 for (const Buffer buffer : wanted) {
                   visit_buffer(buffer, parts.host, [&](auto& elements) {
                     const std::size_t count =
                         std::min(elements.size(), live(info(buffer).domain, parts.sizes, now, cached));
                     parts.read(buffer, elements.data(), count * sizeof(elements[0]), false);
                   });
                 }
                 parts.queue.finish();
               });
  return parts.host;
}

template <class real>
void DeviceBackend<real>::upload(Buffer buffer, const Buffers<real>& buffers) {
  opencl_guard([&] { return parts_->where(); },
               [&] {
                 for_each_buffer(buffers, [&](Buffer each, const auto& elements) {
                   if (each != buffer) return;
                   const std::size_t bytes = elements.size() * sizeof(elements[0]);
                   parts_->write(buffer, elements.data(), std::min(bytes, parts_->memory.of(buffer).bytes));
                 });
               });
}

template <class real>
void DeviceBackend<real>::poison(Buffer buffer, unsigned char byte) {
  const DeviceArray& array = parts_->memory.of(buffer);
  opencl_guard([&] { return parts_->where(); },
               [&] { parts_->queue.enqueueFillBuffer(array.buffer, byte, 0, array.bytes); });
}

template <class real>
const Sizes& DeviceBackend<real>::sizes() const {
  return parts_->sizes;
}

template <class real>
Features DeviceBackend<real>::features() const {
  return parts_->features;
}

template <class real>
std::string DeviceBackend<real>::name() const {
  return parts_->device.info.name;
}

template <class real>
std::array<double, stage_count> DeviceBackend<real>::stage_seconds() const {
  opencl_guard([&] { return parts_->where(); },
               [&] {
                 parts_->queue.finish();
                 parts_->add_spans();
               });
  return parts_->seconds;
}

template <class real>
u32 DeviceBackend<real>::lanes() const {
  return parts_->lanes;
}

template class DeviceBackend<float>;
template class DeviceBackend<double>;

}  // namespace lockstep
