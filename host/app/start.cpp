#include "host/app/start.hpp"

#include <fmt/format.h>

#include <cstdio>
#include <utility>

#include "host/backends/first_contacts.hpp"
#include "host/error.hpp"
#include "host/record/whole_file.hpp"
#include "host/steppers/oracles.hpp"

namespace lockstep::app {

template <class real>
Start<real> make_start(std::span<const Scene> worlds, const SceneOptions& options) {
  Start<real> start;
  start.state = compile<real>(worlds);
  if (options.resume.empty()) return start;
  const Scene& scene = worlds[0];
  resume_from(read_whole_file(options.resume), options.resume, scene.name, start.state);
  start.steps_done = start.state.buffers.step_index.front();
  if (start.steps_done >= scene.settings.steps)
    throw Error(Failure::input, options.resume,
                fmt::format("is {} steps old already, and the run is to end after {}; ask for more --steps",
                            start.steps_done, scene.settings.steps));
  return start;
}

template <class real>
void tell_suspicions(const Scene& scene, Start<real>& start) {
  std::vector<FirstContact> contacts;
  if (start.steps_done == 0) contacts = first_contacts(scene, start.state);
  for (const std::string& line : suspicions_of(scene, contacts))
    fmt::print(stderr, "lockstep: {}: {}\n", scene.source, line);
}

template <class real>
Simulation<real> simulate(Start<real>& start, const SceneOptions& options) {
  InitialState<real> state = std::exchange(start.state, {});
  const StepParams<real> params = state.params;
  return {make_stepper(std::move(state), target_of(options, state.oracle)).backend, params, start.steps_done};
}

void expect_all_solved(const std::string& scene, const std::string& solver, const Unsolved& unsolved) {
  if (unsolved.count == 0) return;
  throw Error(Failure::comparison, scene,
              in_words(solver, unsolved) + "; try another --solver, more --iterations or a larger --tolerance");
}

void tell_if_bad(const std::string& scene, const Verdict& verdict) {
  if (!verdict.good())
    fmt::print(stderr, "lockstep: {}: {} (docs/reference/error_measures.md)\n", scene, in_words(verdict));
}

#define INSTANTIATE(real)                                                             \
  template Start<real> make_start<real>(std::span<const Scene>, const SceneOptions&); \
  template void tell_suspicions(const Scene&, Start<real>&);                          \
  template Simulation<real> simulate(Start<real>&, const SceneOptions&);
INSTANTIATE(float)
INSTANTIATE(double)
#undef INSTANTIATE

}  // namespace lockstep::app
