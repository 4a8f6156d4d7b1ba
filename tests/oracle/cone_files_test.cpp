// Files of frictional contact problems: what is written is read, in every storage, and what is wrong is refused.
#include <gtest/gtest.h>

#include <fstream>

#include "cpu_reference/oracle/cone/whole.hpp"
#include "host/error.hpp"
#include "host/problems/cone_file.hpp"
#include "host/record/hdf5.hpp"
#include "host/record/whole_file.hpp"
#include "tests/oracle/cone_problems.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::cone_files_test {
namespace {

using Eigen::VectorXd;
using oracle::ConeProblem;
using oracle::GlobalConeProblem;

class ConeFiles : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return folder_.file(name); }

  ConeFile read_text(const std::string& text) const {
    std::ofstream(path("problem.dat")) << text;
    return read_cone_file(path("problem.dat"));
  }

  ConeFile read_bytes(const std::vector<unsigned char>& bytes) const {
    replace_file(path("problem.hdf5"), bytes);
    return read_cone_file(path("problem.hdf5"));
  }

  // One line: file, place and `expected`.
  template <class Read>
  void expect_refused(Read&& read, const std::string& expected) const {
    try {
      read();
      ADD_FAILURE() << "was not refused: " << expected;
    } catch (const Error& error) {
      const std::string line = error.what();
      EXPECT_EQ(error.failure(), Failure::input);
      EXPECT_EQ(line.rfind(path("problem."), 0), 0u) << line;
      EXPECT_EQ(line.find('\n'), line.npos) << line;
      EXPECT_NE(line.find(expected), line.npos) << line;
    }
  }

 private:
  const TemporaryFolder folder_;
};

void expect_equal(const ConeProblem& a, const ConeProblem& b) {
  EXPECT_EQ(a.w.dense(), b.w.dense());
  EXPECT_EQ(a.q, b.q);
  EXPECT_EQ(a.mu, b.mu);
  ASSERT_EQ(a.joints.has_value(), b.joints.has_value());
  if (!a.joints) return;
  EXPECT_EQ(Eigen::MatrixXd(a.joints->v), Eigen::MatrixXd(b.joints->v));
  EXPECT_EQ(Eigen::MatrixXd(a.joints->r), Eigen::MatrixXd(b.joints->r));
  EXPECT_EQ(a.joints->s, b.joints->s);
  EXPECT_EQ(a.joints->first, b.joints->first);
}

GlobalConeProblem with_joints(GlobalConeProblem problem) {
  std::vector<Eigen::Triplet<double>> g = {{0, 0, 1.0}, {6, 0, -1.0}, {1, 1, 1.0}, {7, 1, -1.0}, {3, 2, 0.5}};
  problem.g = oracle::SparseMatrix(problem.m.rows(), 3);
  problem.g.setFromTriplets(g.begin(), g.end());
  problem.b = Eigen::Vector3d(0.1, 0, 0.2);
  problem.first = {0, 2, 3};
  return problem;
}

TEST_F(ConeFiles, KeepLocalAndGlobalForms) {
  const GlobalConeProblem global = with_joints(oracle::random_heap(4, 7, 0.3, 1));
  const ConeProblem local = oracle::local_form(global);
  const oracle::ConeImpulses stored = {VectorXd::LinSpaced(21, 0, 1), Eigen::Vector3d(1, 2, 3)};
  const ConeFile of_global = read_bytes(encode_fclib(global, "heap", stored));
  expect_equal(of_global.problem, local);
  ASSERT_TRUE(of_global.global && of_global.stored);
  EXPECT_EQ(of_global.stored->r, stored.r);
  EXPECT_EQ(of_global.stored->l, stored.l);
  const ConeFile of_local = read_bytes(encode_fclib(local, "heap"));
  expect_equal(of_local.problem, local);
  EXPECT_FALSE(of_local.global || of_local.stored);
}

