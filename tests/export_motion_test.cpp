// `lockstep export` of a motion: the file keeps the rules of glTF 2.0, and another reader (assimp) finds in it the
// poses of the recording.
#include <assimp/scene.h>

#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <map>
#include <set>

#include "host/record/recording_reader.hpp"
#include "host/record/whole_file.hpp"
#include "tests/command_line.hpp"

namespace lockstep::export_motion_test {
namespace {

using nlohmann::json;

u32 word_at(const std::vector<unsigned char>& bytes, std::size_t offset) {
  u32 word = 0;
  std::memcpy(&word, &bytes.at(offset), 4);
  return word;
}

// The two chunks of a binary file; what the container must keep is checked on the way.
struct Glb {
  json document;
  std::vector<unsigned char> buffer;

  explicit Glb(const std::string& path) {
    const std::vector<unsigned char> bytes = read_whole_file(path);
    EXPECT_EQ(word_at(bytes, 0), 0x46546c67u);
    EXPECT_EQ(word_at(bytes, 4), 2u);
    EXPECT_EQ(word_at(bytes, 8), bytes.size());
    const u32 text = word_at(bytes, 12);
    EXPECT_EQ(word_at(bytes, 16), 0x4e4f534au);
    EXPECT_EQ(text % 4, 0u);
    document = json::parse(bytes.begin() + 20, bytes.begin() + 20 + text);
    EXPECT_EQ(word_at(bytes, 20 + text), bytes.size() - 28 - text);
    EXPECT_EQ(word_at(bytes, 24 + text), 0x004e4942u);
    buffer.assign(bytes.begin() + 28 + text, bytes.end());
    EXPECT_EQ(buffer.size() % 4, 0u);
    EXPECT_EQ(document["buffers"], json::array({{{"byteLength", buffer.size()}}}));
  }

  // The numbers of an accessor, row by row; it must lie in its view, and in fours.
  template <class T>
  std::vector<T> numbers(std::size_t index) const {
    const json& accessor = document["accessors"].at(index);
    const json& view = document["bufferViews"].at(accessor["bufferView"].get<std::size_t>());
    const std::map<std::string, std::size_t> columns = {{"SCALAR", 1}, {"VEC3", 3}, {"VEC4", 4}};
    const std::size_t row = columns.at(accessor["type"]) * 4, count = accessor["count"];
    EXPECT_EQ(accessor["componentType"], (std::is_same_v<T, float> ? 5126 : 5125));
    const std::size_t stride = view.value("byteStride", row), first = accessor.value("byteOffset", 0);
    const std::size_t start = view["byteOffset"];
    EXPECT_EQ((first | start | stride) % 4, 0u);
    EXPECT_GT(count, 0u);
    EXPECT_LE(first + (count - 1) * stride + row, view["byteLength"].get<std::size_t>());
    EXPECT_LE(start + view["byteLength"].get<std::size_t>(), buffer.size());
    std::vector<T> values(count * row / 4);
    for (std::size_t i = 0; i < count; ++i)
      std::memcpy(&values[i * row / 4], &buffer.at(start + first + i * stride), row);
    return values;
  }

