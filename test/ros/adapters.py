#!/usr/bin/env python3
"""Sends one moving box as a message of each type that an object may have. The contacts must be the
same for all types."""
import os
import sys
import time
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Log as ConsoleLine
from sensor_msgs.msg import PointCloud2
from shape_msgs.msg import Mesh
from std_msgs.msg import String
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

import boxes_scene
from adapted_messages import (
    array_message, cloud_message, marker_message, points, shape_message)
from boxes_scene import REFERENCE_FRAME
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, Monitor, DeformableMesh, mesh_message, now, oracle_pairs,
    pairs_of, posed_links, touching, transform_message, wait_until)
from pose_meshes import read_obj

BOX = read_obj(os.path.join(os.path.dirname(os.path.abspath(__file__)), "box.obj"))
TYPES = {"mesh": DeformableMesh, "shape": Mesh, "marker": Marker, "array": MarkerArray,
         "cloud": PointCloud2, "cells": PointCloud2, "late": DeformableMesh}
LATE = rospy.Duration(0.5)  # as in adapters.test
# Through the palm to the finger, and away; float32 has all of these exactly.
PLACES = [np.array(place, np.float32) for place in
          ((0, 0, 0.125), (0.125, 0, 0.0625), (0.1875, 0.0625, 0.0625), (0, 0, 3))]


def stamped(stamp, message):
    message.header.stamp = stamp
    message.header.frame_id = REFERENCE_FRAME
    return message


def stamped_array(stamp, array):
    for marker in array.markers:
        stamped(stamp, marker)
    return array


def half_a_marker(place):
    """Half of BOX, and the marker's pose and scale do the rest."""
    marker = marker_message((BOX[0] / 2, BOX[1]))
    marker.scale.x = marker.scale.y = marker.scale.z = 2
    marker.pose.position = points([place])[0]
    return marker


class Adapters(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.console = Log("/rosout", ConsoleLine)
        cls.diagnostics = Log("/diagnostics", DiagnosticArray)
        cls.monitor = Monitor()
        cls.links = posed_links(cls.monitor.robot_meshes(cls.monitor.robot_meshes_log()),
                                lambda link: boxes_scene.edges()[link][1])
        cls.static = rospy.Publisher("/tf_static", TFMessage, queue_size=1, latch=True)
        cls.static.publish(transform_message(now(), boxes_scene.edges()))
        cls.publishers = {name: rospy.Publisher("/" + name, message_type, queue_size=1)
                          for name, message_type in TYPES.items()}
        for name, publisher in cls.publishers.items():
            wait_until(lambda p=publisher: p.get_num_connections() > 0, f"a subscriber of {name}")

    def send(self, place):
        """The box at that place in all types; {object: contacts of its cycle}. One type is sent
        after the other's cycle: the monitor's queue holds two messages, and drops the older."""
        box = (BOX[0] + place, BOX[1])
        stamp = now()
        with_middle = (np.concatenate([box[0], [place]]), None)
        messages = {
            "mesh": mesh_message("mesh", stamp, REFERENCE_FRAME, box),
            "late": mesh_message("late", stamp + LATE, REFERENCE_FRAME, box),
            "shape": shape_message(box),
            "marker": stamped(stamp, half_a_marker(place)),
            "array": stamped_array(stamp, array_message(box)),
            "cells": stamped(stamp, cloud_message(with_middle, rows=3)),
            "cloud": stamped(stamp, cloud_message(box, rows=2))}
        contacts = {}
        for name, message in messages.items():
            def is_of(found, name=name):
                return found.header.stamp >= stamp and found.triggered[found.bodies.index(name)]
            since = self.monitor.contacts.count()
            self.publishers[name].publish(message)
            contacts[name] = self.monitor.contacts.wait(f"a cycle of {name}", is_of, since)
        return contacts

    def wait_for_transforms(self):
        def is_complete():
            return not any(c.skipped for c in self.send(PLACES[-1]).values())
        wait_until(is_complete, "transforms of all links")

    def warning(self, *parts):
        def is_it(line):
            return line.name == self.monitor.name and all(part in line.msg for part in parts)
        return self.console.wait(f"a warning with {parts}", is_it).msg

    def mesh_status(self, name, meanwhile=lambda: None):
        def is_wanted(status):
            return status.name.endswith("mesh:" + name) and status.level == DiagnosticStatus.OK
        deadline = time.monotonic() + WAIT_S
        while True:
            self.assertLess(time.monotonic(), deadline, f"no status of {name}")
            meanwhile()
            time.sleep(0.1)
            found = [s for m in list(self.diagnostics.messages) for s in m.status if is_wanted(s)]
            if found:
                return found[-1]

    def test_the_same_contacts_whatever_it_comes_as(self):
        self.wait_for_transforms()
        touched = []
        for place in PLACES:
            contacts = self.send(place)
            box = (BOX[0] + place, BOX[1])
            for name in TYPES:
                with self.subTest(place=place, object=name):
                    expected = oracle_pairs(self.links, name, box)
                    found = {pair for pair in pairs_of(contacts[name]) if pair[2] == name}
                    self.assertEqual(found, expected)
                    self.assertTrue(contacts[name].complete)
            self.assertEqual(contacts["late"].header.stamp, contacts["mesh"].header.stamp)
            touched.append(touching(expected))
        self.assertEqual(touched, [{"palm"}, {"palm"}, {"palm", "finger"}, set()])

    def test_what_is_stamped_on_receipt_is_said(self):
        status = self.mesh_status("shape", lambda: self.send(PLACES[-1]))
        self.assertIn("stamped on receipt", status.message)
        self.assertNotIn("stamped on receipt", self.mesh_status("marker").message)
        self.warning("object 'shape'", "stamped on receipt")
        with self.console.condition:
            said = [m.msg for m in self.console.messages if "stamped on receipt" in m.msg]
        self.assertEqual(len(said), 1, said)

    def test_a_marker_that_is_deleted_is_unknown(self):
        self.wait_for_transforms()
        marker = stamped(now(), half_a_marker(PLACES[0]))
        marker.action = Marker.DELETE
        since = self.monitor.states.count()
        self.publishers["marker"].publish(marker)

        def is_it(states):
            return any(s.body_b == "marker" and s.state == ContactState.UNKNOWN
                       and "marker 'box'/4 was deleted" in s.reason for s in states.states)
        self.monitor.states.wait("UNKNOWN", is_it, since)

    def test_the_type_that_is_wanted_is_named(self):
        publisher = rospy.Publisher("/text", String, queue_size=1)
        publisher.publish("no cloud")
        text = self.warning("object 'text'", "std_msgs/String is published")
        self.assertIn("and not sensor_msgs/PointCloud2", text)


if __name__ == "__main__":
    rospy.init_node("adapters_test")
    rostest.rosrun(PACKAGE, "adapters", Adapters, sys.argv)
