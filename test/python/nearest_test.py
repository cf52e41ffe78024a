#!/usr/bin/env python3
"""Detector(nearest=True): distances, points and normals, by hand and against brute force."""
import os
import subprocess
import tempfile
import unittest

import mesh_scenes
import numpy
from deformable_contact import Detector, Scene
from mesh_scenes import as_set

FLOOR = [[0, 0, 0], [8, 0, 0], [0, 8, 0]]
TRIANGLE = [[0, 1, 2]]


def above(height):
    """A triangle whose lowest vertex is above (1, 2)."""
    return [[1, 2, height], [1, 3, height + 2], [2, 2, height + 2]]


def scene_with(heights, margins=()):
    """The floor, and a body at each height; every two bodies are enabled."""
    scene = Scene()
    scene.add_body("floor", FLOOR, TRIANGLE)
    for height in heights:
        scene.add_body("at %g" % height, above(height), TRIANGLE)
    for a in range(scene.body_count):
        for b in range(a):
            scene.set_pair_enabled(a, b)
    for body, margin_m in enumerate(margins):
        scene.set_margin(body, margin_m)
    return scene


def nearest_by_brute_force(meshes, margin_m):
    """(body_a, body_b): (triangle_a, triangle_b, distance), by the tool."""
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for number, (vertices, triangles) in enumerate(meshes):
            files.append(os.path.join(folder, "%d.obj" % number))
            mesh_scenes.write_obj(files[-1], vertices, triangles)
        text = subprocess.run(
            [os.environ["DETECT_CONTACTS"], "--backend", "brute_force", "--margin", repr(margin_m),
             "--nearest", "-", *files], stdout=subprocess.PIPE, check=True).stdout
    rows = [line.split() for line in text.splitlines()]
    return {(int(row[0]), int(row[2])): (int(row[1]), int(row[3]), numpy.float32(row[4]))
            for row in rows}


class Nearest(unittest.TestCase):

    def test_a_pair_within_its_margin(self):
        scene = scene_with([.25, 3], margins=(.5, 0, 0))
        for options in {}, {"threads": 1}, {"geometry": True}:
            result = Detector("cpu", nearest=True, **options).detect(scene)
            pair, = result.nearest
            self.assertEqual((pair.body_a, pair.body_b), (0, 1))
            self.assertEqual(pair.names, ("floor", "at 0.25"))
            self.assertEqual(pair.triangles, (0, 0))
            self.assertEqual(pair.distance_m, .25)
            self.assertEqual(pair.point_a, (1, 2, 0))
            self.assertEqual(pair.point_b, (1, 2, .25))
            self.assertEqual(pair.normal, (0, 0, 1))
            self.assertEqual(repr(pair), "<NearestPair: floor and at 0.25, 0.250000 m>")
            self.assertEqual(len(result.pairs), 0)
            self.assertIsNone(result.separations_m)
            self.assertTrue(result.complete)

    def test_a_pair_that_touches_has_distance_zero(self):
        pair, = Detector("cpu", nearest=True).detect(scene_with([-1])).nearest
        self.assertEqual((pair.distance_m, pair.normal), (0, (0, 0, 0)))
        self.assertEqual(pair.point_a, pair.point_b)

    def test_is_none_unless_asked_for(self):
        """An empty list would say that nothing is near."""
        scene = scene_with([9])
        self.assertIsNone(Detector("cpu").detect(scene).nearest)
        self.assertEqual(Detector("cpu", nearest=True).detect(scene).nearest, [])

    def test_near_pairs_list_the_triangles_as_well(self):
        scene = scene_with([.25], margins=(.5, 0))
        result = Detector("cpu", nearest=True, near_pairs=True).detect(scene)
        self.assertEqual(as_set(result.pairs), {(0, 0, 1, 0)})
        self.assertEqual(result.separations_m.tolist(), [.25])
        self.assertEqual(result.nearest[0].distance_m, .25)

    def test_without_time_the_result_says_so(self):
        """What is listed is true all the same."""
        result = Detector("cpu", nearest=True).detect(scene_with([.25], (.5, 0)), max_time_s=0)
        self.assertEqual((result.cut_off, result.complete), (True, False))
        self.assertLessEqual({pair.distance_m for pair in result.nearest}, {.25})

    def test_results_outlive_scene_and_detector(self):
        pair = Detector("cpu", nearest=True).detect(scene_with([.25], (.5, 0))).nearest[0]
        self.assertEqual((pair.names[1], pair.point_b[2]), ("at 0.25", .25))

    def test_moving_soups_against_brute_force(self):
        rng = numpy.random.default_rng(3)
        detector = Detector("cpu", nearest=True)
        scene, meshes = Scene(), []
        for body in range(3):
            vertices, triangles = mesh_scenes.soup(rng, 30)
            meshes.append((vertices * numpy.float32(.25) + numpy.float32([body, 0, 0]), triangles))
            scene.add_body(str(body), *meshes[-1])
            scene.set_margin(body, .6)
            for other in range(body):
                scene.set_pair_enabled(other, body)
        seen = set()
        for _ in range(5):
            meshes[1] = meshes[1][0] + rng.uniform(-.1, .1, 3).astype("f4"), meshes[1][1]
            scene.set_vertices(1, meshes[1][0])
            found = {(p.body_a, p.body_b): (*p.triangles, numpy.float32(p.distance_m))
                     for p in detector.detect(scene).nearest}
            self.assertEqual(found, nearest_by_brute_force(meshes, .6))
            seen |= set(found)
        self.assertLessEqual({(0, 1), (1, 2)}, seen)


if __name__ == "__main__":
    unittest.main()
