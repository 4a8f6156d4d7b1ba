#include "cpu_reference/oracle/articulated/rows.hpp"

#include <cmath>

#include "cpu_reference/oracle/dense.hpp"

namespace lockstep::oracle::articulated {

namespace {

constexpr double immovable = 1e-11;

using Triplets = std::vector<Eigen::Triplet<double>>;

void add_vector(Triplets& triplets, Index first, Index column, const Vector6& v) {
  for (int k = 0; k < 6; ++k) {
    if (v[k] != 0) triplets.emplace_back(int(first + k), int(column), v[k]);
  }
}

}  // namespace

Row row_between(std::size_t body_a, const Pose& a, std::size_t body_b, const Pose& b, const Vector3d& point,
                const Vector6& wrench) {
  Row row = {body_a, body_b};
  if (body_a != world) row.on_a = -wrench_from(wrench, point - a.x);
  if (body_b != world) row.on_b = wrench_from(wrench, point - b.x);
  return row;
}

std::vector<Row> rows_of(const Joint& joint, const Configuration& at) {
  const Pose a = pose_of(at, joint.body_a), b = pose_of(at, joint.body_b);
  const JointGeometry s = joint_geometry(joint, at);
  const LockedRows locked = locked_rows(joint, s);
  std::vector<Row> rows;
  for (int k = 0; k < 6; ++k) {
    if ((locked.mask >> k & 1) != 0)
      rows.push_back(row_between(joint.body_a, a, joint.body_b, b, s.point, locked.wrench.col(k)));
  }
  return rows;
}

Row acting_row(const Joint& joint, const Configuration& at) {
  const Pose a = pose_of(at, joint.body_a), b = pose_of(at, joint.body_b);
  const JointGeometry s = joint_geometry(joint, at);
  return row_between(joint.body_a, a, joint.body_b, b, s.point, acting_axis(joint, s));
}

double velocity(const Row& row, const std::vector<Vector6>& twists) {
  double u = 0;
  if (row.body_a != world) u += row.on_a.dot(twists[row.body_a]);
  if (row.body_b != world) u += row.on_b.dot(twists[row.body_b]);
  return u;
}

SparseMatrix Mobility::responses(const std::vector<Row>& rows) const {
  const Tree& tree = inertia_.at().tree();
  Triplets triplets;
  TreeResponse response = {VectorXd::Zero(tree.freedoms()), LinkVectors(tree.size(), Vector6::Zero()),
                           LinkVectors(tree.size(), Vector6::Zero())};
  LinkVectors wrench(tree.size(), Vector6::Zero());
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Row& row = rows[i];
    std::size_t touched[2] = {no_link, no_link};  // trees
    const std::size_t bodies[2] = {row.body_a, row.body_b};
    const Vector6* acting[2] = {&row.on_a, &row.on_b};
    for (int side = 0; side < 2; ++side) {
      if (bodies[side] == world) continue;
      const std::size_t link = tree.link_of(bodies[side]);
      if (link == no_link) {
        const LoneBody& body = lone_[bodies[side]];
        const Vector6& w = *acting[side];
        add_vector(triplets, 6 * Index(bodies[side]), Index(i),
                   spatial(body.inverse_mass * w.head<3>(), body.inverse_inertia * w.tail<3>()));
        continue;
      }
      wrench[link] += *acting[side];
      const std::size_t t = tree.link(link).tree;
      if (touched[0] != t) touched[touched[0] == no_link ? 0 : 1] = t;
    }
    for (const std::size_t t : touched) {
      if (t == no_link) continue;
      inertia_.solve_tree(t, wrench, {}, {}, response);
      for (std::size_t link = tree.starts()[t]; link < tree.starts()[t + 1]; ++link) {
        add_vector(triplets, 6 * Index(tree.link(link).body), Index(i), response.twist[link]);
        wrench[link].setZero();
      }
    }
  }
  SparseMatrix result(6 * Index(tree.system().bodies.size()), Index(rows.size()));
  result.setFromTriplets(triplets.begin(), triplets.end());
  return result;
}

