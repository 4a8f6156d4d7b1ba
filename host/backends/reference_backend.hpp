// Runs the pipeline in plain C++.
#pragma once

#include "cpu_reference/reference.hpp"
#include "host/backends/backend.hpp"
#include "host/scene/compile.hpp"

namespace lockstep {

template <class real>
class ReferenceBackend : public Backend<real> {
 public:
  explicit ReferenceBackend(InitialState<real> state, bool profile = false);

  void run(Stage stage, const StepParams<real>& params) override;
  Counters counters() override;
  void grow(const Sizes& sizes) override;
  void enable(Feature feature) override { features_ = with(features_, feature); }
  const Buffers<real>& download(std::span<const Buffer>) override { return buffers_; }
  void upload(Buffer buffer, const Buffers<real>& buffers) override;
  const Sizes& sizes() const override { return sizes_; }
  Features features() const override { return features_; }
  std::string name() const override { return "reference"; }
  StageSeconds stage_seconds() const override { return seconds_; }

  Buffers<real>& buffers() { return buffers_; }

 protected:
  /// The work of a stage that the scene asks for.
  virtual void work(Stage stage, const StepParams<real>& params) { reference::run_stage(stage, buffers_, params); }

 private:
  Buffers<real> buffers_;
  Sizes sizes_;
  Features features_;
  bool profile_;
  StageSeconds seconds_ = {};
};

}  // namespace lockstep
