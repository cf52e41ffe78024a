#!/usr/bin/env python3
"""Messages stay as they are: their MD5 sums, and the rules that bring bags of older versions to them.
recorded_0_1.bag and recorded_0_2.bag were recorded with these versions: the demo's arm and a cloth;
0.2 with a margin of 8 mm and contact_geometry."""
import csv
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
from xml.etree import ElementTree

import rosbag
from rosbag.migration import MessageMigrator, checkbag, fixbag2

from deformable_contact_monitor import msg, srv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
BAG_0_1, BAG_0_2 = HERE / "recorded_0_1.bag", HERE / "recorded_0_2.bag"
RULES = [str(ROOT / "msg" / name) for name in ("from_0_1.bmr", "from_0_2.bmr")]
TOOL = os.environ["EVALUATE_BAG"]
CONTACTS, STATES = "/contact_monitor/contacts", "/contact_monitor/contact_states"
EVENTS = "/contact_monitor/contact_events"

# Of version 0.3. Who changes a message adds a rule of migration, and a bag that was recorded before.
MD5 = {
    "AllowedContact": "4e2b07c1a4705e8d86a3db9f579c598f",
    "AttachObject": "8719fb920e74a03fea6cd3678d10dec7",
    "CheckStates": "c85b5de8f10a24e7f16501f0133177e0",
    "ContactArray": "7e08734d93c542bf1e4deaac365dd4e5",
    "ContactEvent": "e55736c25137f44cb897b1d3313e8243",
    "ContactGeometry": "69444e8346d34b2a00cdea8dc533c95b",
    "ContactPair": "48b265effdb9209663c7372072597df1",
    "ContactPatch": "905c4e285445e3c571c94cd371d97270",
    "ContactPatches": "f0bc9e7c2cc4471c0a91ee87d4713d0a",
    "ContactState": "8dabfa6d11a5fa3049e11319d214ecbe",
    "ContactStates": "73257206c13ef3a715ea1797d762e484",
    "DeformableMesh": "862e992f505c74bc0fbe5996f972b2e6",
    "GetContacts": "1c93b82b20388049e3e6f5ca0557b1a0",
    "LinkMesh": "3da062f9797ab898734a4a87678d4843",
    "LinkMeshes": "0b911e759aca1832ac28cfa4b75ff854",
    "NearestTriangles": "50d2926476a6f3099fa0590352282580",
    "SetAllowedContacts": "58f084afbfa0b6c38ef90a19eb55201a",
    "StatesChecked": "00160c8d16c8837122e6fb991df7aab3",
    "StatesToCheck": "1972626dae44ed4ff05119be9ec9cc94",
    "SweptContacts": "01760a1f3ca41ca2e83776344d5507b6",
}
# What the old versions had under the same name with the same meaning.
KEPT_SINCE_0_1 = {
    CONTACTS: ("header", "cycle", "bodies", "body_kind", "body_stamps", "topology_ids", "pairs",
               "pair_count", "complete", "guaranteed", "truncated", "undecided",
               "rejected_triangles", "skipped", "backend", "predicates", "overlap", "compute_time",
               "age"),
    EVENTS: ("header", "body_a", "body_b", "type", "pair_count", "reason")}
KEPT_SINCE_0_2 = {
    CONTACTS: KEPT_SINCE_0_1[CONTACTS] + ("triggered", "timed_out", "tolerance", "geometry"),
    STATES: ("header", "cycle", "age", "complete", "tolerance"),
    EVENTS: KEPT_SINCE_0_1[EVENTS] + ("first_low",)}
KEPT_OF_STATE = ("body_a", "body_b", "state", "pair_count", "centroid", "mean_normal", "since")
KEPT_OF_STATE_SINCE_0_2 = KEPT_OF_STATE + ("stamp", "reason", "inside", "min_separation",
                                           "distance_low")


def messages(path, topic):
    with rosbag.Bag(str(path)) as bag:
        return [message for _, message, _ in bag.read_messages(topics=[topic])]


