#include "host/steppers/impulse_backend.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "host/error.hpp"
#include "host/steppers/system_problem.hpp"

namespace lockstep {

namespace {

using Row = WholeSystemProblem::Row;

constexpr double closed = 1e-11;  // m, rad
constexpr u32 most_predictions = 40, most_in_vain = 3;
constexpr double gain = 0.9;       // of a gap: one that shrinks by less is in vain
constexpr u32 most_sweeps = 5000;  // for one prediction: the next one takes them up

// Where each joint of the system is in the blocks: in their order.
std::vector<u32> slots_of(const Buffers<double>& buffers) {
  std::vector<u32> slots;
  for (u32 slot = 0; slot < buffers.joint_lanes.size() * PACK; ++slot) {
    if (buffers.joint_lanes[slot / PACK].joint[slot % PACK] != NONE) slots.push_back(slot);
  }
  return slots;
}

// Whether the row is to be closed: neither it nor its joint is a spring, or gives way.
bool closes(const SystemJoint& j, const Row& row) {
  if (row.row == WholeSystemProblem::IMPEDANCE_ROW) return false;
  return row.row == JOINT_ROWS ? j.spring_compliance == 0 && j.bound_softness == 0 : j.softness == 0;
}

// A joint at the predicted end, in parts of the time step: the velocity that its gaps stand for.
struct Predicted {
  const JointBlock<double>& block;
  u32 lane;

  double gap(u32 row) const {
    // of a locked coordinate: prepare_joints adds what the turning of bodies does, which a prediction has in it
    if (row == JOINT_ROWS) return -(block.slowest[lane] + block.velocity_product[JOINT_ROWS][lane]);
    return block.bias[row][lane];
  }
  double slowest() const { return block.slowest[lane]; }
  double fastest() const { return block.fastest[lane]; }
};

// What the end of a sub-step, as it is predicted, asks of the velocities at its start.
class Correction {
 public:
  Correction(const ContactSystem& system, const Buffers<double>& buffers, const StepParams<double>& params)
      : system_(system),
        slots_(slots_of(buffers)),
        dt_(params.dt),
        theta_(params.theta),
        whole_(whole_problem_of(system)) {
    first_ = asked();
  }

  WholeSystemProblem& whole() { return whole_; }

  /// The velocities that joints and bounded rows are to have.
  struct Asked {
    Eigen::VectorXd b;
    std::vector<oracle::BoundedLaw> laws;
  };
  Asked asked() const { return {whole_.problem.cones.b, whole_.problem.laws}; }

  /// The largest gap, m or rad, of joints and beyond limits.
  double gap(const std::vector<JointBlock<double>>& blocks) const {
    double largest = 0;
    for (const Row& row : whole_.locked) {
      if (closes(system_.joints[row.joint], row)) largest = std::max(largest, std::abs(at(blocks, row).gap(row.row)));
    }
    for (const Row& row : whole_.bounded) {
      const SystemJoint& j = system_.joints[row.joint];
      if (!closes(j, row)) continue;
      if (is_low(j)) largest = std::max(largest, at(blocks, row).slowest());
      if (is_high(j)) largest = std::max(largest, -at(blocks, row).fastest());
    }
    return dt_ * largest;
  }

  /// Asks that velocities change so that the gaps close: a change of 1 moves the end by theta dt.
  void ask(const std::vector<JointBlock<double>>& blocks, const oracle::MixedSweeps& sweeps) {
    const Eigen::VectorXd rates = sweeps.joint_rates(), row_rates = sweeps.row_rates();
    for (std::size_t k = 0; k < whole_.locked.size(); ++k) {
      const Row& row = whole_.locked[k];
      if (!closes(system_.joints[row.joint], row)) continue;
      whole_.problem.cones.b[Eigen::Index(k)] =
          row.size * at(blocks, row).gap(row.row) / theta_ - rates[Eigen::Index(k)];
    }
    for (std::size_t k = 0; k < whole_.bounded.size(); ++k) {
      const Row& row = whole_.bounded[k];
      const SystemJoint& j = system_.joints[row.joint];
      oracle::BoundedLaw& law = whole_.problem.laws[k];
      if (!closes(j, row)) continue;
      const double rate = row_rates[Eigen::Index(k)], size = row.size / theta_;
      if (is_low(j)) law.slowest = rate + size * at(blocks, row).slowest();
      if (is_high(j)) law.fastest = std::max(law.slowest, rate + size * at(blocks, row).fastest());
    }
  }

