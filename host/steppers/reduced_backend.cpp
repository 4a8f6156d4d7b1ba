#include "host/steppers/reduced_backend.hpp"

#include <algorithm>

#include "cpu_reference/oracle/articulated/reduced_cones.hpp"
#include "cpu_reference/oracle/error.hpp"
#include "host/in_double.hpp"
#include "host/scene/joint_angles.hpp"

namespace lockstep {

using namespace oracle::articulated;

ReducedBackend::ReducedBackend(InitialState<double> state, ReducedSolver solver, bool profile)
    : OracleBackend(std::move(state), SystemSolver(), profile),
      solver_(std::move(solver)),
      system_(articulated_system(buffers())),
      tree_(system_),
      laws_(laws_of(buffers(), tree_)) {}

void ReducedBackend::work(Stage stage, const StepParams<double>& params) {
  const bool is_aborted = (buffers().counters[COUNTER_STATUS] & STATUS_ABORTED) != 0;
  const bool solved = stage == Stage::warm_start || stage == Stage::solve_constraints || stage == Stage::close_joints;
  if (!solved || is_aborted) ReferenceBackend::work(stage, params);
  if (is_aborted) return;
  if (stage == Stage::integrate_velocities) start(params);
  if (stage == Stage::solve_constraints) solve(params);
  if (stage == Stage::integrate_positions) finish();
}

void ReducedBackend::start(const StepParams<double>& params) {
  solution_.reset();
  step_ = std::make_unique<Step>(tree_, laws_, step_start(buffers(), params, tree_));
  write_twists(step_->twists(), true);
  Buffers<double>& b = buffers();
  if (b.joint_angles.empty()) return;
  std::vector<double> angles;  // prepare_joints expects them a sub-step before, by these velocities
  for (std::size_t j = 0; j < b.joints.size(); ++j) angles.push_back(step_->coordinate_from(j));
  set_joint_angles(angles, params.dt, b);
}

void ReducedBackend::solve(const StepParams<double>& params) {
  Buffers<double>& b = buffers();
  if (has(features(), Feature::contacts)) ReferenceBackend::work(Stage::store_impulses, params);
  const ContactSystem system = contact_system(b, b.counters);
  demand_ = demand_of(system, b, laws_, *step_);
  VectorXd first(3 * Index(system.contacts.size()));
  for (std::size_t i = 0; i < system.contacts.size(); ++i) {
    const SystemContact& c = system.contacts[i];
    const Eigen::Vector2d tangential = oracle::models::tangents(c.normal).transpose() * c.impulse;
    first.segment<3>(3 * Index(i)) << c.normal.dot(c.impulse), tangential;
  }
  const Index rows = first.size();
  first.conservativeResize(reduced_rows(*step_, demand_).size());
  first.tail(first.size() - rows).setZero();
  const std::string where = "step " + std::to_string(b.step_index.front()) + ", solve_constraints";
  solution_ = solver_(*step_, demand_, first, limits_of(params), where);
  push(*step_, solution_->problem, solution_->impulses);
  write_twists(step_->twists(), false);
  write_impulses(system);
  note(solution_->report, params);
}

void ReducedBackend::write_twists(const std::vector<Vector6>& twists, bool links_only) {
  Buffers<double>& b = buffers();
  for (std::size_t i = 0; i < b.body_infos.size(); ++i) {
    const bool link = tree_.link_of(i) != no_link;
    if (!link && (links_only || b.body_infos[i].kind != BODY_DYNAMIC)) continue;
    for (int k = 0; k < 3; ++k) {
      b.motions[i].v[k] = twists[i][k];
      b.motions[i].w[k] = twists[i][3 + k];
    }
  }
}

void ReducedBackend::write_impulses(const ContactSystem& system) {
  Buffers<double>& b = buffers();
  for (std::size_t i = 0; i < system.contacts.size(); ++i) {
    const SystemContact& c = system.contacts[i];
    const Vector3d r = solution_->impulses.segment<3>(3 * Index(i));
    const Vector3d impulse = r[0] * c.normal + oracle::models::tangents(c.normal) * r.tail<2>();
    write_impulse(c, impulse);
  }
  const std::vector<JointPush> pushes = joint_pushes(*step_, laws_, demand_, solution_->problem, solution_->impulses);
  for (u32 slot = 0; slot < b.joint_lanes.size() * PACK; ++slot) {
    const u32 joint = b.joint_lanes[slot / PACK].joint[slot % PACK];
    if (joint == NONE) continue;
    JointImpulseBlock<double>& block = b.joint_impulses[slot / PACK];
    for (u32 row = 0; row < JOINT_ROWS; ++row) block.locked[row][slot % PACK] = pushes[joint].locked[row];
    block.free[slot % PACK] = pushes[joint].free;
    block.impedance[slot % PACK] = pushes[joint].impedance;
  }
}

void ReducedBackend::finish() {
  Buffers<double>& b = buffers();
  if (tree_.size() == 0) return;
  std::vector<Pose> poses(b.body_infos.size() + 1);
  for (std::size_t i = 0; i < b.body_infos.size(); ++i)
    poses[i] = {vector3(b.positions[i]), rotation(b.orientations[i])};
  const Step::End end = step_->finish(poses);
  open_ = end.open;
  for (std::size_t i = 0; i < b.body_infos.size(); ++i) {
    if (tree_.link_of(i) == no_link) continue;
    const Pose& pose = end.poses[i];
    Vec4<double>&x = b.positions[i], &q = b.orientations[i];
    x.x = pose.x.x();
    x.y = pose.x.y();
    x.z = pose.x.z();
    q = {pose.q.x(), pose.q.y(), pose.q.z(), pose.q.w()};
    if (pose.x.allFinite() && pose.q.coeffs().allFinite()) continue;
    b.counters[COUNTER_STATUS] |= STATUS_BAD_POSE;
    b.counters[COUNTER_BAD_BODY] = std::max(b.counters[COUNTER_BAD_BODY], NONE - static_cast<u32>(i));
  }
  write_twists(end.twists, true);
}

std::optional<Residual> ReducedBackend::residual() const {
  if (!solution_) return {};
  const ReducedProblem& p = solution_->problem;
  Residual residual;
  if (p.first_drive() == 0) return residual;
  const oracle::ConeError error =
      oracle::cone_error(cone_problem(p, solution_->impulses), cone_impulses(p, solution_->impulses));
  residual.relative = error.residual;
  residual.defect_max = error.defect_max;
  residual.defect_rms = error.defect_rms;
  residual.scale = error.scale;
  residual.rounding = error.rounding;
  residual.natural_map = error.natural_map;
  residual.worst_is_joint = error.worst >= p.contacts();
  residual.worst = error.worst;
  if (residual.worst_is_joint)
    residual.worst = u32(demand_.bounds[p.bound_of[error.worst - std::size_t(p.contacts())]].joint);
  return residual;
}

// The solution is of another step.
void ReducedBackend::restore(SavedBuffers& saved) {
  OracleBackend::restore(saved);
  solution_.reset();
  open_ = 0;
}

void ReducedBackend::take_own_residual(Measures& measures) {
  measures.residual = residual();
  measures.worst = std::nullopt;
  if (measures.residual && measures.residual->defect_max > 0) measures.worst = worst_contact(*measures.residual);
}

WorstContact ReducedBackend::worst_contact(const Residual& residual) {
  const Buffers<double>& b = buffers();
  const auto id = [&](u32 body) { return body < b.body_infos.size() ? b.body_infos[body].id : NONE; };
  if (residual.worst_is_joint) {
    const JointInfo& joint = b.joint_infos[residual.worst];
    return {joint.world, id(joint.body_a), id(joint.body_b), NONE, NONE};
  }
  const Contact& contact = b.contacts[residual.worst];
  return {contact.world, id(contact.body_a), id(contact.body_b), b.shape_infos[contact.shape_a].id,
          b.shape_infos[contact.shape_b].id};
}

}  // namespace lockstep
