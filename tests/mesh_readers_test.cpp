// The readers of mesh files, against assimp, against closed forms, and against what is no such file.
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <assimp/Importer.hpp>
#include <chrono>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "host/embedded.hpp"
#include "host/scene/mesh.hpp"
#include "host/scene/mesh_formats.hpp"
#include "host/scene/triangle_mesh.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::mesh_readers_test {
namespace {

std::string refusal_of(const std::function<TriangleMesh()>& read) {
  try {
    read();
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

std::string refusal_of_bytes(const std::string& name, const std::string& bytes) {
  const TemporaryFolder folder;
  std::ofstream(folder.file(name), std::ios::binary) << bytes;
  return refusal_of([&] { return read_mesh(folder.file(name)); });
}

TriangleMesh by_assimp(const std::string& text, const char* ending) {
  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFileFromMemory(
      text.data(), text.size(),
      aiProcess_PreTransformVertices | aiProcess_JoinIdenticalVertices | aiProcess_Triangulate, ending);
  TriangleMesh whole;
  if (scene == nullptr) return whole;
  for (unsigned m = 0; m < scene->mNumMeshes; ++m) {
    const aiMesh& mesh = *scene->mMeshes[m];
    const u32 first = static_cast<u32>(whole.vertices.size());
    for (unsigned i = 0; i < mesh.mNumVertices; ++i)
      whole.vertices.push_back({double(mesh.mVertices[i].x), double(mesh.mVertices[i].y), double(mesh.mVertices[i].z)});
    for (unsigned i = 0; i < mesh.mNumFaces; ++i)
      whole.triangles.push_back(
          {first + mesh.mFaces[i].mIndices[0], first + mesh.mFaces[i].mIndices[1], first + mesh.mFaces[i].mIndices[2]});
  }
  return whole;
}

// Golden hashes of scenes with meshes rest on each bit of these.
TEST(MeshReaders, BuiltInMeshesAreToTheBitWhatAssimpReads) {
  for (const EmbeddedFile& file : embedded_meshes()) {
    SCOPED_TRACE(file.name);
    const TriangleMesh ours = read_mesh(std::string(file.name)), theirs = by_assimp(std::string(file.text), "obj");
    ASSERT_GT(ours.triangles.size(), 100u);
    EXPECT_EQ(ours.vertices, theirs.vertices);
    EXPECT_EQ(ours.triangles, theirs.triangles);
  }
}

constexpr const char* square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

TEST(MeshReaders, ObjHasPolygonsNegativeCornersAndLinesThatGoOn) {
  const std::vector<Vector3> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  for (const char* face :
       {"f 1 2 3 4\n", "f -4 -3 -2 -1", "f 1/1 2/7/9 3//2 4 # seen from above\r\n", "f 1 2 \\\n3 4\n"}) {
    const TriangleMesh mesh = read_obj(std::string(square) + face);
    EXPECT_EQ(mesh.vertices, corners) << face;
    EXPECT_EQ(mesh.triangles, (std::vector<std::array<u32, 3>>{{0, 1, 2}, {0, 2, 3}})) << face;
  }
  EXPECT_EQ(read_obj("v 2 4 6 2\nv +1e0 2 3 1 1 1").vertices, (std::vector<Vector3>{{1, 2, 3}, {1, 2, 3}}));
  EXPECT_EQ(read_obj(std::string(square) + "l 1 2\np 3\nf 2 3 4\n").vertices.size(), 3u);
}

// The triangles of a polygon have its area, also where it is not convex.
TEST(MeshReaders, PolygonsAreCutWithoutOverlap) {
  TriangleMesh star;
  std::vector<u32> corners;
  for (u32 i = 0; i < 14; ++i) {
    const double r = i % 2 == 0 ? 2 : 0.5, a = 3.14159265358979 * i / 7;
    star.vertices.push_back({r * std::cos(a), r * std::sin(a), 0});
    corners.push_back(i);
  }
  add_polygon(corners, star);
  ASSERT_EQ(star.triangles.size(), 12u);
  double area = 0;
  for (const auto& [a, b, c] : star.triangles) {
    const Vector3 twice = exact::cross(exact::subtract(star.vertices[b], star.vertices[a]),
                                       exact::subtract(star.vertices[c], star.vertices[a]));
    EXPECT_GT(twice[2], 0);
    area += twice[2] / 2;
  }
  EXPECT_NEAR(area, 14 * 0.5 * 2 * 0.5 * std::sin(3.14159265358979 / 7), 1e-12);
}

TEST(MeshReaders, PlyIsReadInEachOrder) {
  const auto file = [](const std::string& format, const std::string& body) {
    return "ply\r\nformat " + format +
           " 1.0\ncomment made by hand\nelement vertex 4\nproperty uchar red\nproperty double x\nproperty float y\n"
           "property float z\nelement face 1\nproperty list uchar int vertex_indices\nproperty float "
           "quality\nend_header\n" +
           body;
  };
  std::string little, big;
  const auto append = [&](auto value) {
    std::array<char, sizeof(value)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(value));
    little.append(bytes.begin(), bytes.end());
    big.append(bytes.rbegin(), bytes.rend());
  };
  for (unsigned i = 0; i < 4; ++i) {
    append(static_cast<unsigned char>(7));
    append(i == 1 || i == 2 ? 1.0 : 0.0);
    append(i >= 2 ? 1.0f : 0.0f);
    append(0.25f);
  }
  append(static_cast<unsigned char>(4));
  for (const std::int32_t corner : {0, 1, 2, 3}) append(corner);
  append(0.5f);
  const std::string text = "7 0 0 .25\n7 1 0 0.25\n7 1 1 0.25 7 0 1 0.25\n4 0 1 2 3 0.5\n";
  for (const std::string& bytes :
       {file("ascii", text), file("binary_little_endian", little), file("binary_big_endian", big)}) {
    const TriangleMesh mesh = read_ply(bytes);
    EXPECT_EQ(mesh.vertices, (std::vector<Vector3>{{0, 0, 0.25}, {1, 0, 0.25}, {1, 1, 0.25}, {0, 1, 0.25}}));
    EXPECT_EQ(mesh.triangles.size(), 2u);
  }
}

const std::string triangle_gltf =
    R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}],
  "nodes": [{"children": [1], "translation": [0, 0, 5]}, {"mesh": 0, "scale": [2, 3, 4], "rotation": [0, 0, 0.70710678, 0.70710678]}],
  "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
  "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
  "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "corners.bin"}]})";

