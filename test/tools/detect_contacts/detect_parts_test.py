#!/usr/bin/env python3
"""detect_contacts --parts: what is left out, and what is wrong with a file."""
import unittest

from detect_case import Case, FLOOR, PIERCING, TOUCHING

# Two triangles that pierce the floor, side by side.
TWO = "v 1 1 -1\nv 1 1 1\nv 1 2 1\nv 2 1 -1\nv 2 1 1\nv 2 2 1\nf 1 2 3\nf 4 5 6\n"


class DetectParts(Case):

    def bodies(self):
        return self.mesh("floor.obj", FLOOR), self.mesh("two.obj", TWO)

    def with_parts(self, text, *arguments):
        return self.pairs("--parts", self.mesh("parts.txt", text), *arguments, *self.bodies())

    def test_skipped_parts_are_left_out(self):
        both, first, second = "0 0 1 0\n0 0 1 1\n", "0 0 1 0\n", "0 0 1 1\n"
        for backend in "auto", "cpu", "brute_force":
            for text, wanted in (
                    ("", both),
                    ("# nothing is skipped\npart 1 tip 0\n", both),
                    ("part 1 tip 0  # the first\nskip 1:tip 0\n", second),
                    ("part 1 tip 0-0\nskip 0:rest 1:tip\n", second),
                    ("part 1 tip 0\nskip 0 1:rest\n", first),
                    ("part 1 tip 0\npart 1 end 1\nskip 0 1:rest\n", both),
                    ("part 1 tip 0\npart 1 tip 1\nskip 0 1:tip\n", ""),
                    ("part 1 tip 0-1\nskip 0 1\n", ""),
                    ("skip 1 0\n", ""),
                    ("part 1 tip 0\nskip 1:tip 1:tip\n", both)):
                self.assertEqual(self.with_parts(text, "--backend", backend), wanted, text)

    def test_distances_are_those_of_the_parts_that_count(self):
        floor, piercing = self.mesh("floor.obj", FLOOR), self.mesh("p.obj", PIERCING)
        parts = self.mesh("parts.txt", "part 1 tip 1\nskip 0 1:tip\n")
        lines = self.works("--parts", parts, "--margin", "20", "--nearest", "-", floor,
                           piercing).stdout
        self.assertEqual(lines.split()[:4], ["0", "0", "1", "0"])
        self.assertGreater(float(lines.split()[4]), 9)

    def test_swept_contacts_too(self):
        floor, two = self.bodies()
        parts = self.mesh("parts.txt", "part 1 tip 0\nskip 0 1:tip\n")
        self.assertEqual(self.pairs("--swept", "--parts", parts, floor, floor, two, two),
                         "0 0 1 1\n")

    def test_a_body_with_itself(self):
        own = self.mesh("own.obj", FLOOR + TOUCHING.replace("f 1 2 3", "f 4 5 6"))
        self.assertEqual(self.pairs("--self", "--adjacent", "skip", own), "")
        crossing = self.mesh("c.obj", FLOOR + TWO.replace("f 1 2 3", "f 4 5 6").replace(
            "\nf 4 5 6\nf 4 5 6", "\nf 4 5 6\nf 7 8 9"))
        parts = self.mesh("parts.txt", "part 0 tip 2\nskip 0:tip 0:rest\n")
        self.assertEqual(self.pairs("--self", crossing), "0 0 0 1\n0 0 0 2\n")
        self.assertEqual(self.pairs("--self", "--parts", parts, crossing), "0 0 0 1\n")

    def test_a_wrong_file_is_refused_with_its_line(self):
        for text, why in (
                ("part 1 tip 2", "line 1: triangle 2 does not exist; there are 2"),
                ("part 2 tip 0", "line 1: body 2 does not exist; there are 2"),
                ("\npart 1 tip 1-0", "line 2: '1-0' ends before it begins"),
                ("part 1 tip x", "line 1: 'x' is no number of a triangle"),
                ("part 1 tip 0-", "line 1: '' is no number of a triangle"),
                ("part -1 tip 0", "line 1: '-1' is no number of a body"),
                ("part 1 tip", "line 1: part needs a body, a name and triangles"),
                ("part 1 rest 0", "line 1: 'rest' cannot be the name of a part"),
                ("part 1 a:b 0", "line 1: 'a:b' cannot be the name of a part"),
                ("part 1 a 0\npart 1 b 0-1", "line 2: triangle 0 of body 1 has another part"),
                ("skip 0:tip 1", "line 1: no line before says what '0:tip' is"),
                ("skip 0", "line 1: skip needs two bodies or parts"),
                ("skip 0 1 1", "line 1: skip needs two bodies or parts"),
                ("hem 0", "line 1: 'hem' is neither part, group nor skip")):
            parts = self.mesh("parts.txt", text)
            self.assert_refused(["--parts", parts, *self.bodies()], "parts.txt " + why)
        self.assert_refused(["--parts", self.path("none"), *self.bodies()], "cannot be opened")

    def test_groups_of_the_file(self):
        floor = self.mesh("floor.obj", FLOOR)
        two = self.mesh("groups.obj", TWO.replace("f 1 2 3", "g tip\nf 1 2 3\ng end side"))
        both, first, second = "0 0 1 0\n0 0 1 1\n", "0 0 1 0\n", "0 0 1 1\n"
        for text, wanted in (
                ("group 1 tip tip\nskip 0 1:tip\n", second),
                ("group 1 hem side\nskip 0 1:hem\n", first),
                ("group 1 all tip end\nskip 0 1:rest\n", both),
                ("group 1 all tip side\nskip 0 1:all\n", ""),
                ("part 1 tip 1\ngroup 1 tip tip\nskip 0 1:tip\n", "")):
            parts = self.mesh("parts.txt", text)
            self.assertEqual(self.pairs("--parts", parts, floor, two), wanted, text)
        for text, why in (
                ("group 1 tip hem", "groups.obj: has no group 'hem'; it has 'tip', 'end', 'side'"),
                ("group 0 tip hem", "floor.obj: has no group 'hem'; it has none"),
                ("group 1 tip", "line 1: group needs a body, a name and groups of its file"),
                ("group 1 rest tip", "line 1: 'rest' cannot be the name of a part"),
                ("part 1 a 0\ngroup 1 b tip", "line 2: triangle 0 of body 1 has another part")):
            self.assert_refused(["--parts", self.mesh("parts.txt", text), floor, two], why)

    def test_a_body_has_255_parts(self):
        count = 256
        mesh = self.mesh("many.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n" + "f 1 2 3\n" * count)
        lines = ["part 0 p%d %d" % (i, i) for i in range(count)]
        self.works("--parts", self.mesh("parts.txt", "\n".join(lines[:255])), mesh, mesh)
        self.assert_refused(["--parts", self.mesh("parts.txt", "\n".join(lines)), mesh, mesh],
                            "line 256: body 0 has 255 parts already")


if __name__ == "__main__":
    unittest.main()
