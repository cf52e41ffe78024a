#!/usr/bin/env python3
"""measure_trade --margins as its users see it: table, summary and messages. The tool is
$MEASURE_TRADE."""
import unittest

from trade_case import ABOVE, Case, FLOOR


class Margins(Case):
    """A cloth of four states: one above all, one on the post, two on the floor as well."""

    OPTIONS = ("--margins", "--margins-m", "0.05,0.5", "--cycles", "8", "--warm-up", "1")

    def rows(self, *arguments):
        self.works(*self.OPTIONS, *self.scene(), *arguments)
        return {(row["use"], row["margin_m"]): row for row in self.table("margins.csv")}

    def test_table(self):
        rows = self.rows()
        self.assertEqual(list(rows), [("touching", "0"), ("near_pairs", "0.05"),
                                      ("nearest", "0.05"), ("near_pairs", "0.5"),
                                      ("nearest", "0.5")])
        for row in rows.values():
            self.assertEqual((row["backend"], row["threads"], row["cycles"]), ("cpu", "1", "8"))
            self.assertTrue(0 < float(row["median_ms"]) <= float(row["p95_ms"])
                            <= float(row["p99_ms"]), row)
        touching = rows["touching", "0"]
        # Of floor and post, in four states: none; the post; both; both.
        self.assertEqual(float(touching["body_pairs"]), 5 / 4)
        for margin in "0.05", "0.5":
            near, nearest = rows["near_pairs", margin], rows["nearest", margin]
            self.assertEqual(nearest["body_pairs"], near["body_pairs"])
            self.assertEqual(nearest["triangle_pairs"], touching["triangle_pairs"])
            self.assertGreater(float(near["triangle_pairs"]), float(touching["triangle_pairs"]))
        self.assertGreater(float(rows["nearest", "0.5"]["body_pairs"]),
                           float(touching["body_pairs"]))
        self.assertEqual(self.summary()["broken_promises"], [])
        self.assertEqual(len(self.summary()["settings"]), 5)

    def test_lines_for_people(self):
        done = self.works(*self.OPTIONS, *self.scene())
        self.assertRegex(done.stdout, r"\AMeans of a cycle, on 1 thread:\n  cpu, touching +median")
        self.assertRegex(done.stdout, r"\n  cpu, nearest, margin 0.5 m +median +[\d.]+ ms, p99")
        self.assertEqual(done.stderr, "")

    def test_rejected_triangles_are_said(self):
        states = [self.mesh("%d.obj" % i, ABOVE + "v 0 0 nan\nf 1 2 4\n") for i in range(3)]
        done = self.works(*self.OPTIONS, *states, "--against", self.mesh("floor.obj", FLOOR))
        self.assertIn("note: 3 triangles, over all frames, have a NaN or infinite vertex and took "
                      "no part", done.stderr)
        self.assertEqual(self.summary()["rejected_triangles"], 3)

    def test_refuses(self):
        scene = self.scene()
        self.assert_refused(["--margins-m", "1", *scene], "--margins-m", "--margins")
        self.assert_refused(["--margins", "--margins-m", "-1", *scene], "--margins-m")
        for other in (["--swept"], ["--tolerance"], ["--overlaps", "0"], ["--budget-ms", "3"]):
            self.assert_refused(["--margins", *other, *scene], "--margins", other[0])


if __name__ == "__main__":
    unittest.main()
