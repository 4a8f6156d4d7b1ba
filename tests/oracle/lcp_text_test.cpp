// Text files of complementarity problems.
#include "host/problems/lcp_text.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "host/error.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep {
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
  EXPECT_EQ(refusal(""), "p.dat:1: the file ends where the number of unknowns should stand");
  EXPECT_EQ(refusal("two"), "p.dat:1: the number of unknowns: not a whole number: two");
  EXPECT_EQ(refusal("-1"), "p.dat:1: the number of unknowns must be 0 to 10000, is -1");
  EXPECT_EQ(refusal("99999999999999999999"),
            "p.dat:1: the number of unknowns: not a whole number: 99999999999999999999");
  EXPECT_EQ(refusal("2\n1"), "p.dat:2: only dense matrices (storage 0) are read, this is 1");
  EXPECT_EQ(refusal("2\n0\n2\n3"), "p.dat:4: the number of columns must be 2, is 3");
  EXPECT_EQ(refusal("2\n0\n2\n2\n3 2\n"), "p.dat:5: the number of rows once more must be 2, is 3");
  EXPECT_EQ(refusal("2\n0\n2\n2\n2 2\n1 2\n3"), "p.dat:7: the file ends where M(1, 1) should stand");
  EXPECT_EQ(refusal("2\n0\n2\n2\n2 2\n1 2\n3 4\n5"), "p.dat:8: the file ends where q(1) should stand");
  EXPECT_EQ(refusal("2\n0\n2\n2\n2 2\n1 2\n3 nan\n5 6"), "p.dat:7: M(1, 1): must be finite, is nan");
  EXPECT_EQ(refusal("2\n0\n2\n2\n2 2\n1 2\n3 4\n5 inf"), "p.dat:8: q(1): must be finite, is inf");
  EXPECT_EQ(refusal("2\n0\n2\n2\n2 2\n1 2\n3 4x\n5 6"), "p.dat:7: M(1, 1): not a number: 4x");
  EXPECT_EQ(refusal("1\n0\n1\n1\n1 1\n1e999 1"), "p.dat:6: M(0, 0): not a number: 1e999");
}

TEST(LcpText, RefusesWhatCannotBeRead) {
  EXPECT_THROW(read_lcp_text("/nonexistent/p.dat"), Error);
  const TemporaryFolder folder;
  EXPECT_THROW(read_lcp_text(folder.file("")), Error);
}

}  // namespace
}  // namespace lockstep
