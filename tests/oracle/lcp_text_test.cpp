// Text files of complementarity problems.
#include "host/problems/lcp_text.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "host/error.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::lcp_text_test {
namespace {

oracle::lcp::Lcp read(const std::string& text) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("p.dat")) << text;
  return read_lcp_text(folder.file("p.dat"));
}

std::string refusal(const std::string& text) {
  try {
    read(text);
  } catch (const Error& e) {
    EXPECT_EQ(e.failure(), Failure::input);
    const std::string what = e.what();
    EXPECT_EQ(what.find('\n'), std::string::npos) << "one line";
    return what.substr(what.find("p.dat"));
  }
  return "";
}

TEST(LcpText, ReadsColumnsThenTheVector) {
  const oracle::lcp::Lcp p = read("2\n0\n2\n2\n2\t2\n1 -2.5e1\n +3 4\n-5 6\n\na remark\n");
  Eigen::Matrix2d m;
  m << 1, 3, -25, 4;
  EXPECT_EQ(p.m, m);
  EXPECT_EQ(p.q, Eigen::Vector2d(-5, 6));
  EXPECT_EQ(read("0 0 0 0 0 0").size(), 0);
}

TEST(LcpText, ReadsBlocksAndSparseMatrices) {
  const oracle::lcp::Lcp blocks = read("2 1 2 2  1 1 1  2  2  2 1  0 1  0  0 2 1 1 2  -5 -6");
  EXPECT_EQ(blocks.m, (Eigen::Matrix2d() << 2, 1, 1, 2).finished());
  const oracle::lcp::Lcp sparse = read(
      "2 2 2 2\n2\nCSparse Version 3\n2-by-2, nzmax: 3 nnz: 3, 1-norm: 3\n    col 0 : locations 0 to 1\n"
      "      0 : 2\n      1 : 1\n    col 1 : locations 2 to 2\n      1 : 2\n-5 -6\n");
  EXPECT_EQ(sparse.m, (Eigen::Matrix2d() << 2, 0, 1, 2).finished());
  EXPECT_EQ(sparse.q, Eigen::Vector2d(-5, -6));
}

// Contact problems begin with dimension, contacts and storage, which may be the same numbers.
TEST(LcpText, IsToldFromContactProblems) {
  const TemporaryFolder folder;
  const auto is_one = [&](const std::string& text) {
    std::ofstream(folder.file("p.dat")) << text;
    return is_lcp_text(folder.file("p.dat"));
  };
  EXPECT_TRUE(is_one("2\n0\n2\n2\n2 2\n1 0 0 1 -5 6"));
  EXPECT_TRUE(is_one("2 1 2 2  1 1 1  2  2  2 1  0 1  0  0 2 1 1 2  -5 -6"));
  EXPECT_TRUE(is_one("2 2 2 2\n2\nCSparse Version 3\n"));
  EXPECT_FALSE(is_one("2 1 2 2 2\n2\nCSparse Version 3\n")) << "a contact in the plane, its matrix sparse";
  EXPECT_FALSE(is_one("2 0 2 900 900\n1\nCSparse Version 3\n")) << "without contacts, global";
  EXPECT_FALSE(is_one("3 1 0 3 3 3 3 15 -1 -2 -1 14 1 -2 1 16 -1 2 3 0.1"));
}

TEST(LcpText, RefusesWhatIsNone) {
  EXPECT_EQ(refusal(""), "p.dat: line 1: number of unknowns: the file ends here; it may be cut short");
  const std::string unknowns = "p.dat: line 1: number of unknowns: must be a whole number from 0 to 10000, is ";
  EXPECT_EQ(refusal("two"), unknowns + "'two'");
  EXPECT_EQ(refusal("-1"), unknowns + "'-1'");
  EXPECT_EQ(refusal("99999999999999999999"), unknowns + "'99999999999999999999'");
  EXPECT_EQ(refusal("2\n3"),
            "p.dat: line 2: storage of the matrix (0 dense, 1 by blocks, 2 sparse): must be a whole "
            "number from 0 to 2, is '3'");
  EXPECT_EQ(refusal("2\n0\n2\n3"), "p.dat: line 4: the matrix: must be 2 x 2, is 2 x 3");
  EXPECT_EQ(refusal("2\n0\n2\n2\n3 2\n"), "p.dat: line 5: rows of the stored matrix: must be 2, is '3'");
  EXPECT_EQ(refusal("9\n0\n9\n9\n9 9\n1 2"),
            "p.dat: line 5: the matrix: 81 numbers are announced, the file is too short for them");
  EXPECT_EQ(refusal("1\n0\n1\n1\n1 1\n1 -1\n-2 2"),
            "p.dat: line 7: the end: more numbers follow than the problem has; it is of another kind");
  const std::string start = "2\n0\n2\n2\n2 2\n1 2\n3";
  EXPECT_EQ(refusal(start + "    "), "p.dat: line 7: the matrix: the file ends here; it may be cut short");
  EXPECT_EQ(refusal(start + " 4\n5"), "p.dat: line 8: q: the file ends here; it may be cut short");
  const std::string rule = ": must be a finite number, is '", cure = "'; write the file anew";
  EXPECT_EQ(refusal(start + " nan\n5 6"), "p.dat: line 7: the matrix" + rule + "nan" + cure);
  EXPECT_EQ(refusal(start + " 4\n5 inf"), "p.dat: line 8: q" + rule + "inf" + cure);
  EXPECT_EQ(refusal(start + " 4x\n5 6"), "p.dat: line 7: the matrix" + rule + "4x" + cure);
  EXPECT_EQ(refusal("1\n0\n1\n1\n1 1\n1e999 1"), "p.dat: line 6: the matrix" + rule + "1e999" + cure);
}

TEST(LcpText, RefusesWhatCannotBeRead) {
  EXPECT_THROW(read_lcp_text("/nonexistent/p.dat"), Error);
  const TemporaryFolder folder;
  EXPECT_THROW(read_lcp_text(folder.file("")), Error);
}

}  // namespace
}  // namespace lockstep::lcp_text_test
