#!/usr/bin/python3
"""Draws what measure_trade --tolerance measured, all scenes in one picture, bounds.png.

Above: median time against the tolerance, without a budget; the line is exact detection.
Below: the share of pairs of bodies that were decided, against the budget, a line a tolerance.
"""
import argparse
import csv
import pathlib
import sys

sys.dont_write_bytecode = True  # beside programs there is no place for it
# pylint: disable=wrong-import-position
from plot_trade import legend, panels, pyplot, write_whole

COLORS = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7")


class Scene:
    """One folder that measure_trade --tolerance wrote."""

    def __init__(self, folder):
        self.name = folder.resolve().name
        with open(folder / "bounds.csv", newline="", encoding="utf-8") as file:
            rows = [{name: float(value) for name, value in row.items()}
                    for row in csv.DictReader(file)]
        if not rows:
            raise ValueError(f"{folder / 'bounds.csv'}: has no row")
        self.exact, self.rows = rows[0], rows[1:]

    def line(self, of, value, along):
        """Rows whose `of` is so, in the order of `along`."""
        return sorted((row for row in self.rows if row[of] == value), key=lambda row: row[along])


def plot(scenes):
    figure, axes = panels(2, len(scenes))
    for column, scene in enumerate(scenes):
        times, shares = axes[:, column]
        times.set_title(scene.name, fontsize=10)
        rows = scene.line("budget_ms", 0, "tolerance_m")
        times.plot([1e3 * row["tolerance_m"] for row in rows],
                   [row["median_ms"] for row in rows], "o-", color="black")
        times.axhline(scene.exact["median_ms"], color="grey", linestyle="--")
        times.set_ylim(bottom=0)
        times.set_xlabel("tolerance [mm]", fontsize=9)
        tolerances = sorted({row["tolerance_m"] for row in scene.rows})
        for color, tolerance in zip(COLORS, tolerances):
            rows = [row for row in scene.line("tolerance_m", tolerance, "budget_ms")
                    if row["budget_ms"] > 0]
            shares.plot([row["budget_ms"] for row in rows],
                        [100 * row["decided_share"] for row in rows], "o-", color=color,
                        label=f"{1e3 * tolerance:g} mm")
        shares.set_ylim(0, 105)
        shares.set_xlabel("budget [ms]", fontsize=9)
    axes[0, 0].set_ylabel("median time [ms]\n(dashed: exact)", fontsize=9)
    axes[1, 0].set_ylabel("pairs of bodies decided [%]", fontsize=9)
    legend(figure, axes[1:])
    return figure


def main():
    parser = argparse.ArgumentParser(description=__doc__,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="+", type=pathlib.Path,
                        help="what measure_trade --tolerance wrote; the scene is called as the "
                             "folder")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("."),
                        help="folder for the picture (default: the current one)")
    arguments = parser.parse_args()
    figure = plot([Scene(folder) for folder in arguments.folder])
    write_whole(arguments.out / "bounds.png", figure)
    pyplot.close(figure)


if __name__ == "__main__":
    try:
        main()
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"plot_bounds.py: {error}")