  // An accessor whose least and largest numbers the format asks for.
  void expect_bounds(std::size_t index, std::size_t columns) const {
    const std::vector<float> all = numbers<float>(index);
    std::vector<float> low(all.begin(), all.begin() + std::ptrdiff_t(columns)), high = low;
    for (std::size_t i = 0; i < all.size(); ++i) {
      low[i % columns] = std::min(low[i % columns], all[i]);
      high[i % columns] = std::max(high[i % columns], all[i]);
    }
    EXPECT_EQ(document["accessors"][index]["min"].get<std::vector<float>>(), low);
    EXPECT_EQ(document["accessors"][index]["max"].get<std::vector<float>>(), high);
  }
};

void expect_no_empty_arrays(const json& value) {
  if (!value.is_structured()) return;
  EXPECT_FALSE(value.empty());
  for (const json& inner : value) expect_no_empty_arrays(inner);
}

void expect_good_meshes(const Glb& glb) {
  for (const json& mesh : glb.document["meshes"]) {
    for (const json& primitive : mesh["primitives"]) {
      const std::size_t position = primitive["attributes"]["POSITION"];
      glb.expect_bounds(position, 3);
      const std::vector<float> normals = glb.numbers<float>(primitive["attributes"]["NORMAL"]);
      EXPECT_EQ(normals.size(), glb.numbers<float>(position).size());
      for (std::size_t i = 0; i < normals.size(); i += 3)
        EXPECT_NEAR(std::hypot(normals[i], normals[i + 1], normals[i + 2]), 1, 1e-5);
      for (const u32 index : glb.numbers<u32>(primitive["indices"])) ASSERT_LT(index, normals.size() / 3);
      EXPECT_LT(primitive["material"].get<std::size_t>(), glb.document["materials"].size());
    }
  }
}

// Each node but the root of the scene has one parent.
void expect_a_tree(const Glb& glb) {
  std::multiset<std::size_t> children = {glb.document["scenes"].at(0)["nodes"].at(0).get<std::size_t>()};
  for (const json& node : glb.document["nodes"]) {
    for (const json& child : node.value("children", json::array())) children.insert(child.get<std::size_t>());
  }
  EXPECT_EQ(children.size(), glb.document["nodes"].size());
  for (std::size_t i = 0; i < glb.document["nodes"].size(); ++i) EXPECT_EQ(children.count(i), 1u) << i;
}

void expect_good_animation(const Glb& glb) {
  const json& animation = glb.document["animations"].at(0);
  std::set<std::pair<std::size_t, std::string>> targets;
  for (const json& channel : animation["channels"]) {
    const json& sampler = animation["samplers"].at(channel["sampler"].get<std::size_t>());
    const std::size_t input = sampler["input"];
    glb.expect_bounds(input, 1);
    const std::vector<float> times = glb.numbers<float>(input);
    EXPECT_EQ(std::set(times.begin(), times.end()).size(), times.size());
    EXPECT_TRUE(std::is_sorted(times.begin(), times.end()));
    const std::string path = channel["target"]["path"];
    const std::size_t columns = path == "rotation" ? 4 : 3;
    const std::vector<float> output = glb.numbers<float>(sampler["output"]);
    EXPECT_EQ(output.size(), columns * times.size());
    for (std::size_t i = 0; columns == 4 && i < output.size(); i += 4) {
      const auto dot = [&](std::size_t j) {
        return output[i] * output[j] + output[i + 1] * output[j + 1] + output[i + 2] * output[j + 2] +
               output[i + 3] * output[j + 3];
      };
      ASSERT_NEAR(dot(i), 1, 1e-5);
      ASSERT_TRUE(i == 0 || dot(i - 4) >= 0) << "the long way round";
    }
    EXPECT_TRUE(targets.emplace(channel["target"]["node"], path).second);
    EXPECT_LT(channel["target"]["node"].get<std::size_t>(), glb.document["nodes"].size());
  }
}

TEST_F(CommandLine, AMotionKeepsTheRulesOfGltf) {
  for (const char* scene : {"cylinders_and_hulls", "rag_doll", "sensor_gate", "heavy_top", "particles_bowl"}) {
    SCOPED_TRACE(scene);
    const std::string path = file("x.glb");
    const Outcome outcome = run(std::string("export ") + scene + " --steps 8 --device reference -o " + path);
    ASSERT_EQ(outcome.status, 0) << outcome.err;
    EXPECT_NE(outcome.out.find("keyframes over"), std::string::npos) << outcome.out;
    const Glb glb(path);
    EXPECT_EQ(glb.document["asset"]["version"], "2.0");
    expect_no_empty_arrays(glb.document);
    expect_good_meshes(glb);
    expect_a_tree(glb);
    expect_good_animation(glb);
  }
}

struct Recorded {
  std::vector<double> x, q;
};

// Of a body of a recording, after a step.
Recorded pose_of(const RecordingReader& recording, u32 body, u32 step) {
  const std::vector<float> x = recording.bodies<float>(0, step - 1), q = recording.bodies<float>(1, step - 1);
  return {{x.begin() + 3 * body, x.begin() + 3 * body + 3}, {q.begin() + 4 * body, q.begin() + 4 * body + 4}};
}

TEST_F(CommandLine, AnotherReaderFindsThePosesOfTheRecording) {
  const std::string recording = file("x.h5"), path = file("x.glb");
  ASSERT_EQ(run("run rag_doll --steps 50 --device reference --quiet --record " + recording).status, 0);
  const Outcome outcome = run("export " + recording + " --fps 20 --quiet -o " + path);
  ASSERT_EQ(outcome.status, 0) << outcome.err;
  EXPECT_EQ(outcome.out + outcome.err, "");

  Assimp::Importer importer;
  const aiScene* scene = importer.ReadFile(path, 0);
  ASSERT_NE(scene, nullptr) << importer.GetErrorString();
  ASSERT_EQ(scene->mNumAnimations, 1u);
  const aiAnimation& animation = *scene->mAnimations[0];
  const RecordingReader reader(recording);
  const InitialState<float> start = reader.start<float>();
  EXPECT_EQ(animation.mNumChannels, start.sizes.bodies - 2) << "all but the ground and the beam";
  const nlohmann::json file = nlohmann::json::parse(reader.label().scene_text);
  std::map<std::string, u32> bodies;
  for (u32 i = 0; i < start.sizes.bodies; ++i) bodies[file["bodies"][i]["name"]] = i;
  for (u32 i = 0; i < animation.mNumChannels; ++i) {
    const aiNodeAnim& channel = *animation.mChannels[i];
    const std::string name = channel.mNodeName.C_Str();
    ASSERT_TRUE(bodies.count(name)) << name;
    ASSERT_EQ(channel.mNumPositionKeys, 18u) << "each third step of 50, the first state and the last one";
    ASSERT_EQ(channel.mNumRotationKeys, 18u);
    for (u32 k = 1; k < 18; ++k) {
      const u32 step = std::min(3 * k, 50u);
      const aiVectorKey& key = channel.mPositionKeys[k];
      const aiQuatKey& rotation = channel.mRotationKeys[k];
      EXPECT_NEAR(key.mTime / animation.mTicksPerSecond, step / 60.0, 1e-6);
      const Recorded pose = pose_of(reader, bodies[name], step);
      EXPECT_EQ(double(key.mValue.x), pose.x[0]);
      EXPECT_EQ(double(key.mValue.y), pose.x[1]);
      EXPECT_EQ(double(key.mValue.z), pose.x[2]);
      const double cosine = double(rotation.mValue.x) * pose.q[0] + double(rotation.mValue.y) * pose.q[1] +
                            double(rotation.mValue.z) * pose.q[2] + double(rotation.mValue.w) * pose.q[3];
      EXPECT_NEAR(std::abs(cosine), 1, 1e-6);
    }
    // up is y: a body at x, y, z is found at x, z, -y
    const aiNode* node = scene->mRootNode->FindNode(channel.mNodeName);
    ASSERT_NE(node, nullptr);
    aiMatrix4x4 whole = node->mTransformation;
    for (const aiNode* up = node->mParent; up != nullptr; up = up->mParent) whole = up->mTransformation * whole;
    const Vec4<float>& at = start.buffers.positions[bodies[name]];
    EXPECT_NEAR(whole.a4, at.x, 1e-5f);
    EXPECT_NEAR(whole.b4, at.z, 1e-5f);
    EXPECT_NEAR(whole.c4, -at.y, 1e-5f);
  }
}

// A box is drawn as large as it is, in the colour of its body.
TEST_F(CommandLine, ShapesOfAMotionHaveTheirSizes) {
  std::ofstream(file("box.json")) << R"({"gravity": [0, 0, 0], "bodies": [{"name": "brick", "density": 1,
      "angular_velocity": [0, 0, 1], "shapes": [{"type": "box", "size": [2, 4, 6]}]}]})";
  ASSERT_EQ(run("export " + file("box.json").string() + " --steps 2 --quiet -o " + file("box.glb").string()).status, 0);
  const Glb glb(file("box.glb"));
  const json& nodes = glb.document["nodes"];
  ASSERT_EQ(nodes.size(), 3u) << "the shape, the body, and what turns up";
  EXPECT_EQ(nodes[0]["scale"], json::array({1, 2, 3}));
  EXPECT_EQ(nodes[1]["name"], "brick");
  EXPECT_EQ(glb.document["meshes"].size(), 1u);
  EXPECT_EQ(glb.document["materials"].size(), 1u);
  EXPECT_FALSE(glb.document["materials"][0].contains("alphaMode"));
}

