"""Actuators of robots by name, by number and all at once; keyframes; springs that are moved."""
import pathlib
import tempfile
import unittest

import numpy as np

import lockstep

ROBOT = """<mujoco model="r"><compiler angle="radian"/><option gravity="0 0 0" timestep="0.001"/><worldbody>
<body name="wheel"><joint name="axle" axis="0 0 1"/><inertial pos="0 0 0" mass="1" diaginertia="2 2 2"/></body>
<body name="cart"><joint name="rail" type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="3" diaginertia="1 1 1"/></body>
</worldbody><actuator><motor name="m" joint="axle" gear="4"/><position name="p" joint="rail" kp="300" kv="60"/></actuator>
<keyframe><key name="home" qpos="0.5 -2" ctrl="0 -2"/></keyframe></mujoco>"""


class Actuators(unittest.TestCase):
    def world(self, **options):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "robot.xml"
            path.write_text(ROBOT)
            return lockstep.World.load(path, device="reference", precision="double", **options)

    def test_controls(self):
        world = self.world()
        self.assertEqual(world.actuators, ["r/m", "r/p"])
        world.set_control("r/m", 1)
        world.set_control(1, 0.25)
        np.testing.assert_array_equal(world.controls, [1, 0.25])
        world.step(100)
        self.assertAlmostEqual(world.joint_state(world.joint("r/axle")).speed, 4 * 1 * 0.1 / 2)
        world.set_controls([0, 0.5])
        world.step(5000)
        self.assertAlmostEqual(world.joint_state(world.joint("r/rail")).coordinate, 0.5, 6)
        world.set_rest(world.joint("r/rail"), -0.5)
        world.step(5000)
        self.assertAlmostEqual(world.joint_state(world.joint("r/rail")).coordinate, -0.5, 6)

    def test_keyframes(self):
        world = self.world(keyframe="home")
        self.assertAlmostEqual(world.joint_state(world.joint("r/axle")).coordinate, 0.5)
        world.step(1000)
        self.assertAlmostEqual(world.joint_state(world.joint("r/rail")).coordinate, -2)
        np.testing.assert_array_equal(world.controls, [0, -2])

    def test_what_is_refused(self):
        world = self.world()
        for call, line in (
            (lambda: world.set_control("r/q", 1), 'world: unknown actuator "r/q"; did you mean "r/m"?'),
            (lambda: world.set_control(2, 1), "world: has no actuator 2; it has 2"),
            (lambda: world.set_controls([1]), "controls: must be 2 numbers, are 1"),
            (lambda: world.set_control(0, float("nan")), 'actuator "r/m": must be finite and fit double, is nan'),
            (lambda: world.set_rest(world.joint("r/axle"), 1), 'joint "r/axle": has no spring; change() gives it one'),
            (lambda: self.world(keyframe="hom"), None),
        ):
            with self.assertRaises(lockstep.Error) as caught:
                call()
            if line:
                self.assertEqual(str(caught.exception), line)


if __name__ == "__main__":
    unittest.main()
