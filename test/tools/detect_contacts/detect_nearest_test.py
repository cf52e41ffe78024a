#!/usr/bin/env python3
"""detect_contacts --nearest: distances, nearest triangles, JSON and messages.

Distances are worked out by hand, or compared between backends.
"""
import json
import pathlib
import random
import unittest

from detect_case import ABOVE, Case, FLOOR, PIERCING, TOUCHING

# A triangle whose tip is 0.1 above the floor's plane, and a second one that is farther away.
TIP = "v 1 1 5\nv 1 2 5\nv 2 1 5\nv 1 1 0.1\nv 1 2 3\nv 2 1 3\nf 1 2 3\nf 4 5 6\n"


def soup(rng, triangles, shift):
    """Random small triangles on a fine grid, beside each other in x."""
    text = []
    for _ in range(triangles):
        centre = [rng.uniform(0, 1) + shift, rng.uniform(0, 1), rng.uniform(0, 1)]
        for _ in range(3):
            text.append("v %.6g %.6g %.6g\n" % tuple(c + rng.uniform(-.05, .05) for c in centre))
    for i in range(triangles):
        text.append("f %d %d %d\n" % (3 * i + 1, 3 * i + 2, 3 * i + 3))
    return "".join(text)


class DetectNearest(Case):

    def nearest(self, *arguments):
        return self.works("--nearest", "-", *arguments).stdout

    def hand_made(self):
        return [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING),
                self.mesh("above.obj", ABOVE), self.mesh("tip.obj", TIP)]

    def test_each_two_bodies_have_their_nearest_triangles(self):
        floor, pierce, above, tip = self.hand_made()
        for backend in "auto", "cpu", "brute_force":
            chosen = ["--backend", backend, "--margin"]
            # The float32 nearest to 0.1, with nine digits.
            self.assertEqual(self.nearest(*chosen, "1", floor, pierce, tip),
                             "0 0 1 1 0\n0 0 2 1 0.100000001\n1 1 2 1 0\n")
            self.assertEqual(self.nearest(*chosen, "2", floor, above), "0 0 1 0 2\n")
            self.assertEqual(self.nearest(*chosen, "1.99", floor, above), "")
            self.assertEqual(self.nearest(*chosen, "0", floor, pierce, above), "0 0 1 1 0\n")
            self.assertEqual(self.nearest(*chosen, "0", floor, self.mesh("t.obj", TOUCHING)),
                             "0 0 1 0 0\n")

    def test_fcl_gives_the_same_distance_within_its_error(self):
        floor, _, above, tip = self.hand_made()
        done = self.run_tool("--backend", "fcl", "--margin", "3", "--nearest", "-", floor, above,
                             tip)
        if done.returncode == 2:
            self.assertIn("no FCL", done.stderr)
            return
        rows = [line.split() for line in done.stdout.splitlines()]
        self.assertEqual([row[:4:2] for row in rows], [["0", "1"], ["0", "2"], ["1", "2"]])
        for row, wanted in zip(rows, (2, .1, 0)):
            self.assertAlmostEqual(float(row[4]), wanted, 6)
        self.assert_refused(["--backend", "fcl", "--margin", "1", "--nearest", "-", "--near-pairs",
                             floor, above], "--near-pairs", "fcl")

    def test_backends_agree_on_random_soups(self):
        for seed in range(4):
            rng = random.Random(seed)
            meshes = [self.mesh("%d.obj" % i, soup(rng, 60, 1.2 * i)) for i in range(3)]
            found = self.nearest("--backend", "cpu", "--margin", "5", *meshes)
            self.assertEqual(found.count("\n"), 3)
            self.assertEqual(found, self.nearest("--backend", "brute_force", "--margin", "5",
                                                 *meshes))

    def test_contacts_are_those_that_touch_unless_near_pairs_are_asked_for(self):
        floor, pierce, above, _ = self.hand_made()
        lines = self.path("nearest")
        arguments = ["--nearest", lines, "--margin", "2", floor, pierce, above]
        self.assertEqual(self.pairs(*arguments), "0 0 1 1\n")
        near = self.pairs("--near-pairs", *arguments)
        self.assertEqual(near, self.pairs(*arguments[2:]))
        self.assertEqual(near, "0 0 1 1\n0 0 2 0\n1 1 2 0\n")
        self.assertEqual(pathlib.Path(lines).read_text(), "0 0 1 1 0\n0 0 2 0 2\n1 1 2 0 1\n")

    def test_json(self):
        floor, pierce, above, _ = self.hand_made()
        report = self.json("--nearest", self.path("n"), "--margin", "2", floor, pierce, above)
        self.assertEqual([(n["bodies"], n["triangles"], n["distance"], n["exact"], n["normal"])
                          for n in report["nearest"]],
                         [([0, 1], [0, 1], 0, True, [0, 0, 0]),
                          ([0, 2], [0, 0], 2, True, [0, 0, 1]),
                          ([1, 2], [1, 0], 1, True, [0, 0, 1])])
        low, high = report["nearest"][2]["points"]
        self.assertEqual((low[2], high[2]), (1, 2))
        self.assertEqual(low[:2], high[:2])
        self.assertEqual((report["contacts"], report["complete"]), (1, True))
        self.assertEqual((report["options"]["nearest"], report["options"]["near_pairs"]),
                         (True, False))
        self.assertNotIn("nearest", self.json("--margin", "2", floor, above))

    def test_the_summary_names_the_bodies(self):
        floor, _, above, _ = self.hand_made()
        done = self.works("--nearest", self.path("n"), "--margin", "2", floor, above)
        self.assertRegex(done.stdout, r"\A0 contacts\npairs of bodies within the margin: 1\n"
                                      r"  \S+floor.obj with \S+above.obj: 2 apart, by triangles 0 "
                                      r"and 0\ncomplete: yes\n")
        self.assertEqual(done.stderr, "")

    def test_a_budget_that_ends_leaves_out_what_is_not_decided_and_says_so(self):
        floor, pierce, above, _ = self.hand_made()
        done = self.works("--nearest", "-", "--margin", "2", "--budget-ms", "1e-6", "--backend",
                          "cpu", floor, pierce, above)
        self.assertEqual(done.stdout, "")
        self.assertIn("detect_contacts: note: 3 pairs of bodies are not decided", done.stderr)
        done = self.works("--nearest", "-", "--margin", "2", "--budget-ms", "1e5", "--backend",
                          "cpu", floor, pierce, above)
        self.assertEqual(done.stdout, "0 0 1 1 0\n0 0 2 0 2\n1 1 2 0 1\n")
        self.assertEqual(done.stderr, "")

    def test_states_follow_from_the_distances(self):
        floor, pierce, above, _ = self.hand_made()
        for backend in "cpu", "brute_force":
            report = self.json("--nearest", self.path("n"), "--margin", "1.5", "--budget-ms", "1e5",
                               "--backend", backend, floor, pierce, above)
            self.assertEqual([state["state"] for state in report["body_states"]],
                             ["contact", "none", "near"], backend)

    def test_with_a_tolerance_bounds_are_marked(self):
        floor, pierce, above, _ = self.hand_made()
        done = self.works("--nearest", self.path("n"), "--json", "-", "--margin", "1.5",
                          "--tolerance-m", "0.25", "--backend", "cpu", floor, pierce, above)
        nearest = {tuple(n["bodies"]): n for n in json.loads(done.stdout)["nearest"]}
        self.assertEqual(set(nearest), {(0, 1), (1, 2)})
        self.assertTrue(0 <= nearest[0, 1]["distance"] <= .25)
        self.assertTrue(1 <= nearest[1, 2]["distance"] <= 1.25)
        bounds = [n for n in nearest.values() if not n["exact"]]
        self.assertEqual("upper bounds, too large by at most 0.25" in done.stderr, bool(bounds))

    def test_a_triangle_that_takes_no_part_is_counted(self):
        floor = self.mesh("floor.obj", FLOOR)
        above = self.mesh("bad.obj", ABOVE + "v 0 0 nan\nf 1 2 4\n")
        done = self.works("--nearest", "-", "--margin", "3", floor, above)
        self.assertEqual(done.stdout, "0 0 1 0 2\n")
        self.assertIn("not complete, 1 triangles have a NaN", done.stderr)

    def test_a_distance_of_a_body_with_rejected_triangles_is_an_upper_bound(self):
        floor, clean = self.mesh("floor.obj", FLOOR), self.mesh("above.obj", ABOVE)
        above = self.mesh("bad.obj", ABOVE + "v 0 0 nan\nf 1 2 4\n")
        for options in (), ("--tolerance-m", "0.25"):
            chosen = ["--backend", "cpu", "--nearest", self.path("n"), *options, "--margin"]
            done = self.works(*chosen, "3", floor, above)
            self.assertIn("bad.obj: at most 2", done.stdout)
            self.assertIn("note: 1 distances of --nearest are upper bounds, because of triangles "
                          "that took no part\n", done.stderr)
            self.assertNotIn("too large", done.stderr)
            self.assertEqual([n["exact"] for n in
                              self.json(*chosen, "3", floor, above)["nearest"]], [False])
            done = self.works(*chosen, "1", floor, above, clean)
            self.assertIn("note: 1 pairs of bodies are not decided", done.stderr)

    def test_refuses(self):
        floor, _, above, _ = self.hand_made()
        meshes = [floor, above]
        self.assert_refused(["--nearest", "-", *meshes], "--nearest", "--margin")
        self.assert_refused(["--near-pairs", "--margin", "1", *meshes], "--near-pairs",
                            "--nearest")
        self.assert_refused(["--nearest", "-", "--pairs", "-", "--margin", "1", *meshes],
                            "--nearest", "--pairs")
        self.assert_refused(["--nearest", floor, "--margin", "1", *meshes], "--nearest", floor)
        self.assert_refused(["--swept", "--nearest", "-", "--margin", "1", *meshes], "--swept")


if __name__ == "__main__":
    unittest.main()
