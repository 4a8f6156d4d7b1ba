// Couplings that the files of robots have: mimic joints of URDF, equality constraints and fixed tendons of MJCF.
#include <cmath>

#include "host/report/joints.hpp"
#include "tests/joints/joint_scene.hpp"
#include "tests/mjcf_scene.hpp"
#include "tests/robots.hpp"

namespace lockstep::robot_couplings_test {
namespace {

using mjcf_scene::mjcf;

struct Ends {
  double a, b;
};

// The coordinates of the first two joints after a second.
template <class real>
Ends after_a_second(const Scene& scene) {
  const InitialState<real> state = compile<real>(scene);
  const Buffers<real> b = test::after_steps<real>(scene, u32(std::lround(1 / scene.settings.dt)));
  return {measure_joint(b, state.params, 0).coordinate, measure_joint(b, state.params, 1).coordinate};
}

const std::string rods = R"(<worldbody>
  <body pos="0 0 1"><joint name="a" axis="0 1 0"/><inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.02 0.02"/></body>
  <body pos="0 1 1"><joint name="b" axis="0 1 0"/><inertial pos="0 0 -0.4" mass="2" diaginertia="0.03 0.03 0.01"/></body>
</worldbody>)";

// Right values are those of MuJoCo 4.0 by Runge-Kutta 4 with steps of 0.2 ms.
TEST(RobotCouplings, OfMjcfJointsAreGears) {
  const Scene scene = mjcf(rods + R"(<equality><joint joint1="b" joint2="a" polycoef="0 -0.5 0 0 0"/></equality>)");
  ASSERT_EQ(scene.couplings.size(), 1u);
  for (const Ends& ends : {after_a_second<float>(scene), after_a_second<double>(scene)}) {
    EXPECT_NEAR(ends.a, 1.1419715, 0.01);
    EXPECT_NEAR(ends.b, -0.5709858, 0.01);
    EXPECT_NEAR(ends.b, -0.5 * ends.a, 1e-5);
  }
}

const std::string chain = R"(<worldbody><body pos="0 0 1">
  <joint name="a" axis="0 1 0"/><inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>
  <body pos="0.6 0 0"><joint name="b" axis="0 1 0"/><inertial pos="0.2 0 0" mass="0.5" diaginertia="0.002 0.01 0.01"/></body>
</body></worldbody>)";
const std::string of_tendon = R"(><joint joint="a" coef="1"/><joint joint="b" coef="-0.5"/></fixed>)";

TEST(RobotCouplings, OfFixedTendonsHaveSprings) {
  const Scene scene = mjcf(chain + R"(<tendon><fixed name="t" stiffness="20" damping="0.3" springlength="0.2")" +
                           of_tendon + "</tendon>");
  for (const Ends& ends : {after_a_second<float>(scene), after_a_second<double>(scene)}) {
    EXPECT_NEAR(ends.a, 2.7244580, 0.01);
    EXPECT_NEAR(ends.b, 4.8128601, 0.01);
  }
}

// Lengths are those of the file's coordinates, which are not 0 where bodies stand at load.
TEST(RobotCouplings, OfFixedTendonsKnowReferences) {
  const std::string bodies = R"(<compiler angle="radian"/><worldbody><body>
    <joint name="a" axis="0 1 0" ref="0.5"/><inertial pos="0.3 0 0" mass="1" diaginertia="0.01 0.02 0.02"/>
    </body></worldbody>)";
  const auto coupling = [&](const std::string& attributes) {
    const Scene scene =
        mjcf(bodies + "<tendon><fixed " + attributes + "><joint joint=\"a\" coef=\"2\"/></fixed></tendon>");
    return scene.couplings.at(0);
  };
  const CouplingDescription limited = coupling("range=\"0 3\" damping=\"1\"");
  EXPECT_TRUE(limited.limited);
  EXPECT_EQ(limited.low, -1);
  EXPECT_EQ(limited.high, 2);
  EXPECT_EQ(limited.joints[0].ratio, 2);
  EXPECT_EQ(limited.spring->damping, 1);
  EXPECT_EQ(limited.spring->rest, 0);
  EXPECT_EQ(coupling("stiffness=\"1\"").spring->rest, 0);
  EXPECT_EQ(coupling("stiffness=\"1\" springlength=\"3\"").spring->rest, 2);
  EXPECT_FALSE(coupling("range=\"0 3\" limited=\"false\" damping=\"1\"").limited);
}

