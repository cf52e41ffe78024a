#!/usr/bin/env python3
"""Checks ~attach_object with a radius: a finger holds a corner of a cloth and moves it into the
palm. The palm's contact is reported, and so is a contact of the finger with the rest of the cloth,
while the corner may touch the finger. A mesh with other triangles ends it."""
import sys
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from visualization_msgs.msg import MarkerArray

import boxes_scene
from deformable_contact_monitor.srv import AttachObject
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, MeshPublisher, Monitor, Transforms, now, pairs_of, touching,
    until_frames_are_seen, wait_until)

NONE, CONTACT, ALLOWED = ContactState.NONE, ContactState.CONTACT, ContactState.ALLOWED
CORNER_AT = (0.35, 0.0, 0.0)  # where the finger is when it takes hold of the cloth
IN_THE_PALM = (0.08, 0.0, 0.0)
RADIUS = 0.03  # [m]


def cloth_from(corner_at, cloth=boxes_scene.CLOTH):
    """The cloth, moved so that its first corner is a little inside the finger that is there."""
    vertices, triangles = cloth
    shift = np.array(corner_at) - vertices[0] - (0.015, 0.015, 0.0)
    return (vertices + shift).astype(np.float32), triangles


class HeldPart(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.diagnostics = Log("/diagnostics", DiagnosticArray)
        rospy.wait_for_service("/contact_monitor/attach_object", WAIT_S)
        cls.attach = rospy.ServiceProxy("/contact_monitor/attach_object", AttachObject)
        cls.transforms = Transforms()
        cls.cloth = MeshPublisher("cloth", "/cloth")
        cls.meshes = cls.monitor.robot_meshes(cls.monitor.robot_meshes_log())
        cls.meshes.pop("lost", None)
        cls.stamp = None

        def cycle():
            cls.send(CORNER_AT)
            return cls.monitor.contacts_at(cls.stamp)
        until_frames_are_seen(cycle)

    def setUp(self):
        self.assertTrue(self.attach(object="cloth").success)

    @classmethod
    def send(cls, finger_at, corner_at=None, cloth=boxes_scene.CLOTH, **arguments):
        """Moves the finger, and the cloth with it or to a place of its own."""
        cls.mesh = cloth_from(finger_at if corner_at is None else corner_at, cloth)
        cls.stamp = now(after=cls.stamp)
        cls.transforms.send(cls.stamp, boxes_scene.edges(finger_at))
        cls.cloth.send(cls.stamp, boxes_scene.REFERENCE_FRAME, cls.mesh, **arguments)

    def states(self):
        """{"link part": state} of the last cycle, without the link that has no mesh."""
        states = self.monitor.states_at(self.stamp).items()
        return {"%s %s" % (link, other): state for (link, other), state in states
                if link != "lost" and other != "rope" and other != "rope:held"}

    def hold(self):
        self.send(CORNER_AT)
        self.assertEqual(self.states(), {"palm cloth": NONE, "finger cloth": CONTACT})
        answer = self.attach("cloth", ["finger"], RADIUS)
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.message,
                         "held: %d triangles of cloth by finger" % answer.held_triangles)
        return answer.held_triangles

    def found_and_expected(self):
        found = pairs_of(self.monitor.contacts_at(self.stamp))
        return found, boxes_scene.expected(self.meshes, self.transforms, self.stamp, self.mesh)

    def test_the_finger_moves_what_it_holds_into_the_palm(self):
        count = self.hold()
        self.send(CORNER_AT)
        self.assertEqual(self.states(), {
            "palm cloth": NONE, "finger cloth": NONE, "palm cloth:held": NONE,
            "finger cloth:held": ALLOWED})
        found, every = self.found_and_expected()
        self.assertEqual(found, set())
        corner = {triangle for _, _, _, triangle in every}
        self.assertLessEqual(len(corner), count)
        self.assertLess(count, len(self.mesh[1]) / 10)

        self.send(IN_THE_PALM)
        self.assertEqual(self.states(), {
            "palm cloth": CONTACT, "finger cloth": NONE, "palm cloth:held": CONTACT,
            "finger cloth:held": ALLOWED})
        found, every = self.found_and_expected()
        self.assertEqual(found, {pair for pair in every if pair[0] == "palm"})
        self.assertEqual(touching(every), {"palm", "finger"})
        markers = Log("/contact_monitor/markers", MarkerArray)
        wait_until(lambda: self.send(CORNER_AT) or self.held_markers(markers),
                   "a held corner in rviz")
        markers.subscriber.unregister()

    def held_markers(self, log):
        self.monitor.contacts_at(self.stamp)
        return [marker for message in list(log.messages) for marker in message.markers
                if marker.ns == "held: cloth" and marker.points]

    def test_the_rest_is_watched_against_the_finger(self):
        self.hold()
        self.send(CORNER_AT, corner_at=(0.0, -0.4, 0.0))
        self.assertEqual(self.states(), {
            "palm cloth": CONTACT, "finger cloth": CONTACT, "palm cloth:held": NONE,
            "finger cloth:held": ALLOWED})
        found, every = self.found_and_expected()
        self.assertEqual(found, every)

    def test_other_triangles_end_it(self):
        self.hold()
        self.send(CORNER_AT, topology_id=2)  # the same triangles
        self.assertEqual(self.states()["finger cloth"], NONE)
        self.send(CORNER_AT, cloth=boxes_scene.SMALL_CLOTH, topology_id=3)
        self.assertEqual(self.states(), {"palm cloth": NONE, "finger cloth": CONTACT})
        status = next(s for s in self.diagnostics.wait(
            "the end of the hold", self.tells_the_end, self.diagnostics.count()).status
            if s.name.endswith(": allowed"))
        self.assertEqual(status.level, DiagnosticStatus.WARN)
        self.send(CORNER_AT, topology_id=4)
        self.assertEqual(self.states(), {"palm cloth": NONE, "finger cloth": CONTACT})
        self.assertEqual(self.attach(object="cloth").message, "nothing is held")

    def tells_the_end(self, message):
        return any("no longer held" in status.message and "other triangles" in status.message
                   for status in message.status if status.name.endswith(": allowed"))

    def test_what_cannot_be_held_is_refused_by_name(self):
        self.send(CORNER_AT)
        self.states()
        for links, radius, reason, name in (
                (["finger"], float("nan"), "must be a finite number", "cloth"),
                (["finger"], -0.01, "must be a finite number", "cloth"),
                (["finger"], float("inf"), "must be a finite number", "cloth"),
                (["finger", "lost"], RADIUS, "lost: ", "cloth"),
                (["base"], RADIUS, "them: base", "cloth"),
                (["palm"], RADIUS, "no triangle of cloth lies within 0.03 m of palm", "cloth"),
                (["finger"], RADIUS, "rope: no mesh yet", "rope")):
            answer = self.attach(name, links, radius)
            self.assertFalse(answer.success)
            self.assertIn(reason, answer.message)
            self.assertEqual(answer.held_triangles, 0)
        stamp = now(after=self.stamp)  # for which nobody knows where the links are
        self.cloth.send(stamp, boxes_scene.REFERENCE_FRAME, self.mesh)
        wait_until(lambda: "finger: " in self.attach("cloth", ["finger"], RADIUS).message,
                   "a refusal without a transform")
        self.setUp()  # lets go: before that mesh came, the finger took hold of the one before

        def is_known():  # a mesh does not wait for a transform that others waited for in vain
            self.send(CORNER_AT)
            return self.states() == {"palm cloth": NONE, "finger cloth": CONTACT}
        wait_until(is_known, "the states without a hold")


if __name__ == "__main__":
    rospy.init_node("held_part_test")
    rostest.rosrun(PACKAGE, "held_part", HeldPart, sys.argv)
