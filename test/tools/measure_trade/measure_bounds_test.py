#!/usr/bin/env python3
"""measure_trade --tolerance as its users see it: table, plot, choice and messages. The tool is
$MEASURE_TRADE."""
import math
import os
import unittest

import yaml
from trade_case import ABOVE, Case, FLOOR, cloth


BOUNDED = [("0", "1000"), ("0.001", "0"), ("0.001", "1000"), ("0.2", "0"), ("0.2", "1000")]


class Bounds(Case):
    """A cloth of four states: one above all, one on the post, two on the floor as well."""

    OPTIONS = ("--tolerance", "--tolerances-m", "0,0.001,0.2", "--budgets-ms", "0,1000",
               "--overlaps", "0,1", "--cycles", "8", "--warm-up", "1")

    def rows(self, *arguments):
        self.works(*self.OPTIONS, *self.scene(), *arguments, plots=True)
        rows = self.table("bounds.csv")
        for name in ("backend", "threads"):
            self.assertEqual({row.pop(name) for row in rows},
                             {{"backend": "cpu", "threads": "1"}[name]})
        return {(row["overlap"], row["tolerance_m"], row["budget_ms"]):
                {name: float(value) for name, value in row.items()} for row in rows}

    def test_table(self):
        rows = self.rows()
        exact, lossy = ("1", "0", "0"), ("0", "0", "0")
        self.assertEqual(list(rows), [exact, lossy, *[("1", *setting) for setting in BOUNDED]])
        for (overlap, tolerance, budget), row in rows.items():
            self.assertEqual((row["cycles"], row["pairs"]), (8, 24), row)
            self.assertEqual((row["contacts"], row["decided_share"]), (10, 1), row)
            self.assertTrue(0 < row["median_ms"] <= row["p95_ms"] <= row["p99_ms"], row)
            self.assertAlmostEqual(row["time_of_exact"],
                                   row["median_ms"] / rows[exact]["median_ms"], places=5)
            self.assertAlmostEqual(row["p99_over_budget"],
                                   row["p99_ms"] / float(budget) if budget != "0" else 0, places=5)
            self.assertLessEqual(row["largest_claim_m"], float(tolerance) + 1e-9)
            if overlap == "1":
                self.assertEqual((row["recall"], row["missed"]), (1, 0), row)
        self.assertEqual(rows["1", "0", "1000"]["precision"], 1)
        self.assertTrue(os.path.getsize(self.path("trade", "bounds.png")) > 1000)

    def test_a_claim_within_the_tolerance_is_no_contact(self):
        """Waves 1 cm below waves: their boxes overlap."""
        self.works("--tolerance", "--tolerances-m", "0.001,0.1", "--budgets-ms", "0", "--overlaps",
                   "1", "--cycles", "4", self.mesh("cloth.obj", cloth(0.4)), "--against",
                   self.mesh("below.obj", cloth(0.39)), self.mesh("far.obj", ABOVE))
        _, less, more = self.table("bounds.csv")
        self.assertEqual((less["contacts"], less["recall"], less["precision"]), ("0", "1", "1"))
        self.assertEqual((more["contacts"], more["recall"], more["precision"]), ("0", "1", "0"))
        self.assertEqual(less["largest_claim_m"], "0")
        self.assertTrue(0.005 < float(more["largest_claim_m"]) <= 0.01, more)
        self.assertEqual(more["decided_share"], "1")

    def test_overlap_loses_touches_of_single_pairs(self):
        """Pins through waves, each to the side into another cluster. They are wide enough for waves of
        several clusters to be near them."""
        pins = []
        for i in range(25):
            x, y, far = 0.2 + 0.15 * (i % 5), 0.2 + 0.15 * (i // 5), 0.5 * (-1) ** i
            z = 0.1 * math.sin(9 * x + 4 * y)
            pins.append(self.mesh(f"pin_{i}.obj", f"v {x} {y} {z + 0.01}\nv {x + far} {y} "
                                  f"{z - 0.3}\nv {x + far} {y + 0.06} {z - 0.3}\nf 1 2 3\n"))
        scene = [self.mesh("waves.obj", cloth(0, 60)), "--against", *pins]
        self.works("--tolerance", "--tolerances-m", "0.001", "--budgets-ms", "0", "--cycles", "1",
                   "--overlaps", "0", *scene)
        exact, lossy, bounded = ({name: float(value) for name, value in row.items()
                                  if name != "backend"} for row in self.table("bounds.csv"))
        self.assertGreater(lossy["missed"], 0, "and that is no broken promise")
        self.assertAlmostEqual(lossy["recall"], 1 - lossy["missed"] / lossy["contacts"])
        for row in (exact, bounded):
            self.assertEqual((row["contacts"], row["recall"]), (lossy["contacts"], 1))
        many = ",".join(str(i / 20) for i in range(20))  # one of them is the fastest
        done = self.works("--tolerance", "--tolerances-m", "0", "--budgets-ms", "0", "--overlaps",
                          many, *scene)
        self.assertIn("\nChosen: exact\n", done.stdout)

    def test_what_is_not_decided_in_time(self):
        done = self.works("--tolerance", "--tolerances-m", "0.001", "--budgets-ms", "0.000001",
                          "--overlaps", "1", "--cycles", "4", *self.scene())
        row = {name: float(value) for name, value in self.table("bounds.csv")[1].items()
               if name != "backend"}
        self.assertEqual((row["decided_share"], row["recall"], row["missed"]), (0, 0, 0), row)
        self.assertGreater(row["p99_over_budget"], 1)
        self.assertIn("\nChosen: exact\n", done.stdout)

    def test_choice(self):
        done = self.works(*self.OPTIONS, *self.scene(), "--budget-ms", "100000",
                          "--write-config", "chosen.yaml")
        self.assertRegex(done.stdout, r"\nChosen within 100000 ms: [^\n]+\n\Z")
        for tolerance, budget in BOUNDED:
            end = f", budget {budget} ms" if budget != "0" else ""
            self.assertRegex(done.stdout, f"\n  tolerance {tolerance} m{end} +median")
        with open(self.path("chosen.yaml")) as file:
            chosen = yaml.safe_load(file)
        self.assertEqual(chosen["tolerance_m"], 0, "the least that keeps it")
        self.assertEqual((chosen["backend"], chosen["threads"]), ("cpu", 1))
        self.assertNotIn("budget_ms", chosen, "it is not asked for")
        self.assertEqual(chosen["pair_classes"], ["robot_deformable"])
        summary = self.summary()
        self.assertEqual(summary["broken_promises"], [])
        self.assertEqual(summary["chosen"], done.stdout.splitlines()[-1].partition(": ")[2])
        self.assertEqual([body["name"] for body in summary["bodies"]],
                         ["cloth_0", "floor", "post", "far"])
        self.assertEqual(len(summary["settings"]), 7)
        self.works("--tolerance", "--tolerances-m", "0.001,0.2", *self.scene(), "--budget-ms",
                   "0.000001", "--cycles", "4", "--write-config", "other.yaml")
        with open(self.path("other.yaml")) as file:
            other = yaml.safe_load(file)
        self.assertEqual(other["tolerance_m"], 0.2, "none keeps it")
        self.assertNotIn("budget_ms", other)

    def test_a_budget_is_written_where_it_is_asked_for(self):
        self.works("--tolerance", "--tolerances-m", "0.2", "--budgets-ms", "0", *self.scene(),
                   "--cycles", "4", "--budget-ms", "12.5", "--write-config", "chosen.yaml",
                   "--write-budget")
        with open(self.path("chosen.yaml")) as file:
            self.assertEqual(yaml.safe_load(file)["budget_ms"], 12.5)
        for missing in (["--budget-ms", "5"], ["--write-config", "other.yaml"]):
            self.assert_refused(["--tolerance", "--write-budget", *missing, *self.scene()],
                                "--write-budget")

    def test_exact_detection_is_the_default(self):
        done = self.works("--tolerance", "--tolerances-m", "0", "--budgets-ms", "0", "--overlaps",
                          "1", "--cycles", "4", *self.scene(), "--write-config", "chosen.yaml")
        self.assertIn("\nKeep the defaults: exact", done.stdout)
        with open(self.path("chosen.yaml")) as file:
            text = file.read()
        self.assertIn("\n# Keep the defaults: exact", text)
        self.assertEqual(yaml.safe_load(text)["tolerance_m"], 0)

    def test_cuda_is_refused_or_beside(self):
        done = self.run_tool(*self.OPTIONS, *self.scene(), "--backends", "cpu,cuda")
        if done.returncode == 0:
            self.assertEqual([row["backend"] for row in self.table("bounds.csv")],
                             ["cpu", "cuda"] + ["cpu"] * 6)
        else:
            self.assertRegex(done.stderr, r"\Ameasure_trade: [^\n]*CUDA[^\n]*\n\Z")

    def test_rejected_triangles_leave_their_bodies_unknown(self):
        """Of the cloth, one triangle has a NaN vertex; the floor and the post are whole."""
        scene = self.scene()
        for state in scene[:4]:
            with open(state, "a") as file:
                file.write("v 0 0 nan\nf 1 2 170\n")
        done = self.works("--tolerance", "--tolerances-m", "0,0.001", "--budgets-ms", "0,1000",
                          "--overlaps", "0,1", "--cycles", "8", *scene)
        for row in self.table("bounds.csv"):
            self.assertEqual((row["pairs"], row["contacts"]), ("24", "10"), row)
            # Only contacts are certain.
            found = round(float(row["recall"]) * 10 / float(row["precision"]))
            self.assertAlmostEqual(float(row["decided_share"]), found / 24, places=5)
            self.assertEqual(row["missed"], "0")
        self.assertIn("\nNo setting decides all pairs\n", done.stdout)
        self.assertIn("note: 4 triangles, over all frames, have a NaN or infinite vertex and took "
                      "no part", done.stderr)
        self.assertEqual(self.summary()["rejected_triangles"], 4)

    def test_no_contact_at_all_is_said_and_no_false_claim_is_chosen(self):
        done = self.works("--tolerance", "--tolerances-m", "0.1", "--budgets-ms", "0", "--overlaps",
                          "1", "--cycles", "4", self.mesh("cloth.obj", cloth(0.4, 40)), "--against",
                          self.mesh("below.obj", cloth(0.39, 40)), "--write-config", "chosen.yaml")
        exact, bounded = self.table("bounds.csv")
        self.assertEqual(bounded["precision"], "0")
        self.assertLess(float(bounded["median_ms"]), float(exact["median_ms"]), "it is tempting")
        self.assertIn("note: no frame has a contact, so recall says nothing\n", done.stderr)
        self.assertIn("\nChosen: exact\n", done.stdout)
        self.works("--tolerance", "--tolerances-m", "0.1", "--budgets-ms", "0", "--cycles", "4",
                   self.path("cloth.obj"), "--against", self.path("below.obj"), "--budget-ms",
                   "0.000001", "--write-config", "other.yaml")
        with open(self.path("other.yaml")) as file:
            self.assertEqual(yaml.safe_load(file)["tolerance_m"], 0, "only false claims have more")

    def test_exact_detection_is_preferred_to_tolerance_zero_with_a_budget(self):
        for _ in range(3):
            budgets = ",".join(str(60000 - i) for i in range(30))  # one of them is the fastest
            done = self.works("--tolerance", "--tolerances-m", "0", "--budgets-ms", budgets,
                              "--overlaps", "1", "--cycles", "4", *self.scene())
            self.assertIn("\nChosen: exact\n", done.stdout)

    def test_one_body_alone_is_refused(self):
        self.assert_refused(["--tolerance", "--self", self.mesh("cloth.obj", cloth(0))],
                            "--tolerance", "--against")

    def test_refusals(self):
        scene = self.scene()
        for option, value in (("--tolerances-m", "-1"), ("--tolerances-m", "2"),
                              ("--budgets-ms", "-1")):
            self.assert_refused(["--tolerance", option, value, *scene], option)
        self.assert_refused(["--tolerances-m", "0.1", *scene], "--tolerances-m", "--tolerance")
        for option in (["--swept"], ["--repeats", "1"], ["--predicates", "exact"]):
            self.assert_refused(["--tolerance", *option, *scene], "--tolerance", option[0])


if __name__ == "__main__":
    unittest.main()
