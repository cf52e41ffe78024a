#!/usr/bin/python3
"""Turns the tables of evaluate_bag into report.html, one file with its plots inside.

Usage: evaluation_report.py FOLDER, with frames.csv, links.csv, distances.csv and summary.json in
it. The page is report.html.jinja, beside this script.
"""
import csv
import io
import json
import math
import os
import sys

try:
    import jinja2
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
    from markupsafe import Markup
except ImportError as error:
    sys.exit(f"evaluation_report.py: {error}; install python3-jinja2 and python3-matplotlib")

MOST_ROWS = 40  # of the timeline
MOST_LINES = 10  # of the distances
MOST_POINTS = 2000  # of a line, about as many as a screen has columns
COLORS = {"CONTACT": "#c62828", "NEAR": "#f9a825", "UNKNOWN": "#bdbdbd", "ALLOWED": "#90caf9",
          "PASSED": "#6a1b9a"}
HERE = os.path.dirname(os.path.realpath(__file__))


def rows_in(path):
    """Yields the rows, for a recording of an hour may have millions."""
    with open(path, newline="", errors="replace") as file:
        yield from csv.DictReader(file)


def read_table(path):
    return list(rows_in(path))


def drawn(line):
    """Returns about MOST_POINTS of a line's (x, y). Of each stretch that it thins out it keeps the
    least y, the largest, and a gap (NaN) if there is one."""
    size = math.ceil(3 * len(line) / MOST_POINTS)
    if size <= 3:
        return line
    kept = []
    for begin in range(0, len(line), size):
        stretch = range(begin, min(begin + size, len(line)))
        known = [i for i in stretch if not math.isnan(line[i][1])]
        gap = [i for i in stretch if math.isnan(line[i][1])][:1]
        ends = [choose(known, key=lambda i: line[i][1]) for choose in (min, max) if known]
        kept += [line[i] for i in sorted({*ends, *gap})]
    return kept


def to_svg(figure):
    """Returns the figure as text that a template does not escape."""
    out = io.StringIO()
    figure.savefig(out, format="svg", bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)
    text = out.getvalue()
    return Markup(text[text.index("<svg"):])


def points_of(xs, ys):
    """Returns what is drawn of a line, as xs and ys."""
    return zip(*drawn(list(zip(xs, ys))))


def runs_of(frames):
    """{run: its rows}, in order."""
    runs = {}
    for row in frames:
        runs.setdefault(row["run"], []).append(row)
    return runs


def since(rows, start):
    return [float(row["stamp"]) - start for row in rows]


def plot_latency(runs):
    figure, axes = plt.subplots(figsize=(9, 3.2))
    for i, (name, rows) in enumerate(runs.items()):
        for column, style in (("detect_ms", "-"), ("round_trip_ms", ":")):
            times = sorted(float(row[column]) for row in rows)
            line = drawn([((k + 1) / len(times), ms) for k, ms in enumerate(times)])
            shares, times = zip(*line)
            label = f"{name}: " + ("detection" if style == "-" else "from host to host")
            axes.step(times, shares, style, where="post", color=f"C{i}", label=label)
    axes.set(xlabel="time of a cycle [ms]", ylabel="share of cycles", ylim=(0, 1.02))
    axes.set_xscale("log")
    axes.grid(alpha=.3, which="both")
    axes.legend(fontsize=8)
    return to_svg(figure)


def plot_pairs(runs, start):
    figure, axes = plt.subplots(figsize=(9, 3.2))
    for name, rows in runs.items():
        # Where a body was unknown, its pairs are missing, so the count would mislead.
        pairs = [math.nan if row["skipped"] else int(row["pairs"]) for row in rows]
        line, = axes.plot(*points_of(since(rows, start), pairs), lw=1, label=name)
        if "swept_pairs" in rows[0]:
            swept = [math.nan if row["swept_complete"] == "no" else int(row["swept_pairs"])
                     for row in rows]
            axes.plot(*points_of(since(rows, start), swept), ":", lw=1, color=line.get_color(),
                      label=f"{name}: since the cycle before")
    first = next(iter(runs.values()))
    unknown = [t for t, row in zip(since(first, start), first) if row["skipped"]]
    if unknown:
        axes.plot(*points_of(unknown, [0] * len(unknown)), "|", color="#888", ms=8,
                  label="some body unknown")
    axes.set(xlabel="time since the first cycle [s]", ylabel="triangle pairs")
    axes.set_ylim(bottom=0)
    axes.grid(alpha=.3)
    axes.legend(fontsize=8)
    return to_svg(figure)


