// Assemblies by divide and conquer against the articulated-body algorithm, and the models of reduced coordinates
// against Model-LCP in maximal ones.
#include "cpu_reference/oracle/articulated/dca_models.hpp"

#include <gtest/gtest.h>

#include "cpu_reference/oracle/lcp/solvers.hpp"
#include "cpu_reference/oracle/models/model_size.hpp"
#include "tests/oracle/articulated_trees.hpp"

namespace lockstep::oracle::articulated::dca_models_test {
namespace {

using test::Random;
using test::RandomTree;

TEST(DivideAndConquer, AssembliesAnswerAsTheArticulatedBodyAlgorithm) {
  for (unsigned seed = 0; seed < 10; ++seed) {
    RandomTree r(seed, 20);
    const Kinematics at(*r.tree, r.at, r.twists, r.rates);
    const ArticulatedInertia inertia(at);
    LinkVectors wrench, product;
    for (std::size_t i = 0; i < r.tree->size(); ++i) {
      wrench.push_back(r.random.vector6(1));
      product.push_back(r.tree->link(i).joint == no_link ? Vector6(Vector6::Zero()) : r.random.vector6(1));
    }
    const TreeResponse unpushed = inertia.solve(wrench, {}, product);
    for (std::size_t t = 0; t + 1 < r.tree->starts().size(); ++t) {
      const std::size_t first = r.tree->starts()[t], end = r.tree->starts()[t + 1];
      std::vector<std::size_t> handles;
      for (std::size_t k = 0; k < 3; ++k) handles.push_back(r.tree->link(first + r.random.below(end - first)).body);
      const Assembly a = assembled(at, t, wrench, product, handles);
      for (const std::size_t on : a.handles) {
        const std::size_t link = r.tree->link_of(on);
        EXPECT_LT((a.free.segment<6>(a.first_row(on)) - unpushed.twist[link]).norm(), 1e-12);
        for (int k = 0; k < 6; ++k) {
          LinkVectors pushed(r.tree->size(), Vector6::Zero());
          pushed[link] = Vector6::Unit(k);
          const TreeResponse response = inertia.solve(pushed);
          for (const std::size_t seen : a.handles) {
            const Vector6 twist = a.inverse_inertia.col(a.first_row(on) + k).segment<6>(a.first_row(seen));
            EXPECT_LT((twist - response.twist[r.tree->link_of(seen)]).norm(), 1e-12) << "seed " << seed;
          }
        }
      }
    }
  }
}

// A chain's pairs are joined side by side.
TEST(DivideAndConquer, ChainsAreJoinedInRoundsOfTheirLogarithm) {
  for (const auto& [links, rounds] : {std::pair(1, 0), std::pair(2, 1), std::pair(16, 4), std::pair(100, 7)}) {
    Random random(1);
    System system;
    system.bodies.assign(std::size_t(links), {1, {0.1, 0.1, 0.1}, true});
    for (std::size_t i = 0; i < std::size_t(links); ++i)
      system.joints.push_back(test::random_joint(random, JointType::ball, i == 0 ? world : i - 1, i));
    const Tree tree(system);
    Configuration at = {std::vector<Pose>(system.bodies.size()), std::vector<Coordinates>(tree.size())};
    close_trees(tree, at);
    const std::vector<Vector6> twists(system.bodies.size(), Vector6::Zero());
    const VectorXd rates = VectorXd::Zero(tree.freedoms());
    const Kinematics kinematics(tree, at, twists, rates);
    EXPECT_EQ(assembled(kinematics, 0, LinkVectors(tree.size(), Vector6::Zero()), {}, {0}).rounds, rounds) << links;
  }
}

// Bodies with contacts in random places, and dry friction in the first joints that have a coordinate.
struct Case {
  Case(unsigned seed, std::size_t bodies, std::size_t contacts, double friction) : r(seed, bodies) {
    StepStart start;
    start.poses = r.at.poses;
    start.poses.push_back({{0.3, -2, 1}, r.random.rotation()});  // a body without joints
    r.system.bodies.push_back({1.5, {0.2, 0.3, 0.4}, false});
    tree = std::make_unique<Tree>(r.system);
    const std::size_t all = start.poses.size();
    start.twists.assign(all, Vector6::Zero());
    start.wrenches.assign(all, Vector6::Zero());
    start.lone.resize(all);
    for (Vector6& twist : start.twists) twist = r.random.vector6(1);
    for (Vector6& wrench : start.wrenches) wrench = r.random.vector6(10);
    const Matrix3d rotation = start.poses.back().q.toRotationMatrix();
    start.lone.back() = {1 / 1.5, rotation * Vector3d(5, 1 / 0.3, 2.5).asDiagonal() * rotation.transpose()};
    start.dt = 0.01;
    start.theta = 1;
    step = std::make_unique<Step>(*tree, laws, start);
    for (std::size_t i = 0; i < contacts; ++i) {
      models::Contact c;
      c.body_a = 1 + r.random.below(all - 1);
      c.body_b = (c.body_a + 1 + r.random.below(all - 1)) % all;
      c.normal = r.random.vector(1).normalized();
      c.arm_a = r.random.vector(0.5);
      c.arm_b = r.random.vector(0.5);
      c.bias = r.random.between(-0.1, 0.1);
      c.friction = friction;
      demand.contacts.push_back(c);
    }
  }

