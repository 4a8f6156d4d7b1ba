#include "host/steppers/oracle_backend.hpp"

#include <cmath>

#include "host/report/contact_system.hpp"
#include "host/stop_request.hpp"

namespace lockstep {

namespace {

constexpr double most_seconds = 60;  // for one system

void copy_persistent(const Buffers<double>& from, Buffers<double>& to) {
#define BUFFER(name, ...) \
  if (info(Buffer::name).lifetime == Lifetime::persistent) to.name = from.name;
#include "host/buffers.def"
#undef BUFFER
}

}  // namespace

void OracleBackend::run(Stage stage, const StepParams<double>& params) {
  if (stage == Stage::begin_step) {
    copy_persistent(buffers(), before_);
    unsolved_before_ = unsolved_;
  }
  ReferenceBackend::run(stage, params);
  if (stage != Stage::solve_constraints || !stop_asked()) return;
  copy_persistent(before_, buffers());
  unsolved_ = unsolved_before_;
  throw Stopped();
}

oracle::SolveLimits OracleBackend::limits_of(const StepParams<double>& params) {
  return {params.tolerance, params.iterations, most_seconds};
}

void OracleBackend::write_impulse(const SystemContact& c, const Eigen::Vector3d& impulse) {
  const u32 slot = buffers().contact_slots[c.contact];
  ImpulseBlock<double>& block = buffers().impulse_blocks[slot / PACK];
  const Eigen::Vector2d tangential = solver_tangents(c.normal).transpose() * impulse;
  block.normal[slot % PACK] = c.normal.dot(impulse);
  block.tangent_1[slot % PACK] = tangential[0];
  block.tangent_2[slot % PACK] = tangential[1];
}

// Velocities and impulses of a system, which was made from the same buffers.
void OracleBackend::write_back(const ContactSystem& system) {
  Buffers<double>& b = buffers();
  for (std::size_t i = 0; i < system.bodies.size(); ++i) {
    const SystemBody& body = system.bodies[i];
    if (body.inverse_mass == 0 && body.inverse_inertia.isZero(0)) continue;
    Motion<double>& motion = b.motions[i];
    for (int k = 0; k < 3; ++k) {
      motion.v[k] = body.v[k];
      motion.w[k] = body.w[k];
    }
  }
  for (const SystemContact& c : system.contacts) write_impulse(c, c.impulse);
  auto joint = system.joints.begin();
  for (u32 slot = 0; slot < b.joint_lanes.size() * PACK; ++slot) {
    if (b.joint_lanes[slot / PACK].joint[slot % PACK] == NONE) continue;
    JointImpulseBlock<double>& block = b.joint_impulses[slot / PACK];
    for (u32 row = 0; row < JOINT_ROWS; ++row) block.locked[row][slot % PACK] = joint->impulse[row];
    block.free[slot % PACK] = joint->free_impulse;
    block.impedance[slot % PACK] = joint->impedance_impulse;
    ++joint;
  }
}

void OracleBackend::note(const oracle::SolveReport& report, const StepParams<double>& params) {
  buffers().counters[COUNTER_SWEEPS] += report.iterations;
  if (report.residual <= params.tolerance) return;
  const Stop stop = !std::isfinite(report.residual) ? Stop::bad
                    : report.stop == Stop::solved   ? Stop::stalled  // in a measure of its own
                                                    : report.stop;
  unsolved_.add(Unsolved::of(1, buffers().step_index.front(), stop, report.residual, params.tolerance));
}

void OracleBackend::work(Stage stage, const StepParams<double>& params) {
  Buffers<double>& b = buffers();
  if (stage != Stage::solve_constraints || (b.counters[COUNTER_STATUS] & STATUS_ABORTED) != 0)
    return ReferenceBackend::work(stage, params);
  // the impulses of the warm start go where a system is read from; the end of the step puts those of the oracle there
  if (has(features(), Feature::contacts)) ReferenceBackend::work(Stage::store_impulses, params);
  ContactSystem system = contact_system(b, b.counters);
  if (system.contacts.empty() && system.joints.empty()) return;
  const oracle::SolveReport report =
      solve_system(system, params, "step " + std::to_string(b.step_index.front()) + ", solve_constraints");
  write_back(system);
  note(report, params);
}

oracle::SolveReport OracleBackend::solve_system(ContactSystem& system, const StepParams<double>& params,
                                                const std::string& where) {
  return solver_(system, limits_of(params), where);
}

}  // namespace lockstep
