#!/usr/bin/env python3
"""StateChecker: states by hand, against detections of their own, and a planned path."""
import importlib.util
import os
import pathlib
import unittest
import warnings

import deformable_contact
import mesh_scenes
import numpy
from deformable_contact import Detector, Scene, StateChecker

EXAMPLES = pathlib.Path(os.environ["DCM_SOURCE_DIR"]) / "src/python/examples"
FLOOR = [[0, 0, 0], [8, 0, 0], [0, 8, 0]]
TRIANGLE = [[0, 1, 2]]


def at(x, y, z):
    pose = numpy.eye(4)
    pose[:3, 3] = x, y, z
    return pose


def as_matrix(rotation, translation):
    pose = numpy.eye(4)
    pose[:3, :3], pose[:3, 3] = rotation, translation
    return pose


class States(unittest.TestCase):

    def setUp(self):
        self.scene = Scene()
        self.floor = self.scene.add_body("floor", FLOOR, TRIANGLE)
        self.one = self.scene.add_body("one", [[1, 2, 0], [1, 3, 2], [2, 2, 2]], TRIANGLE)
        self.two = self.scene.add_body("two", [[2, 2, 0], [2, 3, 2], [3, 2, 2]], TRIANGLE)
        for body in self.one, self.two:
            self.scene.set_pair_enabled(self.floor, body)
        self.checker = StateChecker("cpu")

    def test_free_because_nothing_is_looked_at_is_warned_of(self):
        other = self.scene.add_body("other", [[1, 2, 0], [1, 3, 2], [2, 2, 2]], TRIANGLE)
        with self.assertWarnsRegex(RuntimeWarning, "no pair with one of the bodies that move"):
            self.checker.check(self.scene, [other], [[at(0, 0, 0)]])
        self.scene.set_pair_enabled(other, self.floor)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            states = self.checker.check(self.scene, [other], [[at(0, 0, 0)]])
        self.assertEqual(states.free.tolist(), [False])

    def test_states_by_hand(self):
        self.scene.set_margin(self.floor, 1)
        poses = [[at(0, 0, .25), at(0, 0, 5)], [at(0, 0, 0), at(0, 0, -1)], [at(0, 0, 5)] * 2]
        states = self.checker.check(self.scene, [self.one, self.two], poses, pairs=True,
                                    nearest=True)
        self.assertEqual(len(states), 3)
        self.assertEqual(states.touches.tolist(), [False, True, False])
        self.assertEqual(states.free.tolist(), [True, False, True])
        self.assertFalse(states.unknown.any())
        self.assertEqual(states.distances.tolist(), [.25, 0, numpy.inf])
        self.assertEqual(states.distances.dtype, numpy.float32)
        self.assertEqual(states.nearest_pairs.tolist(),
                         [[self.floor, 0, self.one, 0], [self.floor, 0, self.one, 0], [0] * 4])
        self.assertEqual(states.points[0].tolist(), [[1, 2, 0], [1, 2, .25]])
        self.assertEqual(states.normals.tolist(), [[0, 0, 1], [0, 0, 0], [0, 0, 0]])
        self.assertEqual(states.pairs.tolist(),
                         [[1, self.floor, self.one], [1, self.floor, self.two]])
        self.assertEqual((states.cut_off, states.cut_off_because, states.backend),
                         (False, "", "cpu"))
        self.assertGreater(states.check_ms, 0)

    def test_what_was_not_asked_for_is_none(self):
        states = self.checker.check(self.scene, [self.one], [[at(0, 0, 5)]])
        self.assertEqual(states.free.tolist(), [True])
        for value in (states.distances, states.nearest_pairs, states.points, states.normals,
                      states.pairs):
            self.assertIsNone(value)

    def test_unknown_is_never_free(self):
        poses = numpy.tile(at(0, 0, 5), (4, 1, 1, 1))
        poses[1, 0, 0, 3] = numpy.nan
        poses[2] = numpy.nan
        poses[3, 0, 2, 3] = 1e39
        states = self.checker.check(self.scene, [self.one], poses, nearest=True)
        self.assertEqual(states.unknown.tolist(), [False, True, True, True])
        self.assertEqual(states.free.tolist(), [True, False, False, False])
        self.assertTrue(numpy.isnan(states.distances[1:]).all())
        states = self.checker.check(self.scene, [self.one], poses, max_time_s=0)
        self.assertEqual((states.cut_off, states.cut_off_because), (True, "no time"))
        self.assertTrue(states.unknown.all() and not states.free.any())
        vertices = numpy.array(FLOOR, numpy.float32)
        vertices[0] = numpy.nan
        self.scene.set_vertices(self.floor, vertices)
        states = self.checker.check(self.scene, [self.one], poses[:1])
        self.assertEqual(states.rejected_parts, {(self.floor, 0): 1})
        self.assertEqual((states.free.any(), states.unknown.all()), (False, True))

    def test_beside_a_hole_only_contacts_are_known(self):
        """The second body is NaN at one vertex, and looked at only where it moves."""
        vertices = numpy.array([[1, 2, 0], [1, 3, 2], [2, 2, 2], [numpy.nan] * 3], numpy.float32)
        scene = Scene()
        floor = scene.add_body("floor", FLOOR, TRIANGLE)
        hole = scene.add_body("hole", vertices, [[0, 1, 2], [0, 1, 3]])
        whole = scene.add_body("whole", vertices[:3], TRIANGLE)
        for body in hole, whole:
            scene.set_pair_enabled(floor, body)
            scene.set_margin(body, 9)
        poses = [[at(0, 0, 0)], [at(0, 0, 5)]]
        states = self.checker.check(scene, [hole], poses, nearest=True)
        self.assertEqual(states.touches.tolist(), [True, False])
        self.assertEqual(states.unknown.tolist(), [False, True])
        self.assertEqual(states.free.tolist(), [False, False])
        self.assertEqual(states.distances[0], 0)
        self.assertTrue(numpy.isnan(states.distances[1]))
        self.assertEqual(states.nearest_pairs[1].tolist(), [0] * 4)
        self.assertEqual(states.points[1].tolist(), [[0, 0, 0]] * 2)
        self.assertEqual(states.rejected_parts, {(hole, 0): 1})
        states = self.checker.check(scene, [whole], poses)
        self.assertEqual(states.free.tolist(), [False, True])
        self.assertEqual(states.rejected_parts, {})

    def test_states_equal_detections(self):
        rng = numpy.random.default_rng(5)
        scene, meshes = Scene(), [mesh_scenes.soup(rng, 40) for _ in range(3)]
        for number, (vertices, triangles) in enumerate(meshes):
            scene.add_body(str(number), vertices, triangles)
            scene.set_margin(number, .3)
        scene.set_pair_enabled(0, 1)
        scene.set_pair_enabled(0, 2)
        poses = [[mesh_scenes.random_pose(rng) for _ in range(2)] for _ in range(60)]
        for state in poses:
            for _, translation in state:
                translation *= 5
        states = self.checker.check(
            scene, [2, 1], [[as_matrix(*pose) for pose in state] for state in poses], nearest=True)
        detector = Detector("cpu", nearest=True)
        for number, state in enumerate(poses):
            for body, pose in zip((2, 1), state):
                scene.set_pose(body, *pose)
            result = detector.detect(scene)
            self.assertEqual(states.touches[number], len(result.pairs) > 0)
            distances = [pair.distance_m for pair in result.nearest]
            self.assertEqual(states.distances[number], min(distances, default=numpy.inf))
        self.assertTrue(0 < states.touches.sum() < 60)
        self.assertGreater(numpy.isinf(states.distances).sum(), 0)

    def test_arrays_outlive_the_checker(self):
        states = StateChecker("cpu").check(self.scene, [self.one], [[at(0, 0, 5)]], nearest=True)
        self.scene = None
        self.assertEqual(states.free.tolist(), [True])
        self.assertEqual(states.distances.tolist(), [numpy.inf])

    def test_wrong_arguments_are_refused(self):
        good = [[at(0, 0, 5)]]
        transposed = numpy.swapaxes(good, 2, 3)
        for bodies, poses, why in (([], [], "bodies has none"), ([7], good, "body 7 does not exist"),
                                   ([-1], good, "body -1 does not exist"),
                                   ([1, 1], [good[0] * 2], "one: named twice"),
                                   ([1, 2], good, r"shape \(n, 2, 4, 4\), but have \(1, 1, 4, 4\)"),
                                   ([1], good[0], r"but have \(1, 4, 4\)"),
                                   ([1], [["a"]], "real numbers"),
                                   ([1], transposed, "state 0: the last row of pose 0 is not"),
                                   ([1, 2], [[at(0, 0, 5), numpy.diag([2, 2, 2, 1])]],
                                    "state 0: pose 1 is no rotation"),
                                   ([1], numpy.ma.masked_equal(good, 5), "masked values")):
            with self.assertRaisesRegex(ValueError, why):
                self.checker.check(self.scene, bodies, poses)
        with self.assertRaisesRegex(ValueError, "max_time_s"):
            self.checker.check(self.scene, [1], good, max_time_s=-1)
        for threads in (-1, 1025, 10**9):
            with self.assertRaisesRegex(ValueError, "threads is .*, must be in .0, 1024"):
                StateChecker("cpu", threads=threads)
        with self.assertRaisesRegex(ValueError, "'opencl'"):
            StateChecker("opencl")
        self.checker.reset()
        self.assertTrue(self.checker.check(self.scene, [1], good).free.all())
        self.assertEqual(len(self.checker.check(self.scene, [1], numpy.zeros((0, 1, 4, 4)))), 0)


