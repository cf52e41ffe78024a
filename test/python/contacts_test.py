#!/usr/bin/env python3
"""The contacts that the Python package finds, as sets, against the oracle and brute force."""
import time
import unittest

import deformable_contact
import deformable_contact.messages
import mesh_scenes
import numpy
from deformable_contact import Detector, Scene
from mesh_scenes import as_set

FUNNEL = mesh_scenes.DATA / "cloth-funnel/227.ply"


def scene_of(meshes, enabled):
    scene = Scene()
    for number, (vertices, triangles) in enumerate(meshes):
        scene.add_body("body%d" % number, vertices, triangles)
    for a, b in enabled:
        scene.set_pair_enabled(a, b)
    return scene


def all_pairs(count):
    return [(a, b) for a in range(count) for b in range(a, count)]


def crossing_walls(count):
    """Two bodies of `count` triangles each; each of one meets each of the other."""
    at = numpy.arange(count, dtype=numpy.float32) / count
    one, zero = numpy.ones(count, numpy.float32), numpy.zeros(count, numpy.float32)
    a = numpy.stack([at, -3 * one, zero, at, 3 * one, -3 * one, at, 3 * one, 3 * one], axis=1)
    b = numpy.stack([-3 * one, at, zero, 3 * one, at, -3 * one, 3 * one, at, 3 * one], axis=1)
    triangles = numpy.arange(3 * count, dtype=numpy.uint32).reshape(-1, 3)
    return [(a.reshape(-1, 3), triangles), (b.reshape(-1, 3), triangles)]


def sheet(height, quads=20):
    """A square of 1 m."""
    at = numpy.arange(quads + 1) / quads
    x, y = numpy.meshgrid(at, at)
    vertices = numpy.stack([x.ravel(), y.ravel(), numpy.full(x.size, height)], axis=1)
    corner = (numpy.arange(quads)[:, None] * (quads + 1) + numpy.arange(quads)).ravel()
    above = corner + quads + 1
    triangles = numpy.concatenate([numpy.stack([corner, corner + 1, above], axis=1),
                                   numpy.stack([above, corner + 1, above + 1], axis=1)])
    return vertices.astype(numpy.float32), triangles.astype(numpy.uint32)


class Radius(unittest.TestCase):

    def test_a_rope_above_a_sheet(self):
        points = numpy.array([[0, 0, .05], [.3, 0, .05], [.6, 0, .05]], numpy.float32)
        rope = points, numpy.array([[0, 1, 1], [1, 2, 2]], numpy.uint32)
        scene = scene_of([sheet(0), rope], [(0, 1)])
        detector = Detector("cpu", nearest=True)
        scene.set_margin(0, .1)
        for radius_m in 0, .02, .051:
            scene.set_radius(1, radius_m)
            result = detector.detect(scene)
            nearest, = result.nearest
            self.assertEqual(len(result.pairs) > 0, radius_m > .05)
            self.assertAlmostEqual(nearest.distance_m, max(0, .05 - radius_m), places=6)
        with self.assertRaisesRegex(ValueError, "it has a radius"):
            Detector("cpu", tolerance_m=.01).detect(scene)


