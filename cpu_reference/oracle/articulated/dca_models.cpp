#include "cpu_reference/oracle/articulated/dca_models.hpp"

#include <algorithm>

#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle::articulated {

namespace {

// Rows of w: w = V_0 + Y x. And x alone, but for the rows of contacts.
models::MixedLcp begun(const AssembledProblem& all, const ReducedPyramid& pyramid,
                       const std::vector<std::size_t>& bodies) {
  const ReducedProblem& p = all.problem;
  const Index n = 6 * Index(bodies.size()), contact_rows = 3 * p.contacts();
  MatrixXd responses(n, p.size());
  models::MixedLcp m;
  m.r.resize(n);
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    const Index row = all.assembly.first_row(bodies[i]);
    responses.middleRows(6 * Index(i), 6) = all.responses.middleRows(row, 6);
    m.r.segment<6>(6 * Index(i)) = all.assembly.free.segment<6>(row);
  }
  m.c = product(responses, pyramid.spread());
  m.d = -MatrixXd::Identity(n, n);
  MatrixXd w = p.w;
  w.topRows(contact_rows).setZero();
  VectorXd q = p.q;
  q.head(contact_rows).setZero();
  m.f = pyramid.couplings() + transposed_product(pyramid.spread(), product(w, pyramid.spread()));
  m.a = pyramid.constants() + pyramid.spread().transpose() * q;
  return m;
}

MatrixXd unknowns_of(const ReducedPyramid& pyramid, const MatrixXd& of_contacts, Index rows) {
  MatrixXd all = MatrixXd::Zero(rows, of_contacts.cols());
  all.topRows(of_contacts.rows()) = of_contacts;
  return transposed_product(pyramid.spread(), all);
}

}  // namespace

std::vector<std::size_t> terminals(const Tree& tree) {
  std::size_t most = 0;
  std::vector<std::size_t> ends;
  for (std::size_t t = 0; t + 1 < tree.starts().size(); ++t) {
    const std::size_t first = tree.starts()[t], end = tree.starts()[t + 1];
    if (end - first <= most) continue;
    most = end - first;
    ends = {tree.link(first).body, tree.link(end - 1).body};
  }
  if (!ends.empty()) return ends;
  const auto& bodies = tree.system().bodies;
  for (std::size_t body = 0; body < bodies.size(); ++body) {
    if (!(bodies[body].mass > 0)) continue;
    if (ends.empty()) ends = {body, body};
    ends[1] = body;
  }
  return ends;
}

std::vector<std::size_t> touched(const Tree& tree, const Demand& demand) {
  std::vector<std::size_t> bodies;
  for (const models::Contact& c : demand.contacts) {
    for (const std::size_t body : {c.body_a, c.body_b}) {
      if (tree.system().bodies[body].mass > 0) bodies.push_back(body);
    }
  }
  std::ranges::sort(bodies);
  bodies.erase(std::unique(bodies.begin(), bodies.end()), bodies.end());
  return bodies;
}

models::MixedLcp dca_mlcp1(const AssembledProblem& all, const ReducedPyramid& pyramid,
                           const std::vector<std::size_t>& bodies) {
  const ReducedProblem& p = all.problem;
  models::MixedLcp m = begun(all, pyramid, bodies);
  MatrixXd sees = MatrixXd::Zero(3 * p.contacts(), m.r.size());
  const auto first_of = [&](std::size_t body) { return 6 * Index(std::ranges::find(bodies, body) - bodies.begin()); };
  for (Index i = 0; i < sees.rows(); ++i) {
    const Row& row = p.rows[std::size_t(i)];
    if (first_of(row.body_a) < sees.cols()) sees.row(i).segment<6>(first_of(row.body_a)) += row.on_a.transpose();
    if (first_of(row.body_b) < sees.cols()) sees.row(i).segment<6>(first_of(row.body_b)) += row.on_b.transpose();
  }
  m.b = unknowns_of(pyramid, sees, p.size());
  VectorXd q = VectorXd::Zero(p.size());
  q.head(sees.rows()) =
      p.q.head(sees.rows()) - sees * m.r;  // what w does not know: biases, bodies that move by themselves
  m.a += pyramid.spread().transpose() * q;
  return m;
}

models::MixedLcp dca_mlcp2(const AssembledProblem& all, const ReducedPyramid& pyramid,
                           const std::vector<std::size_t>& ends) {
  const ReducedProblem& p = all.problem;
  const Index contact_rows = 3 * p.contacts(), n = 6 * Index(ends.size());
  models::MixedLcp m = begun(all, pyramid, ends);
  MatrixXd own(n, n), responses(n, p.size());
  for (std::size_t i = 0; i < ends.size(); ++i) {
    const Index row = all.assembly.first_row(ends[i]);
    responses.middleRows(6 * Index(i), 6) = all.responses.middleRows(row, 6);
    for (std::size_t j = 0; j < ends.size(); ++j)
      own.block<6, 6>(6 * Index(i), 6 * Index(j)) =
          all.assembly.inverse_inertia.block<6, 6>(row, all.assembly.first_row(ends[j]));
  }
  const BilateralRows inverse(own, own.diagonal());
  const MatrixXd k = -inverse.response(responses.leftCols(contact_rows)).transpose();
  m.b = unknowns_of(pyramid, k, p.size());
  MatrixXd w = MatrixXd::Zero(p.size(), p.size());
  w.topRows(contact_rows) = MatrixXd(p.w).topRows(contact_rows) - product(k, responses);
  // what only the terminals move cannot move while they are held: rounding there would pass for a mobility
  const VectorXd size = p.w.diagonal().cwiseMax(0).cwiseSqrt();
  w = (w.array().abs() <= 1e-12 * (size * size.transpose()).array()).select(0, w);
  VectorXd q = VectorXd::Zero(p.size());
  q.head(contact_rows) = p.q.head(contact_rows) - k * m.r;
  m.f += transposed_product(pyramid.spread(), product(w, pyramid.spread()));
  m.a += pyramid.spread().transpose() * q;
  return m;
}

}  // namespace lockstep::oracle::articulated
