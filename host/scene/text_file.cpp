#include "host/scene/text_file.hpp"

#include <filesystem>
#include <fstream>

#include "host/error.hpp"

namespace lockstep {

namespace {

constexpr std::size_t largest_file = 64u << 20;

}  // namespace

std::string read_text_file(const std::string& path) {
  std::error_code ignored;
  if (std::filesystem::is_directory(path, ignored))
    throw Error(Failure::input, path, "is a directory, must be a JSON file");
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(Failure::input, path, "cannot be opened for reading; check its permissions");
  std::string text, piece(1u << 16, '\0');
  while (file.read(piece.data(), static_cast<std::streamsize>(piece.size())), file.gcount() > 0) {
    text.append(piece, 0, static_cast<std::size_t>(file.gcount()));
    if (text.size() > largest_file) {
      throw Error(Failure::input, path, "is larger than 64 MiB; place many bodies with generators");
    }
  }
  if (file.bad()) throw Error(Failure::input, path, "cannot be read to its end");
  return text;
}

}  // namespace lockstep
