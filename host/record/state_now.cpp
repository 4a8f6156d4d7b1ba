#include "host/record/state_now.hpp"

#include <algorithm>

#include "host/record/checkpoint.hpp"

namespace lockstep {

template <class real>
InitialState<real> state_now(const InitialState<real>& start, Simulation<real>& simulation) {
  Backend<real>& backend = simulation.backend();
  InitialState<real> state = start;
  state.sizes = backend.sizes();
  state.params = simulation.params();
  resize(state.buffers, state.sizes, state.features);
  std::vector<Buffer> wanted = persistent_buffers(state.features);
  // what inputs change, though no step does
  for (const Buffer buffer : {Buffer::loads, Buffer::joints})
    if (has(state.features, info(buffer).feature)) wanted.push_back(buffer);
  const Buffers<real>& now = backend.download(wanted);
#define BUFFER(name, ...) \
  if (std::find(wanted.begin(), wanted.end(), Buffer::name) != wanted.end()) state.buffers.name = now.name;
#include "host/buffers.def"
#undef BUFFER
  return state;
}

template InitialState<float> state_now(const InitialState<float>&, Simulation<float>&);
template InitialState<double> state_now(const InitialState<double>&, Simulation<double>&);

}  // namespace lockstep
