#!/usr/bin/env python3
"""Stamps one object five seconds behind the other. Each pair of bodies must be checked in its own
object's cycles and by its own stamps, and become UNKNOWN at its own deadline: in the monitor,
contact_test, evaluate_bag and the markers."""
import concurrent.futures
import csv
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rosbag
import rospy
import rostest
from visualization_msgs.msg import Marker, MarkerArray

import boxes_scene
from boxes_scene import CLOTH, FINGER_AT, PALM_AT, REFERENCE_FRAME, SMALL_CLOTH, UPRIGHT
from contact_test_failures import run_contact_test
from monitor_test_support import (
    PACKAGE, ContactState, Log, MeshPublisher, Monitor, Transforms, executable, mesh_message,
    pairs_of, transform_message)

BEHIND = rospy.Duration(5)
PERIOD_S = 0.1
MAX_MESH_AGE_S = 7.0
CONFIG = """
reference_frame: base
objects: [{name: cloth, topic: /cloth}, {name: sheet, topic: /sheet}]
ignored_links: [lost]
max_mesh_age_s: 7.0
"""


def edges(stamp):
    """The finger comes and goes every four seconds, so five seconds ago it was elsewhere at times."""
    away = (0.0, 0.0, 2.0) if stamp.to_sec() % 8 < 4 else FINGER_AT
    return {"palm": (REFERENCE_FRAME, (PALM_AT, UPRIGHT)),
            "finger": (REFERENCE_FRAME, (away, UPRIGHT))}


