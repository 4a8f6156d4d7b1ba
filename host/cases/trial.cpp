#include "host/cases/trial.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <memory>

#include "host/error.hpp"
#include "host/report/joints.hpp"
#include "host/simulation.hpp"
#include "host/steppers/measure_backend.hpp"
#include "host/steppers/oracles.hpp"
#include "host/steppers/stepper.hpp"

namespace lockstep {

namespace {

constexpr u32 looks = 50;  // at the residual, in a run

template <class real>
class SeenIn final : public Seen {
 public:
  SeenIn(double current_time, Simulation<real>& simulation) : Seen(current_time), simulation_(simulation) {}

  BodyState body(u32 index) override {
    if (poses_ == nullptr) {
      constexpr Buffer wanted[] = {Buffer::positions, Buffer::orientations, Buffer::motions};
      poses_ = &simulation_.backend().download(wanted);
    }
    const auto &x = poses_->positions[index], &q = poses_->orientations[index];
    const auto& m = poses_->motions[index];
    return {{x.x, x.y, x.z}, {m.v[0], m.v[1], m.v[2]}, {m.w[0], m.w[1], m.w[2]}, {q.x, q.y, q.z, q.w}};
  }

  Vector3 joint_force(u32 index) override {
    constexpr Buffer wanted[] = {Buffer::positions,   Buffer::orientations,   Buffer::motions,
                                 Buffer::joint_infos, Buffer::joints,         Buffer::screw_leads,
                                 Buffer::joint_lanes, Buffer::joint_impulses, Buffer::joint_angles};
    const Eigen::Vector3d force =
        measure_joint(simulation_.backend().download(wanted), simulation_.params(), index).force;
    return {force.x(), force.y(), force.z()};
  }

  const Measures& measures() override {
    if (!measures_) measures_ = measure(simulation_.backend(), simulation_.params(), simulation_.counters());
    return *measures_;
  }

 private:
  Simulation<real>& simulation_;
  const Buffers<real>* poses_ = nullptr;
  std::optional<Measures> measures_;
};

double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<long>(values.size() / 2);
  std::ranges::nth_element(values, middle);
  return *middle;
}

// Lets the push act on its body in the steps to come.
template <class real>
void act(const Push& push, double time, Buffers<real>& buffers, Backend<real>& backend) {
  const Vector3 force = push.force(time);
  Load<real>& load = buffers.loads[push.body];
  for (int k = 0; k < 3; ++k) load.force[k] = static_cast<real>(force[k]);
  backend.upload(Buffer::loads, buffers);
}

}  // namespace

Vector3 BodyState::w_body() const { return exact::rotate({-q[0], -q[1], -q[2], q[3]}, w); }

Settings Trial::settings_for(const Scene& scene) const {
  Settings settings = scene.settings;
  if (method_.choose) method_.choose(settings);
  if (setting_.dt > 0) settings.dt = setting_.dt;
  if (setting_.substeps > 0) settings.substeps = setting_.substeps;
  if (setting_.iterations > 0) settings.iterations = setting_.iterations;
  settings.precision = precision_;
  if (method_.oracle) replace_solver(settings, *method_.oracle);
  return settings;
}

void Trial::run(const Scene& scene, double duration, const std::function<bool(Seen&)>& observe,
                const std::optional<Push>& push) {
  Scene mine = scene;
  mine.settings = settings_ = settings_for(scene);
  mine.settings.loads = push.has_value();
  if (precision_of(settings_) == "double")
    run_in<double>(mine, duration, observe, push);
  else
    run_in<float>(mine, duration, observe, push);
}

template <class real>
void Trial::run_in(const Scene& scene, double duration, const std::function<bool(Seen&)>& observe,
                   const std::optional<Push>& push) {
  using Clock = std::chrono::steady_clock;
  InitialState<real> state = compile<real>(scene);
  Simulation<real> simulation(make_stepper(state, {device_, {}}).backend, state.params);
  const double dt = scene.settings.dt;
  const auto steps = static_cast<u32>(std::lround(duration / dt));
  const bool solves = has(state.features, Feature::contacts) || has(state.features, Feature::joints);
  SeenIn<real> first(0, simulation);
  bool going = observe(first);
  for (u32 i = 1; going && i <= steps; ++i) {
    if (push) act(*push, (i - 1) * dt, state.buffers, simulation.backend());
    const Clock::time_point start = Clock::now();
    simulation.step();
    if (i > 1) ms_.push_back(std::chrono::duration<double, std::milli>(Clock::now() - start).count());
    SeenIn<real> sample(i * dt, simulation);
    going = observe(sample);
    const bool measures_residual = i % std::max(1u, steps / looks) == 0 || (!going && residuals_.empty());
    if (solves && measures_residual)
      if (const auto& residual = sample.measures().residual) residuals_.push_back(residual->relative);
  }
  if (const Unsolved left = simulation.backend().unsolved(); left.count > 0)
    throw Error(Failure::comparison, scene.name, in_words(name_of(settings_.solver), left));
}

double Trial::ms_per_step() const { return ms_.empty() ? 0 : median(ms_); }

std::optional<double> Trial::residual() const {
  return residuals_.empty() ? std::nullopt : std::optional(median(residuals_));
}

}  // namespace lockstep