TEST_F(CommandLine, ASceneMovesAsItsRecordingDoes) {
  const std::string recording = file("x.h5"), a = file("a.glb"), b = file("b.glb");
  ASSERT_EQ(run("run dzhanibekov --steps 40 --device reference --quiet --record " + recording).status, 0);
  ASSERT_EQ(run("export " + recording + " --quiet -o " + a).status, 0);
  ASSERT_EQ(run("export dzhanibekov --steps 40 --device reference --quiet -o " + b).status, 0);
  EXPECT_EQ(read_whole_file(a), read_whole_file(b));
}

// A robot's file in the place of a scene: what is said of scenes is true of it.
TEST_F(CommandLine, ARobotIsRunRecordedVerifiedDrawnAndExported) {
  const std::string robot = file("arm.urdf"), recording = file("x.h5"), glb = file("x.glb");
  std::ofstream(robot) << R"(<robot name="arm"><link name="world"/><link name="rod"><inertial><origin xyz="0 0 -0.5"/>
      <mass value="1"/><inertia ixx="0.08" iyy="0.08" izz="0.01"/></inertial>
      <collision><origin xyz="0 0 -0.5"/><geometry><capsule radius="0.1" length="0.8"/></geometry></collision></link>
    <joint name="pivot" type="continuous"><parent link="world"/><child link="rod"/><origin rpy="0 1 0"/>
      <axis xyz="0 1 0"/></joint></robot>)";
  ASSERT_EQ(run("run " + robot + " --steps 20 --device reference --quiet --record " + recording).status, 0);
  EXPECT_EQ(run("verify " + recording + " --device reference").status, 0);
  const Outcome drawn = run("render " + recording + " --at 20 --size 96x64 --out " + file("pictures").string());
  EXPECT_EQ(drawn.status, 0) << drawn.err;
  EXPECT_TRUE(fs::exists(file("pictures/arm_000020.png")));
  ASSERT_EQ(run("export " + recording + " --quiet -o " + glb).status, 0);
  const Glb exported(glb);
  const json& nodes = exported.document["nodes"];
  EXPECT_TRUE(std::any_of(nodes.begin(), nodes.end(), [](const json& n) { return n.value("name", "") == "arm/rod"; }));
  EXPECT_EQ(exported.document["animations"][0]["channels"].size(), 2u);
  std::ofstream(robot) << "<robot name=\"arm\">\n<link name=\"a\"/>\n</robot>\n";
  expect_refused("run " + robot, 2, "arm.urdf: has no link that moves or touches anything");
}

