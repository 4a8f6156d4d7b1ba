#include "host/record/inputs.hpp"

#include <algorithm>

namespace lockstep {

namespace {

template <class real>
void store(const double from[3], real to[3]) {
  for (unsigned k = 0; k < 3; ++k) to[k] = static_cast<real>(from[k]);
}

}  // namespace

template <class real>
void act(std::span<const InputRow> inputs, Backend<real>& backend, std::vector<Load<real>>& loads) {
  const auto any = [&](InputKind kind) {
    return std::any_of(inputs.begin(), inputs.end(), [kind](const InputRow& row) { return row.kind == kind; });
  };
  Buffers<real> now;
  const bool velocities = any(InputKind::velocity), forces = any(InputKind::load);
  const Buffer motions[] = {Buffer::motions};
  if (velocities) now.motions = backend.download(motions).motions;
  if (forces) now.loads.swap(loads);
  for (const InputRow& row : inputs) {
    real* linear = row.kind == InputKind::load ? now.loads[row.body].force : now.motions[row.body].v;
    real* angular = row.kind == InputKind::load ? now.loads[row.body].torque : now.motions[row.body].w;
    store(row.linear, linear);
    store(row.angular, angular);
  }
  if (velocities) backend.upload(Buffer::motions, now);
  if (forces) backend.upload(Buffer::loads, now);
  if (forces) now.loads.swap(loads);
}

template void act(std::span<const InputRow>, Backend<float>&, std::vector<Load<float>>&);
template void act(std::span<const InputRow>, Backend<double>&, std::vector<Load<double>>&);

}  // namespace lockstep
