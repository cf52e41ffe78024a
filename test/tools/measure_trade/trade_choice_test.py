#!/usr/bin/env python3
"""Which setting measure_trade chooses, what it says about noise, and what it writes for the node."""
import os
import pathlib
import re
import sys
import unittest

from trade_case import FLOOR, PARAMETERS, SETTING, Case, cloth, quick

MILLISECONDS = r"[0-9.]+ ms"


class TradeChoice(Case):

    def test_choice(self):
        scene = self.scene()
        exact = quick(predicates="exact")  # the others are guaranteed as well, and as fast
        done = self.works(*scene, *exact)
        self.assertRegex(done.stdout, r"\AChosen without a budget: cpu, exact, overlap 1, .*\n"
                                      r"  median .* ms, p95 .* ms; .* 100 % .* 100 % "
                                      r".*miss none\n")
        done = self.works(*scene, *exact, "--budget-ms", "10000")
        self.assertRegex(done.stdout, r"\AChosen for a budget of 10000 ms: cpu, exact, overlap 1,")
        done = self.works(*scene, *quick(), "--budget-ms", "0.000001")
        fastest = min(self.table("settings.csv"), key=lambda row: float(row["median_ms"]))
        self.assertIn("No setting keeps a budget of 1e-06 ms. The fastest: cpu, "
                      f"{fastest['predicates']}, overlap {fastest['overlap']}, ", done.stdout)
        self.assertIsNone(self.summary()["chosen"])
        done = self.works(*scene, *quick(overlaps="0", predicates="conservative"))
        self.assertIn("No setting of these is guaranteed. The fastest: cpu, conservative, "
                      "overlap 0, ", done.stdout)


    def test_a_guarantee_leaves_out_triangles_that_took_no_part(self):
        states = [self.mesh(f"{i}.obj", cloth(0.05) + "v 0 0 nan\nf 1 2 170\n") for i in range(2)]
        done = self.works(*states, "--against", self.mesh("floor.obj", FLOOR), *quick())
        self.assertIn("note: 2 triangles, over all frames, have a NaN or infinite vertex and took "
                      "no part", done.stderr)
        self.assertIn("guaranteed to miss none of the triangles that took part\n", done.stdout)
        self.assertEqual(self.summary()["rejected_triangles"], 2)

    def test_config(self):
        """Names and values that the node knows; its own parser reads it in trade_config_test."""
        known = re.findall(r"^([a-z_]+):", PARAMETERS.read_text(), re.MULTILINE)
        self.works(*self.scene(), *quick(), "--write-config", self.path("chosen.yaml"))
        text = pathlib.Path(self.path("chosen.yaml")).read_text()
        values = dict(line.split(": ") for line in text.splitlines() if not line.startswith("#"))
        self.assertEqual(tuple(values), (*SETTING, "pair_classes"))
        self.assertEqual(values["pair_classes"], "[robot_deformable]")
        self.assertLessEqual(set(values), set(known))
        chosen = self.summary()["chosen"]
        for name in SETTING:
            self.assertEqual(values[name], f"{chosen[name]:g}" if isinstance(
                chosen[name], float) else str(chosen[name]))
        self.assertRegex(text, r"(?m)^# Written by measure_trade .*chosen.yaml$")
        self.assertIn("# Chosen without a budget: cpu, ", text)

        done = self.works(*self.scene(), *quick(), "--write-config", "-")
        self.assertTrue(done.stdout.startswith("# Written by "), done.stdout)
        self.assertTrue(done.stdout.endswith("pair_classes: [robot_deformable]\n"), done.stdout)


    def test_config_that_there_is_none_for(self):
        done = self.run_tool(*self.scene(), *quick(), "--budget-ms", "1e-6",
                             "--write-config", "none")
        self.assertEqual(done.returncode, 2)
        self.assertIn("none: there is no setting to write", done.stderr)
        self.assertFalse(os.path.exists(self.path("none")))
        own = self.mesh("own.yaml", "reference_frame: my_base\n")
        done = self.run_tool(*self.scene(), *quick(), "--budget-ms", "1e-6",
                             "--write-config", own, "--force")
        self.assertEqual(done.returncode, 2)
        self.assertEqual(pathlib.Path(own).read_text(), "reference_frame: my_base\n")


    def test_config_has_the_pair_classes_that_were_measured(self):
        state, floor = self.mesh("cloth.obj", cloth(0)), self.mesh("floor.obj", FLOOR)
        for name, scene, classes in (("one", ["--self"], "deformable_self"),
                                     ("two", ["--self", "--against", floor],
                                      "robot_deformable, deformable_self")):
            self.works(state, *scene, *quick(), "--write-config", self.path(name))
            self.assertIn(f"\npair_classes: [{classes}]\n",
                          pathlib.Path(self.path(name)).read_text())

    def test_config_replaces_no_file_unasked(self):
        own = self.mesh("own.yaml", "reference_frame: my_base\n")
        self.assert_refused([*self.scene(), *quick(), "--write-config", own], "own.yaml is there",
                            "--force")
        self.assertEqual(pathlib.Path(own).read_text(), "reference_frame: my_base\n")
        self.works(*self.scene(), *quick(), "--write-config", own, "--force")
        self.assertIn("pair_classes", pathlib.Path(own).read_text())
        self.assert_refused([*self.scene(), "--force"], "--force", "--write-config")

    def test_noise_is_measured_and_said(self):
        done = self.works(*self.scene(), *quick(repeats="3", cycles="12"))
        self.assertRegex(done.stdout, rf"\n  p10 {MILLISECONDS}, p90 {MILLISECONDS}; in 3 repeats "
                                      rf"the median was {MILLISECONDS} to {MILLISECONDS}, the p95 "
                                      rf"{MILLISECONDS} to {MILLISECONDS}\n")
        summary = self.summary()
        self.assertEqual((summary["repeats"], summary["cycles"]), (3, 12))
        self.assertFalse(summary["budget_within_noise"])
        others = summary["within_noise_of_chosen"]
        self.assertEqual(f"{len(others)} of the 8 other settings cannot be told from it in time"
                         in done.stdout, bool(others))
        for row in self.table("settings.csv"):
            low, median, high = (float(row[name]) for name in ("median_low_ms", "median_ms",
                                                               "median_high_ms"))
            self.assertTrue(0 < low <= median <= high, row)
            self.assertLessEqual(float(row["p95_low_ms"]), float(row["p95_high_ms"]))
            self.assertTrue(float(row["least_ms"]) <= float(row["p10_ms"]) <= median
                            <= float(row["p90_ms"]) <= float(row["p95_ms"]), row)

    def test_one_repeat_says_nothing_about_noise(self):
        done = self.works(*self.scene(), *quick())
        self.assertIn("a single repeat says nothing about noise", done.stdout)


if __name__ == "__main__":
    sys.exit(unittest.main())