TEST(RobotCouplings, OfTendonsAreTiedToEachOther) {
  const std::string tendons =
      "<tendon><fixed name=\"s\"><joint joint=\"b\" coef=\"3\"/></fixed><fixed name=\"t\"" + of_tendon + "</tendon>";
  const Scene both =
      mjcf(chain + tendons + R"(<equality><tendon tendon1="s" tendon2="t" polycoef="0.1 2 0 0 0"/></equality>)");
  const CouplingDescription& tied = both.couplings.at(0);
  EXPECT_EQ(tied.low, 0.1);
  EXPECT_EQ(tied.high, 0.1);
  ASSERT_EQ(tied.joints.size(), 2u);
  EXPECT_EQ(tied.joints[0].ratio, 3 + 2 * 0.5) << "of b";
  EXPECT_EQ(tied.joints[1].ratio, -2) << "of a";
  const Scene one = mjcf(chain + tendons + R"(<equality><tendon tendon1="t" polycoef="0.1"/></equality>)");
  EXPECT_EQ(one.couplings.at(0).low, 0.1);
  const Scene off = mjcf(chain + tendons + "<option><flag equality=\"disable\"/></option>" +
                         R"(<equality><tendon tendon1="t"/></equality>)");
  EXPECT_TRUE(off.couplings.empty());
}

class MimicJoints : public Robots {};

const std::string fingers =
    link("world", "") +
    link(
        "left",
        R"(<inertial><origin xyz="0.3 0 0"/><mass value="1"/><inertia ixx="0.01" iyy="0.02" izz="0.02"/></inertial>)") +
    link(
        "right",
        R"(<inertial><origin xyz="0 0 -0.4"/><mass value="2"/><inertia ixx="0.03" iyy="0.03" izz="0.01"/></inertial>)") +
    R"(<joint name="a" type="continuous"><parent link="world"/><child link="left"/><origin xyz="0 0 1"/><axis xyz="0 1 0"/></joint>
    <joint name="b" type="continuous"><parent link="world"/><child link="right"/><origin xyz="0 1 1"/><axis xyz="0 1 0"/>
      <mimic joint="a" multiplier="-1" offset="0.1"/></joint>)";

// It stands where it is to be from the beginning.
TEST_F(MimicJoints, FollowTheirLeaders) {
  Scene scene = scene_of(robot(fingers), "", R"(, "settings": {"dt": 0.002, "solver": "small_steps", "substeps": 10})");
  ASSERT_EQ(scene.couplings.size(), 1u);
  EXPECT_EQ(scene.couplings[0].name, "r/b");
  const InitialState<double> state = compile<double>(scene);
  EXPECT_NEAR(measure_joint(state.buffers, state.params, 1).coordinate, 0.1, 1e-12);
  for (const Ends& ends : {after_a_second<float>(scene), after_a_second<double>(scene)}) {
    EXPECT_NEAR(ends.a, 0.6311366, 0.01);
    EXPECT_NEAR(ends.b, -0.5311366, 0.01);
    EXPECT_NEAR(ends.b, 0.1 - ends.a, 1e-5);
  }
}

TEST_F(MimicJoints, StartWhereTheirLeadersDo) {
  const Scene scene = scene_of(robot(fingers), R"(, "joints": [{"name": "a", "start": 0.3}])");
  const InitialState<double> state = compile<double>(scene);
  EXPECT_NEAR(measure_joint(state.buffers, state.params, 0).coordinate, 0.3, 1e-12);
  EXPECT_NEAR(measure_joint(state.buffers, state.params, 1).coordinate, -0.2, 1e-12);
  EXPECT_EQ(refusal(robot(fingers), R"(, "joints": [{"name": "b", "start": 0.3}])"),
            "scene.json: /robots/0/joints/0: follows the joint \"a\", which says where it starts");
}

// Scenes tie the joints of robots, too.
TEST_F(MimicJoints, AreNamedByScenes) {
  const Scene scene = scene_of(robot(fingers), "", R"(, "couplings": [{"joints": ["r/a"], "limits": [-1, 1]}])");
  ASSERT_EQ(scene.couplings.size(), 2u);
  EXPECT_EQ(scene.couplings[1].joints[0].joint, 0u);
}

}  // namespace
}  // namespace lockstep::robot_couplings_test
