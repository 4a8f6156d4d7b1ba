#include "host/render/motion_gltf.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <map>
#include <nlohmann/json.hpp>
#include <utility>

#include "host/render/mesh.hpp"

namespace lockstep {

namespace {

using Eigen::Quaternionf;
using Eigen::Vector3f;
using nlohmann::json;

static_assert(std::endian::native == std::endian::little, "glTF is little-endian, and is written as it lies in memory");
static_assert(sizeof(Vertex) == 6 * sizeof(float));

// Numbers of the format.
constexpr u32 magic = 0x46546c67, version = 2, json_chunk = 0x4e4f534a, bin_chunk = 0x004e4942;
constexpr u32 header_bytes = 12, chunk_header_bytes = 8;
constexpr int is_float = 5126, is_u32 = 5125, for_vertices = 34962, for_indices = 34963;

// The parts of the binary buffer.
enum View { vertex_view, index_view, time_view, translation_view, rotation_view };

constexpr Color ground_color = {0.82f, 0.83f, 0.84f};
constexpr float wall_alpha = 0.25f, floor_slope = 0.35f;  // a plane that rises by 70 degrees is a wall, as in pictures
constexpr float least_ground = 10;                        // m, half the side of a square
constexpr std::size_t many = 1000;                        // solids, from which on round ones are coarser

json array_of(const Vector3f& v) { return {v.x(), v.y(), v.z()}; }
json array_of(const Quaternionf& q) { return {q.x(), q.y(), q.z(), q.w()}; }

// Of sRGB, as IEC 61966-2-1 has it: factors of materials are linear.
float linear(float c) { return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f); }

Mesh square_mesh() {
  Mesh mesh;
  for (const auto& [x, y] : {std::pair(-1.0f, -1.0f), {1.0f, -1.0f}, {1.0f, 1.0f}, {-1.0f, 1.0f}})
    mesh.vertices.push_back({{x, y, 0}, {0, 0, 1}});
  mesh.indices = {0, 1, 2, 0, 2, 3};
  return mesh;
}

template <class T>
void append(std::vector<unsigned char>& bytes, std::span<const T> values) {
  const auto* first = reinterpret_cast<const unsigned char*>(values.data());
  bytes.insert(bytes.end(), first, first + values.size_bytes());
}

void append_words(std::vector<unsigned char>& bytes, std::initializer_list<u32> words) {
  append(bytes, std::span<const u32>(words.begin(), words.size()));
}

// Each geometry and each material once.
class Document {
 public:
  Document(std::span<const Mesh> hulls, std::size_t solids) : hulls_(hulls), level_(solids > many ? 2 : 3) {}

  // The mesh of a solid; where it stands in its body is the node's.
  u32 mesh_of(const Solid& solid) {
    return mesh(solid.form, solid.form == Form::hull ? solid.hull : 0, material(solid.color, solid.alpha));
  }
  u32 square(float alpha) { return mesh({}, square_, material(ground_color, alpha)); }

  u32 add_node(json node) {
    nodes_.push_back(std::move(node));
    return static_cast<u32>(nodes_.size() - 1);
  }

  // The times of all keyframes, and two channels for each body that moves.
  void animate(std::span<const float> seconds, const std::vector<u32>& nodes) {
    times_.assign(seconds.begin(), seconds.end());
    const auto count = seconds.size();
    const u32 time = add_accessor({{"bufferView", time_view},
                                   {"componentType", is_float},
                                   {"count", count},
                                   {"type", "SCALAR"},
                                   {"min", json::array({seconds.front()})},
                                   {"max", json::array({seconds.back()})}});
    json samplers = json::array(), channels = json::array();
    for (std::size_t i = 0; i < nodes.size(); ++i) {
      const auto add = [&](const char* path, View view, const char* type, std::size_t bytes) {
        const u32 output = add_accessor({{"bufferView", view},
                                         {"byteOffset", i * count * bytes},
                                         {"componentType", is_float},
                                         {"count", count},
                                         {"type", type}});
        channels.push_back({{"sampler", samplers.size()}, {"target", {{"node", nodes[i]}, {"path", path}}}});
        samplers.push_back({{"input", time}, {"output", output}});
      };
      add("translation", translation_view, "VEC3", 12);
      add("rotation", rotation_view, "VEC4", 16);
    }
    animation_ = {{"name", "motion"}, {"samplers", std::move(samplers)}, {"channels", std::move(channels)}};
  }

