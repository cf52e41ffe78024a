#!/usr/bin/env python3
"""What changed between two evaluations, by tables written here; rules of what may; progress."""
import csv
import io
import json
import os
import pathlib
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src/tools/evaluate_bags"))
from fleet.baseline import BaselineError, compare, is_allowed, read_allowed
from fleet.changes import Change, changes_of
from fleet.pair_hashes import read_pair_hashes, write_pair_hashes
from fleet.progress import Progress


def episodes(*of, state="CONTACT"):
    """Returns links of episodes, each from 0 to 20 s: its times in the state, and NONE between."""
    links = []
    for times in of:
        begin = 0.0
        for first, last in times:
            links += [("NONE", f"{begin}", f"{float(first) - .1:.3f}"), (state, first, last)]
            begin = round(float(last) + .1, 3)
        links.append(("NONE", f"{begin}", "20.0"))
    return {"links": links}


class Rules(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name

    def evaluation(self, name, links, pairs=(), ms=1.0, expectations=()):
        """`links`: (state, from, to), with a cycle each 0.1 s. `pairs`: (stamp, triangle,
        triangle), and the cycle, if it is not 1."""
        folder = os.path.join(self.folder, name)
        os.makedirs(folder)
        with open(folder + "/links.csv", "w") as file:
            file.write("run,body_a,body_b,state,from,to,cycles,least_pairs,most_pairs\n")
            for state, begin, end in links:
                cycles = round((float(end) - float(begin)) / .1) + 1
                # Rows are in the order of their ends, so those of another run may be the first.
                file.write(f"other,hand,cloth,CONTACT,0.{len(name)},9.0,1,1,1\n")
                file.write(f"cpu,hand,cloth,{state},{begin},{end},{cycles},1,1\n")
        with open(folder + "/pairs.csv", "w") as file:
            table = csv.writer(file)
            table.writerow("cycle,stamp,body_a,triangle_a,body_b,triangle_b".split(","))
            table.writerows((*(cycle or [1]), stamp, "hand", a, "cloth", b)
                            for stamp, a, b, *cycle in pairs)
        write_pair_hashes(folder)
        with open(folder + "/summary.json", "w") as file:
            json.dump({"runs": [{"name": "cpu"}, {"name": "other"}],
                       "times": {"runs": [{"detect_ms": {"median": ms}}]}, "expectations": [
                           {"text": text, "holds": holds} for text, holds in expectations]}, file)
        return folder

    def kinds(self, old, new):
        count = len(os.listdir(self.folder))
        return [(c.kind, round(c.amount, 6)) for c in changes_of(
            "a.bag", self.evaluation(f"old{count}", **old), self.evaluation(f"new{count}", **new))
            if c.kind != "latency"]

    def test_contacts(self):
        def links(*contacts, state="CONTACT"):
            return episodes(contacts, state=state)
        one = links(("1.0", "2.0"))
        self.assertEqual(self.kinds(one, one), [])
        self.assertEqual(self.kinds(one, links(("1.1", "2.0"))), [("began", .1)])
        self.assertEqual(self.kinds(one, links(("1.0", "1.5"))), [("ended", .5)])
        self.assertEqual(self.kinds(one, links(("3.0", "4.0"))), [("vanished", 0), ("appeared", 0)])
        self.assertEqual(self.kinds(links(), one), [("appeared", 0)])
        self.assertEqual(self.kinds(one, links()), [("vanished", 0)])
        self.assertEqual(self.kinds(one, links(("1.0", "1.2"), ("1.6", "2.0"))),
                         [("ended", float("inf"))])
        self.assertEqual(self.kinds(links(("1.0", "1.2"), ("1.6", "2.0")), one),
                         [("ended", float("inf"))])
        self.assertEqual(self.kinds(links(("1.0", "1.2"), ("1.6", "2.0")),
                                    links(("1.0", "1.6"), ("1.8", "2.0"))),
                         [("ended", .4), ("began", .2)])
        self.assertEqual(self.kinds(one, links(("1.0", "2.0"), state="UNKNOWN")),
                         [("vanished", 0), ("unknown", 0)])
        self.assertEqual(self.kinds(links(("10.0", "11.0")), links(("9.0", "11.0"))),
                         [("began", 1)])

    def test_a_contact_of_one_episode(self):
        """It is no counterpart of another episode's, although their stamps are the same."""
        for shift in (0, .003):
            contact = (f"{1 + shift}", f"{2 + shift}")
            both = episodes([contact], [("1.0", "2.0")])
            self.assertEqual(self.kinds(both, both), [])
            for less in (episodes([], [("1.0", "2.0")]), episodes([contact], [])):
                self.assertEqual(self.kinds(both, less), [("vanished", 0)])
                self.assertEqual(self.kinds(less, both), [("appeared", 0)])
        both = dict(episodes([("1.0", "2.0")], [("1.0", "2.0")]),
                    pairs=[("1.0", 1, 2), ("1.0", 1, 2, 2)])
        less = dict(episodes([], [("1.0", "2.0")]), pairs=[("1.0", 1, 2)])
        moved = dict(both, pairs=[("1.0", 1, 2), ("1.0", 1, 3, 2)])
        self.assertEqual(self.kinds(both, less), [("vanished", 0)])
        self.assertEqual(self.kinds(both, moved), [("moved", 1)])

    def test_unknown_in_one_episode(self):
        times = [("1.0", "2.0")]
        both, less = (episodes(first, times, state="UNKNOWN") for first in (times, []))
        self.assertEqual(self.kinds(both, both), [])
        self.assertEqual(self.kinds(both, less), [("unknown", 0)])
        self.assertEqual(self.kinds(less, both), [("unknown", 0)])

    def test_less_was_looked_at(self):
        for state in ("NONE", "CONTACT", "UNKNOWN"):
            def links(*spans, of=state):
                return {"links": [(of, begin, end) for begin, end in spans]}
            whole = links(("1.0", "1.9"), ("2.0", "9.0"))
            for less in (links(("1.0", "1.9"), ("2.0", "8.0")),
                         links(("2.0", "9.0"), ("9.1", "10.0")),
                         links(("0.0", "0.9"), ("1.0", "8.0"))):
                self.assertIn("unknown", [kind for kind, _ in self.kinds(whole, less)], state)
        twice = links(("1.0", "3.0"), ("1.0", "3.0"), of="NONE")
        self.assertEqual(self.kinds(twice, links(("1.0", "3.0"), of="NONE")), [("unknown", 0)])
        self.assertEqual(self.kinds(links(("1.0", "3.0"), of="NONE"), twice), [])
        texts = [change.text for change in changes_of(
            "a.bag", self.evaluation("long", **links(("1.0", "9.0"), of="NONE")),
            self.evaluation("short", **links(("1.0", "3.0"), of="NONE")))]
        self.assertIn("looked at in 21 cycles from 1.0 to 3.0, before 81 from 1.0 to 9.0", texts)

    def test_a_bag_that_fails_costs_itself_alone(self):
        def write(out):
            for name in ("a.bag", "b.bag"):
                self.evaluation(f"{out}/bags/{name}", **episodes([("1.0", "2.0")]))
        write("old")
        write("new")
        with open(os.path.join(self.folder, "old/bags/a.bag/links.csv"), "a") as file:
            file.write("cpu,hand,cloth,NONE,,,,,\n")
        found = compare(*(os.path.join(self.folder, of) for of in ("old", "new")),
                        ["a.bag", "b.bag"])
        self.assertEqual([(c.bag, c.kind) for c in found],
                         [("a.bag", "bag"), ("b.bag", "latency")])
        self.assertRegex(found[0].text, "cannot be compared: ValueError: ")

    def test_what_is_no_longer_judged(self):
        def links(state):
            return {"links": [(state, "1.0", "2.0")] if state else []}
        for old, new in (("NONE", None), ("NONE", "ALLOWED"), ("ALLOWED", "NONE"),
                         ("NONE", "UNKNOWN")):
            with self.subTest(old=old, new=new):
                self.assertEqual(self.kinds(links(old), links(new)), [("unknown", 0)])
        self.assertEqual(self.kinds(links(None), links("NONE")), [])

    def test_sets_of_pairs(self):
        links = [("CONTACT", "1.0", "2.0")]
        old = {"links": links, "pairs": [("1.0", 1, 2), ("1.0", 3, 4), ("2.0", 5, 6)]}
        turned = {"links": links, "pairs": [("1.0", 3, 4), ("1.0", 1, 2), ("2.0", 5, 6)]}
        moved = {"links": links, "pairs": [("1.0", 1, 4), ("1.0", 3, 2), ("2.0", 5, 6)]}
        self.assertEqual(self.kinds(old, turned), [])
        self.assertEqual(self.kinds(old, moved), [("moved", 1)])
        self.assertEqual(len(read_pair_hashes(os.path.join(self.folder, "old0"))), 1)

    def test_expectations(self):
        old = {"links": [], "expectations": [("a", True), ("b", True), ("c", False)]}
        new = {"links": [], "expectations": [("a", True), ("b", False), ("c", True)]}
        self.assertEqual(self.kinds(old, new), [("expectation", 0)] * 2)

    def allowed(self, text):
        path = os.path.join(self.folder, "allow.yaml")
        with open(path, "w") as file:
            file.write(text)
        return read_allowed(path)

    def test_rules(self):
        began = Change("lab/a.bag", "began", ("hand", "cloth"), "", .1)
        slower = Change("lab/a.bag", "latency", (), "", 1.6)
        for text, may in (("[]", False), ("- {change: began}", True), ("- {change: ended}", False),
                          ("- {change: began, link: hand, bag: lab/*}", True),
                          ("- {change: began, link: foot}", False),
                          ("- {change: began, bag: other/*}", False),
                          ("- {change: began, within_s: 0.05}", False),
                          ("- {change: began, within_s: 5e-2}", False),
                          ("- {change: began, within_s: 2e-1}", True),
                          ("- {change: began, within_s: 0.2}", True)):
            self.assertEqual(is_allowed(began, self.allowed(text)), may, text)
        self.assertTrue(is_allowed(slower, []))
        self.assertTrue(is_allowed(slower, self.allowed("- {change: latency, ratio: 2}")))
        self.assertFalse(is_allowed(slower, self.allowed("- {change: latency, ratio: 1.5}")))

    def test_bad_rules_are_refused_by_name(self):
        for text, word in (("a: 1", "list"), ("- 3", "maps"), ("- {change: x}", "'x'"),
                           ("- {change: began, ratio: 2}", "ratio"),
                           ("- {change: latency, ratio: -1}", "ratio"),
                           ("- {change: latency, ratio: .nan}", "ratio"),
                           ("- {change: began, lnik: a}", "lnik"),
                           ("- {change: moved, bag: 3}", "bag"),
                           ("- {change: [", "allow.yaml")):
            with self.assertRaises(BaselineError) as caught:
                self.allowed(text)
            self.assertIn(word, str(caught.exception))
            self.assertNotIn("\n", str(caught.exception))

    def test_progress(self):
        clock = iter([0, 10, 10, 10]).__next__
        progress = Progress(4, 400, clock, io.StringIO())
        progress.add(100, 50, False)
        progress.add(100, 99, True)
        self.assertEqual(progress.text(2), "2 of 4 bags (1 were there), 50 cycles, 5 a second, "
                                           "0:00:20 left")


if __name__ == "__main__":
    unittest.main()
