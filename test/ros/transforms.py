#!/usr/bin/env python3
"""Sends transforms late or never, and lets the clock jump back. The test publishes the clock."""
import subprocess
import sys
import time
import unittest

import rosgraph
import rospy
import rostest
from rosgraph_msgs.msg import Clock
from rosgraph_msgs.msg import Log as ConsoleLine
from tf2_msgs.msg import TFMessage

import boxes_scene
from boxes_scene import CLOTH, REFERENCE_FRAME, UPRIGHT
from deformable_contact_monitor.msg import ContactEvent
from monitor_test_support import (
    PACKAGE, ContactState, Log, MeshPublisher, Monitor, Transforms, pairs_of, touching,
    transform_message, until_frames_are_seen, wait_until)

UNKNOWN, CONTACT, NONE = ContactState.UNKNOWN, ContactState.CONTACT, ContactState.NONE
STEP_S = 0.05
FINGER_AWAY_AT = (0.3, 0.0, 1.0)  # [m], off the cloth


class TransformTests(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.time_s = 1000.0
        cls.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        cls.monitor = Monitor()
        cls.meshes = cls.monitor.robot_meshes(cls.monitor.robot_meshes_log())
        cls.transforms = Transforms()
        cls.cloth = MeshPublisher("cloth", "/cloth")
        wait_until(lambda: cls.clock.get_num_connections() >= 2, "monitor and test on /clock")

    def setUp(self):
        until_frames_are_seen(lambda: self.good_cycle()[1])

    def tick(self):
        """Moves the clock on and waits until the test sees it; its time."""
        type(self).time_s += STEP_S
        stamp = rospy.Time.from_sec(self.time_s)
        self.clock.publish(Clock(stamp))
        wait_until(lambda: rospy.Time.now() == stamp, "the clock")
        return stamp

    def expected(self, stamp, meshes=None):
        return boxes_scene.expected(meshes or self.meshes, self.transforms, stamp, CLOTH)

    def cycle(self, stamp, frame=REFERENCE_FRAME):
        self.cloth.send(stamp, frame, CLOTH)
        return self.monitor.contacts_at(stamp), self.monitor.states_at(stamp)

    def good_cycle(self):
        stamp = self.tick()
        self.transforms.send(stamp, boxes_scene.edges())
        return (stamp, *self.cycle(stamp))

    def check_good_cycle(self):
        stamp, contacts, states = self.good_cycle()
        self.assertTrue(contacts.complete, contacts.skipped)
        self.assertEqual(pairs_of(contacts), self.expected(stamp))
        self.assertEqual(states, {("palm", "cloth"): CONTACT, ("finger", "cloth"): CONTACT})

    def reason(self, contacts, body):
        reasons = [text for text in contacts.skipped if text.startswith(body + ": ")]
        self.assertEqual(len(reasons), 1, contacts.skipped)
        return reasons[0]

    def test_late_transforms_are_waited_for(self):
        # The machine may be too busy for the monitor's wait to be long enough: then again.
        for attempt in range(8):
            self.check_good_cycle()
            stamp = self.tick()
            self.cloth.send(stamp, REFERENCE_FRAME, CLOTH)
            time.sleep(0.3)  # of wall time, less than tf_timeout_s
            self.assertFalse([m for m in self.monitor.contacts.messages if m.header.stamp == stamp
                              and not m.skipped], "contacts without a transform")
            self.transforms.send(stamp, boxes_scene.edges(finger_at=FINGER_AWAY_AT))
            contacts, states = self.monitor.contacts_at(stamp), self.monitor.states_at(stamp)
            if not contacts.skipped:
                break
        self.assertTrue(contacts.complete, contacts.skipped)
        self.assertEqual(touching(self.expected(stamp)), {"palm"})
        self.assertEqual(pairs_of(contacts), self.expected(stamp))
        self.assertEqual(states, {("palm", "cloth"): CONTACT, ("finger", "cloth"): NONE})

    def test_a_transform_that_stays_away_makes_its_link_unknown(self):
        self.check_good_cycle()
        for _ in range(2):
            stamp = self.tick()
            self.transforms.send(stamp, boxes_scene.edges(links=["palm"]))
            contacts, states = self.cycle(stamp)
            self.assertIn("late", self.reason(contacts, "finger"))
            self.assertFalse(contacts.complete)
            self.assertEqual(states, {("palm", "cloth"): CONTACT, ("finger", "cloth"): UNKNOWN})
            self.assertEqual(pairs_of(contacts),
                             self.expected(stamp, {"palm": self.meshes["palm"]}))
        self.check_good_cycle()

    def test_a_frame_that_never_comes_makes_its_object_unknown(self):
        self.check_good_cycle()
        console = Log("/rosout", ConsoleLine)
        # The warning comes once: who is not connected to the monitor by then misses it.
        publishers = dict(rosgraph.Master(rospy.get_name()).getSystemState()[0])["/rosout"]
        wait_until(lambda: console.subscriber.get_num_connections() >= len(publishers),
                   "all publishers of /rosout")
        def warnings():
            """Those that came up to a further cycle."""
            stamp = self.tick()
            self.transforms.send(stamp, boxes_scene.edges())
            contacts, states = self.cycle(stamp, frame="nowhere")
            self.assertIn("'nowhere' never seen", self.reason(contacts, "cloth"))
            self.assertFalse(contacts.complete)
            self.assertEqual(contacts.pairs, [])
            self.assertEqual(states, {("palm", "cloth"): UNKNOWN, ("finger", "cloth"): UNKNOWN})
            return [m.msg for m in console.messages if m.level == ConsoleLine.WARN
                    and "cloth: TF frame 'nowhere' never seen" in m.msg]
        warnings()
        # It comes a second after the one before, which may be of the start.
        wait_until(warnings, "a warning")
        self.assertIn("known frames: 'base', 'finger', 'lost', 'palm'; "
                      "1 node publishes /tf, nobody publishes /tf_static", warnings()[0])
        self.check_good_cycle()

    def test_a_transform_from_far_ahead_shuts_out_none(self):
        self.check_good_cycle()
        ahead = rospy.Time.from_sec(self.time_s + 3600)
        self.transforms.publisher.publish(transform_message(ahead, boxes_scene.edges()))
        for _ in range(3):
            self.check_good_cycle()

    def test_the_clock_jumps_back(self):
        self.check_good_cycle()
        self.check_good_cycle()
        before = rospy.Time.now()
        events = self.monitor.events.count()
        cycles = self.monitor.contacts.count()
        type(self).time_s -= 400
        self.tick()
        for link in ("palm", "finger"):
            event = self.monitor.events.wait(
                "the end of contacts", since=events,
                wanted=lambda e, link=link: (e.type, e.body_a) == (ContactEvent.END, link))
            self.assertIn("time jump", event.reason)
        # A mesh from before the jump is still under way, then there are new ones.
        self.cloth.send(before, REFERENCE_FRAME, CLOTH)
        until_frames_are_seen(lambda: self.good_cycle()[1])
        for _ in range(3):
            self.check_good_cycle()
        later = self.monitor.contacts.messages[cycles:]
        self.assertFalse([m for m in later if m.header.stamp >= before and m.pairs],
                         "contacts from before the jump")

    def test_the_fixed_frame_of_a_mesh_moves(self):
        self.check_good_cycle()
        static = rospy.Publisher("/tf_static", TFMessage, queue_size=1)
        wait_until(lambda: static.get_num_connections() >= 1, "the monitor on /tf_static")
        here = {"tray": (REFERENCE_FRAME, ((0, 0, 0), UPRIGHT))}
        static.publish(transform_message(rospy.Time(), here))
        both_touch = {("palm", "cloth"): CONTACT, ("finger", "cloth"): CONTACT}
        until_frames_are_seen(lambda: self.cycle_on_the_tray({})[0])
        self.assertEqual(self.cycle_on_the_tray(here)[1], both_touch)  # /tf says the same
        moved = {"tray": (REFERENCE_FRAME, ((0, 0, 1), UPRIGHT))}
        self.cycle_on_the_tray(moved)  # it may come after the mesh
        contacts, states = self.cycle_on_the_tray({})
        self.assertRegex(self.reason(contacts, "cloth"),
                         "'tray' came on /tf_static .* and then on /tf .*restart this node")
        self.assertEqual(set(states.values()), {UNKNOWN})
        self.check_good_cycle()

    def cycle_on_the_tray(self, further_edges):
        stamp = self.tick()
        self.transforms.send(stamp, {**boxes_scene.edges(), **further_edges})
        return self.cycle(stamp, frame="tray")

    def test_two_nodes_put_a_static_frame_at_different_places_until_one_is_killed(self):
        def put_shelf(name, height_m):
            """Starts such a node, which the master does not forget when it is killed."""
            return subprocess.Popen([sys.executable, __file__, "--shelf", name, str(height_m)])
        def states_on_the_shelf():
            stamp = self.tick()
            self.transforms.send(stamp, boxes_scene.edges())
            contacts, states = self.cycle(stamp, frame="shelf")
            return set(states.values()), contacts
        low, high = put_shelf("low_shelf", 0), None
        try:
            wait_until(lambda: states_on_the_shelf()[0] == {CONTACT}, "the shelf")
            high = put_shelf("high_shelf", 1)
            wait_until(lambda: states_on_the_shelf()[0] == {UNKNOWN}, "the contradiction")
            self.assertRegex(self.reason(states_on_the_shelf()[1], "cloth"),
                             "came on /tf_static from /low_shelf and from /high_shelf, which put")
            high.kill()
            wait_until(lambda: states_on_the_shelf()[0] == {CONTACT}, "the other one's place")
        finally:
            for node in filter(None, (low, high)):
                node.kill()
                node.wait()


def publish_shelf(name, height_m):
    """A node that publishes one static frame."""
    rospy.init_node(name)
    publisher = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
    shelf = {"shelf": (REFERENCE_FRAME, ((0, 0, float(height_m)), UPRIGHT))}
    publisher.publish(transform_message(rospy.Time(), shelf))
    rospy.spin()


if __name__ == "__main__":
    if sys.argv[1:2] == ["--shelf"]:
        publish_shelf(*sys.argv[2:])
        sys.exit()
    rospy.init_node("transforms_test")
    rostest.rosrun(PACKAGE, "transforms", TransformTests, sys.argv)
