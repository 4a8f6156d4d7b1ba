#include "host/scene/package_files.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <sstream>
#include <vector>

#include "host/scene/json_node.hpp"
#include "host/scene/mesh.hpp"

namespace lockstep {

namespace {

namespace fs = std::filesystem;

std::string in_small_letters(std::string name) {
  std::ranges::transform(name, name.begin(), [](unsigned char c) { return std::tolower(c); });
  return name;
}

// The file of a path; else the first by name that differs in the case of letters alone.
std::optional<std::string> existing(const fs::path& path) {
  std::error_code ignored;
  if (is_embedded_mesh(path.string()) || fs::is_regular_file(path, ignored)) return path.lexically_normal().string();
  const std::string wanted = in_small_letters(path.filename().string());
  std::vector<std::string> found;
  const fs::path folder = path.has_parent_path() ? path.parent_path() : fs::path(".");
  for (const auto& entry : fs::directory_iterator(folder, ignored))
    if (in_small_letters(entry.path().filename().string()) == wanted) found.push_back(entry.path().string());
  if (found.empty()) return std::nullopt;
  return fs::path(std::ranges::min(found)).lexically_normal().string();
}

std::optional<std::string> in_package(const fs::path& robot, const fs::path& rest,
                                      const std::map<std::string, std::string>& packages) {
  const std::string name = rest.begin() == rest.end() ? "" : rest.begin()->string();
  fs::path below;
  for (auto piece = rest.begin(); piece != rest.end(); ++piece)
    if (piece != rest.begin()) below /= *piece;
  if (const auto given = packages.find(name); given != packages.end()) return existing(fs::path(given->second) / below);
  std::error_code ignored;
  for (fs::path above = fs::absolute(robot.parent_path(), ignored);; above = above.parent_path()) {
    if (const auto file = existing(above / rest)) return file;
    if (above == above.parent_path()) break;
  }
  const char* folders = std::getenv("ROS_PACKAGE_PATH");
  std::istringstream all(folders == nullptr ? "" : folders);
  for (std::string folder; std::getline(all, folder, ':');) {
    if (folder.empty()) continue;
    if (const auto file = existing(fs::path(folder) / rest)) return file;
    if (fs::path(folder).filename() != name) continue;
    if (const auto file = existing(fs::path(folder) / below)) return file;
  }
  return std::nullopt;
}

}  // namespace

std::string robot_file_path(const XmlNode& node, const char* attribute,
                            const std::map<std::string, std::string>& packages) {
  const std::string name = node.text(attribute);
  const fs::path robot = node.source();
  constexpr std::string_view package = "package://", file = "file://";
  if (name.starts_with(package)) {
    const fs::path rest = fs::path(name.substr(package.size())).relative_path();
    if (const auto found = in_package(robot, rest, packages)) return *found;
    node.fail(attribute, fmt::format("{} is in no folder above the robot's file; say where its package is by "
                                     "--package NAME=FOLDER or ROS_PACKAGE_PATH, or give a path from its file",
                                     quote(name)));
  }
  if (name.find("://") != name.npos && !name.starts_with(file))
    node.fail(attribute, fmt::format("{} is no file here; give a path from the robot's file", quote(name)));
  const fs::path path = name.starts_with(file) ? fs::path(name.substr(file.size())) : robot.parent_path() / name;
  if (const auto found = existing(path.lexically_normal())) return *found;
  node.fail(attribute, fmt::format("names no file: {} does not exist; a mesh is looked for from the folder of the "
                                   "robot's file",
                                   quote(name)));
}

}  // namespace lockstep
