"""The Python module: the bits of the program, closed forms, and all that a world can be asked and told."""
import gc
import json
import os
import subprocess
import tempfile
import threading
import unittest

import lockstep
import numpy as np

PROGRAM = os.environ["LOCKSTEP_PROGRAM"]
BALL = {"mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]}
GROUND = {"name": "ground", "type": "static", "shapes": [{"type": "plane"}]}


def scene(*bodies, **more):
    return {"bodies": list(bodies), **more}


def program_hash(name, steps, device, folder):
    report = os.path.join(folder, "report.json")
    subprocess.run(
        [PROGRAM, "run", name, "--steps", str(steps), "--device", device, "--report", report, "--quiet"], check=True
    )
    with open(report) as file:
        return json.load(file)["state_hash"]


class Bits(unittest.TestCase):
    def test_the_state_is_that_of_the_program(self):
        with tempfile.TemporaryDirectory() as folder:
            for device in ("reference", "auto"):
                for name in ("slide_to_roll", "rag_doll"):
                    world = lockstep.World.load(name, device=device)
                    world.step(200)
                    self.assertEqual(world.state_hash(), program_hash(name, 200, device, folder), (name, device))

    def test_a_dict_is_the_scene_that_its_text_is(self):
        as_dict = scene({**BALL, "position": np.array([0, 0, 3.0])}, GROUND)
        as_text = json.dumps(scene({**BALL, "position": [0, 0, 3.0]}, GROUND))
        hashes = []
        for given in (as_dict, as_text):
            world = lockstep.World(given, device="reference")
            world.step(60)
            hashes.append(world.state_hash())
        self.assertEqual(hashes[0], hashes[1])

    def test_naming_a_solver_is_enough(self):
        for solver, brings in lockstep.solvers().items():
            hashes = []
            for more in ({}, {key: brings[key] for key in ("substeps", "iterations", "tolerance", "precision")}):
                settings = {"solver": solver, **more}
                world = lockstep.World(
                    scene({**BALL, "position": [0, 0, 0.5]}, GROUND, settings=settings), device="reference"
                )
                world.step(5)
                hashes.append(world.state_hash())
            self.assertEqual(hashes[0], hashes[1], solver)
        self.assertEqual((lockstep.solvers()["small_steps"]["substeps"], lockstep.solvers()["jacobi"]["iterations"]), (5, 30))

    def test_settings_are_those_of_the_table(self):
        for name, about in lockstep.settings().items():
            self.assertTrue(about["meaning"], name)
            bad = "qqqqqqqq" if about["names"] else -1
            with self.assertRaisesRegex(lockstep.Error, f"/settings/{name}: ") as refused:
                lockstep.World(scene(BALL, settings={name: bad}), device="reference")
            if about["bounds"]:
                self.assertIn(about["bounds"], str(refused.exception))
        with self.assertRaisesRegex(lockstep.Error, 'unknown key "slob"; did you mean "slop"'):
            lockstep.World(scene(BALL, settings={"slob": 0}), device="reference")

    def test_a_seed_draws_another_scene(self):
        heaps = [lockstep.World.load("mixed_spheres", device="reference", seed=seed).poses() for seed in (0, 0, 1)]
        np.testing.assert_array_equal(heaps[0], heaps[1])
        self.assertGreater(np.abs(heaps[0] - heaps[2]).max(), 1e-3)

    def test_a_recording_is_verified(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "run.h5")
            world = lockstep.World.load("slide_to_roll")
            world.record(path)
            world.step(20)
            world.apply_impulse(world.bodies[-1], [0.1, 0, 0.2])
            world.step(20)
            world.end_recording()
            subprocess.run([PROGRAM, "verify", path, "--device", "reference", "--quiet"], check=True)

    def test_an_oracle_steps_a_world(self):
        solvers = lockstep.solvers()
        self.assertIn("gauss_seidel", solvers)
        self.assertIn("proximal point", solvers["proximal_point"]["what"])
        with tempfile.TemporaryDirectory() as folder:
            path, report = os.path.join(folder, "run.h5"), os.path.join(folder, "report.json")
            for name, solver in (("rag_doll", "mixed_ldlt"), ("chain64", "reduced_auto")):
                world = lockstep.World.load(name, solver=solver)
                world.record(path)
                world.step(10)
                world.end_recording()
                self.assertEqual(world.device.name, "reference")
                self.assertFalse(world.unsolved)
                subprocess.run(
                    [PROGRAM, "run", name, "--solver", solver, "--steps", "10", "--quiet", "--report", report], check=True
                )
                with open(report) as file:
                    self.assertEqual(json.load(file)["state_hash"], world.state_hash())
                subprocess.run([PROGRAM, "verify", path, "--quiet"], check=True)

    def test_an_oracle_may_stand_in_the_settings(self):
        settings = {"solver": "nsgs", "iterations": 1, "tolerance": 1e-14}
        boxes = [{"position": [0, 0, z], "mass": 1, "shapes": [{"type": "box", "size": [1, 1, 1]}]} for z in (0.5, 1.5)]
        world = lockstep.World(scene(GROUND, *boxes, settings=settings))
        world.step(3)
        self.assertEqual(world.unsolved.tolerance, 1e-14)
        self.assertGreater(world.unsolved.count, 0)
        self.assertTrue(world.unsolved)
        self.assertEqual(world.unsolved.worst_stop, "limit")
        self.assertEqual(world.unsolved.first_stop, "limit")
        self.assertEqual(world.unsolved.ended["limit"], world.unsolved.count)
        self.assertEqual(set(world.unsolved.ended), {"limit", "stalled", "infeasible", "bad"})
        with self.assertRaises(lockstep.Error):
            lockstep.World(scene(GROUND, settings=settings), precision="float")
        with self.assertRaises(lockstep.Error):
            lockstep.World(scene(GROUND), solver="magic")


    def test_a_step_that_failed_counts_once(self):
        ball = {"position": [0, 0, 3], "mass": 1, "shapes": [{"type": "sphere", "radius": 0.5}]}
        world = lockstep.World(scene(GROUND, ball), device="reference", precision="double")
        world.step(1)
        world.set_velocity(world.bodies[1], [1e200, 0, 0], [0, 0, 0])
        for _ in range(4):
            with self.assertRaises(lockstep.Error):
                world.step()
        self.assertEqual(world.steps_done, 1)
        self.assertEqual(world.unsolved.ended["bad"], 1)
        self.assertEqual(world.unsolved.count, 1)


class ClosedForms(unittest.TestCase):
    def test_a_ball_falls(self):
        world = lockstep.World(
            scene({**BALL, "position": [1, 2, 30], "velocity": [3, 0, 0]}, settings={"dt": 0.01, "integrator": "trapezoidal"}),
            device="reference",
            precision="double",
        )
        world.step(100)
        self.assertEqual(world.steps_done, 100)
        self.assertAlmostEqual(world.time, 1)
        x, v = world.poses()[0], world.velocities()[0]
        np.testing.assert_allclose(x, [4, 2, 30 - 9.81 / 2, 0, 0, 0, 1], atol=1e-12)
        np.testing.assert_allclose(v, [3, 0, -9.81, 0, 0, 0], atol=1e-12)

    def test_energy_and_momentum_are_told(self):
        world = lockstep.World(
            scene({**BALL, "velocity": [3, 0, 0], "angular_velocity": [0, 0, 5]}, gravity=[0, 0, 0]), precision="double"
        )
        errors = world.errors()
        moment = world.inertia(world.bodies[0])[2]
        self.assertAlmostEqual(moment, 0.4 * 2 * 0.5**2)
        self.assertAlmostEqual(errors.kinetic, 0.5 * 2 * 9 + 0.5 * moment * 25)
        np.testing.assert_allclose(errors.momentum, [6, 0, 0])
        np.testing.assert_allclose(errors.angular_momentum, [0, 0, 5 * moment])
        self.assertIsNone(errors.residual)
        self.assertIsNone(errors.joint_separation)

    def test_the_ground_carries_a_box(self):
        box = {"mass": 3, "position": [0, 0, 0.5], "shapes": [{"type": "box", "size": [1, 1, 1]}]}
        world = lockstep.World(scene(GROUND, box, settings={"dt": 0.01}), precision="double")
        world.step(50)
        contacts = world.contacts()
        self.assertEqual(len(contacts), 4)
        ground = world.body("ground")
        on_ground = np.where((contacts["a"] == ground.id)[:, None], contacts["impulse"], -contacts["impulse"])
        np.testing.assert_allclose(on_ground.sum(axis=0), [0, 0, -3 * 9.81 * 0.01], atol=1e-9)
        np.testing.assert_allclose(world.contact_force(ground), [0, 0, -3 * 9.81], atol=1e-7)
        np.testing.assert_allclose(world.contact_force(world.bodies[1], 0), [0, 0, 3 * 9.81], atol=1e-7)
        np.testing.assert_allclose(np.abs(contacts["normal"][:, 2]), 1)
        errors = world.errors()
        self.assertEqual(errors.contacts, 4)
        self.assertLess(errors.residual, 1e-6)
        self.assertLess(errors.max_penetration, 1e-3)

    def test_a_crate_on_four_feet_stands_on_each_by_a_quarter(self):
        """Its centre of mass 0.1 m beside the middle: n_i = N / 4 (1 +- 0.2)."""
        for offset in (0, 0.1):
            box = {"type": "box", "size": [1, 1, 1], "offset": [-offset, 0, 0]}
            crate = {"mass": 3, "inertia": [1, 1, 1], "position": [0, 0, 0.5], "shapes": [box]}
            sensors = [
                {"name": "scale", "kind": "touch", "body": "ground"},
                {"name": "load", "kind": "force", "body": "ground"},
            ]
            world = lockstep.World(scene(GROUND, crate, sensors=sensors, settings={"dt": 0.01}), precision="double")
            world.step(100)
            told, shared = world.contacts(), world.least_norm_contacts()
            self.assertEqual(shared.dtype, told.dtype)
            np.testing.assert_allclose(shared["impulse"].sum(axis=0), told["impulse"].sum(axis=0), atol=1e-9)
            normal = np.abs(shared["impulse"][:, 2])
            side = np.sign(shared["point"][:, 0] - world.pose(world.bodies[1])[0])
            np.testing.assert_allclose(normal, normal.sum() / 4 * (1 + 2 * offset * side), rtol=1e-3)
            self.assertTrue((np.abs(shared["gap"]) < 1e-3).all())
            scale, load = world.sensor("scale"), world.sensors()[1]
            self.assertEqual((scale.name, scale.kind, load.kind), ("scale", "touch", "force"))
            np.testing.assert_allclose(scale.values, [3 * 9.81], rtol=1e-6)
            np.testing.assert_allclose(load.values, [0, 0, -3 * 9.81], atol=1e-4)
        with self.assertRaisesRegex(lockstep.Error, 'sensor "scal": is not in this world; did you mean "scale"'):
            world.sensor("scal")

    def test_forces_are_of_the_whole_step_unless_asked_otherwise(self):
        box = {"mass": 3, "position": [0, 0, 0.5], "shapes": [{"type": "box", "size": [1, 1, 1]}]}
        for forces, parts in (("auto", 1), ("step", 1), ("substep", 5)):
            settings = {"dt": 0.01, "solver": "small_steps", "forces": forces}
            world = lockstep.World(scene(GROUND, box, settings=settings), precision="double", device="reference")
            self.assertEqual((world.substeps, world.substep_length), (5, 0.01 / 5))
            world.step(100)
            impulse = np.abs(world.contacts()["impulse"].sum(axis=0))[2]
            self.assertAlmostEqual(impulse, 3 * 9.81 * 0.01 / parts, delta=1e-4)
            self.assertAlmostEqual(world.contact_force(world.bodies[1])[2], 3 * 9.81, delta=0.01)

    def test_loads_accelerate(self):
        """v = integral of F / m; a function, a table, and what is applied step by step."""
        free = {"gravity": [0, 0, 0], "settings": {"dt": 0.01}}
        world = lockstep.World(scene(BALL, {**BALL, "position": [9, 0, 0]}, {**BALL, "position": [0, 9, 0]}, **free), precision="double")
        by_function, by_table, by_step = world.bodies
        world.set_load(by_function, lambda time: [4 * time, 0, 0, 0, 0, 1])
        world.set_load_table(by_table, [0, 1], [[0, 0, 0, 0, 0, 0], [4, 0, 0, 0, 0, 0]])
        for _ in range(100):
            world.apply_force(by_step, [2, 0, 0])
            world.apply_torque(by_step, [0, 0, 1])
            world.step()
        inertia = 0.4 * 2 * 0.5**2
        np.testing.assert_allclose(world.velocity(by_function), [1, 0, 0, 0, 0, 1 / inertia], rtol=1e-12)
        np.testing.assert_allclose(world.velocity(by_table), [1, 0, 0, 0, 0, 0], rtol=1e-12)
        np.testing.assert_allclose(world.velocity(by_step), [1, 0, 0, 0, 0, 1 / inertia], rtol=1e-12)
        world.set_load(by_function, None)
        world.step(10)
        np.testing.assert_allclose(world.velocity(by_function)[0], 1, rtol=1e-12)
        world.apply_impulse(by_function, [0, 2, 0])
        world.apply_impulse(by_table, [0, 2, 0], world.pose(by_table)[:3] + [0.5, 0, 0])
        self.assertAlmostEqual(world.velocity(by_function)[1], 1)
        self.assertAlmostEqual(world.velocity(by_table)[5], 0.5 * 2 / inertia)

    def test_a_kinematic_body_goes_where_it_is_told(self):
        lift = {"name": "lift", "type": "kinematic", "shapes": [{"type": "box", "size": [1, 1, 0.1]}]}
        world = lockstep.World(scene({**BALL, "position": [0, 0, 5]}, lift))
        rotated = [0, 0, np.sin(0.1), np.cos(0.1)]
        world.set_kinematic_target(world.body("lift"), [0, 0, 0.01], rotated)
        world.step()
        np.testing.assert_allclose(world.pose(world.body("lift")), [0, 0, 0.01, *rotated], atol=1e-6)
        world.step()
        np.testing.assert_allclose(world.velocity(world.body("lift")), np.zeros(6), atol=1e-12)
        self.assertEqual(world.kind(world.body("lift")), "kinematic")

    def test_a_motor_drives_a_wheel(self):
        wheel = {"name": "wheel", "mass": 1, "inertia": [1, 1, 2]}
        hinge = {"name": "axle", "type": "hinge", "bodies": ["world", "wheel"], "anchor": [0, 0, 0], "axis": [0, 0, 1]}
        world = lockstep.World(scene(wheel, joints=[hinge], settings={"dt": 0.01}), precision="double")
        axle = world.joint("axle")
        world.set_motor(axle, 3, 4)  # 4 N m on 2 kg m^2: 2 rad/s^2
        world.step(100)
        state = world.joint_state(axle)
        self.assertAlmostEqual(state.speed, 2)
        self.assertAlmostEqual(state.drive, 4)
        np.testing.assert_allclose(state.force, [0, 0, 9.81], atol=1e-9)
        world.step(100)
        self.assertAlmostEqual(world.joint_state(axle).speed, 3)
        self.assertLess(world.errors().joint_separation, 1e-9)
        self.assertEqual((world.name(axle), world.kind(axle)), ("axle", "hinge"))


class Questions(unittest.TestCase):
    def setUp(self):
        self.world = lockstep.World(scene(GROUND, {**BALL, "name": "ball", "position": [0, 0, 3]}))

    def test_rays(self):
        hit = self.world.cast_ray([0, 0, 10], [0, 0, -2])
        self.assertEqual(hit.body, self.world.body("ball"))
        self.assertAlmostEqual(hit.distance, 6.5, places=5)
        np.testing.assert_allclose(hit.point, [0, 0, 3.5], atol=1e-5)
        np.testing.assert_allclose(hit.normal, [0, 0, 1], atol=1e-5)
        self.assertIsNone(self.world.cast_ray([0, 0, 10], [0, 0, 1]))
        hits = self.world.cast_rays([[0, 0, 10], [5, 0, 10], [0, 0, 10]], [[0, 0, -1], [0, 0, -1], [0, 0, 1]])
        self.assertEqual(hits["hit"].tolist(), [True, True, False])
        self.assertEqual(hits["body"][:2].tolist(), [self.world.body("ball").id, self.world.body("ground").id])
        np.testing.assert_allclose(hits["distance"], [6.5, 10, np.inf], rtol=1e-6)

    def test_impacts(self):
        settings = {"impact_speed": 1, "dt": 0.001}
        bouncing = [{"name": "rubber", "restitution": 0.5}]
        document = scene(GROUND, {**BALL, "position": [0, 0, 1.5]}, settings=settings, materials=bouncing)
        world = lockstep.World(document, device="reference", precision="double")
        hits = []
        for _ in range(600):
            world.step()
            hits += [event for event in world.events() if event.kind == "impact"]
        (hit,) = hits
        self.assertAlmostEqual(hit.impact.speed, np.sqrt(2 * 9.81), delta=0.02)
        np.testing.assert_allclose(hit.impact.impulse, [0, 0, 1.5 * 2 * hit.impact.speed], atol=0.05)
        np.testing.assert_allclose(hit.impact.normal, [0, 0, 1])
        np.testing.assert_allclose(hit.impact.point, [0, 0, 0], atol=0.01)

    def test_triangles(self):
        grid = {"type": "height_field", "spacing": 1, "heights": [[0, 0], [0, 0]]}
        box = {"type": "box", "size": [1, 1, 1], "offset": [5, 0, -0.5]}
        pebble = {"mass": 1, "position": [0.2, -0.3, 0.05], "shapes": [{"type": "sphere", "radius": 0.05}]}
        world = lockstep.World(scene({"type": "static", "shapes": [box, grid]}, pebble), device="reference")
        world.step()
        (contact,) = world.contacts()
        ground = "a" if contact["a"] == 0 else "b"
        other = "ba"["ab".index(ground)]
        self.assertEqual((contact["shape_" + ground], contact["triangle_" + ground]), (1, 0))
        self.assertEqual((contact["shape_" + other], contact["triangle_" + other]), (0, -1))
        hit = world.cast_ray([-0.2, 0.3, 3], [0, 0, -1])
        self.assertEqual((hit.shape, hit.triangle), (1, 1))
        self.assertIsNone(world.cast_ray([5, 0, 3], [0, 0, -1]).triangle)
        hits = world.cast_rays([[-0.2, 0.3, 3], [5, 0, 3], [9, 9, 9]], [[0, 0, -1]] * 3)
        self.assertEqual(hits["triangle"].tolist(), [1, -1, -1])
        self.assertEqual(hits["shape"][:2].tolist(), [1, 0])

    def test_volumes(self):
        ball, ground = self.world.body("ball"), self.world.body("ground")
        self.assertEqual(self.world.overlapping_sphere([0, 0, 3], 1), [ball])
        self.assertEqual(self.world.overlapping_box([0, 0, 1.5], [1, 1, 2]), [ground, ball])
        self.assertEqual(self.world.overlapping_sphere([9, 9, 9], 1), [])

    def test_events(self):
        world = lockstep.World(scene(GROUND, {**BALL, "position": [0, 0, 0.6]}, settings={"events": True}))
        kinds, shapes = [], []
        for _ in range(60):
            world.step()
            kinds += [(event.kind, {event.a.id, event.b.id}) for event in world.events()]
            shapes = [(event.shape_a, event.shape_b, event.triangle_a) for event in world.events()] or shapes
        self.assertEqual(kinds, [("begin", {0, 1})])
        self.assertEqual(shapes, [(0, 0, None)])
        world.remove(world.bodies[1])
        world.step()
        self.assertEqual([event.kind for event in world.events()], ["end"])

    def test_arrays(self):
        poses, velocities = self.world.poses(), self.world.velocities()
        self.assertEqual((poses.shape, poses.dtype), ((2, 7), np.float64))
        self.assertEqual(velocities.shape, (2, 6))
        before = poses.copy()
        self.world.step(10)
        np.testing.assert_array_equal(poses, before, "what was given does not change")
        self.assertIs(self.world.poses(out=poses), poses)
        self.assertLess(poses[1, 2], before[1, 2])
        np.testing.assert_array_equal(self.world.pose(self.world.body("ball")), poses[1])
        for wrong in (np.zeros((3, 7)), np.zeros((2, 14))[:, ::2]):
            with self.assertRaisesRegex(lockstep.Error, r"out: must be a writeable array of shape \(2, 7\)"):
                self.world.poses(out=wrong)
        with self.assertRaises(TypeError):
            self.world.poses(out=np.zeros((2, 7), np.float32))


class ComeAndGo(unittest.TestCase):
    def test_bodies(self):
        materials = [{"name": "ice", "friction": 0}]
        world = lockstep.World(scene(GROUND, BALL, materials=materials))
        old = world.bodies
        world.step()
        new = world.add_body({**BALL, "name": "new", "position": [5, 0, 1], "shapes": [{"type": "sphere", "radius": 0.2, "material": "ice"}]})
        self.assertEqual(world.bodies, old + [new])
        self.assertEqual(len({*old, new, new}), 3)
        self.assertEqual((world.name(new), world.mass(new)), ("new", 2))
        world.step()
        world.remove(old[1])
        self.assertFalse(world.contains(old[1]))
        self.assertEqual(world.bodies, [old[0], new])
        self.assertEqual(world.poses().shape, (2, 7))
        with self.assertRaisesRegex(lockstep.Error, "body with the handle 1: is not in this world any more"):
            world.pose(old[1])
        with self.assertWarns(DeprecationWarning):
            world.place(new, [0, 0, 9], velocity=[0, 0, 1])
        world.teleport(new, [0, 0, 9], velocity=[0, 0, 1])
        np.testing.assert_allclose(world.pose(new), [0, 0, 9, 0, 0, 0, 1])
        np.testing.assert_allclose(world.velocity(new), [0, 0, 1, 0, 0, 0])
        world.set_velocity(new, [1, 0, 0], [0, 0, 2])
        np.testing.assert_allclose(world.velocity(new), [1, 0, 0, 0, 0, 2])

    def test_what_rests_sleeps_until_it_is_woken(self):
        document = scene(GROUND, {**BALL, "position": [0, 0, 0.5]})
        document["settings"] = {**document.get("settings", {}), "sleeping": {"after": 0.1}}
        world = lockstep.World(document)
        ball = world.bodies[1]
        world.step(60)
        self.assertTrue(world.is_asleep(ball))
        np.testing.assert_array_equal(world.velocity(ball), np.zeros(6))
        world.wake(ball)
        world.step()
        self.assertFalse(world.is_asleep(ball))

    def test_categories_are_those_of_the_scene(self):
        ghost = {"type": "sphere", "radius": 0.5, "category": "ghost", "collides_with": ["ghost"]}
        world = lockstep.World(scene(GROUND, {**BALL, "shapes": [ghost], "position": [0, 0, 4]}))
        fallen = world.add_body({**BALL, "shapes": [ghost], "position": [3, 0, 0.5]})
        world.step(60)
        self.assertLess(world.pose(fallen)[2], -2, "ghosts fall through the ground")

    def test_joints(self):
        world = lockstep.World(scene(BALL, {**BALL, "position": [2, 0, 0]}, gravity=[0, 0, 0]))
        a, b = world.bodies
        rod = world.add_joint({"type": "ball", "anchor": [1, 0, 0]}, a, b)
        fixed = world.add_joint({"type": "fixed", "name": "fixed", "anchor": [0, 0, 0]}, a)
        self.assertEqual(world.joints, [rod, fixed])
        world.step(10)
        self.assertLess(world.errors().joint_separation, 1e-5)
        world.remove(rod)
        self.assertFalse(world.contains(rod))
        self.assertEqual(world.joints, [world.joint("fixed")])


class Loads(unittest.TestCase):
    def test_what_a_load_raises_step_raises(self):
        world = lockstep.World(scene(BALL))
        ball = world.bodies[0]

        def fail(time):
            raise RuntimeError("not today")

        world.set_load(ball, fail)
        with self.assertRaisesRegex(RuntimeError, "not today"):
            world.step()
        world.set_load(ball, lambda time: [1, 2])
        with self.assertRaisesRegex(lockstep.Error, "load: must give six numbers"):
            world.step()
        world.set_load(ball, lambda time: [world.time, 0, 0, 0, 0, 0])
        with self.assertRaisesRegex(lockstep.Error, "is being stepped"):
            world.step()
        world.set_load(ball, None)
        world.step()
        self.assertEqual(world.steps_done, 1)

    def test_a_load_is_let_go_of(self):
        class Load:
            def __call__(self, time):
                return [0] * 6

        gone = threading.Event()
        load = Load()
        import weakref

        weakref.finalize(load, gone.set)
        world = lockstep.World(scene(BALL))
        world.set_load(world.bodies[0], load)
        world.step()
        del load, world
        gc.collect()
        self.assertTrue(gone.is_set())

    def test_other_threads_run_during_a_step(self):
        world = lockstep.World(scene(BALL, gravity=[0, 0, 0]))
        answers = []
        asked = threading.Event()

        def ask():
            try:
                world.poses()
                answers.append("poses")
            except lockstep.Error as error:
                answers.append(str(error))
            asked.set()

        def load(time):
            if not answers:
                threading.Thread(target=ask).start()
                self.assertTrue(asked.wait(60), "the other thread never ran")
            return [0] * 6

        world.set_load(world.bodies[0], load)
        world.step()
        self.assertEqual(answers, ["world: is being stepped; ask and act between two steps"])


if __name__ == "__main__":
    unittest.main()
