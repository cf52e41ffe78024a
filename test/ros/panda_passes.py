#!/usr/bin/env python3
"""Moves a Panda's finger through a cloth between two meshes. With instant motion both states are
NONE; with swept motion the state is PASSED, with the exact oracle's pairs."""
import os
import subprocess
import sys
import tempfile
import unittest

import numpy as np
import rospy
import rostest
from std_srvs.srv import Trigger

from deformable_contact_monitor.msg import ContactEvent, SweptContacts
from deformable_contact_monitor.srv import GetContacts
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, MeshPublisher, Monitor, Transforms, executable, grid, now,
    oracle_pairs, pairs_of, posed_links, touching, until_frames_are_seen)
from panda_scene import READY, REFERENCE_FRAME, Panda
from pose_meshes import write_ply

NAMES = ("instant", "linear", "turning")
NONE, PASSED = ContactState.NONE, ContactState.PASSED
FINGERS = {"panda_leftfinger", "panda_rightfinger"}
STEP_S, SAMPLE_S = 0.1, 0.005
TURN = 0.4  # of the first joint in a step [rad]
FAR_AWAY = (0, 0, 5)


class SweptMonitor(Monitor):

    def __init__(self, name):
        super().__init__("/" + name)
        self.steps = Log(f"/{name}/swept_contacts", SweptContacts)

    def step_to(self, stamp):
        return self.steps.wait(f"a step to {stamp}", lambda m: m.header.stamp == stamp)


