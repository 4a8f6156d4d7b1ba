"""Snapshots of worlds in Python, and kernels that are built ahead."""
import gc
import os
import subprocess
import tempfile
import unittest

import lockstep

PROGRAM = os.environ["LOCKSTEP_PROGRAM"]
BALL = {"mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]}
GROUND = {"name": "ground", "type": "static", "shapes": [{"type": "plane"}]}


class Snapshots(unittest.TestCase):
    def world(self, device, precision):
        world = lockstep.World(
            {"bodies": [GROUND], "settings": {"solver": "small_steps"}}, device=device, precision=precision, quiet=True
        )
        for i in range(4):
            world.add_body({**BALL, "name": f"ball {i}", "position": [0.1 * i, 0, 0.5 + 1.1 * i]})
        return world

    def hashes(self, world, steps):
        found = []
        for _ in range(steps):
            world.step()
            found.append(world.state_hash())
        return found

    def test_eight_that_are_kept_over_twenty_steps_give_equal_hashes(self):
        for device in ("reference", "auto"):
            for precision in ("float", "double"):
                world, kept, hashes = self.world(device, precision), [], []
                for _ in range(20):
                    kept = [*kept[-7:], world.save()]
                    hashes += self.hashes(world, 1)
                for k in (7, 0, 4, 2, 6, 1, 5, 3):
                    world.restore(kept[k])
                    self.assertEqual((world.steps_done, kept[k].steps_done), (12 + k, 12 + k))
                    self.assertEqual(world.time, kept[k].time)
                    self.assertEqual(self.hashes(world, 8 - k), hashes[12 + k :], (device, precision, k))

    def test_what_came_or_went_is_as_it_was(self):
        world = self.world("reference", "double")
        ball = world.body("ball 2")
        hinge = world.add_joint({"type": "hinge", "anchor": [0.2, 0, 2.7], "axis": [0, 1, 0]}, ball)
        pushes = []
        world.set_load(ball, lambda time: pushes.append(time) or [0, 1, 0, 0, 0, 0])
        world.step(5)
        snapshot = world.save()
        self.assertEqual(repr(snapshot), "<lockstep.Snapshot after 5 steps>")
        bodies, hashes = world.bodies, self.hashes(world, 10)
        world.remove(ball)
        new = world.add_body({**BALL, "position": [5, 0, 3]})
        world.step(3)
        world.restore(snapshot)
        self.assertEqual(world.bodies, bodies)
        self.assertTrue(world.contains(ball) and world.contains(hinge))
        self.assertFalse(world.contains(new))
        pushes.clear()
        self.assertEqual(self.hashes(world, 10), hashes)
        self.assertEqual(len(pushes), 10)
        self.assertNotEqual(world.add_body({**BALL, "position": [5, 0, 3]}), new)

    def test_a_recording_of_a_world_that_goes_back_is_verified(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "run.h5")
            world = self.world("auto", "float")
            world.record(path)
            world.step(4)
            snapshot = world.save()
            for push in (1, 2, 3):
                world.restore(snapshot)
                world.apply_impulse(world.bodies[-1], [push, 0, 0])
                world.step(5)
            world.end_recording()
            self.assertEqual(os.listdir(folder), ["run.h5"])
            for device in ("reference", "auto"):
                subprocess.run([PROGRAM, "verify", path, "--device", device, "--quiet"], check=True)

    def test_a_snapshot_of_another_world_is_refused(self):
        world, other = self.world("reference", "float"), self.world("reference", "float")
        snapshot = other.save()
        with self.assertRaisesRegex(lockstep.Error, "^snapshot: is of another world; only the one that made it"):
            world.restore(snapshot)
        with self.assertRaises(TypeError):
            world.restore(None)
        del other
        gc.collect()
        self.assertEqual(snapshot.steps_done, 0)

    def test_warming_up_changes_nothing(self):
        drum = {"name": "drum", "density": 500, "position": [3, 0, 1], "shapes": [{"type": "cylinder", "radius": 0.3, "length": 0.5}]}
        for device in ("reference", "auto"):
            cold, warm = self.world(device, "float"), self.world(device, "float")
            warm.warm_up(bodies=[drum])
            for world in (cold, warm):
                world.step(3)
                world.add_body(drum)
            warm.warm_up(forces=False, questions=False)
            self.assertEqual(self.hashes(warm, 5), self.hashes(cold, 5))
        with self.assertRaisesRegex(lockstep.Error, "body: /mass: must be > 0"):
            warm.warm_up(bodies=[{"mass": 0}])
        bare = self.world("reference", "float")
        for body in bare.bodies:
            bare.remove(body)
        with self.assertRaisesRegex(lockstep.Error, "has no bodies to be warmed up for"):
            bare.warm_up()


if __name__ == "__main__":
    unittest.main()
