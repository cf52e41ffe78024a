#!/usr/bin/env python3
"""Checks the contact patches: they are published while somebody subscribes, also when there are
none, and have ids that persist, and markers."""
import math
import sys
import unittest

import rospy
import rostest
from visualization_msgs.msg import Marker, MarkerArray

import boxes_scene
from boxes_scene import CLOTH, FAR_CLOTH
from deformable_contact_monitor.msg import ContactPatches
from monitor_test_support import (
    PACKAGE, Log, MeshPublisher, Monitor, Transforms, now, pairs_of, until_frames_are_seen,
    wait_until)

NAMES = ("palm", "finger")


class Patches(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.transforms = Transforms()
        cls.cloth = MeshPublisher("cloth", "/cloth")
        cls.stamp = None
        until_frames_are_seen(lambda: cls.send(FAR_CLOTH))

    @classmethod
    def send(cls, mesh):
        cls.stamp = now(after=cls.stamp)
        cls.transforms.send(cls.stamp, boxes_scene.edges(links=NAMES))
        cls.cloth.send(cls.stamp, boxes_scene.REFERENCE_FRAME, mesh)
        return cls.monitor.contacts_at(cls.stamp)

    def patches(self, log, mesh):
        """The contacts of a cycle and its patches."""
        contacts = self.send(mesh)
        self.assertEqual(contacts.geometry, [], "nobody asked for it on ~contacts")
        return contacts, log.wait("its patches", lambda m: m.header.stamp == self.stamp)

    def check(self, contacts, message):
        self.assertEqual(message.header.frame_id, boxes_scene.REFERENCE_FRAME)
        self.assertEqual(message.cycle, contacts.cycle)
        pairs = pairs_of(contacts)
        self.assertEqual(sum(patch.pair_count for patch in message.patches), len(pairs))
        for name in NAMES:
            of_name = [patch for patch in message.patches if patch.body_a == name]
            self.assertTrue(of_name)
            for side, place in (("triangles_a", 1), ("triangles_b", 3)):
                listed = [t for patch in of_name for t in getattr(patch, side)]
                self.assertEqual(len(listed), len(set(listed)), "in two patches")
                self.assertEqual(set(listed), {pair[place] for pair in pairs if pair[0] == name})
        for patch in message.patches:
            self.assertEqual((patch.body_b, patch.stamp), ("cloth", self.stamp))
            self.assertTrue(0 < patch.curve_length < 2, patch.curve_length)
            self.assertTrue(patch.area_a > 0 and patch.area_b > 0)
            self.assertLessEqual(patch.min_separation, 0)
            self.assertLess(math.hypot(patch.centroid.x - 0.15, patch.centroid.y), 0.3)

    def test_patches_while_somebody_listens(self):
        log = Log("/contact_monitor/contact_patches", ContactPatches)
        # The monitor counts a subscriber a moment after that has connected.
        wait_until(lambda: self.send(FAR_CLOTH) and log.count() > 0, "patches")
        contacts, first = self.patches(log, CLOTH)
        self.check(contacts, first)
        _, again = self.patches(log, CLOTH)
        self.assertEqual([patch.id for patch in again.patches],
                         [patch.id for patch in first.patches])
        _, none = self.patches(log, FAR_CLOTH)
        self.assertEqual(none.patches, [])
        contacts, new = self.patches(log, CLOTH)
        self.check(contacts, new)
        self.assertFalse({p.id for p in new.patches} & {p.id for p in first.patches})

        drawn = self.markers(CLOTH)
        for name in NAMES:
            types = {m.type for m in drawn if m.ns == f"patch: {name}/cloth"}
            self.assertLessEqual({Marker.LINE_LIST, Marker.TEXT_VIEW_FACING}, types)
        log.subscriber.unregister()
        self.until_no_patch_is_drawn()

    def markers(self, mesh):
        """Of a cycle that drew some."""
        log = Log("/contact_monitor/markers", MarkerArray)
        for _ in range(1000):
            self.send(mesh)
            for message in list(log.messages):
                added = [m for m in message.markers if m.action == Marker.ADD]
                if any(m.ns.startswith("patch: ") for m in added):
                    return added
        raise AssertionError("no markers of patches")

    def until_no_patch_is_drawn(self):
        log = Log("/contact_monitor/markers", MarkerArray)
        for _ in range(1000):
            self.send(CLOTH)
            for message in list(log.messages):
                if not any(m.ns.startswith("patch: ") and m.action == Marker.ADD
                           for m in message.markers):
                    return
        raise AssertionError("patches are drawn although nobody listens")


if __name__ == "__main__":
    rospy.init_node("contact_patches_test")
    rostest.rosrun(PACKAGE, "contact_patches", Patches, sys.argv)
