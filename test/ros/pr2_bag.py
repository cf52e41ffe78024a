#!/usr/bin/env python3
"""Replays the recorded transforms of a real PR2 with --clock, and sends a cloth through its right
gripper. The cloth must touch the fingers only, and the pairs must be the oracle's at every
stamp."""
import os
import subprocess
import sys
import unittest

import numpy as np
import rosbag
import rospy
import rostest
import tf2_py
from geometry_msgs.msg import Quaternion, TransformStamped, Vector3
from std_srvs.srv import SetBool

from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, MeshPublisher, Monitor, grid, oracle_pairs, pairs_of, pose_from,
    posed_links, touching, wait_until)
from pose_meshes import posed

FIXED_FRAME = "odom_combined"  # the base moves a little in it
REFERENCE_FRAME = "base_link"
FINGERTIPS = {"r_gripper_l_finger_tip_link", "r_gripper_r_finger_tip_link"}
FINGERS = FINGERTIPS | {"r_gripper_l_finger_link", "r_gripper_r_finger_link"}
ELSEWHERE = {"head_pan_link", "head_tilt_link", "base_link", "torso_lift_link", "r_forearm_link",
             "r_gripper_palm_link", "l_gripper_palm_link", "l_gripper_l_finger_tip_link"}
HEIGHTS_M = [0.06, 0.04, 0.02, 0.0, 0.0, 0.0, 0.0]  # of the cloth, above the fingers
STEP = rospy.Duration(0.5)
DELAY = rospy.Duration(0.3)  # of the meshes behind the clock: transforms for them are there


def recorded_transforms(bag):
    """A tf2 buffer with all transforms of the bag. Their old names start with '/'."""
    buffer = tf2_py.BufferCore(rospy.Duration(1000))
    for _, message, _ in rosbag.Bag(bag).read_messages("/tf"):
        for old in message.transforms:
            t, r = old.transform.translation, old.transform.rotation
            transform = TransformStamped()
            transform.header.stamp = old.header.stamp
            transform.header.frame_id = old.header.frame_id.lstrip("/")
            transform.child_frame_id = old.child_frame_id.lstrip("/")
            transform.transform.translation = Vector3(t.x, t.y, t.z)
            transform.transform.rotation = Quaternion(r.x, r.y, r.z, r.w)
            buffer.set_transform(transform, "bag")
    return buffer


class Pr2Bag(unittest.TestCase):

    def setUp(self):
        bag = os.path.join(rospy.get_param("~data"), "bags/pr2_arms_and_pressure.bag")
        self.recorded = recorded_transforms(bag)
        self.monitor = Monitor()
        self.robot = self.monitor.robot_meshes(self.monitor.robot_meshes_log())
        self.cloth = MeshPublisher("cloth", "/cloth")
        player = subprocess.Popen(["rosrun", "rosbag", "play", "--quiet", "--clock",
                                   "--wait-for-subscribers", bag, "__name:=player", "--topics",
                                   "/tf"], stdin=subprocess.DEVNULL)
        self.addCleanup(player.wait, WAIT_S)
        self.addCleanup(player.terminate)

    def cloth_at(self, stamp, height_m):
        """A cloth across both fingertips and short of the palm, in the fixed frame."""
        vertices, triangles = grid(30, 0.12)
        in_gripper = vertices + np.float32([0.02, 0, height_m])
        gripper = pose_from(self.recorded, FIXED_FRAME, "r_gripper_tool_frame", stamp)
        return posed((in_gripper, triangles), gripper)

    def test_cloth_through_the_gripper(self):
        wait_until(lambda: rospy.Time.now().to_sec() > 0, "/clock")
        pause = rospy.ServiceProxy("/player/pause_playback", SetBool)
        stamp = rospy.Time.now() + STEP
        shown = []
        for height_m in HEIGHTS_M:
            wait_until(lambda: rospy.Time.now() >= stamp + STEP + DELAY, "the clock to go on")
            pause(True)  # so that a slow machine does not see the end of the bag
            stamp = rospy.Time.now() - DELAY
            shown.append((stamp, self.cloth_at(stamp, height_m)))
            self.cloth.send(stamp, FIXED_FRAME, shown[-1][1])
            self.monitor.contacts_at(stamp)
            pause(False)

        self.assertLessEqual(ELSEWHERE, set(self.robot))
        touched = [self.check(stamp, mesh) for stamp, mesh in shown]
        self.assertEqual(touched[0], set(), "the cloth is to start above the gripper")
        for links, height_m in zip(touched, HEIGHTS_M):
            if height_m == 0:
                self.assertLessEqual(FINGERTIPS, links)

    def check(self, stamp, mesh):
        """Holds the cycle at that stamp against the oracle; the links touched."""
        contacts = self.monitor.contacts_at(stamp)
        states = self.monitor.states_at(stamp)
        self.assertEqual(contacts.skipped, [])
        self.assertTrue(contacts.complete)

        def pose(frame):
            return pose_from(self.recorded, REFERENCE_FRAME, frame, stamp)
        links = posed_links({link: self.robot[link] for link in FINGERS}, pose)
        pairs = pairs_of(contacts)
        self.assertEqual(pairs, oracle_pairs(links, "cloth", posed(mesh, pose(FIXED_FRAME))))
        for link in self.robot:
            wanted = ContactState.CONTACT if link in touching(pairs) else ContactState.NONE
            self.assertEqual(states[link, "cloth"], wanted, link)
        return touching(pairs)


if __name__ == "__main__":
    rospy.init_node("pr2_bag_test")
    rostest.rosrun(PACKAGE, "pr2_bag", Pr2Bag, sys.argv)
