#!/usr/bin/env python3
"""Runs the commands of config/docs/first_bag.md as they are written there."""
import csv
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

import numpy as np
import rosbag

SOURCE = pathlib.Path(os.environ["DCM_SOURCE_DIR"])
TOOLS = pathlib.Path(os.environ["EVALUATE_BAG"]).parent
BAG = SOURCE / "config/lifted_cloth.bag"


def commands():
    """The indented lines of the page, each command as one text."""
    text = (SOURCE / "config/docs/first_bag.md").read_text()
    return [re.sub(r"\\\n", "", block) for block in re.findall(r"(?:^    .*\n)+", text, re.M)]


def messages(path):
    with rosbag.Bag(str(path)) as bag:
        return [(topic, t, message) for topic, message, t in bag.read_messages()]


class FirstBag(unittest.TestCase):

    def run_in_a_copy(self, command):
        """Runs the command in a folder that looks like the package's after test/run."""
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        root = pathlib.Path(folder.name)
        (root / "build/test/devel/lib").mkdir(parents=True)
        (root / "build/test/devel/lib/deformable_contact_monitor").symlink_to(TOOLS)
        (root / "config").symlink_to(SOURCE / "config")
        done = subprocess.run(["bash", "-c", command], cwd=str(root), stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, universal_newlines=True, check=False,
                              timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return root

    def test_the_report_tells_what_the_page_says(self):
        root = self.run_in_a_copy(commands()[0])
        report = (root / "lifted_cloth/report.html").read_text()
        self.assertGreater(report.count("<svg"), 2)
        for heading in ("Who touches whom", "Distances"):
            self.assertIn(heading, report)
        with open(str(root / "lifted_cloth/links.csv")) as file:
            rows = list(csv.DictReader(file))
        touching = [r for r in rows if r["state"] == "CONTACT"]
        self.assertEqual({r["body_a"] for r in touching}, {"palm"})
        longest = max(touching, key=lambda r: int(r["cycles"]))
        self.assertAlmostEqual(float(longest["from"]), 1004, delta=0.2)
        self.assertAlmostEqual(float(longest["to"]), 1007.5, delta=0.2)
        near = min(float(r["from"]) for r in rows
                   if r["body_a"] == "left_finger" and r["state"] == "NEAR")
        self.assertAlmostEqual(near, 1001.2, delta=0.1)

    def test_the_bag_is_small(self):
        self.assertLess(BAG.stat().st_size, 4 * 2**20)

    @unittest.skipUnless((TOOLS / "soft_scene").exists(), "there is no Bullet")
    def test_the_bag_is_what_its_command_makes(self):
        made = messages(self.run_in_a_copy(commands()[1]) / "lifted_cloth.bag")
        shipped = messages(BAG)
        self.assertEqual([(topic, t) for topic, t, _ in made],
                         [(topic, t) for topic, t, _ in shipped])
        for (topic, t, one), (_, _, other) in zip(made, shipped):
            if topic == "/joint_states":
                np.testing.assert_allclose(one.position, other.position, atol=1e-12)
            elif topic == "/deformable_mesh":
                self.assertEqual(one.triangles, other.triangles)
                # Where the cloth is lifted, it may fall into other folds.
                if t.to_sec() < 1002:
                    np.testing.assert_allclose(one.vertices, other.vertices, atol=1e-3)
                self.assertLess(np.abs(np.subtract(one.vertices, other.vertices)).max(), 0.7)


if __name__ == "__main__":
    unittest.main()
