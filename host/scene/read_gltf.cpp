// glTF 2.0 (https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html): the triangles of the default scene.
#include <fmt/format.h>

#include <array>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "host/scene/json_node.hpp"
#include "host/scene/mesh_formats.hpp"

namespace lockstep {

namespace {

using nlohmann::json;
using Matrix = std::array<double, 16>;  // by columns

constexpr Matrix identity = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
constexpr u32 most_items = 1u << 24, most_bytes = 1u << 30;
constexpr u32 deepest_node = 256;

Matrix product(const Matrix& a, const Matrix& b) {
  Matrix c;
  for (unsigned i = 0; i < 4; ++i)
    for (unsigned j = 0; j < 4; ++j) {
      double sum = 0;
      for (unsigned k = 0; k < 4; ++k) sum += a[4 * k + i] * b[4 * j + k];
      c[4 * j + i] = sum;
    }
  return c;
}

Vector3 transformed_point(const Matrix& m, const Vector3& p) {
  Vector3 q;
  for (unsigned i = 0; i < 3; ++i) q[i] = float(m[i] * p[0] + m[4 + i] * p[1] + m[8 + i] * p[2] + m[12 + i]);
  return q;
}

std::string from_base64(std::string_view text) {
  constexpr std::string_view digits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  std::string bytes;
  u32 word = 0, bits = 0;
  for (const char c : text) {
    if (c == '=') break;
    const std::size_t digit = digits.find(c);
    if (digit == digits.npos) throw std::runtime_error("has a data URI that is not base64");
    word = word << 6 | static_cast<u32>(digit);
    bits += 6;
    if (bits < 8) continue;
    bits -= 8;
    bytes += static_cast<char>(word >> bits & 255);
  }
  return bytes;
}

// What an accessor says: `count` items, `stride` bytes from one to the next.
struct Accessed {
  const char* data = nullptr;
  u32 count = 0;
  std::size_t stride = 0;
  u32 type = 0;  // of a component
};

std::size_t size_of_component(u32 type) {
  switch (type) {
    case 5120:
    case 5121: return 1;
    case 5122:
    case 5123: return 2;
    default: return 4;
  }
}

class GltfReader {
 public:
  GltfReader(JsonNode root, std::string binary, const std::function<std::string(const std::string&)>& file)
      : root_(std::move(root)), binary_(std::move(binary)), file_(file) {}

  TriangleMesh read() {
    if (!root_.at("asset").at("version").text().starts_with("2."))
      root_.at("asset").at("version").fail("must be 2.0; convert the file");
    if (root_.has("extensionsRequired"))
      for (const JsonNode& extension : root_.at("extensionsRequired").elements())
        extension.fail(
            fmt::format("the extension {} is not known; export the mesh without it", quote(extension.text())));
    read_buffers();
    nodes_ = items("nodes");
    meshes_ = items("meshes");
    accessors_ = items("accessors");
    views_ = items("bufferViews");
    is_seen_.resize(nodes_.size());
    const std::vector<JsonNode> scenes = items("scenes");
    if (scenes.empty()) {
      for (const JsonNode& mesh : meshes_) add_mesh(mesh, identity);
    } else {
      const JsonNode& scene = scenes[root_.has("scene") ? index(root_.at("scene"), scenes.size()) : 0];
      if (scene.has("nodes"))
        for (const JsonNode& root : scene.at("nodes").elements()) add_node(root, identity, 0);
    }
    return std::move(mesh_);
  }

 private:
  std::vector<JsonNode> items(const char* key) const {
    return root_.has(key) ? root_.at(key).elements() : std::vector<JsonNode>();
  }

  static u32 index(const JsonNode& node, std::size_t count) {
    if (count == 0) node.fail("names something that the file has none of");
    return node.integer(0, static_cast<u32>(count) - 1);
  }

  void read_buffers() {
    for (const JsonNode& buffer : items("buffers")) {
      const u32 length = buffer.at("byteLength").integer(1, most_bytes);
      std::string bytes;
      if (!buffer.has("uri")) {
        bytes = std::exchange(binary_, {});
      } else if (const std::string uri = buffer.at("uri").text(); uri.starts_with("data:")) {
        const std::size_t begin = uri.find(";base64,");
        if (begin == uri.npos) buffer.at("uri").fail("must be base64");
        bytes = from_base64(std::string_view(uri).substr(begin + 8));
      } else {
        bytes = file_(uri);
      }
      if (bytes.size() < length)
        buffer.at("byteLength").fail(fmt::format("is {}, and the buffer has {} bytes", length, bytes.size()));
      buffers_.push_back(std::move(bytes));
    }
  }

