#!/usr/bin/env python3
"""Checks ~check_states and its stream: states are free or touch as the oracle and all distances say,
as a cycle says once the robot stands there by robot_state_publisher, and within the rules in force;
what is not known is UNKNOWN, and what cannot be answered is refused by name."""
import math
import random
import sys
import threading
import unittest

import numpy as np
import rospy
import rostest
from rosgraph_msgs.msg import Log as ConsoleLine
from std_srvs.srv import SetBool

from arm_states import JOINTS, LIMITS, REFERENCE_FRAME, TOOL_EDGE, UPRIGHT_ARM, Arm
from deformable_contact_monitor.msg import AllowedContact, StatesChecked, StatesToCheck
from deformable_contact_monitor.srv import AttachObject, CheckStates, SetAllowedContacts
from mesh_distance import mesh_distance
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, MeshPublisher, Monitor, grid, now, oracle_pairs,
    peak_memory_mib, touching, wait_until, with_length)
from pose_meshes import posed

NONE, NEAR, CONTACT, UNKNOWN = (
    ContactState.NONE, ContactState.NEAR, ContactState.CONTACT, ContactState.UNKNOWN)


def before_the_arm(mesh):
    return (mesh[0] + np.array([0.55, 0.0, 0.0])).astype(np.float32), mesh[1]


CLOTH = before_the_arm(grid(12, 0.8, height_m=0.6))
SMALL_CLOTH = before_the_arm(grid(2, 0.3, height_m=0.6))
# Two fingers through the cloth's near edge, and the arm upright beside it.
TOUCHING, FREE = [0.0, 0.55, 1.25, 0.3, 0.0, 0.03], UPRIGHT_ARM
MESH_PERIOD_S = 0.1
CORNERS = np.array([[x, y, z] for z in (-1, 1) for y in (-1, 1) for x in (-1, 1)], np.float64)
TOOL = (CORNERS * np.array([0.03125, 0.03125, 0.25]) / 2).astype(np.float32)


class Cloth(threading.Thread):
    """Sends the cloth until it is to rest."""

    def __init__(self):
        super().__init__(daemon=True)
        self.publisher = MeshPublisher("cloth", "/cloth")
        self.mesh = CLOTH
        self.rests = False
        self.stamp = None
        self.start()

    def run(self):
        while not rospy.is_shutdown():
            if not self.rests:
                self.stamp = now(after=self.stamp)
                self.publisher.send(self.stamp, REFERENCE_FRAME, self.mesh,
                                    topology_id=len(self.mesh[1]))
            rospy.rostime.wallsleep(MESH_PERIOD_S)


