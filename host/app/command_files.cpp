#include "host/app/command_files.hpp"

#include <fmt/format.h>
#include <sys/stat.h>

#include <filesystem>
#include <optional>
#include <vector>

#include "host/error.hpp"

namespace lockstep::app {

namespace {

// A file that is there is known by its inode, one that is not by the inode of its folder and its name.
struct Identity {
  dev_t device;
  ino_t inode;
  std::string name;

  bool operator==(const Identity&) const = default;
};

std::optional<Identity> identity_of(const std::string& path) {
  struct stat status;
  if (::stat(path.c_str(), &status) == 0) {
    if (!S_ISREG(status.st_mode)) return {};
    return Identity{status.st_dev, status.st_ino, ""};
  }
  const std::filesystem::path name = path, folder = name.has_parent_path() ? name.parent_path() : ".";
  if (::stat(folder.c_str(), &status) != 0) return {};  // who writes it says so
  return Identity{status.st_dev, status.st_ino, name.filename()};
}

}  // namespace

CLI::Option* add_file_option(CLI::App& command, const char* names, std::string& path, const std::string& meaning) {
  const auto check = [](const std::string& text) {
    return text.empty() ? std::string("must be the name of a file, is empty") : std::string();
  };
  return command.add_option(names, path, meaning)->check(CLI::Validator(check, ""));
}

void expect_separate(std::initializer_list<CommandFile> outputs, std::initializer_list<CommandFile> inputs) {
  struct Known {
    const CommandFile* file;
    Identity identity;
  };
  std::vector<Known> known;
  // a name that is not there is no file but a built-in scene
  for (const CommandFile& input : inputs) {
    if (input.path.empty()) continue;
    const std::optional<Identity> identity = identity_of(input.path);
    if (identity && identity->name.empty()) known.push_back({&input, *identity});
  }
  for (const CommandFile& output : outputs) {
    if (output.path.empty()) continue;
    const std::optional<Identity> identity = identity_of(output.path);
    if (!identity) continue;
    for (const Known& other : known)
      if (other.identity == *identity)
        throw Error(Failure::input, output.option,
                    fmt::format("'{}' is the file of {}, too; name another one", output.path, other.file->option));
    known.push_back({&output, *identity});
  }
}

}  // namespace lockstep::app
