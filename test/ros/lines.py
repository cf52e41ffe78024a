#!/usr/bin/env python3
"""Sends ropes and grains as each message of the types polyline and points. The contacts must be all
pairs at most the radius apart, and what is not known must not look free."""
import sys
import unittest

import numpy as np
import rospy
import rostest
from geometry_msgs.msg import PoseArray
from nav_msgs.msg import Path
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker

import boxes_scene
from adapted_messages import (
    cloud_message, line_triangles, path_message, poses_message, separate_points, strip_message)
from boxes_scene import REFERENCE_FRAME
from mesh_distance import pairs_within
from monitor_test_support import (
    PACKAGE, ContactState, Monitor, now, pairs_of, posed_links, touching, transform_message,
    wait_for_transforms, wait_until)
from ropes import NODES, RADIUS_M, rope_around

PERIOD_S = 1 / 15
POSES = 90  # 6 s of a tracker
TYPES = {"cloud": (PointCloud2, cloud_message), "poses": (PoseArray, poses_message),
         "path": (Path, path_message), "strip": (Marker, strip_message),
         "grains": (PointCloud2, cloud_message)}
FINGER_AT = np.array(boxes_scene.FINGER_AT)


def triangles_of(name, count):
    return separate_points(count) if name == "grains" else line_triangles(count)


class Lines(unittest.TestCase):
    last_stamp = rospy.Time()

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.links = posed_links(cls.monitor.robot_meshes(cls.monitor.robot_meshes_log()),
                                lambda link: boxes_scene.edges()[link][1])
        cls.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        cls.static.publish(transform_message(now(), boxes_scene.edges()))
        cls.publishers = {name: rospy.Publisher("/" + name, message_type, queue_size=1)
                          for name, (message_type, _) in TYPES.items()}
        for name, publisher in cls.publishers.items():
            wait_until(lambda p=publisher: p.get_num_connections() > 0, f"a subscriber of {name}")
        wait_for_transforms(lambda: cls.send("cloud", np.full((2, 3), 3, np.float32)))

    @classmethod
    def publish(cls, name, message):
        """Returns the contacts of the message's cycle."""
        message.header.stamp, message.header.frame_id = now(cls.last_stamp), REFERENCE_FRAME
        cls.last_stamp = message.header.stamp
        cls.publishers[name].publish(message)
        return cls.monitor.contacts_at(message.header.stamp)

    @classmethod
    def send(cls, name, points):
        return cls.publish(name, TYPES[name][1]((points, None)))

    def states_of(self, name, contacts):
        """{link: state} of the object's pairs."""
        states = self.monitor.states_of(contacts)
        return {link: state for (link, other), state in states.items() if other == name}

    def check(self, name, points):
        """Sends the points, compares with the oracle, and returns the links that are touched."""
        contacts = self.send(name, points)
        mesh = (points, triangles_of(name, len(points)))
        expected = pairs_within(self.links, name, mesh, RADIUS_M)
        found = {pair for pair in pairs_of(contacts) if pair[2] == name}
        self.assertEqual(found, expected)
        self.assertTrue(contacts.complete)
        for link, state in self.states_of(name, contacts).items():
            self.assertEqual(state.state == ContactState.CONTACT, link in touching(expected))
            self.assertNotEqual(state.state, ContactState.UNKNOWN, state.reason)
        return touching(expected)

    def test_a_rope_of_45_nodes_around_a_finger(self):
        random = np.random.default_rng(1)
        clock, touched = rospy.Rate(1 / PERIOD_S), []
        for _ in range(POSES):
            rope = (rope_around(random) + FINGER_AT).astype(np.float32)
            self.assertEqual(len(rope), NODES)
            touched.append("finger" in self.check("cloud", rope))
            clock.sleep()
        self.assertGreater(sum(touched), POSES / 5)
        self.assertLess(sum(touched), 4 * POSES / 5)

    def test_each_message_with_any_number_of_nodes(self):
        random = np.random.default_rng(2)
        for name in TYPES:
            touched = []
            for count in (NODES, 7, 1, 2, NODES, 300):
                points = random.uniform((-0.2, -0.2, -0.2), (0.4, 0.2, 0.2), (count, 3))
                with self.subTest(object=name, count=count):
                    touched.append(self.check(name, points.astype(np.float32)))
            self.assertEqual(touched[-1], {"palm", "finger"})

    def test_the_radius_itself_touches_and_the_next_float_does_not(self):
        top = self.links["palm"][0][:, 2].max()
        self.assertEqual(np.float32(top + RADIUS_M) - top, RADIUS_M, "rounding spoils this test")
        beyond = np.nextafter(np.float32(top + RADIUS_M), np.float32(1))
        for name in TYPES:
            for height, expected in ((top + RADIUS_M, {"palm"}), (beyond, set())):
                for xs in ([-0.05, 0.05], [0.0]):
                    points = np.array([(x, 0, height) for x in xs], np.float32)
                    with self.subTest(object=name, height=height, nodes=len(xs)):
                        self.assertEqual(self.check(name, points), expected)

    def test_a_node_of_nan_is_unknown_unless_another_one_touches(self):
        far = np.array([(0.1 * i, 0, 1) for i in range(6)], np.float32)
        for name in TYPES:
            lost, touching_palm = far.copy(), far.copy()
            lost[2, 1] = touching_palm[2, 1] = np.nan
            touching_palm[5] = (0, 0, 0.05)
            with self.subTest(object=name):
                states = self.states_of(name, self.send(name, lost))
                self.assertEqual({s.state for s in states.values()}, {ContactState.UNKNOWN})
                share = f"{1 if name == 'grains' else 2} of {6 if name == 'grains' else 5}"
                self.assertIn(share, states["palm"].reason)
                states = self.states_of(name, self.send(name, touching_palm))
                self.assertEqual(states["palm"].state, ContactState.CONTACT)
                self.assertEqual(states["finger"].state, ContactState.UNKNOWN)
                self.assertEqual(self.check(name, far), set())

    def assert_rejected(self, name, message, why):
        states = self.states_of(name, self.publish(name, message))
        self.assertEqual({s.state for s in states.values()}, {ContactState.UNKNOWN})
        self.assertIn(why, states["palm"].reason)

    def test_what_is_no_line_is_unknown(self):
        far = np.array([(0.1 * i, 0, 1) for i in range(6)], np.float32)
        for name, (_, message_of) in TYPES.items():
            with self.subTest(object=name):
                self.assert_rejected(name, message_of((far[:0], None)), "no points")
                self.assertEqual(self.check(name, far), set())
        huge = cloud_message((far, None))
        huge.width = huge.height = 0xFFFFFFFF
        for name in ("cloud", "grains"):
            self.assert_rejected(name, huge, "row_step is")
        path = path_message((far, None))
        path.poses[3].header.frame_id = "palm"
        self.assert_rejected("path", path, "pose 3 is in frame 'palm'")
        strip = strip_message((far, None))
        strip.type = Marker.LINE_LIST
        self.assert_rejected("strip", strip, "not LINE_STRIP (4)")


if __name__ == "__main__":
    rospy.init_node("lines_test")
    rostest.rosrun(PACKAGE, "lines", Lines, sys.argv)
