#!/usr/bin/env python3
"""Runs the scenarios of `run` that need no GPU for a few seconds each, and sends SIGINT at some
random moments. Checks what the monitor promises on any machine, however busy."""
import json
import os
import subprocess
import sys
import tempfile
import unittest

from load_support import HERE, WAIT_S

SECONDS = 6
MOST_UNKNOWN = 0.5  # share of time; of objects whose meshes come in time
TIMES = 9  # every moment of interruptions.py once
WITHIN_S = 5


class Load(unittest.TestCase):

    def run_scenario(self, name, *options):
        """Its figures, if no promise was broken."""
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "figures.json")
            done = subprocess.run(
                [sys.executable, os.path.join(HERE, "run"), name, "--minutes", str(SECONDS / 60),
                 "--json", path, *options], timeout=4 * WAIT_S, stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT, universal_newlines=True)
            self.assertEqual(done.returncode, 0, done.stdout)
            with open(path) as file:
                figures = json.load(file)
        self.assertGreater(figures["client"]["with_stamp_of_a_mesh"], 0, done.stdout)
        self.assertLess(figures["unknown_worst"], MOST_UNKNOWN, done.stdout)
        self.assertEqual(figures["refused"], 0, done.stdout)
        return figures

    def test_meshes_at_five_hundred_a_second(self):
        self.run_scenario("fast")

    def test_a_hundred_links_and_a_hundred_objects(self):
        # A busy machine has fewer cycles, and a turn of all objects takes longer.
        self.run_scenario("many", "--max-mesh-age", "2")

    def test_subscribers_that_read_nothing(self):
        figures = self.run_scenario("deaf")
        self.assertGreater(figures["deaf_still_connected"], 0)

    def test_how_a_budget_is_kept_is_measured(self):
        done = subprocess.run(
            [sys.executable, os.path.join(HERE, "budget"), "--rounds", "1", "--budgets", "33",
             "--scenes", "1", "--rate", "90"], timeout=4 * WAIT_S, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, universal_newlines=True)
        self.assertEqual(done.returncode, 0, done.stdout)
        row = done.stdout.splitlines()[-1].split("|")
        self.assertEqual(float(row[2]), 33, done.stdout)
        self.assertGreater(float(row[4]), 0, done.stdout)
        self.assertGreater(float(row[6].split()[0]), 0, done.stdout)

    def test_sigint_at_any_moment(self):
        done = subprocess.run(
            [sys.executable, os.path.join(HERE, "interrupt"), "--times", str(TIMES), "--within",
             str(WITHIN_S)], timeout=4 * WAIT_S, stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT, universal_newlines=True)
        self.assertEqual(done.returncode, 0, done.stdout)


if __name__ == "__main__":
    unittest.main()
