"""Collects the detection times of all cycles of all bags: their distribution, and the slowest."""
import array
import csv
import heapq
import math
import os

from evaluation_report import plt, to_svg

MOST_SLOW_CYCLES = 20
MOST_POINTS = 2000  # of the curve
TAIL = 200          # every one of the slowest cycles has a point


def _cycles_of(folder):
    """Yields (milliseconds, stamp) for the cycles of the first run. Without a cycle there are no
    titles either."""
    with open(os.path.join(folder, "frames.csv"), newline="", errors="replace") as file:
        rows = csv.reader(file)
        titles = next(rows, None)
        if titles is None:
            return
        run, ms, stamp = (titles.index(name) for name in ("run", "detect_ms", "stamp"))
        first = None
        for row in rows:
            first = first or row[run]
            if row[run] == first:
                yield float(row[ms]), row[stamp]


class Latency:

    def __init__(self, out, bags):
        """`bags` are entries of fleet.json."""
        times = array.array("d")
        self.slowest = []  # (milliseconds, bag, stamp)
        for bag in bags:
            if not bag["folder"]:
                continue
            cycles = list(_cycles_of(os.path.join(out, bag["folder"])))
            times.extend(ms for ms, _ in cycles)
            slow = heapq.nlargest(MOST_SLOW_CYCLES, cycles)
            self.slowest += [(ms, bag, stamp) for ms, stamp in slow]
        self.slowest.sort(key=lambda c: (-c[0], c[1]["bag"], c[2]))
        del self.slowest[MOST_SLOW_CYCLES:]
        self.times = sorted(times)

    def quantile(self, share):
        """Returns the time that this share of all cycles does not exceed [ms]."""
        return self.times[math.ceil(share * len(self.times)) - 1]

    def points(self):
        """Returns [(milliseconds, share of cycles that take at most as long)], with fewer points
        than cycles."""
        count = len(self.times)
        step = max(count // MOST_POINTS, 1)
        shown = sorted({0, *range(0, count, step), *range(max(count - TAIL, 0), count)})
        return [(self.times[i], (i + 1) / count) for i in shown]

    def plot(self):
        figure, axes = plt.subplots(figsize=(9, 3.2))
        axes.step(*zip(*self.points()), where="post")
        axes.set(xlabel="time of a cycle [ms]", ylabel="share of all cycles", ylim=(0, 1.02))
        axes.set_xscale("log")
        axes.grid(alpha=.3, which="both")
        return to_svg(figure)
