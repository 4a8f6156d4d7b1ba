#include "host/scene/mesh.hpp"

#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <algorithm>
#include <array>
#include <assimp/Importer.hpp>
#include <cctype>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>

#include "host/embedded.hpp"

namespace lockstep {

namespace {

const EmbeddedFile* find_embedded(const std::string& path) {
  const auto files = embedded_meshes();
  const auto found = std::find_if(files.begin(), files.end(), [&](const EmbeddedFile& f) { return f.name == path; });
  return found == files.end() ? nullptr : &*found;
}

}  // namespace

std::size_t triangles_announced(const std::string& path) {
  if (is_embedded_mesh(path)) return 0;
  std::string ending = std::filesystem::path(path).extension().string();
  std::ranges::transform(ending, ending.begin(), [](unsigned char c) { return std::tolower(c); });
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
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, true);  // numbers as the file gives them
  const unsigned steps = aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices | aiProcess_Triangulate;
  const EmbeddedFile* embedded = find_embedded(path);
  const aiScene* scene = embedded != nullptr
                             ? importer.ReadFileFromMemory(embedded->text.data(), embedded->text.size(), steps, "obj")
                             : importer.ReadFile(path, steps);
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason)
      if (c == '\n' || c == '\r') c = ' ';
    throw std::runtime_error(reason);
  }
  TriangleMesh whole;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const u32 first = static_cast<u32>(whole.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      whole.vertices.push_back({static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)});
    }
    for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
      const aiFace& face = mesh.mFaces[i];  // points and lines bound nothing
      if (face.mNumIndices == 3)
        whole.triangles.push_back({first + face.mIndices[0], first + face.mIndices[1], first + face.mIndices[2]});
    }
  }
  if (whole.vertices.empty()) throw std::runtime_error("it holds no mesh");
  return whole;
}

}  // namespace lockstep
