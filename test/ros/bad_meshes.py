#!/usr/bin/env python3
"""Sends no mesh, the same mesh again and again, and bad meshes. The monitor must name what is
wrong, and no other object may be affected. Two more monitors run: one that lacks the mesh file
of a link, and one without objects."""
import sys
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from visualization_msgs.msg import Marker, MarkerArray

import boxes_scene
from boxes_scene import CLOTH, FAR_CLOTH, SMALL_CLOTH
from monitor_test_support import (
    PACKAGE, ContactState, Log, MeshPublisher, Monitor, Transforms, mesh_message, now,
    pairs_of, peak_memory_mib, touching, until_frames_are_seen, with_length)

UNKNOWN, CONTACT, NONE = ContactState.UNKNOWN, ContactState.CONTACT, ContactState.NONE
BOXES = ("palm", "finger")


def counts_of_cloth(diagnostics):
    """received, dropped, refused, topology changes; None if they are not in this message."""
    for status in diagnostics.status:
        if status.name == "contact_monitor: mesh:cloth":
            values = {value.key: value.value for value in status.values}
            return [int(values[key]) for key in ("received", "dropped", "refused",
                                                 "topology changes")]
    return None


class BadMeshes(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor("/contact_monitor")
        cls.incomplete = Monitor("/incomplete_robot")
        cls.idle = Monitor("/nothing_to_do")
        cls.meshes = cls.monitor.robot_meshes(cls.monitor.robot_meshes_log())
        cls.transforms = Transforms(listeners=3)
        cls.cloth = MeshPublisher("cloth", "/cloth", listeners=2)
        cls.sheet = MeshPublisher("sheet", "/sheet")
        cls.stamp = None
        cls.topology_id = 0

    def setUp(self):
        if "without_a_mesh" not in self.id():
            until_frames_are_seen(lambda: self.send_cloth(FAR_CLOTH))

    def send(self, publisher, mesh, **arguments):
        """Sends transforms and a mesh; the contacts of its cycle."""
        cls = type(self)
        cls.stamp = now(after=cls.stamp)
        self.transforms.send(cls.stamp, boxes_scene.edges())
        publisher.send(cls.stamp, boxes_scene.REFERENCE_FRAME, mesh, **arguments)
        return self.monitor.contacts_at(cls.stamp)

    def send_cloth(self, mesh, topology_id=None, keyframe=True, sheet=FAR_CLOTH):
        """After the sheet; with a topology id that was never used, unless it is given."""
        cls = type(self)
        cls.topology_id += 10
        self.sheets_contacts = self.send(self.sheet, sheet)
        return self.send(self.cloth, mesh, topology_id=topology_id or cls.topology_id,
                         keyframe=keyframe)

    def expected(self, mesh, name="cloth"):
        return boxes_scene.expected(self.meshes, self.transforms, self.stamp, mesh, name)

    def states(self):
        return self.monitor.states_at(self.stamp)

    def states_now(self):
        states = self.monitor.states.wait("states", since=self.monitor.states.count())
        return {(s.body_a, s.body_b): s.state for s in states.states}

    def reason(self, contacts, body):
        """Why the body was skipped."""
        reasons = [text for text in contacts.skipped if text.startswith(body + ": ")]
        self.assertEqual(len(reasons), 1, contacts.skipped)
        return reasons[0]

    def test_0_without_a_mesh_everything_is_unknown_once_a_second(self):
        for monitor, objects in ((self.monitor, ["cloth", "sheet"]), (self.idle, [])):
            since = monitor.contacts.count()
            first = monitor.contacts.wait("a heartbeat", since=since)
            second = monitor.contacts.wait("another", lambda m: m.cycle > first.cycle, since)
            self.assertEqual(second.cycle, first.cycle + 1)
            for contacts in (first, second):
                self.assertEqual(contacts.bodies, list(BOXES) + objects)
                self.assertEqual(contacts.pairs, [])
                self.assertFalse(contacts.complete)
                self.assertEqual([text.split(":")[0] for text in contacts.skipped], objects)
            # Wall time, as both came by a wall clock: not faster than the heart beats.
            self.assertGreater((second.header.stamp - first.header.stamp).to_sec(), 0.5)
            states = monitor.states_at(second.header.stamp)
            self.assertEqual(states, {(box, name): UNKNOWN for box in BOXES for name in objects})

    def test_1_a_stationary_scene_gives_the_same_pairs_each_cycle(self):
        wanted = None
        for cycle in range(6):
            contacts = self.send_cloth(CLOTH, topology_id=1, keyframe=cycle % 3 == 0)
            wanted = wanted or self.expected(CLOTH)
            self.assertEqual(touching(wanted), set(BOXES))
            self.assertEqual(pairs_of(contacts), wanted)
            self.assertTrue(contacts.complete, contacts.skipped)
            self.assertEqual(self.states(), {("palm", "cloth"): CONTACT,
                                             ("finger", "cloth"): CONTACT,
                                             ("palm", "sheet"): NONE,
                                             ("finger", "sheet"): NONE})

    def test_far_off_is_none_and_complete(self):
        contacts = self.send_cloth(FAR_CLOTH)
        self.assertEqual(contacts.pairs, [])
        self.assertEqual(contacts.skipped, [])
        self.assertTrue(contacts.complete)
        self.assertEqual(set(self.states().values()), {NONE})

    def test_a_missing_mesh_file_makes_that_link_unknown(self):
        def cycle():
            self.send_cloth(CLOTH)
            return self.incomplete.contacts_at(self.stamp)
        until_frames_are_seen(cycle)
        contacts = cycle()
        states = self.incomplete.states_at(self.stamp)
        self.assertEqual(pairs_of(contacts), self.expected(CLOTH))
        self.assertIn("no_such_package/meshes/lost.stl", self.reason(contacts, "lost"))
        self.assertFalse(contacts.complete)
        self.assertEqual(states, {("palm", "cloth"): CONTACT, ("finger", "cloth"): CONTACT,
                                  ("lost", "cloth"): UNKNOWN})

    def test_nan_vertices_cost_their_own_triangles(self):
        vertices, triangles = CLOTH[0].copy(), CLOTH[1]
        self.send_cloth(CLOTH)
        clean = self.expected(CLOTH)
        bad_vertices = [triangles[next(iter(clean))[3]][0], 0]  # one of a contact, one of a corner
        vertices[bad_vertices[0], 1] = np.nan
        vertices[bad_vertices[1], 2] = np.inf
        bad = {int(t) for t in np.nonzero(np.isin(triangles, bad_vertices).any(axis=1))[0]}
        contacts = self.send_cloth((vertices, triangles))
        self.assertEqual(contacts.rejected_triangles, len(bad))
        self.assertFalse(contacts.complete)
        self.assertEqual(contacts.skipped, [])
        wanted = {pair for pair in clean if pair[3] not in bad}
        self.assertTrue(set() < wanted < clean, "the scene is not what this test is about")
        self.assertEqual(pairs_of(contacts), wanted)

    def test_indices_out_of_range_cost_that_object_alone(self):
        beyond = CLOTH[1].copy()
        beyond[17, 1] = len(CLOTH[0])
        contacts = self.send_cloth((CLOTH[0], beyond), sheet=SMALL_CLOTH)
        self.assertIn("triangle 17", self.reason(contacts, "cloth"))
        self.assertEqual(contacts.pairs, [])
        self.assertEqual(pairs_of(self.sheets_contacts), self.expected(SMALL_CLOTH, "sheet"))
        self.assertTrue(self.sheets_contacts.complete, self.sheets_contacts.skipped)
        self.assertEqual(self.states(), {("palm", "cloth"): UNKNOWN, ("finger", "cloth"): UNKNOWN,
                                         ("palm", "sheet"): CONTACT, ("finger", "sheet"): CONTACT})
        self.assertFalse(contacts.complete)
        contacts = self.send_cloth(CLOTH)
        self.assertEqual(pairs_of(contacts), self.expected(CLOTH))

    def test_vertices_that_do_not_fit_cost_that_object_alone(self):
        self.send_cloth(CLOTH)
        topology_id = self.topology_id
        contacts = self.send_cloth((CLOTH[0][:-1], CLOTH[1]), topology_id, keyframe=False)
        self.assertIn("vertices", self.reason(contacts, "cloth"))
        self.assertEqual(self.states()["palm", "cloth"], UNKNOWN)
        contacts = self.send_cloth(CLOTH, topology_id, keyframe=False)
        self.assertEqual(self.states()["palm", "cloth"], CONTACT)

    def test_a_topology_change_takes_effect_with_its_triangles(self):
        contacts = self.send_cloth(CLOTH, topology_id=2)
        self.assertEqual(pairs_of(contacts), self.expected(CLOTH))
        contacts = self.send_cloth(SMALL_CLOTH, topology_id=3)
        self.assertEqual(contacts.topology_ids[contacts.bodies.index("cloth")], 3)
        self.assertEqual(pairs_of(contacts), self.expected(SMALL_CLOTH))

        contacts = self.send_cloth(SMALL_CLOTH, topology_id=4, keyframe=False)
        self.assertIn("topology_id 4", self.reason(contacts, "cloth"))
        self.assertEqual(contacts.pairs, [])
        self.assertEqual(self.states()["palm", "cloth"], UNKNOWN)

        turned = (SMALL_CLOTH[0], SMALL_CLOTH[1][::-1])
        for keyframe in (True, False):
            contacts = self.send_cloth(turned, topology_id=4, keyframe=keyframe)
            self.assertEqual(contacts.topology_ids[contacts.bodies.index("cloth")], 4)
            self.assertEqual(pairs_of(contacts), self.expected(turned))

    def test_a_publisher_that_starts_anew_must_send_its_own_triangles(self):
        self.send_cloth(CLOTH)
        topology_id = self.topology_id
        self.cloth.publisher.unregister()
        type(self).cloth = MeshPublisher("cloth", "/cloth", listeners=2)
        contacts = self.send_cloth(CLOTH, topology_id, keyframe=False)
        self.assertIn(f"no triangles of topology_id {topology_id} seen from this publisher",
                      self.reason(contacts, "cloth"))
        self.assertEqual(self.states()["palm", "cloth"], UNKNOWN)
        for keyframe in (True, False):
            contacts = self.send_cloth(CLOTH, topology_id, keyframe=keyframe)
            self.assertEqual(pairs_of(contacts), self.expected(CLOTH))
            self.assertEqual(self.states()["palm", "cloth"], CONTACT)

    def test_a_claim_to_be_huge_costs_nothing(self):
        self.send_cloth(CLOTH)
        before_mib = peak_memory_mib("/contact_monitor")
        cls = type(self)
        cls.stamp = now(after=cls.stamp)
        message = mesh_message("cloth", cls.stamp, boxes_scene.REFERENCE_FRAME, SMALL_CLOTH)
        for claim in (750000000, 0x40000001):  # 3 GB, and what is 4 bytes in 32 bits
            self.cloth.publisher.publish(with_length(message, SMALL_CLOTH[0].size, claim))
            contacts = self.monitor.contacts.wait("a refusal", lambda m: any(
                str(4 * claim) in text for text in m.skipped))
            self.assertIn("vertices claims", self.reason(contacts, "cloth"))
        self.assertLess(peak_memory_mib("/contact_monitor"), before_mib + 200)
        self.assertEqual(self.states_now()["palm", "cloth"], UNKNOWN)
        self.assertEqual(pairs_of(self.send_cloth(CLOTH)), self.expected(CLOTH))

    def test_the_diagnostics_count_what_was_sent(self):
        log = Log("/diagnostics", DiagnosticArray)
        before = counts_of_cloth(log.wait("counts", counts_of_cloth, log.count()))
        self.send_cloth(CLOTH)
        self.send_cloth(SMALL_CLOTH, keyframe=False)  # no triangles of its topology id
        self.send_cloth(SMALL_CLOTH)
        self.cloth.send(self.stamp - rospy.Duration(0.01), boxes_scene.REFERENCE_FRAME, CLOTH,
                        topology_id=self.topology_id, keyframe=False)
        wanted = [count + more for count, more in zip(before, (4, 1, 1, 2))]
        log.wait(f"counts {wanted}", lambda m: counts_of_cloth(m) == wanted, log.count())

    def test_markers_come_with_contacts_and_go_with_them(self):
        log = Log("/contact_monitor/markers", MarkerArray)
        drawn = {}
        for name, mesh in (("in contact", CLOTH), ("apart", FAR_CLOTH)):
            sent = set()
            markers = None
            while markers is None:  # there are fewer marker arrays than cycles, and they come later
                self.send_cloth(mesh, topology_id=5)
                sent.add(self.stamp)
                arrays = [m.markers for m in list(log.messages)]
                markers = next((m for m in arrays if m[0].header.stamp in sent), None)
                self.assertLess(len(sent), 1000, "no markers of a cycle that was sent")
            added = [m for m in markers if m.action == Marker.ADD]
            self.assertTrue(all(m.points and m.lifetime.to_sec() > 0 for m in added))
            drawn[name] = {m.ns for m in added}
            deleted = {m.ns for m in markers if m.action == Marker.DELETE}
            self.assertLessEqual(deleted, {"palm/cloth", "finger/cloth"})
        self.assertEqual(log.messages[0].markers[0].action, Marker.DELETEALL,
                         "markers were made before anybody looked")
        self.assertEqual(drawn, {"in contact": {"palm/cloth", "finger/cloth", "cloth"},
                                 "apart": {"cloth"}})


if __name__ == "__main__":
    rospy.init_node("bad_meshes_test")
    rostest.rosrun(PACKAGE, "bad_meshes", BadMeshes, sys.argv)