def plot_timeline(links, run, start):
    """Returns the picture, or None if no bodies were ever in contact or near, and how many pairs of
    bodies are not shown. Those in contact longest come first."""
    rows = {}
    for row in links:
        if row["run"] == run:
            rows.setdefault((row["body_a"], row["body_b"]), []).append(row)

    def contact_cycles(stretches):
        return sum(int(s["cycles"]) for s in stretches
                   if s["state"] in ("CONTACT", "NEAR", "PASSED"))
    touched = sorted((item for item in rows.items() if contact_cycles(item[1]) > 0),
                     key=lambda item: (-contact_cycles(item[1]), item[0]))
    if not touched:
        return None, 0
    shown = touched[:MOST_ROWS]
    figure, axes = plt.subplots(figsize=(9, .9 + .26 * len(shown)))
    for y, (_, stretches) in enumerate(shown):
        for s in stretches:
            if s["state"] not in COLORS:
                continue
            begin, end = float(s["from"]) - start, float(s["to"]) - start
            if s["state"] == "PASSED":  # it lies before its stamp, and is too short for a bar
                axes.plot([begin, end], [y, y], "D-", color=COLORS["PASSED"], ms=5, clip_on=False)
                continue
            axes.barh(y, max(end - begin, .01), left=begin, height=.7, color=COLORS[s["state"]],
                      linewidth=0)
    axes.set_yticks(range(len(shown)))
    axes.set_yticklabels([" / ".join(bodies) for bodies, _ in shown], fontsize=8)
    axes.set_xlabel("time since the first cycle [s]")
    ends = [float(s[end]) - start for of in rows.values() for s in of for end in ("from", "to")]
    axes.set_xlim(min(0, *ends), max(ends) + .01)  # before 0: the clock went back
    axes.set_ylim(len(shown) - .5, -.5)
    axes.grid(alpha=.3, axis="x")
    handles = [plt.Rectangle((0, 0), 1, 1, color=color) for color in COLORS.values()]
    axes.legend(handles, [name.lower() for name in COLORS], fontsize=8,
                ncol=len(COLORS), loc="lower right", bbox_to_anchor=(1, 1), frameon=False)
    return to_svg(figure), len(touched) - len(shown)


def distances_of(distances, links, run):
    """{bodies: [(stamp, distance [m])]} of one run, ascending, of bodies that were ever near. The
    distance is NaN where it is not known: UNKNOWN, or farther apart than the margin (NONE)."""
    lines = {}
    for row in distances:
        if row["run"] == run:
            distance = float(row["distance"]) if row["distance"] else math.nan
            lines.setdefault((row["body_a"], row["body_b"]), []).append(
                (float(row["stamp"]), distance))
    lines = {bodies: line for bodies, line in lines.items()
             if any(distance > 0 for _, distance in line)}
    for row in links:
        bodies = row["body_a"], row["body_b"]
        if row["run"] == run and row["state"] in ("NONE", "UNKNOWN") and bodies in lines:
            lines[bodies].append((float(row["from"]), math.nan))
    return {bodies: sorted(line, key=lambda point: point[0]) for bodies, line in lines.items()}


def least_of(line):
    return min(distance for _, distance in line if not math.isnan(distance))


def plot_distances(lines, start):
    """Returns the picture, or None without a line, and how many pairs of bodies are not shown. Those
    that come nearest come first."""
    if not lines:
        return None, 0
    shown = sorted(lines.items(), key=lambda item: (least_of(item[1]), item[0]))[:MOST_LINES]
    figure, axes = plt.subplots(figsize=(9, 3.2))
    for bodies, line in shown:
        # A marker shows a distance that is known in one cycle alone.
        points = drawn(line)
        axes.plot([stamp - start for stamp, _ in points], [distance for _, distance in points],
                  ".-", ms=2, lw=1, label=" / ".join(bodies))
    axes.set(xlabel="time since the first cycle [s]", ylabel="least distance [m]")
    axes.set_ylim(bottom=0)
    axes.grid(alpha=.3)
    axes.legend(fontsize=8, ncol=2)
    return to_svg(figure), len(lines) - len(shown)


