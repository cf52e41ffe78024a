#!/usr/bin/python3
"""Draws what measure_trade measured: one picture a question, all scenes in each.

accuracy.png  recall and precision in the worst frame against time, with the Pareto front
work.png      candidates and clusters per triangle against overlap
clusters.png  time against the number of clusters
exact.png     the share of candidate pairs that reached the exact stage
"""
import argparse
import csv
import os
import pathlib
import sys

try:
    import matplotlib
    matplotlib.use("Agg")
    matplotlib.rcParams.update({
        "figure.constrained_layout.use": True, "axes.grid": True, "grid.alpha": 0.3,
        "axes.titlesize": 10, "axes.labelsize": 9, "xtick.labelsize": 8, "ytick.labelsize": 8,
        "legend.fontsize": 8, "legend.frameon": False})
    from matplotlib import pyplot, ticker
except ImportError:
    sys.exit(f"plot_trade.py: {sys.executable} has no matplotlib; "
             "install it (Debian: python3-matplotlib)")

BACKENDS = {"cpu": "#0072b2", "cuda": "#009e73"}
STYLES = {"cpu": "o-", "cuda": "^--"}
PREDICATES = {"exact": "o", "conservative": "s"}
WIDTH, HEIGHT = 3.2, 2.5  # of a panel [inches]
USUAL = {"fuzzifier": "2", "iterations": "1", "refresh_period": "1"}


class Measured:
    """One folder that measure_trade wrote, with the rows of a table there."""

    def __init__(self, folder, table):
        self.name = folder.resolve().name
        self.rows = read_table(folder / table)
        if not self.rows:
            raise ValueError(f"{folder / table}: has no row")


class Scene(Measured):
    """What the grid of settings found."""

    def __init__(self, folder):
        super().__init__(folder, "settings.csv")
        unknown = sorted({row["predicates"] for row in self.rows} - PREDICATES.keys())
        if unknown:
            raise ValueError(f"{folder / 'settings.csv'}: another version measured predicates "
                             f"{', '.join(unknown)}, which are gone; measure again")
        self.backends = [b for b in BACKENDS if any(row["backend"] == b for row in self.rows)]

    def select(self, **wanted):
        return [row for row in self.rows if all(row[key] == value for key, value in wanted.items())]

    def usual(self, **wanted):
        """Rows with the speed knobs that the grid varies one at a time at their first value."""
        first = {key: self.rows[0][key] for key in USUAL}
        return self.select(**first, **wanted)


def read_table(path):
    with open(path, newline="", encoding="utf-8", errors="replace") as file:
        return list(csv.DictReader(file))


def recall(row):
    return min(float(row[key] or 1) for key in ("recall_external_worst", "recall_self_worst"))


def numbers(rows, key, factor=1):
    return [factor * float(row[key]) for row in rows]


def panels(rows, columns, **options):
    return pyplot.subplots(rows, columns, squeeze=False,
                           figsize=(WIDTH * max(columns, 1.6), HEIGHT * rows), **options)


def scene_panels(scenes, y_labels, **options):
    """A row for each label, a column a scene."""
    figure, axes = panels(len(y_labels), len(scenes), **options)
    for axis, scene in zip(axes[0], scenes):
        axis.set_title(scene.name)
    for axis, label in zip(axes[:, 0], y_labels):
        axis.set_ylabel(label)
    return figure, axes


def log_scale(axes, names):
    """Makes axes logarithmic, "x", "y" or "xy", with plain numbers at 1, 2, 5."""
    for name in names:
        axes.set(**{name + "scale": "log"})
        getattr(axes, name + "axis").set(
            major_locator=ticker.LogLocator(subs=(1, 2, 5)), minor_formatter=ticker.NullFormatter(),
            major_formatter=ticker.StrMethodFormatter("{x:g}"))


def legend(figure, axes):
    """One for all panels, each label once."""
    entries = {}
    for axis in axes.flat:
        for handle, label in zip(*axis.get_legend_handles_labels()):
            entries.setdefault(label, handle)
    figure.legend(entries.values(), entries.keys(), loc="upper center", bbox_to_anchor=(0.5, 0),
                  ncol=min(len(entries), 6 if axes.shape[1] > 2 else 2))


def percent_axis(axis, values):
    """Not so fine that nothing looks like something."""
    low = min(100 * min(values), 99)
    margin = 0.08 * (100 - low)
    axis.set_ylim(low - margin, 100 + margin)


def rising(rows):
    """By time, those that find more than all faster ones."""
    kept = []
    for row in sorted(rows, key=lambda row: float(row["median_ms"])):
        if not kept or recall(row) > recall(kept[-1]):
            kept.append(row)
    return kept


