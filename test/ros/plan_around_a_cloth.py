#!/usr/bin/env python3
"""Runs the example of config/docs/plan_around_a_cloth.md unchanged, and samples its path densely:
no state touches the cloth, by the service without a margin and by the oracle. The straight path
would. The MoveIt example says the same, with stand-ins of MoveIt's classes."""
import subprocess
import sys

import numpy as np
import rospy
import rostest

from arm_states import JOINTS, UPRIGHT_ARM, Arm
from deformable_contact_monitor.msg import DeformableMesh, StatesToCheck
from deformable_contact_monitor.srv import CheckStates
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, Monitor, executable, oracle_pairs, to_mesh, touching,
    wait_until)
from pages import SOURCE, Page, PageCase
from pose_meshes import posed

DENSE = 4000  # states of each piece of the path; neighbours are some 0.5 mm apart at the fingers
ORACLE_EVERY = 400


class PlanAroundACloth(PageCase):

    def start_all(self):
        page = Page("plan_around_a_cloth.md")
        folder = self.folder_of(page)
        publish, launch, self.plan = page.commands()[-3:]  # Arm and rostest do what precedes
        self.terminal(publish, folder)
        self.arm = Arm()
        self.terminal(launch, folder)
        service = "/contact_monitor/check_states"
        rospy.wait_for_service(service, WAIT_S)
        self.service = rospy.ServiceProxy(service, CheckStates)
        wait_until(lambda: self.states_of([UPRIGHT_ARM])[0] == ContactState.NONE, "all transforms")

    def states_of(self, positions, **fields):
        positions = np.array(positions)
        checked = self.service(StatesToCheck(
            joint_names=JOINTS[:positions.shape[1]], positions=positions.flatten(),
            **fields)).checked
        self.assertTrue(checked.success, checked.reason)
        return np.array(list(checked.state))

    def links_at(self, positions):
        """Those that touch the cloth, by the oracle."""
        poses = self.arm.poses(list(positions) + UPRIGHT_ARM[len(positions):])
        bodies = {link: posed(mesh, poses[link]) for link, mesh in self.links.items()}
        return touching(oracle_pairs(bodies, "cloth", self.cloth))

    def is_valid_for_moveit(self, positions):
        words = [word for joint, value in zip(JOINTS, positions) for word in (joint, str(value))]
        done = subprocess.run([executable("cloth_validity")] + words, check=True,
                              stdout=subprocess.PIPE, universal_newlines=True, timeout=WAIT_S)
        return done.stdout == "valid\n"

    def test_the_path_is_free(self):
        self.start_all()
        monitor = Monitor()
        message = Log("/cloth", DeformableMesh).wait("the cloth")
        self.cloth = to_mesh(message.vertices, message.triangles)
        self.links = monitor.robot_meshes(monitor.robot_meshes_log())
        del self.links["base_link"]
        done = subprocess.run(["bash", "-c", self.plan], cwd=str(SOURCE), stdout=subprocess.PIPE,
                              check=True, universal_newlines=True, timeout=WAIT_S)
        path = np.array([line.split() for line in done.stdout.splitlines()], float)
        self.assertEqual(path.shape, (3, 4))
        for a, b in zip(path, path[1:]):
            dense = np.linspace(a, b, DENSE)
            for fields in ({"first_only": True}, {"margin": 0.015}):
                np.testing.assert_array_equal(self.states_of(dense, **fields), ContactState.NONE)
            for positions in dense[::ORACLE_EVERY]:
                self.assertEqual(self.links_at(positions), set())

        straight = np.linspace(path[0], path[2], 41)
        states = self.states_of(straight)
        self.assertIn(ContactState.CONTACT, states)
        for positions, state in zip(straight, states):
            expected = ContactState.CONTACT if self.links_at(positions) else ContactState.NONE
            self.assertEqual(state, expected)
        self.assertTrue(self.is_valid_for_moveit(path[1]))
        self.assertFalse(self.is_valid_for_moveit(straight[20]))


if __name__ == "__main__":
    rospy.init_node("plan_around_a_cloth_test")
    rostest.rosrun(PACKAGE, "plan_around_a_cloth", PlanAroundACloth, sys.argv)
