#!/usr/bin/env python3
"""Moves the Panda and a T-shirt. The pairs must be the oracle's on meshes that the test transforms
itself."""
import sys
import unittest

import numpy as np
import rospy
import rostest

from monitor_test_support import (
    PACKAGE, ContactState, Monitor, now, oracle_pairs, pairs_of, posed_links, touching)
from panda_scene import READY, REFERENCE_FRAME, PandaScene

IN_CONTACT_AT = (0.35, 0.05, 0.5)  # [m], the shirt's frame
FAR_AT = (0.35, 0.05, 2.5)


def pins(links):
    """Triangles that stand outwards on every vertex of {link: posed mesh}: most touch in that point
    alone, and only if it is the same to the last bit."""
    corners = []
    for vertices, _ in links.values():
        tips = np.unique(vertices, axis=0).astype(np.float64)
        outwards = tips - tips.mean(axis=0)
        outwards *= 0.05 / np.linalg.norm(outwards, axis=1, keepdims=True)
        sideways = 0.02 * np.cross(outwards, [1.0, 0.0, 0.0])
        corners.append(np.stack([tips, tips + outwards + sideways, tips + outwards - sideways], 1))
    corners = np.concatenate(corners).astype(np.float32).reshape(-1, 3)
    return corners, np.arange(len(corners), dtype=np.uint32).reshape(-1, 3)


class PandaTshirt(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.robot_log = cls.monitor.robot_meshes_log()
        cls.scene = PandaScene(rospy.get_param("~data"))
        cls.scene.show_until_seen(cls.monitor)

    def test_link_meshes_are_those_of_the_files(self):
        sent = self.monitor.robot_meshes(self.robot_log)
        self.assertEqual(list(sent), list(self.scene.links))
        for link, (vertices, triangles) in self.scene.links.items():
            corners = sent[link][0][sent[link][1]]
            self.assertEqual(len(corners), len(triangles), link)
            np.testing.assert_allclose(corners, vertices[triangles], atol=1e-7, err_msg=link)

    def test_pairs_in_contact_and_out_of_it(self):
        meshes = self.monitor.robot_meshes(self.robot_log)
        found = {}
        stamp = None
        for step, frame in enumerate([0, 4, 9, 14, 19, 19, 3]):
            away = step >= 5
            stamp = now(after=stamp)
            self.scene.show(stamp, frame, step, FAR_AT if away else IN_CONTACT_AT)
            contacts = self.monitor.contacts_at(stamp)
            states = self.monitor.states_at(stamp)
            expected = self.scene.expected(stamp, frame, meshes)
            self.assertEqual(expected == set(), away, "the scene is not what this test is about")
            self.assertEqual(pairs_of(contacts), expected)
            self.assertTrue(contacts.complete, contacts.skipped)
            self.assertEqual(contacts.header.frame_id, REFERENCE_FRAME)
            self.assertEqual(contacts.bodies, list(meshes) + ["tshirt"])
            touched = touching(expected)
            for link in meshes:
                wanted = ContactState.CONTACT if link in touched else ContactState.NONE
                self.assertEqual(states[link, "tshirt"], wanted, link)
            found[step] = expected
        self.assertEqual(len(set(map(frozenset, found.values()))), 6, "the pairs never changed")

    def test_vertices_are_posed_to_the_last_bit(self):
        meshes = self.monitor.robot_meshes(self.robot_log)
        stamp = now()
        self.scene.transforms.send(stamp, self.scene.edges(READY, 0.01, ((0, 0, 0), (0, 0, 0, 1))))
        links = posed_links(meshes, lambda link: self.scene.transforms.pose(
            REFERENCE_FRAME, link, stamp))
        mesh = pins(links)
        self.scene.shirt.send(stamp, REFERENCE_FRAME, mesh, topology_id=2)
        expected = oracle_pairs(links, "tshirt", mesh)
        self.assertEqual(touching(expected), set(meshes))
        self.assertEqual(pairs_of(self.monitor.contacts_at(stamp)), expected)


if __name__ == "__main__":
    rospy.init_node("panda_tshirt_test")
    rostest.rosrun(PACKAGE, "panda_tshirt", PandaTshirt, sys.argv)
