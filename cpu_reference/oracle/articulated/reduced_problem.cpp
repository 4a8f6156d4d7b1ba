#include "cpu_reference/oracle/articulated/reduced_problem.hpp"

#include <cmath>

namespace lockstep::oracle::articulated {

namespace {

// direction . (velocity of a less that of b) at the contact point
Row contact_row(const models::Contact& c, const Vector3d& direction) {
  return {c.body_a, c.body_b, spatial(direction, c.arm_a.cross(direction)),
          -spatial(direction, c.arm_b.cross(direction))};
}

Row negated(Row row) {
  row.on_a *= -1;
  row.on_b *= -1;
  return row;
}

}  // namespace

ReducedProblem reduced_rows(const Step& step, const Demand& demand) {
  const auto& joints = step.tree().system().joints;
  ReducedProblem p;
  std::vector<double> constants, max_impulse;
  p.friction.resize(Index(demand.contacts.size()));
  for (std::size_t i = 0; i < demand.contacts.size(); ++i) {
    const models::Contact& c = demand.contacts[i];
    const Eigen::Matrix<double, 3, 2> t = models::tangents(c.normal);
    for (const Vector3d& direction : {c.normal, Vector3d(t.col(0)), Vector3d(t.col(1))})
      p.rows.push_back(contact_row(c, direction));
    constants.insert(constants.end(), {c.bias, t.col(0).dot(c.slide), t.col(1).dot(c.slide)});
    p.friction[Index(i)] = c.friction;
  }
  for (std::size_t i = 0; i < demand.bounds.size(); ++i) {
    const RateBound& bound = demand.bounds[i];
    const Row row = acting_row(joints[bound.joint], step.at());
    const auto add = [&](const Row& one, double constant) {
      p.rows.push_back(one);
      constants.push_back(constant);
      p.bound_of.push_back(i);
    };
    if (std::isfinite(bound.slowest)) add(row, -bound.slowest);
    if (std::isfinite(bound.fastest)) add(negated(row), bound.fastest);
  }
  for (const Drive& drive : demand.drives) {
    p.rows.push_back(acting_row(joints[drive.joint], step.at()));
    constants.push_back(-drive.speed);
    max_impulse.push_back(drive.max_impulse);
  }
  p.max_impulse = Eigen::Map<const VectorXd>(max_impulse.data(), Index(max_impulse.size()));
  p.q = Eigen::Map<const VectorXd>(constants.data(), Index(constants.size()));
  p.unheld = step.mobility().unheld({p.rows.end() - p.max_impulse.size(), p.rows.end()});
  for (Index i = 0; i < p.size(); ++i) p.q[i] += velocity(p.rows[std::size_t(i)], step.twists());
  return p;
}

ReducedProblem reduced_problem(const Step& step, const Demand& demand) {
  ReducedProblem p = reduced_rows(step, demand);
  const std::size_t bodies = step.twists().size();
  const SparseMatrix responses = step.mobility().responses(p.rows), j = jacobian(p.rows, bodies);
  p.w = j * responses;
  if (!step.bilateral_rows().empty()) {
    p.coupling = jacobian(step.bilateral_rows(), bodies) * responses;
    const MatrixXd less = p.coupling.transpose() * step.bilateral().response(p.coupling);
    p.w += SparseMatrix(less.sparseView());
  }
  p.w = 0.5 * (p.w + SparseMatrix(p.w.transpose()));
  return p;
}

void push(Step& step, const ReducedProblem& problem, const VectorXd& impulses) {
  VectorXd bilateral = VectorXd::Zero(Index(step.bilateral_rows().size()));
  if (bilateral.size() > 0) bilateral = step.bilateral().response(problem.coupling * impulses);
  step.push(problem.rows, impulses, bilateral);
}

}  // namespace lockstep::oracle::articulated
