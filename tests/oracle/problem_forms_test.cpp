// The forms that contact problems of others have in files: global texts in every storage, matrices of which a triangle
// is stored, rolling friction.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <fstream>
#include <random>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "host/problems/cone_file.hpp"
#include "host/record/whole_file.hpp"
#include "tests/oracle/cone_problems.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::problem_forms_test {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;
using oracle::ConeProblem;
using oracle::GlobalConeProblem;
using oracle::SparseMatrix;

std::string numbers(const VectorXd& values) {
  std::string text;
  for (const double value : values) text += fmt::format(" {:.17g}", value);
  return text + "\n";
}

std::string dense(const MatrixXd& m) {
  return fmt::format("0\n{0} {1}\n{0} {1}\n", m.rows(), m.cols()) +
         numbers(Eigen::Map<const VectorXd>(m.data(), m.size()));
}

// As one block, which every matrix is.
std::string one_block(const MatrixXd& m) {
  return fmt::format("1\n{0}\n{1}\n1 1 1\n{0}\n{1}\n2 1\n0 1\n0\n0\n", m.rows(), m.cols()) +
         numbers(Eigen::Map<const VectorXd>(m.data(), m.size()));
}

std::string triplets(const SparseMatrix& m) {
  std::string text = fmt::format("2\n{0}\n{1}\n1\nCSparse Version 3.1.9\ntriplet: {0}-by-{1}, nzmax: {2} nnz: {2}\n",
                                 m.rows(), m.cols(), m.nonZeros());
  for (int k = 0; k < m.outerSize(); ++k) {
    for (SparseMatrix::InnerIterator entry(m, k); entry; ++entry)
      text += fmt::format("    {} {} : {:.17g}\n", entry.row(), entry.col(), entry.value());
  }
  return text;
}

// `kind` 2: columns of m, 3: rows, which are the columns of its transpose.
std::string compressed(const SparseMatrix& m, int kind) {
  const SparseMatrix lines = kind == 2 ? m : SparseMatrix(m.transpose());
  std::string text =
      fmt::format("2\n{0}\n{1}\n{2}\nCSparse Version 3.1.9\n{3}{0}-by-{1}, nzmax: {4} nnz: {4}, 1-norm: 1\n", m.rows(),
                  m.cols(), kind, kind == 3 ? "csr: " : "", m.nonZeros());
  Eigen::Index first = 0;
  for (int k = 0; k < lines.outerSize(); ++k) {
    const Eigen::Index count = SparseMatrix(lines.col(k)).nonZeros();
    text += fmt::format("    {} {} : locations {} to {}\n", kind == 2 ? "col" : "row", k, first, first + count - 1);
    first += count;
    for (SparseMatrix::InnerIterator entry(lines, k); entry; ++entry)
      text += fmt::format("      {} : {:.17g}\n", entry.row(), entry.value());
  }
  return text;
}

// Bodies whose masses are coupled, so that M has two triangles.
GlobalConeProblem coupled_heap() {
  GlobalConeProblem problem = oracle::random_heap(3, 5, 0.4, 2);
  for (Eigen::Index i = 0; i + 1 < problem.m.rows(); ++i) {
    const double both = 0.3 * std::sqrt(problem.m.coeff(i, i) * problem.m.coeff(i + 1, i + 1));
    problem.m.coeffRef(i, i + 1) = both;
    problem.m.coeffRef(i + 1, i) = both;
  }
  problem.m.makeCompressed();
  return problem;
}

class ProblemForms : public testing::Test {
 protected:
  ConeFile read(const std::string& text) const {
    std::ofstream(folder_.file("p.dat")) << text;
    return read_cone_file(folder_.file("p.dat"));
  }
  ConeFile read(const std::vector<unsigned char>& bytes) const {
    replace_file(folder_.file("p.hdf5"), bytes);
    return read_cone_file(folder_.file("p.hdf5"));
  }

 private:
  const TemporaryFolder folder_;
};

void expect_same(const ConeProblem& a, const ConeProblem& b) {
  const double size = b.w.dense().cwiseAbs().maxCoeff();
  EXPECT_LT((a.w.dense() - b.w.dense()).cwiseAbs().maxCoeff(), 1e-13 * size);
  EXPECT_LT((a.q - b.q).cwiseAbs().maxCoeff(), 1e-13 * b.q.cwiseAbs().maxCoeff());
  EXPECT_EQ(a.mu, b.mu);
}

