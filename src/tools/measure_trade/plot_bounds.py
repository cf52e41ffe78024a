#!/usr/bin/python3
"""Draws what measure_trade --tolerance measured, all scenes in one picture, bounds.png.

A column a scene; from above: median time against the tolerance, without a budget, beside exact
detection; recall and precision of pairs of bodies against time, of tolerances and of overlaps; the
largest distance at a claimed contact against the tolerance, which is the line; the share of pairs
of bodies that were decided, and their p99, against the budget, a line a tolerance.
"""
import sys

sys.dont_write_bytecode = True  # beside programs there is no place for it
# pylint: disable=wrong-import-position
from plot_trade import (BACKENDS, Measured, draw, legend, log_scale, numbers, percent_axis,
                        scene_panels)

COLORS = ("#0072b2", "#d55e00", "#009e73", "#e69f00", "#56b4e9", "#cc79a7")


class Scene(Measured):
    """What measure_trade --tolerance found."""

    def __init__(self, folder):
        super().__init__(folder, "bounds.csv")
        rows = [{name: value if name == "backend" else float(value)
                 for name, value in row.items()} for row in self.rows]
        self.exact = [row for row in rows if is_exact(row)]
        self.overlaps = [row for row in rows if row["overlap"] < 1]
        bounded = [row for row in rows if row["tolerance_m"] > 0 or row["budget_ms"] > 0]
        self.without_budget = [row for row in bounded if row["budget_ms"] == 0]
        self.with_budget = [row for row in bounded if row["budget_ms"] > 0]


def is_exact(row):
    return row["overlap"] == 1 and row["tolerance_m"] == 0 and row["budget_ms"] == 0


def plot_times(axis, scene):
    axis.plot(numbers(scene.without_budget, "tolerance_m", 1e3),
              numbers(scene.without_budget, "median_ms"), "o-", color="black", label="tolerance")
    for row in scene.exact:
        axis.axhline(row["median_ms"], color=BACKENDS[row["backend"]], linestyle="--",
                     label=f"exact, {row['backend']}")
    log_scale(axis, "y")
    axis.set_xlabel("tolerance [mm]")


def plot_rates(axis, scene):
    kinds = (("tolerance", scene.without_budget, "black"),
             ("overlap", scene.overlaps, "#d55e00"),
             ("exact", scene.exact[:1], BACKENDS["cpu"]))
    rates = [row[rate] for _, rows, _ in kinds for row in rows for rate in ("recall", "precision")]
    percent_axis(axis, rates)
    for name, rows, color in kinds:
        for rate, marker in (("recall", "o"), ("precision", "x")):
            axis.plot(numbers(rows, "median_ms"), numbers(rows, rate, 100), marker, color=color,
                      fillstyle="none", label=f"{name}: {rate}" if rows else None)
    log_scale(axis, "x")
    axis.set_xlabel("median time [ms]")


def plot_claims(axis, scene):
    tolerances = numbers(scene.without_budget, "tolerance_m", 1e3)
    axis.plot(tolerances, tolerances, "--", color="grey", label="tolerance itself")
    axis.plot(tolerances, numbers(scene.without_budget, "largest_claim_m", 1e3), "o",
              color="black", label="largest at a claimed contact")
    axis.set_xlabel("tolerance [mm]")


def plot_budgets(decided, times, scene):
    for color, tolerance in zip(COLORS, sorted({row["tolerance_m"] for row in scene.with_budget})):
        rows = [row for row in scene.with_budget if row["tolerance_m"] == tolerance]
        rows.sort(key=lambda row: row["budget_ms"])
        budgets, label = numbers(rows, "budget_ms"), f"{1e3 * tolerance:g} mm"
        decided.plot(budgets, numbers(rows, "decided_share", 100), "o-", color=color, label=label)
        times.plot(budgets, numbers(rows, "p99_ms"), "o-", color=color, label=label)
    budgets = sorted({row["budget_ms"] for row in scene.with_budget})
    times.plot(budgets, budgets, "--", color="grey", label="budget itself")
    decided.set(ylim=(0, 105), xlabel="budget [ms]")
    times.set_xlabel("budget [ms]")


def plot(scenes):
    figure, axes = scene_panels(scenes, ("median time [ms]", "pairs of bodies [%]",
                                         "distance [mm]", "pairs decided [%]", "p99 [ms]"))
    for column, scene in enumerate(scenes):
        times, rates, claims, decided, late = axes[:, column]
        plot_times(times, scene)
        plot_rates(rates, scene)
        plot_claims(claims, scene)
        plot_budgets(decided, late, scene)
    legend(figure, axes)
    return figure


if __name__ == "__main__":
    draw(__doc__, "measure_trade --tolerance", Scene, {"bounds": plot})
