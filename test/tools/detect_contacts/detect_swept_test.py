#!/usr/bin/env python3
"""detect_contacts --swept: pairs, times, JSON and messages.

Expected pairs are worked out by hand, or those of the tests' oracle, $SWEPT_PAIRS.
"""
import os
import pathlib
import random
import shutil
import struct
import subprocess
import tempfile
import unittest

from detect_case import Case, DATA, FLOOR, TOOL, TOUCHING

SWEPT_PAIRS = os.environ["SWEPT_PAIRS"]

# A triangle above the floor, and where it is after it has gone through; nothing touches at the
# ends. Its tip, at x = y = 1, is in the floor's plane in the middle of the step.
BEFORE = "v 1 1 1\nv 1 2 3\nv 2 1 3\nf 1 2 3\n"
BEHIND = "v 1 1 -1\nv 1 2 -0.5\nv 2 1 -0.5\nf 1 2 3\n"


def lines_of(program, *arguments):
    """What it prints, numbers by lines, sorted and each once."""
    done = subprocess.run([program, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          text=True, check=False)
    assert done.returncode == 0, done.stderr
    lines = [tuple(map(int, line.split(" "))) for line in done.stdout.splitlines()]
    assert lines == sorted(set(lines)), "sorted, each once"
    return lines


class DetectSwept(Case):

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

    def test_swept_polygons_have_the_triangles_of_the_later_state(self):
        floor = self.mesh("floor.obj", "v 9 9 1\nv 9 8 1\nv 8 9 1\nf 1 2 3\n")
        convex, dart = (self.mesh(name, "v 0 0 0\nv 4 4 0\nv 0 8 0\nv %s 0\nf 1 2 3 4\n" % corner)
                        for name, corner in (("convex.obj", "-4 4"), ("dart.obj", "2 4")))
        for states in (convex, dart), (dart, convex):
            report = self.json("--swept", floor, floor, *states)
            self.assertEqual((report["triangles"], report["complete"]), (3, True))

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
