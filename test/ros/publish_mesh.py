#!/usr/bin/env python3
"""What subscribers of messages.publish_mesh() get: triangles whenever they may not know them."""
import sys
import unittest

import genpy
import numpy as np
import rospy
import rostest

from deformable_contact.messages import publish_mesh
from deformable_contact_monitor.msg import DeformableMesh
from monitor_test_support import PACKAGE, Log, now, to_mesh, wait_until

VERTICES = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], float)
TRIANGLES = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]])


class PublishMesh(unittest.TestCase):

    def publish_until(self, log, wanted, what, triangles=TRIANGLES):
        """Publishes until a message comes that is wanted. Returns it."""
        since = log.count()
        def found():
            publish_mesh("cloth", VERTICES, triangles)
            return any(wanted(message) for message in log.messages[since:])
        wait_until(found, what)
        return next(message for message in log.messages[since:] if wanted(message))

    def test_subscribers_know_the_triangles(self):
        early = VERTICES.copy()
        before = now()
        publish_mesh("cloth", early, TRIANGLES, frame="table", name="sheet")
        early[:] = 7  # the first message is serialized only when somebody subscribes
        first = Log("/cloth", DeformableMesh)
        message = first.wait("the latched message")
        self.assertEqual((message.header.frame_id, message.object), ("table", "sheet"))
        self.assertTrue(before <= message.header.stamp <= now())
        vertices, triangles = to_mesh(message.vertices, message.triangles)
        self.assertEqual(vertices.tolist(), VERTICES.tolist())
        self.assertEqual(triangles.tolist(), TRIANGLES.tolist())

        short = self.publish_until(first, lambda m: not m.triangles, "a message without triangles")
        self.assertEqual((short.header.frame_id, short.object), ("base_link", ""))
        self.assertEqual(short.topology_id, message.topology_id)
        second = Log("/cloth", DeformableMesh)
        known = self.publish_until(second, lambda m: m.triangles, "triangles for a new subscriber")
        self.assertEqual(known.topology_id, message.topology_id)
        other = self.publish_until(first, lambda m: m.topology_id != message.topology_id,
                                   "other triangles", TRIANGLES[:3])
        self.assertEqual(len(other.triangles), 9)

    def test_the_stamp_may_be_that_of_a_message(self):
        publish_mesh("stamped", VERTICES, TRIANGLES, stamp=genpy.Time(12, 5))
        message = Log("/stamped", DeformableMesh).wait("the mesh")
        self.assertEqual((message.header.stamp.secs, message.header.stamp.nsecs), (12, 5))


if __name__ == "__main__":
    rospy.init_node("publish_mesh_test")
    rostest.rosrun(PACKAGE, "publish_mesh", PublishMesh, sys.argv)