TEST_F(CommandLine, RefusesMotionsThatCannotBeWritten) {
  const std::string glb = file("x.glb"), recording = file("x.h5");
  expect_refused("export box_stack -o " + file("x.gltf").string(), 2, ".glb");
  expect_refused("export box_stack --at 3 -o " + glb, 2, "--at: is for the constraint system");
  expect_refused("export box_stack --at 3 --fps 3 -o " + file("x.hdf5").string(), 2, "--fps: is for a motion");
  expect_refused("export box_stack --fps 0 -o " + glb, 2, "--fps");
  expect_refused("export box_stack -o /nowhere/x.glb", 2, "/nowhere/x.glb");
  expect_refused("export spheres8000 --device reference --steps 30000 --fps 1000 -o " + glb, 2,
                 "a binary glTF file ends at 4294967295; ask for a lower --fps");
  EXPECT_FALSE(fs::exists(glb));
  ASSERT_EQ(run("run box_stack --steps 3 --device reference --quiet --record " + recording).status, 0);
  expect_refused("export " + recording + " --steps 3 -o " + glb, 2, "--steps is for what is simulated");
  expect_refused("export " + recording + " --at 3 -o " + file("x.hdf5").string(), 2, "is a recording");
  std::ofstream(glb) << "mine";
  expect_refused("export " + recording + " -o " + glb, 2, "does not overwrite it");
}

}  // namespace
}  // namespace lockstep::export_motion_test
