#include <fmt/format.h>

#include <array>
#include <cmath>
#include <stdexcept>

#include "host/scene/json_node.hpp"
#include "host/scene/mesh_formats.hpp"
#include "host/scene/number_scan.hpp"

namespace lockstep {

namespace {

class ObjReader {
 public:
  TriangleMesh read(std::string_view text) {
    NumberScan lines(text);
    std::string joined;
    while (auto line = lines.line()) {
      ++number_;
      if (line->ends_with('\\')) {  // goes on in the next one
        joined.append(line->substr(0, line->size() - 1)).append(" ");
        continue;
      }
      if (joined.empty()) {
        read_line(*line);
      } else {
        read_line(joined.append(*line));
        joined.clear();
      }
    }
    if (!joined.empty()) read_line(joined);
    if (mesh_.triangles.empty()) mesh_.vertices = positions_;
    return std::move(mesh_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    throw std::runtime_error(fmt::format("line {} {}", number_, what));
  }

  void read_line(std::string_view line) {
    NumberScan scan(line);
    const std::string_view kind = scan.word();
    if (kind == "v") read_position(scan);
    if (kind == "f") read_face(scan);
  }

  // x y z, x y z w, or x y z with a color.
  void read_position(NumberScan scan) {
    std::array<double, 4> p = {0, 0, 0, 1};
    unsigned count = 0;
    for (std::string_view word = scan.word(); !word.empty(); word = scan.word(), ++count) {
      const auto number = float_in(word);
      if (!number) fail(fmt::format("must have numbers, has {}", quote(std::string(word))));
      if (count < 4) p[count] = *number;
    }
    if (count < 3) fail("must have three numbers after v");
    if (count != 4) p[3] = 1;
    if (p[3] == 0) fail("is a point at infinity: its fourth number is 0");
    positions_.push_back({p[0] / p[3], p[1] / p[3], p[2] / p[3]});
  }

  void read_face(NumberScan scan) {
    corners_.clear();
    for (std::string_view word = scan.word(); !word.empty() && word[0] != '#'; word = scan.word()) {
      const std::string_view position = word.substr(0, word.find('/'));
      const auto number = number_in<std::int64_t>(position);
      const auto most = static_cast<std::int64_t>(positions_.size());
      if (!number || *number == 0 || *number > most || *number < -most)
        fail(
            fmt::format("has the corner {}, must be one of the {} vertices before it", quote(std::string(word)), most));
      corners_.push_back(vertex(static_cast<std::size_t>(*number > 0 ? *number - 1 : most + *number)));
    }
    add_polygon(corners_, mesh_);
  }

  u32 vertex(std::size_t position) {
    vertices_.resize(positions_.size(), NONE);
    u32& vertex = vertices_[position];
    if (vertex == NONE) {
      vertex = static_cast<u32>(mesh_.vertices.size());
      mesh_.vertices.push_back(positions_[position]);
    }
    return vertex;
  }

  std::size_t number_ = 0;  // of the line
  std::vector<Vector3> positions_;
  std::vector<u32> vertices_, corners_;  // of the positions; of a face
  TriangleMesh mesh_;
};

}  // namespace

TriangleMesh read_obj(std::string_view text) { return ObjReader().read(text); }

}  // namespace lockstep
