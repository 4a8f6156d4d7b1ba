// Frictional contact problems in files: FCLIB (HDF5) in its local and its global form, and the text format of Siconos.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "cpu_reference/oracle/cone_problem.hpp"

namespace lockstep {

struct ConeFile {
  std::string form;                                 // in words: "FCLIB, global"
  std::uint32_t dimension = 3;                      // of the file; the problem is in space, whatever it is
  oracle::ConeProblem problem;                      // the local form
  std::optional<oracle::GlobalConeProblem> global;  // where the file has it
  std::optional<oracle::ConeImpulses> stored;       // whether they solve it, the error says
};

/// Reads any of them. Throws Error (input), one line naming the file, the location and what is wrong there, for a file
/// that is cut short, contradicts itself, holds what is no number, or is in no dimension but two and three.
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