class TwoClocks(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.markers = Log("/contact_monitor/markers", MarkerArray)
        cls.meshes_log = cls.monitor.robot_meshes_log()
        cls.transforms = Transforms()
        cls.publishers = {name: MeshPublisher(name, "/" + name) for name in ("cloth", "sheet")}
        cls.mesh_of = {"cloth": CLOTH, "sheet": SMALL_CLOTH}
        cls.sent = {"cloth": [], "sheet": []}
        cls.tf_stamps = []
        cls.running = {"cloth": True, "sheet": True}
        cls.ended = threading.Event()
        start = rospy.Time.now()
        for step in range(70, 0, -1):  # what the object behind needs
            cls.send_transforms(start - rospy.Duration(PERIOD_S * step))
        cls.feeder = threading.Thread(target=cls.feed)
        cls.feeder.start()
        cls.addClassCleanup(cls.feeder.join)
        cls.addClassCleanup(cls.ended.set)
        for name in cls.sent:
            cls.monitor.contacts.wait(f"contacts of {name}", lambda m, name=name: pairs_of(m) and
                                      m.triggered[m.bodies.index(name)])

    @classmethod
    def send_transforms(cls, stamp):
        cls.transforms.send(stamp, edges(stamp))
        cls.tf_stamps.append(stamp)
        time.sleep(0.002)

    @classmethod
    def feed(cls):
        while not cls.ended.is_set():
            stamp = rospy.Time.now()
            cls.send_transforms(stamp)
            for name, offset in (("cloth", rospy.Duration(0)), ("sheet", BEHIND)):
                if cls.running[name]:
                    cls.sent[name].append(stamp - offset)
                    cls.publishers[name].send(stamp - offset, REFERENCE_FRAME, cls.mesh_of[name])
            cls.ended.wait(PERIOD_S)

    def cycles(self, name):
        """{stamp: pairs} of the complete cycles of an object so far."""
        return {m.header.stamp: pairs_of(m) for m in list(self.monitor.contacts.messages)
                if m.complete and m.triggered == [body == name for body in m.bodies]}

    def test_1_each_object_has_its_cycles_at_its_own_stamps(self):
        time.sleep(2.5)
        robot = self.monitor.robot_meshes(self.meshes_log)
        for name, mesh in self.mesh_of.items():
            cycles = self.cycles(name)
            self.assertGreater(len(cycles), 15, name)
            for stamp in sorted(cycles)[-6::2]:
                self.assertIn(stamp, self.sent[name])
                wanted = boxes_scene.expected(robot, self.transforms, stamp, mesh, name)
                self.assertEqual(cycles[stamp], wanted)

    def test_2_every_state_has_the_stamp_of_its_own_object(self):
        message = self.monitor.states.wait("states", since=self.monitor.states.count() - 1)
        stamps = {(s.body_a, s.body_b): s.stamp for s in message.states}
        self.assertEqual(len(stamps), 4)
        for (_, name), stamp in stamps.items():
            self.assertIn(stamp, self.sent[name])
        lag_s = (stamps["palm", "cloth"] - stamps["palm", "sheet"]).to_sec()
        self.assertLess(abs(lag_s - BEHIND.to_sec()), 1)
        self.assertTrue(message.complete)
        self.assertGreater(message.age.to_sec(), 4.9)

    def test_3_contact_test_goes_by_the_pairs_own_stamps(self):
        both = {name: {"object": name, "state": "contact", "hold_s": 1.0, "within_s": 2.0}
                for name in ("cloth", "sheet")}
        with concurrent.futures.ThreadPoolExecutor(3) as pool:
            running = [pool.submit(run_contact_test, "holds_" + name, parameters)
                       for name, parameters in both.items()]
            fresh = pool.submit(run_contact_test, "fresh", {**both["sheet"], "max_age_s": 2.0})
            for result in running:
                code, failure, output = result.result()
                self.assertEqual((code, failure), (0, ""), output)
            code, failure, output = fresh.result()
            self.assertRegex(failure, r"^too old: .*greatest age [56]\.", output)

    def test_4_markers_of_both_are_there(self):
        since = self.markers.count()
        time.sleep(1)
        messages = self.markers.messages[since:]
        drawn = {m.ns for array in messages for m in array.markers if m.action == Marker.ADD}
        self.assertLessEqual({"palm/cloth", "palm/sheet", "cloth", "sheet"}, drawn)
        deleted = {m.ns for array in messages for m in array.markers if m.action != Marker.ADD}
        self.assertLessEqual(deleted, {"finger/cloth", "finger/sheet"})

    def test_5_evaluate_bag_finds_the_same_pairs(self):
        live = {name: self.cycles(name) for name in self.sent}
        with tempfile.TemporaryDirectory() as folder:
            path, config, out = (os.path.join(folder, n) for n in ("x.bag", "c.yaml", "out"))
            with open(config, "w") as file:
                file.write(CONFIG)
            self.write_bag(path)
            subprocess.run([executable("evaluate_bag"), path, "--config", config, "--out", out,
                            "--pairs", "--no-report", "--backends", "cpu"], check=True, timeout=60)
            found = {}
            with open(os.path.join(out, "pairs.csv"), newline="") as file:
                for row in csv.DictReader(file):
                    found.setdefault(row["stamp"], set()).add(
                        (row["body_a"], int(row["triangle_a"]), row["body_b"],
                         int(row["triangle_b"])))
        for name in self.sent:
            for stamp in sorted(live[name])[-8:]:
                self.assertEqual(found.get(f"{stamp.secs}.{stamp.nsecs:09}", set()),
                                 live[name][stamp])

    def write_bag(self, path):
        received = rospy.Time.now()
        with rosbag.Bag(path, "w") as bag:
            bag.write("/contact_monitor/robot_meshes", self.meshes_log.messages[-1], received)
            for stamp in list(self.tf_stamps):
                bag.write("/tf", transform_message(stamp, edges(stamp)), stamp)
            for name, stamps in self.sent.items():
                offset = BEHIND if name == "sheet" else rospy.Duration(0)
                for stamp in list(stamps):
                    message = mesh_message(name, stamp, REFERENCE_FRAME, self.mesh_of[name])
                    bag.write("/" + name, message, stamp + offset)

    def test_6_what_stops_is_unknown_at_its_own_deadline(self):
        """The sheet is five seconds old when it comes, so it lasts for two more."""
        self.running["sheet"] = False
        time.sleep(0.3)
        last = self.sent["sheet"][-1]
        since = self.monitor.states.count()

        def state(message, name):
            return next(s for s in message.states if (s.body_a, s.body_b) == ("palm", name))
        unknown = self.monitor.states.wait(
            "UNKNOWN", lambda m: state(m, "sheet").state == ContactState.UNKNOWN, since)
        late_s = (state(unknown, "sheet").stamp - last).to_sec() - MAX_MESH_AGE_S
        self.assertGreater(late_s, 0)
        self.assertLess(late_s, 0.5)
        self.assertIn("no new mesh", state(unknown, "sheet").reason)
        self.assertEqual(state(unknown, "cloth").state, ContactState.CONTACT)
        named = self.monitor.states.wait(
            "the object's name", lambda m: state(m, "sheet").reason.startswith("sheet: newest"), since)
        self.assertEqual(state(named, "cloth").state, ContactState.CONTACT)


if __name__ == "__main__":
    rospy.init_node("two_clocks")
    rostest.rosrun(PACKAGE, "two_clocks", TwoClocks, sys.argv)
