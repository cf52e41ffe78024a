#!/usr/bin/env python3
"""Records a scene that was monitored live, evaluates it and replays it, also in a loop and with a
pause. The pairs must be the same, and the oracle's, at every stamp that was processed."""
import csv
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy
import rostest

from monitor_test_support import (
    PACKAGE, ContactEvent, Monitor, executable, pairs_of, wait_until)
from panda_scene import PandaScene

FRAMES = 20
PERIOD_S = 0.05
AWAY = range(6, 9)
CONFIG = "reference_frame: panda_link0\nobjects: [{name: tshirt, topic: /tshirt}]\n"


class RecordAndReplay(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.bag = os.path.join(cls.folder, "contacts.bag")
        with open(os.path.join(cls.folder, "config.yaml"), "w") as file:
            file.write(CONFIG)
        cls.started = []
        cls.addClassCleanup(lambda: [process.wait(30) for process in cls.started])
        cls.live = cls.record()  # {stamp [ns]: pairs}
        cls.evaluated = cls.evaluate()

    @classmethod
    def start(cls, launch_file, *arguments):
        process = subprocess.Popen(["roslaunch", PACKAGE, launch_file, *arguments],
                                   stdin=subprocess.DEVNULL,
                                   stdout=subprocess.DEVNULL, start_new_session=True)
        cls.started.append(process)
        return process

    @staticmethod
    def stop(process):
        if process.poll() is None:
            process.send_signal(signal.SIGINT)
        process.wait(30)

    @classmethod
    def record(cls):
        """Records while the monitor runs; what it published, held against the oracle."""
        monitor = Monitor()
        robot_log = monitor.robot_meshes_log()
        scene = PandaScene(rospy.get_param("~data"))
        recorder = cls.start("record.launch", "bag:=" + cls.bag, "meshes:=/tshirt")
        wait_until(lambda: scene.shirt.publisher.get_num_connections() >= 2, "the recorder")
        wait_until(lambda: scene.transforms.publisher.get_num_connections() >= 2, "the recorder")
        scene.show_until_seen(monitor)
        meshes = monitor.robot_meshes(robot_log)
        stamps = []
        for frame in range(FRAMES):
            stamps.append(rospy.Time.now() if frame == 0
                          else stamps[-1] + rospy.Duration(PERIOD_S))
            rospy.sleep(stamps[-1] - rospy.Time.now())
            scene.show(stamps[-1], frame, frame % 5, (0.35, 0.05, 2.5 if frame in AWAY else 0.5))
            monitor.contacts_at(stamps[-1])
        rospy.sleep(0.2)
        cls.stop(recorder)
        found = {}
        for frame, stamp in enumerate(stamps):
            pairs = pairs_of(monitor.contacts_at(stamp))
            assert pairs == scene.expected(stamp, frame, meshes)
            assert (pairs == set()) == (frame in AWAY), "the scene is not what this test is about"
            found[stamp.to_nsec()] = pairs
        return found

    @classmethod
    def evaluate(cls):
        """{stamp [ns]: pairs} of evaluate_bag."""
        out = os.path.join(cls.folder, "out")
        subprocess.run([executable("evaluate_bag"), cls.bag, "--config",
                        os.path.join(cls.folder, "config.yaml"), "--out", out, "--pairs",
                        "--no-report"], check=True, timeout=100)
        def ns(text):
            return int(text.replace(".", ""))
        with open(out + "/frames.csv", newline="") as file:
            found = {ns(row["stamp"]): set() for row in csv.DictReader(file)}
        with open(out + "/pairs.csv", newline="") as file:
            for row in csv.DictReader(file):
                found[ns(row["stamp"])].add((row["body_a"], int(row["triangle_a"]), row["body_b"],
                                             int(row["triangle_b"])))
        return found

    def test_recorded_is_what_replay_needs(self):
        with rosbag.Bag(self.bag) as bag:
            topics = bag.get_type_and_topic_info().topics
        self.assertEqual(set(topics), {"/tf", "/tshirt", "/contact_monitor/robot_meshes"})
        self.assertGreaterEqual(topics["/tshirt"].message_count, FRAMES)

    def test_evaluated_as_live(self):
        for stamp, pairs in self.live.items():
            self.assertEqual(self.evaluated[stamp], pairs)

    def replay(self, name, play=""):
        """The monitor of a replay, and its process."""
        process = self.start(
            "replay.launch", "bag:=" + self.bag, "name:=" + name, "play:=" + play,
            "config:=" + os.path.join(self.folder, "config.yaml"))
        self.addCleanup(self.stop, process)
        return Monitor("/" + name), process

    def check(self, contacts):
        """The cycles that looked at a mesh of the recording equal evaluate_bag's; their stamps."""
        stamps = []
        for message in contacts:
            # The first mesh may reach the monitor before the first transform, as each topic has a
            # connection of its own.
            is_first = not stamps and any("never seen" in text for text in message.skipped)
            if is_first or any("tshirt" in text for text in message.skipped):
                self.assertFalse(message.complete)
                continue
            stamp = message.header.stamp.to_nsec()
            self.assertTrue(message.complete, message.skipped)
            self.assertEqual(pairs_of(message), self.evaluated[stamp])
            stamps.append(stamp)
        return stamps

    def test_replayed_as_evaluated(self):
        monitor, _ = self.replay("replayed")
        last = max(self.live)
        monitor.contacts.wait("the last mesh", lambda m: m.header.stamp.to_nsec() == last
                              and not m.skipped)
        stamps = self.check(list(monitor.contacts.messages))
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertGreater(len(set(stamps) & set(self.live)), FRAMES / 2)

    def test_looped_and_paused(self):
        monitor, _ = self.replay("looped", "--loop")

        def passes():
            stamps = [m.header.stamp.to_nsec() for m in monitor.contacts.messages if not m.skipped]
            return sum(a > b for a, b in zip(stamps, stamps[1:]))
        wait_until(lambda: passes() >= 2, "the bag to begin for the third time")
        stamps = self.check(list(monitor.contacts.messages))
        again = [stamp for stamp in self.live if stamps.count(stamp) > 1]
        self.assertGreater(len(again), FRAMES / 2)
        ends = [e for e in monitor.events.messages if e.type == ContactEvent.END
                and "time jump" in e.reason]
        self.assertTrue(ends, "the contacts of one pass must end before those of the next")

        # While the clock stands, nothing passes for fresh.
        subprocess.run(["rosservice", "call", "/play_contacts/pause_playback", "true"], check=True,
                       timeout=30, stdout=subprocess.DEVNULL)
        since = monitor.contacts.count()
        silent = monitor.contacts.wait("a heartbeat of the pause", lambda m: m.skipped, since)
        self.assertFalse(silent.complete)
        subprocess.run(["rosservice", "call", "/play_contacts/pause_playback", "false"], check=True,
                       timeout=30, stdout=subprocess.DEVNULL)
        since = monitor.contacts.count()
        monitor.contacts.wait("contacts after the pause", lambda m: not m.skipped, since)
        self.check(list(monitor.contacts.messages))


if __name__ == "__main__":
    rospy.init_node("record_and_replay_test")
    rostest.rosrun(PACKAGE, "record_and_replay", RecordAndReplay, sys.argv)
