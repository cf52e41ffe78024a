#!/usr/bin/env python3
"""measure_trade as its users see it: tables, plots, exit codes and messages."""
import os
import pathlib
import resource
import subprocess
import sys
import unittest

from trade_case import ABOVE, DATA, FLOOR, POST, SETTING, TOOL, Case, cloth, quick


class MeasureTrade(Case):

    def test_tables(self):
        self.works(*self.scene(), *quick())
        rows = self.table("settings.csv")
        self.assertEqual(len(rows), 2 * 2 * 2 + 1)
        self.assertEqual(len({tuple(row[key] for key in SETTING) for row in rows}), len(rows))
        for row in rows:
            least, median, p95 = (float(row[f"{key}_ms"]) for key in ("least", "median", "p95"))
            self.assertTrue(0 < least <= median <= p95, row)
            safe = row["overlap"] == "1" and row["predicates"] == "exact"
            self.assertEqual(row["guaranteed"], "true" if safe else "false")
            self.assertEqual(row["recall_self_worst"], "", "there are no self-contacts to recall")
            if safe:
                self.assertEqual((row["recall_external_worst"], row["precision_worst"]), ("1", "1"))
                self.assertEqual(row["recall_external_worst_frame"], "")
            else:
                self.assertLessEqual(float(row["recall_external_worst"]),
                                     float(row["recall_external_mean"]))
            # Two bodies are touched, in one run each, in each of the passes.
            self.assertEqual(row["onset_runs"], "2")
        self.assertTrue(any(row["pareto_front"] == "true" for row in rows))
        hard = [row for row in rows if row["overlap"] == "0" and row["clusters"] == "6"]
        for row in hard:
            self.assertAlmostEqual(float(row["clusters_per_triangle"]), 1, places=2)

    def test_hard_clustering_loses_the_floor_and_says_where(self):
        """One floor triangle is in one cluster; the cloth's other clusters miss it."""
        self.works(*self.scene(), *quick())
        worst = [row for row in self.table("settings.csv")
                 if row["overlap"] == "0" and row["clusters"] == "6"
                 and row["predicates"] == "exact"][0]
        links = {row["link"]: row for row in self.table("links.csv")
                 if all(row[key] == worst[key] for key in SETTING)}
        self.assertEqual(set(links), {"floor", "post"}, "what is never touched is left out")
        for row in links.values():
            self.assertEqual(row["object"], "cloth_0")
            self.assertEqual(row["onset_runs"], "1")
            recall = float(row["recall_worst"])
            self.assertTrue(0 <= recall <= 1)
            self.assertEqual(row["recall_worst_frame"] != "", recall < 1)
            self.assertLessEqual(recall, float(row["recall_mean"]))

    def test_passes(self):
        """Whole passes: five cycles of four states are two passes."""
        self.works(*self.scene(), *quick(cycles="5"))
        self.assertEqual(self.summary()["cycles"], 8)
        self.assertEqual({row["onset_runs"] for row in self.table("settings.csv")}, {"4"})

    def test_self_contacts_and_changed_triangles(self):
        fold = self.mesh("fold.obj", cloth(0.3) + POST.replace("f 1 2 3", "f -3 -2 -1"))
        flat = self.mesh("flat.obj", cloth(0.3, 5))
        self.works(fold, flat, "--self", *quick())
        self.assertEqual({row["recall_external_worst"] for row in self.table("settings.csv")}, {""})
        self.assertEqual({(row["link"], row["object"]) for row in self.table("links.csv")},
                         {("fold", "fold")})
        self.assertEqual([frame["contacts"] > 0 for frame in self.summary()["frames"]],
                         [True, False])

    def test_summary(self):
        self.works(*self.scene(), *quick(), "--out", "a folder/inside", "--adjacent", "skip")
        summary = self.summary("a folder/inside")
        self.assertEqual([frame["contacts"] > 0 for frame in summary["frames"]],
                         [False, True, True, True])
        self.assertEqual([(body["name"], body["deformable"]) for body in summary["bodies"]],
                         [("cloth_0", True), ("floor", False), ("post", False), ("far", False)])
        self.assertEqual((summary["adjacent"], summary["threads"], summary["settings"]),
                         ("skip", 1, 9))
        self.assertEqual(summary["broken_guarantees"], [])
        self.assertTrue(summary["machine"]["cpu"])
        self.assertRegex(summary["command"], r"\Ameasure_trade .*--out 'a folder/inside'")
        self.assertTrue(summary["chosen"]["guaranteed"])

    def test_plots(self):
        done = self.works(*self.scene(), *quick())
        if "no matplotlib" in done.stderr:
            self.skipTest("SKIPPED: no matplotlib")
        self.assertRegex(done.stderr, r"\A(drawing \(\d+ s\)\n)*\Z")  # progress, on a busy machine
        for name in "accuracy", "work", "clusters", "exact":
            content = pathlib.Path(self.path("trade", f"{name}.png")).read_bytes()
            self.assertTrue(content.startswith(b"\x89PNG"), name)

    def test_plots_of_several_scenes(self):
        scene = self.scene()
        self.works(*scene, *quick(), "--out", "one")
        if not os.path.exists(self.path("one", "work.png")):
            self.skipTest("SKIPPED: no matplotlib")
        self.works(*scene, *quick(overlaps="1", predicates="exact"), "--out", "two")
        script = [str(pathlib.Path(TOOL).with_name("plot_trade.py"))]
        subprocess.run([*script, self.path("one"), self.path("two"), "--out", self.folder],
                       timeout=120, check=True)
        self.assertTrue(os.path.exists(self.path("accuracy.png")))
        done = subprocess.run([*script, self.path("three")], stderr=subprocess.PIPE, text=True,
                              timeout=120, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertRegex(done.stderr, r"\Aplot_trade.py: .*three/settings.csv.*\n\Z")

    def test_a_disk_that_is_full_leaves_no_half_a_picture(self):
        self.works(*self.scene(), *quick(overlaps="1", predicates="exact"))
        folder = pathlib.Path(self.path("trade"))
        if not (folder / "work.png").exists():
            self.skipTest("SKIPPED: no matplotlib")
        for picture in folder.glob("*.png"):
            picture.unlink()
        (folder / "accuracy.png").write_text("what was there")
        before = sorted(os.listdir(folder))
        done = subprocess.run(
            [str(pathlib.Path(TOOL).with_name("plot_trade.py")), str(folder), "--out", str(folder)],
            stderr=subprocess.PIPE, text=True, timeout=120, check=False, restore_signals=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)))
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("plot_trade.py: ", done.stderr)
        self.assertEqual(sorted(os.listdir(folder)), before)
        self.assertEqual((folder / "accuracy.png").read_text(), "what was there")

    def test_without_matplotlib_there_are_no_plots_and_a_note(self):
        os.mkdir(self.path("blocked"))
        with open(self.path("blocked", "matplotlib.py"), "w") as file:
            file.write("raise ImportError\n")
        done = self.works(*self.scene(), *quick(),
                          env={**os.environ, "PYTHONPATH": self.path("blocked")})
        self.assertRegex(done.stderr, r"\Aplot_trade.py: .*python3-matplotlib\)\n"
                                      r"measure_trade: note: .*\n\Z")
        self.assertTrue(done.stdout.startswith("Chosen "))
        self.assertEqual(len(self.table("settings.csv")), 9)

    def test_no_contact_at_all(self):
        done = self.works(self.sinking()[0], "--against", self.mesh("far.obj", ABOVE), *quick())
        self.assertIn("note: no frame has a contact", done.stderr)
        self.assertEqual(self.table("links.csv"), [])
        self.assertEqual({row["recall_external_worst"] for row in self.table("settings.csv")}, {""})

    def test_help_and_version(self):
        self.assertIn("--budget-ms", self.works("--help").stdout)
        self.assertRegex(self.works("--version").stdout, r"\Ameasure_trade \d+\.\d+\.\d+\n\Z")

    def test_bad_usage(self):
        state = self.mesh("cloth.obj", cloth(0))
        for arguments, words in (
                (["--self"], "STATE"), ([state], "--against"),
                ([state, "--self", "--bogus"], "--bogus"),
                ([state, "--self", "--overlaps", "0,1.1"], "overlap is 1.1"),
                ([state, "--self", "--overlaps", "0,nan"], "overlap"),
                ([state, "--self", "--overlaps", "0,x"], "--overlaps"),
                ([state, "--self", "--overlaps", ""], "--overlaps"),
                ([state, "--self", "--clusters", "-1"], "clusters is -1"),
                ([state, "--self", "--clusters", ""], "--clusters"),
                ([state, "--self", "--fuzzifiers", "2,1"], "fuzzifier is 1"),
                ([state, "--self", "--iterations", "101"], "iterations is 101"),
                ([state, "--self", "--refresh-periods", "0"], "refresh_period is 0"),
                ([state, "--self", "--predicates", "sloppy"], "sloppy"),
                ([state, "--self", "--predicates", ""], "--predicates"),
                ([state, "--self", "--backends", "fcl"], "fcl"),
                ([state, "--self", "--threads", "-1"], "threads is -1"),
                ([state, "--self", "--cycles", "0"], "--cycles"),
                ([state, "--self", "--warm-up", "-1"], "--warm-up"),
                ([state, "--self", "--budget-ms", "0"], "--budget-ms"),
                ([state, "--self", "--budget-ms", "nan"], "--budget-ms"),
                ([state, "--self", "--budget-ms", "inf"], "--budget-ms"),
                ([state, "--self", "--adjacent", "no"], "--adjacent"),
                ([state, "--self", "--out", ""], "--out"),
                (["--bag", "x.bag", "--self"], "--bag"),
                ([state, "--self", "--write-config", state], state)):
            self.assert_refused(arguments, words)
        self.assertEqual(pathlib.Path(state).read_text(), cloth(0))
        self.assertEqual(os.listdir(self.folder), ["cloth.obj"], "nothing is written")

    def test_bad_files(self):
        state = self.mesh("cloth.obj", cloth(0))
        self.assert_refused([self.path("none.ply"), "--self"], "none.ply", "No such file")
        self.assert_refused([state, "--against", self.mesh("empty.obj", "")], "empty.obj", "empty")
        self.assert_refused([state, self.mesh("cut.off", "OFF 3"), "--self"], "cut.off")
        os.mkdir(self.path("other"))
        self.assert_refused([state, "--against", self.mesh("other/cloth.ply", "ply")], "cloth.ply")
        self.assert_refused([state, "--against", self.mesh("other/cloth.obj", FLOOR)],
                            "other/cloth.obj", state)
        self.assertFalse(os.path.exists(self.path("trade")))

    def test_unwritable_output(self):
        scene = [self.mesh("cloth.obj", cloth(0)), "--self"]
        self.assert_refused([*scene, "--out", scene[0]], scene[0])
        self.assert_refused([*scene, "--out", "/proc/trade"], "/proc/trade")
        self.assert_refused([*scene, "--write-config", self.path("none/x.yaml")], "none/x.yaml")
        os.makedirs(self.path("taken", "links.csv"))
        self.assert_refused([*scene, "--out", self.path("taken")], "taken/links.csv")

    def test_bags_are_read_or_refused(self):
        self.assert_refused(["--bag", self.path("none.bag")], "none.bag")

    def test_cuda_is_measured_or_refused(self):
        done = self.run_tool(*self.scene(), *quick(), "--backends", "cpu,cuda")
        if done.returncode == 0:
            backends = {row["backend"] for row in self.table("settings.csv")}
            self.assertEqual(backends, {"cpu", "cuda"})
        else:
            self.assertEqual(done.returncode, 2)
            self.assertRegex(done.stderr, r"(?i)\Ameasure_trade: [^\n]*CUDA[^\n]*\n\Z")


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
        done = self.works(*self.scene())
        if "no matplotlib" in done.stderr:
            self.skipTest("SKIPPED: no matplotlib")
        for name in "lost", "onsets":
            content = pathlib.Path(self.path("trade", f"{name}.png")).read_bytes()
            self.assertTrue(content.startswith(b"\x89PNG"), name)
        script = str(pathlib.Path(TOOL).with_name("plot_motion.py"))
        subprocess.run([script, self.path("trade"), self.path("trade"), "--out", self.folder],
                       timeout=120, check=True)
        self.assertTrue(os.path.exists(self.path("onsets.png")))
        done = subprocess.run([script, self.path("none")], stderr=subprocess.PIPE, text=True,
                              timeout=120, check=False)
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

    def test_funnel(self):
        self.works(*(DATA / "cloth-funnel" / name for name in ("227.ply", "228.ply")), "--self",
                   *quick(clusters="0,64"))
        self.assertEqual([frame["contacts"] for frame in self.summary()["frames"]], [309, 382])
        rows = self.table("settings.csv")
        for row in rows:
            recall = float(row["recall_self_worst"])
            if row["overlap"] == "0":
                self.assertLess(recall, 1)
                self.assertIn("cloth-funnel/22", row["recall_self_worst_frame"])
            elif row["predicates"] == "exact":
                self.assertEqual(recall, 1)

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
    sys.exit(unittest.main())
