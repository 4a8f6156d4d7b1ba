// Linear complementarity problems from small text files, as the problem collections of Siconos keep them:
//   n
//   0 n n        a dense matrix follows
//   n n          its size once more
//   n * n numbers of M, column after column
//   n numbers of q
// What follows is a remark.
#pragma once

#include <filesystem>

#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep {

/// Whether a file is one, as far as its first two numbers say: of contact problems the second is the number of
/// contacts.
bool is_lcp_text(const std::filesystem::path& path);

/// Throws Error, one line with the file and the line in it, where the file is missing, ends early, holds a number that
/// is none or not finite, or contradicts itself about its size.
oracle::lcp::Lcp read_lcp_text(const std::filesystem::path& path);

}  // namespace lockstep
