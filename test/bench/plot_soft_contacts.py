#!/usr/bin/env python3
"""Draws what soft_contacts wrote: plot_soft_contacts.py CSV PNG."""
import csv
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt

LINES = (("touching", "tab:red", "touching triangles"), ("missed", "k", "of these not listed"),
         ("listed", "tab:blue", "listed vertices"), ("apart", "tab:cyan", "of these apart"),
         ("between", "tab:orange", "triangles that touch only within the step"))


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    runs = {}
    with open(sys.argv[1]) as file:
        for row in csv.DictReader(file):
            runs.setdefault((row["scene"], round(1 / float(row["step_s"]))), []).append(row)
    scenes = list(dict.fromkeys(scene for scene, _ in runs))
    rates = sorted({rate for _, rate in runs}, reverse=True)
    figure, axes = plt.subplots(len(scenes), len(rates), figsize=(4 * len(rates), 2.4 * len(scenes)),
                                sharex=True, sharey="row", squeeze=False)
    for (scene, rate), rows in runs.items():
        axis = axes[scenes.index(scene)][rates.index(rate)]
        for name, color, label in LINES:
            axis.plot([float(row["time_s"]) for row in rows], [int(row[name]) for row in rows],
                      color=color, label=label, linewidth=0.9)
        axis.set_title("%s, 1/%d s" % (scene, rate), fontsize=8)
    for axis in axes[-1]:
        axis.set_xlabel("time [s]")
    figure.legend(*axes[0][0].get_legend_handles_labels(), loc="lower center", ncol=5, fontsize=8)
    figure.tight_layout(rect=(0, 0.03, 1, 1))
    figure.savefig(sys.argv[2], dpi=80)


if __name__ == "__main__":
    main()