class Tolerance(unittest.TestCase):

    def detect(self, lower, upper, margins=(0, .02)):
        """Two sheets, by a tolerance of 5 mm."""
        scene = scene_of([lower, upper], [(0, 1)])
        for body, margin_m in enumerate(margins):
            scene.set_margin(body, margin_m)
        result = Detector("cpu", tolerance_m=.005).detect(scene)
        self.assertEqual(len(result.distances), 1)
        self.assertFalse(result.guaranteed)
        return result

    def test_states(self):
        cases = ((0, "contact"), (.004, "contact"), (.012, "near"), (.03, "none"))
        for margins in ((0, .02), (.02, .001)):
            for height, state in cases:
                result = self.detect(sheet(0), sheet(height), margins)
                distance, = result.distances
                self.assertEqual((distance.body_a, distance.body_b), (0, 1))
                self.assertEqual(distance.state, state)
                self.assertLessEqual(distance.low_m, height)
                self.assertGreaterEqual(distance.high_m, numpy.float32(height) - 1e-7)
                if state != "none":
                    self.assertLessEqual(distance.high_m, height + .005)
                self.assertEqual(distance.is_listed, state == "none")
                self.assertEqual(distance.contact_count, len(result.pairs))
                if height == 0:
                    self.assertGreater(distance.contact_count, 0)
            self.assertGreater(distance.low_m, .02)

    def test_points_are_of_the_triangles(self):
        lower, upper = sheet(0), sheet(.004, quads=7)
        distance, = self.detect(lower, upper).distances
        self.assertAlmostEqual(distance.point_a[2], 0)
        self.assertAlmostEqual(distance.point_b[2], .004)
        self.assertEqual(distance.point_a[:2], distance.point_b[:2])
        for (vertices, triangles), point, triangle in zip(
                (lower, upper), (distance.point_a, distance.point_b), distance.triangles):
            corners = vertices[triangles[triangle]]
            self.assertTrue((corners.min(axis=0) - 1e-6 <= point).all(), (corners, point))
            self.assertTrue((point <= corners.max(axis=0) + 1e-6).all(), (corners, point))

    def test_bounds_are_two(self):
        """Waves 3 mm over waves, whose boxes overlap: only what is seen is known."""
        (lower, triangles), (upper, _) = sheet(0), sheet(.003)
        for vertices in (lower, upper):
            vertices[:, 2] += .1 * numpy.sin(9 * vertices[:, 0] + 4 * vertices[:, 1])
        distance, = self.detect((lower, triangles), (upper, triangles), (0, 0)).distances
        self.assertEqual(distance.state, "contact")
        self.assertTrue(.001 < distance.high_m <= .005, distance.high_m)
        self.assertTrue(0 <= distance.low_m <= .003, distance.low_m)

    def test_bodies_with_rejected_triangles_are_unknown_unless_they_touch(self):
        for height, state in (0, "contact"), (.012, "unknown"), (.03, "unknown"):
            vertices, triangles = sheet(height)
            vertices = numpy.array(vertices, numpy.float32)
            vertices[0] = numpy.nan
            result = self.detect(sheet(0), (vertices, triangles))
            distance, = result.distances
            self.assertEqual((distance.state, distance.low_m), (state, 0))
            self.assertFalse(distance.is_listed)
            self.assertGreater(result.counters["rejected"], 0)
            self.assertEqual(result.rejected_parts, {(1, 0): result.counters["rejected"]})
            vertices[:] = numpy.nan
            distance, = self.detect(sheet(0), (vertices, triangles)).distances
            self.assertEqual((distance.state, distance.low_m), ("unknown", 0))

    def test_those_of_several_pairs_ascend(self):
        scene = scene_of([sheet(0), sheet(.5), sheet(.501)], [(1, 2), (0, 1), (0, 2)])
        detector = Detector("cpu", tolerance_m=.005)
        distances = detector.detect(scene).distances
        self.assertEqual([(d.body_a, d.body_b) for d in distances], [(0, 1), (0, 2), (1, 2)])
        for distance, height in zip(distances, (.5, .501, .001)):
            self.assertLessEqual(distance.low_m, height)
            self.assertGreaterEqual(distance.high_m, height - 1e-7)

    def test_are_there_in_every_call(self):
        """Also of bodies that come later, of new topologies, and of another scene."""
        detector = Detector("cpu", tolerance_m=.005)
        for quads in (3, 5, 7):
            scene = scene_of([sheet(0), sheet(.02, quads=quads)], [(0, 1), (1, 1)])
            self.assertEqual(len(detector.detect(scene).distances), 1)
            scene.set_mesh(1, *sheet(.02, quads=quads + 1))
            self.assertEqual(len(detector.detect(scene).distances), 1)
            body = scene.add_body("later", *sheet(.04))
            scene.set_pair_enabled(0, body)
            for _ in range(3):
                self.assertEqual(len(detector.detect(scene).distances), 2)

    def test_a_limit_of_time_waits_for_no_groups(self):
        scene = scene_of([sheet(0), sheet(.02)], [(0, 1)])
        detector = Detector("cpu", tolerance_m=.005)
        self.assertEqual(detector.detect(scene, max_time_s=10).distances, [])
        for _ in range(1000):
            if detector.detect(scene, max_time_s=10).distances:
                break
            time.sleep(.01)
        self.assertEqual(len(detector.detect(scene, max_time_s=10).distances), 1)

    def test_exact_detection_has_none(self):
        scene = scene_of([sheet(0), sheet(0)], [(0, 1)])
        self.assertEqual(Detector("cpu").detect(scene).distances, [])


