// Siconos's text format of a frictional contact problem: numbers between blanks,
//   dimension (2 or 3), contacts n, storage of the matrix,
//   storage 0: rows, columns, rows, columns, the matrix column by column
//   storage 1: rows, columns, blocks b, block rows, block columns, ends of block rows, ends of block columns,
//              length of the row index and the index, b and the column of each block, then of each block its number and
//              its entries column by column
//   q, mu, and a last 0 where no solution follows.
#include <fmt/format.h>

#include "host/problems/formats.hpp"
#include "host/problems/number_text.hpp"

namespace lockstep {

namespace {

using Eigen::VectorXd;
using oracle::SparseMatrix;

using Triplets = std::vector<Eigen::Triplet<double>>;

Triplets dense_matrix(NumberText& numbers, long long size) {
  Triplets triplets;
  for (const char* label : {"rows of the stored matrix", "columns of the stored matrix"})
    numbers.count(label, size, size);
  numbers.expect_room("the matrix", size * size);
  for (long long column = 0; column < size; ++column) {
    for (long long row = 0; row < size; ++row)
      triplets.emplace_back(int(row), int(column), numbers.number("the matrix"));
  }
  return triplets;
}

Triplets block_matrix(NumberText& numbers, long long dimension, long long contacts) {
  const long long most = contacts * contacts;
  const long long blocks = numbers.count("number of blocks", 0, most);
  numbers.expect_room("the blocks", blocks * dimension * dimension);
  for (const char* label : {"block rows", "block columns"}) numbers.count(label, contacts, contacts);
  for (const char* label : {"ends of block rows", "ends of block columns"}) {
    for (long long i = 1; i <= contacts; ++i) numbers.count(label, i * dimension, i * dimension);
  }
  const long long rows = numbers.count("length of the row index", contacts + 1, contacts + 1);
  numbers.count("length of the column index", blocks, blocks);
  std::vector<long long> first, column;
  for (long long i = 0; i < rows; ++i) {
    const long long least = first.empty() ? 0 : first.back();
    first.push_back(numbers.count("row index", least, first.empty() ? 0 : blocks));
  }
  if (first.back() != blocks) numbers.refuse("row index", "ends before the last block");
  for (long long i = 0; i < blocks; ++i) column.push_back(numbers.count("column index", 0, contacts - 1));
  Triplets triplets;
  for (long long row = 0; row < contacts; ++row) {
    for (long long k = first[row]; k < first[row + 1]; ++k) {
      if (k > first[row] && column[k] <= column[k - 1])
        numbers.refuse("column index", fmt::format("columns must rise within row {}", row));
      numbers.count("number of a block", k, k);
      const std::string label = fmt::format("block {}", k);
      for (long long c = 0; c < dimension; ++c) {
        for (long long r = 0; r < dimension; ++r)
          triplets.emplace_back(int(row * dimension + r), int(column[k] * dimension + c), numbers.number(label));
      }
    }
  }
  return triplets;
}

}  // namespace

ConeFile read_siconos_text(const std::string& path, std::string_view text) {
  NumberText numbers(path, text);
  ConeFile file;
  const long long dimension = numbers.count("the dimension", 2, 3);
  const long long contacts = numbers.count("number of contacts", 0, most_contacts), size = dimension * contacts;
  const long long storage = numbers.count("storage of the matrix (0 dense, 1 by blocks)", 0, 1);
  for (const char* label : {"rows", "columns"}) numbers.count(label, size, size);
  const Triplets triplets = storage == 0 ? dense_matrix(numbers, size) : block_matrix(numbers, dimension, contacts);
  SparseMatrix w(size, size);
  w.setFromTriplets(triplets.begin(), triplets.end());
  const VectorXd q = numbers.vector("q", size), mu = numbers.vector("mu", contacts);
  expect_friction(path, "mu", mu);
  expect_symmetric(path, "the matrix", w);
  if (numbers.more()) numbers.count("the end (a single 0 may stand there)", 0, 0);
  if (numbers.more()) numbers.refuse("the end", "more numbers follow than the problem has");
  file.form = storage == 0 ? "Siconos text, dense" : "Siconos text, by blocks";
  file.dimension = static_cast<std::uint32_t>(dimension);
  if (dimension == 2)
    file.problem = oracle::embed_plane(w, q, mu);
  else
    file.problem = {oracle::block_matrix(w), q, mu, {}, {}};
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
