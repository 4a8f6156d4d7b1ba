#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "host/scene/json_node.hpp"
#include "host/scene/mesh_formats.hpp"
#include "host/scene/number_scan.hpp"

namespace lockstep {

namespace {

enum class PlyType { i8, u8, i16, u16, i32, u32, f32, f64 };
constexpr std::array<std::size_t, 8> ply_sizes = {1, 1, 2, 2, 4, 4, 4, 8};

struct PlyProperty {
  std::string name;
  PlyType type = PlyType::f32;
  std::optional<PlyType> count = {};  // of a list
};
struct PlyElement {
  std::string name;
  std::uint64_t count = 0;
  std::vector<PlyProperty> properties = {};
};

[[noreturn]] void fail_ply(const std::string& what) { throw std::runtime_error(what); }

PlyType ply_type(std::string_view name) {
  constexpr std::array<std::array<std::string_view, 2>, 8> names = {{{"char", "int8"},
                                                                     {"uchar", "uint8"},
                                                                     {"short", "int16"},
                                                                     {"ushort", "uint16"},
                                                                     {"int", "int32"},
                                                                     {"uint", "uint32"},
                                                                     {"float", "float32"},
                                                                     {"double", "float64"}}};
  for (std::size_t i = 0; i < names.size(); ++i)
    if (name == names[i][0] || name == names[i][1]) return static_cast<PlyType>(i);
  fail_ply(fmt::format("has a property of the unknown type {}", quote(std::string(name))));
}

// The numbers of the body, one after the other.
class PlyBody {
 public:
  PlyBody(std::string_view bytes, std::string_view format) : bytes_(bytes), words_(bytes) {
    is_text_ = format == "ascii";
    is_swapped_ = (format == "binary_big_endian") == (std::endian::native == std::endian::little);
    if (!is_text_ && format != "binary_big_endian" && format != "binary_little_endian")
      fail_ply(fmt::format("is of the unknown format {}", quote(std::string(format))));
  }

  // What is left has no more numbers than that.
  std::size_t most_left(PlyType type) const {
    return is_text_ ? (words_.rest().size() + 1) / 2 : (bytes_.size() - at_) / ply_sizes[std::size_t(type)];
  }

  double next(PlyType type) {
    if (is_text_) {
      const std::string_view word = words_.word();
      if (word.empty()) fail_ply("is cut short");
      const std::optional<double> number =
          type == PlyType::f32 ? std::optional<double>(float_in(word)) : number_in<double>(word);
      if (!number) fail_ply(fmt::format("must have numbers, has {}", quote(std::string(word))));
      return *number;
    }
    switch (type) {
      case PlyType::i8: return raw<std::int8_t>();
      case PlyType::u8: return raw<std::uint8_t>();
      case PlyType::i16: return raw<std::int16_t>();
      case PlyType::u16: return raw<std::uint16_t>();
      case PlyType::i32: return raw<std::int32_t>();
      case PlyType::u32: return raw<std::uint32_t>();
      case PlyType::f32: return double(raw<float>());
      default: return raw<double>();
    }
  }

  // A list's number of entries, or an index.
  std::uint64_t whole(PlyType type) {
    const double number = next(type);
    if (!(number >= 0 && number < 4294967296.0) || number != std::floor(number))
      fail_ply(fmt::format("must have whole numbers from 0 on in its lists, has {}", number));
    return static_cast<std::uint64_t>(number);
  }

 private:
  template <class T>
  T raw() {
    if (bytes_.size() - at_ < sizeof(T)) fail_ply("is cut short");
    std::array<char, sizeof(T)> bytes;
    std::memcpy(bytes.data(), bytes_.data() + at_, sizeof(T));
    at_ += sizeof(T);
    if (is_swapped_) std::ranges::reverse(bytes);
    return std::bit_cast<T>(bytes);
  }

  std::string_view bytes_;
  NumberScan words_;
  std::size_t at_ = 0;
  bool is_text_ = false, is_swapped_ = false;
};

struct PlyHeader {
  std::string format;
  std::vector<PlyElement> elements;
};

PlyProperty ply_property(NumberScan& words) {
  PlyProperty property;
  std::string_view type = words.word();
  if (type == "list") {
    property.count = ply_type(words.word());
    type = words.word();
  }
  property.type = ply_type(type);
  property.name = words.word();
  return property;
}

PlyHeader read_ply_header(NumberScan& lines) {
  PlyHeader header;
  if (lines.line() != "ply") fail_ply("is no PLY file: it does not begin with ply");
  while (const auto line = lines.line()) {
    NumberScan words(*line);
    const std::string_view key = words.word();
    if (key == "end_header") return header;
    if (key == "format") header.format = words.word();
    if (key == "element") {
      PlyElement element = {std::string(words.word())};
      const std::string_view count = words.word();
      const auto number = number_in<std::uint64_t>(count);
      if (!number) fail_ply(fmt::format("has no number of elements: {}", quote(std::string(count))));
      element.count = *number;
      header.elements.push_back(element);
    }
    if (key == "property") {
      if (header.elements.empty()) fail_ply("has a property before its first element");
      header.elements.back().properties.push_back(ply_property(words));
    }
  }
  fail_ply("has no end_header");
}

std::optional<unsigned> axis_of(const std::string& name) {
  return name == "x"   ? std::optional(0u)
         : name == "y" ? std::optional(1u)
         : name == "z" ? std::optional(2u)
                       : std::nullopt;
}

void expect_enough(const PlyElement& element, const PlyBody& body) {
  if (element.count == 0) return;
  if (element.properties.empty())
    fail_ply(fmt::format("says nothing of its {} {}", element.count, quote(element.name)));
  const PlyProperty& first = element.properties.front();
  if (element.count > body.most_left(first.count.value_or(first.type)))
    fail_ply(fmt::format("is cut short: it announces {} {}, which it cannot have", element.count, quote(element.name)));
}

}  // namespace

TriangleMesh read_ply(std::string_view bytes) {
  NumberScan lines(bytes);
  const PlyHeader header = read_ply_header(lines);
  PlyBody body(lines.rest(), header.format);
  TriangleMesh mesh;
  std::vector<std::vector<u32>> faces;  // which may come before the vertices
  std::size_t corners = 0;
  for (const PlyElement& element : header.elements) {
    expect_enough(element, body);
    for (std::uint64_t i = 0; i < element.count; ++i) {
      Vector3 position = {0, 0, 0};
      for (const PlyProperty& property : element.properties) {
        if (!property.count) {
          const double number = body.next(property.type);
          if (const auto axis = axis_of(property.name)) position[*axis] = static_cast<float>(number);
          continue;
        }
        const std::uint64_t count = body.whole(*property.count);
        if (count > body.most_left(property.type)) fail_ply("is cut short");
        const bool is_face =
            element.name == "face" && (property.name == "vertex_indices" || property.name == "vertex_index");
        std::vector<u32> face;
        for (std::uint64_t k = 0; k < count; ++k) {
          if (is_face)
            face.push_back(static_cast<u32>(body.whole(property.type)));
          else
            body.next(property.type);
        }
        if ((corners += face.size()) > most_mesh_corners) fail_ply("has more than 67 million corners");
        if (is_face) faces.push_back(std::move(face));
      }
      if (element.name == "vertex") mesh.vertices.push_back(position);
    }
  }
  for (const std::vector<u32>& face : faces) {
    for (const u32 corner : face)
      if (corner >= mesh.vertices.size())
        fail_ply(fmt::format("has a face with the vertex {} of {}", corner, mesh.vertices.size()));
    add_polygon(face, mesh);
  }
  return mesh;
}

}  // namespace lockstep
