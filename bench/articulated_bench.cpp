// Featherstone's articulated-body algorithm and its divide-and-conquer form against the dense equations in reduced
// coordinates: the accelerations of a hanging chain of hinges in turn about two axes, by its length.
//
//   articulated_bench > bench/results/MACHINE/articulated.csv
//
// Times are medians of 21 runs, us, kinematics included; `dense` makes M = J^T M J and factors it; `off` is the largest
// difference of their accelerations, as a share; `rounds` are the joins of the divide-and-conquer form that wait for
// each other (here they are done one after another).
#include <fmt/format.h>

#include <algorithm>
#include <chrono>

#include "bench/median.hpp"
#include "cpu_reference/oracle/articulated/assembly.hpp"
#include "cpu_reference/oracle/dense.hpp"

namespace {

using namespace lockstep::oracle;
using namespace lockstep::oracle::articulated;

System chain(std::size_t links) {
  System system;
  for (std::size_t i = 0; i < links; ++i) {
    system.bodies.push_back({1, {0.02, 0.03, 0.04}, true});
    Joint joint;
    joint.body_a = i == 0 ? world : i - 1;
    joint.body_b = i;
    joint.type = JointType::hinge;
    joint.anchor_a = i == 0 ? Vector3d(Vector3d::Zero()) : Vector3d(0.25, 0, 0);
    joint.anchor_b = {-0.25, 0, 0};
    if (i % 2 == 1) joint.frame_a = joint.frame_b = Quaterniond(1, 1, 0, 0).normalized();
    system.joints.push_back(joint);
  }
  return system;
}

template <class Work>
double median_us(Work&& work) {
  std::vector<double> times;
  for (int i = 0; i < 21; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    times.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - start).count());
  }
  return lockstep::bench::median(times);
}

VectorXd dense(const Kinematics& at, const LinkVectors& wrench) {
  const Tree& tree = at.tree();
  const Index n = tree.freedoms();
  MatrixXd m = MatrixXd::Zero(n, n);
  VectorXd right = VectorXd::Zero(n);
  LinkVectors products(tree.size());
  MatrixXd j = MatrixXd::Zero(6 * Index(tree.size()), n);
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    products[i] = at.link(i).product;
    if (link.parent != no_link) {
      j.middleRows<6>(6 * Index(i)) = shift(at.link(i).from_parent) * j.middleRows<6>(6 * Index(link.parent));
      products[i] += twist_at(products[link.parent], at.link(i).from_parent);
    }
    j.block(6 * Index(i), link.first, 6, link.freedoms) += at.link(i).motion;
    MatrixXd momenta(6, n);
    for (Index k = 0; k < n; ++k) momenta.col(k) = at.momentum(i, j.block<6, 1>(6 * Index(i), k));
    m += transposed_product(j.middleRows<6>(6 * Index(i)), momenta);
    right += j.middleRows<6>(6 * Index(i)).transpose() * (wrench[i] - at.momentum(i, products[i]));
  }
  return solve_by_lu(m, right);
}

}  // namespace

int main() {
  fmt::print("links,aba_us,dca_us,dense_us,off,rounds\n");
  for (const std::size_t links : {4u, 16u, 64u, 256u, 1024u}) {
    const System system = chain(links);
    const Tree tree(system);
    Configuration at = {std::vector<Pose>(links), std::vector<Coordinates>(links)};
    VectorXd rates(tree.freedoms());
    for (std::size_t i = 0; i < links; ++i) {
      at.coordinates[i].value[0] = 0.1 * double(i % 7) - 0.3;
      rates[Index(i)] = 0.2 * double(i % 5) - 0.4;
    }
    close_trees(tree, at);
    const std::vector<Vector6> twists(links, Vector6::Zero());
    const LinkVectors wrench(links, spatial({0, 0, -9.81}, Vector3d::Zero()));
    const auto products = [&](const Kinematics& k) {
      LinkVectors all;
      for (std::size_t i = 0; i < links; ++i) all.push_back(k.link(i).product);
      return all;
    };
    VectorXd by_aba, by_dense;
    Assembly whole;
    const double aba = median_us([&] {
      const Kinematics k(tree, at, twists, rates);
      by_aba = ArticulatedInertia(k).solve(wrench, {}, products(k)).rates;
    });
    const double dca = median_us([&] {
      const Kinematics k(tree, at, twists, rates);
      whole = assembled(k, 0, wrench, products(k), {0, links - 1});
    });
    double direct = 0, off = 0;
    if (links <= 256) {
      direct = median_us([&] { by_dense = dense(Kinematics(tree, at, twists, rates), wrench); });
      off = (by_aba - by_dense).norm() / by_dense.norm();
    }
    fmt::print("{},{:.1f},{:.1f},{},{},{}\n", links, aba, dca, links <= 256 ? fmt::format("{:.1f}", direct) : "",
               links <= 256 ? fmt::format("{:.1g}", off) : "", whole.rounds);
  }
  return 0;
}