TEST_F(ProblemForms, GlobalTextsInEveryStorage) {
  const GlobalConeProblem problem = coupled_heap();
  const ConeProblem local = oracle::local_form(problem);
  const std::string rest = numbers(problem.f) + numbers(problem.w) + numbers(problem.mu);
  const std::pair<std::string, std::string> storages[] = {
      {dense(problem.m) + dense(problem.h), "Siconos text, global, dense"},
      {one_block(problem.m) + one_block(problem.h), "Siconos text, global, by blocks"},
      {triplets(problem.m) + compressed(problem.h, 2), "Siconos text, global, sparse"},
      {compressed(problem.m, 3) + compressed(problem.h, 3), "Siconos text, global, sparse"}};
  for (const auto& [matrices, form] : storages) {
    for (const char* end : {"", "0\n", "1\n"}) {
      SCOPED_TRACE(form + " " + end);
      const ConeFile file = read("3\n5\n" + matrices + rest + end);
      EXPECT_EQ(file.form, form);
      ASSERT_TRUE(file.global);
      expect_same(file.problem, local);
    }
  }
}

// As many velocities as rows of contacts: only the numbers that follow tell global from local.
TEST_F(ProblemForms, SquareGlobalTextsAreNotTakenForLocal) {
  GlobalConeProblem problem = oracle::random_heap(1, 2, 0.4, 2);
  ASSERT_EQ(problem.m.rows(), problem.h.cols());
  const std::string rest = numbers(problem.f) + numbers(problem.w) + numbers(problem.mu);
  const ConeFile global = read("3 2 " + dense(problem.m) + dense(problem.h) + rest + "0");
  EXPECT_EQ(global.form, "Siconos text, global, dense");
  const ConeProblem form = oracle::local_form(problem);
  expect_same(global.problem, form);
  const ConeFile local = read("3 2 " + dense(form.w.dense()) + numbers(form.q) + numbers(form.mu) + "1");
  EXPECT_EQ(local.form, "Siconos text, local, dense");
  expect_same(local.problem, form);
}

TEST_F(ProblemForms, AStoredTriangleIsMadeWhole) {
  const GlobalConeProblem whole = coupled_heap();
  const ConeProblem local = oracle::local_form(whole);
  GlobalConeProblem half = whole;
  half.m = whole.m.triangularView<Eigen::Upper>();
  const ConeFile upper = read(encode_fclib(half, "upper"));
  EXPECT_EQ(upper.form, "FCLIB, global, M from its upper triangle");
  expect_same(upper.problem, local);
  half.m = whole.m.triangularView<Eigen::Lower>();
  const ConeFile lower = read(encode_fclib(half, "lower"));
  EXPECT_EQ(lower.form, "FCLIB, global, M from its lower triangle");
  expect_same(lower.problem, local);
  const MatrixXd w = local.w.dense();
  const std::string rest = numbers(local.q) + numbers(local.mu);
  const ConeFile text = read("3 5 " + dense(MatrixXd(w.triangularView<Eigen::Upper>())) + rest);
  EXPECT_EQ(text.form, "Siconos text, local, dense, W from its upper triangle");
  expect_same(text.problem, local);
  EXPECT_EQ(read(encode_fclib(whole, "whole")).form, "FCLIB, global");
}

// W = H^T M^-1 H of an M that is off by some thousandths, as it stands.
TEST_F(ProblemForms, AMassThatIsALittleUnsymmetricIsTakenAsItIs) {
  GlobalConeProblem problem = coupled_heap();
  problem.m.coeffRef(0, 1) *= 1.01;
  const MatrixXd h = problem.h, w = h.transpose() * MatrixXd(problem.m).inverse() * h;
  const ConeFile file = read(encode_fclib(problem, "skew"));
  EXPECT_LT((file.problem.w.dense() - w).cwiseAbs().maxCoeff(), 1e-12 * w.cwiseAbs().maxCoeff());
  EXPECT_GT((w - w.transpose()).cwiseAbs().maxCoeff(), 1e-6 * w.cwiseAbs().maxCoeff());
}

