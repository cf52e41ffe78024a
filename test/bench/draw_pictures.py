#!/usr/bin/env python3
"""Draws the pictures of how_it_works.md and of README.md beside this file.

Usage: draw_pictures.py DATA FOLDER

DATA is what cluster_data printed. The figures of speed.png are read from README.md's tables.
"""
import pathlib
import re
import sys

import matplotlib
matplotlib.use("Agg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

README = pathlib.Path(__file__).with_name("README.md")
SHOWN = 12  # the cluster of the second picture
ROWS = 60  # triangles of it whose intervals are drawn


def read(path):
    """{cluster: point}, {cluster: axis}, and the triangles, a row of numbers each."""
    prototypes, axes, triangles = {}, {}, []
    with open(path) as file:
        for line in file:
            kind, *words = line.split()
            numbers = [float(word) for word in words]
            if kind == "triangle":
                triangles.append(numbers)
            else:
                vectors = prototypes if kind == "prototype" else axes
                vectors[int(numbers[0])] = np.array(numbers[1:])
    return prototypes, axes, np.array(triangles)


def draw_clusters(prototypes, triangles, path):
    """The cloth from the front: a color for each cluster, black what is in several."""
    corners = triangles[:, 2:11].reshape(-1, 3, 3)
    order = np.argsort(corners[:, :, 2].mean(axis=1))
    colors = plt.get_cmap("tab20")(triangles[order, 0].astype(int) % 20)
    colors[triangles[order, 1] > 1] = (0, 0, 0, 1)
    figure, axis = plt.subplots(figsize=(6, 5))
    axis.add_collection(PolyCollection(corners[order][:, :, :2], facecolors=colors, linewidths=0))
    points = np.array(list(prototypes.values()))
    axis.plot(points[:, 0], points[:, 1], "o", color="white", markeredgecolor="black")
    axis.set_aspect("equal")
    axis.autoscale_view()
    axis.axis("off")
    figure.tight_layout()
    figure.savefig(path, dpi=90, bbox_inches="tight")


def draw_interval(axes, triangles, path):
    """One cluster with its first principal axis, and its triangles' intervals along it, sorted."""
    mine = triangles[triangles[:, 0] == SHOWN]
    corners = mine[:, 2:11].reshape(-1, 3, 3)
    first = axes[SHOWN]
    middle = corners.mean(axis=(0, 1))
    across = np.linalg.svd((corners.reshape(-1, 3) - middle), full_matrices=False)[2]
    across = max(across, key=lambda a: np.linalg.norm(np.cross(a, first)))
    second = np.cross(np.cross(first, across), first)
    second /= np.linalg.norm(second)
    flat = np.stack([(corners - middle) @ first, (corners - middle) @ second], axis=-1)
    figure, (above, below) = plt.subplots(2, 1, figsize=(6, 5.4),
                                          gridspec_kw={"height_ratios": (3, 2)})
    above.add_collection(
        PolyCollection(flat, facecolors="#9fc3d9", edgecolors="#5b89a3", linewidths=0.2))
    low, high = flat[..., 0].min(), flat[..., 0].max()
    above.annotate("", (high, 0), (low, 0),
                   arrowprops={"arrowstyle": "->", "color": "tab:red", "lw": 2})
    above.set_aspect("equal")
    above.autoscale_view()
    above.axis("off")
    above.set_title("one cluster and its first principal axis", fontsize=10)
    some = mine[np.linspace(0, len(mine) - 1, ROWS).astype(int), 11:]
    rows = [((low, -i), (high, -i)) for i, (low, high) in enumerate(some)]
    below.add_collection(LineCollection(rows, colors="#5b89a3", linewidths=2))
    below.autoscale_view()
    below.axis("off")
    below.set_title(f"intervals of {ROWS} of its {len(mine)} triangles along that axis, sorted",
                    fontsize=10)
    figure.tight_layout()
    figure.savefig(path, dpi=90, bbox_inches="tight")


def cells(start):
    """The cells of the only row of README.md that begins with these cells."""
    rows = [line for line in README.read_text().splitlines() if line.startswith(f"| {start} |")]
    if len(rows) != 1:
        raise ValueError(f"README.md has {len(rows)} rows that begin with {start!r}")
    return [cell.strip() for cell in rows[0].strip("|").split("|")]


def number(cell):
    return float(re.match(r"[\d. ]+", cell).group().replace(" ", ""))


def draw_bars(axis, title, rows):
    for i, (name, ms, is_ours) in enumerate(rows):
        axis.barh(-i, ms, color="tab:blue" if is_ours else "#b8c4cc")
        axis.text(ms * 1.1, -i, f"{ms:g} ms", va="center", fontsize=9)
    axis.set_yticks([-i for i in range(len(rows))])
    axis.set_yticklabels([name for name, _, _ in rows], fontsize=9)
    axis.set_xscale("log")
    times = [ms for _, ms, _ in rows]
    axis.set_xlim(10 ** np.floor(np.log10(min(times)) - 0.3), max(times) * 6)
    axis.set_title(title, fontsize=10, loc="left")
    for side in ("top", "right"):
        axis.spines[side].set_visible(False)


def draw_speed(path):
    cloth = "cloth_ball92, self"
    contacts = [(name, number(cells(f"{cloth} | {row}")[2]), ours) for name, row, ours in (
        ("this package: all contacts, exact", "ours, exact, neighbours skipped: detect", True),
        ("Embree: pairs of leaves' boxes", "Embree rtcCollide (boxes of leaves only)", False),
        ("CGAL: pairs of boxes", "CGAL box_self_intersection_d (boxes only)", False),
        ("FCL: triangles, floating point", "FCL BVHModel (triangles in floating point)", False))]
    panda = cells("Panda's 11 links beside cloth_ball92, 0.15 m apart | 94 594 | 0.081")
    distances = [(name, number(panda[column]), ours) for name, column, ours in (
        ("this package: nearest pair, exact", 3, True), ("FCL, refitted top-down", 8, False),
        ("FCL, rebuilt", 9, False))]
    figure, axes = plt.subplots(2, 1, figsize=(7.5, 4.2), gridspec_kw={"height_ratios": (4, 3)})
    draw_bars(axes[0], "a crumpled cloth of 92 230 triangles with itself", contacts)
    draw_bars(axes[1], "distances of a Panda's 11 links from that cloth", distances)
    figure.tight_layout()
    figure.savefig(path, dpi=90, bbox_inches="tight")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    prototypes, axes, triangles = read(sys.argv[1])
    folder = pathlib.Path(sys.argv[2])
    draw_clusters(prototypes, triangles, folder / "clusters.png")
    draw_interval(axes, triangles, folder / "intervals.png")
    draw_speed(folder / "speed.png")


if __name__ == "__main__":
    main()
