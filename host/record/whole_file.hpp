// Files that are there whole or not at all.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace lockstep {

/// Throws Error (input) where a file of this name could not be written, or where there is one that is not ours: one
/// that does not start with `signature`. An empty path is always good.
void expect_writable(const std::string& path, const std::string& what, std::string_view signature);

/// Writes beside the file and then puts it in its place, so that a crash leaves the old one or the new one. Throws
/// Error (device) where the disk does not take it.
void replace_file(const std::string& path, std::span<const unsigned char> bytes);

/// Throws Error (input) where there is no such file or it cannot be read to its end.
std::vector<unsigned char> read_whole_file(const std::string& path);

}  // namespace lockstep
