#include "host/scene/elevation_file.hpp"

#include <png.h>

#include <cstring>
#include <fstream>
#include <iterator>
#include <memory>
#include <stdexcept>

namespace lockstep {

namespace {

// Little-endian, as MuJoCo writes it.
class Bytes {
 public:
  explicit Bytes(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    bytes_.assign(std::istreambuf_iterator<char>(in), {});
    if (!in) throw std::runtime_error("it cannot be opened");
  }

  template <class Value>
  std::vector<Value> take(std::size_t count) {
    if (count > (bytes_.size() - at_) / sizeof(Value)) throw std::runtime_error("it is too short");
    std::vector<Value> values(count);
    std::memcpy(values.data(), bytes_.data() + at_, count * sizeof(Value));
    at_ += count * sizeof(Value);
    return values;
  }

  std::size_t count() {
    const std::int32_t value = take<std::int32_t>(1)[0];
    if (value < 0 || value > 100000000) throw std::runtime_error("it is not MuJoCo's binary format");
    return static_cast<std::size_t>(value);
  }

 private:
  std::vector<char> bytes_;
  std::size_t at_ = 0;
};

Elevations read_picture(const std::string& path) {
  png_image image = {};
  image.version = PNG_IMAGE_VERSION;
  const std::unique_ptr<png_image, void (*)(png_image*)> cleanup(&image, [](png_image* p) { png_image_free(p); });
  if (!png_image_begin_read_from_file(&image, path.c_str())) throw std::runtime_error(image.message);
  image.format = PNG_FORMAT_GRAY;
  Elevations field = {image.height, image.width, {}};
  if (field.rows > 2000 || field.columns > 2000) throw std::runtime_error("it has more than 2000 rows or columns");
  std::vector<png_byte> grey(PNG_IMAGE_SIZE(image));
  if (!png_image_finish_read(&image, nullptr, grey.data(), 0, nullptr)) throw std::runtime_error(image.message);
  for (std::size_t r = field.rows; r-- > 0;)
    field.heights.insert(field.heights.end(), grey.begin() + static_cast<std::ptrdiff_t>(r * field.columns),
                         grey.begin() + static_cast<std::ptrdiff_t>((r + 1) * field.columns));
  return field;
}

}  // namespace

Elevations read_elevations(const std::string& path) {
  const std::string end = path.size() > 4 ? path.substr(path.size() - 4) : "";
  if (end == ".png" || end == ".PNG") return read_picture(path);
  Bytes bytes(path);
  Elevations field;
  field.rows = bytes.count();
  field.columns = bytes.count();
  if (field.rows > 2000 || field.columns > 2000) throw std::runtime_error("it has more than 2000 rows or columns");
  for (const float height : bytes.take<float>(field.rows * field.columns)) field.heights.push_back(height);
  return field;
}

TriangleMesh read_msh(const std::string& path) {
  Bytes bytes(path);
  const std::size_t vertices = bytes.count(), normals = bytes.count(), coordinates = bytes.count(),
                    triangles = bytes.count();
  const std::vector<float> points = bytes.take<float>(3 * vertices);
  bytes.take<float>(3 * normals + 2 * coordinates);
  const std::vector<std::int32_t> corners = bytes.take<std::int32_t>(3 * triangles);
  TriangleMesh mesh;
  for (std::size_t i = 0; i < vertices; ++i)
    mesh.vertices.push_back({points[3 * i], points[3 * i + 1], points[3 * i + 2]});
  for (std::size_t i = 0; i < triangles; ++i) {
    std::array<u32, 3> triangle = {};
    for (std::size_t k = 0; k < 3; ++k) {
      const std::int32_t corner = corners[3 * i + k];
      if (corner < 0 || static_cast<std::size_t>(corner) >= vertices)
        throw std::runtime_error("a triangle has a corner that is no vertex");
      triangle[k] = static_cast<u32>(corner);
    }
    mesh.triangles.push_back(triangle);
  }
  return mesh;
}

}  // namespace lockstep
