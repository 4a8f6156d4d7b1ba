#include "host/backends/device_backend.hpp"

#include <algorithm>
#include <chrono>
#include <map>
#include <utility>

#include "host/backends/launch_plan.hpp"
#include "host/backends/plan_trial.hpp"
#include "host/device/background_build.hpp"
#include "host/device/device_launcher.hpp"
#include "host/device/fused_substeps.hpp"
#include "host/device/program.hpp"
#include "kernels/team.h"

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

// The words of the counters, and those behind them (kernels/team.h).
constexpr std::size_t counter_bytes = (COUNTER_COUNT + TEAM_WORDS) * sizeof(u32);

// The bytes of a buffer's host copy.
template <class real, class Function>
void with_buffer(Buffer wanted, Buffers<real>& buffers, Function&& function) {
#define BUFFER(name, ...) \
  if (wanted == Buffer::name) function(buffers.name);
#include "host/buffers.def"
#undef BUFFER
}

// What the stages that run are compiled from.
struct Kernels {
  KernelSources sources;
  std::vector<std::string> files;
  std::vector<KernelSignature> signatures;
};

Kernels kernels_of(Features features, const DeviceOptions& options) {
  KernelSources sources = KernelSources::embedded(options.patches);
  std::vector<std::string> files = stage_files(sources, features, options.only);
  std::vector<KernelSignature> signatures = sources.signatures(files);
  check_stage_table(signatures);
  return {std::move(sources), std::move(files), std::move(signatures)};
}

// A kernel takes seconds to be built; steps that have taken less in all are not worth it, s.
constexpr double worth_a_build = 2;

// Buffers one behind the other in one of OpenCL's.
struct DeviceCopy final : SavedBuffers {
  struct Piece {
    Buffer buffer;
    std::size_t first, bytes;
  };
  cl::Buffer all;
  std::vector<Piece> pieces;
};
constexpr std::size_t copy_alignment = 256;  // bytes

cl::CommandQueue make_queue(Device& device, bool profile) {
  return opencl_guard("opening " + device.info.name, [&] {
    return cl::CommandQueue(device.context, device.handle, profile ? CL_QUEUE_PROFILING_ENABLE : 0);
  });
}

}  // namespace

template <class real>
struct DeviceBackend<real>::Impl {
  // `spent`: the state where it is to be let go of while the device takes it, or null.
  Impl(const InitialState<real>& state, InitialState<real>* spent, const DeviceInfo& info, const DeviceOptions& wanted)
      : threads(threads_for(info, state.sizes, state.features, wanted.threads)),
        device(open_device(info, threads)),
        sizes(state.sizes),
        features(state.features),
        lanes(lanes_for<real>(info, wanted.lanes)),
        queue(make_queue(device, wanted.profile)),
        options(wanted),
        kernels(kernels_of(features, wanted)),
        substeps(substep_plan(sizes, features, info, wanted)),
        tries_all_groups(may_try_all_groups(sizes, features, info, device.compute_units, wanted)),
        fused(substeps != SubstepPlan::launches || tries_all_groups
                  ? std::optional(fuse_substeps(kernels.signatures, fused_plan(first_plan(state, lanes))))
                  : std::nullopt),
        memory(device, queue),
        builds(device.info.name, wanted.tell_building, wanted.patience),
        launcher(device, queue, memory, builds, wanted.work_group, wanted.profile) {
    build_programs(kernels, features);
    make_mirror();
    launcher.plan() = first_plan(state, lanes);
    for_each_buffer(state.buffers, [&](Buffer buffer, const auto& elements) {
      if (elements.empty()) return;
      memory.allocate(buffer, buffer == Buffer::counters ? counter_bytes : elements.size() * sizeof(elements[0]), 0);
      write(buffer, elements.data(), elements.size() * sizeof(elements[0]));
      if (spent)
        with_buffer(buffer, spent->buffers, [](auto& of_spent) { std::decay_t<decltype(of_spent)>().swap(of_spent); });
    });
    forget_stall();
    if (substeps != SubstepPlan::launches) build_fused();
  }