  void add_joint_friction(double max_impulse) {
    for (std::size_t j = 0; j < r.system.joints.size() && demand.drives.size() < 3; ++j) {
      const JointType type = r.system.joints[j].type;
      if (type != JointType::fixed && type != JointType::ball) demand.drives.push_back({j, 0, max_impulse});
    }
  }

  // The same in maximal coordinates: the world is a further body.
  models::Multibody maximal() const {
    models::Multibody m;
    const Configuration& at = step->at();
    for (std::size_t i = 0; i < at.poses.size(); ++i) {
      const Body& body = r.system.bodies[i];
      models::Body to;
      to.v = step->twists()[i].head<3>();
      to.w = step->twists()[i].tail<3>();
      if (body.mass > 0) {
        const Matrix3d rotation = at.poses[i].q.toRotationMatrix();
        to.inverse_mass = 1 / body.mass;
        to.inverse_inertia = rotation * body.inertia.cwiseInverse().asDiagonal() * rotation.transpose();
        if (!body.is_link) to.inverse_inertia = step->given().lone[i].inverse_inertia;
      }
      m.bodies.push_back(to);
    }
    m.bodies.emplace_back();
    m.contacts = demand.contacts;
    const auto plain = [&](const Row& row) {
      const auto index = [&](std::size_t body) { return body == world ? at.poses.size() : body; };
      const Vector3d linear = row.body_b == world ? Vector3d(-row.on_a.head<3>()) : Vector3d(row.on_b.head<3>());
      return models::Row{index(row.body_b), index(row.body_a), linear, row.on_b.tail<3>(), row.on_a.tail<3>()};
    };
    for (const Joint& joint : r.system.joints) {
      for (const Row& row : rows_of(joint, at)) m.joint_rows.push_back({plain(row), -velocity(row, step->twists())});
    }
    for (const Drive& drive : demand.drives)
      m.dry_rows.push_back({plain(acting_row(r.system.joints[drive.joint], at)), drive.max_impulse});
    return m;
  }

