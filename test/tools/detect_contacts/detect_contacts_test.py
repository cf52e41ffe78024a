#!/usr/bin/env python3
"""detect_contacts as its users see it: pairs, JSON, exit codes and messages.

The tool is $DETECT_CONTACTS. Expected pairs are worked out by hand, or are the figures that were
checked on real data.
"""
import json
import os
import pathlib
import resource
import struct
import subprocess
import unittest

from detect_case import ABOVE, Case, DATA, FLOOR, PIERCING, SOURCE, TOOL, TOUCHING


# Two triangles over one edge, folded flat onto each other: they meet beyond the edge.
FOLD = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 2 0\nf 1 2 3\nf 2 1 4\n"

JSON_KEYS = {
    "triangles", "contacts", "candidates", "clusters", "backend", "complete", "detect_ms",
    "round_trip_ms", "stages_ms", "posed", "culled", "clustered", "rejected_triangles", "large",
    "cluster_entries", "interval_overlaps", "exact", "undecided", "options", "files", "repeat",
    "guaranteed"}


class DetectContacts(Case):

    def test_pairs_between_files(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING),
                  self.mesh("touch.obj", TOUCHING)]
        for backend in "auto", "cpu", "brute_force":
            self.assertEqual(self.pairs("--backend", backend, *meshes), "0 0 1 1\n0 0 2 0\n")
        self.assertEqual(self.pairs(*reversed(meshes)), "0 0 2 0\n1 1 2 0\n")
        self.assertEqual(self.pairs(meshes[1], self.mesh("above.obj", TOUCHING)), "")

    def test_polygons_are_what_they_look_like(self):
        """A needle through the notch of an L touches nothing, whatever corner the L begins with."""
        corners = "v 0 0 0\nv 2 0 0\nv 2 1 0\nv 1 1 0\nv 1 2 0\nv 0 2 0\n"
        notch = self.mesh("notch.obj", "v 1.2 1.2 -1\nv 1.2 1.25 1\nv 1.25 1.2 1\nf 1 2 3\n")
        needle = self.mesh("needle.obj", "v .2 .2 -1\nv .2 .25 2\nv .25 .2 2\nf 1 2 3\n")
        for first in range(6):
            face = "f " + " ".join(str((first + i) % 6 + 1) for i in range(6))
            shape = self.mesh("l.obj", corners + face)
            self.assertEqual(self.works("--pairs", "-", shape, notch).stdout, "")
            self.assertNotEqual(self.works("--pairs", "-", shape, needle).stdout, "")
        bent = self.mesh("bent.obj", corners.replace("1 1 0", "1 1 9") + "f 1 2 3 4 5 6\n")
        done = self.works(bent, needle)
        self.assertIn("detect_contacts: note: " + bent + ": 1 of 1 polygons of 4", done.stderr)

    def test_self_contacts(self):
        fold = self.mesh("fold.obj", FOLD)
        floor = self.mesh("floor.obj", FLOOR)
        self.assertEqual(self.pairs(fold, floor), "0 0 1 0\n0 1 1 0\n")
        self.assertEqual(self.pairs("--self", fold, floor), "0 0 0 1\n0 0 1 0\n0 1 1 0\n")
        self.assertEqual(self.pairs("--self", "--adjacent", "skip", fold, floor),
                         "0 0 1 0\n0 1 1 0\n")

    def test_margin(self):
        floor, above = self.mesh("floor.obj", FLOOR), self.mesh("above.obj", ABOVE)
        self.assertEqual(self.pairs("--margin", "1.99", floor, above), "")
        self.assertEqual(self.pairs("--margin", "2", floor, above), "0 0 1 0\n")

    def states(self, *arguments):
        done = self.works("--json", "-", *arguments)
        report = json.loads(done.stdout)
        return {tuple(s["bodies"]): s for s in report["body_states"]}, report, done.stderr

    def test_tolerance(self):
        """Floor at z 0; ABOVE 2 m over it; a slab pierces it."""
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING),
                  self.mesh("above.obj", ABOVE)]
        states, report, note = self.states("--backend", "cpu", "--tolerance-m", ".5", *meshes)
        self.assertEqual([states[pair]["state"] for pair in ((0, 1), (0, 2))],
                         ["contact", "none"])
        self.assertEqual(states[0, 1]["distance_high"], 0)
        self.assertEqual(states[0, 1]["witness"], [0, 1])
        self.assertTrue(0 < states[0, 2]["distance_low"] <= 2)
        self.assertFalse(report["complete"] or report["guaranteed"])
        self.assertEqual(report["options"]["tolerance_m"], .5)
        self.assertIn("seen on the way, not all\n", note)
        states, _, _ = self.states("--backend", "cpu", "--tolerance-m", "2.5", "--margin", "3",
                                   meshes[0], meshes[2])
        self.assertEqual(states[0, 1]["state"], "contact")
        self.assertAlmostEqual(states[0, 1]["distance_high"], 2, 5)
        self.assertEqual([point[2] for point in states[0, 1]["points"]], [0, 2])
        states, _, _ = self.states("--backend", "cpu", "--tolerance-m", ".5", "--margin", "3",
                                   meshes[0], meshes[2])
        self.assertEqual(states[0, 1]["state"], "near")

    def test_a_body_with_rejected_triangles_is_unknown_unless_it_touches(self):
        """In ABOVE's place there may be a triangle of which a vertex is NaN."""
        floor, pierce = self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)
        hole = self.mesh("hole.obj", ABOVE + "v 0 0 nan\nf 1 2 4\n")
        nothing = self.mesh("nothing.obj", "v 0 0 nan\nv 4 0 nan\nv 0 4 nan\nf 1 2 3\n")
        clean = self.mesh("clean.obj", ABOVE.replace(" 2\n", " 20\n"))
        for options in (["cpu", "--tolerance-m", ".5"], ["cpu", "--budget-ms", "1e5"],
                        ["brute_force", "--tolerance-m", ".5"],
                        ["cpu", "--budget-ms", "1e5", "--nearest", self.path("n")],
                        ["cpu", "--tolerance-m", "2.5"]):
            options = ["--backend", *options, "--margin", "2.25"]
            for body in hole, nothing:
                meshes = [floor, pierce, body, clean]
                states, report, _ = self.states(*options, *meshes)
                touches = body == hole and "2.5" in options
                self.assertEqual(
                    [states[pair]["state"] for pair in ((0, 1), (0, 2), (0, 3), (2, 3))],
                    ["contact", "contact" if touches else "unknown", "none", "unknown"], options)
                self.assertEqual((states[0, 2]["distance_low"], states[0, 2]["listed"]), (0, False))
                self.assertEqual(report["rejected_triangles"], 1)
                done = self.works(*options, *meshes)
                self.assertNotIn("of pairs of bodies it is certain", done.stdout)
                self.assertNotIn("inf apart", done.stdout)
        done = self.works("--backend", "cpu", "--tolerance-m", ".5", floor, nothing)
        self.assertRegex(done.stdout, r"nothing.obj: unknown, nothing is known of the distance\n")
        self.assertIn("their bodies are unknown unless they touch", done.stdout)

    def test_backends_without_bounds_are_exact(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING),
                  self.mesh("above.obj", ABOVE)]
        states, report, note = self.states("--backend", "brute_force", "--tolerance-m", "3",
                                           *meshes)
        self.assertEqual([states[pair]["state"] for pair in ((0, 1), (0, 2))],
                         ["contact", "none"])
        self.assertIsNone(states[0, 2]["witness"])
        self.assertTrue(report["complete"])
        self.assertEqual(note, "")

    def test_budget(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        states, report, _ = self.states("--backend", "cpu", "--budget-ms", "1e-6", *meshes)
        self.assertEqual(states[0, 1]["state"], "unknown")
        self.assertEqual(report["cut_off_because"], "no time")
        states, report, _ = self.states("--backend", "cpu", "--budget-ms", "1e5", *meshes)
        self.assertEqual(states[0, 1]["state"], "contact")
        self.assertTrue(report["complete"] and states[0, 1]["listed"])

    def test_states_are_in_the_summary(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        done = self.works("--backend", "cpu", "--tolerance-m", ".5", *meshes)
        self.assertRegex(done.stdout, r"pairs of bodies, within 0.5:\n  \S+ with \S+: contact, 0 to 0 "
                                      r"apart, by triangles 0 and 1\n")

    def test_tolerance_and_budget_are_refused_by_name(self):
        floor = self.mesh("floor.obj", FLOOR)
        for option, value in (("--tolerance-m", "-1"), ("--budget-ms", "0"), ("--budget-ms", "x")):
            self.assert_refused([option, value, floor, floor], option.strip("-").split("-")[0])
        for option in ("--tolerance-m", "--budget-ms"):
            self.assert_refused(["--swept", option, "1", floor, floor], option, "--swept")

    def test_speed_options_do_not_change_pairs(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        for options in (["--clusters", "7"], ["--threads", "1"], ["--fuzzifier", "2"],
                        ["--iterations", "0"], ["--refresh-period", "3", "--repeat", "5"],
                        ["--predicates", "conservative"]):
            self.assertEqual(self.pairs(*options, *meshes), "0 0 1 1\n", options)

    def test_one_mesh_alone_has_no_pairs_and_a_note(self):
        done = self.works("--pairs", "-", self.mesh("fold.obj", FOLD))
        self.assertEqual(done.stdout, "")
        self.assertIn("--self", done.stderr)

    def test_summary_is_for_people(self):
        done = self.works(self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING))
        self.assertTrue(done.stdout.startswith("1 contacts\n"), done.stdout)
        self.assertIn("floor.obj with ", done.stdout)
        self.assertIn("complete: yes", done.stdout)
        self.assertEqual(done.stderr, "")

    def test_files(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        done = self.works("--pairs", self.path("pairs"), "--json", self.path("json"), *meshes)
        self.assertTrue(done.stdout.startswith("1 contacts\n"))
        self.assertEqual(pathlib.Path(self.path("pairs")).read_text(), "0 0 1 1\n")
        report = json.loads(pathlib.Path(self.path("json")).read_text())
        self.assertEqual(report["contacts"], 1)
        # An older, longer file is replaced, not overwritten in part.
        self.mesh("pairs", "old\n" * 100)
        done = self.works("--pairs", self.path("pairs"), "--json", "-", *meshes)
        self.assertEqual(json.loads(done.stdout)["contacts"], 1)
        self.assertEqual(pathlib.Path(self.path("pairs")).read_text(), "0 0 1 1\n")

    def test_json(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        report = self.json("--repeat", "7", "--overlap", "0.5", "--clusters", "3", *meshes)
        self.assertLessEqual(JSON_KEYS, set(report))
        self.assertEqual((report["triangles"], report["repeat"]), (3, 7))
        self.assertEqual([file["path"] for file in report["files"]], meshes)
        self.assertEqual(report["options"]["overlap"], 0.5)
        self.assertEqual(report["options"]["clusters"], 3)
        self.assertFalse(report["guaranteed"])
        self.assertFalse(report["complete"])
        for times in report["detect_ms"], report["round_trip_ms"]:
            self.assertEqual(set(times), {"first", "median", "p95"})
            self.assertLessEqual(times["median"], times["p95"])
        self.assertTrue(all(ms >= 0 for ms in report["stages_ms"].values()))
        report = self.json(*meshes)
        self.assertEqual((report["complete"], report["guaranteed"]), (True, True))
        self.assertEqual(report["options"]["clusters"], "auto")
        self.assertIn(report["backend"], ("cpu", "cuda"))

    def test_geometry(self):
        """What the manual shows; the pairs are --pairs's, the numbers the float32 themselves."""
        meshes = [self.mesh("floor.obj", FLOOR),
                  self.mesh("blade.obj", "v 1 1 -0.5\nv 1 0.5 1.5\nv 1 1.5 1.5\nf 1 2 3\n")]
        line = self.works("--geometry", "-", *meshes).stdout
        manual = (SOURCE / "src/tools/detect_contacts/README.md").read_text()
        self.assertIn("    " + line, manual)
        numbers = [float(number) for number in line.split()]
        self.assertEqual(numbers[:4], [0, 0, 1, 0])
        self.assertEqual(numbers[10:], [0, 0, 1, -0.5, 0])
        for backend in "brute_force", "cpu":
            self.assertEqual(self.works("--backend", backend, "--geometry", "-", *meshes).stdout,
                             line)
        self.assertEqual(self.works("--geometry", self.path("g"), "--pairs", "-", *meshes).stdout,
                         "0 0 1 0\n")
        self.assertEqual(pathlib.Path(self.path("g")).read_text(), line)

        near = self.works("--geometry", "-", "--margin", "2", meshes[0],
                          self.mesh("above.obj", ABOVE)).stdout.split()
        self.assertEqual([float(n) for n in near[-5:]], [0, 0, 1, 2, 0])
        self.assertEqual(self.works("--geometry", "-", meshes[0], self.path("above.obj")).stdout, "")

        report = self.json("--self", "--geometry", self.path("g"), self.mesh("fold.obj", FOLD))
        self.assertEqual(report["geometry"], {
            "deepest": 0, "coplanar": 1, "degenerate": 0, "normal_not_unique": 1,
            "normal_undefined": 0, "separation_undefined": 0})
        self.assertNotIn("geometry", self.json(*meshes))

    def test_references_say_what_they_are(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        self.assertTrue(self.json("--backend", "brute_force", *meshes)["complete"])
        done = self.run_tool("--backend", "fcl", "--json", "-", *meshes)
        if done.returncode == 2:
            self.assertIn("no FCL", done.stderr)
            return
        report = json.loads(done.stdout)
        self.assertEqual((report["backend"], report["contacts"]), ("fcl", 1))
        self.assertFalse(report["complete"])
        self.assert_refused(["--backend", "fcl", "--margin", "1", *meshes], "--margin", "fcl")

    def test_rejected_triangles_are_counted(self):
        bad = self.mesh("bad.obj", FLOOR + "v nan 0 0\nv 0 inf 0\nf 1 2 4\nf 5 1 2\n")
        touching = self.mesh("touching.obj", TOUCHING)
        report = self.json(bad, touching)
        self.assertEqual((report["contacts"], report["rejected_triangles"]), (1, 2))
        self.assertEqual((report["complete"], report["guaranteed"]), (False, True))
        done = self.works("--pairs", "-", bad, touching)
        self.assertEqual(done.stdout, "0 0 1 0\n")
        self.assertIn("2 triangles", done.stderr)

    def test_file_name_that_is_no_utf8(self):
        name = os.fsencode(self.folder) + b"/\xff.obj"
        with open(name, "w") as file:
            file.write(FLOOR)
        report = self.json(os.fsdecode(name))
        self.assertEqual(report["triangles"], 1)

    def test_help_and_version(self):
        self.assertIn("--backend", self.works("--help").stdout)
        self.assertRegex(self.works("--version").stdout, r"\Adetect_contacts \d+\.\d+\.\d+\n\Z")

    def test_bad_usage(self):
        floor = self.mesh("floor.obj", FLOOR)
        for arguments, words in (
                ([], "MESH"), (["--bogus", floor], "--bogus"),
                (["--backend", "gpu", floor], "gpu"), (["--adjacent", "no", floor], "--adjacent"),
                (["--predicates", "x", floor], "--predicates"),
                (["--overlap", "1.1", floor], "overlap"), (["--overlap", "nan", floor], "overlap"),
                (["--clusters", "0", floor], "--clusters"),
                (["--clusters", "2x", floor], "--clusters"),
                (["--clusters", "65536", floor], "clusters"),
                (["--margin", "-1", floor], "margin"), (["--margin", "inf", floor], "margin"),
                (["--repeat", "0", floor], "--repeat"), (["--threads", "-1", floor], "threads"),
                (["--fuzzifier", "1", floor], "fuzzifier"),
                (["--iterations", "101", floor], "iterations"),
                (["--refresh-period", "0", floor], "refresh_period"),
                (["--pairs", "-", "--json", "-", floor], "--json"),
                (["--pairs", "-", "--geometry", "-", floor], "--geometry"),
                (["--geometry", "x", "--json", "x", floor], "--geometry")):
            done = self.assert_refused(arguments, words)
            self.assertEqual(done.stdout, "")

    def test_a_forgotten_file_name_costs_no_mesh(self):
        floor, touch = self.mesh("floor.obj", FLOOR), self.mesh("touch.obj", TOUCHING)
        self.assert_refused(["--pairs", floor, touch], "--pairs", floor)
        self.assert_refused(["--geometry", floor, touch], "--geometry", floor)
        self.assertEqual(pathlib.Path(floor).read_text(), FLOOR)

    def test_bad_meshes_name_file_and_place(self):
        floor = self.mesh("floor.obj", FLOOR)
        for name, content, words in (
                ("empty.obj", "", "is empty"), ("points.obj", "v 0 0 0\n", "no triangle"),
                ("index.obj", FLOOR + "f 1 2 9\n", "index.obj:5: "),
                ("text.off", "hello\n", "text.off:1: "), ("mesh.xyz", "0 0 0\n", ".obj"),
                ("cut.stl", "solid\nfacet normal 0 0 1\n", "cut.stl:3: ")):
            mesh = self.mesh(name, content)
            done = self.assert_refused(["--pairs", self.path("out"), floor, mesh], mesh, words)
            self.assertEqual(done.stdout, "")
            self.assertFalse(os.path.exists(self.path("out")))
        self.assert_refused([self.path("none.ply")], "none.ply", "No such file")
        os.mkdir(self.path("folder.stl"))
        self.assert_refused([self.path("folder.stl")], "folder.stl", "directory")
        with open(self.path("cut_binary.stl"), "wb") as file:
            file.write(b"solid".ljust(80, b"\0") + struct.pack("<I", 7) + b"\0" * 60)
        self.assert_refused([self.path("cut_binary.stl")], "cut_binary.stl", "7 facets")

    def test_unwritable_output(self):
        floor = self.mesh("floor.obj", FLOOR)
        self.assert_refused(["--self", "--pairs", self.path("none/pairs"), floor], "none/pairs")
        self.assert_refused(["--self", "--json", self.folder, floor], self.folder)
        self.assert_refused(["--self", "--json", "/dev/full", floor], "/dev/full", "No space")
        with open("/dev/full", "w") as full:
            done = subprocess.run([TOOL, "--self", "--json", "-", floor], stdout=full,
                                  stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual(done.returncode, 2)
        self.assertIn("standard output", done.stderr)

    def test_a_disk_that_is_full_leaves_no_half_a_file(self):
        floor = self.mesh("floor.obj", FLOOR)
        touch = self.mesh("touch.obj", TOUCHING + "f 1 2 3\n" * 300)
        for earlier in (None, "what was there\n"):
            if earlier:
                with open(self.path("pairs"), "w") as file:
                    file.write(earlier)
            before = sorted(os.listdir(self.folder))
            done = subprocess.run(
                [TOOL, "--pairs", self.path("pairs"), floor, touch], stdout=subprocess.PIPE,
                stderr=subprocess.PIPE, text=True, check=False, restore_signals=False,
                preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000)))
            self.assertEqual(done.returncode, 2, done.stderr)
            self.assertIn("pairs: cannot be written", done.stderr)
            self.assertEqual(sorted(os.listdir(self.folder)), before)
            if earlier:
                with open(self.path("pairs")) as file:
                    self.assertEqual(file.read(), earlier)

    def test_reader_that_goes_away(self):
        floor = self.mesh("floor.obj", FLOOR + "f 1 2 3\n" * 300)
        touch = self.mesh("touch.obj", TOUCHING + "f 1 2 3\n" * 300)  # 90 601 pairs, 1 MB
        run = subprocess.Popen([TOOL, "--pairs", "-", floor, touch], stdout=subprocess.PIPE,
                               stderr=subprocess.PIPE, text=True)
        self.assertEqual(run.stdout.readline(), "0 0 1 0\n")
        run.stdout.close()
        with run.stderr as said:  # on a busy machine, how far it is
            self.assertEqual([line for line in said if not line.startswith("detecting, ")], [])
        self.assertEqual(run.wait(timeout=60), 0)

    def test_cuda_runs_or_says_why_it_is_the_cpu(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        done = self.run_tool("--backend", "cuda", "--pairs", "-", *meshes)
        self.assertEqual((done.returncode, done.stdout), (0, "0 0 1 1\n"))
        report = json.loads(self.run_tool("--backend", "cuda", "--json", "-", *meshes).stdout)
        if report["backend"] == "cuda":
            self.assertEqual(done.stderr, "")
        else:
            self.assertEqual(report["backend"], "cpu")
            self.assertEqual(done.stderr.count("\n"), 1)
            self.assertIn("warning: CUDA cannot be used, so on the CPU: ", done.stderr)


@unittest.skipUnless(DATA.is_dir(), f"SKIPPED: no test data at {DATA}")
class RealFrames(unittest.TestCase):
    """The figures of the design document, through the tool."""

    FRAMES = (("cloth-ball/cloth_ball92.ply", 61530, 63602),
              ("cloth-ball/cloth_ball93.ply", 97320, 99872),
              ("cloth-funnel/227.ply", 261, 309), ("cloth-funnel/228.ply", 332, 382))

    def test_counts(self):
        for name, skip, beyond_shared in self.FRAMES:
            for adjacent, wanted in ("skip", skip), ("beyond_shared", beyond_shared):
                done = subprocess.run(
                    [TOOL, "--self", "--adjacent", adjacent, "--pairs", "-", DATA / name],
                    stdout=subprocess.PIPE, text=True, check=True)
                pairs = [tuple(map(int, line.split(" "))) for line in done.stdout.splitlines()]
                self.assertEqual(len(pairs), wanted, (name, adjacent))
                self.assertEqual(pairs, sorted(set(pairs)), "sorted, each once")
                self.assertTrue(all(a < b for _, a, _, b in pairs))


if __name__ == "__main__":
    unittest.main()
