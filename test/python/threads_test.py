#!/usr/bin/env python3
"""The global lock, use from several threads, forked processes, lifetimes and memory."""
import gc
import multiprocessing
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import mesh_scenes
import numpy
from deformable_contact import Detector, Scene, StateChecker, read_mesh

TICKS = 20


def small_scene(rng):
    scene = Scene()
    for name in "ab":
        scene.add_body(name, *mesh_scenes.soup(rng, 12))
    scene.set_pair_enabled(0, 1)
    return scene


def long_scene():
    """Of 9 million candidate pairs: on one thread, more than LongDetection gives it."""
    rng = numpy.random.default_rng(3)
    scene = Scene()
    for name in "ab":
        vertices = rng.uniform(0, 1, (9000, 3)).astype(numpy.float32)
        scene.add_body(name, vertices, numpy.arange(9000).reshape(-1, 3))
    scene.set_pair_enabled(0, 1)
    return scene


class LongDetection:
    """A detection in another thread, while the context lasts."""

    def __init__(self, scene, detector):
        self._begins = threading.Event()
        self.result = None
        self.ended = None

        def run():
            self._begins.set()
            self.result = detector.detect(scene, max_time_s=2)
            self.ended = time.monotonic()

        self._thread = threading.Thread(target=run)

    def __enter__(self):
        self._thread.start()
        self._begins.wait()
        time.sleep(0.02)
        return self

    def __exit__(self, *_):
        self._thread.join()


class Threads(unittest.TestCase):

    def test_others_run_while_it_detects(self):
        ticks = []
        with LongDetection(long_scene(), Detector("cpu", threads=1)) as detection:
            while len(ticks) < TICKS:
                time.sleep(0.001)
                ticks.append(time.monotonic())
        self.assertGreater(detection.ended, ticks[-1])

    def test_what_another_thread_uses_is_refused(self):
        scene, detector = long_scene(), Detector("cpu", threads=1)
        other_scene = small_scene(numpy.random.default_rng(1))
        with LongDetection(scene, detector) as detection:
            changing = "the scene cannot change while detect\\(\\) looks at it in another thread"
            for change in (lambda: scene.set_margin(0, 1), lambda: scene.set_pair_enabled(0, 0),
                           lambda: scene.set_vertices(0, numpy.zeros((9000, 3))),
                           lambda: scene.set_mesh(0, numpy.zeros((3, 3)), [[0, 1, 2]]),
                           lambda: scene.set_pose(0, numpy.eye(3), [0, 0, 1]),
                           lambda: scene.add_body("c", numpy.zeros((3, 3)), [[0, 1, 2]])):
                with self.assertRaisesRegex(RuntimeError, changing):
                    change()
            busy = "the detector is in use by another thread's detect\\(\\)"
            with self.assertRaisesRegex(RuntimeError, busy):
                detector.detect(other_scene)
            with self.assertRaisesRegex(RuntimeError, busy):
                detector.reset()
            # To look is allowed, and so is another detector.
            self.assertEqual((scene.body_count, detector.backend), (2, "cpu"))
            self.assertTrue(Detector("cpu").detect(scene, max_time_s=0).cut_off)
            with self.assertRaisesRegex(RuntimeError, changing):
                scene.set_margin(0, 1)
            self.assertIsNone(detection.ended)
        self.assertGreater(len(detection.result.pairs), 0)
        scene.set_margin(0, 0)
        detector.reset()
        self.assertTrue(detector.detect(other_scene).complete)

    def test_a_checker_that_is_taken_while_poses_are_read_is_refused(self):
        scene, checker = long_scene(), StateChecker("cpu", threads=1)
        poses = numpy.tile(numpy.eye(4), (1, 1, 1, 1))
        many = numpy.tile(numpy.eye(4), (2000, 1, 1, 1))
        other = threading.Thread(
            target=lambda: checker.check(scene, [1], many, pairs=True, nearest=True, max_time_s=2))

        class Late:
            def __array__(self, *_arguments, **_options):
                other.start()
                while True:
                    try:
                        checker.reset()
                        time.sleep(0.001)
                    except RuntimeError:
                        return poses

        with self.assertRaisesRegex(RuntimeError, "in use by another thread"):
            checker.check(scene, [1], Late())
        other.join()
        self.assertEqual(len(checker.check(scene, [1], poses)), 1)

    def test_a_refusal_leaves_both_usable(self):
        scene, detector = small_scene(numpy.random.default_rng(2)), Detector()
        with self.assertRaises(ValueError):
            detector.detect(scene, max_time_s=-1)
        with self.assertRaises(TypeError):
            detector.detect(None)
        scene.set_margin(0, 1)
        self.assertTrue(detector.detect(scene).complete)


