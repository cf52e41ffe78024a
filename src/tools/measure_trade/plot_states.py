#!/usr/bin/python3
"""Draws what measure_trade --states measured, all scenes in one picture, states.png.

A column a scene; above, the time of a state against the number of states that are asked at once;
below, which share of the states other ways call free though they touch, or blocked though they do
not.
"""
import sys

sys.dont_write_bytecode = True  # beside programs there is no place for it
# pylint: disable=wrong-import-position
from plot_trade import BACKENDS, STYLES, Measured, draw, legend, log_scale, scene_panels


class Scene(Measured):
    """What measure_trade --states found."""

    def __init__(self, folder):
        super().__init__(folder, "states.csv")
        self.others = [row for row in self.rows if row["way"] not in BACKENDS]

    def line(self, backend, question):
        rows = [row for row in self.rows if (row["way"], row["question"]) == (backend, question)]
        return [float(row["batch"]) for row in rows], [float(row["median_us"]) for row in rows]


def plot_times(axis, scene):
    for backend, color in BACKENDS.items():
        for question, fill in (("touch", "full"), ("nearest", "none")):
            batch, time = scene.line(backend, question)
            if batch:
                axis.plot(batch, time, STYLES[backend], color=color, fillstyle=fill, markersize=5,
                          label=f"{backend}, {question}")
    for row in scene.others:
        if row["way"] == "fcl":
            axis.axhline(float(row["median_us"]), color="black", linestyle="--", label="fcl, touch")
    log_scale(axis, "y")
    axis.set(xscale="log", xlabel="states at once")


def plot_errors(axis, scene):
    names = [row["way"].replace("spheres_", "").replace("_", "\n") for row in scene.others]
    for place, (key, color, label) in enumerate((("false_free", "#d55e00", "touch, called free"),
                                                 ("false_blocked", "#56b4e9",
                                                  "free, called touching"))):
        shares = [100 * float(row[key]) for row in scene.others]
        at = [i + 0.4 * place - 0.2 for i in range(len(names))]
        axis.bar(at, shares, width=0.4, color=color, label=label)
    axis.set_xticks(range(len(names)))
    axis.set_xticklabels(names, fontsize=7)
    axis.grid(visible=False, axis="x")


def plot_states(scenes):
    figure, axes = scene_panels(scenes, ("time of a state [us]", "states [%]"))
    for column, scene in enumerate(scenes):
        plot_times(axes[0, column], scene)
        plot_errors(axes[1, column], scene)
    legend(figure, axes)
    return figure


if __name__ == "__main__":
    draw(__doc__, "measure_trade --states", Scene, {"states": plot_states})