@unittest.skipUnless(hasattr(deformable_contact, "Robot"), "this build is without ROS")
class Robots(unittest.TestCase):

    URDF = pathlib.Path(os.environ["DCM_SOURCE_DIR"], "config/surgical_arm.urdf").read_text()

    def by_hand(self, positions):
        """Where the links are, by the joints' own definitions: link -> 4x4."""
        turn = {"x": [[1, 0, 0], [0, "c", "-s"], [0, "s", "c"]],
                "y": [["c", 0, "s"], [0, 1, 0], ["-s", 0, "c"]],
                "z": [["c", "-s", 0], ["s", "c", 0], [0, 0, 1]]}
        place = {"base": numpy.eye(4)}
        for link, parent, joint, axis, sign in (
                ("yaw", "base", "yaw", "y", 1), ("pitch", "yaw", "pitch", "x", 1),
                ("shaft", "pitch", "insertion", None, -1), ("wrist", "shaft", "roll", "z", 1),
                ("left_jaw", "wrist", "jaw", "x", 1), ("right_jaw", "wrist", "jaw", "x", -1)):
            step = numpy.eye(4)
            at = sign * positions[joint]
            if axis is None:
                step[2, 3] = at
            else:
                s, c = numpy.sin(at), numpy.cos(at)
                step[:3, :3] = [[{"c": c, "s": s, "-s": -s}.get(e, e) for e in row]
                                for row in turn[axis]]
            place[link] = place[parent] @ step
        return place

    def test_poses_are_those_of_the_joints(self):
        robot = deformable_contact.Robot(self.URDF)
        self.assertEqual(robot.joints, ["insertion", "jaw", "pitch", "roll", "yaw"])
        self.assertEqual(robot.limits.tolist(),
                         [[.02, .24], [0, .8], [-.8, .8], [-3, 3], [-1.2, 1.2]])
        rng = numpy.random.default_rng(1)
        positions = rng.uniform(*robot.limits.T, size=(20, 5))
        poses = robot.poses(positions)
        in_wrist = deformable_contact.Robot(self.URDF, frame="wrist").poses(positions)
        self.assertEqual(poses.shape, (20, len(robot.links), 4, 4))
        for number, state in enumerate(positions):
            place = self.by_hand(dict(zip(robot.joints, state)))
            for link, pose, seen in zip(robot.links, poses[number], in_wrist[number]):
                numpy.testing.assert_allclose(pose, place[link], atol=1e-12)
                numpy.testing.assert_allclose(
                    seen, numpy.linalg.inv(place["wrist"]) @ place[link], atol=1e-12)
        self.assertEqual(robot.poses(numpy.zeros((0, 5))).shape, (0, len(robot.links), 4, 4))
        self.assertTrue(numpy.isnan(robot.poses([[0, 0, 0, 0, numpy.nan]])).any())

    def test_joint_positions_are_checked_as_states(self):
        robot = deformable_contact.Robot(self.URDF)
        scene = Scene()
        floor = scene.add_body("floor", [[-1, -1, -.2], [1, -1, -.2], [0, 2, -.2]], TRIANGLE)
        bodies = robot.add_to(scene)
        for body in bodies:
            scene.set_pair_enabled(floor, body)
        scene.set_margin(floor, .1)
        self.assertEqual(scene.names[1:], robot.links)
        # Upright, the jaws' lowest points are 14 mm below the wrist, which the insertion lowers.
        positions = [[depth, 0, 0, 0, 0] for depth in (.1, .18, .2)]
        states = StateChecker("cpu").check(scene, bodies, robot.poses(positions), nearest=True)
        self.assertEqual(states.touches.tolist(), [False, False, True])
        numpy.testing.assert_allclose(states.distances, [.086, .006, 0], atol=1e-6)
        with self.assertRaisesRegex(ValueError, "a body 'base' already"):
            robot.add_to(scene)

    def test_wrong_arguments_are_refused(self):
        with self.assertRaisesRegex(ValueError, "robot description, line 1"):
            deformable_contact.Robot("<robot")
        with self.assertRaisesRegex(ValueError, "frame 'wirst' is no link of robot 'surgical_arm'"):
            deformable_contact.Robot(self.URDF, frame="wirst")
        with self.assertRaisesRegex(ValueError, "geometry is 'both'"):
            deformable_contact.Robot(self.URDF, geometry="both")
        with self.assertRaisesRegex(ValueError, "no link of the robot has visual geometry"):
            deformable_contact.Robot(self.URDF, geometry="visual")
        with self.assertRaisesRegex(ValueError, "left_jaw: .*none.stl"):
            deformable_contact.Robot(self.URDF.replace(
                '<box size="0.004 0.002 0.012"/>', '<mesh filename="file:///none.stl"/>', 1))
        for broken, problem in (
                (self.URDF.replace('<mimic joint="jaw"', '<mimic joint="jw"'),
                 "joint '[^']*' mimics 'jw', but there is no joint 'jw'"),
                (self.URDF.replace("</robot>", '<joint name="again" type="fixed">'
                                   '<parent link="base"/><child link="wrist"/></joint></robot>'),
                 "link 'wrist' has several parents, by the joints 'again', 'roll'")):
            with self.assertRaisesRegex(ValueError, "robot description: " + problem):
                deformable_contact.Robot(broken)
        robot = deformable_contact.Robot(self.URDF)
        with self.assertRaisesRegex(ValueError, r"shape \(n, 5\).* but have \(1, 4\)"):
            robot.poses([[0] * 4])
        with self.assertRaisesRegex(ValueError, "real numbers"):
            robot.poses([["a"] * 5])


class Example(unittest.TestCase):

    def test_the_path_is_free(self):
        spec = importlib.util.spec_from_file_location("plan_path", EXAMPLES / "plan_path.py")
        example = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(example)
        scene, arm, path = example.main([])
        self.assertGreater(len(path), 2)  # the straight one is blocked
        joints = numpy.concatenate([numpy.linspace(a, b, 400) for a, b in zip(path, path[1:])])
        self.assertTrue(StateChecker("cpu").check(scene, arm.bodies, arm.poses(joints)).free.all())
        straight = numpy.linspace(path[0], path[-1], 400)
        self.assertTrue(
            StateChecker("cpu").check(scene, arm.bodies, arm.poses(straight)).touches.any())


if __name__ == "__main__":
    unittest.main()
