#include "host/problems/siconos_matrix.hpp"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <vector>

#include "host/problems/formats.hpp"

namespace lockstep {

namespace {

using Triplets = std::vector<Eigen::Triplet<double>>;

constexpr std::array<std::string_view, 3> storage_names = {"dense", "by blocks", "sparse"};

Triplets read_dense(NumberText& numbers, const std::string& name, const SiconosMatrixHead& head) {
  Triplets triplets;
  numbers.count("rows of the stored matrix", head.rows, head.rows);
  numbers.count("columns of the stored matrix", head.columns, head.columns);
  numbers.expect_room(name, head.rows * head.columns);
  for (long long column = 0; column < head.columns; ++column) {
    for (long long row = 0; row < head.rows; ++row) {
      const double value = numbers.number(name);
      if (value != 0) triplets.emplace_back(int(row), int(column), value);
    }
  }
  return triplets;
}

// Where each block row or column starts, and the end of the last.
std::vector<long long> read_ends(NumberText& numbers, const std::string& label, long long count, long long size) {
  numbers.expect_room(label, count);
  std::vector<long long> starts = {0};
  for (long long i = 0; i < count; ++i)
    starts.push_back(numbers.count(label, i + 1 == count ? size : starts.back() + 1, size));
  return starts;
}

Triplets read_blocks(NumberText& numbers, const SiconosMatrixHead& head) {
  Triplets triplets;
  const long long blocks = numbers.count("number of blocks", 0, head.rows * head.columns);
  if (blocks == 0) return triplets;
  const long long block_rows = numbers.count("block rows", 1, head.rows),
                  block_columns = numbers.count("block columns", 1, head.columns);
  const std::vector<long long> rows = read_ends(numbers, "ends of block rows", block_rows, head.rows),
                               columns = read_ends(numbers, "ends of block columns", block_columns, head.columns);
  numbers.count("length of the row index", block_rows + 1, block_rows + 1);
  numbers.count("length of the column index", blocks, blocks);
  numbers.expect_room("the blocks", 2 * blocks);
  std::vector<long long> first, column;
  for (long long i = 0; i <= block_rows; ++i)
    first.push_back(numbers.count("row index", first.empty() ? 0 : first.back(), first.empty() ? 0 : blocks));
  if (first.back() != blocks) numbers.refuse("row index", "ends before the last block");
  for (long long i = 0; i < blocks; ++i) column.push_back(numbers.count("column index", 0, block_columns - 1));
  for (long long row = 0; row < block_rows; ++row) {
    for (long long k = first[row]; k < first[row + 1]; ++k) {
      if (k > first[row] && column[k] <= column[k - 1])
        numbers.refuse("column index", fmt::format("columns must rise within row {}", row));
      numbers.count("number of a block", k, k);
      const std::string label = fmt::format("block {}", k);
      for (long long c = columns[column[k]]; c < columns[column[k] + 1]; ++c) {
        for (long long r = rows[row]; r < rows[row + 1]; ++r)
          triplets.emplace_back(int(r), int(c), numbers.number(label));
      }
    }
  }
  return triplets;
}

// "1334-by-1334,"
void expect_size(NumberText& numbers, const std::string& name, std::string_view word, const SiconosMatrixHead& head) {
  const std::string size = fmt::format("{}-by-{},", head.rows, head.columns);
  if (word != size) numbers.refuse(name, fmt::format("must be '{}', is '{}'", size, word.substr(0, 40)));
}

// "nnz: 3822" or "nnz: 3822,"
long long read_entry_count(NumberText& numbers, const std::string& name) {
  numbers.expect_word("nzmax:", name);
  numbers.word(name);
  numbers.expect_word("nnz:", name);
  std::string_view word = numbers.word(name);
  if (word.ends_with(',')) word.remove_suffix(1);
  long long count = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), count);
  if (error != std::errc() || end != word.data() + word.size() || count < 0)
    numbers.refuse(name, fmt::format("must have a number of entries, has '{}'", word.substr(0, 40)));
  numbers.skip_line();
  numbers.expect_room(name, 3 * count);
  return count;
}

Triplets read_sparse(NumberText& numbers, const std::string& name, const SiconosMatrixHead& head) {
  Triplets triplets;
  const long long kind = numbers.count("kind of sparse matrix (1 triplets, 2 columns, 3 rows, 4 a triangle)", 1, 4);
  numbers.expect_word("CSparse", name);
  numbers.skip_line();
  const auto value = [&] {
    numbers.expect_word(":", name);
    return numbers.number(name);
  };
  if (kind == 1 || kind == 4) {
    numbers.expect_word("triplet:", name);
    expect_size(numbers, name, numbers.word(name), head);
    for (long long left = read_entry_count(numbers, name); left > 0; --left) {
      const long long row = numbers.count("row of an entry", 0, head.rows - 1),
                      column = numbers.count("column of an entry", 0, head.columns - 1);
      triplets.emplace_back(int(row), int(column), value());
    }
    return triplets;
  }
  const bool by_columns = kind == 2;
  if (!by_columns) numbers.expect_word("csr:", name);
  expect_size(numbers, name, numbers.word(name), head);
  const long long count = read_entry_count(numbers, name), outer = by_columns ? head.columns : head.rows,
                  inner = by_columns ? head.rows : head.columns;
  const std::string entry = by_columns ? "row of an entry" : "column of an entry";
  long long read = 0;
  for (long long k = 0; k < outer; ++k) {
    const std::string label = fmt::format("{} {}", by_columns ? "column" : "row", k);
    numbers.expect_word(by_columns ? "col" : "row", label);
    numbers.count(label, k, k);
    numbers.expect_word(":", label);
    numbers.expect_word("locations", label);
    numbers.count(label, read, read);
    numbers.expect_word("to", label);
    const long long last = numbers.count(label, read - 1, count - 1);
    for (; read <= last; ++read) {
      const long long i = numbers.count(entry, 0, inner - 1);
      triplets.emplace_back(int(by_columns ? i : k), int(by_columns ? k : i), value());
    }
  }
  if (read != count) numbers.refuse(name, fmt::format("must have {} entries, has {}", count, read));
  return triplets;
}

}  // namespace

SiconosMatrixHead read_siconos_head(NumberText& numbers, const std::string& name) {
  const std::string of = " of " + name;
  SiconosMatrixHead head;
  head.storage = numbers.count("storage" + of + " (0 dense, 1 by blocks, 2 sparse)", 0, 2);
  head.rows = numbers.count("rows" + of, 0, 6 * most_contacts);
  head.columns = numbers.count("columns" + of, 0, 6 * most_contacts);
  return head;
}

oracle::SparseMatrix read_siconos_matrix(NumberText& numbers, const std::string& name, const SiconosMatrixHead& head) {
  const Triplets triplets = head.storage == 0   ? read_dense(numbers, name, head)
                            : head.storage == 1 ? read_blocks(numbers, head)
                                                : read_sparse(numbers, name, head);
  oracle::SparseMatrix matrix(head.rows, head.columns);
  matrix.setFromTriplets(triplets.begin(), triplets.end());
  return matrix;
}

std::string_view siconos_storage_name(long long storage) { return storage_names.at(std::size_t(storage)); }

}  // namespace lockstep
