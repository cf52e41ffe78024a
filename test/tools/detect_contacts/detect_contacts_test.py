#!/usr/bin/env python3
"""detect_contacts as its users see it: pairs, JSON, exit codes and messages.

The tool is $DETECT_CONTACTS. Expected pairs are worked out by hand, or are the figures that were
checked on real data; between two states, they are those of the tests' oracle, $SWEPT_PAIRS.
"""
import json
import os
import pathlib
import random
import resource
import shutil
import struct
import subprocess
import tempfile
import unittest

TOOL = os.environ["DETECT_CONTACTS"]
SWEPT_PAIRS = os.environ["SWEPT_PAIRS"]
SOURCE = pathlib.Path(__file__).resolve().parents[3]
DATA = pathlib.Path(os.environ.get("DCM_TEST_DATA") or SOURCE / "../shared/data")

# A triangle in the plane z = 0, one that pierces it, one that touches its corner, one far off.
FLOOR = "v 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n"
PIERCING = "v 9 9 9\nv 9 8 9\nv 8 9 9\nv 1 1 -1\nv 1 1 1\nv 1 2 1\nf 1 2 3\nf 4 5 6\n"
TOUCHING = "v 4 0 0\nv 5 0 0\nv 5 0 1\nf 1 2 3\n"
ABOVE = "v 0 0 2\nv 4 0 2\nv 0 4 2\nf 1 2 3\n"
# Two triangles over one edge, folded flat onto each other: they meet beyond the edge.
FOLD = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 2 0\nf 1 2 3\nf 2 1 4\n"

# A triangle above the floor, and where it is after it has gone through; nothing touches at the ends.
# Its tip, at x = y = 1, is in the floor's plane in the middle of the step.
BEFORE = "v 1 1 1\nv 1 2 3\nv 2 1 3\nf 1 2 3\n"
BEHIND = "v 1 1 -1\nv 1 2 -0.5\nv 2 1 -0.5\nf 1 2 3\n"

JSON_KEYS = {
    "triangles", "contacts", "candidates", "clusters", "backend", "complete", "detect_ms",
    "round_trip_ms", "stages_ms", "posed", "culled", "clustered", "rejected_triangles", "large",
    "cluster_entries", "interval_overlaps", "exact", "undecided", "options", "files", "repeat",
    "guaranteed"}


