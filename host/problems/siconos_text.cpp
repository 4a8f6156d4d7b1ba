// Siconos's texts of frictional contact problems: numbers between blanks,
//   dimension (2 in the plane, 3 in space, 5 with rolling friction), contacts n, then
//   local    W, q, mu
//   global   M, H, q, b, mu       FCLIB's f and w are q and b here
// with rolling friction mu_r after mu, and a last 0 or 1 in some. Matrices: siconos_matrix.hpp. Nothing in the text
// says which of the two it is, but sizes have to add up: after M, where it is local, there are as many numbers as it
// has rows and coefficients; a second matrix takes more.
#include <fmt/format.h>

#include <cmath>

#include "host/problems/formats.hpp"
#include "host/problems/number_text.hpp"
#include "host/problems/siconos_matrix.hpp"

namespace lockstep {

namespace {

using Eigen::VectorXd;

// Whether a matrix of this many rows and columns comes next, and `numbers` more after its size. A copy is read ahead.
bool matrix_follows(NumberText numbers, long long rows, long long columns, long long after) {
  if (numbers.words_left() <= after) return false;
  for (const auto& [least, most] : {std::pair(0ll, 2ll), {rows, rows}, {columns, columns}}) {
    double value = 0;
    try {
      value = numbers.number("");
    } catch (const Error&) {
      return false;
    }
    if (value != std::floor(value) || value < double(least) || value > double(most)) return false;
  }
  return true;
}

}  // namespace

ConeFile read_siconos_text(const std::string& path, std::string_view text) {
  NumberText numbers(path, text);
  ConeFile file;
  const long long dimension = numbers.count("the dimension", 0, 0x7fffffff);
  if (dimension != 2 && dimension != 3 && dimension != 5)
    numbers.refuse("the dimension", fmt::format("must be 2, 3 or, with rolling friction, 5, is {}; what does not begin "
                                                "with it is a problem of another kind",
                                                dimension));
  file.dimension = static_cast<std::uint32_t>(dimension);
  const long long contacts = numbers.count("number of contacts", 0, most_contacts), rows = dimension * contacts;
  const long long coefficients = (dimension == 5 ? 2 : 1) * contacts;
  const SiconosMatrixHead head = read_siconos_head(numbers, "the matrix");
  if (head.columns != head.rows)
    numbers.refuse("columns of the matrix", fmt::format("must be {} as the rows, is {}", head.rows, head.columns));
  oracle::SparseMatrix matrix = read_siconos_matrix(numbers, "the matrix", head);
  const bool global = head.rows != rows || matrix_follows(numbers, head.rows, rows, rows + coefficients + 1);
  file.form = fmt::format("Siconos text, {}, {}{}", global ? "global" : "local", siconos_storage_name(head.storage),
                          dimension == 5 ? ", rolling friction" : "");
  matrix = whole_matrix(path, "the matrix", std::move(matrix), global ? "M" : "W", file.form);
  oracle::GlobalConeProblem problem;
  if (global) {
    const SiconosMatrixHead h = read_siconos_head(numbers, "H");
    if (h.rows != head.rows || h.columns != rows)
      numbers.refuse("H", fmt::format("must be {} x {}, is {} x {}", head.rows, rows, h.rows, h.columns));
    problem.m = std::move(matrix);
    problem.h = read_siconos_matrix(numbers, "H", h);
    problem.g = oracle::SparseMatrix(h.rows, 0);
    problem.f = numbers.vector("q", h.rows);
  }
  const VectorXd q = numbers.vector(global ? "b" : "q", rows), mu = numbers.vector("mu", contacts);
  expect_friction(path, "mu", mu);
  const VectorXd rolling = numbers.vector("mu_r", dimension == 5 ? contacts : 0);
  expect_friction(path, "mu_r", rolling);
  if (numbers.more()) numbers.count("the end (a single 0 or 1 may stand there)", 0, 1);
  if (numbers.more()) numbers.refuse("the end", "more numbers follow than the problem has");
  if (!global) {
    set_local(file, matrix, q, mu, rolling, {});
    return file;
  }
  problem.w = q;
  problem.mu = mu;
  try {
    set_global(file, std::move(problem), rolling);
  } catch (const std::runtime_error& error) {
    refuse_problem(path, "the matrix", error.what());
  }
  return file;
}

std::string encode_siconos_text(const oracle::ConeProblem& problem) {
  if (problem.joints) throw Error(Failure::input, "Siconos text", "cannot hold joints; write an .hdf5 file");
  const oracle::BlockMatrix& w = problem.w;
  const std::uint32_t n = w.rows();
  std::string text = fmt::format("3\n{}\n1\n{}\n{}\n{}\n{}\n{}\n", n, 3 * n, 3 * n, w.block.size(), n, n);
  const auto row = [&](const auto& numbers) {
    for (const auto& number : numbers) text += fmt::format("{}\t", number);
    text += '\n';
  };
  std::vector<std::uint32_t> ends;
  for (std::uint32_t i = 1; i <= n; ++i) ends.push_back(3 * i);
  row(ends);
  row(ends);
  text += fmt::format("{}\n{}\n", n + 1, w.block.size());
  row(w.first);
  row(w.column);
  for (std::size_t k = 0; k < w.block.size(); ++k) {
    text += fmt::format("{}\n", k);
    for (int i = 0; i < 9; ++i) text += fmt::format("{:.17g}\n", w.block[k].data()[i]);
  }
  row(problem.q);
  row(problem.mu);
  return text;
}

}  // namespace lockstep
