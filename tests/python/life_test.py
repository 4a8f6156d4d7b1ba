"""How worlds live in a process: collected in cycles, closed at its end, forked, and given up by Ctrl-C."""
import gc
import os
import signal
import subprocess
import sys
import tempfile
import textwrap
import threading
import time
import unittest
import weakref

import lockstep

BALL = {"name": "ball", "mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]}
SCENE = {"gravity": [0, 0, 0], "bodies": [BALL]}
PROGRAM = os.environ.get("LOCKSTEP_PROGRAM", "lockstep")
PREAMBLE = """
import os, signal, sys, threading, time
import lockstep
BALL = {"name": "ball", "mass": 2, "shapes": [{"type": "sphere", "radius": 0.5}]}
SCENE = {"gravity": [0, 0, 0], "bodies": [BALL]}
GROUND = {"type": "static", "shapes": [{"type": "plane"}]}
def pile(n):
    return {"bodies": [GROUND] + [{**BALL, "name": str(i), "position": [1.1 * (i % 30), 1.1 * (i // 30 % 30), 0.5 + 1.01 * (i // 900)]}
                                  for i in range(n)]}
"""


def script(text, folder, timeout=120):
    """Runs a script in a process of its own: its status and what it writes."""
    done = subprocess.run([sys.executable, "-c", PREAMBLE + textwrap.dedent(text)], cwd=folder, text=True, timeout=timeout,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE)
    return done.returncode, done.stdout, done.stderr


class Cycles(unittest.TestCase):
    def is_freed(self, make):
        """Whether what make() gives is gone after a collection, and not before."""
        gc.collect()
        gc.disable()
        try:
            watched = weakref.ref(make())
            self.assertIsNotNone(watched(), "no cycle: the test is of nothing")
            gc.collect()
            return watched() is None
        finally:
            gc.enable()

    def test_a_load_that_refers_to_its_world_is_freed_with_it(self):
        def make():
            world = lockstep.World(SCENE, device="reference")
            world.set_load(world.bodies[0], lambda t: [world.mass(world.bodies[0]) if t < 0 else 1, 0, 0, 0, 0, 0])
            world.step(2)
            return world

        self.assertTrue(self.is_freed(make))

    def test_so_it_is_by_the_globals_of_its_module(self):
        def make():
            names = {}
            exec("def load(t): return [1, 0, 0, 0, 0, 0] if world else None", names)
            names["world"] = world = lockstep.World(SCENE, device="reference")
            world.set_load(world.bodies[0], names["load"])
            return world

        self.assertTrue(self.is_freed(make))

    def test_so_it_is_by_an_object_of_a_class_of_its_own(self):
        class Robot(lockstep.World):
            def push(self, t):
                return [1, 0, 0, 0, 0, 0]

        def make():
            world = Robot(SCENE, device="reference")
            world.set_load(world.bodies[0], world.push)
            world.step()
            return world

        self.assertTrue(self.is_freed(make))

    def test_so_are_snapshots(self):
        def make():
            class Keeper:
                pass

            world = lockstep.World(SCENE, device="reference")
            keeper = Keeper()
            world.set_load(world.bodies[0], lambda t: [1 if keeper else 0, 0, 0, 0, 0, 0])
            keeper.snapshot = world.save()
            return keeper

        self.assertTrue(self.is_freed(make))

    def test_a_load_that_somebody_else_has_too_stays(self):
        world = lockstep.World(SCENE, device="reference")
        first = world.save()
        state = {"n": 0}

        def load(t):
            state["n"] += 1
            return [1, 0, 0, 0, 0, 0]

        world.set_load(world.bodies[0], load)
        saved = world.save()
        world.restore(first)
        watched = weakref.ref(load)
        del load
        gc.collect()
        self.assertIsNotNone(watched())
        world.restore(saved)
        world.step(3)
        self.assertEqual(state["n"], 3)
        del world, saved, first
        gc.collect()
        self.assertIsNone(watched())

    def test_memory_stays_level(self):
        def resident():
            with open("/proc/self/statm") as file:
                return int(file.read().split()[1]) * os.sysconf("SC_PAGE_SIZE") / 2**20

        scene = {"bodies": [{**BALL, "name": str(i), "position": [2 * i, 0, 0]} for i in range(500)]}

        def worlds(n):
            for k in range(n):
                world = lockstep.World(scene, device="reference")
                world.set_load(world.bodies[0], lambda t, world=world: [1, 0, 0, 0, 0, 0])
                world.step()
                if k % 10 == 9:
                    gc.collect()

        worlds(100)
        before = resident()
        worlds(100)
        self.assertLess(resident() - before, 30, "MB")


class Ends(unittest.TestCase):
    def steps_in(self, folder, name="r.h5"):
        done = subprocess.run([PROGRAM, "verify", name], cwd=folder, text=True, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.assertEqual(done.returncode, 0, done.stdout)
        return done.stdout

    def test_a_world_that_is_alive_at_the_end_ends_its_recording(self):
        texts = {
            "a global": "world = lockstep.World(SCENE, device='reference'); world.record('r.h5'); world.step(70)",
            "a cycle": """
                world = lockstep.World(SCENE, device='reference')
                world.set_load(world.bodies[0], lambda t: [1 if world else 0, 0, 0, 0, 0, 0])
                world.record('r.h5'); world.step(70)""",
            "in a module": """
                sys.kept = lockstep.World(SCENE, device='reference'); sys.kept.record('r.h5'); sys.kept.step(70)""",
            "an exception": """
                world = lockstep.World(SCENE, device='reference'); world.record('r.h5'); world.step(70)
                sys.exit(0)""",
        }
        for what, text in texts.items():
            with self.subTest(what), tempfile.TemporaryDirectory() as folder:
                status, out, error = script(text, folder)
                self.assertEqual((status, error), (0, ""), out)
                self.assertIn("70", self.steps_in(folder))

    def test_a_daemon_thread_that_steps(self):
        for device in ("reference", "auto"):
            with self.subTest(device), tempfile.TemporaryDirectory() as folder:
                status, out, error = script(
                    f"""
                    world = lockstep.World(pile(200), device={device!r})
                    world.record('r.h5')
                    def run():
                        while True:
                            world.step(7)
                    threading.Thread(target=run, daemon=True).start()
                    while world_steps() < 3: time.sleep(0.01)
                    print('ends')
                    """.replace("while world_steps() < 3: time.sleep(0.01)", "time.sleep(1)"), folder)
                self.assertEqual((status, out, error), (0, "ends\n", ""))
                self.steps_in(folder)

    def test_a_daemon_thread_with_a_load(self):
        with tempfile.TemporaryDirectory() as folder:
            status, out, error = script(
                """
                world = lockstep.World(SCENE, device='reference')
                world.set_load(world.bodies[0], lambda t: [1, 0, 0, 0, 0, 0])
                def run():
                    while True:
                        world.step(1000)
                threading.Thread(target=run, daemon=True).start()
                time.sleep(0.3)
                print('ends')
                """, folder)
            self.assertEqual((status, out, error), (0, "ends\n", ""))

    def test_a_daemon_thread_whose_load_never_ends(self):
        with tempfile.TemporaryDirectory() as folder:
            status, out, error = script(
                """
                world = lockstep.World(SCENE, device='reference')
                world.set_load(world.bodies[0], lambda t: time.sleep(1000))
                threading.Thread(target=world.step, daemon=True).start()
                time.sleep(0.3)
                print('ends')
                """, folder, timeout=30)
            self.assertEqual((status, out, error), (0, "ends\n", ""))

    def test_a_daemon_thread_that_makes_worlds(self):
        with tempfile.TemporaryDirectory() as folder:
            status, out, error = script(
                """
                def run():
                    while True:
                        lockstep.World(pile(100), device='reference').step()
                for _ in range(3): threading.Thread(target=run, daemon=True).start()
                time.sleep(0.5)
                print('ends')
                """, folder)
            self.assertEqual((status, out, error), (0, "ends\n", ""))


class Forks(unittest.TestCase):
    def test_a_world_made_before_fork_refuses_in_the_child(self):
        for device in ("reference", "auto"):
            with self.subTest(device), tempfile.TemporaryDirectory() as folder:
                status, out, error = script(
                    f"""
                    world = lockstep.World(pile(600), device={device!r})
                    world.record('r.h5')
                    world.step(3)
                    snapshot = world.save()
                    before = world.state_hash()
                    sys.stdout.flush()
                    child = os.fork()
                    if child == 0:
                        for call in (world.step, world.poses, world.state_hash, world.end_recording, world.save):
                            try:
                                call()
                                print('no error')
                            except lockstep.Error as error:
                                assert 'before fork()' in str(error) and '\\n' not in str(error), error
                        try:
                            fresh = lockstep.World(pile(600), device={device!r})
                            fresh.step(3)
                            assert fresh.state_hash() == before
                            print('fresh works')
                        except lockstep.Error as error:
                            assert 'before fork()' in str(error) and '\\n' not in str(error), error
                            print('fresh refuses')
                        fresh = lockstep.World(pile(600), device='reference')
                        fresh.step(3)
                        assert fresh.state_hash() == before
                        del world, snapshot
                        sys.exit(0)
                    _, status = os.waitpid(child, 0)
                    world.step(3)
                    world.restore(snapshot)
                    assert world.state_hash() == before
                    world.step(1)
                    print('parent', status)
                    """, folder)
                self.assertEqual((status, error), (0, ""))
                self.assertIn("parent 0\n", out)
                self.assertIn("fresh works" if device == "reference" else "fresh ", out)
                self.assertNotIn("no error", out)
                Ends.steps_in(self, folder)

    def test_multiprocessing_forks(self):
        with tempfile.TemporaryDirectory() as folder:
            status, out, error = script(
                """
                import multiprocessing
                def work(n):
                    world = lockstep.World(SCENE)
                    world.step(n)
                    return world.steps_done
                with multiprocessing.get_context('fork').Pool(2) as pool:
                    print(pool.map(work, [3, 4, 5]))
                """, folder)
            self.assertEqual((status, out, error), (0, "[3, 4, 5]\n", ""))


class CtrlC(unittest.TestCase):
    def heeds(self, call, most=0.2, after=0.3):
        """Ctrl-C ends the call within `most` s, the best of five: a machine at other work may be late. How often it was
        called."""
        for calls in range(1, 6):
            took = self.interrupted_after(call, after)
            if took < most:
                return calls
        self.fail(f"Ctrl-C was heeded after {took} s")

    def interrupted_after(self, call, after):
        before = signal.signal(signal.SIGINT, signal.default_int_handler)
        sent = []

        def send():
            sent.append(time.monotonic())
            os.kill(os.getpid(), signal.SIGINT)

        timer = threading.Timer(after, send)
        timer.start()
        try:
            with self.assertRaises(KeyboardInterrupt):
                call()
                time.sleep(after)  # too quick for the test to be of anything
                self.fail("the call ended by itself")
        finally:
            timer.cancel()
            signal.signal(signal.SIGINT, before)
        return time.monotonic() - sent[0]

    def pile(self, n):
        ground = {"type": "static", "shapes": [{"type": "plane"}]}
        return {"settings": {"substeps": 100}, "bodies": [ground] + [
            {**BALL, "name": str(i), "position": [1.1 * (i % 30), 1.1 * (i // 30 % 30), 0.5 + 1.01 * (i // 900)]} for i in range(n)]}

    def test_in_a_long_step(self):
        world = lockstep.World(self.pile(20000), device="reference")
        calls = self.heeds(lambda: world.step(1), after=0.6)
        # the step that had begun is made
        self.assertEqual(world.steps_done, calls)

    def test_in_many_short_steps(self):
        world = lockstep.World(SCENE, device="reference")
        world.step(10)
        self.heeds(lambda: world.step(4_000_000_000))
        done = world.steps_done
        self.assertGreater(done, 10)
        world.step()
        self.assertEqual(world.steps_done, done + 1)

    def test_while_a_world_is_made(self):
        scene = self.pile(30000)
        text = __import__("json").dumps(scene)
        self.heeds(lambda: lockstep.World(text, device="reference").step(1), after=0.1)

    def test_while_a_mesh_is_read(self):
        n = 300
        with tempfile.TemporaryDirectory() as folder:
            with open(os.path.join(folder, "large.obj"), "w") as file:
                for i in range(n):
                    for j in range(n):
                        file.write(f"v {i} {j} {(i * j) % 7}\n")
                for i in range(n - 1):
                    for j in range(n - 1):
                        a = i * n + j + 1
                        file.write(f"f {a} {a + n} {a + n + 1}\nf {a} {a + n + 1} {a + 1}\n")
            scene = {"bodies": [BALL, {"type": "static", "shapes": [{"type": "mesh", "mesh": "large.obj"}]}]}
            self.heeds(lambda: lockstep.World(scene, device="reference", source=os.path.join(folder, "s.json")), after=0.1)

    def test_in_questions(self):
        world = lockstep.World(self.pile(20000), device="reference")
        self.heeds(lambda: [world.step(1), world.least_norm_contacts(), world.errors()], after=0.5)

    def test_a_load_raises_as_before(self):
        world = lockstep.World(SCENE, device="reference")

        def load(t):
            raise ZeroDivisionError("of the load")

        world.set_load(world.bodies[0], load)
        with self.assertRaisesRegex(ZeroDivisionError, "of the load"):
            world.step()
        world.set_load(world.bodies[0], lambda t: world.poses())
        with self.assertRaisesRegex(lockstep.Error, "is being stepped"):
            world.step()
        world.set_load(world.bodies[0], None)
        world.step()


class Threads(unittest.TestCase):
    def counts_while(self, call):
        """How often another thread runs within the longest call, by its time."""
        count, stop = [0], threading.Event()

        def run():
            while not stop.is_set():
                count[0] += 1
                time.sleep(0.001)

        thread = threading.Thread(target=run)
        thread.start()
        time.sleep(0.05)
        before, begin = count[0], time.monotonic()
        try:
            call()
        finally:
            ran, took = count[0] - before, time.monotonic() - begin
            stop.set()
            thread.join()
        self.assertGreater(took, 0.1, "too quick for the test to be of anything")
        return ran / took

    def test_others_run_while_a_world_is_made_or_steps(self):
        scene = CtrlC.pile(self, 40000)
        text = __import__("json").dumps(scene)
        worlds = []
        self.assertGreater(self.counts_while(lambda: worlds.append(lockstep.World(text, device="reference"))), 20)
        self.assertGreater(self.counts_while(lambda: worlds[0].step(1)), 20)

    def test_other_threads_make_and_step_worlds(self):
        hashes = []

        def run():
            world = lockstep.World(SCENE, device="reference")
            world.set_load(world.bodies[0], lambda t: [1, 0, 0, 0, 0, 0])
            world.step(50)
            hashes.append(world.state_hash())

        threads = [threading.Thread(target=run) for _ in range(4)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        run()
        self.assertEqual(len(hashes), 5)
        self.assertEqual(len(set(hashes)), 1)


if __name__ == "__main__":
    unittest.main()
