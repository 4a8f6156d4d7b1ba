// Linear complementarity problems from small text files, as the problem collections of Siconos keep them:
//   n, M (siconos_matrix.hpp), n numbers of q
// What follows is a remark and does not begin with a number: problems of other kinds (relays) have bounds there.
#pragma once

#include <filesystem>

#include "cpu_reference/oracle/lcp/lcp.hpp"

namespace lockstep {

/// Whether a file is one, as far as it begins like one: n, storage, n, n. Contact problems begin with dimension,
/// contacts, storage.
bool is_lcp_text(const std::filesystem::path& path);

/// Throws Error, one line with the file and the line in it, where the file is missing, ends early, holds a number that
/// is none or not finite, or contradicts itself about its size.
oracle::lcp::Lcp read_lcp_text(const std::filesystem::path& path);

}  // namespace lockstep