  // The head of the file; `keyframes`: bytes that follow it.
  std::vector<unsigned char> head(const std::string& name, u32 root, std::uint64_t keyframes) {
    const std::uint64_t buffer = vertices_.size() * sizeof(Vertex) + (indices_.size() + times_.size()) * 4 + keyframes;
    std::string text = document(name, root, buffer).dump(-1, ' ', false, json::error_handler_t::replace);
    text.resize((text.size() + 3) / 4 * 4, ' ');
    std::uint64_t all = header_bytes + chunk_header_bytes + text.size();
    if (buffer > 0) all += chunk_header_bytes + buffer;
    std::vector<unsigned char> bytes;
    append_words(bytes, {magic, version, static_cast<u32>(all)});
    append_words(bytes, {static_cast<u32>(text.size()), json_chunk});
    append(bytes, std::span<const char>(text));
    if (buffer > 0) append_words(bytes, {static_cast<u32>(buffer), bin_chunk});
    append(bytes, std::span<const Vertex>(vertices_));
    append(bytes, std::span<const u32>(indices_));
    append(bytes, std::span<const float>(times_));
    return bytes;
  }

 private:
  struct Geometry {
    u32 positions, normals, indices;  // accessors
  };
  using FormKey = std::pair<int, u32>;  // form and hull
  static constexpr FormKey square_ = {-1, 0};

  u32 add_accessor(json accessor) {
    accessors_.push_back(std::move(accessor));
    return static_cast<u32>(accessors_.size() - 1);
  }

  u32 material(const Color& color, float alpha) {
    const auto [found, is_new] =
        material_numbers_.try_emplace({color[0], color[1], color[2], alpha}, static_cast<u32>(materials_.size()));
    if (!is_new) return found->second;
    json made = {{"pbrMetallicRoughness",
                  {{"baseColorFactor", {linear(color[0]), linear(color[1]), linear(color[2]), alpha}},
                   {"metallicFactor", 0},
                   {"roughnessFactor", 0.7}}}};
    if (alpha < 1) made["alphaMode"] = "BLEND";
    materials_.push_back(std::move(made));
    return found->second;
  }

  u32 mesh(Form form, u32 hull, u32 material) { return mesh(form, {static_cast<int>(form), hull}, material); }
  u32 mesh(Form form, const FormKey& key, u32 material) {
    const auto [found, is_new] = mesh_numbers_.try_emplace({key, material}, static_cast<u32>(meshes_.size()));
    if (!is_new) return found->second;
    const auto known = geometries_.find(key);
    const Geometry& g =
        known != geometries_.end()
            ? known->second
            : geometries_.emplace(key, add(key == square_ ? square_mesh() : form_mesh(form, key.second))).first->second;
    const json primitive = {{"attributes", {{"POSITION", g.positions}, {"NORMAL", g.normals}}},
                            {"indices", g.indices},
                            {"material", material}};
    meshes_.push_back({{"primitives", json::array({primitive})}});
    return found->second;
  }

  Mesh form_mesh(Form form, u32 hull) const {
    const u32 segments = 12u << (level_ - 1);
    switch (form) {
      case Form::sphere: return sphere_mesh(level_);
      case Form::box: return box_mesh();
      case Form::cylinder: return cylinder_mesh(segments, true);
      case Form::tube: return cylinder_mesh(segments, false);
      case Form::hemisphere: return hemisphere_mesh(segments);
      case Form::hull: return hulls_[hull];
    }
    return {};
  }

  Geometry add(const Mesh& mesh) {
    Vector3f low = mesh.vertices.front().position, high = low;
    for (const Vertex& vertex : mesh.vertices) {
      low = low.cwiseMin(vertex.position);
      high = high.cwiseMax(vertex.position);
    }
    const std::size_t first = vertices_.size() * sizeof(Vertex), first_index = indices_.size() * 4;
    vertices_.insert(vertices_.end(), mesh.vertices.begin(), mesh.vertices.end());
    indices_.insert(indices_.end(), mesh.indices.begin(), mesh.indices.end());
    json position = {{"bufferView", vertex_view},
                     {"byteOffset", first},
                     {"componentType", is_float},
                     {"count", mesh.vertices.size()},
                     {"type", "VEC3"}};
    json normal = position;
    normal["byteOffset"] = first + 12;
    position["min"] = array_of(low);
    position["max"] = array_of(high);
    return {add_accessor(std::move(position)), add_accessor(std::move(normal)),
            add_accessor({{"bufferView", index_view},
                          {"byteOffset", first_index},
                          {"componentType", is_u32},
                          {"count", mesh.indices.size()},
                          {"type", "SCALAR"}})};
  }