class Migration(unittest.TestCase):

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def migrated(self, bag):
        path = self.folder / ("migrated_" + bag.name)
        self.assertEqual(fixbag2(MessageMigrator(RULES, False), str(bag), str(path)), [])
        return path

    def test_the_sums(self):
        found = {name: getattr(where, name)._md5sum for where in (msg, srv) for name in dir(where)
                 if name[0].isupper() and not name.endswith(("Request", "Response"))}
        self.assertEqual(found, MD5)

    def test_every_type_has_its_rule(self):
        for bag in BAG_0_1, BAG_0_2:
            migrator = MessageMigrator(RULES, False)
            self.assertEqual([rules for _, rules in checkbag(migrator, str(bag)) if rules], [])
            self.assertNotEqual(checkbag(MessageMigrator([], False), str(bag)), [])

    def test_the_package_names_its_rules(self):
        package = ElementTree.parse(str(ROOT / "package.xml"))
        self.assertEqual([str(ROOT / rules.get("migration_rule_file"))
                          for rules in package.iter("rosbag")], RULES)

    def check_kept(self, bag, kept):
        path = self.migrated(bag)
        for topic, names in kept.items():
            old, new = messages(bag, topic), messages(path, topic)
            self.assertEqual(len(old), len(new))
            self.assertTrue(old)
            for before, after in zip(old, new):
                for name in names:
                    self.assertEqual(str(getattr(before, name)), str(getattr(after, name)), name)
        return path

    def check_states(self, bag, path, kept):
        """Returns the migrated states."""
        found = []
        old, new = messages(bag, STATES), messages(path, STATES)
        self.assertEqual(len(old), len(new))
        for before, after in zip(old, new):
            self.assertEqual(len(before.states), len(after.states))
            for b, a in zip(before.states, after.states):
                for name in kept:
                    self.assertEqual(str(getattr(b, name)), str(getattr(a, name)), name)
                for point in a.point_a, a.point_b, a.normal:
                    self.assertEqual((point.x, point.y, point.z), (0, 0, 0))
                found.append((before, a))
        return found

    def test_what_version_0_1_recorded_is_still_there(self):
        path = self.check_kept(BAG_0_1, KEPT_SINCE_0_1)
        self.assertGreater(max(m.pair_count for m in messages(path, CONTACTS)), 200)

    def test_what_version_0_2_recorded_is_still_there(self):
        path = self.check_kept(BAG_0_2, KEPT_SINCE_0_2)
        states = {a.state for _, a in self.check_states(BAG_0_2, path, KEPT_OF_STATE_SINCE_0_2)}
        self.assertTrue(states >= {msg.ContactState.NONE, msg.ContactState.NEAR,
                                   msg.ContactState.CONTACT})
        contacts = messages(path, CONTACTS)
        self.assertTrue(any(g.separation > 0 for m in contacts for g in m.geometry))
        self.assertEqual([m.nearest for m in contacts], [[]] * len(contacts))

    def test_new_fields_say_what_version_0_1_meant(self):
        path = self.migrated(BAG_0_1)
        for contacts in messages(path, CONTACTS):
            self.assertEqual(contacts.triggered, [not t.is_zero() for t in contacts.body_stamps])
            self.assertEqual((contacts.timed_out, contacts.tolerance), (False, 0))
            self.assertEqual(contacts.nearest, [])
        for before, state in self.check_states(BAG_0_1, path, KEPT_OF_STATE):
            self.assertEqual(state.stamp, before.header.stamp)
            self.assertEqual(bool(state.reason), state.state == msg.ContactState.UNKNOWN)

    def test_geometry(self):
        migrator = MessageMigrator(RULES, False)
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
                           stdout=subprocess.DEVNULL)
            with open(out / "pairs.csv", newline="") as file:
                return [tuple(row.values())[1:] for row in csv.DictReader(file)]
        found = pairs(BAG_0_1, "old")
        self.assertEqual(found, pairs(self.migrated(BAG_0_1), "new"))
        recorded = {(f"{m.header.stamp.secs}.{m.header.stamp.nsecs:09}", m.bodies[p.body_a],
                     str(p.triangle_a), m.bodies[p.body_b], str(p.triangle_b))
                    for m in messages(BAG_0_1, CONTACTS) for p in m.pairs}
        self.assertEqual(set(found), recorded)
        self.assertGreater(len(recorded), 700)


if __name__ == "__main__":
    sys.exit(unittest.main())
