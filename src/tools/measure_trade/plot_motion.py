#!/usr/bin/python3
"""Draws what measure_trade --swept measured, all scenes in each picture.

lost.png    the share of contacts and of onsets that each way to look loses, of pairs of triangles
onsets.png  onsets found so far, of pairs of triangles, over the frames
"""
import json
import sys

sys.dont_write_bytecode = True  # beside programs there is no place for it
# pylint: disable=wrong-import-position
from plot_trade import Measured, draw, legend, read_table, scene_panels

TRUTH = "swept, all frames"
COLORS = {"instant": "#d55e00", "instant_kept": "#e69f00", "swept_kept": "#0072b2"}
WAYS = tuple(COLORS)  # in the order of the rows of motions.csv
ROWS = (("triangles", "contacts"), ("triangles", "onsets"))


class Scene(Measured):
    """What measure_trade --swept found."""

    def __init__(self, folder):
        super().__init__(folder, "motions.csv")
        self.onsets = read_table(folder / "onsets.csv")
        with open(folder / "summary.json", encoding="utf-8") as file:
            summary = json.load(file)
        self.every, self.frames = summary["every"], len(summary["frames"])

    def lost(self, level, what):
        """By way: lost, of how many."""
        rows = [row for row in self.rows if row["level"] == level]
        return [(int(row[what + "_lost"]), int(row[what])) for row in rows]

    def times(self, column):
        """When onsets of triangle pairs were found, ascending [frames]."""
        return sorted(float(row[column]) for row in self.onsets
                      if row["level"] == "triangles" and row[column])


def label(way):
    motion, _, kept = way.partition("_")
    return f"{motion}, kept frames" if kept else f"{motion}, all frames"


def plot_lost(scenes):
    figure, axes = scene_panels(
        scenes, ("contacts of triangles\nlost [%]", "onsets of triangles\nlost [%]"), sharex="col")
    for column, scene in enumerate(scenes):
        for axis, (level, what) in zip(axes[:, column], ROWS):
            shares = [100 * lost / of if of else 0 for lost, of in scene.lost(level, what)]
            axis.bar(range(len(WAYS)), shares, width=0.6, color=list(COLORS.values()))
            for place, (share, (lost, _)) in enumerate(zip(shares, scene.lost(level, what))):
                axis.annotate(str(lost), (place, share), (0, 2), textcoords="offset points",
                              ha="center", va="bottom", fontsize=8)
            axis.set_ylim(0, 1.18 * max(shares + [1]))
            axis.set_xticks(range(len(WAYS)))
            axis.set_xticklabels([label(way).replace(", ", ",\n") for way in WAYS], fontsize=7)
            axis.grid(visible=False, axis="x")
    return figure


def plot_onsets(scenes):
    figure, axes = scene_panels(scenes, ["onsets of triangle pairs"])
    for axis, scene in zip(axes[0], scenes):
        for name, column, color in ((TRUTH, "first_low", "black"),
                                    *((label(way), way if way.startswith("instant")
                                       else way + "_low", COLORS[way]) for way in WAYS)):
            times = scene.times(column)
            x = [0, *times, scene.frames - 1]
            y = [*range(len(times) + 1), len(times)]
            axis.step(x, y, where="post", color=color, linewidth=2.4 if name == TRUTH else 1.2,
                      alpha=0.35 if name == TRUTH else 1, label=name)
        axis.set(title=f"{scene.name} (every {scene.every}th kept)", xlabel="time [frames]")
        axis.set_ylim(bottom=0)
    legend(figure, axes)
    return figure


if __name__ == "__main__":
    draw(__doc__, "measure_trade --swept", Scene, {"lost": plot_lost, "onsets": plot_onsets})
