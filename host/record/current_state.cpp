#include "host/record/current_state.hpp"

#include <algorithm>

#include "host/record/checkpoint.hpp"

namespace lockstep {

template <class real>
InitialState<real> current_state(const InitialState<real>& start, Simulation<real>& simulation) {
  Backend<real>& backend = simulation.backend();
  InitialState<real> state = start;
  state.sizes = backend.sizes();
  state.params = simulation.params();
  resize(state.buffers, state.sizes, state.features);
  std::vector<Buffer> wanted = persistent_buffers(state.features);
  for (const Buffer buffer : driven_buffers)
    if (has(state.features, info(buffer).feature)) wanted.push_back(buffer);
  const Buffers<real>& current = backend.download(wanted);
#define BUFFER(name, ...) \
  if (std::find(wanted.begin(), wanted.end(), Buffer::name) != wanted.end()) state.buffers.name = current.name;
#include "host/buffers.def"
#undef BUFFER
  return state;
}

template InitialState<float> current_state(const InitialState<float>&, Simulation<float>&);
template InitialState<double> current_state(const InitialState<double>&, Simulation<double>&);

}  // namespace lockstep
