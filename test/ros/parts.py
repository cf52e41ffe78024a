#!/usr/bin/env python3
"""Checks named parts of a cloth: a hem that the finger holds is ALLOWED, and the rest of the cloth
is not; a half that nobody sees is UNKNOWN, and the other half is not."""
import sys
import unittest

import numpy as np
import rospy
import rostest

import boxes_scene
from deformable_contact import contact_reader
from deformable_contact_monitor.msg import AllowedContact
from deformable_contact_monitor.srv import SetAllowedContacts
from monitor_test_support import (
    PACKAGE, ContactState, MeshPublisher, Monitor, Transforms, now, pairs_of, touching,
    until_frames_are_seen, wait_until)

NONE, CONTACT = ContactState.NONE, ContactState.CONTACT
ALLOWED, UNKNOWN = ContactState.ALLOWED, ContactState.UNKNOWN
MONITORS = ("held", "halves", "rest")
HEM_FROM = 216  # the first triangle of the hem: it begins at x = 0.2 m
IN_THE_REST = (-0.25, 0.0, 0.0)


def without_right_half(mesh):
    """The cloth, of which no vertex of the triangles from 144 on is known."""
    vertices = np.array(mesh[0])
    vertices[7 * 13:] = np.nan
    return vertices, mesh[1]


class Parts(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitors = {name: Monitor("/" + name) for name in MONITORS}
        cls.transforms = Transforms(listeners=len(MONITORS))
        cls.cloth = MeshPublisher("cloth", "/cloth", listeners=len(MONITORS))
        held = cls.monitors["held"]
        cls.meshes = held.robot_meshes(held.robot_meshes_log())
        cls.stamp = None

        def cycle():
            cls.send(boxes_scene.CLOTH)
            all_contacts = [m.contacts_at(cls.stamp) for m in cls.monitors.values()]
            return max(all_contacts, key=lambda contacts: len(contacts.skipped))
        until_frames_are_seen(cycle)

    @classmethod
    def send(cls, mesh, finger_at=boxes_scene.FINGER_AT):
        cls.stamp = now(after=cls.stamp)
        cls.transforms.send(cls.stamp, boxes_scene.edges(finger_at, links=("palm", "finger")))
        cls.cloth.send(cls.stamp, boxes_scene.REFERENCE_FRAME, mesh)

    def states(self, monitor):
        """{"link part": state}, in the order of the message."""
        return {"%s %s" % pair: state
                for pair, state in self.monitors[monitor].states_at(self.stamp).items()}

    def without_held(self, pairs):
        return {pair for pair in pairs if pair[0] != "finger" or pair[3] < HEM_FROM}

    def test_the_rest_of_a_held_cloth_is_watched(self):
        for finger_at, finger in ((boxes_scene.FINGER_AT, NONE), (IN_THE_REST, CONTACT)):
            self.send(boxes_scene.CLOTH, finger_at)
            self.assertEqual(self.states("held"), {
                "palm cloth": CONTACT, "finger cloth": finger, "palm cloth:hem": NONE,
                "finger cloth:hem": ALLOWED})
            every = boxes_scene.expected(self.meshes, self.transforms, self.stamp,
                                         boxes_scene.CLOTH)
            self.assertEqual(touching(every), {"palm", "finger"})
            found = pairs_of(self.monitors["held"].contacts_at(self.stamp))
            self.assertEqual(found, self.without_held(every))

    def test_the_service_changes_what_is_held(self):
        service = rospy.ServiceProxy("/held/set_allowed_contacts", SetAllowedContacts)

        def finger_states():
            self.send(boxes_scene.CLOTH)
            states = self.states("held")
            return states["finger cloth"], states["finger cloth:hem"]
        service(rules=[AllowedContact("finger", "cloth:*", False, "")])
        self.assertEqual(finger_states(), (NONE, ALLOWED))  # the rule of that part is stronger
        service(rules=[AllowedContact("finger", "cloth:hem", False, "")])
        wait_until(lambda: finger_states() == (CONTACT, CONTACT), "a hem that is not held")
        service(rules=[AllowedContact("finger", "cloth:hem", True, "")])
        wait_until(lambda: finger_states() == (NONE, ALLOWED), "a hem that is held")

    def test_a_half_that_is_not_seen_is_unknown(self):
        self.send(boxes_scene.FAR_CLOTH)
        self.assertEqual(set(self.states("halves").values()), {NONE})
        self.send(without_right_half(boxes_scene.FAR_CLOTH))
        for link in ("palm", "finger"):
            halves, rest = self.states("halves"), self.states("rest")
            self.assertEqual(
                [halves[link + " " + name] for name in ("cloth", "cloth:left", "cloth:right")],
                [NONE, NONE, UNKNOWN])
            self.assertEqual([rest[link + " " + name] for name in ("cloth", "cloth:left")],
                             [UNKNOWN, NONE])
        self.expect_reasons()

        self.send(without_right_half(boxes_scene.CLOTH))
        halves = self.states("halves")
        self.assertEqual([halves["palm " + name] for name in ("cloth", "cloth:left")],
                         [CONTACT, CONTACT])
        self.assertEqual(halves["palm cloth:right"], UNKNOWN)

    def expect_reasons(self):
        """The reader forbids to move the cloth because of its part, and names that."""
        message = self.monitors["halves"].states.wait(
            "the states", lambda m: m.header.stamp == self.stamp)
        reader = contact_reader.ContactReader(max_age_s=60.0)
        reader.store(message, rospy.Time.now())
        because = ("palm and cloth:right: UNKNOWN: cloth:right: 144 of 144 triangles have a vertex "
                   "that is not finite (tolerated_rejects)")
        for body in ("cloth", "cloth:right", "palm"):
            self.assertEqual(reader.may_move(body, rospy.Time.now()).because, because)
        self.assertEqual(reader.may_move("cloth:left", rospy.Time.now()).because, "")


if __name__ == "__main__":
    rospy.init_node("parts_test")
    rostest.rosrun(PACKAGE, "parts", Parts, sys.argv)
