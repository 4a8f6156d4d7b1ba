// Random trees of bodies and joints of every kind, for the tests of articulated bodies.
#pragma once

#include <algorithm>
#include <memory>
#include <random>

#include "cpu_reference/oracle/articulated/articulated_inertia.hpp"

namespace lockstep::oracle::articulated::test {

constexpr JointType tree_types[] = {JointType::fixed,  JointType::hinge, JointType::slider,    JointType::cylindrical,
                                    JointType::planar, JointType::ball,  JointType::universal, JointType::screw};

class Random {
 public:
  explicit Random(unsigned seed) : engine_(seed) {}
  double between(double low, double high) { return std::uniform_real_distribution<double>(low, high)(engine_); }
  std::size_t below(std::size_t n) { return engine_() % n; }
  Vector3d vector(double size) { return {between(-size, size), between(-size, size), between(-size, size)}; }
  Vector6 vector6(double size) { return spatial(vector(size), vector(size)); }
  Quaterniond rotation() {
    return Quaterniond(between(0.1, 1), between(-1, 1), between(-1, 1), between(-1, 1)).normalized();
  }
  VectorXd values(Index n, double size) {
    VectorXd v(n);
    for (double& x : v) x = between(-size, size);
    return v;
  }

 private:
  std::mt19937 engine_;
};

inline Joint random_joint(Random& random, JointType type, std::size_t a, std::size_t b) {
  return {a, b, type, random.vector(1), random.vector(1), random.rotation(), random.rotation(), random.between(0.2, 1)};
}

/// A tree of moving bodies, body 0 being one that moves by itself; of three roots one hangs from the world, one from
/// body 0 and one is free.
struct RandomTree {
  RandomTree(unsigned seed, std::size_t bodies) : random(seed) {
    system.bodies.push_back({});
    for (std::size_t i = 1; i <= bodies; ++i) {
      const Vector3d squares = random.vector(1).cwiseAbs() + Vector3d::Constant(0.1);
      system.bodies.push_back({random.between(0.5, 3), Vector3d::Constant(squares.sum()) - squares, true});
      const JointType type = tree_types[random.below(std::size(tree_types))];
      if (i % 9 == 7) continue;  // a free root
      const std::size_t parent = i == 1 ? world : i == 2 ? 0 : 1 + random.below(i - 1);
      if (random.below(2) == 0)
        system.joints.push_back(random_joint(random, type, parent, i));
      else
        system.joints.push_back(random_joint(random, type, i, parent));
    }
    tree = std::make_unique<Tree>(system);
    at.poses.resize(system.bodies.size());
    for (Pose& pose : at.poses) pose = {random.vector(2), random.rotation()};
    at.coordinates.resize(tree->size());
    for (Coordinates& c : at.coordinates) c = {random.vector(1), random.rotation()};
    close_trees(*tree, at);
    twists.assign(system.bodies.size(), Vector6::Zero());
    twists[0] = random.vector6(1);
    rates = random.values(tree->freedoms(), 1);
  }

  Random random;
  System system;
  std::unique_ptr<Tree> tree;
  Configuration at;
  std::vector<Vector6> twists;
  VectorXd rates;
};

}  // namespace lockstep::oracle::articulated::test
