#include "cpu_reference/oracle/articulated/step.hpp"

#include <algorithm>
#include <cmath>

#include "cpu_reference/oracle/articulated/closing.hpp"

namespace lockstep::oracle::articulated {

namespace {

constexpr double unfelt = 1e-3;      // of a tree's energy of motion, given in a step
constexpr int most_iterations = 30;  // of the fixed point; a step that turns by little needs five or six

// Of springs, then of armatures.
std::vector<Row> soft_rows(const Laws& laws, const Tree& tree, const Configuration& at) {
  std::vector<Row> rows;
  for (const Spring& spring : laws.springs) rows.push_back(acting_row(tree.system().joints[spring.joint], at));
  for (const Armature& armature : laws.armatures) rows.push_back(acting_row(tree.system().joints[armature.joint], at));
  return rows;
}

// Angular velocity keeps its components in the body while that turns.
void carry(const Pose& from, const Pose& to, Vector6& twist) {
  twist.tail<3>() = (to.q * (from.q.conjugate() * twist.tail<3>())).eval();
}

VectorXd velocities(const std::vector<Row>& rows, const std::vector<Vector6>& twists) {
  VectorXd u(Index(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) u[Index(i)] = velocity(rows[i], twists);
  return u;
}

}  // namespace

std::vector<Vector6> twists_at(const Kinematics& at, const VectorXd& rates, std::vector<Vector6> twists) {
  const Tree& tree = at.tree();
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    const Vector6 own = at.link(i).motion * rates.segment(link.first, link.freedoms);
    const Vector6 parent =
        link.parent == no_link ? at.carried(i) : twist_at(twists[tree.link(link.parent).body], at.link(i).from_parent);
    twists[link.body] = parent + own;
  }
  return twists;
}

VectorXd constrained_rates(const Kinematics& at, const std::vector<Row>& rows, const VectorXd& rates,
                           const std::vector<Vector6>& twists) {
  if (rows.empty()) return rates;
  const ArticulatedInertia inertia(at);
  const std::vector<LoneBody> lone(twists.size());
  const Mobility mobility(inertia, lone);
  const BilateralRows bilateral(jacobian(rows, twists.size()) * mobility.responses(rows), mobility.unheld(rows));
  std::vector<Vector6> wrenches(twists.size(), Vector6::Zero()), changed = twists;
  add_impulses(rows, bilateral.response(velocities(rows, twists_at(at, rates, twists))), wrenches);
  VectorXd constrained = rates;
  mobility.push(wrenches, changed, constrained);
  return constrained;
}

Step::Step(const Tree& tree, const Laws& laws, StepStart start)
    : tree_(tree), laws_(laws), start_(std::move(start)), angles_(start_.angles), from_(measured(tree, start_.poses)) {
  angles_.resize(tree.system().joints.size(), 0);
  close_loops(tree_, laws_.closures, nullptr, angles_, from_);
  const Kinematics still(tree_, from_, start_.twists, VectorXd::Zero(tree_.freedoms()));
  VectorXd rates = gripped_rates(ArticulatedInertia(still), start_.twists);
  rates = constrained_rates(still, closure_rows(laws_.closures, tree_, angles_, from_).rows, rates, start_.twists);
  start_.twists = twists_at(still, rates, start_.twists);

  // a first guess by the accelerations at the start
  const Kinematics current(tree_, from_, start_.twists, rates);
  LinkVectors forces, products;
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    forces.push_back(start_.wrenches[tree_.link(i).body] - (start_.gyroscopic ? 1.0 : 0.0) * current.gyroscopic(i));
    products.push_back(current.link(i).product);
  }
  const VectorXd delta_rates = start_.dt * ArticulatedInertia(current).solve(forces, {}, products).rates;
  VectorXd guess = rates + start_.theta * delta_rates, half = rates + 0.5 * delta_rates, best = guess, best_half = half;
  double least = -1;
  for (int i = 0; i < most_iterations; ++i) {
    go(guess, half);
    const double off = (mean() - guess).norm();
    if (off <= 1e-13 * (rates.norm() + guess.norm())) return;
    if (least >= 0 && off > 2 * least) break;  // turns too far in a step to converge
    if (least < 0 || off < least) least = off, best = guess, best_half = half;
    guess = mean();
    half = rates_ + 0.5 * change_;
  }
  go(best, best_half);
}