VectorXd Mobility::unheld(const std::vector<Row>& rows) const {
  const Tree& tree = inertia_.at().tree();
  const auto of = [&](std::size_t body, const Vector6& on) {
    if (body == world) return 0.0;
    const Vector3d f = on.head<3>(), n = on.tail<3>();
    const std::size_t link = tree.link_of(body);
    if (link == no_link) return lone_[body].inverse_mass * f.dot(f) + n.dot(lone_[body].inverse_inertia * n);
    const Body& own = tree.system().bodies[body];
    const Vector3d n_body = inertia_.at().configuration().poses[body].q.conjugate() * n;
    return f.dot(f) / own.mass + n_body.dot(n_body.cwiseQuotient(own.inertia));
  };
  VectorXd mobility(Index(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i)
    mobility[Index(i)] = of(rows[i].body_a, rows[i].on_a) + of(rows[i].body_b, rows[i].on_b);
  return mobility;
}

void Mobility::push(const std::vector<Vector6>& wrenches, std::vector<Vector6>& twists, VectorXd& rates) const {
  const Tree& tree = inertia_.at().tree();
  LinkVectors on_links(tree.size());
  for (std::size_t body = 0; body < wrenches.size(); ++body) {
    const std::size_t link = tree.link_of(body);
    if (link != no_link)
      on_links[link] = wrenches[body];
    else
      twists[body] += spatial(lone_[body].inverse_mass * wrenches[body].head<3>(),
                              lone_[body].inverse_inertia * wrenches[body].tail<3>());
  }
  const TreeResponse response = inertia_.solve(on_links);
  for (std::size_t i = 0; i < tree.size(); ++i) twists[tree.link(i).body] += response.twist[i];
  rates += response.rates;
}

SparseMatrix jacobian(const std::vector<Row>& rows, std::size_t bodies) {
  Triplets triplets;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].body_a != world) add_vector(triplets, 6 * Index(rows[i].body_a), Index(i), rows[i].on_a);
    if (rows[i].body_b != world) add_vector(triplets, 6 * Index(rows[i].body_b), Index(i), rows[i].on_b);
  }
  SparseMatrix transposed(6 * Index(bodies), Index(rows.size()));
  transposed.setFromTriplets(triplets.begin(), triplets.end());
  return transposed.transpose();
}

void add_impulses(const std::vector<Row>& rows, const VectorXd& impulses, std::vector<Vector6>& wrenches) {
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows[i].body_a != world) wrenches[rows[i].body_a] += impulses[Index(i)] * rows[i].on_a;
    if (rows[i].body_b != world) wrenches[rows[i].body_b] += impulses[Index(i)] * rows[i].on_b;
  }
}

BilateralRows::BilateralRows(const MatrixXd& r, const VectorXd& unheld) {
  if (r.rows() == 0) return;
  scale_ = VectorXd::Ones(r.rows());
  for (Index i = 0; i < r.rows(); ++i) {
    if (unheld[i] > 0) scale_[i] = 1 / std::sqrt(unheld[i]);
  }
  const MatrixXd scaled = scale_.asDiagonal() * r * scale_.asDiagonal();
  const SymmetricEigen eigen = symmetric_eigen<Eigen::Dynamic>(MatrixXd(0.5 * (scaled + scaled.transpose())));
  VectorXd inverse = eigen.values;
  for (double& value : inverse) value = value > immovable ? 1 / value : 0;
  inverse_ = product(eigen.vectors * inverse.asDiagonal(), eigen.vectors.transpose());
}

MatrixXd BilateralRows::response(const MatrixXd& s) const {
  if (size() == 0) return MatrixXd::Zero(0, s.cols());
  return -(scale_.asDiagonal() * product(inverse_, scale_.asDiagonal() * s));
}

}  // namespace lockstep::oracle::articulated