TEST_F(ConeFiles, KeepTheTextForm) {
  const ConeProblem problem = oracle::local_form(oracle::random_heap(4, 7, 0.3, 1));
  expect_equal(read_text(encode_siconos_text(problem)).problem, problem);
  for (const char* end : {"0\n", "1\n"}) expect_equal(read_text(encode_siconos_text(problem) + end).problem, problem);
  EXPECT_THROW(encode_siconos_text(oracle::local_form(with_joints(oracle::random_heap(4, 7, 0.3, 1)))), Error);
}

TEST_F(ConeFiles, ReadDenseText) {
  const ConeFile file = read_text("3\n1\n\n0\n3 3\n3 3\n15 -1 -2\n-1 14 1\n-2 1 16\n-1 2 3\n0.1\n");
  EXPECT_EQ(file.problem.contacts(), 1u);
  EXPECT_EQ(file.problem.w.on_diagonal(0)(0, 1), -1);
  EXPECT_EQ(file.problem.w.on_diagonal(0)(2, 1), 1);
  EXPECT_EQ(file.problem.q, Eigen::Vector3d(-1, 2, 3));
  EXPECT_EQ(file.problem.mu[0], 0.1);
}

// In the plane: W = 1/4 of one contact that slides, and of two contacts by blocks.
TEST_F(ConeFiles, ReadProblemsInThePlane) {
  const ConeFile file = read_text("2 1 0 2 2 2 2  0.25 0 0 0.25  -2 5  0.3");
  EXPECT_EQ(file.dimension, 2u);
  for (const oracle::ConeSolver& solver : oracle::cone_solvers()) {
    if (solver.name == "ccp_apgd") continue;
    const oracle::ConeSolution solution = oracle::solve_whole(file.problem, solver, {});
    EXPECT_LT((solution.r - Eigen::Vector3d(8, -2.4, 0)).norm(), 1e-6) << solver.name;
  }
  const ConeFile blocks =
      read_text("2 2 1 4 4 2 2 2  2 4  2 4  3 2  0 1 2  0 1  0 1 0.25 0.25 2  1 3 0 0 3  -1 0 -1 0  0.3 0.4 0");
  EXPECT_EQ(blocks.problem.w.on_diagonal(0)(1, 0), 0.25);
  EXPECT_EQ(blocks.problem.w.on_diagonal(1)(1, 1), 3);
  EXPECT_EQ(blocks.problem.w.block.size(), 2u);
  GlobalConeProblem global;
  global.dimension = 2;
  global.m = oracle::SparseMatrix(2, 2);
  global.m.setIdentity();
  global.m *= 4.0;
  global.h = oracle::SparseMatrix(2, 2);
  global.h.setIdentity();
  global.g = oracle::SparseMatrix(2, 0);
  global.f = Eigen::Vector2d(-8, 20);
  global.w = VectorXd::Zero(2);
  global.mu = VectorXd::Constant(1, 0.3);
  expect_equal(read_bytes(encode_fclib(global, "plane", oracle::ConeImpulses{Eigen::Vector2d(8, -2.4), {}})).problem,
               file.problem);
}

