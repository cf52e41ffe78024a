#!/usr/bin/env python3
"""trajectory_player.py: its motion, what the guard and its silence do, and how it brakes."""
import importlib.util
import os
import pathlib
import tempfile
import unittest

PLAYER = pathlib.Path(os.environ["DCM_SOURCE_DIR"]) / "launch/trajectory_player.py"
SPEC = importlib.util.spec_from_file_location("trajectory_player", str(PLAYER))
player = importlib.util.module_from_spec(SPEC)
SPEC.loader.exec_module(player)


def motion_of(text):
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
        file.write(text)
        file.flush()
        return player.Motion(file.name)


class Heard(player.Guard):
    """A guard that was heard at a time [s]."""

    def __init__(self, scale, stop, heard):
        super().__init__("", 0)
        self._max_silence_s, self._scale, self._stop, self._heard = 0.2, scale, stop, heard


class MotionTest(unittest.TestCase):

    def test_it_starts_and_ends_softly(self):
        motion = motion_of("joints: [a, b]\npoints: [[1, 0, 5], [3, 8, 5]]\nhold: [[2, 0.1, hand]]")
        self.assertEqual(3, motion.end_s)
        self.assertEqual([(2.0, [0.1, "hand"])], motion.holds)
        for time_s, a in ((0, 0), (1, 0), (2, 4), (3, 8), (9, 8)):
            self.assertEqual([a, 5], motion.at(time_s).tolist())
        self.assertAlmostEqual(8 * 0.25 ** 2 * (3 - 0.5), motion.at(1.5)[0])

    def test_what_is_no_motion_is_refused(self):
        for text in ("[]", "joints: [a]", "joints: [a]\npoints: [[0, 1, 2]]",
                     "joints: [a]\npoints: [[1, 0], [1, 2]]", "joints: [a]\npoints: [[0, .nan]]",
                     "joints: [a]\npoints: [[0, x]]"):
            with self.assertRaises(ValueError, msg=text):
                motion_of(text)


class GuardTest(unittest.TestCase):

    def test_a_stop_and_silence_are_a_scale_of_zero(self):
        self.assertEqual(0.5, Heard(0.5, False, 10.0).scale(10.1))
        self.assertEqual(0, Heard(0.5, True, 10.0).scale(10.1))
        self.assertEqual(0, Heard(0.5, False, 10.0).scale(10.3))
        self.assertEqual(0, Heard(0.5, False, None).scale(10.1))
        self.assertEqual(1, player.Guard("", 0.2).scale(10.1))


if __name__ == "__main__":
    unittest.main()
