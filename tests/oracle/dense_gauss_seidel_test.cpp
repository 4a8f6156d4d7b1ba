// The dense solver against the textbook: W = J M^-1 J^T by Eigen, and a sweep over its rows in the order of the list,
// each contact solved by the oracle's own exact solution of a cone.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "cpu_reference/oracle/cone/local_cone.hpp"
#include "cpu_reference/solve_contact.hpp"
#include "tests/dense_scene.hpp"

namespace lockstep::test::dense_gauss_seidel_test {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

Vector3d vector_of(reference::Vec3<double> a) { return {a.x, a.y, a.z}; }
Matrix3d cross_matrix(const Vector3d& a) {
  return (Matrix3d() << 0, -a.z(), a.y(), a.z(), 0, -a.x(), -a.y(), a.x(), 0).finished();
}

struct Textbook {
  MatrixXd j, inverse_mass;  // rows of the contacts in their frames, M^-1
  VectorXd v, bias, r;       // velocities behind the warm start, impulses to start from
  std::vector<double> mu;

  explicit Textbook(const Buffers<double>& b) {
    const u32 contacts = b.counters[COUNTER_CONTACTS], bodies = u32(b.body_infos.size());
    j = MatrixXd::Zero(3 * contacts, 6 * bodies);
    inverse_mass = MatrixXd::Zero(6 * bodies, 6 * bodies);
    v = VectorXd::Zero(6 * bodies);
    bias = r = VectorXd::Zero(3 * contacts);
    for (u32 i = 0; i < bodies; ++i) {
      const Motion<double>& m = b.motions[i];
      v.segment<6>(6 * i) << m.v[0], m.v[1], m.v[2], m.w[0], m.w[1], m.w[2];
      inverse_mass.block<3, 3>(6 * i, 6 * i) = m.inverse_mass * Matrix3d::Identity();
      inverse_mass.block<3, 3>(6 * i + 3, 6 * i + 3) << m.inertia_xx, m.inertia_xy, m.inertia_xz, m.inertia_xy,
          m.inertia_yy, m.inertia_yz, m.inertia_xz, m.inertia_yz, m.inertia_zz;
    }
    for (u32 i = 0; i < contacts; ++i) {
      const u32 row = b.contact_slots[i] / PACK, lane = b.contact_slots[i] % PACK;
      const auto c = reference::contact_frame<double>(b.contact_blocks[row], lane);
      Matrix3d axes;
      axes << vector_of(c.normal), vector_of(c.tangent_1), vector_of(c.tangent_2);
      const auto add = [&](u32 body, const Vector3d& arm, double sign) {
        j.block<3, 3>(3 * i, 6 * body) += sign * axes.transpose();
        j.block<3, 3>(3 * i, 6 * body + 3) -= sign * axes.transpose() * cross_matrix(arm);
      };
      add(b.contacts[i].body_a, vector_of(c.arm_a), 1);
      add(b.contacts[i].body_b, vector_of(c.arm_b), -1);
      bias[3 * i] = b.contact_blocks[row].bias[lane];
      const auto start = reference::impulse_of(b.impulse_blocks[row], lane);
      r.segment<3>(3 * i) << start.normal, start.tangent_1, start.tangent_2;
      mu.push_back(b.contact_blocks[row].friction[lane]);
    }
  }

  void sweep(u32 sweeps) {
    const MatrixXd w = j * inverse_mass * j.transpose();
    const VectorXd start = r, q = j * v + bias - w * r;
    for (u32 k = 0; k < sweeps; ++k) {
      for (Eigen::Index i = 0; i < Eigen::Index(mu.size()); ++i) {
        const Matrix3d own = w.block<3, 3>(3 * i, 3 * i);
        const Vector3d free = q.segment<3>(3 * i) + w.middleRows<3>(3 * i) * r - own * r.segment<3>(3 * i);
        r.segment<3>(3 * i) = oracle::LocalCone(own, mu[std::size_t(i)]).solve(free);
      }
    }
    v += inverse_mass * j.transpose() * (r - start);
  }
};

// Sweep by sweep, a heap with friction, bodies of several contacts and some that cannot move.
TEST(DenseGaussSeidel, IsThatOfTheTextbook) {
  const InitialState<double> state = started_dense(heap<double>(11, 40, 1024), 1);
  ASSERT_GT(state.buffers.counters[COUNTER_CONTACTS], 60u);
  for (const u32 sweeps : {1u, 2u, 7u}) {
    InitialState<double> solved = state;
    solved.params.iterations = sweeps;
    reference::run_stage(Stage::solve_constraints, solved.buffers, solved.params);
    Textbook textbook(state.buffers);
    textbook.sweep(sweeps);
    const Textbook found(solved.buffers);
    EXPECT_LT((found.r - textbook.r).cwiseAbs().maxCoeff(), 1e-10 * textbook.r.cwiseAbs().maxCoeff()) << sweeps;
    EXPECT_LT((found.v - textbook.v).cwiseAbs().maxCoeff(), 1e-10 * textbook.v.cwiseAbs().maxCoeff()) << sweeps;
    EXPECT_GT((found.v - Textbook(state.buffers).v).cwiseAbs().maxCoeff(), 0.1);
  }
}

}  // namespace
}  // namespace lockstep::test::dense_gauss_seidel_test
