#!/usr/bin/env python3
"""The camera of launch/framed_rviz.py: what it is to see lies within the picture."""
import contextlib
import importlib.util
import io
import itertools
import math
import os
import sys
import types
import unittest
from unittest import mock

HERE = os.path.dirname(os.path.abspath(__file__))
SPEC = importlib.util.spec_from_file_location(
    "framed_rviz", os.path.join(HERE, "../launch/framed_rviz.py"))
framed_rviz = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(framed_rviz)

BOXES = [((0, 0, 0), (1, 1, 1)), ((-3, 7, 0.5), (-2.9, 9, 0.6)), ((100, 0, 0), (180, 1, 30)),
         ((0, 0, 0), (0.001, 0.001, 0.001))]


def angle_from_axis(point, focus, distance, yaw, pitch):
    """Of what rviz's orbit camera sees."""
    eye = [f + distance * d for f, d in zip(focus, (
        math.cos(yaw) * math.cos(pitch), math.sin(yaw) * math.cos(pitch), math.sin(pitch)))]
    ahead, to = ([a - b for a, b in zip(p, eye)] for p in (focus, point))
    cosine = sum(map(lambda a, b: a * b, ahead, to)) / math.hypot(*ahead) / math.hypot(*to)
    return math.acos(min(1, cosine))


class FramedRviz(unittest.TestCase):

    def test_all_corners_are_in_the_picture_from_any_side(self):
        for box in BOXES:
            focus, distance = framed_rviz.view_of(box)
            angles = [angle_from_axis(corner, focus, distance, yaw, pitch)
                      for corner in itertools.product(*zip(*box))
                      for yaw in (0, 0.95, 2, 4) for pitch in (-1.5, 0, 0.42, 1)]
            self.assertLess(max(angles), math.radians(22.5), box)
            if math.dist(*box) > 0.1:
                self.assertGreater(max(angles), math.radians(18), "and they fill it")

    def test_boxes(self):
        nan = float("nan")
        self.assertEqual(framed_rviz.box_of([(1, 5, 3), (nan, 0, 0), (2, 4, 9)]),
                         ((1, 4, 3), (2, 5, 9)))
        self.assertIsNone(framed_rviz.box_of([(nan, 1, 1)]))

    def test_help_and_wrong_values_end_it_before_ros_starts(self):
        for words, code, text in ((["--help"], 0, "--monitor NAME"), (["a:=b", "-h"], 0, "rviz"),
                                  (["--wait", "long"], 2, "--wait")):
            out = io.StringIO()
            with self.assertRaises(SystemExit) as end, contextlib.redirect_stdout(out), \
                    contextlib.redirect_stderr(out), mock.patch.object(sys, "argv", ["", *words]):
                framed_rviz.main()
            self.assertEqual(end.exception.code, code)
            self.assertIn(text, out.getvalue())
        self.assertNotIn("rospy", sys.modules)

    def test_rviz_gets_its_own_arguments(self):
        arguments, for_rviz, remappings = framed_rviz.parse(
            ["--wait", "3", "-f", "map", "a:=b", "--fullscreen", "__name:=view"])
        self.assertEqual((arguments.monitor, arguments.wait), ("/contact_monitor", 3))
        self.assertEqual(for_rviz, ["-f", "map", "--fullscreen"])
        self.assertEqual(remappings, ["a:=b", "__name:=view"])

    def test_only_the_view_changes(self):
        with open(framed_rviz.CONFIG) as file:
            before = file.read()
        after = framed_rviz.with_view(before, (1.5, -2, 3), 4)
        changed = [(a.strip(), b.strip()) for a, b in zip(before.splitlines(), after.splitlines())
                   if a != b]
        self.assertEqual([b for _, b in changed],
                         ["Distance: 4.000", "X: 1.500", "Y: -2.000", "Z: 3.000"])
        self.assertEqual(framed_rviz.with_view(after, (1.5, -2, 3), 4), after)
        with self.assertRaises(ValueError):
            framed_rviz.with_view("Panels:", (0, 0, 0), 1)

    def test_points_are_moved_by_transforms(self):
        half = math.sqrt(0.5)
        pose = types.SimpleNamespace(  # a quarter turn about z, and one along x
            rotation=types.SimpleNamespace(x=0, y=0, z=half, w=half),
            translation=types.SimpleNamespace(x=1, y=0, z=0))
        for point, wanted in (((1, 0, 0), (1, 1, 0)), ((0, 2, 5), (-1, 0, 5))):
            for a, b in zip(framed_rviz.moved(pose, point), wanted):
                self.assertAlmostEqual(a, b)


if __name__ == "__main__":
    unittest.main()
