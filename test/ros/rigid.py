#!/usr/bin/env python3
"""Checks rigid objects: a table that a cloth touches where the oracle says so, which moves with its
TF frame, or with the link that it is attached to; and a clamp that holds the cloth."""
import pathlib
import sys
import unittest

import numpy as np
import rospy
import rostest
from dynamic_reconfigure.srv import Reconfigure, ReconfigureRequest
from dynamic_reconfigure.msg import BoolParameter
from visualization_msgs.msg import MarkerArray

import boxes_scene
from boxes_scene import FINGER_AT, PALM_AT, UPRIGHT
from deformable_contact_monitor.msg import ContactArray
from deformable_contact_monitor.srv import AttachObject
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, MeshPublisher, Monitor, Transforms, now, oracle_pairs,
    pairs_of, touching, wait_until)
from pose_meshes import posed, read_obj

NONE, CONTACT, ALLOWED, UNKNOWN = (
    ContactState.NONE, ContactState.CONTACT, ContactState.ALLOWED, ContactState.UNKNOWN)
# The box as src/robot/primitives.cpp has it: bits 0, 1, 2 of a corner are the side of x, y, z.
CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float64)
TABLE = ((CORNERS * np.array([0.5, 0.5, 0.0625]) / 2).astype(np.float32),
         np.array([(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
                   (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)], np.uint32))
CLAMP = read_obj(pathlib.Path(__file__).with_name("box.obj"), 0.5)
# Sums of powers of two, so that poses that are put together are exact.
UNDER_THE_CLOTH, AWAY = (1.0, 0.25, -0.03125), (1.0, 0.25, -2.0)
CLAMP_AT = (-3.0, 0.0, 0.0)
TURNED = (0.0, 0.0, 0.6, 0.8)


def cloth_at(x):
    vertices, triangles = boxes_scene.CLOTH
    return (vertices + np.array([x, 0.0, 0.0])).astype(np.float32), triangles


class Rigid(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        rospy.wait_for_service("/contact_monitor/attach_object", WAIT_S)
        cls.attach = rospy.ServiceProxy("/contact_monitor/attach_object", AttachObject)
        cls.transforms = Transforms()
        cls.cloth = MeshPublisher("cloth", "/cloth")
        cls.meshes = cls.monitor.robot_meshes(cls.monitor.robot_meshes_log())
        cls.meshes.update(table=TABLE, clamp=CLAMP)
        cls.stamp = None

        def seen():
            cls.send()
            return not any("never seen" in text for text in cls.contacts().skipped)
        wait_until(seen, "all frames")

    def setUp(self):
        for name in ("table", "cloth"):
            self.assertTrue(self.attach(object=name).success)

    @classmethod
    def send(cls, table=(UNDER_THE_CLOTH, UPRIGHT), finger_at=FINGER_AT, clamp_at=CLAMP_AT,
             cloth=cloth_at(1.0), carried_table=None):
        """One stamp of the scene. `carried_table`: where the table is if a link carries it."""
        cls.stamp = now(after=cls.stamp)
        edges = boxes_scene.edges(finger_at, ("palm", "finger"))
        edges["clamp"] = ("base", (clamp_at, UPRIGHT))
        if table is not None:
            edges["table_top"] = ("base", table)
        cls.transforms.send(cls.stamp, edges)
        cls.mesh = cloth
        cls.poses = {"palm": (PALM_AT, UPRIGHT), "finger": (finger_at, UPRIGHT),
                     "clamp": (clamp_at, UPRIGHT), "table": carried_table or table}
        cls.cloth.send(cls.stamp, boxes_scene.REFERENCE_FRAME, cloth)

    @classmethod
    def contacts(cls):
        """The cloth's cycle; the robot's own may have the same stamp."""
        def is_cloths(message):
            return message.header.stamp == cls.stamp and message.triggered[-1]
        return cls.monitor.contacts.wait(f"the cloth's contacts at {cls.stamp}", is_cloths)

    def expected(self):
        bodies = {name: posed(self.meshes[name], pose) for name, pose in self.poses.items()}
        return oracle_pairs(bodies, "cloth", self.mesh)

    def assert_states(self, **expected):
        """Waits until the pairs, as `table_cloth`, have these states, of this stamp or later."""
        def has_all(message):
            found = {f"{s.body_a}_{s.body_b}".replace(":", "_"): s.state for s in message.states
                     if s.stamp >= self.stamp}
            return all(found.get(pair) == state for pair, state in expected.items())
        self.monitor.states.wait(f"{expected} at {self.stamp}", has_all)

    def assert_oracle_pairs(self):
        contacts = self.contacts()
        expected = self.expected()
        self.assertEqual(pairs_of(contacts), expected)
        self.assertTrue(contacts.complete, contacts.skipped)
        return touching(expected)

    def test_the_cloth_touches_the_table_where_the_oracle_says(self):
        self.send()
        self.assertEqual(self.assert_oracle_pairs(), {"table"})
        contacts = self.contacts()
        self.assertEqual(contacts.bodies, ["palm", "finger", "table", "clamp", "cloth"])
        link, rigid, deformable = ContactArray.LINK, ContactArray.RIGID, ContactArray.DEFORMABLE
        self.assertEqual(list(contacts.body_kind), [link, link, rigid, rigid, deformable])
        self.assertEqual(contacts.body_stamps[2], self.stamp)
        self.assert_states(table_cloth=CONTACT, clamp_cloth=NONE, palm_cloth=NONE)
        self.send(clamp_at=(1.375, 0.0, 0.0))
        self.assertEqual(self.assert_oracle_pairs(), {"table", "clamp"})

    def test_it_moves_with_its_frame(self):
        self.send(table=(AWAY, UPRIGHT))
        self.assertEqual(self.assert_oracle_pairs(), set())
        self.assert_states(table_cloth=NONE)
        self.send(table=((1.25, 0.125, 0.0), TURNED))
        self.assertEqual(self.assert_oracle_pairs(), {"table"})

    def test_without_its_transform_it_is_unknown(self):
        self.send(table=None)
        self.assert_states(table_cloth=UNKNOWN, palm_cloth=NONE)
        (skipped,) = self.contacts().skipped
        self.assertTrue(skipped.startswith("table: TF from 'table_top' to 'base'"), skipped)

        def is_known():  # a mesh does not wait for a transform that others waited for in vain
            self.send()
            return not self.contacts().skipped
        wait_until(is_known, "the table's transform")

    def test_links_touch_it_in_cycles_of_the_robot(self):
        self.send(table=((0.0, 0.0, 0.0), UPRIGHT), cloth=cloth_at(5.0))
        self.assert_states(palm_table=CONTACT, finger_table=NONE)
        self.send(table=(AWAY, UPRIGHT), cloth=cloth_at(5.0))
        self.assert_states(palm_table=NONE, finger_table=NONE)

    def test_a_link_carries_it(self):
        start = (1.0, 0.25, -0.5)  # of the finger
        self.send(finger_at=start)
        self.assertEqual(self.assert_oracle_pairs(), {"table"})
        answer = self.attach(object="table", links=["finger", "palm"])
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.message, "held: table by finger, palm")
        self.send(table=(AWAY, UPRIGHT), finger_at=start, carried_table=(UNDER_THE_CLOTH, UPRIGHT))
        self.assertEqual(self.assert_oracle_pairs(), {"table"})
        self.assert_states(finger_table=ALLOWED, palm_table=ALLOWED)
        way = np.array([0.25, 0.125, 0.015625])
        moved = tuple(start + way)
        self.send(table=None, finger_at=moved,
                  carried_table=(tuple(UNDER_THE_CLOTH + way), UPRIGHT))
        self.assertEqual(self.assert_oracle_pairs(), {"table"})
        self.assertTrue(self.attach(object="table").success)
        self.send(table=(AWAY, UPRIGHT), finger_at=moved)
        self.assertEqual(self.assert_oracle_pairs(), set())
        self.assert_states(finger_table=NONE, palm_table=NONE)
        self.send(finger_at=moved)
        self.contacts()
        self.assertTrue(self.attach(object="table", links=["palm", "finger"]).success)
        self.send(table=None, carried_table=(UNDER_THE_CLOTH, UPRIGHT))
        self.assertEqual(self.assert_oracle_pairs(), {"table"}, "the palm carries it, which stands")

    def test_it_holds_the_cloth(self):
        at = (1.375, 0.0, 0.0)
        self.send(clamp_at=at)
        self.assert_states(clamp_cloth=CONTACT)
        answer = self.attach("cloth", ["clamp"], 0.03)
        self.assertTrue(answer.success, answer.message)
        self.assertGreater(answer.held_triangles, 0)
        self.send(clamp_at=at)
        self.assert_states(clamp_cloth=NONE, clamp_cloth_held=ALLOWED, table_cloth=CONTACT)
        self.assertTrue(self.attach(object="cloth", links=["clamp"]).success)
        self.send(clamp_at=at)
        self.assert_states(clamp_cloth=ALLOWED)
        self.assertEqual({pair for pair in self.expected() if pair[0] != "clamp"},
                         pairs_of(self.contacts()))

    def test_what_cannot_be_held_is_refused_by_name(self):
        self.send()
        self.contacts()
        for links, radius, reason in (
                (["finger"], 0.02, "a radius is not supported for 'table', which is rigid"),
                (["clamp"], 0.0, "'clamp' is rigid as 'table' is, and only links hold"),
                (["fingr"], 0.0, "the robot has no link 'fingr' (did you mean 'finger'?)")):
            answer = self.attach("table", links, radius)
            self.assertFalse(answer.success)
            self.assertEqual(answer.message[:len(reason)], reason)

    def test_it_is_drawn_and_may_be_switched_off(self):
        markers = Log("/contact_monitor/markers", MarkerArray)

        def drawn():
            self.send()
            self.contacts()
            return any(marker.ns == "table" and marker.points
                       for message in list(markers.messages) for marker in message.markers)
        wait_until(drawn, "the table's surface in rviz")
        markers.subscriber.unregister()

        change = rospy.ServiceProxy("/contact_monitor/set_parameters", Reconfigure)
        for is_on in (False, True):
            request = ReconfigureRequest()
            request.config.bools = [BoolParameter("deformable_rigid", is_on)]
            change(request)

            def matches(is_on=is_on):
                self.send()
                return (self.contacts().body_stamps[2] == self.stamp) == is_on
            wait_until(matches, f"deformable_rigid: {is_on}")
            self.assertEqual(pairs_of(self.contacts()), self.expected() if is_on else set())


if __name__ == "__main__":
    rospy.init_node("rigid_test")
    rostest.rosrun(PACKAGE, "rigid", Rigid, sys.argv)
