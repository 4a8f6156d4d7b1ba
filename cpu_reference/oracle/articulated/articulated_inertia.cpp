#include "cpu_reference/oracle/articulated/articulated_inertia.hpp"

#include <Eigen/Cholesky>

namespace lockstep::oracle::articulated {

ArticulatedInertia::ArticulatedInertia(const Kinematics& at) : at_(at), factors_(at.tree().size()) {
  const Tree& tree = at.tree();
  for (std::size_t i = 0; i < tree.size(); ++i) {
    factors_[i].inertia.setZero();
    factors_[i].inertia.topLeftCorner<3, 3>().diagonal().setConstant(tree.system().bodies[tree.link(i).body].mass);
    factors_[i].inertia.bottomRightCorner<3, 3>() = at.link(i).inertia;
  }
  for (std::size_t i = tree.size(); i-- > 0;) {
    const Link& link = tree.link(i);
    const LinkKinematics& k = at.link(i);
    Factor& f = factors_[i];
    f.response = f.inertia * k.motion;
    const Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 6, 6> d = k.motion.transpose() * f.response;
    f.inverse.setIdentity(link.freedoms, link.freedoms);
    if (link.freedoms == 1)
      f.inverse(0, 0) = 1 / d(0, 0);
    else if (link.freedoms > 1)
      f.inverse = d.llt().solve(f.inverse.eval());
    if (link.parent == no_link) continue;
    const Matrix6 x = shift(k.from_parent);
    const Matrix6 left = f.inertia - f.response * f.inverse * f.response.transpose();
    factors_[link.parent].inertia += x.transpose() * left * x;
  }
}

void ArticulatedInertia::solve_tree(std::size_t number, const LinkVectors& wrench, const VectorXd& effort,
                                    const LinkVectors& product, TreeResponse& response) const {
  const Tree& tree = at_.tree();
  const std::size_t first = tree.starts()[number], end = tree.starts()[number + 1];
  // `carried` holds p, `twist` is not known yet and `rates` hold u
  for (std::size_t i = first; i < end; ++i) response.carried[i] = -wrench[i];
  for (std::size_t i = end; i-- > first;) {
    const Link& link = tree.link(i);
    const LinkKinematics& k = at_.link(i);
    const Factor& f = factors_[i];
    auto u = response.rates.segment(link.first, link.freedoms);
    u = -k.motion.transpose() * response.carried[i];
    if (effort.size() > 0) u += effort.segment(link.first, link.freedoms);
    if (link.parent == no_link) continue;
    Vector6 up = response.carried[i] + f.response * (f.inverse * u);
    if (!product.empty())
      up += f.inertia * product[i] - f.response * (f.inverse * (f.response.transpose() * product[i]));
    response.carried[link.parent] += wrench_from(up, k.from_parent);
  }
  for (std::size_t i = first; i < end; ++i) {
    const Link& link = tree.link(i);
    const LinkKinematics& k = at_.link(i);
    const Factor& f = factors_[i];
    Vector6 twist =
        link.parent == no_link ? Vector6(Vector6::Zero()) : twist_at(response.twist[link.parent], k.from_parent);
    if (!product.empty()) twist += product[i];
    auto rates = response.rates.segment(link.first, link.freedoms);
    rates = (f.inverse * (rates - f.response.transpose() * twist)).eval();
    response.twist[i] = twist + k.motion * rates;
    response.carried[i] += f.inertia * response.twist[i];
  }
}

TreeResponse ArticulatedInertia::solve(const LinkVectors& wrench, const VectorXd& effort,
                                       const LinkVectors& product) const {
  const Tree& tree = at_.tree();
  TreeResponse response = {VectorXd::Zero(tree.freedoms()), LinkVectors(tree.size(), Vector6::Zero()),
                           LinkVectors(tree.size(), Vector6::Zero())};
  for (std::size_t t = 0; t + 1 < tree.starts().size(); ++t) solve_tree(t, wrench, effort, product, response);
  return response;
}

VectorXd gripped_rates(const ArticulatedInertia& inertia, const std::vector<Vector6>& twists) {
  const Kinematics& at = inertia.at();
  const Tree& tree = at.tree();
  LinkVectors momentum, carried;
  for (std::size_t i = 0; i < tree.size(); ++i) {
    momentum.push_back(at.momentum(i, twists[tree.link(i).body]));
    carried.push_back(at.carried(i));
  }
  return inertia.solve(momentum, {}, carried).rates;
}

}  // namespace lockstep::oracle::articulated
