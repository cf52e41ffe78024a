#!/usr/bin/env python3
"""index.html of hundreds of bags: what is of interest first, and a page that stays small."""
import bisect
import os
import pathlib
import random
import re
import sys
import tempfile
import unittest

TOOLS = pathlib.Path(__file__).resolve().parents[3] / "src/tools"
sys.path[:0] = [str(TOOLS / "evaluate_bags"), str(TOOLS / "evaluate_bag")]
from fleet.latency import MOST_POINTS, TAIL, Latency
from fleet.report import MOST_OPEN, write_report

BAGS, CYCLES = 250, 30
BROKEN, CRASHED, CHANGED = "lab/run123.bag", "lab/run200.bag", "lab/run240.bag"
EXPECTATIONS = ("hand touches cloth", "palm never touches <cloth>")


class Page(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out = folder.name
        self.random = random.Random(7)
        self.cycles = []  # (ms, bag's name, stamp)
        self.bags = [self.bag(f"lab/run{i:03}.bag") for i in range(BAGS)]

    def bag(self, name):
        folder = os.path.join("bags", name)
        os.makedirs(os.path.join(self.out, folder))
        cycles = [(round(self.random.lognormvariate(0, 1), 6), f"{i}.5") for i in range(CYCLES)]
        with open(os.path.join(self.out, folder, "frames.csv"), "w") as file:
            file.write("cycle,run,stamp,skipped,detect_ms\n")
            for i, (ms, stamp) in enumerate(cycles):
                file.write(f'{i},cpu,{stamp},"a, b",{ms:.6f}\n{i},fcl,{stamp},,999\n')
        self.cycles += [(ms, name, stamp) for ms, stamp in cycles]
        return {"bag": name, "folder": folder, "state": "broken" if name == BROKEN else "passed",
                "message": "why it is", "cycles": CYCLES, "complete_cycles": CYCLES, "pairs": 3,
                "detect_ms": {"median": 1, "most": 2}, "changes": [
                    {"kind": "bag", "bodies": (), "text": "", "allowed": name != CHANGED}],
                "expectations": [
                    {"text": text, "holds": name != BROKEN or text == EXPECTATIONS[0],
                     "failure": 'not "so"'} for text in EXPECTATIONS]}

    def page(self):
        fleet = {"bags": self.bags, "bags_gone": [], "baseline": "last", "exit_code": 2,
                 "verdict": "Failed", "arguments": [], "version": "1", "machines": ["a"],
                 "were_there": 0, "times": {"elapsed_s": 1}}
        write_report(self.out, fleet)
        with open(os.path.join(self.out, "index.html")) as file:
            return file.read()

    def test_curve(self):
        # A bag without a cycle has a table without titles.
        os.makedirs(os.path.join(self.out, "empty"))
        open(os.path.join(self.out, "empty", "frames.csv"), "w").close()
        latency = Latency(self.out, [*self.bags, {**self.bags[0], "folder": "empty"}])
        times = sorted(ms for ms, _, _ in self.cycles)
        self.assertEqual(latency.times, times)
        points = latency.points()
        self.assertLessEqual(len(points), 2 * MOST_POINTS + TAIL)
        self.assertGreater(len(points), MOST_POINTS)
        for ms, share in points:
            least, most = bisect.bisect_left(times, ms) + 1, bisect.bisect_right(times, ms)
            self.assertTrue(least <= round(share * len(times)) <= most, (ms, share))
        self.assertEqual(points[-1], (times[-1], 1))
        self.assertEqual([ms for ms, _ in points[-TAIL:]], times[-TAIL:])
        for share in (.001, .5, .95, .99, .9999, 1):
            ms = latency.quantile(share)
            self.assertGreaterEqual(sum(t <= ms for t in times), share * len(times))
            self.assertLess(sum(t < ms for t in times), share * len(times))

    def test_slowest_cycles(self):
        slowest = [(ms, bag["bag"], stamp)
                   for ms, bag, stamp in Latency(self.out, self.bags).slowest]
        self.assertEqual(slowest, sorted(self.cycles, reverse=True)[:len(slowest)])
        self.assertEqual(len(slowest), 20)

    def test_page(self):
        crashed = next(bag for bag in self.bags if bag["bag"] == CRASHED)
        crashed.update(folder=None, state="crashed", expectations=[], detect_ms=None)
        page = self.page()
        self.assertLess(len(page), 1000 * BAGS + 200000)
        of_bags, expectations, changes, _ = re.split("<h2>(?:Expec|What changed|Latency)", page)[:4]
        names = re.findall(r"lab/run\d+\.bag(?=<|\b[^/])", re.sub(r'href="[^"]*"', "", of_bags))
        self.assertEqual(names[:3], [BROKEN, CRASHED, CHANGED])
        self.assertEqual(sorted(names), [bag["bag"] for bag in self.bags])
        self.assertEqual(of_bags.split("<details>")[0].count("<tr>"), MOST_OPEN + 1)
        self.assertIn(f"And {BAGS - MOST_OPEN} more", of_bags)
        self.assertNotIn(f'href="bags/{CRASHED}', page)
        # Broken ones have the first row and the first column.
        self.assertLess(expectations.index("palm never touches &lt;cloth&gt;"),
                        expectations.index(EXPECTATIONS[0]))
        rows = re.findall("<tr><td>.*?</tr>", expectations)
        self.assertEqual(len(rows), BAGS - 1)
        self.assertIn(f'<a href="bags/{BROKEN}/summary.json">', rows[0])
        self.assertEqual([row.count("\u2717") for row in rows], [1] + [0] * (BAGS - 2))
        self.assertIn('title="not &#34;so&#34;"', rows[0])
        self.assertIn(f'<tr><td><a href="bags/{CHANGED}/summary.json">', changes)
        self.assertIn("NOT ALLOWED", re.search("<tr><td>.*?</tr>", changes).group())


if __name__ == "__main__":
    unittest.main()