def lines_of(program, *arguments):
    """What it prints, numbers by lines, sorted and each once."""
    done = subprocess.run([program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, timeout=300, check=False)
    assert done.returncode == 0, done.stderr
    lines = [tuple(map(int, line.split(" "))) for line in done.stdout.splitlines()]
    assert lines == sorted(set(lines)), "sorted, each once"
    return lines


class DetectContacts(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def mesh(self, name, content):
        with open(self.path(name), "w") as file:
            file.write(content)
        return self.path(name)

    def run_tool(self, *arguments, **options):
        return subprocess.run([TOOL, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, errors="replace", timeout=300, check=False, **options)

    def works(self, *arguments):
        done = self.run_tool(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def pairs(self, *arguments):
        return self.works("--pairs", "-", *arguments).stdout

    def json(self, *arguments):
        return json.loads(self.works("--json", "-", *arguments).stdout)

    def assert_refused(self, arguments, *wanted, **options):
        done = self.run_tool(*arguments, **options)
        self.assertEqual(done.returncode, 2, done)
        self.assertRegex(done.stderr, r"\Adetect_contacts: [^\n]+\n\Z")
        for words in wanted:
            self.assertIn(words, done.stderr)
        return done

    def test_pairs_between_files(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING),
                  self.mesh("touch.obj", TOUCHING)]
        for backend in "auto", "cpu", "brute_force":
            self.assertEqual(self.pairs("--backend", backend, *meshes), "0 0 1 1\n0 0 2 0\n")
        self.assertEqual(self.pairs(*reversed(meshes)), "0 0 2 0\n1 1 2 0\n")
        self.assertEqual(self.pairs(meshes[1], self.mesh("above.obj", TOUCHING)), "")

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

    def test_speed_options_do_not_change_pairs(self):
        meshes = [self.mesh("floor.obj", FLOOR), self.mesh("pierce.obj", PIERCING)]
        for options in (["--clusters", "7"], ["--threads", "1"], ["--fuzzifier", "2"],
                        ["--iterations", "0"], ["--refresh-period", "3", "--repeat", "5"],
                        ["--predicates", "conservative"]):
            self.assertEqual(self.pairs(*options, *meshes), "0 0 1 1\n", options)

    def swept_files(self):
        """Floor, still; what goes through it."""
        floor = self.mesh("floor.obj", FLOOR)
        return [floor, floor, self.mesh("before.obj", BEFORE), self.mesh("behind.obj", BEHIND)]

    def test_swept_sees_what_goes_through(self):
        floor, _, before, behind = files = self.swept_files()
        for backend in "auto", "cpu", "brute_force":
            for state in before, behind:
                self.assertEqual(self.pairs("--backend", backend, floor, state), "")
            self.assertEqual(self.pairs("--backend", backend, "--swept", *files), "0 0 1 0\n")
            self.assertEqual(self.pairs("--backend", backend, "--swept", floor, floor, behind,
                                        before), "0 0 1 0\n")
            # What is nowhere near, and a body that stands still.
            self.assertEqual(self.pairs("--backend", backend, "--swept", floor, floor, before,
                                        before), "")

    def test_times_of_first_contact(self):
        files = self.swept_files()
        touch = self.mesh("touch.obj", TOUCHING)
        lines = self.works("--swept", "--times", "-", *files, touch, touch).stdout.splitlines()
        rows = [line.split(" ") for line in lines]
        self.assertEqual([row[:4] for row in rows],
                         [["0", "0", "1", "0"], ["0", "0", "2", "0"]])
        low, high = map(float, rows[0][4:])
        self.assertTrue(low <= 0.5 <= high <= low + 2**-20, rows)
        self.assertEqual(rows[1][4:], ["0", "0"])
        for text in rows[0][4:]:  # the float32 itself
            self.assertEqual("%.9g" % struct.unpack("f", struct.pack("f", float(text))), text)
        done = self.works("--swept", "--times", self.path("times"), "--pairs", "-", *files)
        self.assertEqual(done.stdout, "0 0 1 0\n")
        self.assertEqual(pathlib.Path(self.path("times")).read_text(), lines[0] + "\n")

    def test_swept_json(self):
        files = self.swept_files()
        touch = self.mesh("touch.obj", TOUCHING)
        report = self.json("--swept", "--times", self.path("t"), *files, touch, touch)
        self.assertEqual((report["motion"], report["contacts"], report["at_start"]),
                         ("swept", 2, 1))
        self.assertTrue(report["complete"] and report["guaranteed"])
        self.assertEqual([(file["earlier"], file["path"]) for file in report["files"]],
                         [tuple(files[:2]), tuple(files[2:]), (touch, touch)])
        self.assertEqual((report["triangles"], report["rejected_triangles"]), (3, 0))
        self.assertNotIn("at_start", self.json("--swept", *files))
        report = self.json(files[0], files[2])
        self.assertEqual(report["motion"], "instant")
        self.assertNotIn("earlier", report["files"][0])

    def test_swept_counts_what_is_not_finite_at_either_end(self):
        floor, _, before, behind = self.swept_files()
        bad = self.mesh("bad.obj", BEFORE.replace("2 1 3", "2 nan 3"))
        for states in (bad, behind), (behind, bad):
            report = self.json("--swept", floor, floor, *states)
            self.assertEqual((report["contacts"], report["rejected_triangles"]), (0, 1))
            self.assertFalse(report["complete"])

    def test_swept_refuses(self):
        floor, _, before, behind = files = self.swept_files()
        two = self.mesh("two.obj", FLOOR + "f 3 2 1\n")
        turned = self.mesh("turned.obj", FLOOR.replace("f 1 2 3", "f 2 3 1"))
        point = self.mesh("point.obj", FLOOR + "v 7 7 7\n")
        for arguments, words in (
                ([floor], floor), ([*files, two], two), ([floor, two], two),
                ([two, floor], floor), ([before, behind, floor, turned], turned),
                ([floor, point], point), ([floor, self.path("none.obj")], "none.obj"),
                ([self.path("none.obj"), floor], "none.obj"),
                (["--margin", "1", *files], "--margin"), (["--margin", "0", *files], "--margin"),
                (["--geometry", "-", *files], "--geometry"),
                (["--backend", "fcl", *files], "fcl")):
            done = self.assert_refused(["--swept", "--pairs", self.path("out"), *arguments], words)
            self.assertEqual(done.stdout, "")
            self.assertFalse(os.path.exists(self.path("out")))
        self.assert_refused(["--times", "-", floor, before], "--times", "--swept")
        self.assert_refused(["--swept", "--times", floor, *files], "--times", floor)
        self.assert_refused(["--swept", "--times", "-", "--pairs", "-", *files], "--times")
        self.assert_refused(["--swept", "--times", "x", "--json", "x", *files], "--times")

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
                                  stderr=subprocess.PIPE, text=True, timeout=60, check=False)
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
                stderr=subprocess.PIPE, text=True, timeout=60, check=False, restore_signals=False,
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
        self.assertEqual(run.stderr.read(), "")
        run.stderr.close()
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


class SweptAgainstTheOracle(unittest.TestCase):
    """Random soups that move, with themselves: sets, by $SWEPT_PAIRS."""

    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp())
        self.addCleanup(shutil.rmtree, self.folder)

    def soup(self, rng, triangles):
        """Two states on a small grid: ties, shared vertices, segments and points."""
        faces = "".join("f %d %d %d\n" % tuple(rng.randint(1, 2 * triangles) for _ in range(3))
                        for _ in range(triangles))
        files = []
        for state in "earlier", "later":
            files.append(self.folder / (state + ".obj"))
            files[-1].write_text("".join(
                "v %d %d %d\n" % tuple(rng.randint(0, 6) for _ in range(3))
                for _ in range(2 * triangles)) + faces)
        return files

    def test_sets(self):
        for seed in range(6):
            files = self.soup(random.Random(seed), 30)
            for adjacent in "skip", "beyond_shared":
                options = ["--adjacent", adjacent, *files]
                wanted = lines_of(SWEPT_PAIRS, *options)
                self.assertGreater(len(wanted), 20)
                for backend in "cpu", "brute_force":
                    found = lines_of(TOOL, "--swept", "--self", "--pairs", "-", "--backend",
                                     backend, *options)
                    self.assertEqual([(a, b) for _, a, _, b in found], wanted,
                                     (seed, adjacent, backend))


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
                    stdout=subprocess.PIPE, text=True, timeout=300, check=True)
                pairs = [tuple(map(int, line.split(" "))) for line in done.stdout.splitlines()]
                self.assertEqual(len(pairs), wanted, (name, adjacent))
                self.assertEqual(pairs, sorted(set(pairs)), "sorted, each once")
                self.assertTrue(all(a < b for _, a, _, b in pairs))

    def test_swept(self):
        """Of one step, against the oracle."""
        files = [DATA / "cloth-funnel/227.ply", DATA / "cloth-funnel/228.ply"]
        for adjacent, count in ("skip", 381), ("beyond_shared", 510):
            options = ["--adjacent", adjacent, *files]
            found = lines_of(TOOL, "--swept", "--self", "--pairs", "-", *options)
            self.assertEqual(len(found), count, adjacent)
            self.assertEqual([(a, b) for _, a, _, b in found], lines_of(SWEPT_PAIRS, *options),
                             adjacent)


if __name__ == "__main__":
    unittest.main()