def least_rows(lines, start):
    """Returns (bodies, least distance, time) of each pair, the nearest first."""
    rows = []
    for bodies, line in lines.items():
        least = least_of(line)
        stamp = next(stamp for stamp, distance in line if distance == least)
        rows.append((" / ".join(bodies), least, stamp - start))
    return sorted(rows, key=lambda row: (row[1], row[0]))


def stages_of(rows):
    """In order of execution: columns of frames.csv."""
    titles = list(rows[0])
    columns = titles[titles.index("round_trip_ms") + 1:titles.index("other_ms")]
    return [column[:-len("_ms")] for column in columns]


def plot_stages(summary, names):
    figure, axes = plt.subplots(figsize=(9, .8 + .4 * len(summary["times"]["runs"])))
    colors = {name: plt.get_cmap("tab20")(i % 20) for i, name in enumerate(names)}
    for y, run in enumerate(summary["times"]["runs"]):
        left = 0
        for stage in names:
            ms = run["median_stages_ms"].get(stage, 0)
            axes.barh(y, ms, left=left, color=colors[stage], height=.6)
            left += ms
    axes.set_yticks(range(len(summary["times"]["runs"])))
    axes.set_yticklabels([run["name"] for run in summary["times"]["runs"]], fontsize=8)
    axes.invert_yaxis()
    axes.set_xlabel("median time of each stage [ms]")
    handles = [plt.Rectangle((0, 0), 1, 1, color=colors[name]) for name in names]
    axes.legend(handles, names, fontsize=8, ncol=8, loc="lower left", bbox_to_anchor=(0, 1),
                frameon=False)
    return to_svg(figure)


def template(name, *more_folders):
    """Loads a page, which escapes everything that it is given but Markup."""
    loader = jinja2.FileSystemLoader([*more_folders, HERE])
    return jinja2.Environment(loader=loader, autoescape=True, trim_blocks=True,
                              lstrip_blocks=True).get_template(name)


def write_whole(path, content):
    """Writes a file that gets its name only once it is complete."""
    part = f"{path}.{os.getpid()}.part"
    try:
        with open(part, "wb") as file:
            file.write(content)
        os.replace(part, path)
    except OSError:
        if os.path.exists(part):
            os.remove(part)
        raise


def plots_of(summary, runs, links, distances):
    """Returns the pictures of the page by their names; none if there was no cycle."""
    if not runs:
        return {}
    first = next(iter(runs))
    start = float(runs[first][0]["stamp"])
    timeline, more_bodies = plot_timeline(links, first, start)
    lines = distances_of(distances, links, first)
    near, more_lines = plot_distances(lines, start)
    return {"timeline": timeline, "more_bodies": more_bodies, "distances": near,
            "more_lines": more_lines, "least": least_rows(lines, start),
            "pairs": plot_pairs(runs, start), "latency": plot_latency(runs),
            "stages": plot_stages(summary, stages_of(runs[first]))}


def report(folder):
    with open(os.path.join(folder, "summary.json"), errors="replace") as file:
        summary = json.load(file)
    runs = runs_of(read_table(os.path.join(folder, "frames.csv")))
    links = read_table(os.path.join(folder, "links.csv"))
    distances = rows_in(os.path.join(folder, "distances.csv"))
    page = template("report.html.jinja").render(
        summary=summary, first=summary["runs"][0], plots=plots_of(summary, runs, links, distances),
        most_rows=MOST_ROWS, bags=", ".join(os.path.basename(bag) for bag in summary["bags"]))
    write_whole(os.path.join(folder, "report.html"), page.encode(errors="replace"))


if __name__ == "__main__":
    if "--help" in sys.argv or "-h" in sys.argv:
        print(__doc__)
        sys.exit(0)
    if len(sys.argv) != 2:
        print("evaluation_report.py: one folder is expected (see --help)", file=sys.stderr)
        sys.exit(2)
    plt.rcParams.update({"svg.hashsalt": "evaluate_bag", "axes.spines.top": False,
                         "axes.spines.right": False})
    try:
        report(sys.argv[1])
    except OSError as error:
        sys.exit(f"evaluation_report.py: {error}")
