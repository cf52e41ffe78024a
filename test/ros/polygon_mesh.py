#!/usr/bin/env python3
"""Sends a moving box as polygons of the Point Cloud Library, in triangles and in squares."""
import sys
import unittest

import numpy as np
import rospy
import rostest
from pcl_msgs.msg import PolygonMesh
from tf2_msgs.msg import TFMessage

import boxes_scene
from adapted_messages import polygon_message
from adapters import BOX, PLACES
from boxes_scene import REFERENCE_FRAME
from monitor_test_support import (
    PACKAGE, ContactState, Monitor, now, oracle_pairs, pairs_of, posed_links, touching,
    transform_message, wait_for_transforms, wait_until)


def squares():
    """The sides of BOX, whose triangles 2k and 2k + 1 are a square, as polygons of four."""
    sides = []
    for first, second in zip(BOX[1][::2].tolist(), BOX[1][1::2].tolist()):
        sides.append([first[0], first[1], first[2], second[2]])
    return sides


class PolygonMeshes(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.links = posed_links(cls.monitor.robot_meshes(cls.monitor.robot_meshes_log()),
                                lambda link: boxes_scene.edges()[link][1])
        cls.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        cls.static.publish(transform_message(now(), boxes_scene.edges()))
        cls.publisher = rospy.Publisher("/polygons", PolygonMesh, queue_size=1)
        wait_until(lambda: cls.publisher.get_num_connections() > 0, "a subscriber")

    def send(self, vertices, polygons):
        message = polygon_message((vertices, polygons))
        message.header.stamp, message.header.frame_id = now(), REFERENCE_FRAME
        self.publisher.publish(message)
        return self.monitor.contacts_at(message.header.stamp)

    def test_the_same_contacts(self):
        wait_for_transforms(lambda: self.send(BOX[0] + PLACES[-1], BOX[1]))
        fans = np.array([t for a, b, c, d in squares() for t in ((a, b, c), (a, c, d))], np.uint32)
        touched = []
        for polygons, triangles in ((BOX[1], BOX[1]), (squares(), fans)):
            for place in PLACES:
                contacts = self.send(BOX[0] + place, polygons)
                expected = oracle_pairs(self.links, "polygons", (BOX[0] + place, triangles))
                self.assertEqual(pairs_of(contacts), expected)
                self.assertTrue(contacts.complete)
                touched.append(touching(expected))
        self.assertEqual(touched, 2 * [{"palm"}, {"palm"}, {"palm", "finger"}, set()])

    def test_a_bad_polygon_is_unknown(self):
        for polygons, why in (([[0, 1]], "polygon 0 has 2 vertices"),
                              ([[0, 1, 8]], "refers to vertex 8, but there are 8")):
            states = self.monitor.states_of(self.send(BOX[0], polygons))
            self.assertEqual({s.state for s in states.values()}, {ContactState.UNKNOWN})
            self.assertIn(why, states["palm", "polygons"].reason)


if __name__ == "__main__":
    rospy.init_node("polygon_mesh_test")
    rostest.rosrun(PACKAGE, "polygon_mesh", PolygonMeshes, sys.argv)
