"""What is refused, and in which words; and that all is described."""
import inspect
import math
import os
import signal
import tempfile
import threading
import unittest
import warnings

import lockstep

BALL = {"mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]}


class Errors(unittest.TestCase):
    def refusal(self, make):
        with self.assertRaises(lockstep.Error) as caught:
            make()
        self.assertEqual(caught.exception.failure, "input")
        line = str(caught.exception)
        self.assertNotIn("\n", line)
        return line

    def test_scenes(self):
        def world_of(scene, **more):
            return lambda: lockstep.World(scene, **more)

        self.assertEqual(
            self.refusal(world_of({"bodies": [{**BALL, "mass": -1}]})), "scene.json: /bodies/0/mass: must be > 0, is -1"
        )
        self.assertIn("here.json: /bodies: is empty", self.refusal(world_of({"bodies": []}, source="here.json")))
        self.assertIn("not JSON", self.refusal(world_of("{")))
        self.assertIn('scene.json: /bodies/0/mass: must be finite, is nan',
                      self.refusal(world_of({"bodies": [{**BALL, "mass": float("nan")}]})))
        self.assertIn("unknown key", self.refusal(world_of({"bodies": [BALL], "robot": []})))
        self.assertIn("no built-in scene", self.refusal(lambda: lockstep.World.load("nothing_of_the_kind")))
        self.assertIn("precision", self.refusal(world_of({"bodies": [BALL]}, precision="half")))
        self.assertIn("device", self.refusal(world_of({"bodies": [BALL]}, device="abacus")))

    def test_what_a_robot_file_says_that_is_left_out(self):
        inertial = '<inertial><mass value="1"/><inertia ixx="1" iyy="1" izz="1"/></inertial>'
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "one.urdf")
            with open(path, "w") as file:
                file.write(f'<robot name="one"><link name="a">{inertial}</link><gazebo/></robot>')
            with self.assertWarnsRegex(UserWarning, "one.urdf: left out: 1 x `gazebo`"):
                lockstep.World.load(path, device="reference", packages={"one": folder})
            line = self.refusal(lambda: lockstep.World.load(path, device="reference", strict=True))
            self.assertIn("<gazebo>: is not simulated: it would be left out (--strict)", line)

    def test_bodies_and_joints(self):
        world = lockstep.World({"bodies": [BALL]}, device="reference")
        ball = world.bodies[0]
        self.assertEqual(self.refusal(lambda: world.add_body({"mass": 0})), "body: /mass: must be > 0, is 0")
        self.assertIn("unknown key", self.refusal(lambda: world.add_body({"generator": "line"})))
        self.assertIn(
            "unknown material", self.refusal(lambda: world.add_body({**BALL, "shapes": [{"type": "sphere", "radius": 1, "material": "x"}]}))
        )
        self.assertEqual(self.refusal(lambda: world.body("nobody")), "world: has no body of the name 'nobody'")
        self.assertIn("has no joint", self.refusal(lambda: world.joint("none")))
        self.assertIn("/bodies", self.refusal(lambda: world.add_joint({"type": "ball", "bodies": ["a", "b"]}, ball)))
        self.assertIn("unknown joint", self.refusal(lambda: world.add_joint({"type": "hing"}, ball)))
        self.assertIn("body with the handle 7: is not in this world", self.refusal(lambda: world.pose(lockstep.Body(7))))
        other = lockstep.World({"bodies": [BALL]}, device="reference")
        self.assertIn("is of another world", self.refusal(lambda: world.pose(other.bodies[0])))
        self.assertIn("finite", self.refusal(lambda: world.apply_impulse(ball, [float("inf"), 0, 0])))
        self.assertIn("kinematic", self.refusal(lambda: world.set_kinematic_target(ball, [0, 0, 0])))
        self.assertIn("times must rise", self.refusal(lambda: world.set_load_table(ball, [1, 0], [[0] * 6] * 2)))
        self.assertIn("(n, 3)", self.refusal(lambda: world.cast_rays([[0, 0, 0]], [[0, 0]])))
        with self.assertRaises(TypeError):
            world.pose("ball")
        with self.assertRaises(TypeError):
            lockstep.World({"bodies": [object()]})
        for scene, line in (({"gravity": [0, 0, math.nan], "bodies": [BALL]}, "scene.json: /gravity/2: must be finite, is nan"),
                            ({"bodies": [{**BALL, "mass": math.inf}]}, "scene.json: /bodies/0/mass: must be finite, is inf"),
                            (math.nan, "scene.json: /: must be finite, is nan")):
            with self.assertRaises(lockstep.Error) as caught:
                lockstep.World(scene)
            self.assertEqual(str(caught.exception), line)

    def test_arguments_of_the_wrong_type_are_told_in_one_line(self):
        world = lockstep.World({"bodies": [BALL]}, device="reference")
        ball = world.bodies[0]
        cases = (
            (lambda: world.pose("ball"), "World.pose(): body must be a lockstep.Body, is 'ball' (str)"),
            (lambda: world.step(-1), "World.step(): count must be a whole number from 0 on, is -1 (int)"),
            (lambda: world.step(1.5), "World.step(): count must be a whole number from 0 on, is 1.5 (float)"),
            (lambda: world.step(cuont=3), 'World.step(): has no argument "cuont"; did you mean "count"?'),
            (lambda: world.step(1, 2), "World.step(): takes at most 1 argument without a name, is given 2"),
            (lambda: world.step(1, count=2), "World.step(): is given count twice"),
            (lambda: world.apply_impulse(), "World.apply_impulse(): needs body: a lockstep.Body"),
            (lambda: world.apply_force(ball, [1, 2]), "World.apply_force(): force must be 3 numbers, is [1, 2] (list)"),
            (lambda: world.set_load(ball, 5), "World.set_load(): load must be a function, or None, is 5 (int)"),
            (lambda: world.remove(3), "World.remove(): takes (body: a lockstep.Body) or (joint: a lockstep.Joint), is given 3 (int)"),
            (lambda: world.restore(world), "World.restore(): snapshot must be a lockstep.Snapshot, is a World"),
            (lambda: lockstep.World(), "World(): needs scene"),
            (lambda: lockstep.World({}, devise="cpu"), 'World(): has no argument "devise"; did you mean "device"?'),
            (lambda: lockstep.World({}, precision=3), "World(): precision must be a str, is 3 (int)"),
            (lambda: lockstep.scenes(1), "scenes(): takes at most 0 arguments without a name, is given 1"),
        )
        for call, line in cases:
            with self.assertRaises(TypeError) as caught:
                call()
            self.assertEqual(str(caught.exception), line)
        for value in ("x" * 10000, ["\n"] * 1000, {"a": "ä" * 500}):
            for call in (lambda: world.pose(value), lambda: world.step(value), lambda: world.apply_force(ball, value)):
                with self.assertRaises(TypeError) as caught:
                    call()
                self.assertLessEqual(len(str(caught.exception)), 300)
                self.assertNotIn("\n", str(caught.exception))

    def test_a_run_that_goes_bad(self):
        world = lockstep.World({"bodies": [{**BALL, "name": "ball", "velocity": [1, 0, 0]}], "settings": {"speed_limit": 5}})
        with self.assertRaisesRegex(lockstep.Error, 'body "ball": the forces leave it at 5.* m/s, above the setting "speed_limit" of 5 m/s') as caught:
            world.step(600)
        self.assertEqual(caught.exception.failure, "comparison")

    def test_what_looks_like_a_mistake_is_warned_of_once(self):
        ground = {"type": "static", "shapes": [{"type": "plane"}]}
        world = lockstep.World({"bodies": [ground, BALL]}, device="reference", source="ball.json")
        self.assertEqual(len(world.suspicions()), 1)
        with self.assertWarnsRegex(UserWarning, "ball.json: body 1 starts 0.5 m below body 0"):
            world.step()
        self.assertEqual(world.suspicions(), [])
        sound = lockstep.World({"bodies": [ground, {**BALL, "position": [0, 0, 0.5]}]}, device="reference")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            world.step()
            sound.step()

    def test_ctrl_c_ends_many_steps_between_two_of_them(self):
        world = lockstep.World({"gravity": [0, 0, 0], "bodies": [BALL]}, device="reference")
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        timer = threading.Timer(0.2, os.kill, [os.getpid(), signal.SIGINT])
        timer.start()
        try:
            with self.assertRaises(KeyboardInterrupt):
                world.step(4_000_000_000)
        finally:
            timer.cancel()
            signal.signal(signal.SIGINT, before)
        done = world.steps_done
        self.assertGreater(done, 0)
        world.step()
        self.assertEqual(world.steps_done, done + 1)

    def test_everything_is_described(self):
        for name, thing in inspect.getmembers(lockstep):
            if name.startswith("__"):
                continue
            self.assertTrue(inspect.getdoc(thing), name)
            if inspect.isclass(thing) and not issubclass(thing, Exception):
                for member, value in vars(thing).items():
                    if not member.startswith("__"):
                        self.assertTrue(inspect.getdoc(value), f"{name}.{member}")


class Lists(unittest.TestCase):
    def test_scenes_and_devices(self):
        self.assertIn("slide_to_roll", lockstep.scenes())
        self.assertTrue(all(lockstep.scenes().values()))
        self.assertIsInstance(lockstep.devices(), list)


if __name__ == "__main__":
    unittest.main()
