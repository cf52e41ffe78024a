#!/usr/bin/env python3
"""Checks bodies inside others: what is inside a closed surface is a contact that says so. An open
surface contains nothing, and the diagnostics name it."""
import sys
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray

import boxes_scene
from monitor_test_support import (
    PACKAGE, ContactEvent, ContactState, Log, MeshPublisher, Monitor, Transforms, now,
    until_frames_are_seen)

NONE, CONTACT = ContactState.NONE, ContactState.CONTACT
CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float32)
SIDES = [(0, 2, 1), (1, 2, 3), (4, 5, 6), (5, 7, 6), (0, 1, 4), (1, 5, 4), (2, 6, 3), (3, 6, 7),
         (0, 4, 2), (2, 4, 6), (1, 3, 5), (3, 7, 5)]


def box(center, half_sides, sides=12):
    """A box of so many of its twelve triangles [m]."""
    vertices = np.array(center, np.float32) + CORNERS * np.array(half_sides, np.float32)
    return vertices, np.array(SIDES[:sides], np.uint32)


WITHIN_THE_PALM = box(boxes_scene.PALM_AT, (0.02, 0.02, 0.02))
AROUND_THE_FINGER = box(boxes_scene.FINGER_AT, (0.1, 0.1, 0.2))
OPEN_AROUND_THE_FINGER = box(boxes_scene.FINGER_AT, (0.1, 0.1, 0.2), sides=11)
APART = box((0.0, 0.0, 5.0), (0.1, 0.1, 0.1))


class Containment(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.diagnostics = Log("/diagnostics", DiagnosticArray)
        cls.transforms = Transforms()
        cls.parcel = MeshPublisher("parcel", "/parcel")
        cls.stamp, cls.topology_id = None, 0
        until_frames_are_seen(lambda: cls.send(APART))

    @classmethod
    def send(cls, mesh):
        cls.stamp = now(after=cls.stamp)
        cls.topology_id += 1
        cls.transforms.send(cls.stamp, boxes_scene.edges(links=("palm", "finger")))
        cls.parcel.send(cls.stamp, boxes_scene.REFERENCE_FRAME, mesh,
                        topology_id=cls.topology_id)
        return cls.monitor.contacts_at(cls.stamp)

    def states(self, mesh):
        """{link: its state with the parcel} of a cycle with that mesh."""
        contacts = self.send(mesh)
        self.assertEqual(contacts.pairs, [])
        message = self.monitor.states.wait(
            "its states", lambda m: m.header.stamp == self.stamp and m.cycle == contacts.cycle)
        return {state.body_a: state for state in message.states}

    def wait_for_open_bodies(self, text):
        def says(message):
            return any(value.key == "not closed" and value.value == text
                       for status in message.status for value in status.values)
        self.diagnostics.wait(f"'{text}'", says, since=self.diagnostics.count())

    def test_an_object_within_a_link(self):
        since = self.monitor.events.count()
        states = self.states(WITHIN_THE_PALM)
        palm, finger = states["palm"], states["finger"]
        self.assertEqual((palm.state, palm.inside), (CONTACT, 2))
        self.assertEqual((palm.pair_count, palm.min_separation), (0, 0.0))
        self.assertLess(abs(palm.centroid.x) + abs(palm.centroid.y) + abs(palm.centroid.z), 0.06)
        self.assertEqual((finger.state, finger.inside), (NONE, 0))
        for kind in (ContactEvent.BEGIN, ContactEvent.END):
            self.monitor.events.wait("an event of the palm", lambda e, kind=kind:
                                     (e.type, e.body_a, e.pair_count) == (kind, "palm", 0), since)
            for _ in range(2):  # debounced
                self.assertEqual(self.states(APART)["palm"].state, NONE)

    def test_a_link_within_an_object_while_that_is_closed(self):
        finger = self.states(AROUND_THE_FINGER)["finger"]
        self.assertEqual((finger.state, finger.inside), (CONTACT, 1))
        self.assertAlmostEqual(finger.centroid.x, boxes_scene.FINGER_AT[0], delta=0.03)
        self.wait_for_open_bodies("")

        finger = self.states(OPEN_AROUND_THE_FINGER)["finger"]
        self.assertEqual((finger.state, finger.inside), (NONE, 0))
        self.wait_for_open_bodies("parcel (1 of 1 parts)")

        finger = self.states(AROUND_THE_FINGER)["finger"]
        self.assertEqual((finger.state, finger.inside), (CONTACT, 1))
        self.wait_for_open_bodies("")


if __name__ == "__main__":
    rospy.init_node("containment_test")
    rostest.rosrun(PACKAGE, "containment", Containment, sys.argv)
