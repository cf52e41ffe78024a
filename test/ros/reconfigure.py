#!/usr/bin/env python3
"""Changes margins, pair classes and rates while the monitor runs, as rqt_reconfigure would."""
import math
import subprocess
import sys
import threading
import time
import unittest

import rospy
import rostest
from dynamic_reconfigure.client import Client

import boxes_scene
from boxes_scene import REFERENCE_FRAME
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactEvent, ContactState, MeshPublisher, Monitor, Transforms, grid, now)

PALM, FINGER, CLOTH = "palm", "finger", "cloth"
NEAR_M = 0.03  # of the cloth above palm and finger
START = {"margin_m": 0.01, "near_pairs": False, "max_rate_hz": 0.0, "robot_deformable": True, "robot_self": True,
         "deformable_self": False, "deformable_deformable": False, "predicates": "exact",
         "overlap": 1.0, "clusters": 5, "iterations": 1, "refresh_period": 1,
         "robot_rate_hz": 30.0, "marker_rate_hz": 10.0}


class Reconfigure(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.transforms = Transforms()
        cls.cloth = MeshPublisher(CLOTH, "/cloth")
        cls.client = Client("/contact_monitor", timeout=WAIT_S)
        cls.start = cls.client.get_configuration(timeout=WAIT_S)
        cls.height_m = 0.15 + NEAR_M
        cls.stopped = threading.Event()
        cls.thread = threading.Thread(target=cls.play)
        cls.thread.start()

    @classmethod
    def tearDownClass(cls):
        cls.stopped.set()
        cls.thread.join()

    @classmethod
    def play(cls):
        """A flat cloth over the finger, whose top is the highest there is."""
        while not cls.stopped.is_set():
            stamp = now()
            vertices, triangles = grid(6, 0.8)
            vertices[:, 2] = cls.height_m
            cls.transforms.send(stamp, boxes_scene.edges())
            cls.cloth.send(stamp, REFERENCE_FRAME, (vertices, triangles))
            time.sleep(0.03)

    def tearDown(self):
        type(self).height_m = 0.15 + NEAR_M
        self.client.update_configuration(START)

    def change(self, **values):
        """What holds then."""
        return self.client.update_configuration(values)

    def wait_for(self, condition, what):
        """The first states from now on, {(body_a, body_b): ContactState}, of which it holds."""
        def states(message):
            return {(s.body_a, s.body_b): s for s in message.states}
        return states(self.monitor.states.wait(what, lambda m: condition(states(m)),
                                               self.monitor.states.count()))

    def wait_for_state(self, state, what, pair=(FINGER, CLOTH)):
        return self.wait_for(lambda s: pair in s and s[pair].state == state, what)[pair]

    def test_the_start_values_are_the_parameters(self):
        self.assertEqual({key: self.start[key] for key in START}, START)
        for key in ("margin_m", "clusters", "overlap"):
            self.assertEqual(rospy.get_param(f"/contact_monitor/{key}"), START[key])
        self.assertEqual(rospy.get_param("/contact_monitor/pair_classes"),
                         ["robot_deformable", "robot_self"])

    def test_numbers_with_an_exponent(self):
        """YAML 1.1 takes 1e-1 for a text, and controllers read margins as numbers."""
        self.assertEqual(rospy.get_param("/contact_monitor/link_margin_m"), {"palm": 0.1})
        subprocess.run(["rosrun", "dynamic_reconfigure", "dynparam", "set", "/contact_monitor",
                        "margin_m", "6e-2"], check=True, timeout=WAIT_S)
        self.wait_for_state(ContactState.NEAR, "the cloth near the finger")
        self.assertEqual(rospy.get_param("/contact_monitor/margin_m"), 0.06)

    def test_a_margin_makes_near_of_none_and_never_contact(self):
        self.wait_for_state(ContactState.NONE, "nothing near")
        since = self.monitor.states.count()
        self.assertEqual(self.change(margin_m=2 * NEAR_M)["margin_m"], 2 * NEAR_M)
        state = self.wait_for_state(ContactState.NEAR, "the cloth near the finger")
        self.assertAlmostEqual(state.min_separation, NEAR_M, 5)
        self.wait_for_state(ContactState.NONE, "the palm farther off", (PALM, CLOTH))
        self.change(margin_m=0.0)
        self.wait_for_state(ContactState.NONE, "nothing near again")
        with self.monitor.states.condition:
            seen = {s.state for m in self.monitor.states.messages[since:] for s in m.states}
        self.assertNotIn(ContactState.CONTACT, seen)

    def test_a_margin_of_its_own_stays(self):
        """The palm's: 0.1 m."""
        type(self).height_m = 0.14
        self.wait_for_state(ContactState.NEAR, "the cloth near the palm", (PALM, CLOTH))
        self.change(margin_m=0.0)
        self.wait_for_state(ContactState.NEAR, "the palm's own margin", (PALM, CLOTH))
        self.change(margin_m=0.5)
        self.wait_for_state(ContactState.NEAR, "all of them near", (PALM, FINGER))

    def test_far_away_is_near_with_points_and_without_a_list(self):
        self.change(margin_m=10.0)
        state = self.wait_for_state(ContactState.NEAR, "the finger's distance")
        self.assertAlmostEqual(state.min_separation, NEAR_M, 6)
        self.assertAlmostEqual(state.distance_low, NEAR_M, 6)
        self.assertAlmostEqual(state.point_a.z, 0.15, 6)
        self.assertAlmostEqual(state.point_b.z, 0.15 + NEAR_M, 6)
        self.assertEqual((state.point_a.x, state.point_a.y), (state.point_b.x, state.point_b.y))
        self.assertAlmostEqual(state.normal.z, 1, 6)
        self.assertEqual(state.pair_count, 0)
        self.wait_for_state(ContactState.NEAR, "the palm's distance", (PALM, CLOTH))
        contacts = self.monitor.contacts.wait(
            "the cloth's cycle", lambda m: m.triggered[m.bodies.index(CLOTH)],
            self.monitor.contacts.count())
        self.assertEqual((len(contacts.pairs), contacts.pair_count), (0, 0))
        nearest = {(contacts.bodies[n.body_a], contacts.bodies[n.body_b]): n
                   for n in contacts.nearest}
        self.assertEqual(nearest[FINGER, CLOTH].distance, state.min_separation)
        self.assertEqual(nearest[FINGER, CLOTH].point_b.z, state.point_b.z)

        self.change(near_pairs=True)
        state = self.wait_for(lambda s: s[FINGER, CLOTH].pair_count > 0, "a list")[FINGER, CLOTH]
        self.assertEqual(state.state, ContactState.NEAR)
        self.assertEqual(state.min_separation, nearest[FINGER, CLOTH].distance)
        contacts = self.monitor.contacts.wait("near pairs", lambda m: len(m.pairs) > 100,
                                              self.monitor.contacts.count())
        self.assertEqual(contacts.pair_count, len(contacts.pairs))

    def test_classes_are_switched_on_and_off(self):
        since = self.monitor.events.count()
        type(self).height_m = 0.1
        self.monitor.events.wait("contact", lambda e: e.type == ContactEvent.BEGIN, since)
        since = self.monitor.events.count(), self.monitor.states.count()
        held = self.change(robot_deformable=False, robot_self=False, deformable_self=True)
        self.assertEqual((held["robot_deformable"], held["deformable_self"]), (False, True))
        self.wait_for(lambda s: set(s) == {(CLOTH, CLOTH)}
                      and s[CLOTH, CLOTH].state == ContactState.NONE, "the cloth with itself alone")
        event = self.monitor.events.wait("the contact's end", since=since[0])
        self.assertEqual((event.type, event.reason, event.body_a),
                         (ContactEvent.END, "no longer monitored", FINGER))
        with self.monitor.states.condition:
            first = next(s for m in self.monitor.states.messages[since[1]:] for s in m.states
                         if s.body_a == CLOTH)
        self.assertEqual((first.state, first.reason),
                         (ContactState.UNKNOWN, "not looked at yet"))
        self.assertEqual(rospy.get_param("/contact_monitor/pair_classes"), ["deformable_self"])

        self.change(robot_deformable=True, robot_self=True, deformable_self=False)
        pairs = {(PALM, FINGER), (PALM, CLOTH), (FINGER, CLOTH)}
        self.wait_for(lambda s: set(s) == pairs and ContactState.UNKNOWN not in {
            state.state for state in s.values()}, "links with cloth and links again")

    def test_what_cannot_be_used_is_answered_by_what_holds(self):
        held = self.change(margin_m=50.0, overlap=-1.0, clusters=1 << 20, refresh_period=0)
        self.assertEqual((held["margin_m"], held["overlap"], held["clusters"],
                          held["refresh_period"]), (10.0, 0.0, 65535, 1))
        self.change(**START)
        held = self.change(margin_m=math.nan, predicates="sloppy", iterations=3)
        self.assertEqual((held["margin_m"], held["predicates"], held["iterations"]),
                         (START["margin_m"], "exact", 3))
        self.wait_for_state(ContactState.NONE, "that it goes on")

    def test_a_rate_holds_at_once(self):
        self.change(max_rate_hz=2.0)
        contacts = self.monitor.contacts
        def cycles_within(seconds):
            first = contacts.count()
            time.sleep(seconds)
            with contacts.condition:
                return sum(any(t and b == CLOTH for t, b in zip(m.triggered, m.bodies))
                           for m in contacts.messages[first:])
        self.assertLessEqual(cycles_within(2), 6)
        self.change(max_rate_hz=0.0)
        deadline = time.monotonic() + WAIT_S
        while cycles_within(2) < 8:
            self.assertLess(time.monotonic(), deadline, "the rate stays low")


if __name__ == "__main__":
    rospy.init_node("reconfigure_test")
    rostest.rosrun(PACKAGE, "reconfigure", Reconfigure, sys.argv)
