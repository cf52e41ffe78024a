#!/usr/bin/env python3
"""measure_trade on a bag: the frames are evaluate_bag's, the contacts the oracle's."""
import copy
import csv
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import time
import unittest

import rospy

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "bags"))
from panda_bag import DATA, FRAMES, PandaBag, stamp_of, write_bag

TOOL = os.environ["MEASURE_TRADE"]
CONFIG = "reference_frame: panda_link0\nobjects: [{name: tshirt, topic: /tshirt}]\n"


class TradeBag(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)
        self.scene = PandaBag()
        self.tool = shutil.copy(TOOL, self.folder)  # it finds no scripts to draw plots
        pathlib.Path(self.path("config.yaml")).write_text(CONFIG)

    def path(self, name):
        return os.path.join(self.folder, name)

    def run_tool(self, *arguments):
        return subprocess.run([self.tool, "--out", self.path("out"), *arguments], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True, check=False)

    def rows(self, name):
        with open(self.path("out/" + name), newline="") as file:
            return list(csv.DictReader(file))

    def test_a_bag(self):
        bag = write_bag(self.path("panda.bag"), self.scene.events())
        done = self.run_tool("--bag", bag, "--config", self.path("config.yaml"),
                             "--overlaps", "0,1", "--clusters", "0,64", "--predicates", "exact")
        self.assertEqual(done.returncode, 0, done.stderr)
        expected = self.scene.expected()
        with open(self.path("out/summary.json")) as file:
            frames = json.load(file)["frames"]
        self.assertEqual([frame["contacts"] for frame in frames],
                         [len(expected[frame]) for frame in range(FRAMES)])
        links = {row["link"] for row in self.rows("links.csv")}
        self.assertEqual(links, {pair[0] for pairs in expected.values() for pair in pairs})
        recalls = {(row["overlap"], row["clusters"]): float(row["recall_external_worst"])
                   for row in self.rows("settings.csv")}
        self.assertEqual({recalls["1", clusters] for clusters in ("0", "64")}, {1.0})
        self.assertLess(recalls["0", "64"], 1)

    def test_bodies_with_themselves_have_no_tolerance(self):
        with open(self.path("config.yaml"), "a") as file:
            file.write("pair_classes: [deformable_self]\n")
        done = self.run_tool("--tolerance", "--bag",
                             write_bag(self.path("panda.bag"), self.scene.events()), "--config",
                             self.path("config.yaml"), "--cycles", "1", "--warm-up", "0")
        self.assertEqual((done.returncode, done.stdout), (2, ""))
        self.assertIn("measure_trade: --tolerance: no frame has an enabled pair of two bodies",
                      done.stderr)

    def test_what_is_not_looked_at_is_said(self):
        events = [e for e in self.scene.events() if e[1] != "/tf" or e[0] < stamp_of(9.5)]
        done = self.run_tool("--bag", write_bag(self.path("half.bag"), events), "--config",
                             self.path("config.yaml"), "--overlaps", "1", "--clusters", "0",
                             "--predicates", "exact")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("in 10 of 20 cycles a body is UNKNOWN", done.stderr)

    def test_a_long_bag_is_sampled(self):
        bag = write_bag(self.path("panda.bag"), self.scene.events())
        expected = self.scene.expected()
        for most in (FRAMES - 1, 5, 1, 0):
            done = self.run_tool("--bag", bag, "--config", self.path("config.yaml"), "--overlaps",
                                 "1", "--clusters", "0", "--predicates", "exact", "--repeats", "1",
                                 "--cycles", "1", "--warm-up", "0", "--frames", str(most))
            self.assertEqual(done.returncode, 0, done.stderr)
            step = next(2**i for i in range(20) if most == 0 or -(-FRAMES // 2**i) <= most)
            kept = range(0, FRAMES, step)
            with open(self.path("out/summary.json")) as file:
                frames = json.load(file)["frames"]
            self.assertEqual([frame["contacts"] for frame in frames],
                             [len(expected[frame]) for frame in kept])
            note = (f"note: {len(kept)} of {FRAMES} cycles are measured, one in {step} "
                    "(--frames 0: all)")
            self.assertEqual(note in done.stderr, step > 1, done.stderr)
        for other in (["--swept"], ["--frames", "-1"]):
            done = self.run_tool("--bag", bag, "--frames", "5", *other)
            self.assertEqual(done.returncode, 2)
            self.assertIn("--frames", done.stderr)

    def test_swept(self):
        """What instant motion finds is the oracle's, in each stretch from one kept frame on."""
        every = 4
        bag = write_bag(self.path("panda.bag"), self.scene.events())
        done = self.run_tool("--bag", bag, "--config", self.path("config.yaml"), "--swept",
                             "--every", str(every))
        self.assertEqual(done.returncode, 0, done.stderr)
        expected = self.scene.expected()
        kept = [*range(0, FRAMES - 1, every), FRAMES - 1]
        found = {1: 0, every: 0}
        for begin, end in zip(kept, kept[1:]):
            found[1] += len(set().union(*(expected[f] for f in range(begin, end + 1))))
            found[every] += len(set(expected[begin]) | set(expected[end]))
        rows = {(row["motion"], int(row["every"])): row for row in self.rows("motions.csv")
                if row["level"] == "triangles"}
        for step, count in found.items():
            row = rows["instant", step]
            self.assertEqual(int(row["contacts"]) - int(row["contacts_lost"]), count, step)
            self.assertEqual(row["contacts_added"], "0")
        self.assertGreater(int(rows["instant", every]["contacts_lost"]),
                           int(rows["instant", 1]["contacts_lost"]))
        with open(self.path("out/summary.json")) as file:
            summary = json.load(file)
        self.assertEqual((len(summary["frames"]), summary["pairs_without_step"]), (FRAMES, 0))

    def test_there_is_no_step_where_the_clock_goes_back_or_the_object_was_away(self):
        robot, *rest = self.scene.events()
        earlier = []
        for received, topic, message in rest:
            message = copy.deepcopy(message)
            for stamped in getattr(message, "transforms", [message]):
                stamped.header.stamp += rospy.Duration(60)
            earlier.append((received - rospy.Duration(10), topic, message))
        away = [e for e in rest if e[1] != "/tshirt" or not stamp_of(2) < e[0] < stamp_of(17)]
        start = [(earlier[0][0] - rospy.Duration(1), *robot[1:])]
        steps = {}
        for name, events in (("whole", [robot] + rest), ("away", [robot] + away),
                             ("anew", start + earlier + rest)):
            done = self.run_tool("--bag", write_bag(self.path(name + ".bag"), events), "--config",
                                 self.path("config.yaml"), "--swept", "--every", "2")
            self.assertEqual(done.returncode, 0, done.stderr)
            with open(self.path("out/summary.json")) as file:
                summary = json.load(file)
            steps[name] = (len(summary["frames"]), summary["pairs_without_step"])
        pairs = steps["away"][1]  # those of one frame
        self.assertGreater(pairs, 0)
        self.assertEqual(steps, {"whole": (FRAMES, 0), "away": (FRAMES - 15, pairs),
                                 "anew": (2 * FRAMES, pairs)})

    def test_the_bags_pair_classes_are_written(self):
        bag = write_bag(self.path("panda.bag"), self.scene.events())
        classes = "pair_classes: [robot_deformable, deformable_self]\n"
        pathlib.Path(self.path("config.yaml")).write_text(CONFIG + classes)
        done = self.run_tool("--bag", bag, "--config", self.path("config.yaml"), "--overlaps", "1",
                             "--clusters", "0", "--predicates", "exact", "--repeats", "1",
                             "--write-config", self.path("chosen.yaml"))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(pathlib.Path(self.path("chosen.yaml")).read_text().endswith(classes))

    def test_refusals(self):
        bag = write_bag(self.path("bare.bag"), [e for e in self.scene.events() if e[1] == "/tf"])
        for arguments, words in ((["--bag", bag], "no robot"),
                                 (["--bag", self.path("none.bag")], "cannot be read"),
                                 (["--config", self.path("config.yaml")], "--bag")):
            done = self.run_tool(*arguments)
            self.assertEqual(done.returncode, 2, done)
            self.assertIn(words, done.stderr.splitlines()[-1])

    def test_a_damaged_bag_is_named_as_such(self):
        """The link meshes are in the first chunk, which cannot be read."""
        bag = write_bag(self.path("damaged.bag"), self.scene.events(), "bz2", 4096)
        content = bytearray(pathlib.Path(bag).read_bytes())
        start = content.index(b"BZh") + 100
        content[start:start + 100] = bytes(100)
        pathlib.Path(bag).write_bytes(content)
        done = self.run_tool("--bag", bag)
        self.assertEqual(done.returncode, 2, done)
        self.assertIn("measure_trade: damaged: ", done.stderr.splitlines()[-1])

    def test_the_reader_is_forked_before_any_thread_starts(self):
        """A thread that holds a lock at the fork would leave it locked in the reader for ever."""
        os.mkfifo(self.path("bag"))  # the reader waits in open(), and the tool for the reader
        tool = subprocess.Popen([self.tool, "--bag", self.path("bag"), "--out", self.path("out")])
        self.addCleanup(tool.wait)
        self.addCleanup(tool.kill)
        tasks = pathlib.Path(f"/proc/{tool.pid}/task")
        readers, threads = [], []
        while not readers or not threads:
            self.assertIsNone(tool.poll())
            readers = [int(pid) for pid in (tasks / str(tool.pid) / "children").read_text().split()]
            threads = [int(task.name) for task in tasks.iterdir() if int(task.name) != tool.pid]
            time.sleep(0.01)
        # Linux numbers tasks in the order of their start, and begins anew at its limit.
        numbers = int(pathlib.Path("/proc/sys/kernel/pid_max").read_text())
        self.assertLess((readers[0] - tool.pid) % numbers, (min(threads) - tool.pid) % numbers)


if __name__ == "__main__":
    if not DATA.is_dir():
        print(f"SKIPPED: there are no test data at {DATA}")
        raise SystemExit(77)
    unittest.main()
