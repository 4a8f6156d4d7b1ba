// The bytes of a file.
#pragma once

#include <cstddef>
#include <string>

namespace lockstep {

/// All bytes of a regular file; pipes and devices are not waited for. Throws std::runtime_error, without its name,
/// where it is none, cannot be read to its end, or has more bytes than `most`.
std::string read_regular_file(const std::string& path, std::size_t most);

}  // namespace lockstep