def in_child(work):
    """Runs work() in a forked process. Returns its exit code; -SIGALRM where it hung."""
    child = os.fork()
    if child == 0:
        code = 1
        try:
            signal.alarm(60)
            code = 0 if work() else 2
        finally:
            os._exit(code)
    status = os.waitpid(child, 0)[1]
    return -os.WTERMSIG(status) if os.WIFSIGNALED(status) else os.WEXITSTATUS(status)


def pairs_of(seed):
    """As a worker of multiprocessing: a scene and a detector of its own."""
    scene = small_scene(numpy.random.default_rng(seed))
    scene.set_margin(0, 0.2)
    detectors = Detector("cpu"), Detector(tolerance_m=0.01)
    return len(detectors[0].detect(scene).pairs), len(detectors[1].detect(scene).distances)


class Forks(unittest.TestCase):
    """Threads of the parent are not there in a child, and nothing waits for them."""

    def setUp(self):
        self.scene = small_scene(numpy.random.default_rng(6))
        self.scene.set_margin(0, 0.5)
        self.exact = Detector("cpu")
        self.pairs = self.exact.detect(self.scene).pairs.tolist()
        self.assertGreater(len(self.pairs), 0)
        self.bounded = Detector("cpu", tolerance_m=0.01)
        self.assertEqual(len(self.bounded.detect(self.scene).distances), 1)

    def test_a_child_drops_what_the_parent_made(self):
        def drop():
            del self.exact, self.bounded, self.scene
            return gc.collect() >= 0

        self.assertEqual(in_child(drop), 0)
        self.assertEqual(self.exact.detect(self.scene).pairs.tolist(), self.pairs)

    def test_a_child_detects(self):
        def detect():
            self.exact.reset()
            return (self.exact.detect(self.scene).pairs.tolist() == self.pairs
                    and len(self.bounded.detect(self.scene).distances) == 1
                    and Detector("cpu").detect(self.scene).pairs.tolist() == self.pairs
                    and len(Detector(tolerance_m=0.01).detect(self.scene).distances) == 1
                    and in_child(lambda: pairs_of(1)[1] == 1) == 0)

        self.assertEqual(in_child(detect), 0)

    def test_workers_of_a_pool_detect(self):
        expected = [pairs_of(seed) for seed in range(6)]
        with multiprocessing.get_context("fork").Pool(2) as pool:
            self.assertEqual(pool.map_async(pairs_of, range(6)).get(timeout=60), expected)

    def test_a_child_ends_by_itself(self):
        """With what Python and the libraries do at the end of a program."""
        code = ("import os, signal; from deformable_contact import Detector; import threads_test\n"
                "scene = threads_test.small_scene(threads_test.numpy.random.default_rng(1))\n"
                "detector = Detector('cpu', tolerance_m=0.01); detector.detect(scene)\n"
                "child = os.fork()\n"
                "if child == 0: signal.alarm(60)\n"
                "detector.detect(scene)\n"
                "if child: print(os.waitpid(child, 0)[1])\n")
        done = subprocess.run([sys.executable, "-c", code], check=True, stdout=subprocess.PIPE,
                              cwd=os.path.dirname(os.path.abspath(__file__)))
        self.assertEqual(done.stdout, b"0\n")

    def test_what_another_thread_used_at_the_fork_is_refused(self):
        scene, detector = long_scene(), Detector("cpu", threads=1, tolerance_m=0.01)

        def child():
            for call in (lambda: detector.detect(self.scene), detector.reset):
                try:
                    call()
                    return False
                except RuntimeError as error:
                    if "this process was forked" not in str(error):
                        return False
            scene.set_margin(0, 0.001)  # nobody looks at it here
            return pairs_of(1)[1] == 1 and detector.backend == "cpu"

        with LongDetection(scene, detector):
            code = in_child(child)  # 2 where the detection had ended before the fork
        self.assertEqual(code, 0)

    def test_a_child_of_another_thread_ends(self):
        codes = []
        thread = threading.Thread(target=lambda: codes.append(in_child(
            lambda: self.exact.detect(self.scene).pairs.tolist() == self.pairs)))
        thread.start()
        thread.join()
        self.assertEqual(codes, [0])


