#!/usr/bin/env python3
"""Scene.set_parts() and set_part_pair_enabled(), by hand."""
import unittest

import numpy
from deformable_contact import Detector, Scene
from mesh_scenes import as_set

FLOOR = [[0, 0, 0], [8, 0, 0], [0, 8, 0]]
# Two triangles that pierce the floor, side by side.
TWO = [[1, 1, -1], [1, 1, 1], [1, 2, 1], [2, 1, -1], [2, 1, 1], [2, 2, 1]]


class Parts(unittest.TestCase):

    def setUp(self):
        self.scene = Scene()
        self.floor = self.scene.add_body("floor", FLOOR, [[0, 1, 2]])
        self.two = self.scene.add_body("two", TWO, [[0, 1, 2], [3, 4, 5]])
        self.scene.set_pair_enabled(self.floor, self.two)
        self.detector = Detector("cpu")

    def found(self):
        return as_set(self.detector.detect(self.scene).pairs)

    def test_a_disabled_part_is_left_out(self):
        first, second = (0, 0, 1, 0), (0, 0, 1, 1)
        self.assertEqual(self.found(), {first, second})
        self.scene.set_parts(self.two, numpy.array([7, 0], numpy.uint8))
        self.assertEqual(self.found(), {first, second})
        self.scene.set_part_pair_enabled(self.two, 7, self.floor, 0, False)
        self.assertEqual(self.found(), {second})
        self.scene.set_parts(self.two, [0, 7])
        self.assertEqual(self.found(), {first})
        self.scene.set_part_pair_enabled(self.two, 7, self.floor, 0)
        self.assertEqual(self.found(), {first, second})
        self.scene.set_part_pair_enabled(self.floor, 0, self.two, 0, enabled=False)
        self.assertEqual(self.found(), {second})
        self.scene.set_parts(self.two, None)
        self.assertEqual(self.found(), set())

    def test_rejected_triangles_are_counted_by_part(self):
        self.scene.set_parts(self.two, [7, 3])
        vertices = numpy.array(TWO, numpy.float32)
        vertices[0, 0] = float("nan")
        self.scene.set_vertices(self.two, vertices)
        self.assertEqual(self.detector.detect(self.scene).rejected_parts, {(self.two, 7): 1})
        self.scene.set_parts(self.two, None)
        self.assertEqual(self.detector.detect(self.scene).rejected_parts, {(self.two, 0): 1})
        for detector in Detector("cpu", nearest=True), Detector("cpu", tolerance_m=.01):
            self.assertEqual(detector.detect(self.scene).rejected_parts, {(self.two, 0): 1})
        self.scene.set_vertices(self.two, TWO)
        self.assertEqual(self.detector.detect(self.scene).rejected_parts, {})

    def test_nearest_triangles_by_part(self):
        high = numpy.array(TWO, numpy.float32)
        high[:, 2] += 1.25
        high[3:, 2] += 0.5
        self.scene.set_vertices(self.two, high)
        self.scene.set_margin(self.two, 2)
        self.scene.set_parts(self.two, [7, 3])
        result = Detector("cpu", nearest=True, nearest_by_part=True).detect(self.scene)
        self.assertEqual(list(result.nearest_parts), [(0, 0, 1, 3), (0, 0, 1, 7)])
        of_7, of_3 = result.nearest_parts[0, 0, 1, 7], result.nearest_parts[0, 0, 1, 3]
        self.assertEqual((of_7.distance_m, of_7.triangles), (0.25, (0, 0)))
        self.assertEqual((of_3.distance_m, of_3.triangles), (0.75, (0, 1)))
        self.assertEqual(of_3.names, ("floor", "two"))
        self.assertEqual([pair.distance_m for pair in result.nearest], [0.25])
        self.scene.set_part_pair_enabled(self.two, 7, self.floor, 0, False)
        result = Detector("cpu", nearest=True, nearest_by_part=True).detect(self.scene)
        self.assertEqual(list(result.nearest_parts), [(0, 0, 1, 3)])
        self.assertIsNone(Detector("cpu", nearest=True).detect(self.scene).nearest_parts)
        with self.assertRaisesRegex(ValueError, "nearest_by_part is true, which needs nearest"):
            Detector("cpu", nearest_by_part=True)

    def test_parts_have_margins(self):
        high = numpy.array(TWO, numpy.float32)
        high[:, 2] += 1.25
        self.scene.set_vertices(self.two, high)
        self.scene.set_parts(self.two, [7, 3])
        detector = Detector("cpu", near_pairs=True)
        self.assertEqual(len(detector.detect(self.scene).pairs), 0)
        self.scene.set_part_margins(self.two, {3: 0.5})
        self.assertEqual(as_set(detector.detect(self.scene).pairs), {(0, 0, 1, 1)})
        self.scene.set_margin(self.two, 1)
        self.scene.set_part_margins(self.two, {3: 0.125})
        self.assertEqual(as_set(detector.detect(self.scene).pairs), {(0, 0, 1, 0)})
        with self.assertRaisesRegex(ValueError, "two: its parts have margins of their own"):
            Detector("cpu", tolerance_m=0.1).detect(self.scene)
        for margins_m, why in (({300: 1}, "part 300 is not in"), ({3: -1}, "two: the margin of part 3"),
                               ({3: float("nan")}, "two: the margin of part 3")):
            with self.assertRaisesRegex(ValueError, why):
                self.scene.set_part_margins(self.two, margins_m)

    def test_wrong_parts_are_refused(self):
        for parts, why in (([1], "two: parts are given for 1 triangles, but its mesh has 2"),
                           (numpy.array([], int), "two: parts has none"),
                           ([1, 256], r"part 256 is not in \[0, 255\]"),
                           ([-1, 0], r"part -1 is not in"),
                           ([1.0, 2.0], "two: parts must be integers"),
                           ([[1, 2]], "two: parts must be integers of shape"),
                           ("ab", "two: parts must be integers")):
            with self.assertRaisesRegex(ValueError, why):
                self.scene.set_parts(self.two, parts)
        with self.assertRaisesRegex(ValueError, "body 5 does not exist"):
            self.scene.set_parts(5, [1, 2])
        with self.assertRaisesRegex(ValueError, "part 300"):
            self.scene.set_part_pair_enabled(0, 300, 1, 0)
        with self.assertRaisesRegex(ValueError, "body -1"):
            self.scene.set_part_pair_enabled(-1, 0, 1, 0)
        self.assertEqual(len(self.found()), 2)


if __name__ == "__main__":
    unittest.main()
