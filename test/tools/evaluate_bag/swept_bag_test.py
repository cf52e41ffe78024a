#!/usr/bin/env python3
"""evaluate_bag with motion: swept, on a finger that goes through a cloth between two meshes.

The tool is $EVALUATE_BAG, the oracle of steps $SWEPT_PAIRS: exact, and no code of the product's.
"""
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

import numpy as np
import rospy

TESTS = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(TESTS / "ros"), str(TESTS / "tools/bags")]
# pylint: disable=wrong-import-position
from deformable_contact_monitor.msg import LinkMesh, LinkMeshes
from monitor_test_support import grid, mesh_message, transform_message
from panda_bag import DATA, write_bag
from pose_meshes import merged, posed, read_binary_stl, rpy_quaternion, write_ply

TOOL = os.environ["EVALUATE_BAG"]
SWEPT_PAIRS = os.environ["SWEPT_PAIRS"]
START = rospy.Time(1000, 123456789)
PERIOD = rospy.Duration(0, 40000000)
# Where the finger's middle is in each frame; it is through between the second and the third.
HEIGHTS = (0.2, 0.1, -0.1, -0.2, -0.2)
PASSED_IN = 2
CONFIG = """
reference_frame: base
objects: [{name: cloth, topic: /cloth}]
"""
EXACT = CONFIG + "motion: swept\nswept_tolerance_m: 0\n"


def stamp_of(frame):
    return START + rospy.Duration.from_sec(frame * PERIOD.to_sec())


def text_of(stamp):
    return "%d.%09d" % (stamp.secs, stamp.nsecs)


def finger():
    """A box of 2 x 2 x 6 cm, out of the grid's symmetry."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-3, 3)], np.float32)
    quads = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = [t for a, b, c, d in quads for t in ((a, b, c), (a, c, d))]
    return (0.01 * corners + np.float32([0.013, 0.027, 0])).astype(np.float32), np.uint32(triangles)


def cloth(frame):
    """It waves, so that it moves in each step."""
    vertices, triangles = grid(12, 0.4)
    x, y = vertices[:, 0], vertices[:, 1]
    wave = 0.004 * np.sin(20 * x + 13 * y + frame)
    return np.stack([x, y, wave], axis=1).astype(np.float32), triangles


def pose_of(frame, turning=False):
    """(translation, quaternion) of the finger's link; turning, it swings about an axis far off."""
    height = HEIGHTS[min(max(frame, 0), len(HEIGHTS) - 1)]
    return (0, 0, height), rpy_quaternion((5 * height if turning else 0, 0, 0))


def events(turning=False):
    vertices, triangles = finger()
    links = LinkMeshes(meshes=[LinkMesh("finger", "test", vertices.flatten().tolist(),
                                        triangles.flatten().tolist())])
    found = [(START - rospy.Duration(1), "/contact_monitor/robot_meshes", links)]
    for frame in range(-1, len(HEIGHTS) + 1):
        stamp = stamp_of(frame)
        edges = {"finger": ("base", pose_of(frame, turning))}
        found.append((stamp, "/tf", transform_message(stamp, edges)))
        if 0 <= frame < len(HEIGHTS):
            mesh = mesh_message("cloth", stamp, "base", cloth(frame))
            found.append((stamp + rospy.Duration(0, 5000000), "/cloth", mesh))
    return found


