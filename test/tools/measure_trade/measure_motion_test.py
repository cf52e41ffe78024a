#!/usr/bin/env python3
"""measure_trade --swept as its users see it: tables, plots and messages. The tool is
$MEASURE_TRADE."""
import os
import pathlib
import subprocess
import unittest

from measure_trade_test import Case, DATA, FLOOR, TOOL

NEEDLE = "v 0 0 %g\nv 0.1 0 %g\nv 0 0.1 %g\nf 1 2 3\n"
# Where a needle of a quarter's height has its tip above the floor: through it between the second
# state and the third, in it again in the sixth and seventh. Every fourth and the last: 0, 4, 8.
TIPS = (1, 0.5, -0.5, -1, -1, -0.125, -0.125, 0.5, 1)


class Swept(Case):
    """What each way to look loses; more cases in motion_statistics_test."""

    WAYS = (("instant", "1"), ("instant", "4"), ("swept", "4"))

    def states(self, tips=TIPS):
        return [self.mesh(f"needle_{i}.obj", NEEDLE % (z, z + 0.25, z + 0.25))
                for i, z in enumerate(tips)]

    def scene(self):
        return [*self.states(), "--against", self.mesh("floor.obj", FLOOR), "--swept", "--every",
                "4"]

    def motions(self):
        return {(row["level"], row["motion"], row["every"]): row
                for row in self.table("motions.csv")}

    def test_tables(self):
        done = self.works(*self.scene())
        rows = self.motions()
        self.assertEqual(set(rows), {(level, *way) for level in ("bodies", "triangles")
                                     for way in self.WAYS})
        for (_, motion, every), row in rows.items():
            lost = {("instant", "1"): "1", ("instant", "4"): "2", ("swept", "4"): "0"}
            self.assertEqual((row["contacts"], row["onsets"]), ("2", "2"))
            self.assertEqual((row["contacts_lost"], row["onsets_lost"]), (lost[motion, every],) * 2)
            self.assertEqual((row["contacts_added"], row["onsets_added"]), ("0", "0"))
            self.assertGreater(float(row["median_ms"]), 0)
        self.assertEqual([row["cycles"] for row in self.table("motions.csv")], ["9", "3", "2"] * 2)
        self.assertIn("instant at every 4th frame loses 2 of 2 contacts of bodies, 2 of 2 onsets; "
                      "2 of 2 contacts of triangles, 2 of 2 onsets\n", done.stdout)
        self.assertIn("swept at every 4th frame loses 0 of 2", done.stdout)

    def test_onsets(self):
        self.works(*self.scene())
        rows = self.table("onsets.csv")
        self.assertEqual([row["level"] for row in rows], ["bodies"] * 2 + ["triangles"] * 2)
        again = 4 + 0.75 / 0.875
        for row, first, instant, swept in zip(rows, (1.5, again) * 2, ("", "5") * 2, (2, 5.5) * 2):
            self.assertEqual((row["body_a"], row["body_b"]), ("needle_0", "floor"))
            self.assertEqual(row["triangle_a"], "" if row["level"] == "bodies" else "0")
            self.assertTrue(float(row["first_low"]) <= first <= float(row["first_high"]), row)
            self.assertEqual((row["instant"], row["instant_kept"]), (instant, ""))
            self.assertTrue(float(row["swept_kept_low"]) <= swept <= float(row["swept_kept_high"]))
        self.assertEqual(os.path.basename(rows[0]["after_frame"]), "needle_1.obj")

    def test_summary(self):
        self.works(*self.scene(), "--adjacent", "skip")
        summary = self.summary()
        self.assertEqual((summary["every"], len(summary["frames"]), summary["adjacent"]),
                         (4, 9, "skip"))
        self.assertEqual((summary["pairs_without_step"], summary["rejected_triangles"]), (0, 0))
        self.assertEqual([{name: str(value) for name, value in row.items()
                           if isinstance(value, (int, str))} for row in summary["motions"]],
                         [{name: row[name] for name in row
                           if not name.startswith("time_") and name != "median_ms"}
                          for row in self.table("motions.csv")])
        self.assertEqual(summary["backend"], "cpu")

    def test_split(self):
        """Two files, and the frames between them."""
        states = self.states((1, -1))
        self.works(*states, "--against", self.mesh("floor.obj", FLOOR), "--swept", "--split", "10")
        frames = self.summary()["frames"]
        self.assertEqual(frames[0], states[0])
        self.assertEqual(frames[3], states[0] + " + 3/10")
        self.assertEqual((frames[10], len(frames)), (states[1], 11))
        row = self.motions()["triangles", "swept", "10"]
        self.assertEqual((row["contacts"], row["contacts_lost"], row["cycles"]), ("1", "0", "1"))
        row = self.motions()["triangles", "instant", "1"]
        self.assertEqual(row["contacts_lost"], "0", "at -0.2 it is in the floor")

    def test_changed_triangles_have_no_step(self):
        states = self.states((1, 0.5, 0.4, -1))
        with open(states[2], "a") as file:
            file.write("f 3 2 1\n")
        done = self.works(*states, "--against", self.mesh("floor.obj", FLOOR), "--swept",
                          "--every", "2")
        self.assertIn("note: 2 pairs of bodies, over all frames, were not looked at or had other "
                      "triangles", done.stderr)
        self.assertEqual(self.summary()["pairs_without_step"], 2)
        self.assertEqual(self.motions()["bodies", "swept", "2"]["contacts"], "0")

    def test_plots(self):
        done = self.works(*self.scene(), plots=True)
        if "no matplotlib" in done.stderr:
            self.skipTest("SKIPPED: no matplotlib")
        for name in "lost", "onsets":
            content = pathlib.Path(self.path("trade", f"{name}.png")).read_bytes()
            self.assertTrue(content.startswith(b"\x89PNG"), name)
        script = str(pathlib.Path(TOOL).with_name("plot_motion.py"))
        subprocess.run([script, self.path("trade"), self.path("trade"), "--out", self.folder],
                       check=True)
        self.assertTrue(os.path.exists(self.path("onsets.png")))
        done = subprocess.run([script, self.path("none")], stderr=subprocess.PIPE, text=True,
                              check=False)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"\Aplot_motion.py: .*none/motions.csv.*\n\Z")

    def test_refusals(self):
        scene = self.scene()
        for option in ("--overlaps", "--predicates", "--clusters", "--fuzzifiers", "--iterations",
                       "--refresh-periods", "--cycles", "--warm-up", "--budget-ms",
                       "--write-config"):
            self.assert_refused([*scene, option, "1"], option, "--swept")
        plain = [*self.states(), "--self"]
        self.assert_refused([*plain, "--every", "2"], "--every", "--swept")
        self.assert_refused([*plain, "--split", "2"], "--split", "--swept")
        self.assert_refused([*plain, "--swept", "--every", "1"], "--every")
        self.assert_refused([*plain, "--swept", "--split", "0"], "--split")
        self.assert_refused([*plain, "--swept", "--backends", "cpu,cuda"], "--backends")
        self.assert_refused(["--bag", "x.bag", "--swept", "--split", "2"], "--split", "--bag")
        self.assertFalse(os.path.exists(self.path("trade")))
        self.assert_refused([*plain, "--swept", "--every", "9"], "9 frames", "--every 9")


@unittest.skipUnless(DATA.is_dir(), f"SKIPPED: no test data at {DATA}")
class RealFrames(Case):

    def test_funnel_swept(self):
        """The figures of the design document: 261, 332 and, in between, 381."""
        self.works(*(DATA / "cloth-funnel" / name for name in ("227.ply", "228.ply")), "--self",
                   "--adjacent", "skip", "--swept", "--split", "10")
        rows = {(row["motion"], row["every"]): row for row in self.table("motions.csv")
                if row["level"] == "triangles"}
        self.assertEqual(rows["swept", "10"]["contacts"], "381")
        self.assertEqual(rows["swept", "10"]["contacts_lost"], "0")
        self.assertEqual(rows["instant", "10"]["contacts_lost"], "40")


if __name__ == "__main__":
    unittest.main()
