#!/usr/bin/env python3
"""Checks soft_scene beside a monitor: what it simulates hangs on and is pushed by the arm, the monitor
finds the contacts, links hold and move the cloth, and a robot that jumps does not tear it."""
import threading
import time
import unittest

import numpy as np
import rospy
import rostest
from rosgraph_msgs.msg import Log as RosLog
from sensor_msgs.msg import JointState
from visualization_msgs.msg import Marker

from deformable_contact_monitor.msg import DeformableMesh
from deformable_contact_monitor.srv import AttachObject
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, Monitor, wait_until)

NAMES = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_bend", "wrist_roll", "grip"]
FOLDED = [0.0, 0.0, 1.9, 1.0, 0.0, 0.02]  # behind the cloth, which hangs
STRETCHED = [0.0, 0.7, 1.2, -0.3, 0.0, 0.02]  # where the cloth would hang
FASTEST = 1.0  # [rad/s]
PERIOD_S = 0.02


class Joints:
    """Sends joint states from a thread; moves to the wanted ones at FASTEST."""

    def __init__(self):
        self.publisher = rospy.Publisher("/joint_states", JointState, queue_size=10)
        self.now = np.array(FOLDED)
        self.wanted = np.array(FOLDED)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not rospy.is_shutdown():
            step = FASTEST * PERIOD_S
            self.now = self.now + np.clip(self.wanted - self.now, -step, step)
            message = JointState(name=NAMES, position=self.now.tolist())
            message.header.stamp = rospy.Time.now()
            try:
                self.publisher.publish(message)
            except rospy.ROSException:  # closed meanwhile: the test ends
                return
            time.sleep(PERIOD_S)

    def jump(self, positions):
        self.wanted = np.array(positions)
        self.now = self.wanted

    def move(self, positions):
        self.wanted = np.array(positions)
        wait_until(lambda: np.allclose(self.now, self.wanted), "the arm")


def vertices_of(message):
    return np.array(message.vertices).reshape(-1, 3)


class SoftScene(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.joints = Joints()
        cls.log = Log("/rosout", RosLog)
        cls.meshes = Log("/cloth", DeformableMesh)
        cls.ropes = Log("/rope", Marker)
        cls.monitor = Monitor()
        name = "/cloth_scene/attach_object"
        rospy.wait_for_service(name, WAIT_S)
        cls.attach = rospy.ServiceProxy(name, AttachObject)

    def next_mesh(self, after=1):
        """Of those that are sent from now on."""
        count = self.meshes.count() + after - 1
        return self.meshes.wait("a mesh", since=count)

    def rest(self):
        """The vertices of the cloth once it hangs still: it begins as a level sheet, and swings."""
        before = vertices_of(self.next_mesh())
        for _ in range(100):
            after = vertices_of(self.next_mesh(after=10))
            if np.abs(after - before).max() < 0.01:
                return after
            before = after
        raise AssertionError("the cloth does not come to rest")

    def wait_for(self, link, other, state):
        self.monitor.states.wait(
            f"{state} of {link} and {other}", since=self.monitor.states.count(),
            wanted=lambda message: any(
                (s.body_a, s.body_b, s.state) == (link, other, state) for s in message.states))

    def test_1_the_monitor_finds_what_the_arm_pushes(self):
        self.wait_for("palm", "cloth", ContactState.NONE)
        hanging = self.rest()
        self.joints.move(STRETCHED)
        self.wait_for("palm", "cloth", ContactState.CONTACT)
        self.meshes.wait("the cloth is pushed", since=self.meshes.count(), wanted=lambda mesh: (
            vertices_of(mesh) - hanging)[:, 0].max() > 0.1)
        self.wait_for("base_link", "cloth", ContactState.NONE)
        states = self.monitor.states.messages[-1].states
        self.assertFalse([s for s in states if s.state == ContactState.UNKNOWN])

    def test_2_stamps_and_triangles(self):
        self.next_mesh(after=40)
        messages = self.meshes.messages
        stamps = [m.header.stamp for m in messages]
        self.assertEqual(stamps, sorted(set(stamps)))
        self.assertLess(abs((rospy.Time.now() - stamps[-1]).to_sec()), WAIT_S)
        self.assertEqual({m.header.frame_id for m in messages}, {"base_link"})
        self.assertEqual({len(m.triangles) for m in messages}, {0, 3 * 2 * 21 * 21})
        first = vertices_of(messages[0])[:22]  # the edge that is pinned
        for message in messages:
            np.testing.assert_array_equal(vertices_of(message)[:22], first)

    def test_3_a_rope_is_a_line_of_its_width(self):
        rope = self.ropes.wait("a rope")
        self.assertEqual((rope.type, rope.ns, len(rope.points)), (Marker.LINE_STRIP, "rope", 40))
        self.assertAlmostEqual(rope.scale.x, 0.02)
        # It lies on the arm, which only TF poses for it.
        self.monitor.states.wait(
            "a rope at the arm", since=self.monitor.states.count(),
            wanted=lambda message: any(
                s.body_b == "rope" and s.state in (ContactState.CONTACT, ContactState.NEAR)
                for s in message.states))

    def test_4_what_links_hold_follows_them(self):
        answer = self.attach(object="rope", links=["palm"], radius=0.1)
        self.assertFalse(answer.success)
        self.assertIn("'rope'", answer.message)
        for links, radius in ((["nobody"], 0.1), (["palm"], 0.0), (["base_link"], 1e-4)):
            answer = self.attach(object="cloth", links=links, radius=radius)
            self.assertFalse(answer.success, links)
            self.assertTrue(answer.message)
        answer = self.attach(object="cloth", links=["palm"], radius=0.03)
        self.assertTrue(answer.success, answer.message)
        self.assertGreater(answer.held_triangles, 0)
        before = vertices_of(self.next_mesh())
        turned = list(STRETCHED)
        turned[0] = 0.3
        self.joints.move(turned)
        after = vertices_of(self.next_mesh(after=3))
        # About the shoulder's axis, which is z: held vertices keep their distance from it.
        turn = np.array([[np.cos(0.3), -np.sin(0.3)], [np.sin(0.3), np.cos(0.3)]])
        error = np.linalg.norm(before[:, :2] @ turn.T - after[:, :2], axis=1)
        self.assertGreater(np.count_nonzero(error < 1e-4), 3)
        answer = self.attach(object="cloth")
        self.assertTrue(answer.success)
        self.assertIn("no more", answer.message)
        self.joints.move(STRETCHED)

    def test_5_a_robot_that_jumps_does_not_tear_the_cloth(self):
        self.assertTrue(self.attach(object="cloth", links=["palm"], radius=0.03).success)
        since = self.log.count()
        # The arm flips over within one message, several times.
        for turn in range(20):
            self.joints.jump([3.0 * (turn % 2)] + STRETCHED[1:])
            time.sleep(0.1)
            if any("was undone" in m.msg for m in self.log.messages[since:]):
                break
        self.log.wait("the log of a step that was undone", since=since,
                      wanted=lambda m: m.level == RosLog.ERROR and "was undone" in m.msg)
        self.joints.jump(STRETCHED)
        self.assertTrue(self.attach(object="cloth").success)
        mesh = vertices_of(self.next_mesh(after=10))
        self.assertTrue(np.isfinite(mesh).all())
        self.assertLess(np.abs(mesh).max(), 20)


if __name__ == "__main__":
    rospy.init_node("soft_scene_test")
    rostest.rosrun(PACKAGE, "soft_scene", SoftScene)