  void build_fused() {
    build(kernels, features, fused->files, fused->text);
    launcher.add(programs.back()->program, std::span(&fused->signature, 1));
    make_room_for_fused();
  }

  bool meets_in_grid() const { return tries_all_groups || substeps == SubstepPlan::all_groups; }

  // Where launches and all groups are both allowed: the kernel of the second is built beside the steps, at once where
  // that has been done before, and then the clock says which is the faster one.
  void begin_step() {
    step_began = Clock::now();
    if (tries_all_groups && !trial) prepare_trial();
    if (trial) substeps = trial->plan() == 0 ? SubstepPlan::launches : SubstepPlan::all_groups;
    ++steps_by_plan[static_cast<u32>(substeps)];
  }
  void prepare_trial() {
    if (challenger) {
      if (!challenger->is_ready()) return;
      build_fused();
      fuse_again();
      trial.emplace();
      return;
    }
    const bool is_worth_it = seconds_in_steps > worth_a_build;
    if (!is_first_step && !is_worth_it) return;
    FusedBuild wanted = {device.info,
                         threads,
                         kernels.sources.assemble(fused->files) + fused->text,
                         {features, sizeof(real) == 8, lanes, options.optimize, true},
                         *fused,
                         device.compute_units,
                         launcher.fused_work_group()};
    if (is_worth_it || BackgroundBuild::was_made(wanted)) challenger.emplace(std::move(wanted));
  }
  void end_step(u32 contacts) {
    if (!step_began) return;
    const double step_seconds = std::chrono::duration<double>(Clock::now() - *std::exchange(step_began, {})).count();
    if (!std::exchange(is_first_step, false)) seconds_in_steps += step_seconds;  // the first one builds kernels
    if (trial) trial->note(step_seconds, contacts);
  }

  void forget_stall() {
    queue.enqueueFillBuffer(memory.of(Buffer::counters).buffer, u32{0}, COUNTER_COUNT * sizeof(u32),
                            TEAM_WORDS * sizeof(u32));
  }

  void keep_state(DeviceBackend& backend) {
    if (before)
      copy_again(static_cast<DeviceCopy&>(*before));
    else
      before = backend.save(state_of(*fused, features));
  }

  void copy_again(const DeviceCopy& copy) {
    for (const auto& [buffer, first, bytes] : copy.pieces)
      queue.enqueueCopyBuffer(memory.of(buffer).buffer, copy.all, 0, first, bytes);
  }

  // A work-group waited for others that did not come: the state is that before the sub-steps again, and from here on
  // sub-steps are launches.
  void leave_team(DeviceBackend& backend) {
    backend.restore(*before);
    forget_stall();
    const std::vector<std::string> files = std::move(fused->files);
    fused.reset();
    before.reset();
    trial.reset();
    tries_all_groups = false;
    substeps = SubstepPlan::launches;
    build(kernels, features, files);
  }

  // The files whose kernels no fused one calls, those together that differ alike from scene to scene.
  void build_programs(const Kernels& all, Features compiled) {
    std::map<Differ, std::vector<std::string>> programs_of;
    for (const std::string& file : all.files)
      if (substeps == SubstepPlan::launches || std::ranges::count(fused->files, file) == 0)
        programs_of[differ(all.sources.assemble(std::span(&file, 1)))].push_back(file);
    for (const auto& [by, files] : programs_of) build(all, compiled, files);
  }

  // The named files, and what follows them, as one program.
  void build(const Kernels& all, Features compiled, std::span<const std::string> files, const std::string& more = {}) {
    builds.time([&] {
      programs.push_back(
          &build_program(device, all.sources.assemble(files) + more,
                         {compiled, sizeof(real) == 8, lanes, options.optimize, meets_in_grid() && !more.empty()}));
    });
    launcher.add(programs.back()->program, all.sources.signatures(files));
  }