class Geometry(unittest.TestCase):

    def test_each_contact_has_its_own(self):
        """Of a blade through a floor, one that touches it, one that is near."""
        floor = numpy.float32([[0, 0, 0], [8, 0, 0], [0, 8, 0]])
        blade = numpy.float32([[1, 1, 0], [1, .5, 2.5], [1, 1.5, 2.5]])
        blades = numpy.concatenate([blade + numpy.float32([x, 0, z])
                                    for x, z in ((0, -.5), (1, 0), (2, .25))])
        triangle = numpy.uint32([[0, 1, 2]])
        scene = scene_of([(floor, triangle), (blades, numpy.arange(9).reshape(-1, 3))], [(0, 1)])
        scene.set_margin(1, .5)
        result = Detector(geometry=True).detect(scene)
        self.assertEqual(as_set(result.pairs), {(0, 0, 1, 0), (0, 0, 1, 1), (0, 0, 1, 2)})
        geometry = result.geometry
        self.assertEqual(geometry.dtype, deformable_contact.messages.GEOMETRY)
        self.assertEqual(geometry.shape, (3,))
        numpy.testing.assert_array_equal(geometry["separation"], [-.5, 0, .25])
        numpy.testing.assert_array_equal(geometry["normal"], [[0, 0, 1]] * 3)
        numpy.testing.assert_array_equal(geometry["flags"], [0, 0, 0])
        numpy.testing.assert_array_equal(geometry["point_a"][1:], [[2, 1, 0], [3, 1, 0]])
        numpy.testing.assert_array_equal(geometry["point_b"][1:], [[2, 1, 0], [3, 1, .25]])
        self.assertEqual({geometry["point_a"][0][0], geometry["point_b"][0][0]}, {1})
        self.assertTrue(geometry.flags.owndata)

    def test_is_there_if_asked_for(self):
        scene = scene_of(crossing_walls(30), all_pairs(2))
        self.assertIsNone(Detector().detect(scene).geometry)
        result = Detector(geometry=True).detect(scene)
        self.assertEqual(len(result.geometry), len(result.pairs))
        self.assertTrue((result.geometry["separation"] <= 0).all())
        empty = scene_of(crossing_walls(3), [])
        self.assertEqual(Detector(geometry=True).detect(empty).geometry.shape, (0,))


