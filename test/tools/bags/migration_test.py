#!/usr/bin/env python3
"""Messages stay as they are: their MD5 sums, and the rules that bring bags of version 0.1 to them.
recorded_0_1.bag was recorded with version 0.1: its demo's arm and cloth."""
import csv
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import rosbag
from rosbag.migration import MessageMigrator, checkbag, fixbag2

from deformable_contact_monitor import msg, srv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
OLD_BAG = HERE / "recorded_0_1.bag"
RULES = ROOT / "msg" / "from_0_1.bmr"
TOOL = os.environ["EVALUATE_BAG"]
CONTACTS, STATES = "/contact_monitor/contacts", "/contact_monitor/contact_states"
EVENTS = "/contact_monitor/contact_events"

# Of version 0.2. Who changes a message adds a rule of migration, and a bag that was recorded before.
MD5 = {
    "AllowedContact": "4e2b07c1a4705e8d86a3db9f579c598f",
    "AttachObject": "dbc0a530fa5dff971b50d7a106f31ac2",
    "ContactArray": "6b4142207053bf261b9af7201580ce11",
    "ContactEvent": "e55736c25137f44cb897b1d3313e8243",
    "ContactGeometry": "69444e8346d34b2a00cdea8dc533c95b",
    "ContactPair": "48b265effdb9209663c7372072597df1",
    "ContactPatch": "905c4e285445e3c571c94cd371d97270",
    "ContactPatches": "f0bc9e7c2cc4471c0a91ee87d4713d0a",
    "ContactState": "5377b2a9a9436a0d537fe646f25ec685",
    "ContactStates": "202e64cd71c9607fe24b55881f5fe59e",
    "DeformableMesh": "862e992f505c74bc0fbe5996f972b2e6",
    "GetContacts": "c1090ebdc71fc3951c39e22da4f1cf87",
    "LinkMesh": "3da062f9797ab898734a4a87678d4843",
    "LinkMeshes": "0b911e759aca1832ac28cfa4b75ff854",
    "SetAllowedContacts": "58f084afbfa0b6c38ef90a19eb55201a",
    "SweptContacts": "01760a1f3ca41ca2e83776344d5507b6",
}
# What 0.1 had under the same name with the same meaning.
KEPT = {
    CONTACTS: ("header", "cycle", "bodies", "body_kind", "body_stamps", "topology_ids", "pairs",
               "pair_count", "complete", "guaranteed", "truncated", "undecided",
               "rejected_triangles", "skipped", "backend", "predicates", "overlap", "compute_time",
               "age"),
    EVENTS: ("header", "body_a", "body_b", "type", "pair_count", "reason")}
KEPT_OF_STATE = ("body_a", "body_b", "state", "pair_count", "centroid", "mean_normal", "since")


def messages(path, topic):
    with rosbag.Bag(str(path)) as bag:
        return [message for _, message, _ in bag.read_messages(topics=[topic])]


class Migration(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def migrated(self):
        path = self.folder / "migrated.bag"
        self.assertEqual(fixbag2(MessageMigrator([str(RULES)], False), str(OLD_BAG), str(path)), [])
        return path

    def test_the_sums(self):
        found = {name: getattr(where, name)._md5sum for where in (msg, srv) for name in dir(where)
                 if name[0].isupper() and not name.endswith(("Request", "Response"))}
        self.assertEqual(found, MD5)

    def test_every_type_has_its_rule(self):
        migrator = MessageMigrator([str(RULES)], False)
        self.assertEqual([rules for _, rules in checkbag(migrator, str(OLD_BAG)) if rules], [])
        self.assertNotEqual(checkbag(MessageMigrator([], False), str(OLD_BAG)), [])

    def test_what_was_recorded_is_still_there(self):
        path = self.migrated()
        for topic, names in KEPT.items():
            old, new = messages(OLD_BAG, topic), messages(path, topic)
            self.assertEqual(len(old), len(new))
            self.assertTrue(old)
            for before, after in zip(old, new):
                for name in names:
                    self.assertEqual(str(getattr(before, name)), str(getattr(after, name)), name)
        self.assertGreater(max(m.pair_count for m in messages(path, CONTACTS)), 200)

    def test_new_fields_say_what_version_0_1_meant(self):
        path = self.migrated()
        for contacts in messages(path, CONTACTS):
            self.assertEqual(contacts.triggered, [not t.is_zero() for t in contacts.body_stamps])
            self.assertEqual((contacts.timed_out, contacts.tolerance), (False, 0))
        old = messages(OLD_BAG, STATES)
        for before, after in zip(old, messages(path, STATES)):
            for b, a in zip(before.states, after.states):
                for name in KEPT_OF_STATE:
                    self.assertEqual(str(getattr(b, name)), str(getattr(a, name)), name)
                self.assertEqual(a.stamp, before.header.stamp)
                self.assertEqual(bool(a.reason), a.state == msg.ContactState.UNKNOWN)
            self.assertEqual(len(before.states), len(after.states))

    def test_geometry(self):
        migrator = MessageMigrator([str(RULES)], False)
        rule = next(r.rule for r in migrator.base_nodes
                    if r.new_class._type.endswith("/ContactGeometry"))
        old = rule.old_class()
        old.point.x, old.normal.z, old.separation, old.flags = 3, 1, 0.5, 2
        new = msg.ContactGeometry()
        migrator.migrate(old, new)
        self.assertEqual((new.point_a.x, new.point_b.x, new.normal.z, new.separation, new.flags),
                         (3, 3, 1, 0.5, 2))

    def test_the_same_pairs_are_found_in_both(self):
        def pairs(path, name):
            out = self.folder / name
            subprocess.run([TOOL, str(path), "--config", str(ROOT / "config" / "demo.yaml"), "--out",
                            str(out), "--pairs", "--no-report", "--backends", "cpu"], check=True,
                           timeout=60, stdout=subprocess.DEVNULL)
            with open(out / "pairs.csv", newline="") as file:
                return [tuple(row.values())[1:] for row in csv.DictReader(file)]
        found = pairs(OLD_BAG, "old")
        self.assertEqual(found, pairs(self.migrated(), "new"))
        recorded = {(f"{m.header.stamp.secs}.{m.header.stamp.nsecs:09}", m.bodies[p.body_a],
                     str(p.triangle_a), m.bodies[p.body_b], str(p.triangle_b))
                    for m in messages(OLD_BAG, CONTACTS) for p in m.pairs}
        self.assertEqual(set(found), recorded)
        self.assertGreater(len(recorded), 700)


if __name__ == "__main__":
    sys.exit(unittest.main())