class SweptBag(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_tool(self, config, *arguments, turning=False, report=False):
        with open(self.path("config.yaml"), "w") as file:
            file.write(config)
        bag = write_bag(self.path("finger.bag"), events(turning))
        return subprocess.run(
            [TOOL, "--out", self.path("out"), "--config", self.path("config.yaml"), "--pairs",
             *arguments, *(() if report else ("--no-report",)), bag], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
            check=False)

    def evaluate(self, config, *arguments, code=0, **options):
        """The tool's summary."""
        done = self.run_tool(config, *arguments, **options)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        with open(self.path("out/summary.json")) as file:
            return json.load(file)

    def table(self, name):
        with open(self.path("out/" + name), newline="") as file:
            return list(csv.DictReader(file))

    def states(self):
        """By frame."""
        states = {}
        for row in self.table("links.csv"):
            for frame in range(len(HEIGHTS)):
                stamp = text_of(stamp_of(frame))
                if row["from"] <= stamp <= row["to"]:
                    states[frame] = row["state"]
        return [states[frame] for frame in range(len(HEIGHTS))]

    def oracle_pairs(self, frame):
        """Of the step that ends with the frame: {(triangle of the finger, of the cloth)}."""
        files, origins = [], []
        for at in frame - 1, frame:
            mesh, origins = merged([posed(finger(), pose_of(at)), cloth(at)])
            files.append(self.path("state%d.ply" % at))
            write_ply(files[-1], mesh)
        done = subprocess.run([SWEPT_PAIRS, "--adjacent", "skip", *files], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, check=True)
        pairs = [tuple(origins[int(word)] for word in line.split())
                 for line in done.stdout.splitlines()]
        return {(a, b) for (body_a, a), (body_b, b) in pairs if (body_a, body_b) == (0, 1)}

    def assert_oracle_pairs(self):
        rows = self.table("swept_pairs.csv")
        for frame in range(1, len(HEIGHTS)):
            of_step = [row for row in rows if row["stamp"] == text_of(stamp_of(frame))]
            self.assertEqual({row["from"] for row in of_step} or {text_of(stamp_of(frame - 1))},
                             {text_of(stamp_of(frame - 1))})
            pairs = [(int(row["triangle_a"]), int(row["triangle_b"])) for row in of_step]
            self.assertEqual(pairs, sorted(set(pairs)))
            self.assertEqual(set(pairs), self.oracle_pairs(frame), frame)
            self.assertEqual(bool(pairs), frame == PASSED_IN)
        for row in rows:
            self.assertEqual((row["body_a"], row["body_b"], row["within_pad"]),
                             ("finger", "cloth", "no"))
            low, high = float(row["first_low"]), float(row["first_high"])
            self.assertTrue(0 < low <= high < 1 and high - low <= 2**-20, row)
        return rows

    def test_instant_sees_nothing(self):
        summary = self.evaluate(CONFIG)
        self.assertEqual(self.states(), ["NONE"] * len(HEIGHTS))
        self.assertEqual(self.table("pairs.csv"), [])
        self.assertEqual(self.table("events.csv"), [])
        self.assertFalse(os.path.exists(self.path("out/swept_pairs.csv")))
        self.assertNotIn("swept", summary["runs"][0])
        self.assertNotIn("swept_pairs", self.table("frames.csv")[0])

    def test_swept_sees_the_pairs_of_the_oracle(self):
        summary = self.evaluate(EXACT)
        rows = self.assert_oracle_pairs()
        self.assertEqual(self.states(), ["NONE", "NONE", "PASSED", "NONE", "NONE"])
        self.assertEqual(self.table("pairs.csv"), [])
        steps = summary["runs"][0]["swept"]
        self.assertEqual((steps["pairs"], steps["passed"]), (len(rows), 1))
        self.assertEqual((steps["cycles_with_a_step"], steps["complete_cycles"]), (4, 4))
        self.assertEqual((steps["pairs_within_pad"], steps["most_pad_m"]), (0, 0))
        self.assertEqual(summary["configuration"]["motion"], "swept")
        frames = self.table("frames.csv")
        self.assertEqual([row["swept_complete"] for row in frames],
                         ["no", "yes", "yes", "yes", "yes"], "the first has nothing to start from")
        self.assertEqual([int(row["swept_pairs"]) for row in frames], [0, 0, len(rows), 0, 0])
        self.assertEqual({row["complete"] for row in frames}, {"yes"})
        manual = (TESTS.parent / "src/tools/evaluate_bag/README.md").read_text()
        self.assertRegex(manual, r"swept +NONE NONE PASSED NONE NONE +0 +%d\n" % len(rows))

    def test_the_pandas_finger(self):
        stl = DATA / "robots/panda_description/meshes/collision/finger.stl"
        if not stl.exists():
            self.skipTest(f"SKIPPED: no {stl}")
        with mock.patch.object(sys.modules[__name__], "finger", lambda: read_binary_stl(stl)):
            self.evaluate(CONFIG)
            self.assertEqual(self.states(), ["NONE"] * len(HEIGHTS))
            self.evaluate(EXACT)
            self.assertGreater(len(self.assert_oracle_pairs()), 50)
            self.assertEqual(self.states(), ["NONE", "NONE", "PASSED", "NONE", "NONE"])

    def test_its_event_says_when(self):
        self.evaluate(EXACT)
        event, = self.table("events.csv")
        rows = self.table("swept_pairs.csv")
        self.assertEqual((event["type"], event["body_a"], event["body_b"]),
                         ("PASSED", "finger", "cloth"))
        self.assertEqual((event["stamp"], event["from"]), (rows[0]["stamp"], rows[0]["from"]))
        self.assertEqual(int(event["pairs"]), len(rows))
        first = min(float(row["first_low"]) for row in rows)
        self.assertEqual(float(event["first_low"]), first)
        # Its tip, 3 cm below its middle, meets the cloth's waves of 4 mm.
        self.assertTrue(0.33 < first < 0.38, first)

    def test_straight_ways_need_no_pad(self):
        """The usual tolerance: a link that does not turn moves straight anyway."""
        summary = self.evaluate(CONFIG + "motion: swept\n")
        self.assert_oracle_pairs()
        self.assertEqual(self.states()[PASSED_IN], "PASSED")
        self.assertEqual(summary["configuration"]["swept_tolerance_m"], 1e-4)

    def test_a_finger_that_turns(self):
        summary = self.evaluate(CONFIG + "motion: swept\n", turning=True)
        self.assertEqual(self.states(), ["NONE", "NONE", "PASSED", "NONE", "NONE"])
        steps = summary["runs"][0]["swept"]
        self.assertTrue(0 < steps["most_pad_m"] <= 1e-4, steps)
        self.assertGreater(steps["most_sub_steps"], 1)
        marked = [row for row in self.table("swept_pairs.csv") if row["within_pad"] == "yes"]
        self.assertEqual(len(marked), steps["pairs_within_pad"])
        for row in marked:
            self.assertEqual(row["first_high"], "1")

    def test_backends_agree_on_steps_too(self):
        summary = self.evaluate(EXACT, "--backends", "cpu,brute_force")
        first, second = summary["runs"]
        self.assertEqual(first["swept"], second["swept"])
        self.assertGreater(first["swept"]["pairs"], 0)
        self.assertEqual(summary["comparisons"][0]["cycles_that_differ"], 0)
        self.assert_oracle_pairs()
        self.assertEqual([row["run"] for row in self.table("events.csv")],
                         ["cpu exact", "brute_force exact"])

    def test_expectations(self):
        with open(self.path("expect.yaml"), "w") as file:
            file.write("""
- {link: finger, object: cloth, touches: never}
- {link: finger, object: cloth, touches: sometime}
- {link: finger, object: cloth, touches: sometime, min_pairs: 100000}
- {link: finger, object: cloth, touches: always, from_s: 0.07, to_s: 0.09}
- {link: finger, object: cloth, touches: never, from_s: 0.1}
""")
        summary = self.evaluate(EXACT, "--expect", self.path("expect.yaml"), code=1)
        self.assertEqual([e["holds"] for e in summary["expectations"]],
                         [False, True, False, False, True])
        failures = [e["failure"] for e in summary["expectations"]]
        self.assertRegex(failures[0], r"at 0.080 s: PASSED, \d+ pairs")
        self.assertIn("most pairs %d" % len(self.table("swept_pairs.csv")), failures[2])
        self.assertIn("PASSED", failures[3])
        summary = self.evaluate(CONFIG, "--expect", self.path("expect.yaml"), code=1)
        self.assertEqual([e["holds"] for e in summary["expectations"]],
                         [True, False, False, False, True])

    def test_report(self):
        done = self.run_tool(EXACT, report=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        if "no matplotlib" in done.stderr or "python3-matplotlib" in done.stderr:
            self.skipTest("SKIPPED: no matplotlib")
        self.assertRegex(done.stdout, r"between cycles: \d+ pairs, 1 passed, 4 of 4 cycles")
        report = pathlib.Path(self.path("out/report.html")).read_text()
        self.assertIn("<h2>Between the cycles</h2>", report)
        self.assertIn("swept, links&#39; paths to within 0 m", report)

    def test_refusals(self):
        for config, arguments, words in (
                (EXACT, ["--backends", "cpu,fcl"], "fcl does not support swept motion"),
                (CONFIG + "motion: slow\n", [], "motion"),
                (CONFIG + "motion: swept\nswept_tolerance_m: -1\n", [], "swept_tolerance_m")):
            done = self.run_tool(config, *arguments)
            self.assertEqual(done.returncode, 2, done)
            self.assertRegex(done.stderr.splitlines()[-1], r"\Aevaluate_bag: [^\n]+\Z")
            self.assertIn(words, done.stderr.splitlines()[-1])


if __name__ == "__main__":
    unittest.main()
