#!/usr/bin/env python3
"""Distances that evaluate_bag writes, draws and expects, of two triangles that are worked out by
hand. It needs no test data, but ROS."""
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../ros"))

# pylint: disable=wrong-import-position
from deformable_contact_monitor.msg import DeformableMesh
from evaluation_case import TOOL, read_table

CONFIG = """
reference_frame: world
pair_classes: [deformable_deformable]
objects: [{name: floor, topic: /floor}, {name: tip, topic: /tip}]
max_mesh_age_s: 0.3
margin_m: %s
"""
START_S = 1000
PERIOD_S = 0.125  # a binary fraction, as the heights are
# Of the tip above the floor.
HEIGHTS = (1.5, 0.75, 0.5, 0.25, -0.5, 0.25, 1.5, 0.5)


def mesh(name, stamp, corners, frame="world"):
    message = DeformableMesh(object=name, topology_id=1)
    message.header.frame_id, message.header.stamp = frame, stamp
    message.vertices = [x for corner in corners for x in corner]
    message.triangles = [0, 1, 2]
    return message


def tip_at(height):
    return (1, 2, height), (1, 3, height + 2), (2, 2, height + 2)


class Distances(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def text(self, name, content):
        with open(self.path(name), "w") as file:
            file.write(content)
        return self.path(name)

    def bag(self, lost_from, late=None):
        """From that index on, nobody knows the frame of the tip's mesh. late: a topic whose first
        mesh was recorded last."""
        with rosbag.Bag(self.path("run.bag"), "w") as bag:
            for i, height in enumerate(HEIGHTS):
                stamp = rospy.Time.from_sec(START_S + i * PERIOD_S)
                bag.write("/floor", mesh("floor", stamp, ((0, 0, 0), (8, 0, 0), (0, 8, 0))), stamp)
                bag.write("/tip", mesh("tip", stamp, tip_at(height),
                                       "world" if i < lost_from else "lost"), stamp)
            if late:
                stamp = rospy.Time(START_S)
                last = stamp + rospy.Duration((len(HEIGHTS) - 1) * PERIOD_S)
                bag.write(late, mesh(late[1:], stamp, tip_at(1)), last)
        return self.path("run.bag")

    def evaluate(self, *arguments, margin_m=1, lost_from=len(HEIGHTS), late=None, code=0,
                 report=False):
        config = self.text("config.yaml", CONFIG % margin_m)
        done = subprocess.run(
            [TOOL, self.bag(lost_from, late), "--out", self.path("out"), "--config", config, *arguments,
             *([] if report else ["--no-report"])],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True,
            check=False)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return done

    def rows(self):
        """{index of the tip's state: row}, of the cycles after both meshes."""
        rows = {}
        for row in read_table(self.path("out/distances.csv")):
            rows[round((float(row["stamp"]) - START_S) / PERIOD_S)] = row
        return rows

    def test_each_cycle_has_the_least_distance_with_its_points(self):
        self.evaluate()
        rows = self.rows()
        # Beyond the margin of 1 m a pair has no row.
        self.assertEqual({i: (row["state"], float(row["distance"])) for i, row in rows.items()},
                         {1: ("NEAR", .75), 2: ("NEAR", .5), 3: ("NEAR", .25), 4: ("CONTACT", 0),
                          5: ("NEAR", .25), 7: ("NEAR", .5)})
        near = rows[2]
        self.assertEqual((near["body_a"], near["body_b"]), ("floor", "tip"))
        self.assertEqual([float(near[key]) for key in ("ax", "ay", "az", "bx", "by", "bz")],
                         [1, 2, 0, 1, 2, .5])
        self.assertEqual([float(near[key]) for key in ("nx", "ny", "nz")], [0, 0, 1])

    def test_meshes_that_came_late_are_named_if_the_node_would_receive_them(self):
        warning = r"after their stamps: 1, by 0\.875 s at most; the live node would have rejected them"
        self.assertRegex(self.evaluate(late="/tip").stderr, warning)
        self.assertNotIn("after their stamps", self.evaluate(late="/other").stderr)

    def test_fcl_has_distances_but_no_near_pairs(self):
        with open(self.path("near.yaml"), "w") as file:
            file.write(CONFIG % 1 + "near_pairs: true\n")
        tool = [TOOL, self.bag(len(HEIGHTS)), "--out", self.path("out"), "--no-report",
                "--backends", "fcl", "--config"]
        done = subprocess.run([*tool, self.path("near.yaml")], stderr=subprocess.PIPE,
                              universal_newlines=True, check=False)
        self.assertEqual(done.returncode, 2)
        if "no FCL" in done.stderr:
            return
        self.assertIn("fcl does not support near_pairs; set it to false", done.stderr)
        self.evaluate("--backends", "fcl")
        self.assertEqual({i: float(row["distance"]) for i, row in self.rows().items()},
                         {1: .75, 2: .5, 3: .25, 4: 0, 5: .25, 7: .5})

    def test_unknown_has_no_distance(self):
        self.evaluate(lost_from=4)
        last = self.rows()[len(HEIGHTS) - 1]
        self.assertEqual((last["state"], last["distance"], last["ax"]), ("UNKNOWN", "", ""))

    def failures(self, expectations, **options):
        done = self.evaluate("--expect", self.text("e.yaml", expectations), code=1, **options)
        return [line for line in done.stdout.splitlines() if " keeps " in line]

    def test_a_distance_that_is_kept(self):
        self.evaluate("--expect", self.text("e.yaml", """
- {link: tip, object: floor, keeps_m: 0.5, to_s: 0.25}
- {link: floor, object: tip, keeps_m: 0.25, from_s: 0.6}
- {link: floor, object: tip, keeps_m: 1, from_s: 0.75, to_s: 0.75}
"""))

    def test_a_distance_that_is_not_kept(self):
        found = self.failures("""
- {link: tip, object: floor, keeps_m: 0.5, to_s: 0.375}
- {link: tip, object: floor, keeps_m: 0.125}
- {link: tip, object: floor, keeps_m: 0.51, from_s: 0.8}
""")
        self.assertEqual(len(found), 3, found)
        self.assertIn("tip keeps 0.5 m from floor to 0.375 s", found[0])
        self.assertIn("at 0.375 s: NEAR, 0.25 m; least 0.25 m at 0.375 s", found[0])
        self.assertIn("at 0.500 s: CONTACT, 1 pairs; least 0 m at 0.500 s", found[1])
        self.assertIn("at 0.875 s: NEAR, 0.5 m", found[2])

    def test_unknown_does_not_count_as_kept(self):
        found = self.failures("- {link: tip, object: floor, keeps_m: 0.125, from_s: 0.85}\n",
                              lost_from=4)
        self.assertRegex(found[0], r"at 0\.875 s: UNKNOWN, 0 pairs \(")

    def test_what_no_margin_shows_fails_with_that_reason(self):
        found = self.failures("""
- {link: tip, object: floor, keeps_m: 0.5}
- {link: tip, object: tip, keeps_m: 0.1}
- {link: tip, object: flor, keeps_m: 0.1}
""", margin_m=0.25)
        self.assertIn("keeps_m 0.5 m is above the margin of the two, 0.25 m", found[0])
        self.assertIn("a body has no distance from itself", found[1])
        self.assertIn("no such body 'flor' (did you mean 'floor'?)", found[2])

    def test_bad_entries_are_refused(self):
        for entry, words in (("keeps_m: 0.1, touches: never", "keeps_m excludes touches"),
                             ("keeps_m: 0.1, min_pairs: 2", "keeps_m excludes min_pairs"),
                             ("keeps_m: 0", "keeps_m"), ("keeps_m: far", "keeps_m"),
                             ("keep_m: 1", "keep_m (did you mean 'keeps_m'?)")):
            done = self.evaluate("--expect", self.text(
                "e.yaml", "- {link: tip, object: floor, %s}\n" % entry), code=2)
            self.assertIn(words, done.stderr)

    def test_the_report_draws_the_distances(self):
        self.evaluate(report=True)
        with open(self.path("out/report.html")) as file:
            page = file.read()
        self.assertIn("<h2>Distances</h2>", page)
        self.assertRegex(page, r"<td>floor / tip</td><td>0</td><td>0\.500</td>")
        self.evaluate(margin_m=0, report=True)
        with open(self.path("out/report.html")) as file:
            self.assertNotIn("<h2>Distances</h2>", file.read())


if __name__ == "__main__":
    unittest.main()