  void add_node(const JsonNode& number, const Matrix& parent, u32 depth) {
    const u32 n = index(number, nodes_.size());
    if (is_seen_[n]) number.fail("names a node a second time; nodes are a tree");
    if (depth == deepest_node) number.fail(fmt::format("is nested deeper than {} nodes", deepest_node));
    is_seen_[n] = true;
    const JsonNode& node = nodes_[n];
    const Matrix frame = product(parent, frame_of(node));
    if (node.has("mesh")) add_mesh(meshes_.at(index(node.at("mesh"), meshes_.size())), frame);
    if (node.has("children"))
      for (const JsonNode& child : node.at("children").elements()) add_node(child, frame, depth + 1);
  }

  template <std::size_t n>
  static std::array<double, n> numbers(const JsonNode& node, const char* key, std::array<double, n> numbers) {
    if (!node.has(key)) return numbers;
    const std::vector<JsonNode> all = node.at(key).elements();
    if (all.size() != n) node.at(key).fail(fmt::format("must have {} numbers, has {}", n, all.size()));
    for (std::size_t i = 0; i < n; ++i) numbers[i] = all[i].number();
    return numbers;
  }

  static Matrix frame_of(const JsonNode& node) {
    if (node.has("matrix")) return numbers<16>(node, "matrix", identity);
    const auto [x, y, z] = numbers<3>(node, "translation", {0, 0, 0});
    const auto scale = numbers<3>(node, "scale", {1, 1, 1});
    const Quaternion q = numbers<4>(node, "rotation", {0, 0, 0, 1});
    Matrix frame = identity;
    for (unsigned j = 0; j < 3; ++j) {
      Vector3 axis = {0, 0, 0};
      axis[j] = scale[j];
      const Vector3 column = exact::rotate(q, axis);
      for (unsigned i = 0; i < 3; ++i) frame[4 * j + i] = column[i];
    }
    frame[12] = x, frame[13] = y, frame[14] = z;
    return frame;
  }

  Accessed access(const JsonNode& number, const char* type) const {
    const JsonNode& accessor = accessors_.at(index(number, accessors_.size()));
    if (accessor.at("type").text() != type) accessor.at("type").must_be(fmt::format("\"{}\"", type));
    if (accessor.has("sparse")) accessor.at("sparse").fail("is not read; export the mesh without it");
    Accessed found;
    found.type = accessor.at("componentType").integer(5120, 5126);
    found.count = accessor.at("count").integer(0, most_items);
    const std::size_t item = size_of_component(found.type) * (std::string_view(type) == "VEC3" ? 3 : 1);
    const JsonNode& view = views_.at(index(accessor.at("bufferView"), views_.size()));
    const std::string& buffer = buffers_.at(index(view.at("buffer"), buffers_.size()));
    const auto bytes = [](const JsonNode& node, const char* key) -> std::size_t {
      return node.has(key) ? node.at(key).integer(0, most_bytes) : 0;
    };
    const std::size_t first = bytes(view, "byteOffset"), length = bytes(view, "byteLength");
    if (first + length > buffer.size())
      view.fail(fmt::format("ends at byte {} of a buffer of {}", first + length, buffer.size()));
    found.stride = view.has("byteStride") ? bytes(view, "byteStride") : item;
    const std::size_t offset = bytes(accessor, "byteOffset");
    if (found.count > 0 && offset + found.stride * (found.count - 1) + item > length)
      accessor.fail(fmt::format("ends behind its view of {} bytes", length));
    found.data = buffer.data() + first + offset;
    return found;
  }

  void add_mesh(const JsonNode& mesh, const Matrix& frame) {
    for (const JsonNode& primitive : mesh.at("primitives").elements()) {
      const u32 mode = primitive.has("mode") ? primitive.at("mode").integer(0, 6) : 4;
      if (mode < 4) continue;  // points and lines bound nothing
      const JsonNode position = primitive.at("attributes").at("POSITION");
      const Accessed positions = access(position, "VEC3");
      if (positions.type != 5126) position.fail("must be of floats (5126)");
      std::vector<u32> corners;
      if (primitive.has("indices"))
        corners = indices(primitive.at("indices"), positions.count);
      else
        for (u32 i = 0; i < positions.count; ++i) corners.push_back(i);
      const std::size_t vertices = mesh_.vertices.size();
      if (vertices + positions.count > most_mesh_corners ||
          3 * mesh_.triangles.size() + 3 * corners.size() > most_mesh_corners)
        mesh.fail("makes more than 22 million triangles of the file; give it fewer");
      for (u32 i = 0; i < positions.count; ++i) {
        float p[3];
        std::memcpy(p, positions.data + positions.stride * i, sizeof(p));
        mesh_.vertices.push_back(transformed_point(frame, {p[0], p[1], p[2]}));
      }
      add_triangles(mode, corners, static_cast<u32>(vertices), is_mirror(frame));
    }
  }

