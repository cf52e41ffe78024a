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
            safe = row["overlap"] == "1"
            self.assertEqual(row["guaranteed"], "true" if safe else "false")
            self.assertEqual(row["recall_self_worst"], "", "there are no self-contacts to recall")
            if safe:
                self.assertEqual(row["recall_external_worst"], "1")
                if row["predicates"] == "exact":
                    self.assertEqual(row["precision_worst"], "1")
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
        done = self.works(*self.scene(), *quick(), plots=True)
        if "no matplotlib" in done.stderr:
            self.skipTest("SKIPPED: no matplotlib")
        self.assertRegex(done.stderr, r"\A(drawing \(\d+ s\)\n)*\Z")  # progress, on a busy machine
        for name in "accuracy", "work", "clusters", "exact":
            content = pathlib.Path(self.path("trade", f"{name}.png")).read_bytes()
            self.assertTrue(content.startswith(b"\x89PNG"), name)

    def test_plots_of_several_scenes(self):
        scene = self.scene()
        self.works(*scene, *quick(), "--out", "one", plots=True)
        if not os.path.exists(self.path("one", "work.png")):
            self.skipTest("SKIPPED: no matplotlib")
        self.works(*scene, *quick(overlaps="1", predicates="exact"), "--out", "two")
        script = [str(pathlib.Path(TOOL).with_name("plot_trade.py"))]
        subprocess.run([*script, self.path("one"), self.path("two"), "--out", self.folder],
                       check=True)
        self.assertTrue(os.path.exists(self.path("accuracy.png")))
        two = pathlib.Path(self.path("two", "settings.csv"))
        two.write_text(two.read_text().replace("exact", "fast"))
        for folder, problem in (("two", "two/settings.csv: .* predicates fast, which are gone;"),
                                ("three", "three/settings.csv")):
            done = subprocess.run([*script, self.path(folder)], stderr=subprocess.PIPE, text=True,
                                  check=False)
            self.assertEqual(done.returncode, 1)
            self.assertRegex(done.stderr, rf"\Aplot_trade.py: .*{problem}.*\n\Z")

    def test_a_disk_that_is_full_leaves_no_half_a_picture(self):
        self.works(*self.scene(), *quick(overlaps="1", predicates="exact"), plots=True)
        folder = pathlib.Path(self.path("trade"))
        if not (folder / "work.png").exists():
            self.skipTest("SKIPPED: no matplotlib")
        for picture in folder.glob("*.png"):
            picture.unlink()
        (folder / "accuracy.png").write_text("what was there")
        before = sorted(os.listdir(folder))
        done = subprocess.run(
            [str(pathlib.Path(TOOL).with_name("plot_trade.py")), str(folder), "--out", str(folder)],
            stderr=subprocess.PIPE, text=True, check=False, restore_signals=False,
            preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000)))
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertIn("plot_trade.py: ", done.stderr)
        self.assertEqual(sorted(os.listdir(folder)), before)
        self.assertEqual((folder / "accuracy.png").read_text(), "what was there")

    def test_without_matplotlib_there_are_no_plots_and_a_note(self):
        os.mkdir(self.path("blocked"))
        with open(self.path("blocked", "matplotlib.py"), "w") as file:
            file.write("raise ImportError\n")
        done = self.works(*self.scene(), *quick(), plots=True,
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
                ([state, "--self", "--predicates", "fast"], "one of exact, conservative"),
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
            else:
                self.assertEqual(recall, 1)


if __name__ == "__main__":
    sys.exit(unittest.main())
