// What solves a problem, in a file: HDF5 or text, written by `lockstep solve --solution`, read back by `--guess`.
//   HDF5   FCLIB's group `solution`: v, u, r, l, in the file of its problem where that is one of FCLIB, else alone
//   text   the same by name, each with how many numbers follow: "r 6", and a line for each contact; u and v in m/s, r
//   and
//          l in N s. Of linear complementarity problems z and w. To be read, a text may also be the numbers of r (of z)
//          alone, as other programs write them
// Rows are those of the problem's file: normal and tangents, with rolling friction two moments behind them.
#pragma once

#include "host/problems/cone_file.hpp"

namespace lockstep {

/// The names are FCLIB's: velocities v of the bodies (of the global form only), u of the contacts, impulses r of the
/// contacts and l of joints (where there are any).
struct ProblemSolution {
  Eigen::VectorXd v, u, r, l;
};

/// All of it, from the impulses.
ProblemSolution solution_of(const ConeFile& file, const oracle::ConeImpulses& impulses);

/// `problem`: the bytes of the problem's file.
std::vector<unsigned char> encode_solution(const ProblemSolution& solution, std::span<const unsigned char> problem);
std::vector<unsigned char> encode_solution_text(const ProblemSolution& solution, std::uint32_t dimension);
std::vector<unsigned char> encode_solution_text(const Eigen::VectorXd& z, const Eigen::VectorXd& w);

/// The impulses in a file of either kind. Throws Error (input), one line, where there are none or of another size.
oracle::ConeImpulses read_solution_file(const std::string& path, const ConeFile& file);

/// z of a linear complementarity problem with so many unknowns, from a text.
Eigen::VectorXd read_solution_text(const std::string& path, Eigen::Index unknowns);

}  // namespace lockstep
