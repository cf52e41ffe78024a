#!/usr/bin/env python3
"""Sends images of a depth camera. The contacts must be those of the triangles that the rule of
config/docs/mesh_from/depth_camera.md makes, and what is not seen must not look free."""
import sys
import unittest

import numpy as np
import rospy
import rostest
from sensor_msgs.msg import PointCloud2
from tf2_msgs.msg import TFMessage

import boxes_scene
from adapted_messages import cloud_message, depth_triangles
from boxes_scene import REFERENCE_FRAME
from monitor_test_support import (
    PACKAGE, ContactState, Monitor, now, oracle_pairs, pairs_of, posed_links, touching,
    transform_message, wait_for_transforms, wait_until)
from pose_meshes import posed

ROWS, COLUMNS = 24, 32
CAMERA = ((0.0, 0.0, 1.0), (1.0, 0.0, 0.0, 0.0))  # 1 m above the palm, looking down


def image(depth):
    """The points of a depth image, in float32 and row by row."""
    rows, columns = np.mgrid[0:ROWS, 0:COLUMNS]
    x, y = (columns - COLUMNS / 2) / 32 * depth, (rows - ROWS / 2) / 32 * depth
    return np.stack([x, y, depth], axis=-1).reshape(-1, 3).astype(np.float32)


def floor(depth):
    return np.full((ROWS, COLUMNS), float(depth))


def step():
    """A near half through the boxes and a far half below them; the jump between them is cut."""
    depth = floor(1)
    depth[:, COLUMNS // 2:] = 1.25
    return depth


def holes():
    depth = floor(1)
    depth[8:16, 12:20] = np.nan
    depth[3, ::5] = np.inf
    return depth


def noise():
    return 1 + 0.1 * np.random.default_rng(1).random((ROWS, COLUMNS))


def table():
    """Seen at so flat an angle that each row is a tenth farther away than the one below it."""
    return np.repeat(0.45 * 1.1 ** np.arange(ROWS)[::-1, None], COLUMNS, axis=1)


def cable():
    """One pixel wide, through the palm; the floor lies far behind it."""
    depth = floor(3)
    depth[:, COLUMNS // 2] = np.linspace(0.9, 1.1, ROWS)
    return depth


class DepthCamera(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.links = posed_links(cls.monitor.robot_meshes(cls.monitor.robot_meshes_log()),
                                lambda link: boxes_scene.edges()[link][1])
        cls.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        edges = dict(boxes_scene.edges(), camera=(REFERENCE_FRAME, CAMERA))
        cls.static.publish(transform_message(now(), edges))
        cls.publisher = rospy.Publisher("/camera/points", PointCloud2, queue_size=1)
        wait_until(lambda: cls.publisher.get_num_connections() > 0, "a subscriber")

    def send(self, points, rows=ROWS):
        """Returns the contacts of the image's cycle."""
        cloud = cloud_message((points, None), rows)
        cloud.header.stamp, cloud.header.frame_id = now(), "camera"
        self.publisher.publish(cloud)
        return self.monitor.contacts_at(cloud.header.stamp)

    def state_of(self, contacts):
        return self.monitor.states_of(contacts)["palm", "scene"]

    def test_contacts_are_those_of_the_triangles(self):
        wait_for_transforms(lambda: self.send(image(floor(3))))
        touched, counts = [], []
        for depth in (floor(1), step(), holes(), noise(), table(), cable(), floor(0.5)):
            points = image(depth)
            triangles = depth_triangles(points, ROWS, 0.0625)
            contacts = self.send(points)
            seen = np.where(np.isfinite(points), points, np.float32(0))  # the rest has no triangle
            expected = oracle_pairs(self.links, "scene", posed((seen, triangles), CAMERA))
            found = {pair for pair in pairs_of(contacts) if pair[2] == "scene"}
            self.assertEqual(found, expected)
            self.assertTrue(contacts.complete)
            touched.append(touching(expected))
            counts.append(len(triangles))
        self.assertEqual(touched[0], {"palm", "finger"})
        self.assertEqual(touched[1], {"palm"})
        self.assertIn("palm", touched[4], "a row of the table crosses it")
        self.assertIn("palm", touched[5])
        self.assertEqual(touched[-1], set())
        whole = 2 * (ROWS - 1) * (COLUMNS - 1)
        self.assertEqual(counts[0], whole)
        self.assertEqual(counts[1], whole - 2 * (ROWS - 1))
        self.assertLess(counts[3], whole)

    def test_what_is_not_seen_is_unknown(self):
        wait_for_transforms(lambda: self.send(image(floor(3))))
        hidden = floor(3)
        hidden[:, : COLUMNS - 7] = np.nan
        for points, rows, why in ((image(hidden), ROWS, "fewer than min_seen allows"),
                                  (image(floor(np.nan)), ROWS, "only 0 of 32 x 24 pixels"),
                                  (image(floor(3)), 1, "it is not organised in rows")):
            state = self.state_of(self.send(points, rows))
            self.assertEqual(state.state, ContactState.UNKNOWN)
            self.assertIn(why, state.reason)
        hidden[:, COLUMNS - 8] = 3
        self.assertEqual(self.state_of(self.send(image(hidden))).state, ContactState.NONE)


if __name__ == "__main__":
    rospy.init_node("depth_camera_test")
    rostest.rosrun(PACKAGE, "depth_camera", DepthCamera, sys.argv)
