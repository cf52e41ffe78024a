"""What the tests of evaluate_bag share: the scene's bags, the tool and its tables. The tool is
$EVALUATE_BAG."""
import copy
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import rospy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bags"))
from panda_bag import AWAY_FROM, DATA, PandaBag, stamp_of, write_bag

TOOL = os.environ["EVALUATE_BAG"]
CONFIG = """
reference_frame: panda_link0
objects: [{name: tshirt, topic: /tshirt}]
"""


def read_table(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def of_time(message, offset_s):
    """A copy of a recorded message, all of whose stamps differ by so much."""
    message = copy.deepcopy(message)
    for stamped in getattr(message, "transforms", [message]):
        stamped.header.stamp += rospy.Duration(offset_s)
    return message


class EvaluationCase(unittest.TestCase):
    _expected = None  # set by the first test that needs it

    @classmethod
    def setUpClass(cls):
        cls.scene = PandaBag()
        cls.events = cls.scene.events()

    @property
    def expected(self):
        """{frame: pairs}, by the oracle."""
        case = type(self)
        if case._expected is None:
            case._expected = self.scene.expected()
            touched = [frame for frame, pairs in case._expected.items() if pairs]
            assert touched == list(range(AWAY_FROM)), "the scene is not what this test is about"
        return case._expected

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def text(self, name, content):
        with open(self.path(name), "w") as file:
            file.write(content)
        return self.path(name)

    def bag(self, name="panda.bag", events=None, **options):
        return write_bag(self.path(name), self.events if events is None else events, **options)

    @staticmethod
    def tool(*arguments):
        environment = dict(os.environ, ROS_PACKAGE_PATH=f"{DATA}/robots")
        return subprocess.run([TOOL, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, errors="replace", check=False,
                              env=environment)

    def run_tool(self, *arguments, report=False):
        """Draws the report only where a test looks at it: this takes far longer than the rest."""
        more = () if report or "--no-report" in arguments else ("--no-report",)
        return self.tool("--out", self.path("out"), *arguments, *more)

    def evaluate(self, *arguments, code=0, report=False):
        """Returns the tool's summary."""
        done = self.run_tool("--config", self.text("config.yaml", CONFIG), "--pairs", *arguments,
                             report=report)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        return self.summary()

    def summary(self):
        with open(self.path("out/summary.json")) as file:
            return json.load(file)

    def report(self):
        with open(self.path("out/report.html")) as file:
            return file.read()

    def pairs(self):
        """{stamp: pairs} as pairs.csv has them; each once."""
        found = {}
        for row in read_table(self.path("out/pairs.csv")):
            pair = (row["body_a"], int(row["triangle_a"]), row["body_b"], int(row["triangle_b"]))
            of_stamp = found.setdefault(row["stamp"], set())
            self.assertNotIn(pair, of_stamp)
            of_stamp.add(pair)
        return found

    def assert_oracle_pairs(self):
        wanted = {f"{stamp_of(f).secs}.{stamp_of(f).nsecs:09d}": pairs
                  for f, pairs in self.expected.items()}
        frames = read_table(self.path("out/frames.csv"))
        self.assertEqual([row["stamp"] for row in frames], sorted(wanted))
        self.assertEqual(self.pairs(), {stamp: pairs for stamp, pairs in wanted.items() if pairs})
        for row in frames:
            self.assertEqual(int(row["pairs"]), len(wanted[row["stamp"]]))
            self.assertEqual((row["complete"], row["skipped"]), ("yes", ""))

    def assert_refused(self, arguments, *wanted, report=False):
        done = self.run_tool(*arguments, report=report)
        self.assertEqual(done.returncode, 2, done)
        last = done.stderr.splitlines()[-1]
        self.assertRegex(last, r"\Aevaluate_bag: [^\n]+\Z")
        for words in wanted:
            self.assertIn(words, last)
        return done

    def evaluate_pr2(self, bag, *arguments):
        done = self.run_tool(bag, "--robot-description", str(DATA / "bags/pr2.urdf"), *arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.summary()


def main():
    if not DATA.is_dir():
        print(f"SKIPPED: there are no test data at {DATA}")
        raise SystemExit(77)
    unittest.main()
