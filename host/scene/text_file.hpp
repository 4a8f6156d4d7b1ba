// Files of text that describe scenes.
#pragma once

#include <string>

namespace lockstep {

/// Throws Error (input) where it cannot be read to its end, or is larger than 64 MiB.
std::string read_text_file(const std::string& path);

}  // namespace lockstep
