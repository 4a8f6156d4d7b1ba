#include "host/problems/lcp_text.hpp"

#include <fmt/format.h>

#include <fstream>

#include "host/problems/number_text.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep {

namespace {

constexpr long long most_unknowns = 10'000;  // a dense matrix of 800 MB

}  // namespace

bool is_lcp_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  long unknowns = 0, storage = -1;
  return file >> unknowns >> storage && unknowns >= 0 && storage == 0;
}

oracle::lcp::Lcp read_lcp_text(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::vector<unsigned char> bytes = read_whole_file(name);
  NumberText numbers(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const long long n = numbers.count("number of unknowns", 0, most_unknowns);
  numbers.count("storage of the matrix (0 dense)", 0, 0);
  for (const char* label : {"rows", "columns", "rows once more", "columns once more"}) numbers.count(label, n, n);
  numbers.expect_room("the matrix", n * n);
  oracle::lcp::Lcp problem = {Eigen::MatrixXd(n, n), Eigen::VectorXd(n)};
  for (long long j = 0; j < n; ++j) {
    for (long long i = 0; i < n; ++i) problem.m(i, j) = numbers.number(fmt::format("M({}, {})", i, j));
  }
  for (long long i = 0; i < n; ++i) problem.q[i] = numbers.number(fmt::format("q({})", i));
  return problem;
}

}  // namespace lockstep
