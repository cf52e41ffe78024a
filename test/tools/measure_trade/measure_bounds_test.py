#!/usr/bin/env python3
"""measure_trade --tolerance as its users see it: table, plot, choice and messages. The tool is
$MEASURE_TRADE."""
import os
import unittest

import yaml
from trade_case import ABOVE, Case, FLOOR, POST


class Bounds(Case):
    """A cloth of four states: one above all, one on the post, two on the floor as well."""

    OPTIONS = ("--tolerance", "--tolerances-m", "0,0.001,0.2", "--budgets-ms", "0,1000", "--cycles",
               "8", "--warm-up", "1")

    def rows(self, *arguments):
        self.works(*self.OPTIONS, *self.scene(), *arguments)
        return {(row["tolerance_m"], row["budget_ms"]): {name: float(value)
                                                         for name, value in row.items()}
                for row in self.table("bounds.csv")}

    def test_table(self):
        rows = self.rows()
        self.assertEqual(list(rows), [("0", "0"), ("0", "1000"), ("0.001", "0"), ("0.001", "1000"),
                                      ("0.2", "0"), ("0.2", "1000")])
        for (tolerance, budget), row in rows.items():
            self.assertEqual((row["cycles"], row["pairs"], row["contacts"]), (8, 24, 10), row)
            self.assertEqual((row["decided_share"], row["recall"], row["missed"]), (1, 1, 0), row)
            self.assertLessEqual(row["largest_claim_m"], float(tolerance) + 1e-9)
            self.assertGreater(row["median_ms"], 0)
            self.assertEqual(row["p99_over_budget"] > 0, budget != "0")
            self.assertEqual(row["threads"], 1)
        self.assertEqual(rows["0", "0"]["time_of_exact"], 1)
        self.assertEqual(rows["0", "1000"]["precision"], 1)
        self.assertTrue(os.path.getsize(self.path("trade", "bounds.png")) > 1000)

    def test_what_is_not_decided_in_time(self):
        self.works("--tolerance", "--tolerances-m", "0.001", "--budgets-ms", "0.000001",
                   "--cycles", "4", *self.scene())
        row = self.table("bounds.csv")[1]
        self.assertLess(float(row["decided_share"]), 1)
        self.assertEqual(float(row["missed"]), 0)

    def test_choice(self):
        done = self.works(*self.OPTIONS, *self.scene(), "--budget-ms", "100000",
                          "--write-config", "chosen.yaml")
        self.assertRegex(done.stdout, r"\nChosen within 100000 ms: [^\n]+\n\Z")
        with open(self.path("chosen.yaml")) as file:
            chosen = yaml.safe_load(file)
        self.assertEqual(chosen["tolerance_m"], 0, "the least that keeps it")
        self.assertEqual((chosen["budget_ms"], chosen["backend"]), (100000, "cpu"))
        self.assertEqual(self.summary()["broken_promises"], [])
        self.works("--tolerance", "--tolerances-m", "0.001,0.2", *self.scene(), "--budget-ms",
                   "0.000001", "--cycles", "4", "--write-config", "other.yaml")
        with open(self.path("other.yaml")) as file:
            self.assertEqual(yaml.safe_load(file)["tolerance_m"], 0.2, "none keeps it")

    def test_refusals(self):
        scene = self.scene()
        for option, value in (("--tolerances-m", "-1"), ("--tolerances-m", "2"),
                              ("--budgets-ms", "-1")):
            self.assert_refused(["--tolerance", option, value, *scene], option)
        self.assert_refused(["--tolerances-m", "0.1", *scene], "--tolerances-m", "--tolerance")
        for option in (["--swept"], ["--overlaps", "1"], ["--predicates", "exact"]):
            self.assert_refused(["--tolerance", *option, *scene], "--tolerance", option[0])


if __name__ == "__main__":
    unittest.main()