std::string corners_of_triangle() {
  const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
  return {reinterpret_cast<const char*>(corners), sizeof(corners)};
}

TEST(MeshReaders, GltfAppliesTheFramesOfItsNodes) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("one.gltf")) << triangle_gltf;
  std::ofstream(folder.file("corners.bin"), std::ios::binary) << corners_of_triangle();
  const TriangleMesh mesh = read_mesh(folder.file("one.gltf"));
  ASSERT_EQ(mesh.vertices.size(), 3u);
  const Vector3 expected[] = {{0, 0, 5}, {0, 2, 5}, {-3, 0, 5}};
  for (unsigned i = 0; i < 3; ++i)
    for (unsigned k = 0; k < 3; ++k) EXPECT_NEAR(mesh.vertices[i][k], expected[i][k], 1e-6);
}

TEST(MeshReaders, NoNameIsFollowedOutOfTheFolder) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.file("inner"));
  std::ofstream(folder.file("corners.bin"), std::ios::binary) << corners_of_triangle();
  for (const std::string& uri : {std::string("../corners.bin"), folder.file("corners.bin"), std::string("link.bin")}) {
    std::string text = triangle_gltf;
    text.replace(text.find("corners.bin"), 11, uri);
    std::ofstream(folder.file("inner/one.gltf")) << text;
    std::error_code ignored;
    std::filesystem::create_symlink(folder.file("corners.bin"), folder.file("inner/link.bin"), ignored);
    EXPECT_NE(refusal_of([&] { return read_mesh(folder.file("inner/one.gltf")); }).find("not in its folder"),
              std::string::npos)
        << uri;
  }
}

TEST(MeshReaders, PipesAreNotWaitedFor) {
  const TemporaryFolder folder;
  for (const char* name : {"mesh.obj", "mesh.ply", "mesh.stl", "mesh.dae", "mesh.gltf"}) {
    ASSERT_EQ(mkfifo(folder.file(name).c_str(), 0600), 0);
    EXPECT_EQ(refusal_of([&] { return read_mesh(folder.file(name)); }), "is no regular file") << name;
  }
  ASSERT_EQ(mkfifo(folder.file("paint.mtl").c_str(), 0600), 0);
  std::ofstream(folder.file("with.obj")) << "mtllib paint.mtl\nusemtl red\n" << square << "f 1 2 3\n";
  EXPECT_EQ(read_mesh(folder.file("with.obj")).triangles.size(), 1u);
}

