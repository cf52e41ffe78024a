#!/usr/bin/env python3
"""Contacts between two states, from the Python package: sets and times, and what is refused."""
import unittest

import mesh_scenes
import numpy
from deformable_contact import Detector, Scene
from mesh_scenes import IDENTITY, as_set

FLOOR = numpy.float32([[0, 0, 0], [4, 0, 0], [0, 4, 0]])
BEFORE = numpy.float32([[1, 1, 1], [1, 2, 3], [2, 1, 3]])  # above the floor
BEHIND = BEFORE - numpy.float32([0, 0, 4])  # through it: the tip is in its plane at a quarter
TRIANGLE = numpy.uint32([[0, 1, 2]])


def falling():
    scene = Scene()
    scene.add_body("floor", FLOOR, TRIANGLE)
    scene.add_body("falling", BEHIND, TRIANGLE)
    scene.set_pair_enabled(0, 1)
    scene.set_earlier(0)
    scene.set_earlier(1, BEFORE)
    return scene


class BetweenTwoStates(unittest.TestCase):

    def test_what_goes_through_is_a_contact(self):
        scene = falling()
        self.assertEqual(len(Detector().detect(scene).pairs), 0)
        result = Detector(motion="swept", first_times=True).detect(scene)
        self.assertEqual(result.pairs.tolist(), [[0, 0, 1, 0]])
        self.assertTrue(result.complete)
        self.assertEqual((result.first_times.dtype, result.first_times.shape),
                         (numpy.float32, (1, 2)))
        low, high = result.first_times[0].tolist()
        self.assertTrue(low <= 0.25 <= high <= low + 2**-20, (low, high))
        self.assertEqual((result.within_pad, result.without_step), (None, []))
        self.assertIsNone(Detector(motion="swept").detect(scene).first_times)

    def test_a_body_without_an_earlier_state_stands_still(self):
        scene = falling()
        detector = Detector(motion="swept", first_times=True)
        scene.clear_earlier(1)
        result = detector.detect(scene)
        self.assertEqual((result.pairs.shape, result.first_times.shape), ((0, 4), (0, 2)))
        self.assertEqual(result.without_step, [1])
        scene.set_earlier(1, BEFORE)
        self.assertEqual(len(detector.detect(scene).pairs), 1)
        scene.set_mesh(1, BEHIND, TRIANGLE)
        self.assertEqual(detector.detect(scene).without_step, [1])

    def test_rigid_bodies_and_poses(self):
        """Where only a part is given, the rest is as it is."""
        scene = falling()
        scene.set_vertices(1, BEFORE)
        rotation = numpy.eye(3)
        scene.set_pose(1, rotation, [0, 0, -4])
        scene.set_earlier(1, rotation=rotation, translation=[0, 0, 0])
        detector = Detector(motion="swept", first_times=True)
        low, high = detector.detect(scene).first_times[0]
        self.assertTrue(low <= 0.25 <= high)
        # The pose stays, the vertices were four higher.
        scene.set_earlier(1, BEFORE + numpy.float32([0, 0, 4]))
        self.assertEqual(detector.detect(scene).first_times[0].tolist(), [low, high])

    def test_pads(self):
        scene = falling()
        scene.set_vertices(1, BEFORE)
        scene.set_earlier(1, BEFORE)  # one above the floor all the time
        detector = Detector(motion="swept", first_times=True)
        for pad_m, pairs in (0.5, 0), (1.5, 1):
            scene.set_pad(1, pad_m)
            result = detector.detect(scene)
            self.assertEqual(len(result.pairs), pairs)
            self.assertEqual(result.within_pad.dtype, bool)
            self.assertEqual(result.within_pad.tolist(), [True] * pairs)
        self.assertEqual(result.first_times[0, 1], 1)
        scene.set_earlier(1, BEHIND)
        self.assertEqual(detector.detect(scene).within_pad.tolist(), [False])
        scene.set_pad(1, 0)
        self.assertIsNone(detector.detect(scene).within_pad)

    def test_margins_play_no_part(self):
        scene = falling()
        scene.set_margin(1, 5)
        result = Detector(motion="swept").detect(scene)
        self.assertEqual(len(result.pairs), 1)
        self.assertIsNone(result.separations_m)

    def test_random_scenes_with_poses(self):
        """Sets and times of brute force."""
        for seed in range(6):
            rng = numpy.random.default_rng(seed)
            scene, meshes = Scene(), []
            for body in range(2):
                earlier, triangles = mesh_scenes.soup(rng, 25, on_grid=seed % 2)
                later = earlier + rng.integers(-2, 3, earlier.shape).astype(numpy.float32)
                poses = [mesh_scenes.random_pose(rng) if rng.integers(2) else IDENTITY
                         for _ in range(2)]
                scene.add_body("body%d" % body, later, triangles)
                scene.set_earlier(body, earlier, *poses[0])
                scene.set_pose(body, *poses[1])
                meshes.append((mesh_scenes.posed(earlier, poses[0]),
                               mesh_scenes.posed(later, poses[1]), triangles))
            for a, b in (0, 0), (0, 1), (1, 1):
                scene.set_pair_enabled(a, b)
            result = Detector(motion="swept", first_times=True).detect(scene)
            expected = mesh_scenes.swept_pairs(meshes)
            self.assertEqual(as_set(result.pairs), set(expected), seed)
            self.assertGreater(len(expected), 20)
            for pair, times in zip(result.pairs.tolist(), result.first_times.tolist()):
                self.assertEqual(tuple(times), expected[tuple(pair)], (seed, pair))


class Refusals(unittest.TestCase):

    def assert_refused(self, words, call, *arguments, **named):
        with self.assertRaisesRegex(ValueError, words):
            call(*arguments, **named)

    def test_options(self):
        self.assert_refused("motion 'fast' is none of instant, swept", Detector, motion="fast")
        self.assert_refused("first_times is of a step", Detector, first_times=True)
        self.assert_refused("geometry is of one moment", Detector, motion="swept", geometry=True)

    def test_earlier_states(self):
        scene = falling()
        set_earlier = scene.set_earlier
        self.assert_refused("body 7 does not exist", set_earlier, 7)
        self.assert_refused("body 7 does not exist", scene.clear_earlier, 7)
        self.assert_refused("body 7 does not exist", scene.set_pad, 7, 0)
        self.assert_refused("falling: vertices has shape", set_earlier, 1, [1, 2, 3])
        self.assert_refused("falling.*vertices", set_earlier, 1, BEFORE[:2])
        self.assert_refused("falling.*vertices", set_earlier, 1, numpy.empty((0, 3)))
        self.assert_refused("falling: rotation and translation", set_earlier, 1,
                            rotation=numpy.eye(3))
        self.assert_refused("falling: rotation and translation", set_earlier, 1,
                            translation=[0, 0, 0])
        self.assert_refused("falling", set_earlier, 1, rotation=numpy.eye(3),
                            translation=[0, 0, numpy.nan])
        for pad_m in -1, float("nan"), float("inf"):
            self.assert_refused("falling", scene.set_pad, 1, pad_m)
        self.assertEqual(len(Detector(motion="swept").detect(scene).pairs), 1, "as it was")


if __name__ == "__main__":
    unittest.main()
