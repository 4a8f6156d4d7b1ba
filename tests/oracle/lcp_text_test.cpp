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

TEST(LcpText, RefusesWhatIsNone) {
  EXPECT_EQ(refusal(""), "p.dat: line 1: number of unknowns: the file ends here; it may be cut short");
  const std::string unknowns = "p.dat: line 1: number of unknowns: must be a whole number from 0 to 10000, is ";
  EXPECT_EQ(refusal("two"), unknowns + "'two'");
  EXPECT_EQ(refusal("-1"), unknowns + "'-1'");
  EXPECT_EQ(refusal("99999999999999999999"), unknowns + "'99999999999999999999'");
  EXPECT_EQ(refusal("2\n1"), "p.dat: line 2: storage of the matrix (0 dense): must be 0, is '1'");
  EXPECT_EQ(refusal("2\n0\n2\n3"), "p.dat: line 4: columns: must be 2, is '3'");
  EXPECT_EQ(refusal("2\n0\n2\n2\n3 2\n"), "p.dat: line 5: rows once more: must be 2, is '3'");
  EXPECT_EQ(refusal("9\n0\n9\n9\n9 9\n1 2"),
            "p.dat: line 5: the matrix: 81 numbers are announced, the file is too short for them");
  const std::string start = "2\n0\n2\n2\n2 2\n1 2\n3";
  EXPECT_EQ(refusal(start + "    "), "p.dat: line 7: M(1, 1): the file ends here; it may be cut short");
  EXPECT_EQ(refusal(start + " 4\n5"), "p.dat: line 8: q(1): the file ends here; it may be cut short");
  const std::string rule = ": must be a finite number, is '", cure = "'; write the file anew";
  EXPECT_EQ(refusal(start + " nan\n5 6"), "p.dat: line 7: M(1, 1)" + rule + "nan" + cure);
  EXPECT_EQ(refusal(start + " 4\n5 inf"), "p.dat: line 8: q(1)" + rule + "inf" + cure);
  EXPECT_EQ(refusal(start + " 4x\n5 6"), "p.dat: line 7: M(1, 1)" + rule + "4x" + cure);
  EXPECT_EQ(refusal("1\n0\n1\n1\n1 1\n1e999 1"), "p.dat: line 6: M(0, 0)" + rule + "1e999" + cure);
}

TEST(LcpText, RefusesWhatCannotBeRead) {
  EXPECT_THROW(read_lcp_text("/nonexistent/p.dat"), Error);
  const TemporaryFolder folder;
  EXPECT_THROW(read_lcp_text(folder.file("")), Error);
}

}  // namespace
}  // namespace lockstep::lcp_text_test