class AgainstTheOracle(unittest.TestCase):

    def test_random_scenes_with_poses(self):
        for seed in range(12):
            rng = numpy.random.default_rng(seed)
            meshes = [mesh_scenes.soup(rng, 30, on_grid=seed % 2) for _ in range(3)]
            poses = [mesh_scenes.random_pose(rng) if rng.integers(2) else mesh_scenes.IDENTITY
                     for _ in meshes]
            enabled = [pair for pair in all_pairs(3) if rng.integers(4)]
            adjacent = ("beyond_shared", "skip")[seed // 2 % 2]
            scene = scene_of(meshes, enabled)
            for body, (rotation, translation) in enumerate(poses):
                scene.set_pose(body, rotation, translation)
            self.assertEqual(scene.enabled_pairs(), enabled)

            result = Detector(adjacent_pairs=adjacent).detect(scene)
            moved = [(mesh_scenes.posed(vertices, pose), triangles)
                     for (vertices, triangles), pose in zip(meshes, poses)]
            expected = {pair for pair in mesh_scenes.oracle_pairs(moved, adjacent)
                        if (pair[0], pair[2]) in enabled}
            self.assertEqual(as_set(result.pairs), expected, seed)
            self.assertGreater(len(expected), 20)
            self.assertTrue(result.complete)
            self.assertIsNone(result.separations_m)

    def test_margins(self):
        for seed, margin_m in enumerate((0.125, 0.5)):
            rng = numpy.random.default_rng(seed)
            meshes = [mesh_scenes.soup(rng, 20) for _ in range(2)]
            scene = scene_of(meshes, all_pairs(2))
            detector = Detector()
            touching = as_set(detector.detect(scene).pairs)
            scene.set_margin(0, margin_m)
            scene.set_margin(1, margin_m)
            result = detector.detect(scene)
            expected = mesh_scenes.brute_force_pairs(meshes, margin_m)
            self.assertEqual(as_set(result.pairs), expected)
            self.assertLess(touching, expected)
            self.assertEqual(result.separations_m.dtype, numpy.float32)
            self.assertTrue(((0 <= result.separations_m)
                             & (result.separations_m <= margin_m)).all())
            self.assertEqual(as_set(result.pairs[result.separations_m == 0]), touching)

    def test_margins_without_a_contact(self):
        scene = scene_of([([[0, 0, 0], [1, 0, 0], [0, 1, 0]], [[0, 1, 2]]),
                          ([[0, 0, 9], [1, 0, 9], [0, 1, 9]], [[0, 1, 2]])], [(0, 1)])
        scene.set_margin(0, 0.5)
        result = Detector().detect(scene)
        self.assertEqual(result.pairs.shape, (0, 4))
        self.assertEqual(result.separations_m.shape, (0,))

    def test_moving_vertices(self):
        rng = numpy.random.default_rng(5)
        meshes = [mesh_scenes.soup(rng, 40) for _ in range(2)]
        scene = scene_of(meshes, all_pairs(2))
        detector = Detector()
        for _ in range(3):
            detector.detect(scene)
            vertices = rng.uniform(0, 3, meshes[0][0].shape).astype(numpy.float32)
            scene.set_vertices(0, vertices)
            meshes[0] = vertices, meshes[0][1]
            self.assertEqual(as_set(detector.detect(scene).pairs),
                             mesh_scenes.brute_force_pairs(meshes))
        meshes[1] = mesh_scenes.soup(rng, 25)
        scene.set_mesh(1, *meshes[1])
        self.assertEqual(scene.triangle_count, 65)
        self.assertEqual(as_set(detector.detect(scene).pairs),
                         mesh_scenes.brute_force_pairs(meshes))

    @unittest.skipUnless(FUNNEL.exists(), "no %s" % FUNNEL)
    def test_a_real_mesh(self):
        vertices, triangles = deformable_contact.read_mesh(FUNNEL)
        self.assertEqual((vertices.dtype, triangles.dtype), (numpy.float32, numpy.uint32))
        scene = scene_of([(vertices, triangles)], [(0, 0)])
        for adjacent, count in ("beyond_shared", 309), ("skip", 261):
            result = Detector(adjacent_pairs=adjacent).detect(scene)
            self.assertEqual(as_set(result.pairs),
                             mesh_scenes.oracle_pairs_of_file(FUNNEL, adjacent))
            self.assertEqual(len(result.pairs), count)


class WhatAResultSays(unittest.TestCase):

    def setUp(self):
        rng = numpy.random.default_rng(1)
        self.meshes = [mesh_scenes.soup(rng, 50) for _ in range(2)]
        self.scene = scene_of(self.meshes, all_pairs(2))
        self.expected = as_set(Detector().detect(self.scene).pairs)

    def test_options_that_cost_time_alone_do_not_change_pairs(self):
        for options in ({"clusters": 7}, {"fuzzifier": 1.5}, {"iterations": 0}, {"threads": 1},
                        {"refresh_period": 3}, {"backend": "cpu"}, {"memory_limit_mib": 64}):
            detector = Detector(**options)
            for _ in range(3):
                result = detector.detect(self.scene)
                self.assertEqual(as_set(result.pairs), self.expected, options)
            detector.reset()
            self.assertEqual(as_set(detector.detect(self.scene).pairs), self.expected)
        self.assertEqual(detector.detect(self.scene).counters["clusters"] > 0, True)
        self.assertEqual(Detector("cpu", clusters=7).detect(self.scene).counters["clusters"], 7)

    def test_what_may_err_says_so(self):
        result = Detector(overlap=0.5).detect(self.scene)
        self.assertEqual((result.guaranteed, result.complete), (False, False))
        result = Detector(predicates="conservative").detect(self.scene)
        self.assertTrue(result.guaranteed)
        self.assertLessEqual(self.expected, as_set(result.pairs))

    def test_triangles_that_are_not_finite_are_counted(self):
        vertices, triangles = self.meshes[0]
        vertices = vertices.copy()
        vertices[triangles[3, 1], 2] = numpy.nan
        self.scene.set_vertices(0, vertices)
        result = Detector().detect(self.scene)
        hit = int((triangles == triangles[3, 1]).any(axis=1).sum())
        self.assertEqual(result.counters["rejected"], hit)
        self.assertTrue(result.guaranteed)
        self.assertFalse(result.complete)

    def test_no_time(self):
        result = Detector().detect(self.scene, max_time_s=0)
        self.assertEqual((result.cut_off, result.cut_off_because), (True, "no time"))
        self.assertFalse(result.complete)
        for enough in 1e3, 1e300, float("inf"), None:
            result = Detector().detect(self.scene, max_time_s=enough)
            self.assertEqual((result.cut_off, result.cut_off_because), (False, ""))
            self.assertEqual(as_set(result.pairs), self.expected)

    def test_little_memory(self):
        scene = scene_of(crossing_walls(300), [(0, 1)])
        whole = Detector("cpu").detect(scene)
        self.assertEqual((len(whole.pairs), whole.left_out), (90000, 0))
        part = Detector("cpu", memory_limit_mib=1).detect(scene)
        self.assertGreater(part.left_out, 0)
        self.assertEqual(len(part.pairs) + part.left_out, 90000)
        self.assertFalse(part.complete)
        self.assertLess(as_set(part.pairs), as_set(whole.pairs))

    def test_times_and_counters(self):
        result = Detector("cpu").detect(self.scene)
        self.assertEqual(result.backend, "cpu")
        self.assertEqual(result.counters["triangles"], 100)
        self.assertEqual(list(result.stages_ms), ["transform", "cluster", "assign", "sort", "sweep",
                                                  "oversized", "narrow_phase", "output"])
        self.assertGreater(result.detect_ms, 0)
        self.assertGreaterEqual(result.round_trip_ms, result.detect_ms)
        self.assertTrue(result.started_cold)
        self.assertEqual(repr(result), "<Result: %d contacts, complete>" % len(self.expected))


if __name__ == "__main__":
    unittest.main()