  // The same kernel, after the plan has changed: with other numbers and more room.
  void fuse_again() {
    if (!fused) return;
    fused = fuse_substeps(kernels.signatures, fused_plan(launcher.plan()));
    make_room_for_fused();
  }

  void make_room_for_fused() {
    for (const FusedSubsteps::Scratch& scratch : fused->scratch) memory.scratch(scratch.name, scratch.words);
    if (fused->values.empty()) return;
    queue.enqueueWriteBuffer(memory.find("fused_values")->buffer, CL_TRUE, 0, fused->values.size() * sizeof(u32),
                             fused->values.data());
  }

  // Room on the host for what steps change; what is constant may be large, and gets it when it is asked for.
  void make_mirror() {
    for_each_buffer(host, [&](Buffer buffer, auto& elements) {
      const BufferInfo& of = info(buffer);
      const std::size_t count = has(features, of.feature) ? capacity(of.domain, sizes) : 0;
      elements.resize(of.lifetime == Lifetime::constant ? 0 : count);
      rows[static_cast<u32>(buffer)] = count;
    });
  }

  void write(Buffer buffer, const void* data, std::size_t bytes) {
    if (bytes > 0) queue.enqueueWriteBuffer(memory.of(buffer).buffer, CL_TRUE, 0, bytes, data);
  }
  void read(Buffer buffer, void* data, std::size_t bytes, bool blocking) {
    if (bytes > 0) queue.enqueueReadBuffer(memory.of(buffer).buffer, blocking, 0, bytes, data);
  }
  std::string where() const { return device.info.name; }
  void add_spans();

  u32 threads;
  Device& device;
  Sizes sizes;
  Features features;
  u32 lanes;
  cl::CommandQueue queue;
  DeviceOptions options;
  Kernels kernels;
  SubstepPlan substeps;   // of this step
  bool tries_all_groups;  // beside launches
  std::optional<FusedSubsteps> fused;
  std::unique_ptr<SavedBuffers> before;  // the sub-steps, where work-groups wait for each other
  std::vector<BuiltProgram*> programs;
  DeviceMemory memory;
  BuildClock builds;
  DeviceLauncher launcher;
  Buffers<real> host;
  std::array<std::size_t, buffer_count> rows = {};  // of the device's buffers
  StageSeconds seconds = {};
  std::array<u32, std::size(substep_plan_names)> steps_by_plan = {};
  std::optional<BackgroundBuild> challenger;
  std::optional<PlanTrial> trial;
  using Clock = std::chrono::steady_clock;
  std::optional<Clock::time_point> step_began;
  double seconds_in_steps = 0;
  bool is_first_step = true;
};

// From the start of a stage's first command to the end of its last.
template <class real>
void DeviceBackend<real>::Impl::add_spans() {
  for (const DeviceLauncher::Span& span : launcher.take_spans()) {
    const cl_ulong start = span.first.getProfilingInfo<CL_PROFILING_COMMAND_START>();
    const cl_ulong end = span.last.getProfilingInfo<CL_PROFILING_COMMAND_END>();
    seconds[static_cast<u32>(span.stage)] += static_cast<double>(end - start) * 1e-9;
  }
}

template <class real>
DeviceBackend<real>::DeviceBackend(const InitialState<real>& state, const DeviceInfo& device,
                                   const DeviceOptions& options)
    : impl_(opencl_guard(device.name, [&] { return std::make_unique<Impl>(state, nullptr, device, options); })) {}

template <class real>
DeviceBackend<real>::DeviceBackend(InitialState<real>&& state, const DeviceInfo& device, const DeviceOptions& options)
    : impl_(opencl_guard(device.name, [&] { return std::make_unique<Impl>(state, &state, device, options); })) {}