void Step::go(const VectorXd& mean_rates, const VectorXd& half) {
  const double h = start_.dt;
  at_ = std::make_unique<Configuration>(moved(tree_, from_, mean_rates, start_.twists, 0.5 * h));
  kinematics_ = std::make_unique<Kinematics>(tree_, *at_, start_.twists, half);
  inertia_ = std::make_unique<ArticulatedInertia>(*kinematics_);
  impulses_.assign(start_.poses.size(), Vector6::Zero());
  old_twists_ = start_.twists;
  LinkVectors pushes(tree_.size()), momentum(tree_.size()), carried(tree_.size());
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    const std::size_t body = tree_.link(i).body;
    if (start_.gyroscopic) carry(from_.poses[body], at_->poses[body], old_twists_[body]);
    pushes[i] = h * start_.wrenches[body];
    if (start_.gyroscopic) pushes[i] -= h * kinematics_->gyroscopic(i);
    impulses_[body] = pushes[i];
    momentum[i] = kinematics_->momentum(i, old_twists_[body]);
    carried[i] = kinematics_->carried(i);
  }
  rates_ = inertia_->solve(momentum, {}, carried).rates;
  const TreeResponse pushed = inertia_->solve(pushes);
  change_ = pushed.rates;

  const std::vector<Row> closures = closure_rows(laws_.closures, tree_, angles_, *at_).rows;
  bilateral_rows_ = closures;
  for (const Row& row : soft_rows(laws_, tree_, *at_)) bilateral_rows_.push_back(row);
  const Index closed = Index(closures.size()), all = Index(bilateral_rows_.size());
  bilateral_impulses_ = VectorXd::Zero(all);
  MatrixXd r;
  VectorXd unheld;
  if (all > 0) {
    r = jacobian(bilateral_rows_, start_.poses.size()) * mobility().responses(bilateral_rows_);
    unheld = mobility().unheld(bilateral_rows_);
  }
  if (closed > 0) {
    const VectorXd u = velocities(closures, twists_at(*kinematics_, rates_, old_twists_));
    const VectorXd closing_impulses = BilateralRows(r.topLeftCorner(closed, closed), unheld.head(closed)).response(u);
    std::vector<Vector6> wrenches(start_.poses.size(), Vector6::Zero()), unused = old_twists_;
    add_impulses(closures, closing_impulses, wrenches);
    mobility().push(wrenches, unused, rates_);
    for (std::size_t body = 0; body < wrenches.size(); ++body) impulses_[body] += 2 * wrenches[body];
    bilateral_impulses_.head(closed) = 2 * closing_impulses;
  }

  twists_ = twists_at(*kinematics_, rates_, old_twists_);
  std::vector<Vector6> changes(start_.poses.size(), Vector6::Zero());
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    const std::size_t body = tree_.link(i).body;
    changes[body] = pushed.twist[i];
    twists_[body] = 2 * twists_[body] - old_twists_[body] + changes[body];
  }
  if (all == 0) return;
  VectorXd s = velocities(bilateral_rows_, twists_);
  s.head(closed) = velocities(closures, changes);
  // a trapezoidal step has the mean rate (u + u') / 2 in the law of springs: all of it times two
  const double weight = start_.theta == 0.5 ? 2 : 1;
  for (std::size_t i = 0; i < laws_.springs.size(); ++i) {
    const Spring& spring = laws_.springs[i];
    const Index row = closed + Index(i);
    const double above = coordinate_from(spring.joint) - spring.rest;
    double bias = spring.rate * above, compliance = spring.compliance;
    if (start_.theta == 0.5) {
      // in the mean rate a damper of the velocity (1 - t) u + t u' has 2 t of its h c, and (1 - 2 t) of it in u
      const double before = velocity(bilateral_rows_[std::size_t(row)], old_twists_);
      const double damper = (1 - 0.5 * start_.dt * spring.rate) / spring.compliance, z = damper * r(row, row);
      const double stiffer = damper * z / (z + 6);
      compliance = 1 / (1 / spring.compliance + stiffer);
      bias = compliance * (bias / spring.compliance - stiffer * before);
      s[row] += before;
    }
    s[row] += weight * bias;
    r(row, row) += weight * compliance;
  }
  const Index first_armature = closed + Index(laws_.springs.size());
  if (first_armature < all) {
    const Configuration to = moved(tree_, from_, mean_rates, start_.twists, h);
    const std::vector<Vector6> end_twists = twists_at_end(to);
    for (std::size_t i = 0; i < laws_.armatures.size(); ++i) {
      const Armature& armature = laws_.armatures[i];
      const Joint& joint = tree_.system().joints[armature.joint];
      const Index row = first_armature + Index(i);
      s[row] = velocity(acting_row(joint, to), end_twists) - velocity(acting_row(joint, from_), start_.twists);
      r(row, row) += 1 / armature.inertia;
    }
  }
  bilateral_ = BilateralRows(r, unheld);
  push({}, {}, bilateral_.response(s));
}

void Step::push(const std::vector<Row>& rows, const VectorXd& impulses, const VectorXd& bilateral_impulses) {
  std::vector<Vector6> wrenches(twists_.size(), Vector6::Zero());
  add_impulses(rows, impulses, wrenches);
  add_impulses(bilateral_rows_, bilateral_impulses, wrenches);
  mobility().push(wrenches, twists_, change_);
  for (std::size_t body = 0; body < wrenches.size(); ++body) impulses_[body] += wrenches[body];
  bilateral_impulses_ += bilateral_impulses;
}

