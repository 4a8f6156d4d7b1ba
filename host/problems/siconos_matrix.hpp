// Matrices as Siconos's texts have them: storage, rows, columns, and what the storage asks for.
//   0  dense      rows, columns once more, the entries column by column
//   1  blocks     their number b (of 0 blocks nothing follows), block rows, block columns, ends of block rows, ends of
//                 block columns, length of the row index and of the column index, both, then of each block its number
//                 and its entries column by column
//   2  sparse     1 triplets, 2 columns, 3 rows or 4 triplets of one triangle, and what CSparse prints: a line with its
//                 name, a line with the size, and the entries: "row column : value", or after "col j : locations a to
//                 b" (rows alike) "row : value"
#pragma once

#include "cpu_reference/oracle/cone_problem.hpp"
#include "host/problems/number_text.hpp"

namespace lockstep {

struct SiconosMatrixHead {
  long long storage = 0, rows = 0, columns = 0;
};

/// Its first three numbers; `name` is for complaints.
SiconosMatrixHead read_siconos_head(NumberText& numbers, const std::string& name);

/// What follows them. Throws Error (input), one line with the line in the file, where it contradicts itself.
oracle::SparseMatrix read_siconos_matrix(NumberText& numbers, const std::string& name, const SiconosMatrixHead& head);

/// "dense", "by blocks", "sparse"
std::string_view siconos_storage_name(long long storage);

}  // namespace lockstep
