#!/usr/bin/env python3
"""Checks the warnings on the console about meshes that are missing, rejected, of another type or in
millimetres, and about simulated time that was set too late."""
import sys
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Log as ConsoleLine
from std_msgs.msg import String

import boxes_scene
from boxes_scene import CLOTH, REFERENCE_FRAME
from monitor_test_support import PACKAGE, Log, MeshPublisher, Monitor, Transforms, now

MESH_TYPE = PACKAGE + "/DeformableMesh"


class InputWarnings(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.console = Log("/rosout", ConsoleLine)
        cls.monitor = Monitor()
        cls.transforms = Transforms()
        cls.cloth = MeshPublisher("cloth", "/cloth")

    def warning(self, *parts, meanwhile=lambda: None):
        """The next one of the monitor in which all of them are."""
        since = self.console.count()
        def found():
            with self.console.condition:
                return [m.msg for m in self.console.messages[since:]
                        if m.name == self.monitor.name and m.level == ConsoleLine.WARN
                        and all(part in m.msg for part in parts)]
        deadline = time.monotonic() + 40
        while not found():
            self.assertLess(time.monotonic(), deadline, f"no warning with {parts}")
            meanwhile()
            time.sleep(0.05)
        return found()[0]

    def send(self, mesh, stamp=None):
        stamp = now() if stamp is None else stamp
        self.transforms.send(stamp, boxes_scene.edges())
        self.cloth.send(stamp, REFERENCE_FRAME, mesh)

    def test_a_missing_mesh(self):
        text = self.warning("object 'sheet'", "no mesh for")
        self.assertIn("on /sheet, on which nobody publishes", text)

    def test_a_publisher_of_another_type(self):
        publisher = rospy.Publisher("/cable", String, queue_size=1)
        text = self.warning("object 'cable'", "std_msgs/String",
                            meanwhile=lambda: publisher.publish("no mesh"))
        self.assertIn(f"std_msgs/String is published, and not {MESH_TYPE}", text)
        publisher.unregister()

    def test_a_refused_mesh(self):
        text = self.warning("object 'cloth'", "mesh refused: header.stamp is zero",
                            meanwhile=lambda: self.send(CLOTH, stamp=rospy.Time()))
        self.assertIn(f"on /cloth, on which 1 publisher(s) of {MESH_TYPE} are connected", text)

    def test_simulated_time_that_was_set_after_the_start(self):
        rospy.set_param("/use_sim_time", True)  # nobody else starts meanwhile
        self.addCleanup(rospy.delete_param, "/use_sim_time")
        self.warning("started before /use_sim_time was set", "restart it")

    def test_a_mesh_in_millimetres(self):
        def send():
            self.send((1000 * CLOTH[0], CLOTH[1]))
        self.warning("object 'cloth'", "m long", "millimetres", meanwhile=send)
        log = Log("/diagnostics", DiagnosticArray)
        status = None
        deadline = time.monotonic() + 40
        while status is None:
            self.assertLess(time.monotonic(), deadline, "no such diagnostics")
            send()
            time.sleep(0.05)
            status = next((s for m in list(log.messages) for s in m.status
                           if s.name.endswith("mesh:cloth") and "millimetres" in s.message), None)
        self.assertNotEqual(status.level, DiagnosticStatus.OK)


if __name__ == "__main__":
    rospy.init_node("input_warnings_test")
    rostest.rosrun(PACKAGE, "input_warnings", InputWarnings, sys.argv)
