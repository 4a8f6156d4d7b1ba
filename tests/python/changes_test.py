"""What changes while a world runs, as Python says it."""
import os
import subprocess
import tempfile
import unittest

import lockstep
import numpy as np

PROGRAM = os.environ["LOCKSTEP_PROGRAM"]
BALL = {"mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]}
GROUND = {"name": "ground", "type": "static", "shapes": [{"type": "plane"}]}


def in_double(document):
    return lockstep.World(document, precision="double", device="reference")


class Changes(unittest.TestCase):
    def test_a_body_is_described_anew(self):
        world = in_double({"bodies": [{**BALL, "name": "ball", "position": [0, 0, 9]}]})
        ball = world.body("ball")
        world.step(10)
        pose = world.pose(ball)
        world.change_body(ball, {"type": "static", "shapes": BALL["shapes"], "position": [1, 2, 3]})
        world.step(10)
        np.testing.assert_array_equal(world.pose(ball), pose)
        self.assertEqual((world.kind(ball), world.name(ball)), ("static", "ball"))
        world.change_body(ball, {**BALL, "mass": 3, "name": "heavy"})
        self.assertEqual((world.mass(ball), world.body("heavy")), (3, ball))
        world.step(10)
        self.assertAlmostEqual(world.velocity(ball)[2], -9.81 * 10 / 60, places=12)
        with self.assertRaisesRegex(lockstep.Error, 'body "heavy": needs "mass" or "density"'):
            world.change_body(ball, {"shapes": BALL["shapes"]})

    def test_a_joint_is_described_anew(self):
        world = in_double({"bodies": [BALL], "gravity": [0, 0, 0]})
        hinge = {"type": "hinge", "anchor": [0, 0, 0], "axis": [0, 0, 1], "name": "axle"}
        axle = world.add_joint(hinge, world.bodies[0])
        motor = {"speed": 1, "max_torque": 10}
        world.change_joint(axle, {"limits": [-1, 0.5], "motor": motor})
        world.step(120)
        self.assertAlmostEqual(world.joint_state(axle).coordinate, 0.5, places=6)
        world.change_joint(axle, {**hinge, "anchor": [9, 9, 9], "limits": [-1, 0.75], "motor": motor})
        world.step(120)
        self.assertAlmostEqual(world.joint_state(axle).coordinate, 0.75, places=6)
        self.assertEqual(world.joint("axle"), axle)
        world.change_joint(axle, {"spring": {"stiffness": 50, "damping": 20, "rest": -0.25}})
        world.step(600)
        self.assertAlmostEqual(world.joint_state(axle).coordinate, -0.25, places=6)
        with self.assertRaisesRegex(lockstep.Error, 'unknown key "limit"; did you mean "limits"'):
            world.change_joint(axle, {"limit": [0, 1]})
        with self.assertRaisesRegex(lockstep.Error, "stays a hinge"):
            world.change_joint(axle, {"type": "slider", "limits": [0, 1]})
        with self.assertRaisesRegex(lockstep.Error, 'stays a hinge'):
            world.change_joint(axle, {"type": "wobbly"})

    def test_gravity_and_the_bound_on_speeds(self):
        world = in_double({"bodies": [BALL]})
        np.testing.assert_array_equal(world.gravity, [0, 0, -9.81])
        world.set_gravity([0, 6, 0])
        np.testing.assert_array_equal(world.gravity, [0, 6, 0])
        world.step(60)
        self.assertAlmostEqual(world.velocity(world.bodies[0])[1], 6, places=12)
        world.set_speed_limit(5)
        self.assertEqual(world.speed_limit, 5)
        with self.assertRaisesRegex(lockstep.Error, "speed_limit"):
            world.step()

    def test_materials(self):
        box = {"mass": 1, "position": [0, 0, 0.5], "shapes": [{"type": "box", "size": [1, 1, 1], "material": "wood"}]}
        materials = [{"name": "stone", "friction": 0.5}, {"name": "wood", "friction": 0.5, "restitution": 0.25}]
        world = in_double({"bodies": [GROUND, box], "materials": materials})
        body = world.bodies[1]

        def slows_by(mu):
            world.set_velocity(body, [3, 0, 0])
            world.step(12)
            self.assertAlmostEqual(world.velocity(body)[0], 3 - mu * 9.81 * 0.2, delta=0.02)

        slows_by(0.5)
        world.set_material("wood", friction=0)
        slows_by(0)
        world.set_material_pair("wood", "stone", 0.3, 0)
        slows_by(0.3)
        with self.assertRaisesRegex(lockstep.Error, 'unknown material "woods"; did you mean "wood"'):
            world.set_material("woods", friction=0)
        with self.assertRaisesRegex(lockstep.Error, 'material "wood": must have no negative friction'):
            world.set_material("wood", friction=-1)

    def test_masks_take_names(self):
        shape = {"type": "sphere", "radius": 0.5}
        world = in_double(
            {
                "bodies": [
                    {"type": "static", "position": [2, 0, 0], "shapes": [{**shape, "category": "walls"}]},
                    {**BALL, "position": [5, 0, 0]},
                ]
            }
        )
        wall, ball = world.bodies
        ghost = world.add_body({**BALL, "position": [8, 0, 0], "shapes": [{**shape, "category": "ghosts"}]})
        self.assertEqual([world.category_mask([name]) for name in ("default", "walls", "ghosts")], [1, 2, 4])
        ray = ([0, 0, 0], [1, 0, 0])
        self.assertEqual(world.cast_ray(*ray).body, wall)
        self.assertEqual(world.cast_ray(*ray, mask="default").body, ball)
        self.assertEqual(world.cast_ray(*ray, mask=["ghosts"]).body, ghost)
        self.assertEqual(world.cast_ray(*ray, mask=5).body, ball)
        self.assertEqual(world.cast_rays([ray[0]], [ray[1]], mask="ghosts")["body"].tolist(), [ghost.id])
        self.assertEqual(world.overlapping_sphere([0, 0, 0], 20, mask=["walls", "ghosts"]), [wall, ghost])
        self.assertEqual(world.overlapping_box([0, 0, 0], [20, 1, 1], mask="walls"), [wall])
        with self.assertRaisesRegex(lockstep.Error, 'mask: unknown category "wall"; did you mean "walls"'):
            world.cast_ray(*ray, mask="wall")

    def test_they_are_recorded_and_gone_back_over(self):
        with tempfile.TemporaryDirectory() as folder:
            world = lockstep.World({"bodies": [GROUND, {**BALL, "position": [0, 0, 0.6]}]})
            world.record(os.path.join(folder, "run.h5"))
            world.step(10)
            kept = world.save()
            hashes = []
            for _ in range(2):
                world.restore(kept)
                world.set_gravity([1, 0, -5])
                world.step(5)
                world.change_body(world.bodies[1], {**BALL, "mass": 7})
                world.step(5)
                hashes.append(world.state_hash())
            world.end_recording()
            self.assertEqual(*hashes)
            self.assertEqual(world.mass(world.bodies[1]), 7)
            for file in sorted(os.listdir(folder)):
                subprocess.run([PROGRAM, "verify", os.path.join(folder, file), "--quiet"], check=True)


if __name__ == "__main__":
    unittest.main()