  /// Writes what was asked for to where the report looks for it.
  void write(const Asked& asked, std::vector<JointBlock<double>>& blocks) const {
    for (std::size_t k = 0; k < whole_.locked.size(); ++k) {
      const Row& row = whole_.locked[k];
      if (row.row == WholeSystemProblem::IMPEDANCE_ROW) continue;  // asks what it did
      const double change = (asked.b[Eigen::Index(k)] - first_.b[Eigen::Index(k)]) / row.size;
      JointBlock<double>& block = blocks[slots_[row.joint] / PACK];
      const u32 lane = slots_[row.joint] % PACK;
      if (row.row == JOINT_ROWS) {
        block.slowest[lane] -= change;
        block.fastest[lane] -= change;
      } else {
        block.bias[row.row][lane] += change;
      }
    }
    for (std::size_t k = 0; k < whole_.bounded.size(); ++k) {
      const Row& row = whole_.bounded[k];
      JointBlock<double>& block = blocks[slots_[row.joint] / PACK];
      const u32 lane = slots_[row.joint] % PACK;
      block.slowest[lane] += (asked.laws[k].slowest - first_.laws[k].slowest) / row.size;
      block.fastest[lane] += (asked.laws[k].fastest - first_.laws[k].fastest) / row.size;
    }
  }

 private:
  static bool is_low(const SystemJoint& j) { return j.slowest > -double(JOINT_UNBOUNDED); }
  static bool is_high(const SystemJoint& j) { return j.fastest < double(JOINT_UNBOUNDED); }
  Predicted at(const std::vector<JointBlock<double>>& blocks, const Row& row) const {
    const u32 slot = slots_[row.joint];
    return {blocks[slot / PACK], slot % PACK};
  }

  const ContactSystem& system_;
  const std::vector<u32> slots_;
  const double dt_, theta_;
  WholeSystemProblem whole_;
  Asked first_;  // before any prediction
};

}  // namespace

void ImpulseBackend::work(Stage stage, const StepParams<double>& params) {
  if (stage == Stage::close_joints) return;  // they are closed
  OracleBackend::work(stage, params);
}

// The joints' blocks as they would be at the end of the sub-step, their gaps as velocities that close them in its time.
std::vector<JointBlock<double>> ImpulseBackend::predict(const StepParams<double>& params) {
  Buffers<double>& b = buffers();
  const auto positions = b.positions;
  const auto orientations = b.orientations;
  const auto motions = b.motions;
  const auto blocks = b.joint_blocks;
  const auto joints = b.joints;
  const auto counters = b.counters;
  ReferenceBackend::work(Stage::integrate_positions, params);
  for (Joint<double>& joint : b.joints) joint.correction = 1;
  ReferenceBackend::work(Stage::prepare_joints, params);
  auto predicted = std::move(b.joint_blocks);
  b.positions = positions;
  b.orientations = orientations;
  b.motions = motions;
  b.joint_blocks = blocks;
  b.joints = joints;
  b.counters = counters;
  return predicted;
}

oracle::SolveReport ImpulseBackend::solve_system(ContactSystem& system, const StepParams<double>& params,
                                                 const std::string& where) {
  if (!(params.theta > 0))
    throw Error(
        Failure::input, where,
        "explicit Euler moves bodies by their old velocities, which no impulse changes; take another integrator");
  Correction correction(system, buffers(), params);
  WholeSystemProblem& whole = correction.whole();
  oracle::MixedSweeps sweeps(whole.problem, *oracle::find_mixed_solver("mixed_ldlt"), whole.impulses);
  const oracle::SolveLimits limits = limits_of(params);
  oracle::SolveLimits few = limits;
  few.iterations = std::min(few.iterations, most_sweeps);
  const auto apply = [&](const oracle::MixedImpulses& impulses) {
    set_impulses(system, impulses_of(system, impulses));
    write_back(system);
  };
  struct {
    double gap;
    oracle::MixedImpulses impulses;
    Correction::Asked asked;
  } best = {std::numeric_limits<double>::infinity(), sweeps.impulses(), correction.asked()};
  oracle::SolveReport report;
  u32 in_vain = 0;
  for (u32 predictions = 0;; ++predictions) {
    apply(sweeps.impulses());
    const auto end = system.joints.empty() ? std::vector<JointBlock<double>>() : predict(params);
    const double gap = correction.gap(end);
    in_vain = gap < gain * best.gap ? 0 : in_vain + 1;
    if (predictions > 0 && gap < best.gap) best = {gap, sweeps.impulses(), correction.asked()};
    if (predictions > 0 && gap <= closed) {
      // of joints alone nothing else is asked: rows of loops that agree at the end only contradict each other before
      if (system.contacts.empty() && whole.problem.laws.empty()) {
        report.stop = oracle::Stop::solved;
        report.residual = std::min(report.residual, limits.tolerance);
      }
      break;
    }
    if (predictions == most_predictions || in_vain == most_in_vain) {
      apply(best.impulses);
      report.stop = oracle::Stop::stalled;
      report.residual = std::max(report.residual, best.gap / params.dt);
      break;
    }
    correction.ask(end, sweeps);
    const oracle::SolveReport sweep_report = sweeps.run(few);
    report.stop = sweep_report.stop;
    report.iterations += sweep_report.iterations;
    report.residual = sweep_report.residual;
    report.seconds += sweep_report.seconds;
  }
  correction.write(best.asked, buffers().joint_blocks);
  return report;
}

}  // namespace lockstep
