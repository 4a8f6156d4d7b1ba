// Articulated bodies: joints and kinematics against differences, Featherstone's algorithm against the dense equations
// in reduced coordinates and against those of maximal coordinates.
#include <gtest/gtest.h>

#include "cpu_reference/oracle/articulated/closing.hpp"
#include "cpu_reference/oracle/dense.hpp"
#include "tests/oracle/articulated_trees.hpp"

namespace lockstep::oracle::articulated::articulated_test {
namespace {

using test::Random;
using test::RandomTree;

double distance(const Pose& a, const Pose& b) { return (a.x - b.x).norm() + a.q.angularDistance(b.q); }

TEST(ArticulatedJoints, CoordinatesAndPosesAreEachOthersInverse) {
  Random random(3);
  for (const JointType type : test::tree_types) {
    for (int i = 0; i < 50; ++i) {
      const Joint joint = test::random_joint(random, type, 0, 1);
      const Pose a = {random.vector(2), random.rotation()};
      Coordinates c = {3 * random.vector(1), random.rotation()};
      if (type == JointType::screw) c.value[0] *= 10;  // whole turns
      const Pose b = pose_of_b(joint, a, c);
      EXPECT_LT(distance(pose_of_a(joint, b, c), a), 1e-12) << int(type);
      const JointGeometry at = joint_geometry(joint, a, b);
      EXPECT_LT(locked_rows(joint, at).error.norm(), 1e-13) << int(type);
      EXPECT_LT(distance(pose_of_b(joint, a, measured(joint, at)), b), 1e-12) << int(type);
      EXPECT_LT((pose_of_b(joint, a, measured(joint, at)).x - b.x).norm(), 1e-13) << int(type);
    }
  }
}

// What a joint locks and what it leaves free are each other's complement.
TEST(ArticulatedJoints, LockWhatTheyDoNotLeaveFree) {
  Random random(4);
  for (const JointType type : test::tree_types) {
    const Joint joint = test::random_joint(random, type, 0, 1);
    const Pose a = {random.vector(2), random.rotation()};
    const JointGeometry at = joint_geometry(joint, a, pose_of_b(joint, a, {random.vector(1), random.rotation()}));
    const LockedRows locked = locked_rows(joint, at);
    EXPECT_EQ(__builtin_popcount(locked.mask) + freedoms(type), 6) << int(type);
    EXPECT_LT((locked.wrench.transpose() * motion_axes(joint, at)).norm(), 1e-14) << int(type);
  }
}

// The error of a locked row changes at the row's velocity, and so does the acting coordinate.
TEST(ArticulatedJoints, RowsAreTheDerivativesOfErrors) {
  Random random(5);
  const double h = 1e-6;
  for (int type = 0; type <= int(JointType::distance); ++type) {
    const Joint joint = test::random_joint(random, JointType(type), 0, 1);
    const Pose a = {random.vector(2), random.rotation()};
    Configuration at = {{a, pose_of_b(joint, a, {random.vector(1), random.rotation()})}, {}};
    if (joint.type == JointType::distance) at.poses[1].x += random.vector(1);
    const System system = {{{}, {}}, {joint}};
    const Tree none(system);
    const std::vector<Vector6> twists = {random.vector6(1), random.vector6(1)};
    const std::vector<Closure> closures = {{0, true, type != int(JointType::fixed) && type != int(JointType::ball)}};
    const ErrorRows rows = closure_rows(closures, none, {0}, at);
    const ErrorRows later = closure_rows(closures, none, {0}, moved(none, at, VectorXd(), twists, h));
    const ErrorRows sooner = closure_rows(closures, none, {0}, moved(none, at, VectorXd(), twists, -h));
    for (std::size_t i = 0; i < rows.rows.size(); ++i)
      EXPECT_NEAR((later.errors[i] - sooner.errors[i]) / (2 * h), velocity(rows.rows[i], twists), 1e-8)
          << type << ", row " << i;
  }
}

TEST(ArticulatedKinematics, TwistsAndProductsAreDerivatives) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    RandomTree r(seed, 25);
    const double h = 1e-5;
    const Configuration later = moved(*r.tree, r.at, r.rates, r.twists, h),
                        sooner = moved(*r.tree, r.at, r.rates, r.twists, -h);
    const Kinematics current(*r.tree, r.at, r.twists, r.rates), then(*r.tree, later, r.twists, r.rates),
        before(*r.tree, sooner, r.twists, r.rates);
    std::vector<Vector6> acceleration(r.tree->size());
    for (std::size_t i = 0; i < r.tree->size(); ++i) {
      const Link& link = r.tree->link(i);
      const LinkKinematics& k = current.link(i);
      const Vector3d v = (later.poses[link.body].x - sooner.poses[link.body].x) / (2 * h);
      EXPECT_LT((v - k.twist.head<3>()).norm(), 1e-8 * (1 + k.twist.norm()));
      const Quaterniond rotation = later.poses[link.body].q * sooner.poses[link.body].q.conjugate();
      const Vector3d w = (rotation.w() < 0 ? -1 : 1) * rotation.vec() / h;
      EXPECT_LT((w - k.twist.tail<3>()).norm(), 1e-8 * (1 + k.twist.norm()));
      acceleration[i] = k.product;
      if (link.parent != no_link) acceleration[i] += twist_at(acceleration[link.parent], k.from_parent);
      const Vector6 difference = (then.link(i).twist - before.link(i).twist) / (2 * h);
      EXPECT_LT((difference - acceleration[i]).norm(), 1e-8 * (1 + acceleration[i].norm())) << "seed " << seed;
    }
  }
}

