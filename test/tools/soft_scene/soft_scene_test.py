#!/usr/bin/env python3
"""soft_scene as a command that writes bags: the same bag twice, the demo's motion, bad usage."""
import os
import pathlib
import resource
import signal
import subprocess
import tempfile
import unittest

import numpy as np
import rosbag

TOOL = os.environ["SOFT_SCENE"]
SOURCE = pathlib.Path(os.environ["DCM_SOURCE_DIR"])
ARM = str(SOURCE / "config/demo_arm.urdf")
MOTION = str(SOURCE / "config/demo_motion.yaml")
# Nobody starts a node by mistake.
ENVIRONMENT = dict(os.environ, ROS_MASTER_URI="http://localhost:1")


def contents(bag):
    """Topic, stamp of recording, and bytes of each message."""
    with rosbag.Bag(bag) as file:
        return [(topic, t, message[1]) for topic, message, t in file.read_messages(raw=True)]


class SoftSceneTest(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def run_tool(self, *words):
        return subprocess.run([TOOL, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              universal_newlines=True, env=ENVIRONMENT, check=False)

    def bag(self, name, *words):
        done = self.run_tool("--bag", self.path(name), *words)
        self.assertEqual(done.returncode, 0, done.stderr)
        return contents(self.path(name))

    def test_the_same_command_writes_the_same_bag(self):
        scenes = [
            ("cloth", "--robot", ARM, "--joints", "--offset", "0.25", "0", "1"),
            ("rope", "--robot", ARM, "--joints", "--offset", "0.25", "0", "1", "--radius", "0.02"),
            ("volume", "--floor", "-0.6", "--pinned", "none")]
        for scene in scenes:
            with self.subTest(scene[0]):
                words = ("--object", *scene, "--vertices", "100", "--seconds", "2")
                one = self.bag("one.bag", *words)
                self.assertTrue(one == self.bag("two.bag", *words))  # no diff of megabytes
                self.assertFalse(one == self.bag("other.bag", *words, "--seed", "2"))

    def test_what_is_told_does_not_need_a_master(self):
        """Mesh files are listed at the start; a cloth that falls is put back, and the log says so."""
        self.bag("fall.bag", "--object", "cloth", "--pinned", "none", "--vertices", "100",
                 "--seconds", "8")
        mesh = self.path("one.obj")
        with open(mesh, "w") as file:
            file.write("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
        self.assertTrue(self.bag("played.bag", "--meshes", mesh, mesh, "--seconds", "1"))

    def test_a_bag_that_does_not_fit_is_no_bag(self):
        def limit_files():  # as on a full disk, writing fails
            signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
            resource.setrlimit(resource.RLIMIT_FSIZE, (20000, 20000))

        for seconds in ("1", "20"):  # fails when the bag is closed, and before
            with self.subTest(seconds=seconds):
                words = ["--object", "cloth", "--vertices", "2000", "--seconds", seconds]
                done = subprocess.run([TOOL, "--bag", self.path("full.bag"), *words],
                                      stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                      universal_newlines=True, env=ENVIRONMENT, check=False,
                                      preexec_fn=limit_files)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertRegex(done.stderr, r"soft_scene: [^\n]+\n\Z")
                self.assertEqual(os.listdir(self.folder.name), [])

    def test_the_demos_arm_lifts_the_cloth(self):
        self.bag("demo.bag", "--object", "cloth", "--vertices", "225", "--scale", "0.6", "--offset",
                 "1.05", "0", "0.02", "--pinned", "none", "--floor", "0", "--robot", ARM, "--motion",
                 MOTION, "--seconds", "11")
        with rosbag.Bag(self.path("demo.bag")) as file:
            meshes = [message for _, message, _ in file.read_messages("/deformable_mesh")]
        highest = [np.array(mesh.vertices).reshape(-1, 3)[:, 2].max() for mesh in meshes]
        self.assertEqual(len(meshes), 330)
        self.assertLess(highest[30], 0.1)  # on the ground
        self.assertGreater(highest[150], 0.5)  # lifted
        self.assertLess(highest[300], 0.3)  # laid down
        np.testing.assert_allclose(highest[-1], 0.02, atol=0.03)  # the script has begun again

    def test_bad_usage(self):
        text = self.path("motion.yaml")
        for words, says in (
                ([], "--object"), (["--object", "no_such_file.obj"], "no_such_file.obj"),
                (["--object", "cloth", "--meshes", "a.obj"], "--meshes"),
                (["--object", "volume", "--pinned", "corners"], "corners"),
                (["--object", "cloth", "--pinned", "all"], "--pinned"),
                (["--object", "cloth", "--vertices", "1"], "--vertices"),
                (["--object", "cloth", "--step", "0"], "--step"),
                (["--joints"], "--robot"), (["--joints", "--motion", text], "--motion"),
                (["--motion", "no_such_file.yaml", "--robot", ARM], "no_such_file.yaml"),
                (["--object", "cloth", "--monitor", "m"], "--bag"),
                (["--object", "cloth", "--frame", "camera", "--robot", ARM, "--joints"], "camera"),
                (["--object", "cloth", "--radius", "-1"], "--radius")):
            with self.subTest(words=words):
                self.assert_refused(words, says)
        for yaml, says in (
                ("[1]", "map"), ("joints: [a]", "points"), ("joints: [a]\npoints: [[0]]", "1 pos"),
                ("joints: [a]\npoints: [[1, 0], [1, 0]]", "ascending"),
                ("joints: [a]\npoints: [[0, x]]", "no number"),
                ("joints: [a]\npoints: [[0, 0]]\nhold: [[1, 0, left_finger]]", "hold"),
                ("joints: [a]\npoints: [[0, 0]]\nholds: []", "holds"),
                ("joints: [a]\npoints: [[0, 0]]\nloop: 1", "loop")):
            with self.subTest(yaml=yaml):
                with open(text, "w") as file:
                    file.write(yaml)
                self.assert_refused(["--motion", text, "--robot", ARM], says)

    def assert_refused(self, words, says):
        done = self.run_tool("--bag", self.path("bad.bag"), "--seconds", "1", *words)
        self.assertEqual((done.returncode, done.stdout), (2, ""), done.stderr)
        self.assertRegex(done.stderr, r"\Asoft_scene: [^\n]+\n\Z")
        self.assertIn(says, done.stderr)


if __name__ == "__main__":
    unittest.main()