  RandomTree r;
  std::unique_ptr<Tree> tree;
  Laws laws;
  std::unique_ptr<Step> step;
  Demand demand;
};

std::vector<Vector6> pushed(const Case& c, const ReducedProblem& problem, const VectorXd& impulses) {
  std::vector<Vector6> twists = c.step->twists(), wrenches(twists.size(), Vector6::Zero());
  VectorXd rates = VectorXd::Zero(c.tree->freedoms());
  add_impulses(problem.rows, impulses, wrenches);
  c.step->mobility().push(wrenches, twists, rates);
  return twists;
}

// Whether every row can be moved by its own impulse: where a tree holds a body fast, rounding alone is its mobility.
bool rows_are_mobile(const ReducedProblem& problem) {
  const VectorXd own = problem.w.diagonal();
  return own.minCoeff() > 1e-9 * own.maxCoeff();
}

double distance(const std::vector<Vector6>& twists, const VectorXd& velocities) {
  double most = 0;
  for (std::size_t i = 0; i < twists.size(); ++i)
    most = std::max(most, (twists[i] - velocities.segment<6>(6 * Index(i))).norm());
  return most;
}

// The problem of both coordinates is one: Model-LCP with joints eliminated, and Model-DCA-LCP.
TEST(DcaModels, TheLcpIsThatOfMaximalCoordinates) {
  for (unsigned seed = 0; seed < 8; ++seed) {
    Case c(seed, 6 + seed, 5, 0.4);
    c.add_joint_friction(0.05);
    const models::Multibody maximal = c.maximal();
    const lcp::Lcp by_rows = models::FrictionPyramid(maximal, 4).reduced();
    const AssembledProblem assembled = assembled_problem(*c.step, c.demand);
    const ReducedProblem by_links = reduced_problem(*c.step, c.demand);
    for (const ReducedProblem* problem : {&assembled.problem, &by_links}) {
      const lcp::Lcp reduced = ReducedPyramid(*problem, 4).lcp();
      ASSERT_EQ(reduced.size(), by_rows.size());
      EXPECT_LT((reduced.m - by_rows.m).norm(), 1e-13 * by_rows.m.norm()) << "seed " << seed;
      EXPECT_LT((reduced.q - by_rows.q).norm(), 1e-13 * by_rows.q.norm()) << "seed " << seed;
    }
  }
}

// Without friction velocities are unique.
TEST(DcaModels, AllComeToTheVelocitiesOfModelLcp) {
  int solved = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    Case c(seed + 50, 10, 6, 0);
    const models::Multibody maximal = c.maximal();
    const models::FrictionPyramid in_maximal(maximal, 4);
    VectorXd x;
    const Stop stop = lcp::lemke(in_maximal.reduced(), {.tolerance = 1e-12}, x).stop;
    if (stop == Stop::infeasible || !rows_are_mobile(reduced_problem(*c.step, c.demand))) continue;
    ASSERT_EQ(stop, Stop::solved) << "seed " << seed;
    ++solved;
    const VectorXd velocities = in_maximal.velocities(x);

    std::vector<std::size_t> bodies = touched(*c.tree, c.demand);
    const std::vector<std::size_t> ends = terminals(*c.tree);
    bodies.insert(bodies.end(), ends.begin(), ends.end());
    const AssembledProblem problem = assembled_problem(*c.step, c.demand, bodies);
    const ReducedPyramid pyramid(problem.problem, 4);
    VectorXd y;
    ASSERT_EQ(lcp::lemke(pyramid.lcp(), {.tolerance = 1e-12}, y).stop, Stop::solved) << "seed " << seed;
    EXPECT_LT(distance(pushed(c, problem.problem, pyramid.impulses(y)), velocities), 1e-12) << "seed " << seed;
  }
  EXPECT_GE(solved, 5);
}

// With their velocities eliminated, w = V_0 + Y x, the mixed models are the third.
TEST(DcaModels, MixedModelsAreTheLcpWithVelocitiesKept) {
  int solved = 0;
  for (unsigned seed = 0; seed < 8; ++seed) {
    Case c(seed + 50, 10, 6, 0.2);
    c.add_joint_friction(0.05);
    std::vector<std::size_t> bodies = touched(*c.tree, c.demand);
    const std::vector<std::size_t> ends = terminals(*c.tree);
    bodies.insert(bodies.end(), ends.begin(), ends.end());
    const AssembledProblem problem = assembled_problem(*c.step, c.demand, bodies);
    const ReducedPyramid pyramid(problem.problem, 4);
    const lcp::Lcp plain = pyramid.lcp();
    VectorXd x;
    const Stop stop = lcp::lemke(plain, {.tolerance = 1e-12}, x).stop;
    for (const models::MixedLcp& mixed : {dca_mlcp1(problem, pyramid, bodies), dca_mlcp2(problem, pyramid, ends)}) {
      EXPECT_LT((mixed.f + mixed.b * mixed.c - plain.m).norm(), 1e-12 * plain.m.norm()) << "seed " << seed;
      EXPECT_LT((mixed.a + mixed.b * mixed.r - plain.q).norm(), 1e-13 * plain.q.norm()) << "seed " << seed;
      if (stop != Stop::solved || !rows_are_mobile(problem.problem)) continue;
      VectorXd z;
      if (lcp::fischer_newton(mixed.stacked(), {.tolerance = 1e-12}, z).stop != Stop::solved) continue;
      ++solved;
      const std::vector<Vector6> twists = pushed(c, problem.problem, pyramid.impulses(z.head(pyramid.size())));
      const std::vector<Vector6> by_lemke = pushed(c, problem.problem, pyramid.impulses(x));
      for (std::size_t i = 0; i < twists.size(); ++i)
        EXPECT_LT((twists[i] - by_lemke[i]).norm(), 1e-10) << "seed " << seed << ", body " << i;
      EXPECT_LT((z.tail<6>() - twists[ends[1]]).norm(), 1e-10)
          << "seed " << seed << ": the velocity kept is the body's";
    }
  }
  EXPECT_GE(solved, 8) << "of 16, by a method without a promise on pyramids";
}

// One body touches at several points, two are touched, one joint of one degree of freedom rubs.
TEST(DcaModels, SizesAreThoseOfTheTable) {
  Case c(3, 12, 7, 0.4);
  c.add_joint_friction(0.1);
  for (const int directions : {4, 8}) {
    const auto bodies = touched(*c.tree, c.demand), ends = terminals(*c.tree);
    const models::ModelSizes sizes = models::model_sizes({.bodies = 13,
                                                          .touching_bodies = bodies.size(),
                                                          .joints = c.demand.drives.size(),
                                                          .contacts = 7,
                                                          .directions = std::size_t(directions)});
    std::vector<std::size_t> all = bodies;
    all.insert(all.end(), ends.begin(), ends.end());
    const AssembledProblem problem = assembled_problem(*c.step, c.demand, all);
    const ReducedPyramid pyramid(problem.problem, directions);
    EXPECT_EQ(Index(sizes.dca_lcp), pyramid.lcp().size());
    EXPECT_EQ(Index(sizes.dca_mlcp1), dca_mlcp1(problem, pyramid, all).stacked().size());
    EXPECT_EQ(Index(sizes.dca_mlcp2), dca_mlcp2(problem, pyramid, ends).stacked().size());
  }
}

}  // namespace
}  // namespace lockstep::oracle::articulated::dca_models_test