struct Question {
  explicit Question(RandomTree& r) : effort(r.random.values(r.tree->freedoms(), 1)) {
    for (std::size_t i = 0; i < r.tree->size(); ++i) {
      wrench.push_back(r.random.vector6(1));
      product.push_back(r.tree->link(i).joint == no_link ? Vector6(Vector6::Zero()) : r.random.vector6(1));
    }
  }
  LinkVectors wrench, product;
  VectorXd effort;
};

// Twists of all links, 6 after another, by unit rates: J of V = J rates. And those of the products alone.
MatrixXd link_jacobian(const Kinematics& at) {
  const Tree& tree = at.tree();
  MatrixXd j = MatrixXd::Zero(6 * Index(tree.size()), tree.freedoms());
  for (std::size_t i = 0; i < tree.size(); ++i) {
    const Link& link = tree.link(i);
    const LinkKinematics& k = at.link(i);
    if (link.parent != no_link)
      j.middleRows(6 * Index(i), 6) = shift(k.from_parent) * j.middleRows(6 * Index(link.parent), 6);
    j.block(6 * Index(i), link.first, 6, link.freedoms) += k.motion;
  }
  return j;
}

MatrixXd masses(const Kinematics& at) {
  const Index n = 6 * Index(at.tree().size());
  MatrixXd m = MatrixXd::Zero(n, n);
  for (Index i = 0; i < n; ++i) m.col(i).segment<6>(i / 6 * 6) = at.momentum(std::size_t(i / 6), Vector6::Unit(i % 6));
  return m;
}

VectorXd stacked(const LinkVectors& vectors) {
  VectorXd all(6 * Index(vectors.size()));
  for (std::size_t i = 0; i < vectors.size(); ++i) all.segment<6>(6 * Index(i)) = vectors[i];
  return all;
}