// Waits for what is under way, also after a failure: a driver that still builds a kernel when the process ends may
// abort it. Then every kernel that was wanted has run. A binary that cannot be had is built again next time.
template <class real>
DeviceBackend<real>::~DeviceBackend() {
  clFinish(impl_->queue());
  try {
    for (BuiltProgram* program : impl_->programs) save_program(impl_->device, *program);
  } catch (const Error&) {
  }
}

template <class real>
void DeviceBackend<real>::run(Stage stage, const StepParams<real>& params) {
  if (!runs(stage, impl_->features)) return;
  DeviceLauncher& launcher = impl_->launcher;
  const StepCounts counts = counts_of(params);
  if (std::exchange(launcher.plan().counts, counts) != counts) impl_->fuse_again();
  if (stage == Stage::begin_step) impl_->begin_step();
  const auto& fused = impl_->fused;
  const bool in_fused = impl_->substeps != SubstepPlan::launches && fused->replaces(stage);
  if (in_fused && (params.substep > 0 || stage != fused->stages[0])) return;
  if (in_fused && impl_->substeps == SubstepPlan::all_groups) impl_->keep_state(*this);
  launcher.begin(in_fused ? Stage::count : stage, std::as_bytes(std::span(&params, 1)));
  if (in_fused && impl_->substeps == SubstepPlan::all_groups)
    launcher.run_groups(fused->signature.name, impl_->device.compute_units);
  else if (in_fused)
    launcher.run_group(fused->signature.name);
  else
    launch(stage, launcher);
}

template <class real>
Counters DeviceBackend<real>::counters() {
  Counters counters;
  opencl_guard([&] { return impl_->where(); },
               [&] {
                 impl_->read(Buffer::counters, counters.data(), sizeof(counters), true);
                 impl_->builds.reset();
                 impl_->add_spans();
                 impl_->end_step(counters[COUNTER_CONTACTS]);
                 if ((counters[COUNTER_STATUS] & STATUS_STALLED) != 0) impl_->leave_team(*this);
               });
  update_plan(impl_->launcher.plan(), counters);
  return counters;
}

template <class real>
void DeviceBackend<real>::grow(const Sizes& sizes) {
  opencl_guard([&] { return impl_->where(); },
               [&] {
                 for_each_buffer(impl_->host, [&](Buffer buffer, auto& elements) {
                   const std::size_t wanted = capacity(info(buffer).domain, sizes);
                   const std::size_t had = impl_->rows[static_cast<u32>(buffer)];
                   if (!has(impl_->features, info(buffer).feature) || wanted <= had) return;
                   const std::size_t element = sizeof(elements[0]);
                   const bool kept = info(buffer).lifetime != Lifetime::transient;
                   impl_->memory.allocate(buffer, wanted * element, kept ? had * element : 0);
                 });
                 impl_->queue.finish();
                 impl_->before.reset();
                 impl_->sizes = impl_->launcher.plan().sizes = sizes;
                 impl_->fuse_again();
               });
  impl_->make_mirror();
}

// Kernels of their own: those of a step are left as they are. Volumes may be boxes where no shape is one.
template <class real>
void DeviceBackend<real>::enable(Feature feature) {
  if (has(impl_->features, feature)) return;
  impl_->features = with(impl_->features, feature);
  DeviceOptions options = impl_->options;
  options.only.clear();
  for (u32 s = 0; s < stage_count; ++s) {
    if (info(static_cast<Stage>(s)).feature == feature) options.only.push_back(static_cast<Stage>(s));
  }
  const Features compiled = with(with(impl_->features, Feature::manifolds), Feature::boxes);
  impl_->build_programs(kernels_of(compiled, options), compiled);
}