  json document(const std::string& name, u32 root, std::uint64_t buffer) {
    const json scene = {{"name", name}, {"nodes", json::array({root})}};
    json all = {{"asset", {{"version", "2.0"}, {"generator", "Lockstep"}}},
                {"scene", 0},
                {"scenes", json::array({scene})},
                {"nodes", std::move(nodes_)}};
    // the format has no empty arrays, nor views of nothing; of the ends of the buffer only what there is
    json views = json::array();
    std::uint64_t offset = 0;
    const auto add_view = [&](std::uint64_t bytes, int target) -> json& {
      views.push_back({{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}});
      if (target != 0) views.back()["target"] = target;
      offset += bytes;
      return views.back();
    };
    if (meshes_.empty()) return all;
    add_view(vertices_.size() * sizeof(Vertex), for_vertices)["byteStride"] = sizeof(Vertex);
    add_view(indices_.size() * 4, for_indices);
    if (!times_.empty()) {
      add_view(times_.size() * 4, 0);
      const std::uint64_t each = (buffer - offset) / 7;  // three parts for the translations, four for the rotations
      add_view(3 * each, 0);
      add_view(4 * each, 0);
      all["animations"] = json::array({std::move(animation_)});
    }
    all["materials"] = std::move(materials_);
    all["meshes"] = std::move(meshes_);
    all["accessors"] = std::move(accessors_);
    all["bufferViews"] = std::move(views);
    all["buffers"] = json::array({json{{"byteLength", buffer}}});
    return all;
  }

  std::span<const Mesh> hulls_;
  u32 level_;
  std::map<std::array<float, 4>, u32> material_numbers_;
  std::map<FormKey, Geometry> geometries_;
  std::map<std::pair<FormKey, u32>, u32> mesh_numbers_;
  json nodes_ = json::array(), meshes_ = json::array(), materials_ = json::array(), accessors_ = json::array();
  json animation_;
  std::vector<Vertex> vertices_;
  std::vector<u32> indices_;
  std::vector<float> times_;
};

json node_of(const Vector3f& position, const Quaternionf& rotation) {
  json node = json::object();
  if (!position.isZero(0)) node["translation"] = array_of(position);
  if (rotation.coeffs() != Quaternionf::Identity().coeffs()) node["rotation"] = array_of(rotation.normalized());
  return node;
}

// A square of a plane that lies about the middle of the region.
json square_node(const PlaneSurface& plane, const RenderPose& body, const Region& region) {
  const bool is_empty = region.isEmpty();
  const Vector3f middle = is_empty ? Vector3f::Zero() : Vector3f(region.center().cast<float>());
  const float half = is_empty ? least_ground : std::max(least_ground, 3 * static_cast<float>(region.diagonal().norm()));
  const Vector3f seen = body.rotation.conjugate() * (middle - body.position);  // in the frame of the body
  const Vector3f normal = plane.normal();
  json node = node_of(seen - normal.dot(seen - plane.origin) * normal, plane.rotation);
  node["scale"] = {half, half, 1};
  return node;
}

}  // namespace

MotionGltf::MotionGltf(const SceneModel& model, std::span<const MotionBody> bodies, const Region& region,
                       std::span<const float> seconds, const std::string& name) {
  std::vector<Look> looks(model.bodies());
  for (u32 body = 0; body < model.bodies(); ++body) {
    if (model.movable(body)) looks[body].color = body_color(model.id(body));
  }
  const std::vector<OwnSolids> own = model.own_solids(looks);
  std::size_t solids = 0;
  for (const OwnSolids& body : own) solids += body.solids.size();
  Document document(model.hulls(), solids);
  std::vector<u32> roots, animated;
  for (u32 body = 0; body < model.bodies(); ++body) {
    const RenderPose& start = bodies[body].start;
    std::vector<u32> children;
    for (const Solid& solid : own[body].solids) {
      json node = node_of(solid.position, solid.rotation);
      if (solid.form != Form::hull) node["scale"] = array_of(solid.scale);
      node["mesh"] = document.mesh_of(solid);
      children.push_back(document.add_node(std::move(node)));
    }
    for (const PlaneSurface& plane : own[body].planes) {
      json node = square_node(plane, start, region);
      const bool is_floor = (start.rotation * plane.normal()).dot(model.up()) > floor_slope;
      node["mesh"] = document.square(is_floor ? 1 : wall_alpha);
      children.push_back(document.add_node(std::move(node)));
    }
    if (children.empty()) continue;
    json node = node_of(start.position, start.rotation);
    node["name"] = bodies[body].name;
    node["children"] = std::move(children);
    roots.push_back(document.add_node(std::move(node)));
    if (!bodies[body].moves) continue;
    moving_.push_back(body);
    animated.push_back(roots.back());
  }
  if (seconds.size() < 2) moving_.clear();
  if (!moving_.empty()) document.animate(seconds, animated);
  const float half = std::sqrt(0.5f);
  json top = {{"name", "z up"}, {"rotation", {-half, 0, 0, half}}};  // a quarter turn about x: z becomes y
  if (!roots.empty()) top["children"] = roots;
  keyframes_ = moving_.empty() ? 0 : seconds.size();
  const std::uint64_t more = moving_.size() * keyframes_ * (12 + 16);
  head_ = document.head(name, document.add_node(std::move(top)), more);
  size_ = head_.size() + more;
}

}  // namespace lockstep
