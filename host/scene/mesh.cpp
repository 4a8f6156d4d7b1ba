#include "host/scene/mesh.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "host/embedded.hpp"
#include "host/scene/json_node.hpp"
#include "host/scene/mesh_formats.hpp"
#include "host/scene/regular_file.hpp"

namespace lockstep {

namespace {

const EmbeddedFile* find_embedded(const std::string& path) {
  const auto files = embedded_meshes();
  const auto found = std::find_if(files.begin(), files.end(), [&](const EmbeddedFile& f) { return f.name == path; });
  return found == files.end() ? nullptr : &*found;
}

// Of a name, in small letters.
std::string ending_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

constexpr std::size_t largest_mesh_file = std::size_t{1} << 30;

std::string read_mesh_bytes(const std::string& path) { return read_regular_file(path, largest_mesh_file); }

// The bytes of what a file names beside it.
std::string read_beside(const std::string& path, const std::string& name) {
  const std::filesystem::path folder = std::filesystem::weakly_canonical(path).parent_path(),
                              file = std::filesystem::weakly_canonical(folder / name),
                              from = file.lexically_relative(folder);
  if (from.empty() || *from.begin() == "..")
    throw std::runtime_error(fmt::format("names the file {}, which is not in its folder", quote(name)));
  return read_mesh_bytes(file.string());
}

TriangleMesh read_bytes(const std::string& path) {
  const std::string ending = ending_of(path), bytes = read_mesh_bytes(path);
  if (ending == ".obj") return read_obj(bytes);
  if (ending == ".stl") return read_stl(bytes);
  if (ending == ".ply") return read_ply(bytes);
  if (ending == ".gltf" || ending == ".glb")
    return read_gltf(bytes, path, [&](const std::string& name) { return read_beside(path, name); });
  return read_by_assimp(bytes, ending.empty() ? "" : ending.substr(1));
}

}  // namespace

std::size_t triangles_announced(const std::string& path) {
  std::error_code ignored;
  if (is_embedded_mesh(path) || !std::filesystem::is_regular_file(path, ignored)) return 0;
  const std::string ending = ending_of(path);
  std::ifstream file(path, std::ios::binary);
  std::size_t count = 0;
  std::string line;
  if (ending == ".stl") {
    std::array<char, 84> header = {};
    u32 announced = 0;
    if (!file.read(header.data(), header.size())) return 0;
    std::memcpy(&announced, header.data() + 80, sizeof announced);
    std::error_code failed;
    const auto bytes = std::filesystem::file_size(path, failed);
    return !failed && bytes == 84 + std::uintmax_t{50} * announced ? announced : 0;
  }
  if (ending == ".ply") {
    while (std::getline(file, line) && !line.starts_with("end_header"))
      if (line.starts_with("element face ")) count = std::strtoull(line.c_str() + 13, nullptr, 10);
    return count;
  }
  if (ending != ".obj") return 0;
  while (std::getline(file, line)) count += line.starts_with("f ");
  return count;
}

bool is_embedded_mesh(const std::string& path) { return find_embedded(path) != nullptr; }

TriangleMesh read_mesh(const std::string& path) {
  const EmbeddedFile* embedded = find_embedded(path);
  TriangleMesh mesh = embedded != nullptr ? read_obj(embedded->text) : read_bytes(path);
  if (mesh.vertices.empty()) throw std::runtime_error("it has no mesh");
  return mesh;
}

}  // namespace lockstep