TEST(ArticulatedBodies, SolveTheDenseEquationsOfMotion) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomTree r(seed, 3 + 2 * seed);
    const Kinematics at(*r.tree, r.at, r.twists, r.rates);
    const Question q(r);
    const TreeResponse response = ArticulatedInertia(at).solve(q.wrench, q.effort, q.product);
    // M a = J^T (F - M A_0) + t, with A_0 the twists of the products alone
    LinkVectors products(q.product);
    for (std::size_t i = 0; i < r.tree->size(); ++i) {
      if (r.tree->link(i).parent != no_link)
        products[i] += twist_at(products[r.tree->link(i).parent], at.link(i).from_parent);
    }
    const MatrixXd j = link_jacobian(at), m = masses(at);
    const VectorXd right = j.transpose() * (stacked(q.wrench) - m * stacked(products)) + q.effort;
    const VectorXd rates = solve_by_lu(MatrixXd(j.transpose() * m * j), right);
    EXPECT_LT((response.rates - rates).norm(), 1e-13 * (1 + rates.norm())) << "seed " << seed;
    const VectorXd twists = j * rates + stacked(products);
    EXPECT_LT((stacked(response.twist) - twists).norm(), 1e-13 * (1 + twists.norm())) << "seed " << seed;
  }
}

// M A = F + G^T l, G A = what products make of it: each joint's locked rows in maximal coordinates.
TEST(ArticulatedBodies, SolveTheEquationsOfMaximalCoordinates) {
  for (unsigned seed = 0; seed < 20; ++seed) {
    RandomTree r(seed + 100, 3 + 2 * seed);
    const Kinematics at(*r.tree, r.at, r.twists, r.rates);
    Question q(r);
    q.effort.setZero();
    const TreeResponse response = ArticulatedInertia(at).solve(q.wrench, q.effort, q.product);
    std::vector<Row> rows;
    std::vector<double> right;
    for (std::size_t i = 0; i < r.tree->size(); ++i) {
      const Link& link = r.tree->link(i);
      if (link.joint == no_link) continue;
      for (const Row& row : rows_of(r.tree->joint_of(link), r.at)) {
        rows.push_back(row);
        right.push_back((link.child_is_b ? row.on_b : row.on_a).dot(q.product[i]));
      }
    }
    const MatrixXd whole = jacobian(rows, r.at.poses.size());
    MatrixXd g(whole.rows(), 6 * Index(r.tree->size()));
    for (std::size_t i = 0; i < r.tree->size(); ++i)
      g.middleCols(6 * Index(i), 6) = whole.middleCols(6 * Index(r.tree->link(i).body), 6);
    const Index n = g.cols(), m = g.rows();
    MatrixXd kkt = MatrixXd::Zero(n + m, n + m);
    kkt.topLeftCorner(n, n) = masses(at);
    kkt.topRightCorner(n, m) = -g.transpose();
    kkt.bottomLeftCorner(m, n) = g;
    VectorXd f(n + m);
    f << stacked(q.wrench), Eigen::Map<const VectorXd>(right.data(), m);
    const VectorXd x = solve_by_lu(kkt, f);
    EXPECT_LT((stacked(response.twist) - x.head(n)).norm(), 1e-12 * (1 + x.head(n).norm())) << "seed " << seed;
    // what a joint carries is what its rows push the child with
    for (std::size_t i = 0, row = 0; i < r.tree->size(); ++i) {
      const Link& link = r.tree->link(i);
      if (link.joint == no_link) continue;
      Vector6 carried = Vector6::Zero();
      const Index locked = 6 - link.freedoms;
      for (Index k = 0; k < locked; ++k, ++row)
        carried += x[n + Index(row)] * (link.child_is_b ? rows[row].on_b : rows[row].on_a);
      EXPECT_LT((response.carried[i] - carried).norm(), 1e-12 * (1 + x.tail(m).norm())) << "seed " << seed;
    }
  }
}

TEST(ArticulatedBodies, GrippedTwistsThatObeyTheJointsStay) {
  RandomTree r(7, 30);
  const Kinematics moving(*r.tree, r.at, r.twists, r.rates);
  std::vector<Vector6> twists = r.twists;
  for (std::size_t i = 0; i < r.tree->size(); ++i) twists[r.tree->link(i).body] = moving.link(i).twist;
  const Kinematics still(*r.tree, r.at, twists, VectorXd::Zero(r.tree->freedoms()));
  EXPECT_LT((gripped_rates(ArticulatedInertia(still), twists) - r.rates).norm(), 1e-12 * r.rates.norm());
}

}  // namespace
}  // namespace lockstep::oracle::articulated::articulated_test