def plot_accuracy(scenes):
    figure, axes = scene_panels(scenes, ("worst recall [%]", "worst precision [%]"), sharex="col")
    for column, scene in enumerate(scenes):
        for axis, rate in zip(axes[:, column], (recall, lambda row: float(row["precision_worst"]))):
            for backend in scene.backends:
                for predicates, marker in PREDICATES.items():
                    rows = scene.select(backend=backend, predicates=predicates)
                    axis.plot(numbers(rows, "median_ms"), [100 * rate(row) for row in rows], marker,
                              color=BACKENDS[backend], fillstyle="none", markersize=5, alpha=0.8,
                              label=f"{backend}, {predicates}" if rows else None)
            percent_axis(axis, [rate(row) for row in scene.rows])
        front = rising(scene.select(pareto_front="true"))
        axes[0, column].plot(numbers(front, "median_ms"), [100 * recall(row) for row in front],
                             ".-", color="black", linewidth=0.8, markersize=3,
                             label="Pareto front")
        axes[1, column].set_xlabel("median time [ms]")
        log_scale(axes[1, column], "x")
    legend(figure, axes)
    return figure


def plot_work(scenes):
    """By the strictest predicates: others change what candidates become, not which there are."""
    figure, axes = scene_panels(scenes, ("candidates per triangle", "clusters per triangle"),
                                sharex="col")
    for column, scene in enumerate(scenes):
        rows = scene.usual(backend=scene.backends[0], predicates=scene.rows[0]["predicates"])
        counts = sorted({row["clusters"] for row in rows}, key=int)
        for place, clusters in enumerate(counts):
            line = sorted((row for row in rows if row["clusters"] == clusters),
                          key=lambda row: float(row["overlap"]))
            colour = pyplot.get_cmap("viridis")(0.9 * place / max(len(counts) - 1, 1))
            label = "clusters auto" if clusters == "0" else f"{clusters} clusters"
            for axis, key in zip(axes[:, column],
                                 ("candidates_per_triangle", "clusters_per_triangle")):
                axis.plot(numbers(line, "overlap"), numbers(line, key), "o-", color=colour,
                          markersize=3, linewidth=1, label=label)
        axes[1, column].set_xlabel("overlap")
    legend(figure, axes)
    return figure


def plot_lines(scenes, lines, x_label, y_label):
    """One panel; lines(scene) gives label, style, x and y of each of its lines."""
    figure, axes = panels(1, 1)
    axis = axes[0, 0]
    for place, scene in enumerate(scenes):
        for label, style, x, y in lines(scene):
            axis.plot(x, y, style, color=f"C{place}", markersize=4, linewidth=1,
                      label=f"{scene.name}: {label}")
    axis.set(xlabel=x_label, ylabel=y_label)
    legend(figure, axes)
    return figure, axis


def plot_clusters(scenes):
    """At the largest overlap and the strictest predicates."""
    def lines(scene):
        largest = max((row["overlap"] for row in scene.rows), key=float)
        for backend in scene.backends:
            rows = scene.usual(backend=backend, predicates=scene.rows[0]["predicates"],
                               overlap=largest)
            rows.sort(key=lambda row: float(row["clusters_used"]))
            yield (f"{backend}, overlap {largest}", STYLES[backend],
                   numbers(rows, "clusters_used"), numbers(rows, "median_ms"))

    figure, axis = plot_lines(scenes, lines, "clusters", "median time [ms]")
    log_scale(axis, "xy")
    return figure


def plot_exact(scenes):
    """With the first number of clusters; only exact predicates have that stage."""
    def lines(scene):
        for backend in scene.backends:
            rows = scene.usual(backend=backend, predicates=scene.rows[0]["predicates"],
                               clusters=scene.rows[0]["clusters"])
            rows.sort(key=lambda row: float(row["overlap"]))
            yield (f"{backend}, {rows[0]['predicates']}", STYLES[backend],
                   numbers(rows, "overlap"), [100 * float(row["exact_share"]) for row in rows])

    figure, axis = plot_lines(scenes, lines, "overlap",
                              "candidates that reach\nthe exact stage [%]")
    axis.set_yscale("symlog", linthresh=0.001)  # it may be none
    axis.set_ylim(bottom=0)
    axis.yaxis.set_major_formatter(ticker.StrMethodFormatter("{x:g}"))
    return figure


def write_whole(path, figure):
    """The picture has its name only once it is whole."""
    part = path.with_name(f"{path.name}.{os.getpid()}.part")
    try:
        figure.savefig(part, format="png", dpi=100, bbox_inches="tight")
        part.replace(path)
    except OSError:
        if part.exists():
            part.unlink()
        raise


def draw(doc, wrote, scene_of, plots):
    """main() of the programs that draw: each plot of all folders' scenes, by its name."""
    parser = argparse.ArgumentParser(description=doc,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", nargs="+", type=pathlib.Path,
                        help=f"what {wrote} wrote; the scene is called as the folder")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("."),
                        help="folder for the pictures (default: the current one)")
    arguments = parser.parse_args()
    try:
        scenes = [scene_of(folder) for folder in arguments.folder]
        for name, plot in plots.items():
            figure = plot(scenes)
            write_whole(arguments.out / f"{name}.png", figure)
            pyplot.close(figure)
    except (OSError, KeyError, ValueError) as error:
        sys.exit(f"{pathlib.Path(sys.argv[0]).name}: {error}")


if __name__ == "__main__":
    draw(__doc__, "measure_trade", Scene, {"accuracy": plot_accuracy, "work": plot_work,
                                           "clusters": plot_clusters, "exact": plot_exact})
