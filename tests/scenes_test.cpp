// The built-in scenes: each reads and compiles, to the same bits on every machine (contract rule 6).
#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "host/embedded.hpp"
#include "host/error.hpp"
#include "host/scene/compile.hpp"
#include "host/scene/read.hpp"

namespace lockstep::scenes_test {
namespace {

const std::string golden_path = LOCKSTEP_SOURCE_DIR "/tests/golden/compiled_scenes.json";

// Fowler, Noll and Vo's hash (FNV-1a, 64 bits) over bytes.
struct Fnv {
  std::uint64_t hash = 0xcbf29ce484222325u;

  void add(const void* data, std::size_t bytes) {
    for (std::size_t i = 0; i < bytes; ++i) {
      hash = (hash ^ static_cast<const unsigned char*>(data)[i]) * 0x100000001b3u;
    }
  }
};

// Of everything a scene decides: constant and persistent buffers and the parameters, but not the sizes of lists.
template <class real>
std::string hash_of(const InitialState<real>& state) {
  Fnv fnv;
  for_each_buffer(state.buffers, [&](Buffer buffer, const auto& elements) {
    if (info(buffer).lifetime == Lifetime::transient || info(buffer).domain == Domain::cached) return;
    fnv.add(elements.data(), elements.size() * sizeof(elements[0]));
  });
  // in the order in which the hashes were recorded; capacities, which may change, as zeros
  const StepParams<real>& p = state.params;
  for (const real x : {p.dt, p.theta, p.gyroscopic_theta, p.restitution_threshold, p.correction, p.softness,
                       p.correction_limit, p.slop, p.margin, p.speed_limit, p.tolerance})
    fnv.add(&x, sizeof x);
  for (const u32 n :
       {p.bodies, p.shapes, p.worlds, p.tree_shapes, 0u, 0u, 0u, 0u, p.iterations, p.relaxations, p.substeps, p.substep,
        p.gyroscopic, p.queries, p.overlap_capacity, 0u, p.joint_blocks, p.position_sweeps})
    fnv.add(&n, sizeof n);
  fnv.add(&state.features, sizeof state.features);
  char text[17];
  std::snprintf(text, sizeof text, "%016llx", static_cast<unsigned long long>(fnv.hash));
  return text;
}

TEST(Scenes, EachIsListedWithWhatAViewerSees) {
  const std::vector<SceneListing> scenes = built_in_scenes();
  EXPECT_GE(scenes.size(), 19u);
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    EXPECT_EQ(read_scene(scenes[i].name).name, scenes[i].name);
    EXPECT_GE(scenes[i].description.size(), 30u) << scenes[i].name;
    EXPECT_TRUE(i == 0 || scenes[i - 1].name < scenes[i].name);
  }
}

TEST(Scenes, EmbeddedTextIsThatOfTheFile) {
  for (const EmbeddedFile& embedded : embedded_scenes()) {
    std::ifstream file(LOCKSTEP_SOURCE_DIR "/" + std::string(embedded.name));
    const std::string text = {std::istreambuf_iterator<char>(file), {}};
    EXPECT_EQ(text, embedded.text) << embedded.name;
  }
}

// Recorded once; every compiler, optimisation level and machine has to find the same. LOCKSTEP_RECORD_GOLDEN=1 records
// them anew after a scene was changed on purpose.
TEST(Scenes, CompileToTheGoldenBits) {
  nlohmann::json found;
  for (const SceneListing& listing : built_in_scenes()) {
    const Scene scene = read_scene(listing.name);
    found[listing.name] = {{"float", hash_of(compile<float>(scene))}, {"double", hash_of(compile<double>(scene))}};
  }
  if (std::getenv("LOCKSTEP_RECORD_GOLDEN") != nullptr) std::ofstream(golden_path) << found.dump(2) << '\n';
  std::ifstream file(golden_path);
  ASSERT_TRUE(file) << golden_path;
  EXPECT_EQ(nlohmann::json::parse(file), found);
}

// The initial poses of the 8,000 spheres that other engines are measured with, in their own words: y up, one small
// generator for each sphere. Turned z up about the x axis: (x, y, z) of theirs is (x, z, -y) of ours.
TEST(Scenes, Spheres8000RestWhereThePeersHaveThem) {
  struct Sequence {
    std::uint32_t s;
    explicit Sequence(std::uint32_t i) : s(i * 2654435761u + 12345u) { u(), u(); }
    double u() {
      s = s * 1664525u + 1013904223u;
      return (s >> 8) * (1.0 / 16777216.0);
    }
    double sym() { return 2 * u() - 1; }
  };
  const Scene scene = read_scene("spheres8000");
  const auto state = compile<double>(scene);
  ASSERT_EQ(state.sizes.bodies, 8001u);
  u32 body = 1;
  for (u32 j = 0; j < 20; ++j) {
    for (u32 k = 0; k < 20; ++k) {
      for (u32 i = 0; i < 20; ++i, ++body) {
        Sequence g((j * 20 + k) * 20 + i);
        const double a = .03 * g.sym(), b = .03 * g.sym(), c = .03 * g.sym();
        const double x = (i - 9.5) * 1.1 + a, y = 0.6 + 1.1 * j + b, z = (k - 9.5) * 1.1 + c;
        const Vec4<double>& position = state.buffers.positions[body];
        ASSERT_EQ(position.x, x);
        ASSERT_EQ(position.y, -z);
        ASSERT_EQ(position.z, y);
        ASSERT_EQ(state.buffers.masses[body].inertia[0], 0.4 * 1 * .5 * .5);
      }
    }
  }
  EXPECT_EQ(state.buffers.material_pairs[0].friction, 0.5);
  EXPECT_EQ(state.buffers.material_pairs[0].restitution, 0);
  EXPECT_EQ(scene.settings.dt, 1.0 / 60);
  EXPECT_EQ(scene.settings.steps, 600u);
  EXPECT_EQ(state.sizes.planes, 5u);
}

TEST(Scenes, NothingOverlapsAtTheStart) {
  for (const SceneListing& listing : built_in_scenes()) {
    const Scene scene = read_scene(listing.name);
    struct Sphere {
      Vector3 center;
      double radius;
      const BodyDescription* body;
      u32 category, mask;
    };
    std::vector<Sphere> spheres;
    for (const BodyDescription& body : scene.bodies) {
      for (const ShapeDescription& shape : body.shapes) {
        if (shape.kind != SHAPE_SPHERE) continue;
        const Vector3 center = exact::add(body.position, exact::rotate(body.orientation, shape.offset));
        spheres.push_back({center, shape.radius, &body, shape.category, shape.mask});
      }
    }
    for (const BodyDescription& body : scene.bodies) {
      for (const ShapeDescription& plane : body.shapes) {
        if (plane.kind != SHAPE_PLANE) continue;
        const Quaternion rotation = exact::multiply(body.orientation, plane.rotation);
        const Vector3 point = exact::add(body.position, exact::rotate(body.orientation, plane.offset));
        for (const Sphere& s : spheres) {
          if (s.body->kind != BODY_DYNAMIC) continue;
          if ((s.category & plane.mask) == 0 || (plane.category & s.mask) == 0) continue;
          const double gap =
              exact::dot(exact::rotate(rotation, {0, 0, 1}), exact::subtract(s.center, point)) - s.radius;
          EXPECT_GE(gap, -1e-9) << listing.name << ' ' << s.body->name;
        }
      }
    }
    if (spheres.size() > 1000) continue;  // spheres8000 stands 1.1 m apart, jittered by 0.03 m
    for (const Sphere& a : spheres) {
      for (const Sphere& b : spheres) {
        if (&a <= &b || a.body == b.body || (a.category & b.mask) == 0 || (b.category & a.mask) == 0) continue;
        const double gap = exact::length(exact::subtract(a.center, b.center)) - a.radius - b.radius;
        EXPECT_GE(gap, -1e-9) << listing.name << ' ' << a.body->name << ' ' << b.body->name;
      }
    }
  }
}

// Derived anew here, so that a slip in a scene shows.
TEST(Scenes, TopsHaveTheEnergyAndRateOfTheirClosedForms) {
  const Scene heavy = read_scene("heavy_top");
  const BodyDescription& top = heavy.bodies[0];
  const double axial_rate = exact::dot(exact::rotate(top.orientation, {0, 0, 1}), top.angular_velocity);
  EXPECT_NEAR(0.5 * top.inertia[2] * axial_rate * axial_rate - top.mass * exact::dot(heavy.gravity, top.position),
              1269.975005, 1e-6);

  // I1 W^2 cos(tilt) - I3 w3 W + m g l = 0, W about the vertical and the rest of the spin about the axis of the top
  const BodyDescription steady = read_scene("steady_precession").bodies[0];
  const double about_pivot = steady.inertia[0] + steady.mass * steady.com_offset[2] * steady.com_offset[2];
  EXPECT_NEAR(about_pivot, 0.3, 1e-15);
  const double a = about_pivot * std::cos(exact::pi / 6), b = steady.inertia[2] * 60, c = 5 * 9.81 * 0.1;
  const double rate = (b - std::sqrt(b * b - 4 * a * c)) / (2 * a);
  EXPECT_NEAR(rate, 0.848689, 1e-6);
  const Vector3 axis = exact::rotate(steady.orientation, {0, 0, 1});
  const Vector3 expected = exact::add({0, 0, rate}, exact::scale(60 - rate * std::cos(exact::pi / 6), axis));
  for (unsigned i = 0; i < 3; ++i) EXPECT_NEAR(steady.angular_velocity[i], expected[i], 1e-13);
}

// The names that the reader offers where it meets an unknown one.
std::set<std::string> offered(const std::string& scene) {
  try {
    parse_scene(scene, "probe.json");
  } catch (const Error& error) {
    const std::string line = error.what(), lead = "known: ";
    const std::size_t start = line.find(lead);
    EXPECT_NE(start, std::string::npos) << line;
    std::set<std::string> names;
    std::istringstream words(line.substr(start + lead.size()));
    for (std::string word; std::getline(words >> std::ws, word, ',');) names.insert(word);
    return names;
  }
  ADD_FAILURE() << "accepted: " << scene;
  return {};
}

std::string read_text(const std::string& path) {
  std::ifstream file(LOCKSTEP_SOURCE_DIR "/" + path);
  EXPECT_TRUE(file) << path;
  return {std::istreambuf_iterator<char>(file), {}};
}

// A place of a scene with an unknown word in it, and the same place in the schema: an object's keys, or a list of
// names.
struct Probe {
  const char* schema_location;
  const char* scene;
};

const Probe probes[] = {
    {"/properties", R"({"qqqqqqqq": 0})"},
    {"/$defs/camera/properties", R"({"camera": {"qqqqqqqq": 0}})"},
    {"/$defs/settings/properties", R"({"settings": {"qqqqqqqq": 0}})"},
    {"/$defs/particles/properties", R"({"particles": {"qqqqqqqq": 0}})"},
    {"/$defs/particles/properties/model/enum", R"({"particles": {"radius": 1, "model": "qqqqqqqq"}})"},
    {"/$defs/particles/properties/sampling/enum", R"({"particles": {"radius": 1, "sampling": "qqqqqqqq"}})"},
    {"/$defs/settings/properties/integrator/enum", R"({"settings": {"integrator": "qqqqqqqq"}})"},
    {"/$defs/settings/properties/gyroscopic/enum", R"({"settings": {"gyroscopic": "qqqqqqqq"}})"},
    {"/$defs/settings/properties/precision/enum", R"({"settings": {"precision": "qqqqqqqq"}})"},
    {"/$defs/material/properties", R"({"materials": [{"qqqqqqqq": 0}]})"},
    {"/$defs/material_pair/properties", R"({"material_pairs": [{"qqqqqqqq": 0}]})"},
    {"/$defs/body/properties", R"({"bodies": [{"qqqqqqqq": 0}]})"},
    {"/$defs/body/properties/type/enum", R"({"bodies": [{"type": "qqqqqqqq"}]})"},
    {"/$defs/shape/properties", R"({"bodies": [{"shapes": [{"qqqqqqqq": 0}]}]})"},
    {"/$defs/shape/properties/type/enum", R"({"bodies": [{"shapes": [{"type": "qqqqqqqq"}]}]})"},
    {"/$defs/joint/properties", R"({"bodies": [{"type": "static"}], "joints": [{"qqqqqqqq": 0}]})"},
    {"/$defs/joint/properties/type/enum", R"({"bodies": [{"type": "static"}], "joints": [{"type": "qqqqqqqq"}]})"},
    {"/$defs/sensor/properties", R"({"bodies": [{"type": "static"}], "sensors": [{"qqqqqqqq": 0}]})"},
    {"/$defs/sensor/properties/kind/enum",
     R"({"bodies": [{"type": "static"}], "sensors": [{"name": "a", "kind": "qqqqqqqq"}]})"},
    {"/$defs/robot/properties", R"({"robots": [{"qqqqqqqq": 0}]})"},
    {"/$defs/robot_joint/properties",
     R"({"robots": [{"file": "scenes/robots/sweeper.urdf", "joints": [{"qqqqqqqq": 0}]}]})"},
    {"/$defs/grid/properties", R"({"bodies": [{"generator": "grid", "qqqqqqqq": 0}]})"},
    {"/$defs/grid/properties/generator/enum", R"({"bodies": [{"generator": "qqqqqqqq"}]})"},
    {"/$defs/line/properties", R"({"bodies": [{"generator": "line", "qqqqqqqq": 0}]})"},
    {"/$defs/pyramid/properties", R"({"bodies": [{"generator": "pyramid", "qqqqqqqq": 0}]})"},
    {"/$defs/arc/properties", R"({"bodies": [{"generator": "arc", "qqqqqqqq": 0}]})"},
    {"/$defs/jitter/properties",
     R"({"bodies": [{"generator": "line", "count": 1, "step": [0, 0, 0], "jitter": {"qqqqqqqq": 0}}]})"},
    {"/$defs/jitter/properties/generator/enum",
     R"({"bodies": [{"generator": "line", "count": 1, "step": [0, 0, 0], "jitter": {"generator": "qqqqqqqq"}}]})"},
};

TEST(Scenes, SchemaReaderAndManualKnowTheSameWords) {
  const nlohmann::json schema = nlohmann::json::parse(read_text("scenes/scene.schema.json"));
  std::string manual;
  for (const auto& page : std::filesystem::directory_iterator(LOCKSTEP_SOURCE_DIR "/docs/reference"))
    manual += read_text("docs/reference/" + page.path().filename().string());
  for (const Probe& probe : probes) {
    const nlohmann::json& node = schema.at(nlohmann::json::json_pointer(probe.schema_location));
    std::set<std::string> words;
    for (const auto& item : node.items()) words.insert(node.is_array() ? item.value().get<std::string>() : item.key());
    EXPECT_EQ(words, offered(probe.scene)) << probe.schema_location;
    for (const std::string& word : words) {
      EXPECT_NE(manual.find('`' + word + '`'), std::string::npos) << word << " is not explained in docs/reference/";
    }
  }
}

TEST(Scenes, DefaultsOfTheSchemaAreThoseOfTheReader) {
  const nlohmann::json schema = nlohmann::json::parse(read_text("scenes/scene.schema.json"));
  const nlohmann::json& particles = schema["$defs"]["particles"]["properties"];
  EXPECT_EQ(particles["restitution"]["default"], ParticleSettings().restitution);
  EXPECT_EQ(particles["friction"]["default"], ParticleSettings().friction);
  EXPECT_EQ(schema["$defs"]["material"]["properties"]["friction"]["default"], Material().friction);
  EXPECT_EQ(schema["$defs"]["material"]["properties"]["restitution"]["default"], Material().restitution);
}

TEST(Scenes, TheExampleOfTheManualRuns) {
  const std::string manual = read_text("docs/reference/scene_format.md");
  const std::size_t start = manual.find("```json\n") + 8;
  const Scene scene = parse_scene(manual.substr(start, manual.find("```", start) - start), "example.json");
  EXPECT_EQ(scene.bodies.size(), 101u);
  EXPECT_EQ(compile<float>(scene).sizes.shapes, 102u);
}

}  // namespace
}  // namespace lockstep::scenes_test