class TheEnd(unittest.TestCase):
    """Of an interpreter with daemon threads, like those of rospy, which go on until the process ends."""

    def end_with(self, code):
        folder = os.path.dirname(os.path.abspath(__file__))
        done = subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE, timeout=60,
                              stderr=subprocess.STDOUT, cwd=folder)
        self.assertEqual((done.returncode, done.stdout), (0, b""))

    def end_with_daemons(self, works):
        self.end_with("from threads_test import *\n"
                      "def for_ever(work):\n"
                      "    while True: work()\n"
                      "rng = numpy.random.default_rng(1)\n"
                      f"for work in {works}:\n"
                      "    threading.Thread(target=for_ever, args=[work], daemon=True).start()\n"
                      "time.sleep(0.3)\n"
                      "much = [[i] for i in range(3000000)]  # the end takes its time\n")

    def test_short_work_does_not_abort(self):
        self.end_with_daemons("[lambda s=small_scene(rng), d=Detector('cpu', threads=1): d.detect(s)"
                              " for i in range(3)]")

    def test_long_work_does_not_abort(self):
        self.end_with_daemons("[lambda s=long_scene(), d=Detector('cpu', threads=1): "
                              "d.detect(s, max_time_s=0.2)]")

    def test_states_do_not_abort(self):
        self.end_with_daemons("[lambda s=small_scene(rng), c=StateChecker('cpu', threads=1): "
                              "c.check(s, [1], numpy.tile(numpy.eye(4), (9, 1, 1, 1)))]")

    def test_functions_that_run_later_may_detect(self):
        self.end_with("import atexit\n"
                      "atexit.register(lambda: late())\n"
                      "from threads_test import *\n"
                      "def late(): assert Detector('cpu').detect(scene).complete\n"
                      "scene = small_scene(numpy.random.default_rng(1))\n")


class Lifetimes(unittest.TestCase):

    def test_results_outlive_detector_and_scene(self):
        rng = numpy.random.default_rng(4)
        scene, detector = small_scene(rng), Detector()
        scene.set_margin(0, 0.5)
        result = detector.detect(scene)
        pairs, separations = result.pairs, result.separations_m
        kept = pairs.copy(), separations.copy()
        self.assertGreater(len(pairs), 0)
        self.assertIs(pairs, result.pairs)
        for _ in range(20):
            scene.set_vertices(0, rng.uniform(0, 3, (24, 3)))
            detector.detect(scene)
        del scene, detector, result
        gc.collect()
        garbage = [numpy.full((len(pairs), 4), 7, numpy.uint32) for _ in range(50)]
        numpy.testing.assert_array_equal(pairs, kept[0])
        numpy.testing.assert_array_equal(separations, kept[1])
        self.assertTrue(pairs.flags.owndata and separations.flags.owndata)
        del garbage

    @unittest.skipUnless((mesh_scenes.DATA / "tshirt/000.obj").exists(), "no real mesh")
    def test_meshes_outlive_their_reader(self):
        path = mesh_scenes.DATA / "tshirt/000.obj"
        vertices = read_mesh(path)[0]
        kept = vertices.copy()
        for _ in range(10):
            read_mesh(path)
        gc.collect()
        numpy.testing.assert_array_equal(vertices, kept)


def resident_bytes():
    with open("/proc/self/status") as file:
        return next(1024 * int(line.split()[1]) for line in file if line.startswith("VmRSS"))


class Memory(unittest.TestCase):

    def test_is_flat_over_10_000_calls(self):
        rng = numpy.random.default_rng(5)
        scene, detector = small_scene(rng), Detector("cpu", threads=1)
        scene.set_margin(0, 0.1)
        vertices, triangles = mesh_scenes.soup(rng, 12)
        doubles = vertices.astype(float)
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = os.path.join(folder.name, "mesh.obj")
        mesh_scenes.write_obj(path, *mesh_scenes.soup(rng, 100))

        def call(number):
            scene.set_vertices(0, doubles if number % 2 else vertices)
            scene.set_pose(1, numpy.eye(3), rng.uniform(0, 1, 3))
            result = detector.detect(scene)
            self.assertEqual(len(result.pairs), len(result.separations_m))
            self.assertTrue(result.counters and result.stages_ms)
            if number % 10 == 0:
                scene.set_mesh(1, vertices, triangles.astype(int))
                with self.assertRaises(ValueError):
                    scene.set_vertices(0, [[1, 2]])
                Detector("cpu", threads=1)
                read_mesh(path)

        for number in range(1000):
            call(number)
        before = resident_bytes()
        for number in range(10000):
            call(number)
        self.assertLess(resident_bytes() - before, 1 << 20)


if __name__ == "__main__":
    unittest.main()
