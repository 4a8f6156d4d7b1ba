#include "host/record/inputs.hpp"

#include <algorithm>

#include "host/scene/joint_angles.hpp"
#include "host/sleepers.hpp"

namespace lockstep {

namespace {

template <class real>
void store(const double from[3], real to[3]) {
  for (unsigned k = 0; k < 3; ++k) to[k] = static_cast<real>(from[k]);
}

// Whoever is acted on wakes; gravity acts on all.
template <class real>
void wake(std::span<const InputRow> inputs, Backend<real>& backend) {
  if (inputs.empty() || !has(backend.features(), Feature::sleeping)) return;
  const Buffer wanted[] = {Buffer::sleepers, Buffer::joint_infos};
  const Buffers<real>& current = backend.download(wanted);
  Buffers<real> woken;
  woken.sleepers = current.sleepers;
  bool any = false;
  for (const InputRow& row : inputs) {
    if (row.kind == InputKind::cold_start) continue;
    if (row.kind == InputKind::gravity) {
      any = wake_all(woken.sleepers) || any;
    } else if (row.kind == InputKind::motor || row.kind == InputKind::rest) {
      const JointInfo& joint = current.joint_infos[row.body];
      for (const u32 body : {joint.body_a, joint.body_b}) any = wake_island_of(woken.sleepers, body) || any;
    } else {
      any = wake_island_of(woken.sleepers, row.body) || any;
    }
  }
  if (any) backend.upload(Buffer::sleepers, woken);
}

// Whether a velocity is set by which a joint could seem to have rotated by half a revolution in a sub-step.
template <class real>
bool sets_fast_rotation(std::span<const InputRow> inputs, const std::vector<Motion<real>>& motions, double dt) {
  constexpr double fast = 1;  // rad in a sub-step, of a body
  return std::ranges::any_of(inputs, [&](const InputRow& row) {
    if (row.kind != InputKind::velocity) return false;
    double squares = 0;
    for (unsigned k = 0; k < 3; ++k)
      squares += (row.angular[k] - double(motions[row.body].w[k])) * (row.angular[k] - double(motions[row.body].w[k]));
    return squares * dt * dt > fast * fast;
  });
}

// What the angles of joints that count revolutions need beside motions.
template <class real>
void load_joint_angles(Backend<real>& backend, Buffers<real>& moving) {
  const Buffer wanted[] = {Buffer::body_infos, Buffer::orientations, Buffer::joint_infos, Buffer::joints,
                           Buffer::joint_angles};
  const Buffers<real>& current = backend.download(wanted);
  moving.body_infos = current.body_infos;
  moving.orientations = current.orientations;
  moving.joint_infos = current.joint_infos;
  moving.joints = current.joints;
  moving.joint_angles = current.joint_angles;
}

}  // namespace

template <class real>
Buffers<real> driven_by_inputs(const Buffers<real>& state) {
  Buffers<real> driven;
  driven.loads = state.loads;
  driven.joints = state.joints;
  driven.gravities = state.gravities;
  return driven;
}

template <class real>
void act(std::span<const InputRow> inputs, Simulation<real>& simulation, Buffers<real>& driven) {
  Backend<real>& backend = simulation.backend();
  const double dt = double(simulation.params().dt);
  const auto any = [&](InputKind kind) { return std::ranges::find(inputs, kind, &InputRow::kind) != inputs.end(); };
  wake(inputs, backend);
  const Buffer motions[] = {Buffer::motions};
  Buffers<real> moving;
  std::vector<double> growths;  // of the angles of joints in a sub-step, where these velocities change them much
  if (any(InputKind::velocity)) moving.motions = backend.download(motions).motions;
  if (has(backend.features(), Feature::joint_angles) && sets_fast_rotation(inputs, moving.motions, dt)) {
    load_joint_angles(backend, moving);
    growths = angles_of_substep(moving, dt);
  }
  for (const InputRow& row : inputs) {
    switch (row.kind) {
      case InputKind::velocity:
        store(row.linear, moving.motions[row.body].v);
        store(row.angular, moving.motions[row.body].w);
        break;
      case InputKind::load:
        store(row.linear, driven.loads[row.body].force);
        store(row.angular, driven.loads[row.body].torque);
        break;
      case InputKind::motor:
        driven.joints[row.body].motor_speed = static_cast<real>(row.linear[0]);
        driven.joints[row.body].motor_force = static_cast<real>(row.linear[1]);
        break;
      case InputKind::rest: {
        Joint<real>& joint = driven.joints[row.body];
        const real rest = static_cast<real>(row.linear[0]);
        if (joint.side_compliance > 0)
          joint.side_rest = rest;
        else
          joint.low = joint.high = rest;
        break;
      }
      case InputKind::gravity: {
        Vec4<real>& pulls = driven.gravities[row.body];
        pulls = {static_cast<real>(row.linear[0]), static_cast<real>(row.linear[1]), static_cast<real>(row.linear[2]),
                 pulls.w};
        break;
      }
      case InputKind::cold_start: simulation.start_cold(); break;
      case InputKind::restore: break;  // of the whole state, by who has it
    }
  }
  if (any(InputKind::velocity)) backend.upload(Buffer::motions, moving);
  if (!growths.empty()) {  // the new velocities have not led here
    const std::vector<double> seeming = angles_of_substep(moving, dt);
    for (std::size_t j = 0; j < growths.size(); ++j)
      moving.joint_angles[j] = static_cast<real>(double(moving.joint_angles[j]) + (growths[j] - seeming[j]));
    backend.upload(Buffer::joint_angles, moving);
  }
  if (any(InputKind::load)) backend.upload(Buffer::loads, driven);
  if (any(InputKind::motor) || any(InputKind::rest)) backend.upload(Buffer::joints, driven);
  if (any(InputKind::gravity)) backend.upload(Buffer::gravities, driven);
}

template Buffers<float> driven_by_inputs(const Buffers<float>&);
template Buffers<double> driven_by_inputs(const Buffers<double>&);
template void act(std::span<const InputRow>, Simulation<float>&, Buffers<float>&);
template void act(std::span<const InputRow>, Simulation<double>&, Buffers<double>&);

}  // namespace lockstep