LinkVectors Step::carried() const {
  LinkVectors on_links(tree_.size()), products(tree_.size());
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    const std::size_t body = tree_.link(i).body;
    on_links[i] = 2 * kinematics_->momentum(i, old_twists_[body]) + impulses_[body];
    products[i] = 2 * kinematics_->carried(i);
  }
  return inertia_->solve(on_links, {}, products).carried;
}

double Step::coordinate_from(std::size_t joint) const {
  const Joint& of = tree_.system().joints[joint];
  return acting_coordinate(of, joint_geometry(of, from_), angles_[joint]);
}

std::vector<Vector6> Step::twists_at_end(const Configuration& to) const {
  std::vector<Vector6> twists = twists_;
  if (start_.gyroscopic) {
    for (const Link& link : tree_.links()) carry(at_->poses[link.body], to.poses[link.body], twists[link.body]);
  }
  const Kinematics end(tree_, to, start_.twists, VectorXd::Zero(tree_.freedoms()));
  return twists_at(end, gripped_rates(ArticulatedInertia(end), twists), start_.twists);
}

double Step::armature_energy(std::size_t number, const Configuration& to, const std::vector<Vector6>& twists) const {
  double energy = 0;
  for (const Armature& armature : laws_.armatures) {
    const Joint& of = tree_.system().joints[armature.joint];
    const std::size_t a = tree_.link_of(of.body_a), link = a == no_link ? tree_.link_of(of.body_b) : a;
    if (link < tree_.starts()[number] || link >= tree_.starts()[number + 1]) continue;
    const double rate = velocity(acting_row(of, to), twists);
    energy += 0.5 * armature.inertia * rate * rate;
  }
  return energy;
}

std::vector<double> Step::expected_end() const {
  std::vector<double> expected;
  const std::vector<Vector6> twists = twists_at(*kinematics_, mean(), start_.twists);
  for (std::size_t j = 0; j < angles_.size(); ++j) {
    const bool counts = counts_revolutions(tree_.system().joints[j].type);
    const double growth = counts ? start_.dt * velocity(acting_row(tree_.system().joints[j], *at_), twists) : 0;
    expected.push_back(coordinate_from(j) + growth);
  }
  return expected;
}

double Step::given_by_bends(std::size_t number, const Configuration& to) const {
  const std::vector<Vector6> straight = twists_at(*kinematics_, mean(), start_.twists);
  double work = 0;
  for (std::size_t i = tree_.starts()[number]; i < tree_.starts()[number + 1]; ++i) {
    const std::size_t body = tree_.link(i).body;
    const Vector3d displacement = start_.dt * straight[body].head<3>() - (to.poses[body].x - from_.poses[body].x);
    work += start_.wrenches[body].head<3>().dot(displacement);
  }
  return work;
}

Step::End Step::finish(const std::vector<Pose>& poses) {
  Configuration to = moved(tree_, from_, mean(), start_.twists, start_.dt);
  for (std::size_t body = 0; body < poses.size(); ++body) {
    if (tree_.link_of(body) == no_link) to.poses[body] = poses[body];
  }
  close_trees(tree_, to);
  const std::vector<double> expected = expected_end();
  const double open = close_loops(tree_, laws_.closures, nullptr, expected, to);
  if (!laws_.limits.empty()) close_loops(tree_, laws_.closures, &laws_.limits, expected, to);
  if (start_.gyroscopic) {
    for (const Link& link : tree_.links()) carry(at_->poses[link.body], to.poses[link.body], twists_[link.body]);
  }
  const Kinematics at(tree_, to, start_.twists, VectorXd::Zero(tree_.freedoms()));
  VectorXd rates = gripped_rates(ArticulatedInertia(at), twists_);
  rates = constrained_rates(at, closure_rows(laws_.closures, tree_, expected, to).rows, rates, start_.twists);
  End end = {to.poses, twists_at(at, rates, start_.twists), open};
  // loops have trees move together: none is scaled alone
  for (std::size_t t = 0; laws_.closures.empty() && t + 1 < tree_.starts().size(); ++t) {
    const Link& root = tree_.link(tree_.starts()[t]);
    if (root.joint == no_link || at.carried(tree_.starts()[t]) != Vector6::Zero()) continue;
    double energy = armature_energy(t, to, end.twists);
    for (std::size_t i = tree_.starts()[t]; i < tree_.starts()[t + 1]; ++i) {
      const Vector6& twist = end.twists[tree_.link(i).body];
      energy += 0.5 * twist.dot(at.momentum(i, twist));
    }
    const double given = given_by_bends(t, to);
    if (!(given > unfelt * energy)) continue;
    const double share = std::sqrt(std::max(0.25, 1 - given / energy));
    for (std::size_t i = tree_.starts()[t]; i < tree_.starts()[t + 1]; ++i) end.twists[tree_.link(i).body] *= share;
  }
  return end;
}

}  // namespace lockstep::oracle::articulated
