#!/usr/bin/env python3
"""Three arms of one URDF above a tissue. Contacts with the tissue and between the arms must be the
oracle's, and rules, margins, readers and the guard must know the links by their prefixes."""
import itertools
import pathlib
import sys
import unittest
import xml.etree.ElementTree as ElementTree

import rospy
import rostest
from std_msgs.msg import Bool

from monitor_test_support import (
    PACKAGE, ContactState, Log, MeshPublisher, Monitor, Transforms, grid, now, oracle_pairs,
    oracle_pairs_between, pairs_of, posed_links, touching, until_frames_are_seen,
    wait_until)
from panda_scene import joint_edges

CONFIG = pathlib.Path(__file__).resolve().parents[2] / "config"
FRAME = "world"
MOUNTS = {"PSM1/": (-0.08, 0.0, 0.15), "PSM2/": (0.08, 0.0, 0.15), "PSM3/": (0.0, 0.1, 0.15)}
TISSUE = grid(12, 0.2)
ABOVE = {"insertion": 0.1}
DOWN = {"insertion": 0.145}
# By arm, where the joints are that are not zero.
POSES = {
    "above": (ABOVE, ABOVE, ABOVE),
    "first": (DOWN, ABOVE, ABOVE),
    "all": ({"insertion": 0.15}, {"insertion": 0.15, "jaw": 0.5},
            {"insertion": 0.15, "pitch": -0.2}),
    "crossed": ({"insertion": 0.16, "yaw": -0.6}, {"insertion": 0.16, "yaw": 0.6}, ABOVE),
}


def of_arm(prefix, bodies):
    return {name: mesh for name, mesh in bodies.items() if name.startswith(prefix)}


class ThreeArms(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.meshes = cls.monitor.robot_meshes(cls.monitor.robot_meshes_log())
        cls.joints = ElementTree.parse(CONFIG / "surgical_arm.urdf").getroot().findall("joint")
        cls.transforms = Transforms()
        cls.tissue = MeshPublisher("tissue", "/tissue")
        until_frames_are_seen(lambda: cls.show("above"))

    @classmethod
    def edges(cls, pose):
        edges = {}
        for (prefix, place), values in zip(MOUNTS.items(), POSES[pose]):
            of_all = {joint.get("name"): values.get(joint.get("name"), 0) for joint in cls.joints}
            of_all["jaw_mirror"] = of_all["jaw"]
            edges[prefix + "base"] = FRAME, (place, (0, 0, 0, 1))
            edges.update(joint_edges(cls.joints, of_all, prefix))
        return edges

    @classmethod
    def show(cls, pose):
        """Returns the contacts of the tissue's cycle."""
        stamp = now()
        cls.transforms.send(stamp, cls.edges(pose))
        cls.tissue.send(stamp, FRAME, TISSUE)
        return cls.monitor.contacts_at(stamp)

    def links_at(self, stamp):
        """{link: posed mesh}."""
        return posed_links(self.meshes, lambda link: self.transforms.pose(FRAME, link, stamp))

    def test_the_links_have_their_prefixes(self):
        names = [link.get("name") for link in
                 ElementTree.parse(CONFIG / "surgical_arm.urdf").getroot().findall("link")]
        self.assertEqual(list(self.meshes), [p + name for p in MOUNTS for name in names])

    def test_contacts_with_the_tissue_are_the_oracles(self):
        touched = {}
        for pose in POSES:
            contacts = self.show(pose)
            self.assertEqual(contacts.skipped, [])
            expected = oracle_pairs(self.links_at(contacts.header.stamp), "tissue", TISSUE)
            touched[pose] = touching(expected)
            expected = {pair for pair in expected if pair[0] != "PSM1/wrist"}  # it is allowed
            self.assertEqual({p for p in pairs_of(contacts) if p[2] == "tissue"}, expected)
        self.assertEqual(touched["above"], set())
        self.assertEqual(touched["first"], {"PSM1/left_jaw", "PSM1/right_jaw"})
        self.assertLess({"PSM1/wrist", "PSM2/wrist", "PSM3/left_jaw"}, touched["all"])

    def robots_cycle(self, pose):
        """Contacts of a cycle of the links alone, when they stand in that pose."""
        self.show(pose)  # a cycle before this one may be of the former pose
        since, stamp = self.monitor.contacts.count(), self.show(pose).header.stamp
        return self.monitor.contacts.wait(
            "the robots' own cycle", lambda m: m.header.stamp >= stamp and any(
                on for on, kind in zip(m.triggered, m.body_kind) if kind == m.LINK), since)

    def test_contacts_between_the_arms_are_the_oracles(self):
        for pose, touches in (("above", False), ("crossed", True)):
            contacts = self.robots_cycle(pose)
            links = self.links_at(contacts.header.stamp)
            expected = set()
            for a, b in itertools.combinations(MOUNTS, 2):
                expected |= oracle_pairs_between(of_arm(a, links), of_arm(b, links))
            self.assertEqual({p for p in pairs_of(contacts) if p[2] != "tissue"}, expected)
            self.assertEqual(bool(expected), touches)
            if touches:
                self.assertIn(("PSM1/shaft", "PSM2/shaft"), {(p[0], p[2]) for p in expected})

    def test_an_srdf_holds_within_its_arm(self):
        states = self.monitor.states_of(self.robots_cycle("crossed"))
        allowed = {pair for pair, s in states.items() if s.state == ContactState.ALLOWED}
        rules = ElementTree.parse(CONFIG / "surgical_arm.srdf").getroot()
        expected = {frozenset((prefix + rule.get("link1"), prefix + rule.get("link2")))
                    for prefix in MOUNTS for rule in rules.findall("disable_collisions")}
        self.assertEqual({frozenset(pair) for pair in allowed},
                         expected | {frozenset(("PSM1/wrist", "tissue"))})
        self.assertEqual(states["PSM1/shaft", "PSM2/shaft"].state, ContactState.CONTACT)

    def test_margins_have_the_links_prefix(self):
        states = self.monitor.states_of(self.show("above"))
        for link, state in (("PSM3/left_jaw", ContactState.NEAR), ("PSM2/left_jaw", ContactState.NONE)):
            self.assertEqual(states[link, "tissue"].state, state, link)

    def test_the_guard_knows_the_link(self):
        stops = Log("/contact_guard/stop", Bool)
        for pose, stop in (("first", False), ("all", True), ("first", False)):
            def says_so():
                self.monitor.states_of(self.show(pose))
                return stops.wait("the guard", since=stops.count()).data == stop
            wait_until(says_so, f"stop {stop} of the guard in pose {pose}")


if __name__ == "__main__":
    rospy.init_node("three_arms_test")
    rostest.rosrun(PACKAGE, "three_arms", ThreeArms, sys.argv)
