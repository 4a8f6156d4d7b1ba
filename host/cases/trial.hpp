// One trial of a hard case: its scene by one method at one setting, watched from the first state to the last, its steps
// timed.
#pragma once

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "host/device/devices.hpp"
#include "host/report/measures.hpp"
#include "host/scene/scene.hpp"

namespace lockstep {

/// How fine a step is. What is 0 is as the method or the scene has it.
struct Setting {
  double dt = 0;  // s, of a whole step
  u32 substeps = 0, iterations = 0;
};

/// What computes: a solver, an integrator, an oracle.
struct Method {
  std::string name;                                 // as legends have it
  std::function<void(Settings&)> choose = nullptr;  // makes a scene's settings those of the method; null: leaves them
  std::optional<Solver> oracle = {};                // in the place of the sweeps
  std::vector<Setting> ladder;                      // settings from cheap to dear
};

/// The state of one body, world frame, SI units, in double whatever the precision of the run.
struct BodyState {
  Vector3 x, v, w;
  Quaternion q;

  Vector3 w_body() const;
};

/// The state after a step; what is asked of it is fetched then.
class Seen {
 public:
  explicit Seen(double current_time) : time(current_time) {}
  virtual ~Seen() = default;

  virtual BodyState body(u32 index) = 0;
  /// What the locked rows of a joint of the scene pushed its second body with in the last sub-step: N, world frame.
  virtual Vector3 joint_force(u32 index) = 0;
  virtual const Measures& measures() = 0;

  const double time;  // s
};

/// A force on a body through its centre of mass, N, world frame, as a function of the time at the start of a step.
struct Push {
  u32 body;
  std::function<Vector3(double time)> force;
};

class Trial {
 public:
  /// `device`: nothing for the reference. `precision`: "float" or "double". Oracles run in double on the reference,
  /// whatever is asked for.
  Trial(const Method& method, const Setting& setting, std::string precision, std::optional<DeviceInfo> device)
      : method_(method), setting_(setting), precision_(std::move(precision)), device_(std::move(device)) {}

  /// Runs the scene as method and setting have it and calls `observe` with the state at time 0 and after each step,
  /// until it returns false or `duration` (s) is over. Clocks stand still in between. Throws what a step does, Error
  /// (input) for a scene that the method does not take, and Error (comparison) where an oracle left a step unsolved.
  void run(const Scene& scene, double duration, const std::function<bool(Seen&)>& observe,
           const std::optional<Push>& push = std::nullopt);

  /// The settings that run() gives a scene.
  Settings settings_for(const Scene& scene) const;

  /// Those of the last run().
  const Settings& settings() const { return settings_; }
  /// Whether so many sweeps were made in each sub-step: there was something to solve, and it was not for an oracle.
  bool swept() const { return !method_.oracle && !residuals_.empty(); }

  // of all that was run: the wall time of a step, ms (median; the first of each run warms up and is left out), steps
  // timed, and the residual (median of some fifty looks a run, where there were contacts or joints)
  double ms_per_step() const;
  std::size_t steps() const { return ms_.size(); }
  std::optional<double> residual() const;

 private:
  template <class real>
  void run_in(const Scene& scene, double duration, const std::function<bool(Seen&)>& observe,
              const std::optional<Push>& push);

  const Method& method_;
  const Setting setting_;
  const std::string precision_;
  const std::optional<DeviceInfo> device_;
  Settings settings_;
  std::vector<double> ms_, residuals_;
};

}  // namespace lockstep
