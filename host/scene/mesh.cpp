#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <stdexcept>

#include "host/scene/read_hull.hpp"

namespace lockstep {

std::vector<Vector3> mesh_vertices(const std::string& path) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices);
  if (scene == nullptr) {
    std::string reason = importer.GetErrorString();
    for (char& c : reason)
      if (c == '\n' || c == '\r') c = ' ';
    throw std::runtime_error(reason);
  }
  std::vector<Vector3> points;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    for (unsigned i = 0; i < mesh.mNumVertices; ++i) {
      const aiVector3D& v = mesh.mVertices[i];
      points.push_back({static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)});
    }
  }
  if (points.empty()) throw std::runtime_error("it holds no mesh");
  return points;
}

}  // namespace lockstep
