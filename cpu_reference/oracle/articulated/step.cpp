#include "cpu_reference/oracle/articulated/step.hpp"

#include <cmath>

#include "cpu_reference/oracle/articulated/closing.hpp"

namespace lockstep::oracle::articulated {

namespace {

constexpr int most_iterations = 30;  // of the fixed point; a step that turns by little needs five

std::vector<Row> spring_rows(const std::vector<Spring>& springs, const Tree& tree, const Configuration& at) {
  std::vector<Row> rows;
  for (const Spring& spring : springs) rows.push_back(acting_row(tree.system().joints[spring.joint], at));
  return rows;
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

VectorXd held_rates(const Kinematics& at, const std::vector<Row>& rows, const VectorXd& rates,
                    const std::vector<Vector6>& twists) {
  if (rows.empty()) return rates;
  const ArticulatedInertia inertia(at);
  const std::vector<LoneBody> lone(twists.size());
  const Mobility mobility(inertia, lone);
  const BilateralRows bilateral(jacobian(rows, twists.size()) * mobility.answers(rows), mobility.unheld(rows));
  std::vector<Vector6> wrenches(twists.size(), Vector6::Zero()), changed = twists;
  add_impulses(rows, bilateral.answer(velocities(rows, twists_at(at, rates, twists))), wrenches);
  VectorXd held = rates;
  mobility.push(wrenches, changed, held);
  return held;
}

Step::Step(const Tree& tree, const Laws& laws, StepStart start)
    : tree_(tree), laws_(laws), start_(std::move(start)), from_(measured(tree, start_.poses)) {
  close_loops(tree_, laws_.closures, nullptr, from_);
  const VectorXd none = VectorXd::Zero(tree_.freedoms());
  const Kinematics still(tree_, from_, start_.twists, none);
  old_rates_ = gripped_rates(ArticulatedInertia(still), start_.twists);
  old_rates_ = held_rates(still, closure_rows(laws_.closures, tree_, from_).rows, old_rates_, start_.twists);

  VectorXd change = none, best = none;
  double least = -1;
  for (int i = 0; i < most_iterations; ++i) {
    accelerate(change);
    const VectorXd next = rates_ - old_rates_;
    const double moved_by = (next - change).norm();
    change = next;
    if (moved_by <= 1e-14 * (old_rates_.norm() + next.norm())) return;
    if (least >= 0 && moved_by > 2 * least) break;  // turns too far in a step to converge
    if (least < 0 || moved_by < least) least = moved_by, best = next;
  }
  accelerate(best);
}

void Step::accelerate(const VectorXd& change) {
  const double h = start_.dt, lead = 2 * start_.theta * (1 - start_.theta) * h;
  const bool leads = lead > 0;
  at_ = std::make_unique<Configuration>(leads ? moved(tree_, from_, old_rates_ + 0.5 * change, start_.twists, lead)
                                              : from_);
  kinematics_ = std::make_unique<Kinematics>(tree_, *at_, start_.twists, old_rates_ + 0.5 * change);
  inertia_ = std::make_unique<ArticulatedInertia>(*kinematics_);
  impulses_.assign(start_.poses.size(), Vector6::Zero());
  LinkVectors on_links(tree_.size());
  products_.resize(tree_.size());
  for (std::size_t i = 0; i < tree_.size(); ++i) {
    const std::size_t body = tree_.link(i).body;
    impulses_[body] = h * start_.wrenches[body];
    if (start_.gyroscopic) impulses_[body] -= h * kinematics_->gyroscopic(i);
    on_links[i] = impulses_[body];
    products_[i] = h * kinematics_->link(i).product;
  }
  rates_ = old_rates_ + inertia_->solve(on_links, {}, products_).rates;
  twists_ = twists_at(*kinematics_, rates_, start_.twists);

  bilateral_rows_ = closure_rows(laws_.closures, tree_, *at_).rows;
  const std::size_t closures = bilateral_rows_.size();
  for (const Row& row : spring_rows(laws_.springs, tree_, *at_)) bilateral_rows_.push_back(row);
  bilateral_impulses_ = VectorXd::Zero(Index(bilateral_rows_.size()));
  if (bilateral_rows_.empty()) return;
  MatrixXd r = jacobian(bilateral_rows_, twists_.size()) * mobility().answers(bilateral_rows_);
  VectorXd s = velocities(bilateral_rows_, twists_);
  if (leads)
    s.head(Index(closures)) +=
        velocities(bilateral_rows_, twists_at(*kinematics_, old_rates_, start_.twists)).head(Index(closures));
  for (std::size_t i = 0; i < laws_.springs.size(); ++i) {
    const Spring& spring = laws_.springs[i];
    const Joint& joint = tree_.system().joints[spring.joint];
    const double x = acting_coordinate(joint, stand(joint, pose_of(from_, joint.body_a), pose_of(from_, joint.body_b)));
    s[Index(closures + i)] += spring.rate * (x - spring.rest);
    r(Index(closures + i), Index(closures + i)) += spring.yield;
  }
  bilateral_ = BilateralRows(r, mobility().unheld(bilateral_rows_));
  const VectorXd impulses = bilateral_.answer(s);
  push({}, {}, impulses);
}

void Step::push(const std::vector<Row>& rows, const VectorXd& impulses, const VectorXd& bilateral_impulses) {
  std::vector<Vector6> wrenches(twists_.size(), Vector6::Zero());
  add_impulses(rows, impulses, wrenches);
  add_impulses(bilateral_rows_, bilateral_impulses, wrenches);
  mobility().push(wrenches, twists_, rates_);
  for (std::size_t body = 0; body < wrenches.size(); ++body) impulses_[body] += wrenches[body];
  bilateral_impulses_ += bilateral_impulses;
}

LinkVectors Step::carried() const {
  LinkVectors on_links(tree_.size());
  for (std::size_t i = 0; i < tree_.size(); ++i) on_links[i] = impulses_[tree_.link(i).body];
  return inertia_->solve(on_links, {}, products_).carried;
}

Step::End Step::finish(const std::vector<Pose>& poses) {
  const VectorXd mean = (1 - start_.theta) * old_rates_ + start_.theta * rates_;
  Configuration to = moved(tree_, from_, mean, start_.twists, start_.dt);
  for (std::size_t body = 0; body < poses.size(); ++body) {
    if (tree_.link_of(body) == no_link) to.poses[body] = poses[body];
  }
  close_trees(tree_, to);
  Closed closed = close_loops(tree_, laws_.closures, nullptr, to);
  if (start_.theta == 1) rates_ += closed.way / start_.dt;
  if (!laws_.limits.empty()) closed = close_loops(tree_, laws_.closures, &laws_.limits, to);
  const Kinematics at(tree_, to, start_.twists, rates_);
  rates_ = held_rates(at, closure_rows(laws_.closures, tree_, to).rows, rates_, start_.twists);
  return {to.poses, twists_at(at, rates_, start_.twists), closed.open};
}

}  // namespace lockstep::oracle::articulated