class PandaPasses(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.instant = Monitor("/instant")
        cls.linear, cls.turning = SweptMonitor("linear"), SweptMonitor("turning")
        cls.monitors = (cls.instant, cls.linear, cls.turning)
        cls.panda = Panda(rospy.get_param("~data"))
        cls.transforms = Transforms(listeners=3)
        cls.cloth = MeshPublisher("cloth", "/cloth", listeners=3)
        cls.meshes = cls.instant.robot_meshes(cls.instant.robot_meshes_log())
        cls.stamp = now()

        def cycle():
            cls.show(now(cls.stamp), 0, cls.sheet(FAR_AWAY))
            all_contacts = [monitor.contacts_at(cls.stamp) for monitor in cls.monitors]
            return max(all_contacts, key=lambda contacts: len(contacts.skipped))
        until_frames_are_seen(cycle)

    @staticmethod
    def sheet(centre):
        """A small cloth that stands upright across the finger's way."""
        vertices, triangles = grid(8, 0.04)
        upright = vertices[:, [0, 2, 1]]
        return (upright + np.float32(centre)).astype(np.float32), triangles

    @classmethod
    def show(cls, stamp, turned, mesh, transforms_late_s=0):
        cls.stamp = stamp
        angles = [READY[0] - TURN / 2 + turned * TURN] + READY[1:]
        cls.cloth.send(stamp, REFERENCE_FRAME, mesh)
        rospy.sleep(transforms_late_s)
        cls.transforms.send(stamp, cls.panda.edges(angles, 0.02, (FAR_AWAY, (0, 0, 0, 1))))

    def links_at(self, stamp):
        return posed_links(self.meshes, lambda link: self.transforms.pose(
            REFERENCE_FRAME, link, stamp))

    def finger_tip(self):
        """Where the fingers' tips are halfway, a little below [m]."""
        stamp = now(self.stamp)
        self.show(stamp, 0.5, self.sheet(FAR_AWAY))
        self.instant.contacts_at(stamp)
        tips = [link[0][np.argsort(link[0][:, 2])[:20]].mean(axis=0)
                for name, link in self.links_at(stamp).items() if name in FINGERS]
        return tuple(np.mean(tips, axis=0))

    def pass_through(self):
        """The stamps before and behind it and of a cycle that stands still, and the cloth."""
        mesh = self.sheet(self.finger_tip())
        for monitor in self.monitors:
            since = monitor.states.count()
            rospy.ServiceProxy(monitor.name + "/reset", Trigger)()
            latest = rospy.ServiceProxy(monitor.name + "/get_contacts", GetContacts)()
            self.assertFalse(latest.available and latest.contacts.complete)
            monitor.states.wait("the reset", since=since, wanted=lambda m: any(
                state.reason == "reset" for state in m.states))
        before = now(self.stamp)
        behind = before + rospy.Duration(STEP_S)
        self.transforms.buffer.clear()
        self.show(before, 0, mesh, transforms_late_s=0.05)  # waited for, also after a reset
        for monitor in self.monitors:
            self.assertEqual(pairs_of(monitor.contacts_at(before)), set())
        rospy.sleep(STEP_S)
        self.show(behind, 1, mesh)
        for monitor in self.monitors:
            contacts = monitor.contacts_at(behind)
            self.assertEqual(contacts.skipped, [])
            self.assertEqual(pairs_of(contacts), set(), "the scene is not what this test is about")
        last = now(behind)
        self.show(last, 1, mesh)
        for monitor in self.monitors:
            monitor.contacts_at(last)
        return before, behind, last, mesh

    def oracle(self, before, behind, mesh):
        """{(link, triangle, "cloth", triangle): (low, high) of the first time} on straight lines."""
        pairs = {}
        links0, links1 = self.links_at(before), self.links_at(behind)
        with tempfile.TemporaryDirectory() as folder:
            files = [os.path.join(folder, name) for name in ("a0.ply", "a1.ply", "b.ply")]
            write_ply(files[2], mesh)
            for link in self.meshes:
                write_ply(files[0], links0[link])
                write_ply(files[1], links1[link])
                lines = subprocess.run(
                    [executable("swept_pairs"), *files, files[2]], check=True, timeout=2 * WAIT_S,
                    stdout=subprocess.PIPE, universal_newlines=True).stdout.splitlines()
                for line in lines:
                    a, b, low, high = line.split()
                    pairs[link, int(a), "cloth", int(b)] = float(low), float(high)
        return pairs

    def check_states(self, monitor, stamp, wanted):
        states = monitor.states_at(stamp)
        self.assertEqual(states, {(link, "cloth"): wanted(link) for link in self.meshes})

    def test_a_finger_goes_through_the_cloth(self):
        before, behind, last, mesh = self.pass_through()
        for stamp in (before, behind):
            self.check_states(self.instant, stamp, lambda link: NONE)
        for monitor in (self.linear, self.turning):
            self.check_states(monitor, before, lambda link: NONE)
            first = monitor.step_to(before)
            self.assertTrue(first.from_stamp.is_zero())
            self.assertIn("cloth: reset", first.skipped)

        exact = self.oracle(before, behind, mesh)
        self.assertLessEqual(touching(exact), FINGERS)
        self.assertGreater(len(exact), 20)
        step = self.linear.step_to(behind)
        self.assertEqual(pairs_of(step), set(exact))
        self.assertEqual((step.from_stamp, step.pad, step.within_pad), (before, 0, []))
        self.assertTrue(step.complete, step.skipped)
        for pair, low, high in zip(step.pairs, step.first_low, step.first_high):
            true_low, true_high = exact[step.bodies[pair.body_a], pair.triangle_a, "cloth",
                                        pair.triangle_b]
            self.assertLessEqual(low, true_high)
            self.assertGreaterEqual(high, true_low)
            self.assertLessEqual(high - low, 2.0 ** -19)
        self.check_states(self.linear, behind,
                          lambda link: PASSED if link in touching(exact) else NONE)
        for link in touching(exact):
            event = self.linear.events.wait(f"{link} passed", lambda m: m.type == ContactEvent.PASSED
                                            and m.body_a == link and m.header.stamp == behind)
            self.assertAlmostEqual(event.first_low, min(
                low for pair, (low, _) in exact.items() if pair[0] == link), delta=1e-5)
        self.check_turning(before, behind, mesh)

        for monitor in (self.linear, self.turning):
            self.check_states(monitor, last, lambda link: NONE)
            step = monitor.step_to(last)
            self.assertEqual((pairs_of(step), step.complete), (set(), True))

    def check_turning(self, before, behind, mesh):
        """The arcs: whatever touches at a time at which the monitor asked for transforms is there."""
        step = self.turning.step_to(behind)
        self.assertTrue(step.complete, step.skipped)
        self.assertGreater(step.pad, 0)
        self.assertLess(step.pad, 2.5e-4)
        self.assertEqual(len(step.within_pad), len(step.pairs))
        true = set()
        samples = round(STEP_S / SAMPLE_S)
        for i in range(1, samples):
            at = before + rospy.Duration(nsecs=(behind - before).to_nsec() * i // samples)
            true |= oracle_pairs(self.links_at(at), "cloth", mesh)
        self.assertGreater(len(true), 20)
        self.assertLessEqual(true, pairs_of(step))
        self.check_states(self.turning, behind, lambda link: PASSED if link in touching(
            pairs_of(step)) else NONE)
        self.assertLessEqual(touching(pairs_of(step)), FINGERS)


if __name__ == "__main__":
    rospy.init_node("panda_passes_test")
    rostest.rosrun(PACKAGE, "panda_passes", PandaPasses, sys.argv)
