// Meshes come in many kinds of files: one brick, written in each of them, is read as one solid.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <fstream>
#include <optional>

#include "host/scene/read.hpp"
#include "host/scene/sample_particles.hpp"
#include "host/scene/triangle_mesh.hpp"
#include "tests/temporary_folder.hpp"

namespace lockstep::mesh_files_test {
namespace {

using Corners = std::array<unsigned, 3>;

constexpr std::array<float, 3> half = {0.25f, 0.5f, 0.75f};
constexpr Corners triangles[] = {{0, 2, 3}, {0, 3, 1}, {4, 5, 7}, {4, 7, 6}, {0, 1, 5}, {0, 5, 4},
                                 {2, 6, 7}, {2, 7, 3}, {0, 4, 6}, {0, 6, 2}, {1, 3, 7}, {1, 7, 5}};

float coordinate(unsigned corner, unsigned axis) { return corner >> axis & 1 ? half[axis] : -half[axis]; }

std::string spaced(unsigned corner) {
  std::string text;
  for (unsigned axis = 0; axis < 3; ++axis) text += " " + std::to_string(coordinate(corner, axis));
  return text;
}

template <class T>
void append(std::string& bytes, T value) {
  static_assert(std::endian::native == std::endian::little);
  char raw[sizeof(T)];
  std::memcpy(raw, &value, sizeof(T));
  bytes.append(raw, sizeof(T));
}

std::string as_obj() {
  std::string text;
  for (unsigned i = 0; i < 8; ++i) text += "v" + spaced(i) + "\n";
  for (const Corners& t : triangles) {
    text += "f";
    for (const unsigned corner : t) text += " " + std::to_string(corner + 1);
    text += "\n";
  }
  return text;
}

std::string as_ply() {
  std::string text =
      "ply\nformat ascii 1.0\nelement vertex 8\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
  for (unsigned i = 0; i < 8; ++i) text += spaced(i).substr(1) + "\n";
  for (const Corners& t : triangles) {
    text += "3";
    for (const unsigned corner : t) text += " " + std::to_string(corner);
    text += "\n";
  }
  return text;
}

std::string as_stl_text() {
  std::string text = "solid brick\n";
  for (const Corners& t : triangles) {
    text += "facet normal 0 0 0\nouter loop\n";
    for (const unsigned corner : t) text += "vertex" + spaced(corner) + "\n";
    text += "endloop\nendfacet\n";
  }
  return text + "endsolid brick\n";
}

std::string as_stl() {
  std::string bytes(80, ' ');
  append(bytes, std::uint32_t{12});
  for (const Corners& t : triangles) {
    for (unsigned axis = 0; axis < 3; ++axis) append(bytes, 0.0f);
    for (const unsigned corner : t)
      for (unsigned axis = 0; axis < 3; ++axis) append(bytes, coordinate(corner, axis));
    append(bytes, std::uint16_t{0});
  }
  return bytes;
}

std::string base64(const std::string& bytes) {
  const std::string digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string text;
  for (std::size_t i = 0; i < bytes.size(); i += 3) {  // whose number is divisible by three
    unsigned word = 0;
    for (std::size_t k = 0; k < 3; ++k) word = word << 8 | static_cast<unsigned char>(bytes[i + k]);
    for (int shift = 18; shift >= 0; shift -= 6) text += digits[word >> shift & 63];
  }
  return text;
}

std::string as_gltf() {
  std::string bytes;
  for (unsigned i = 0; i < 8; ++i)
    for (unsigned axis = 0; axis < 3; ++axis) append(bytes, coordinate(i, axis));
  for (const Corners& t : triangles)
    for (const unsigned corner : t) append(bytes, static_cast<std::uint16_t>(corner));
  return R"({"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
    "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
    "accessors": [{"bufferView": 0, "componentType": 5126, "count": 8, "type": "VEC3",
                   "min": [-0.25, -0.5, -0.75], "max": [0.25, 0.5, 0.75]},
                  {"bufferView": 1, "componentType": 5123, "count": 36, "type": "SCALAR"}],
    "bufferViews": [{"buffer": 0, "byteLength": 96}, {"buffer": 0, "byteOffset": 96, "byteLength": 72}],
    "buffers": [{"byteLength": 168, "uri": "data:application/octet-stream;base64,)" +
         base64(bytes) + "\"}]}";
}

std::string as_dae() {
  std::string numbers, corners;
  for (unsigned i = 0; i < 8; ++i) numbers += spaced(i);
  for (const Corners& t : triangles)
    for (const unsigned corner : t) corners += " " + std::to_string(corner);
  return R"(<?xml version="1.0"?><COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
    <asset><unit meter="1"/><up_axis>Z_UP</up_axis></asset>
    <library_geometries><geometry id="brick"><mesh>
      <source id="places"><float_array id="numbers" count="24">)" +
         numbers + R"(</float_array><technique_common><accessor source="#numbers" count="8" stride="3">
        <param name="X" type="float"/><param name="Y" type="float"/><param name="Z" type="float"/>
        </accessor></technique_common></source>
      <vertices id="corners"><input semantic="POSITION" source="#places"/></vertices>
      <triangles count="12"><input semantic="VERTEX" source="#corners" offset="0"/><p>)" +
         corners + R"(</p></triangles></mesh></geometry></library_geometries>
    <library_visual_scenes><visual_scene id="all"><node><instance_geometry url="#brick"/></node></visual_scene>
    </library_visual_scenes><scene><instance_visual_scene url="#all"/></scene></COLLADA>)";
}

TEST(MeshFiles, ABrickIsTheSameSolidInAllOfThem) {
  const std::pair<const char*, std::string> files[] = {{"brick.obj", as_obj()},     {"brick.ply", as_ply()},
                                                       {"text.stl", as_stl_text()}, {"brick.stl", as_stl()},
                                                       {"brick.gltf", as_gltf()},   {"z_up.dae", as_dae()}};
  const TemporaryFolder folder;
  std::optional<std::vector<Vector3>> particles;
  for (const auto& [name, content] : files) {
    SCOPED_TRACE(name);
    std::ofstream(folder.file(name), std::ios::binary) << content;
    const std::string scene_file = folder.file("scene.json");
    std::ofstream(scene_file) << R"({"particles": {"radius": 0.1, "stiffness": 1000}, "settings": {"dt": 0.001},
      "bodies": [{"density": 1000, "shapes": [{"type": "mesh", "mesh": ")"
                              << name << R"("}]}]})";
    const Scene scene = read_scene(scene_file);
    const BodyDescription& body = scene.bodies.at(0);
    EXPECT_NEAR(body.mass, 1000 * 0.5 * 1 * 1.5, 1e-9);
    EXPECT_EQ(body.position, (Vector3{0, 0, 0}));
    std::array<double, 3> moments = {body.inertia[0], body.inertia[1], body.inertia[2]};
    std::sort(moments.begin(), moments.end());
    EXPECT_NEAR(moments[0], body.mass / 12 * (0.25 + 1), 1e-9);
    EXPECT_NEAR(moments[1], body.mass / 12 * (0.25 + 2.25), 1e-9);
    EXPECT_NEAR(moments[2], body.mass / 12 * (1 + 2.25), 1e-9);
    ParticleSampler sampler(*scene.particles);
    std::string refusal;
    const std::vector<Vector3> found = sampler.of(body, refusal).at(0);
    EXPECT_EQ(refusal, "");
    EXPECT_GT(found.size(), 100u);
    for (const Vector3& of_body : found) {
      const Vector3 p = exact::rotate(body.orientation, of_body);
      for (unsigned axis = 0; axis < 3; ++axis) ASSERT_LE(std::abs(p[axis]), double(half[axis]) - 0.1 + 1e-6);
    }
    if (!particles) particles = found;
    EXPECT_NEAR(double(found.size()), double(particles->size()), 0.1 * double(particles->size()))
        << "the order of triangles may be another";
  }
}

}  // namespace
}  // namespace lockstep::mesh_files_test
