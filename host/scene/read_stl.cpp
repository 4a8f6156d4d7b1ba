#include <fmt/format.h>

#include <bit>
#include <cstring>
#include <stdexcept>

#include "host/scene/json_node.hpp"
#include "host/scene/mesh_formats.hpp"
#include "host/scene/number_scan.hpp"

namespace lockstep {

namespace {

static_assert(std::endian::native == std::endian::little);

constexpr std::size_t stl_header = 84, stl_triangle = 50;

void add_corner(TriangleMesh& mesh, const Vector3& corner) {
  mesh.vertices.push_back(corner);
  if (mesh.vertices.size() % 3 != 0) return;
  const u32 last = static_cast<u32>(mesh.vertices.size()) - 1;
  mesh.triangles.push_back({last - 2, last - 1, last});
}

TriangleMesh read_binary_stl(std::string_view bytes, u32 count) {
  TriangleMesh mesh;
  for (u32 t = 0; t < count; ++t) {
    for (std::size_t corner = 0; corner < 3; ++corner) {
      float p[3];
      std::memcpy(p, bytes.data() + stl_header + stl_triangle * t + sizeof(p) * (1 + corner), sizeof(p));
      add_corner(mesh, {p[0], p[1], p[2]});
    }
  }
  return mesh;
}

TriangleMesh read_stl_text(std::string_view text) {
  TriangleMesh mesh;
  NumberScan scan(text);
  for (std::string_view word = scan.word(); !word.empty(); word = scan.word()) {
    if (word == "solid") scan.line();  // and a name
    if (word == "outer" && mesh.vertices.size() % 3 != 0) throw std::runtime_error("a facet has not three corners");
    if (word != "vertex") continue;
    Vector3 corner;
    for (double& x : corner) {
      const std::string_view at = scan.word();
      const auto number = float_in(at);
      if (!number)
        throw std::runtime_error(fmt::format("vertex must have three numbers, has {}", quote(std::string(at))));
      x = *number;
    }
    add_corner(mesh, corner);
  }
  if (mesh.vertices.size() % 3 != 0) throw std::runtime_error("its last facet has not three corners");
  return mesh;
}

}  // namespace

TriangleMesh read_stl(std::string_view bytes) {
  u32 count = 0;
  if (bytes.size() >= stl_header) std::memcpy(&count, bytes.data() + stl_header - sizeof(count), sizeof(count));
  const std::size_t needed = stl_header + stl_triangle * count;
  if (bytes.size() == needed) return read_binary_stl(bytes, count);
  if (NumberScan(bytes).word() == "solid") return read_stl_text(bytes);
  if (bytes.size() > needed) return read_binary_stl(bytes, count);
  throw std::runtime_error(
      bytes.size() < stl_header
          ? fmt::format("is no STL file: {} bytes, and a binary one has {} at least", bytes.size(), stl_header)
          : fmt::format("is cut short: {} triangles take {} bytes, it has {}", count, needed, bytes.size()));
}

}  // namespace lockstep