TEST(MeshReaders, WhatIsCutOrOutOfBoundsIsRefusedInOneLine) {
  const std::string ply = "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nelement face 1\n";
  const struct {
    const char* name;
    std::string bytes;
    const char* line;
  } cases[] = {
      {"a.obj", std::string(square) + "f 1 2 5\n", "line 5 has the corner \"5\""},
      {"a.obj", "v 1 2\n", "line 1 must have three numbers"},
      {"a.obj", "v 1 2 x\n", "must have numbers, has \"x\""},
      {"a.obj", "v 1 2 3 0\n", "infinity"},
      {"a.obj", "f 1 2 3\n", "one of the 0 vertices"},
      {"a.obj", std::string(square) + "f 99999999999999999999 1 2\n", "has the corner"},
      {"a.obj", "", "it has no mesh"},
      {"a.stl", "", "is no STL file"},
      {"a.stl", std::string(80, ' ') + std::string("\xff\xff\xff\x7f", 4), "is cut short"},
      {"a.stl", "solid x\nfacet\nouter loop\nvertex 1 2 3\nendloop", "three corners"},
      {"a.stl", "solid x\nvertex 1 2 three", "must have three numbers, has \"three\""},
      {"a.ply", "", "is no PLY file"},
      {"a.ply", "ply\nformat ascii 1.0\nelement vertex 4000000000\nproperty float x\nend_header\n1 2 3",
       "it announces 4000000000"},
      {"a.ply", ply + "property list uchar int vertex_index\nend_header\n0\n3 0 1 2\n", "the vertex 1 of 1"},
      {"a.ply", ply + "property list uchar int vertex_index\nend_header\n0\n-3 0 1 2\n", "whole numbers"},
      {"a.ply", ply + "property list uchar int vertex_index\nend_header\n0\n3 0", "is cut short"},
      {"a.ply", ply + "end_header\n0\n", "says nothing of its 1 \"face\""},
      {"a.ply", "ply\nformat ascii 1.0\nelement vertex 1\nproperty quad x\nend_header\n1", "unknown type \"quad\""},
      {"a.ply", "ply\nformat utf9 1.0\nend_header\n", "unknown format"},
      {"a.ply", "ply\nformat ascii 1.0\n", "has no end_header"},
      {"a.gltf", "{", "not JSON"},
      {"a.gltf", R"({"asset": {"version": "1.0"}})", "/asset/version: must be 2.0"},
      {"a.gltf", R"({"asset": {"version": "2.0"}, "extensionsRequired": ["KHR_draco_mesh_compression"]})",
       "is not known"},
      {"a.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [0]}], "nodes": [{"children": [0]}]})",
       "a second time"},
      {"a.gltf", R"({"asset": {"version": "2.0"}, "scenes": [{"nodes": [7]}], "nodes": [{}]})", "/scenes/0/nodes/0"},
      {"a.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "data:;base64,AAA="}]})",
       "has 2 bytes"},
      {"a.gltf", R"({"asset": {"version": "2.0"}, "buffers": [{"byteLength": 4, "uri": "none.bin"}]})",
       "cannot be opened"},
      {"a.glb", "glTF\2\0\0\0", "is no binary glTF file"},
      {"a.off", "OFF\n3 1 0\n", "a"},
      {"a.dae", "<COLLADA/>", "a"},
      {"a.xyz", "nothing", "a"},
  };
  for (const auto& [name, bytes, line] : cases) {
    const std::string refusal = refusal_of_bytes(name, bytes);
    EXPECT_NE(refusal.find(line), std::string::npos) << name << ": " << bytes << ": " << refusal;
  }
}

// What assimp overflows its stack on, or does not end with, ends a child.
TEST(MeshReaders, AssimpCannotEndTheProcess) {
  std::string nodes;
  for (int i = 0; i < 200000; ++i) nodes += "<node>";
  const std::string deep =
      "<?xml version=\"1.0\"?><COLLADA version=\"1.4.1\"><asset/><library_visual_scenes><visual_scene id=\"s\">" +
      nodes + "</visual_scene></library_visual_scenes></COLLADA>";
  const std::string cyclic =
      R"(<?xml version="1.0"?><COLLADA version="1.4.1"><asset/><library_nodes><node id="a"><instance_node url="#a"/></node></library_nodes>
      <library_visual_scenes><visual_scene id="s"><node><instance_node url="#a"/></node></visual_scene></library_visual_scenes>
      <scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
  const auto begin = std::chrono::steady_clock::now();
  for (const std::string& text : {deep, cyclic}) EXPECT_NE(refusal_of_bytes("a.dae", text), "");
  EXPECT_NE(refusal_of_bytes("a.off", "OFF\n1000000000 1 0\n0 0 0\n"), "");
  EXPECT_LT(std::chrono::steady_clock::now() - begin, std::chrono::seconds(40));
}

}  // namespace
}  // namespace lockstep::mesh_readers_test
