#!/usr/bin/env python3
"""Every program of the package, as a user calls it for help, where no ROS master is."""
import os
import pathlib
import subprocess
import unittest

FOLDER = pathlib.Path(os.environ["CONTACT_MONITOR"]).parent
SOURCE = pathlib.Path(os.environ["DCM_SOURCE_DIR"])
NODES = [FOLDER / "contact_monitor", FOLDER / "contact_guard", FOLDER / "soft_scene",
         FOLDER / "contact_test"]
PROGRAMS = NODES + [FOLDER / name for name in (
    "evaluate_bag", "evaluate_bags", "evaluation_report.py", "measure_trade", "detect_contacts",
    "read_link_mesh", "plot_trade.py")] + [
        SOURCE / "launch/framed_rviz.py", SOURCE / "launch/demo", SOURCE / "launch/demo_report.py",
        SOURCE / "launch/moving_arms.py"]
# No node that is started by mistake would live long.
ENVIRONMENT = dict(os.environ, ROS_MASTER_URI="http://localhost:1", ROS_LOG_DIR="/nowhere")


def run(program, *words, **variables):
    return subprocess.run([str(program), *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          stdin=subprocess.DEVNULL, universal_newlines=True, check=False,
                          env=dict(ENVIRONMENT, **variables))


class Help(unittest.TestCase):

    def test_is_printed(self):
        for program in PROGRAMS:
            with self.subTest(program.name):
                done = run(program, "--help")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertGreater(len(done.stdout.split()), 10, done.stdout)
                self.assertIn(program.name, done.stdout)

    def test_is_printed_whatever_roslaunch_adds(self):
        for program in NODES:
            with self.subTest(program.name):
                done = run(program, "__name:=other", "-h", "a:=b", "__log:=/nowhere/log",
                           ROS_MASTER_URI="no URI")
                self.assertEqual((done.returncode, done.stderr), (0, ""))
                self.assertIn(program.name, done.stdout)

    def test_what_is_unknown_is_refused_before_anything_starts(self):
        for program in NODES:
            for words in (["now"], ["__name:=x", "--margin", "3"]):
                with self.subTest(program.name, words=words):
                    done = run(program, *words)
                    self.assertEqual((done.returncode, done.stdout), (2, ""))
                    self.assertRegex(done.stderr, r"\A%s: [^\n]*--help[^\n]*\n\Z" % program.name)

    def test_the_version_is_printed(self):
        for name in "contact_monitor", "contact_guard", "soft_scene", "evaluate_bag":
            done = run(FOLDER / name, "--version")
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            self.assertRegex(done.stdout, r"\A%s \d+\.\d+\.\d+\n\Z" % name)


if __name__ == "__main__":
    unittest.main()