template <class real>
const Buffers<real>& DeviceBackend<real>::download(std::span<const Buffer> wanted) {
  Impl& impl = *impl_;
  opencl_guard([&] { return impl.where(); },
               [&] {
                 Counters current;
                 u32 cached = 0;
                 impl.read(Buffer::counters, current.data(), sizeof(current), true);
                 if (has(impl.features, Feature::contacts))
                   impl.read(Buffer::cached_count, &cached, sizeof(cached), true);
                 for (const Buffer buffer : wanted) {
                   with_buffer(buffer, impl.host, [&](auto& elements) {
                     if (info(buffer).lifetime == Lifetime::constant && has(impl.features, info(buffer).feature))
                       elements.resize(capacity(info(buffer).domain, impl.sizes));
                     const std::size_t count =
                         std::min(elements.size(), live(info(buffer).domain, impl.sizes, current, cached));
                     impl.read(buffer, elements.data(), count * sizeof(elements[0]), false);
                   });
                 }
                 impl.queue.finish();
               });
  return impl.host;
}

template <class real>
void DeviceBackend<real>::upload(Buffer buffer, const Buffers<real>& buffers) {
  ++this->uploads_;
  opencl_guard([&] { return impl_->where(); },
               [&] {
                 for_each_buffer(buffers, [&](Buffer each, const auto& elements) {
                   if (each != buffer) return;
                   const std::size_t bytes = elements.size() * sizeof(elements[0]);
                   impl_->write(buffer, elements.data(), std::min(bytes, impl_->memory.of(buffer).bytes));
                 });
               });
}

template <class real>
std::unique_ptr<SavedBuffers> DeviceBackend<real>::save(std::span<const Buffer> wanted) {
  auto copy = std::make_unique<DeviceCopy>();
  std::size_t end = 0;
  for (const Buffer buffer : wanted) {
    const std::size_t bytes = impl_->memory.of(buffer).bytes;
    copy->pieces.push_back({buffer, end, bytes});
    end += (bytes + copy_alignment - 1) / copy_alignment * copy_alignment;
  }
  opencl_guard([&] { return impl_->where(); },
               [&] {
                 copy->all = cl::Buffer(impl_->device.context, CL_MEM_READ_WRITE, std::max(end, copy_alignment));
                 impl_->copy_again(*copy);
               });
  return copy;
}

template <class real>
void DeviceBackend<real>::restore(SavedBuffers& saved) {
  const auto& copy = static_cast<const DeviceCopy&>(saved);
  ++this->uploads_;
  opencl_guard([&] { return impl_->where(); },
               [&] {
                 for (const auto& [buffer, first, bytes] : copy.pieces) {
                   const DeviceArray& array = impl_->memory.of(buffer);
                   impl_->queue.enqueueCopyBuffer(copy.all, array.buffer, first, 0, std::min(bytes, array.bytes));
                 }
               });
}

template <class real>
void DeviceBackend<real>::poison(Buffer buffer, unsigned char byte) {
  const DeviceArray& array = impl_->memory.of(buffer);
  opencl_guard([&] { return impl_->where(); },
               [&] { impl_->queue.enqueueFillBuffer(array.buffer, byte, 0, array.bytes); });
}

template <class real>
const Sizes& DeviceBackend<real>::sizes() const {
  return impl_->sizes;
}

template <class real>
Features DeviceBackend<real>::features() const {
  return impl_->features;
}

template <class real>
std::string DeviceBackend<real>::name() const {
  return impl_->device.info.name;
}

template <class real>
StageSeconds DeviceBackend<real>::stage_seconds() const {
  opencl_guard([&] { return impl_->where(); },
               [&] {
                 impl_->queue.finish();
                 impl_->add_spans();
               });
  return impl_->seconds;
}

template <class real>
std::vector<std::pair<std::string, u32>> DeviceBackend<real>::steps_by_plan() const {
  std::vector<std::pair<std::string, u32>> steps;
  for (const u32 of_plan : impl_->steps_by_plan) steps.emplace_back(substep_plan_names[steps.size()], of_plan);
  return steps;
}

template <class real>
u32 DeviceBackend<real>::lanes() const {
  return impl_->lanes;
}

template <class real>
u32 DeviceBackend<real>::threads() const {
  return impl_->threads;
}

template class DeviceBackend<float>;
template class DeviceBackend<double>;

}  // namespace lockstep
