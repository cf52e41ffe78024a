#!/usr/bin/env python3
"""The closed loop in short: a Panda that reaches through a sheet, and one that reaches for a towel
while the monitor dies, stop without a touch. test/loop/run has the long form."""
import csv
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest

RUN = pathlib.Path(__file__).with_name("run")


class SoftLoopTest(unittest.TestCase):

    def runs(self, *words):
        """The rows of runs.csv."""
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, str(RUN), "--runs", "1", "--out", folder, *words],
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  universal_newlines=True, timeout=280, check=False)
            logs = [path.read_text()[-3000:] for path in pathlib.Path(folder).glob("*/log.txt")]
            self.assertEqual(0, done.returncode, "\n".join([done.stdout, *logs]))
            with open(os.path.join(folder, "runs.csv")) as file:
                return list(csv.DictReader(file))

    def expect_a_stop_before_contact(self, row):
        self.assertGreater(float(row["least_m"]), 0, row)
        self.assertGreater(float(row["standstill_m"]), 0, row)
        self.assertLess(float(row["standstill_m"]), 0.2, row)  # it came near
        self.assertEqual("0", row["touching_meshes"], row)
        self.assertGreaterEqual(int(row["stops"]), 1, row)

    def test_it_stops_before_a_sheet(self):
        row, = self.runs("--scenes", "sheet")
        self.expect_a_stop_before_contact(row)

    def test_it_stops_when_the_monitor_dies(self):
        row, = self.runs("--scenes", "towel", "--faults", "killed")
        self.expect_a_stop_before_contact(row)


if __name__ == "__main__":
    unittest.main()
