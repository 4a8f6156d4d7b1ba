// Files that are there whole or not at all.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace lockstep {

/// Whether a file of this name could be made, tried under another one: who waits for the file is not to find it empty.
bool can_be_made(const std::string& path);

/// Throws Error (input) where a file of this name could not be written, or where there is one that is not ours: one
/// that does not have `signature` at this offset. An empty path is always good.
void expect_writable(const std::string& path, const std::string& what, std::string_view signature,
                     std::size_t offset = 0);

/// A file that nobody else has opened, beside `path` and with the mode of the one that is there, for it to take its
/// place; its name is `name`. Negative where it cannot be made, errno says why.
int make_beside(const std::string& path, std::string& name);

/// A file that gets its name when it is whole, so that a crash leaves the old one or the new one; gone again unless it
/// gets it. Everything throws Error (device) where the disk does not take it.
class NewFile {
 public:
  explicit NewFile(const std::string& path);
  ~NewFile();
  NewFile(const NewFile&) = delete;
  NewFile& operator=(const NewFile&) = delete;

  /// Behind what was written so last.
  void write(std::span<const unsigned char> bytes);
  /// Anywhere, in any order.
  void write_at(std::uint64_t offset, std::span<const unsigned char> bytes);
  void publish();

 private:
  [[noreturn]] void fail() const;

  std::string path_, name_;
  int descriptor_ = -1;
};

/// The same with all its bytes at once.
void replace_file(const std::string& path, std::span<const unsigned char> bytes);

/// Throws Error (input) where there is no such file or it cannot be read to its end.
std::vector<unsigned char> read_whole_file(const std::string& path);

}  // namespace lockstep