// Of one contact whose rows do not feel each other: a normal impulse of 2, friction at its edge, a rolling moment at
// its edge or as large as it takes to stop the rolling.
TEST_F(ProblemForms, OneContactRollsAsItsClosedFormSays) {
  const VectorXd w = (VectorXd(5) << 1, 2, 2, 5, 5).finished(), q = (VectorXd(5) << -2, 9, 0, 0, 4).finished();
  for (const double rolling : {0.0, 0.1, 0.7}) {
    SCOPED_TRACE(rolling);
    const ConeFile file = read("5 1 " + dense(w.asDiagonal()) + numbers(q) + "0.5" + fmt::format(" {}", rolling));
    EXPECT_EQ(file.form, "Siconos text, local, dense, rolling friction");
    EXPECT_EQ(file.contacts(), 1u);
    EXPECT_EQ(file.dimension, 5u);
    const double moment = std::min(2 * rolling, 0.8);
    for (const char* solver : {"auto", "nsgs", "newton"}) {
      const auto solution = oracle::solve_whole(file.problem, *oracle::find_cone_solver(solver), {.tolerance = 1e-10});
      const VectorXd r = impulses_in_file(file, solution.r);
      EXPECT_LT((r - (VectorXd(5) << 2, -1, 0, 0, -moment).finished()).norm(), 1e-8) << solver;
    }
  }
  const VectorXd leaving = (VectorXd(5) << 2, 9, 0, 0, 4).finished();
  const ConeFile file = read("5 1 " + dense(w.asDiagonal()) + numbers(leaving) + "0.5 0.1");
  EXPECT_EQ(oracle::solve_whole(file.problem, *oracle::find_cone_solver("auto"), {}).r.norm(), 0);
}

// Random contacts with rolling friction, coupled: what is found keeps the laws, which are checked one by one. The local
// and the global form agree on the velocities, which are unique for what little friction there is.
TEST_F(ProblemForms, RollingFrictionKeepsItsLaws) {
  std::mt19937 random(5);
  const auto number = [&] { return 2 * double(random()) / 4294967295.0 - 1; };
  for (int trial = 0; trial < 5; ++trial) {
    SCOPED_TRACE(trial);
    const int n = 3;
    const MatrixXd h = MatrixXd::NullaryExpr(12, 5 * n, number);
    const VectorXd f = VectorXd::NullaryExpr(12, number), b = VectorXd::NullaryExpr(5 * n, number);
    const VectorXd mu = VectorXd::Constant(n, 0.2), rolling = VectorXd::Constant(n, 0.1);
    const MatrixXd m = 2 * MatrixXd::Identity(12, 12), w = h.transpose() * h / 2;
    const VectorXd q = h.transpose() * f / 2 + b;
    const std::string rest = numbers(mu) + numbers(rolling);
    const ConeFile local = read("5 3 " + dense(w) + numbers(q) + rest);
    const ConeFile global = read("5 3 " + dense(m) + dense(h) + numbers(f) + numbers(b) + rest);
    EXPECT_EQ(global.form, "Siconos text, global, dense, rolling friction");
    EXPECT_EQ(global.velocities(), 12);
    std::vector<VectorXd> velocities;
    for (const ConeFile* file : {&local, &global}) {
      const auto solution = oracle::solve_whole(file->problem, *oracle::find_cone_solver("auto"), {.tolerance = 1e-11});
      EXPECT_LE(solution.error.residual, 1e-11);
      const VectorXd r = impulses_in_file(*file, solution.r), u = w * r + q;
      for (int i = 0; i < n; ++i) {
        const auto opposed = [&](int row, double radius) {
          const Eigen::Vector2d force = r.segment<2>(5 * i + row), rate = u.segment<2>(5 * i + row);
          EXPECT_LE(force.norm(), radius + 1e-9);
          EXPECT_LT((rate.norm() * force + radius * rate).norm(), 1e-8);  // at its edge, against the rate; or no rate
        };
        EXPECT_GE(r[5 * i], -1e-12);
        EXPECT_GE(u[5 * i], -1e-9);
        EXPECT_LT(std::abs(r[5 * i] * u[5 * i]), 1e-9);
        opposed(1, mu[i] * r[5 * i]);
        opposed(3, rolling[i] * r[5 * i]);
      }
      velocities.push_back(u);
    }
    EXPECT_LT((velocities[0] - velocities[1]).norm(), 1e-7);
  }
}

}  // namespace
}  // namespace lockstep::problem_forms_test
