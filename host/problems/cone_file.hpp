// Frictional contact problems in files: FCLIB (HDF5) and the texts of Siconos, in the local and in the global form,
// with rolling friction or without.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep {

struct ConeFile {
  std::string form;             // in words: "FCLIB, global"
  std::uint32_t dimension = 3;  // rows of a contact in the file: 2 in the plane, 3 in space, 5 with rolling friction
  oracle::ConeProblem problem;  // the local form, in space; two contacts for one with rolling friction (rolling.hpp)
  std::optional<oracle::GlobalConeProblem> global;  // where the file has it, its contacts as in `problem`
  std::optional<oracle::ConeImpulses> stored;       // whether they solve it, the error says

  std::uint32_t contacts_in_problem() const { return dimension == 5 ? 2 : 1; }  // for each of the file
  std::uint32_t contacts() const { return problem.contacts() / contacts_in_problem(); }
  Eigen::Index velocities() const;  // of the global form as the file has it, else 0
};

/// Impulses between the rows of the file and those of its problem.
Eigen::VectorXd impulses_in_problem(const ConeFile& file, const Eigen::VectorXd& r);
Eigen::VectorXd impulses_in_file(const ConeFile& file, const Eigen::VectorXd& r);

/// Reads any of them. Throws Error (input), one line naming the file, the location and what is wrong there, for a file
/// that is cut short, contradicts itself, holds what is no number, or has contacts of another dimension than those
/// above.
ConeFile read_cone_file(const std::string& path);

/// As FCLIB files, matrices in compressed columns. Blocks of rows of joints of more than one row are kept beside them,
/// where other readers do not look.
std::vector<unsigned char> encode_fclib(const oracle::ConeProblem& problem, const std::string& title,
                                        const std::optional<oracle::ConeImpulses>& stored = {});
std::vector<unsigned char> encode_fclib(const oracle::GlobalConeProblem& problem, const std::string& title,
                                        const std::optional<oracle::ConeImpulses>& stored = {});

/// As Siconos's text, by blocks. Throws Error (input) for a problem with joints, which it cannot hold.
std::string encode_siconos_text(const oracle::ConeProblem& problem);

}  // namespace lockstep
