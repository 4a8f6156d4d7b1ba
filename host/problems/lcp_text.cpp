#include "host/problems/lcp_text.hpp"

#include <fmt/format.h>

#include <fstream>

#include "host/problems/number_text.hpp"
#include "host/problems/siconos_matrix.hpp"
#include "host/record/whole_file.hpp"

namespace lockstep {

namespace {

constexpr long long most_unknowns = 10'000;  // a dense matrix of 800 MB

}  // namespace

bool is_lcp_text(const std::filesystem::path& path) {
  std::ifstream file(path);
  long long unknowns = 0, storage = -1, rows = -1, columns = -1;
  if (!(file >> unknowns >> storage) || unknowns < 0 || storage < 0 || storage > 2) return false;
  if (!(file >> rows >> columns) || rows != unknowns || columns != unknowns) return false;
  // a contact problem in the plane whose matrix is sparse begins with such numbers too: dimension, contacts, storage
  std::string ahead;
  for (int i = 0; i < 3 && file >> ahead; ++i) {
    if (ahead == "CSparse") return i == 1;
  }
  return true;
}

oracle::lcp::Lcp read_lcp_text(const std::filesystem::path& path) {
  const std::string name = path.string();
  const std::vector<unsigned char> bytes = read_whole_file(name);
  NumberText numbers(name, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
  const long long n = numbers.count("number of unknowns", 0, most_unknowns);
  const SiconosMatrixHead head = read_siconos_head(numbers, "the matrix");
  if (head.rows != n || head.columns != n)
    numbers.refuse("the matrix", fmt::format("must be {} x {}, is {} x {}", n, n, head.rows, head.columns));
  oracle::lcp::Lcp problem = {read_siconos_matrix(numbers, "the matrix", head), {}};
  problem.q = numbers.vector("q", n);
  if (numbers.more() && std::string_view("0123456789+-.").find(numbers.next_character()) != std::string_view::npos)
    numbers.refuse("the end", "more numbers follow than the problem has; it is of another kind");
  return problem;
}

}  // namespace lockstep