class States(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        service = "/contact_monitor/check_states"
        rospy.wait_for_service(service, WAIT_S)
        cls.service = rospy.ServiceProxy(service, CheckStates)
        cls.arm = Arm()
        cls.cloth = Cloth()
        cls.meshes = cls.monitor.robot_meshes(cls.monitor.robot_meshes_log())
        cls.meshes["tool"] = (TOOL, cls.triangles_of_a_box())
        wait_until(lambda: cls.check([FREE], objects=["cloth"]).reason == "", "all that is asked")

    @staticmethod
    def triangles_of_a_box():
        return np.array([(0, 2, 3), (0, 3, 1), (4, 5, 7), (4, 7, 6), (0, 1, 5), (0, 5, 4),
                         (2, 6, 7), (2, 7, 3), (0, 4, 6), (0, 6, 2), (1, 3, 7), (1, 7, 5)],
                        np.uint32)

    @classmethod
    def check(cls, states, names=tuple(JOINTS), objects=("cloth",), **fields):
        question = StatesToCheck(joint_names=names, objects=objects,
                                 positions=np.array(states, float).flatten(), **fields)
        return cls.service(question).checked

    def bodies(self, positions):
        """The moved links and the tool at these positions."""
        poses = self.arm.poses(positions, TOOL_EDGE)
        poses["tool"] = poses["tool_tip"]
        return {name: posed(mesh, poses[name]) for name, mesh in self.meshes.items()
                if name != "base_link"}

    def randomly(self, count, seed=46):
        source = random.Random(seed)
        return [[source.uniform(*limits) for limits in LIMITS] for _ in range(count)]

    def test_states_are_free_or_touch_as_the_oracle_says(self):
        states = self.randomly(24) + [TOUCHING, FREE]
        first, full = self.check(states, first_only=True), self.check(states)
        self.assertTrue(first.success, first.reason)
        self.assertEqual((list(first.link), list(first.object), list(first.distance)), ([], [], []))
        self.assertEqual(list(first.state), list(full.state))
        self.assertEqual(full.objects, ["cloth"])
        self.assertLess(abs((full.object_stamps[0] - rospy.Time.now()).to_sec()), 5)
        self.assertGreater(full.compute_time.to_sec(), 0)
        for i, positions in enumerate(states):
            links = touching(oracle_pairs(self.bodies(positions), "cloth", CLOTH))
            self.assertEqual(full.state[i], CONTACT if links else NONE, (positions, links))
            self.assertEqual(full.distance[i], 0 if links else math.inf)
            order = [name for name in self.meshes if name in links]
            self.assertEqual(full.link[i], order[0] if order else "")
            self.assertEqual(full.object[i], "cloth" if links else "")
        self.assertIn(CONTACT, full.state)
        self.assertIn(NONE, full.state)
        self.assertEqual((full.state[-2], full.state[-1]), (CONTACT, NONE))

    def show(self, mesh):
        """Waits until this is the cloth that is asked about."""
        self.cloth.mesh = mesh
        since = now() + rospy.Duration(MESH_PERIOD_S)
        wait_until(lambda: self.check([FREE]).object_stamps[0] > since, "another cloth")

    def test_distances_are_the_least_of_all(self):
        self.show(SMALL_CLOTH)
        self.addCleanup(self.show, CLOTH)
        states = self.randomly(2, seed=2) + [FREE]
        apart = [{name: mesh_distance(mesh, SMALL_CLOTH)
                  for name, mesh in self.bodies(one).items()} for one in states]
        for margin, within in ((0.05, 0.05), (-1.0, 2.0), (10.0, 10.0)):
            checked = self.check(states, margin=margin)
            for i, of_links in enumerate(apart):
                least = min(of_links.values())
                expected = CONTACT if least == 0 else NEAR if least <= within else NONE
                self.assertEqual(checked.state[i], expected, (states[i], of_links))
                if expected == NONE:
                    self.assertEqual((checked.distance[i], checked.link[i]), (math.inf, ""))
                    continue
                self.assertAlmostEqual(checked.distance[i], least, delta=1e-6)
                self.assertAlmostEqual(of_links[checked.link[i]], least, delta=1e-6)

    def test_a_cycle_says_the_same_once_the_robot_stands_there(self):
        for positions in self.randomly(3, seed=8) + [TOUCHING]:
            self.arm.positions = UPRIGHT_ARM
            checked = self.check([positions], margin=-1.0)
            # Only some joints are named, and TF has where the others are.
            self.arm.positions = UPRIGHT_ARM[:2] + positions[2:]

            def same_of_two():
                answer = self.check([positions[:2]], names=JOINTS[:2], margin=-1.0)
                return abs(answer.distance[0] - checked.distance[0]) < 1e-6
            wait_until(same_of_two, "the transforms of the joints that are not named")
            self.arm.positions = positions
            start = rospy.Time.now() + rospy.Duration(0.2)
            moved = set(self.meshes) - {"base_link"}

            def stands_there(message):
                found = {s.body_a for s in message.states if s.body_b == "cloth"
                         and s.stamp > start and s.state in (NEAR, CONTACT)}
                return moved <= found
            states = self.monitor.states.wait("a cycle behind the motion", stands_there)
            least = min(s.min_separation for s in states.states
                        if s.body_b == "cloth" and s.body_a in moved)
            self.assertAlmostEqual(checked.distance[0], least, delta=1e-6)
        self.arm.positions = UPRIGHT_ARM

    def test_the_rules_in_force_count(self):
        self.assertEqual(list(self.check([TOUCHING, FREE]).state), [CONTACT, NONE])
        rules = rospy.ServiceProxy("/contact_monitor/set_allowed_contacts", SetAllowedContacts)
        links = touching(oracle_pairs(self.bodies(TOUCHING), "cloth", CLOTH))
        allowed = [AllowedContact(body_a=link, body_b="cloth", allowed=True) for link in links]
        rules(rules=allowed)
        try:
            self.assertEqual(list(self.check([TOUCHING, FREE]).state), [NONE, NONE])
        finally:
            forbidden = AllowedContact(body_a="tool", body_b="cloth", allowed=False)
            rules(remove=allowed, rules=[forbidden])
        self.assertEqual(self.check([TOUCHING]).state[0], CONTACT)

    def test_an_attached_object_goes_with_its_link(self):
        """The plate lies around the foot, and no link that moves touches it."""
        attach = rospy.ServiceProxy("/contact_monitor/attach_object", AttachObject)
        self.assertEqual(self.check([FREE, TOUCHING], objects=["plate"]).state[0], NONE)
        answer = attach(object="plate", links=["shoulder"])
        self.assertTrue(answer.success, answer.message)
        try:
            turned = [[0.5] + FREE[1:], FREE]
            checked = self.check(turned, objects=["plate"], margin=-1.0)
            self.assertEqual(list(checked.state), [CONTACT, CONTACT])
            self.assertEqual((checked.link[0], checked.object[0]), ("plate", "base_link"))
        finally:
            attach(object="plate")

    def test_what_is_stale_is_unknown(self):
        self.cloth.rests = True
        try:
            wait_until(lambda: self.check([FREE]).state[0] == UNKNOWN, "the cloth to be too old")
            checked = self.check([TOUCHING, FREE], margin=0.5)
            self.assertEqual(list(checked.state), [UNKNOWN, UNKNOWN])
            self.assertTrue(all(math.isnan(value) for value in checked.distance))
            self.assertEqual(checked.object_stamps, [self.cloth.stamp])
            self.assertRegex(checked.reason, r"^cloth: newest mesh is \d+\.\d+ s old$")
            # What touches something that is known is certain all the same.
            below = [0.0, 1.2, 1.9, 1.0, 0.0, 0.0]
            checked = self.check([below, FREE], objects=["cloth", "plate"])
            self.assertEqual(list(checked.state), [CONTACT, UNKNOWN])
            self.assertEqual(checked.object[0], "plate")
            self.assertEqual(checked.objects, ["plate", "cloth"])
        finally:
            self.cloth.rests = False
        wait_until(lambda: self.check([FREE]).state[0] == NONE, "a fresh cloth")

    def test_beyond_limits_it_is_checked_and_said(self):
        beyond = [0.0, 0.0, -3.0, 0.0, 0.0, 0.01]
        checked = self.check([FREE, beyond, [0.0, 0.0, 0.2, 0.0, 100.0, 0.01]])
        self.assertEqual(list(checked.beyond_limits), [False, True, False])
        links = touching(oracle_pairs(self.bodies(beyond), "cloth", CLOTH))
        self.assertEqual(checked.state[1], CONTACT if links else NONE)

    def test_what_cannot_be_answered_is_refused_by_name(self):
        nan, infinity = [float("nan")] + FREE[1:], FREE[:5] + [float("inf")]
        for reason, states, fields in (
                ("positions[0], of joint 'shoulder_pan' in state 0, is not finite", [nan], {}),
                ("positions[11], of joint 'grip' in state 1, is not finite", [FREE, infinity], {}),
                ("positions has 5 numbers, which is no multiple of the 6 joint_names", [FREE[:5]], {}),
                ("positions is empty", [], {}),
                ("joint_names is empty", [FREE], {"names": []}),
                ("the robot has no joint 'elbw' (did you mean 'elbow'?)", [[1.0]],
                 {"names": ["elbw"]}),
                ("joint 'elbow' is named twice", [[1.0, 1.0]], {"names": ["elbow", "elbow"]}),
                ("there is no object 'clth' (did you mean 'cloth'?)", [FREE],
                 {"objects": ["cloth", "clth"]}),
                ("margin is nan m; it must be a number of at most 10", [FREE],
                 {"margin": float("nan")}),
                ("max_time is negative", [FREE], {"max_time": rospy.Duration(-1)})):
            checked = self.check(states, **fields)
            self.assertEqual((checked.success, checked.reason), (False, reason))
            self.assertEqual((list(checked.state), checked.objects), ([], []))

    def test_an_object_without_a_mesh_is_unknown(self):
        checked = self.check([FREE, TOUCHING], objects=[], margin=-1.0)
        self.assertEqual(list(checked.state), [UNKNOWN, CONTACT])
        self.assertEqual(checked.reason, "sheet: no mesh yet")
        self.assertEqual(checked.objects, ["plate", "tool", "cloth", "sheet"])
        self.assertEqual(checked.object_stamps[3], rospy.Time())

    def test_without_time_it_is_unknown(self):
        checked = self.check([FREE, TOUCHING], max_time=rospy.Duration(0, 1))
        self.assertTrue(checked.success)
        self.assertEqual(list(checked.state), [UNKNOWN, UNKNOWN])
        self.assertEqual(checked.reason, "no time")

    def test_a_disabled_monitor_refuses(self):
        enable = rospy.ServiceProxy("/contact_monitor/set_enabled", SetBool)
        enable(False)
        try:
            self.assertEqual(self.check([FREE]).reason, "the monitor is disabled (~set_enabled)")
        finally:
            enable(True)
        wait_until(lambda: self.check([FREE]).state == bytes([NONE]), "a fresh cloth")

    @staticmethod
    def stream():
        """Of one queue size in all tests: rospy keeps that of the topic's first publisher."""
        questions = rospy.Publisher("/contact_monitor/states_to_check", StatesToCheck, queue_size=99)
        wait_until(lambda: questions.get_num_connections() > 0, "the monitor")
        return questions

    def test_the_stream_answers_in_order(self):
        answers = Log("/contact_monitor/states_checked", StatesChecked)
        questions = self.stream()
        batches = [self.randomly(5, seed) for seed in range(20)]
        for i, states in enumerate(batches):
            questions.publish(StatesToCheck(
                id=i + 7, joint_names=JOINTS if i != 3 else JOINTS[:1] + JOINTS[:1],
                positions=np.array(states).flatten(), objects=["cloth"], margin=0.1))
        answers.wait("the last answer", lambda m: m.id == len(batches) + 6)
        self.assertEqual([m.id for m in answers.messages], [i + 7 for i in range(len(batches))])
        for i, states in enumerate(batches):
            answer = answers.messages[i]
            if i == 3:
                self.assertEqual(answer.reason, "joint 'shoulder_pan' is named twice")
                continue
            expected = self.check(states, margin=0.1)
            self.assertEqual((list(answer.state), list(answer.distance), answer.link),
                             (list(expected.state), list(expected.distance), expected.link))

    def test_a_damaged_question_costs_nothing(self):
        console = Log("/rosout", ConsoleLine)
        answers = Log("/contact_monitor/states_checked", StatesChecked)
        questions = self.stream()
        question = StatesToCheck(id=1, joint_names=JOINTS, positions=FREE + FREE)
        before_mib = peak_memory_mib("/contact_monitor")
        questions.publish(with_length(question, 2 * len(FREE), 2**28))
        console.wait("the error", lambda m: "positions claims 2147483648 bytes" in m.msg)
        questions.publish(StatesToCheck(id=2, joint_names=JOINTS, positions=FREE))
        self.assertEqual(answers.wait("the next answer").id, 2)
        self.assertLess(peak_memory_mib("/contact_monitor"), before_mib + 200)


if __name__ == "__main__":
    rospy.init_node("check_states_test")
    rostest.rosrun(PACKAGE, "check_states", States, sys.argv)