// A local problem of one contact with its matrix in any storage; `spoil` may overwrite what is in `vectors`.
std::vector<unsigned char> handmade(int nz, std::vector<int> p, std::vector<int> i, const std::vector<double>& x,
                                    std::vector<double> q = {-1, 2, 3}, std::vector<double> mu = {0.1},
                                    int spacedim = 3, int columns = 3) {
  h5::be_quiet();
  const h5::Handle access(H5Pcreate(H5P_FILE_ACCESS));
  h5::check(H5Pset_fapl_core(access, 1u << 16, false));
  const h5::Handle file(H5Fcreate("handmade", H5F_ACC_TRUNC, H5P_DEFAULT, access));
  const auto group = [](hid_t parent, const char* name) {
    return h5::Handle(H5Gcreate2(parent, name, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
  };
  const auto write = [](hid_t parent, const char* name, hid_t type, const void* data, std::size_t count) {
    const hsize_t extent[] = {count};
    const h5::Handle dataset(H5Dcreate2(parent, name, type, h5::space(extent), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT));
    h5::check(H5Dwrite(dataset, type, H5S_ALL, H5S_ALL, H5P_DEFAULT, data));
  };
  {
    const h5::Handle local = group(file, "fclib_local"), w = group(local, "W"), vectors = group(local, "vectors");
    const int m = 3;
    write(local, "spacedim", H5T_NATIVE_INT, &spacedim, 1);
    write(w, "m", H5T_NATIVE_INT, &m, 1);
    write(w, "n", H5T_NATIVE_INT, &columns, 1);
    write(w, "nz", H5T_NATIVE_INT, &nz, 1);
    write(w, "p", H5T_NATIVE_INT, p.data(), p.size());
    write(w, "i", H5T_NATIVE_INT, i.data(), i.size());
    write(w, "x", H5T_NATIVE_DOUBLE, x.data(), x.size());
    write(vectors, "q", H5T_NATIVE_DOUBLE, q.data(), q.size());
    write(vectors, "mu", H5T_NATIVE_DOUBLE, mu.data(), mu.size());
  }
  h5::check(H5Fflush(file, H5F_SCOPE_LOCAL));
  std::vector<unsigned char> bytes(static_cast<std::size_t>(h5::check(H5Fget_file_image(file, nullptr, 0))));
  h5::check(H5Fget_file_image(file, bytes.data(), bytes.size()));
  return bytes;
}

// 4 in the corner, 0.01 off the diagonal on one side and 0.012 on the other, so that rows and columns can be told
// apart.
TEST_F(ConeFiles, ReadEveryStorage) {
  const std::vector<std::vector<unsigned char>> files = {
      handmade(5, {0, 1, 2, 1, 0}, {0, 1, 2, 0, 1}, {4, 2, 1, 0.01, 0.012}),  // triplets: columns p, rows i
      handmade(-1, {0, 2, 4, 5}, {0, 1, 0, 1, 2}, {4, 0.012, 0.01, 2, 1}),    // columns
      handmade(-2, {0, 2, 4, 5}, {0, 1, 0, 1, 2}, {4, 0.01, 0.012, 2, 1}),    // rows
  };
  for (const auto& bytes : files) {
    Eigen::Matrix3d w;
    w << 4, 0.01, 0, 0.012, 2, 0, 0, 0, 1;
    EXPECT_EQ(read_bytes(bytes).problem.w.on_diagonal(0), w);
  }
}

TEST_F(ConeFiles, RefuseBadFclib) {
  const auto good = handmade(3, {0, 1, 2}, {0, 1, 2}, {4, 2, 1});
  EXPECT_EQ(read_bytes(good).problem.contacts(), 1u);
  const auto refused = [&](const std::vector<unsigned char>& bytes, const std::string& expected) {
    expect_refused([&] { read_bytes(bytes); }, expected);
  };
  refused(handmade(3, {0, 1, 3}, {0, 1, 2}, {4, 2, 1}), "/fclib_local/W/");
  refused(handmade(3, {0, 1, -1}, {0, 1, 2}, {4, 2, 1}), "/fclib_local/W/");
  refused(handmade(3, {0, 1}, {0, 1, 2}, {4, 2, 1}), "/fclib_local/W/p: must have 3");
  refused(handmade(-1, {0, 2, 1, 3}, {0, 1, 2}, {4, 2, 1}), "/fclib_local/W/p: must be 4 rising");
  refused(handmade(-3, {0}, {0}, {4}), "/fclib_local/W/nz");
  refused(handmade(3, {0, 1, 2}, {0, 1, 2}, {4, NAN, 1}), "/fclib_local/W/x[1]: must be a finite number");
  refused(handmade(3, {0, 1, 2}, {0, 1, 2}, {4, 2, 1}, {1, 2}), "/fclib_local/vectors/q: must have 3 numbers, has 2");
  refused(handmade(3, {0, 1, 2}, {0, 1, 2}, {4, 2, 1}, {1, 2, 3}, {-0.1}), "vectors/mu[0]: must be >= 0");
  refused(handmade(3, {0, 1, 2}, {0, 1, 2}, {4, 2, 1}, {1, 2, 3}, {0.1}, 4), "/fclib_local/spacedim");
  refused(handmade(3, {0, 1, 2}, {0, 1, 2}, {4, 2, 1}, {1, 2, 3}, {0.1}, 2), "no multiple of the dimension");
  refused(handmade(3, {0, 1, 2}, {0, 1, 2}, {4, 2, 1}, {1, 2, 3}, {0.1}, 3, 4), "/fclib_local/W: must be 3 x 3");
  refused(handmade(5, {0, 1, 2, 1, 0}, {0, 1, 2, 0, 1}, {4, 2, 1, 1, 0.2}),
          "/fclib_local/W: must be symmetric, is not: 0.2 at (1, 0), 1 at (0, 1)");
  // what is small beside the largest entry is not small beside its own diagonal
  refused(handmade(5, {0, 1, 2, 1, 2}, {0, 1, 2, 2, 1}, {2.6e8, 180, 180, 39, 1}), "must be symmetric");
  // one side only, but too large for the triangle of a mobility
  refused(handmade(4, {0, 1, 2, 1}, {0, 1, 2, 0}, {4, 2, 1, 3}), "must be symmetric");
  for (const std::size_t length : {std::size_t{9}, good.size() / 4, good.size() / 2, good.size() - 64})
    refused({good.begin(), good.begin() + static_cast<std::ptrdiff_t>(length)}, "");
  GlobalConeProblem not_positive = oracle::random_heap(2, 3, 0.3, 1);
  not_positive.m.coeffRef(4, 4) = -1;
  refused(encode_fclib(not_positive, ""), "/fclib_global/M: M is not positive definite");
}

TEST_F(ConeFiles, RefuseBadText) {
  const auto refused = [&](const std::string& text, const std::string& expected) {
    expect_refused([&] { read_text(text); }, expected);
  };
  const std::string head = "3 1 0 3 3 3 3\n", matrix = "1 0 0 0 1 0 0 0 1\n", rest = "-1 2 3 0.1";
  EXPECT_EQ(read_text(head + matrix + rest).problem.contacts(), 1u);
  refused("", "line 1: the dimension: the file ends here");
  refused("4 1 0", "line 1: the dimension: must be 2, 3 or, with rolling friction, 5, is 4; what does not begin");
  refused("1 9 9", "line 1: the dimension: must be 2, 3 or");
  refused("3 one 0", "number of contacts");
  refused("3 -1 0", "number of contacts");
  refused("3 1 3", "storage of the matrix");
  refused("3 1 0 3 6", "columns");
  refused("3 1 2 3 3 1 SuperLU", "line 1: the matrix: must be 'CSparse', is 'SuperLU'");
  refused(head + "1 0 0 0 1 0 0 0 nan\n" + rest, "line 2: the matrix: must be a finite number, is 'nan'");
  refused(head + "1 0 0 0 1 0 0 0 1e999\n" + rest, "line 2: the matrix");
  refused(head + "1 5 0 0 1 0 0 0 1\n" + rest, "must be symmetric");
  refused(head + matrix + "-1 2 3 -0.1", "mu[0]: must be >= 0");
  refused(head + matrix + "-1 2 3", "mu: ");
  refused(head + matrix + rest + " 0 7", "more numbers follow");
  refused(head + matrix + rest + " 2", "the end (a single 0 or 1 may stand there)");
  refused("3 9000000 0 27000000 27000000 27000000 27000000 1", "the file is too short");
  const std::string blocks = encode_siconos_text(oracle::single_contact(2, {-1, 0, 0}, 0.5));
  EXPECT_EQ(read_text(blocks).problem.contacts(), 1u);
  for (std::size_t length = 1; length + 4 < blocks.size(); length += 7) refused(blocks.substr(0, length), "");
}

TEST_F(ConeFiles, RefuseWhatIsNotThere) {
  expect_refused([&] { read_cone_file(path("problem.none")); }, "no such file");
  h5::be_quiet();
}

}  // namespace
}  // namespace lockstep::cone_files_test
