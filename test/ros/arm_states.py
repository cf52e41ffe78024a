"""The demo's arm: its joint states, sent in a thread, and where its links are for any positions, by
the URDF and tf2 alone."""
import os
import threading
import xml.etree.ElementTree as ElementTree

import rospy
import roslib.packages
import tf2_py
from sensor_msgs.msg import JointState

from monitor_test_support import PACKAGE, pose_from, transform_message
from panda_scene import joint_edges

REFERENCE_FRAME = "base_link"
JOINTS = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_bend", "wrist_roll", "grip"]
LIMITS = [(-1.2, 1.2), (-0.4, 1.2), (0.2, 1.9), (-1.0, 1.0), (-3.0, 3.0), (0.0, 0.045)]
UPRIGHT_ARM = [0.0, -0.3, 0.25, 0.0, 0.0, 0.01]
TOOL_EDGE = {"tool_tip": ("palm", ((0.0, 0.0, 0.125), (0.0, 0.0, 0.0, 1.0)))}
PERIOD_S = 0.02


class Arm:
    def __init__(self):
        urdf = os.path.join(roslib.packages.get_pkg_dir(PACKAGE), "config", "demo_arm.urdf")
        self.joints = ElementTree.parse(urdf).getroot().findall("joint")
        self.positions = UPRIGHT_ARM
        self.publisher = rospy.Publisher("/joint_states", JointState, queue_size=10)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not rospy.is_shutdown():
            state = JointState(name=JOINTS, position=self.positions)
            state.header.stamp = rospy.Time.now()
            self.publisher.publish(state)
            rospy.rostime.wallsleep(PERIOD_S)

    def poses(self, positions, extra_edges=()):
        """{frame: (translation, quaternion)} in the reference frame."""
        values = dict(zip(JOINTS, positions))
        values["grip_mirror"] = values["grip"]  # a mimic joint
        edges = {**joint_edges(self.joints, values), **dict(extra_edges)}
        buffer, stamp = tf2_py.BufferCore(rospy.Duration(10)), rospy.Time(1)
        for transform in transform_message(stamp, edges).transforms:
            buffer.set_transform(transform, "test")
        return {frame: pose_from(buffer, REFERENCE_FRAME, frame, stamp) for frame in edges}
