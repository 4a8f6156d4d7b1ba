// Bodies and the joints between them as the two kinds of nodes of a graph, read from the matrices of the global form
// (cone_problem.hpp): the graph whose edges are the blocks of
//   K = [ M  -G ; -G^T  0 ]
// off its diagonal (Baraff, Linear-time dynamics using Lagrange multipliers, SIGGRAPH 1996; survey 4.4.1).
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep::oracle {

struct Mechanism {
  struct Joint {
    std::vector<Eigen::Index> rows;
    std::vector<std::uint32_t> bodies;  // rising; one alone is held by the world
  };
  std::vector<std::vector<Eigen::Index>> bodies;  // the velocities of each, rising
  std::vector<Joint> joints;                      // no two between the same bodies; none that no body sees
};

/// `bodies`: the first velocity of each body and the end of the last. Beyond that, and everywhere where it is empty,
/// velocities that M couples are one body; where it is empty and that fits, those of six in a row are as well, as in
/// files of the field. A grouping that is not that of the bodies makes loops where there are none, and no error.
/// `blocks`: the first column of G of each block of rows, and the end; blocks between the same bodies are one joint.
Mechanism mechanism_of(const SparseMatrix& m, const SparseMatrix& g, std::span<const std::uint32_t> bodies,
                       std::span<const std::uint32_t> blocks);

}  // namespace lockstep::oracle
