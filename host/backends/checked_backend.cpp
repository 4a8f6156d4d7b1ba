#include "host/backends/checked_backend.hpp"

#include <algorithm>
#include <cstring>
#include <vector>

#include "host/backends/words.hpp"

namespace lockstep {

namespace {

constexpr unsigned char device_poison = 0xa5, reference_poison = 0x5a;

DeviceOptions staged(DeviceOptions options) {
  options.substeps = SubstepPlan::launches;
  return options;
}

std::string describe(const Difference& d) {
  const std::string_view where = d.stage == Stage::count ? "all sub-steps as one launch" : info(d.stage).name;
  return "step " + std::to_string(d.step) + ", " + std::string(where) + ": " + std::string(info(d.buffer).name) + "[" +
         std::to_string(d.element) + "] word " + std::to_string(d.word) + ": device " + d.device_value +
         ", reference " + d.reference_value;
}

// Compares arrays of records as arrays of words of one type; true where something differs, with the place.
template <class Word>
bool find_difference(const void* device, const void* reference, std::size_t words, std::size_t words_per_element,
                     Difference& difference) {
  if (std::memcmp(device, reference, words * sizeof(Word)) == 0) return false;
  for (std::size_t i = 0; i < words; ++i) {
    Word a, b;
    std::memcpy(&a, static_cast<const char*>(device) + i * sizeof(Word), sizeof(Word));
    std::memcpy(&b, static_cast<const char*>(reference) + i * sizeof(Word), sizeof(Word));
    if (same_bits(a, b)) continue;
    difference.element = i / words_per_element;
    difference.word = static_cast<u32>(i % words_per_element);
    difference.device_value = show_word(a);
    difference.reference_value = show_word(b);
    return true;
  }
  return false;
}

// The stage that fills a transient buffer anew in each step: the first of those that run that writes it.
bool is_first_writer(Stage stage, Buffer buffer, Features features) {
  for (u32 i = 0; i < stage_count; ++i) {
    if (!runs(static_cast<Stage>(i), features)) continue;
    const auto writes = info(static_cast<Stage>(i)).writes;
    if (std::find(writes.begin(), writes.end(), buffer) != writes.end()) return static_cast<Stage>(i) == stage;
  }
  return false;
}

}  // namespace

Mismatch::Mismatch(Difference difference)
    : Error(Failure::comparison, "", describe(difference)), difference_(std::move(difference)) {}

template <class real>
CheckedBackend<real>::CheckedBackend(InitialState<real> state, const DeviceInfo& device, const DeviceOptions& options,
                                     CheckOptions check)
    : device_(state, device, staged(options)),
      fused_(check.fused && substep_plan(state.sizes, state.features, device, options) != SubstepPlan::launches
                 ? std::make_unique<DeviceBackend<real>>(state, device, options)
                 : nullptr),
      reference_(std::move(state)),
      check_(check) {}

template <class real>
void CheckedBackend<real>::run(Stage stage, const StepParams<real>& params) {
  if (!runs(stage, features())) return;
  if (check_.poison) poison_outputs(stage, params);
  device_.run(stage, params);
  reference_.run(stage, params);
  const auto writes = info(stage).writes;
  std::vector<Buffer> written(writes.begin(), writes.end());
  if (std::find(written.begin(), written.end(), Buffer::counters) == written.end()) written.push_back(Buffer::counters);
  compare(device_, stage, written);
  if (fused_) run_fused(stage, params, written);
}

// Compares at the end of the step. One that is aborted has left buffers as they were.
template <class real>
void CheckedBackend<real>::run_fused(Stage stage, const StepParams<real>& params, std::span<const Buffer> written) {
  fused_->run(stage, params);
  if (stage == Stage::begin_step) written_in_step_.clear();
  written_in_step_.insert(written.begin(), written.end());
  const bool is_aborted = (reference_.buffers().counters[COUNTER_STATUS] & STATUS_ABORTED) != 0;
  if (stage == Stage::end_step && !is_aborted)
    compare(*fused_, Stage::count, std::vector<Buffer>(written_in_step_.begin(), written_in_step_.end()));
}

template <class real>
void CheckedBackend<real>::poison_outputs(Stage stage, const StepParams<real>& params) {
  const bool step_aborted = (reference_.buffers().counters[COUNTER_STATUS] & STATUS_ABORTED) != 0;
  if (params.substep > 0 || (step_aborted && stage != Stage::begin_step)) return;
  for_each_buffer(reference_.buffers(), [&](Buffer buffer, auto& elements) {
    const bool rewritten = info(buffer).lifetime == Lifetime::transient && buffer != Buffer::counters;
    if (!rewritten || elements.empty() || !is_first_writer(stage, buffer, features())) return;
    device_.poison(buffer, device_poison);
    std::memset(static_cast<void*>(elements.data()), reference_poison, elements.size() * sizeof(elements[0]));
  });
}

template <class real>
void CheckedBackend<real>::compare(DeviceBackend<real>& backend, Stage stage, std::span<const Buffer> written) {
  const Buffers<real>& device = backend.download(written);
  const Buffers<real>& reference = reference_.buffers();
  const u32 cached = reference.cached_count.empty() ? 0 : reference.cached_count[0];
  Difference difference;
  const u32 steps_done = reference.step_index.empty() ? 0 : reference.step_index[0];
  difference.step = stage == Stage::count ? steps_done - 1 : steps_done;  // end_step has counted this one
  difference.stage = stage;
  const auto compare_one = [&](Buffer buffer, const auto& ours, const auto& theirs) {
    if (std::find(written.begin(), written.end(), buffer) == written.end() || theirs.empty()) return;
    const BufferInfo& about = info(buffer);
    const std::size_t element = about.template element_bytes<real>();
    const std::size_t count = std::min(theirs.size(), live(about.domain, sizes(), reference.counters, cached));
    const bool integers = about.float_bytes == about.double_bytes;
    const std::size_t word = integers ? sizeof(u32) : sizeof(real);
    difference.buffer = buffer;
    const auto find = integers ? find_difference<u32> : find_difference<real>;
    if (find(ours.data(), theirs.data(), count * element / word, element / word, difference))
      throw Mismatch(difference);
    words_compared_ += count * element / word;
  };
  // the counters first: they say how much of the others is live
  compare_one(Buffer::counters, device.counters, reference.counters);
#define BUFFER(name, ...) \
  if (Buffer::name != Buffer::counters) compare_one(Buffer::name, device.name, reference.name);
#include "host/buffers.def"
#undef BUFFER
}

template <class real>
Counters CheckedBackend<real>::counters() {
  if (fused_) fused_->counters();
  return device_.counters();
}

template <class real>
void CheckedBackend<real>::grow(const Sizes& sizes) {
  device_.grow(sizes);
  if (fused_) fused_->grow(sizes);
  reference_.grow(sizes);
}

template <class real>
void CheckedBackend<real>::enable(Feature feature) {
  device_.enable(feature);
  reference_.enable(feature);
}

template <class real>
void CheckedBackend<real>::upload(Buffer buffer, const Buffers<real>& buffers) {
  ++this->uploads_;
  device_.upload(buffer, buffers);
  if (fused_) fused_->upload(buffer, buffers);
  reference_.upload(buffer, buffers);
}

template class CheckedBackend<float>;
template class CheckedBackend<double>;

}  // namespace lockstep
