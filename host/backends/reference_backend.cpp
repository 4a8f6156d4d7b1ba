#include "host/backends/reference_backend.hpp"

#include <algorithm>
#include <chrono>

namespace lockstep {

template <class real>
ReferenceBackend<real>::ReferenceBackend(InitialState<real> state, bool profile)
    : buffers_(std::move(state.buffers)), sizes_(state.sizes), features_(state.features), profile_(profile) {}

template <class real>
void ReferenceBackend<real>::run(Stage stage, const StepParams<real>& params) {
  if (!runs(stage, features_)) return;
  using Clock = std::chrono::steady_clock;
  const Clock::time_point start = profile_ ? Clock::now() : Clock::time_point();
  work(stage, params);
  if (profile_) seconds_[static_cast<u32>(stage)] += std::chrono::duration<double>(Clock::now() - start).count();
}

template <class real>
Counters ReferenceBackend<real>::counters() {
  Counters counters;
  std::copy_n(buffers_.counters.begin(), counters.size(), counters.begin());
  return counters;
}

template <class real>
void ReferenceBackend<real>::grow(const Sizes& sizes) {
  sizes_ = sizes;
  resize(buffers_, sizes_, features_);
}

template <class real>
void ReferenceBackend<real>::upload(Buffer wanted, const Buffers<real>& from) {
  ++this->uploads_;
#define BUFFER(name, ...) \
  if (wanted == Buffer::name) buffers_.name = from.name;
#include "host/buffers.def"
#undef BUFFER
}

template class ReferenceBackend<float>;
template class ReferenceBackend<double>;

}  // namespace lockstep
