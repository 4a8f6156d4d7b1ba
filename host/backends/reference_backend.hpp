// Runs the pipeline in plain C++.
#pragma once

#include "cpu_reference/reference.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

template <class real>
class ReferenceBackend {
 public:
  explicit ReferenceBackend(InitialState<real> state)
      : buffers_(std::move(state.buffers)), sizes_(state.sizes), features_(state.features) {}

  void run(Stage stage, const StepParams<real>& params) {
    if (runs(stage, features_)) reference::run_stage(stage, buffers_, params);
  }

  /// Makes room for longer lists after a step that ran out of it (STATUS_FULL).
  void grow(const Sizes& sizes) {
    sizes_ = sizes;
    resize(buffers_, sizes_, features_);
  }

  Buffers<real>& buffers() { return buffers_; }
  const Buffers<real>& buffers() const { return buffers_; }
  const Sizes& sizes() const { return sizes_; }
  Features features() const { return features_; }

 private:
  Buffers<real> buffers_;
  Sizes sizes_;
  Features features_;
};

}  // namespace lockstep