  std::vector<u32> indices(const JsonNode& number, u32 vertices) const {
    const Accessed of = access(number, "SCALAR");
    std::vector<u32> corners;
    for (u32 i = 0; i < of.count; ++i) {
      const char* at = of.data + of.stride * i;
      u32 corner = 0;
      switch (of.type) {
        case 5121: corner = static_cast<unsigned char>(*at); break;
        case 5123: {
          std::uint16_t two = 0;
          std::memcpy(&two, at, sizeof(two));
          corner = two;
          break;
        }
        case 5125: std::memcpy(&corner, at, sizeof(corner)); break;
        default: number.fail("must be of unsigned integers (5121, 5123 or 5125)");
      }
      if (corner >= vertices) number.fail(fmt::format("has the index {} of {} vertices", corner, vertices));
      corners.push_back(corner);
    }
    return corners;
  }

  static bool is_mirror(const Matrix& m) {
    const Vector3 x = {m[0], m[1], m[2]}, y = {m[4], m[5], m[6]}, z = {m[8], m[9], m[10]};
    return exact::dot(exact::cross(x, y), z) < 0;
  }

  void add_triangles(u32 mode, const std::vector<u32>& corners, u32 first, bool mirrored) {
    const auto add = [&](u32 a, u32 b, u32 c) {
      if (mirrored) std::swap(b, c);
      mesh_.triangles.push_back({first + a, first + b, first + c});
    };
    const std::size_t n = corners.size();
    if (mode == 4)
      for (std::size_t i = 0; i + 2 < n; i += 3) add(corners[i], corners[i + 1], corners[i + 2]);
    if (mode == 5)
      for (std::size_t i = 0; i + 2 < n; ++i) add(corners[i], corners[i + 1 + i % 2], corners[i + 2 - i % 2]);
    if (mode == 6)
      for (std::size_t i = 1; i + 1 < n; ++i) add(corners[0], corners[i], corners[i + 1]);
  }

  const JsonNode root_;
  std::string binary_;
  const std::function<std::string(const std::string&)>& file_;
  std::vector<std::string> buffers_;
  std::vector<JsonNode> nodes_, meshes_, accessors_, views_;
  std::vector<bool> is_seen_;
  TriangleMesh mesh_;
};

u32 word_at(const std::string& bytes, std::size_t at) {
  u32 word = 0;
  std::memcpy(&word, bytes.data() + at, sizeof(word));
  return word;
}

// The chunks of a binary file: its JSON, and the bytes after it.
std::pair<std::string, std::string> chunks_of_glb(const std::string& bytes) {
  constexpr u32 version = 2, is_json = 0x4e4f534a, is_binary = 0x004e4942;
  std::pair<std::string, std::string> chunks;
  if (bytes.size() < 20 || word_at(bytes, 4) != version || word_at(bytes, 16) != is_json)
    throw std::runtime_error("is no binary glTF file of version 2");
  for (std::size_t at = 12; at + 8 <= bytes.size();) {
    const std::size_t length = word_at(bytes, at);
    const u32 kind = word_at(bytes, at + 4);
    if (length > bytes.size() - at - 8) throw std::runtime_error("is cut short");
    std::string& chunk = kind == is_json ? chunks.first : chunks.second;
    if (chunk.empty() && (kind == is_json || kind == is_binary)) chunk = bytes.substr(at + 8, length);
    at += 8 + length;
  }
  return chunks;
}

}  // namespace

TriangleMesh read_gltf(const std::string& bytes, const std::string& source,
                       const std::function<std::string(const std::string&)>& file) {
  std::pair<std::string, std::string> chunks;
  if (bytes.starts_with("glTF"))
    chunks = chunks_of_glb(bytes);
  else
    chunks.first = bytes;
  const json document = parse_json(chunks.first, source);
  return GltfReader(JsonNode(document, source), std::move(chunks.second), file).read();
}

}  // namespace lockstep
