#!/usr/bin/python3
"""Turns the tables of evaluate_bag into report.html, one file with its plots inside.

Usage: evaluation_report.py FOLDER, with frames.csv, links.csv and summary.json in it.
"""
import csv
import html
import io
import json
import math
import os
import sys

try:
    import matplotlib
    matplotlib.use("svg")
    import matplotlib.pyplot as plt
except ImportError as error:
    sys.exit(f"evaluation_report.py: {error}; install python3-matplotlib")

MOST_ROWS = 40  # of the timeline
COLORS = {"CONTACT": "#c62828", "NEAR": "#f9a825", "UNKNOWN": "#bdbdbd", "ALLOWED": "#90caf9",
          "PASSED": "#6a1b9a"}
STYLE = """
body { font: 15px/1.45 sans-serif; max-width: 62rem; margin: 2rem auto; padding: 0 1rem;
       color: #222; }
table { border-collapse: collapse; margin: .5rem 0 1.5rem; }
td, th { padding: .25rem .8rem .25rem 0; text-align: left; border-bottom: 1px solid #ddd;
         font-variant-numeric: tabular-nums; vertical-align: top; }
.bad { color: #c62828; font-weight: bold; } .good { color: #2e7d32; font-weight: bold; }
svg { width: 100%; height: auto; } h2 { margin-top: 2rem; } code { background: #f4f4f4; }
"""


def read_table(path):
    with open(path, newline="", errors="replace") as file:
        return list(csv.DictReader(file))


def to_svg(figure):
    out = io.StringIO()
    figure.savefig(out, format="svg", bbox_inches="tight", metadata={"Date": None})
    plt.close(figure)
    text = out.getvalue()
    return text[text.index("<svg"):]


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
            shares = [(k + 1) / len(times) for k in range(len(times))]
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
        # Where a body was unknown, its pairs are missing, and the rest is no number of pairs.
        pairs = [math.nan if row["skipped"] else int(row["pairs"]) for row in rows]
        line, = axes.plot(since(rows, start), pairs, lw=1, label=name)
        if "swept_pairs" in rows[0]:
            swept = [math.nan if row["swept_complete"] == "no" else int(row["swept_pairs"])
                     for row in rows]
            axes.plot(since(rows, start), swept, ":", lw=1, color=line.get_color(),
                      label=f"{name}: since the cycle before")
    first = next(iter(runs.values()))
    unknown = [t for t, row in zip(since(first, start), first) if row["skipped"]]
    if unknown:
        axes.plot(unknown, [0] * len(unknown), "|", color="#888", ms=8, label="some body unknown")
    axes.set(xlabel="time since the first cycle [s]", ylabel="triangle pairs")
    axes.set_ylim(bottom=0)
    axes.grid(alpha=.3)
    axes.legend(fontsize=8)
    return to_svg(figure)


def plot_timeline(links, run, start):
    """Pairs of bodies that were ever in contact or near, those in contact longest first."""
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
        return "<p>No pair of bodies was ever in contact or near.</p>"
    shown = touched[:MOST_ROWS]
    figure, axes = plt.subplots(figsize=(9, .9 + .26 * len(shown)))
    for y, (_, stretches) in enumerate(shown):
        for s in stretches:
            if s["state"] not in COLORS:
                continue
            begin, end = float(s["from"]) - start, float(s["to"]) - start
            if s["state"] == "PASSED":  # it was before its stamp, for a time that no bar has
                axes.plot([begin, end], [y, y], "D-", color=COLORS["PASSED"], ms=5, clip_on=False)
                continue
            axes.barh(y, max(end - begin, .01), left=begin, height=.7, color=COLORS[s["state"]],
                      linewidth=0)
    axes.set_yticks(range(len(shown)))
    axes.set_yticklabels([" / ".join(bodies) for bodies, _ in shown], fontsize=8)
    axes.set_xlabel("time since the first cycle [s]")
    axes.set_xlim(0, max(float(s["to"]) for of in rows.values() for s in of) - start + .01)
    axes.set_ylim(len(shown) - .5, -.5)
    axes.grid(alpha=.3, axis="x")
    handles = [plt.Rectangle((0, 0), 1, 1, color=color) for color in COLORS.values()]
    axes.legend(handles, [name.lower() for name in COLORS], fontsize=8,
                ncol=len(COLORS), loc="lower right", bbox_to_anchor=(1, 1), frameon=False)
    more = len(touched) - len(shown)
    return to_svg(figure) + (f"<p>And {more} more pairs of bodies.</p>" if more > 0 else "")


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


def table(titles, rows):
    head = "".join(f"<th>{html.escape(title)}</th>" for title in titles)
    body = "".join("<tr>" + "".join(f"<td>{cell}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><tr>{head}</tr>{body}</table>"


def verdict(good, yes, no):
    return f'<span class="{"good" if good else "bad"}">{html.escape(yes if good else no)}</span>'


def runs_table(summary):
    times = {run["name"]: run for run in summary["times"]["runs"]}
    rows = []
    for run in summary["runs"]:
        ms = times[run["name"]]["detect_ms"]
        guaranteed = run["guaranteed_cycles"] == run["cycles"]
        rows.append([html.escape(run["name"]), run["backend"], run["pairs"],
                     f'{run["whole_cycles"]} of {run["cycles"]}',
                     "yes" if guaranteed else "not by this setting", f'{ms["median"]:.3f}',
                     f'{ms["p95"]:.3f}', f'{ms["most"]:.3f}'])
    return table(["run", "ran on", "pairs", "cycles with nothing left out", "every pair guaranteed",
                  "detect, median [ms]", "p95", "most"],
                 rows)


def steps_table(summary):
    rows = [[html.escape(run["name"]), swept["pairs"], swept["passed"],
             f'{swept["complete_cycles"]} of {swept["cycles_with_a_step"]}',
             swept["pairs_within_pad"], f'{swept["most_pad_m"]:.3g}',
             f'{times["swept_ms"]["median"]:.3f}' if "swept_ms" in times else ""]
            for run, times in zip(summary["runs"], summary["times"]["runs"])
            for swept in [run["swept"]]]
    return table(["run", "pairs", "PASSED", "complete, of cycles with a step",
                  "within the pad alone", "largest pad [m]", "median [ms]"], rows)


def unknown_table(run):
    reasons = run["unknown"]
    more = len(reasons) - MOST_ROWS
    return table(["UNKNOWN since", "cycles", "from", "to"],
                 [[html.escape(r["reason"]), r["cycles"], r["from"], r["to"]]
                  for r in reasons[:MOST_ROWS]]) + (
                      f"<p>And {more} more reasons in summary.json.</p>" if more > 0 else "")


def comparisons_table(summary):
    rows = []
    for c in summary["comparisons"]:
        same = c["cycles_that_differ"] == 0
        word = "DISAGREE" if c["must_agree"] else "differ"
        rows.append([html.escape(f'{c["first"]} and {c["second"]}'),
                     verdict(same or not c["must_agree"], "the same pairs" if same else word, word),
                     c["cycles_that_differ"], c["only_first"], c["only_second"],
                     html.escape(c["example"])])
    return table(["runs", "", "cycles that differ", "only the first has", "only the second",
                  "for example"], rows)


def expectations_table(summary):
    return table(["expectation", "", ""],
                 [[html.escape(e["text"]), verdict(e["holds"], "holds", "FAILS"),
                   html.escape(e["failure"])] for e in summary["expectations"]])


def poses_text(poses):
    by_joints = poses["joint_states_frames"]
    text = f'{poses["tf_frames"]} frames from TF'
    return text + (f", {len(by_joints)} from /joint_states and the URDF: " + ", ".join(by_joints)
                   if by_joints else "")


def about_table(summary):
    machine, configuration = summary["machine"], summary["configuration"]
    objects = ", ".join(f'{o["name"]} on {o["topic"]}' for o in configuration["objects"])
    rows = [("Robot", configuration["robot"] + f', {len(configuration["links"])} links'),
            ("Objects", objects), ("Reference frame", configuration["reference_frame"]),
            ("Poses", poses_text(summary["poses"])),
            ("Pairs looked at", ", ".join(configuration["pair_classes"])),
            ("Configuration", summary["configuration_hash"]),
            ("Messages", ", ".join(f'{name}: {topic["messages"]}'
                                   for name, topic in summary["topics"].items())),
            ("Machine", ", ".join([machine["cpu"], f'{machine["cores"]} cores'] + machine["gpus"])),
            ("Speed", f'{summary["times"]["cycles_per_s"]:.1f} cycles a second, '
                      f'{summary["times"]["elapsed_s"]:.1f} s in all')]
    damage = summary["problem"] or (f'{summary["damaged_messages"]} messages'
                                    if summary["damaged_messages"] else "")
    if damage:
        rows.insert(0, ("Damaged", damage + "; what could be read is below"))
    if "motion" in configuration:
        rows.insert(3, ("Motion", f'{configuration["motion"]}, links\' ways to within '
                                  f'{configuration["swept_tolerance_m"]:g} m'))
    return table(["", ""], [[html.escape(name), html.escape(text)] for name, text in rows])


def write_whole(path, content):
    """The file has its name only once it is whole."""
    part = f"{path}.{os.getpid()}.part"
    try:
        with open(part, "wb") as file:
            file.write(content)
        os.replace(part, path)
    except OSError:
        if os.path.exists(part):
            os.remove(part)
        raise


def report(folder):
    with open(os.path.join(folder, "summary.json"), errors="replace") as file:
        summary = json.load(file)
    runs = runs_of(read_table(os.path.join(folder, "frames.csv")))
    links = read_table(os.path.join(folder, "links.csv"))
    bags = ", ".join(os.path.basename(bag) for bag in summary["bags"])
    parts = [f"<h1>Contacts in {html.escape(bags)}</h1>",
             f'<p>{summary["cycles"]} cycles. '
             + verdict(summary["passed"], summary["verdict"], summary["verdict"])
             + "</p>", runs_table(summary)]
    if summary["runs"][0]["unknown"]:
        parts += ["<h2>What was UNKNOWN</h2>", f'<p>{html.escape(summary["runs"][0]["name"])}</p>',
                  unknown_table(summary["runs"][0])]
    if "swept" in summary["runs"][0]:
        parts += ["<h2>Between the cycles</h2>", steps_table(summary)]
    if summary["comparisons"]:
        parts += ["<h2>Runs compared as sets</h2>", comparisons_table(summary)]
    if summary["expectations"]:
        parts += ["<h2>Expectations</h2>", expectations_table(summary)]
    if runs:
        first = next(iter(runs))
        start = float(runs[first][0]["stamp"])
        parts += [f"<h2>Who touches whom</h2><p>{html.escape(first)}</p>",
                  plot_timeline(links, first, start),
                  "<h2>Pairs over time</h2>", plot_pairs(runs, start),
                  "<h2>Latency</h2>", plot_latency(runs), plot_stages(summary, stages_of(runs[first]))]
    parts += ["<h2>What was evaluated</h2>", about_table(summary)]
    text = (f'<!DOCTYPE html><meta charset="utf-8"><title>{html.escape(bags)}</title>'
            f"<style>{STYLE}</style>" + "\n".join(parts) + "\n")
    write_whole(os.path.join(folder, "report.html"), text.encode(errors="replace"))


if __name__ == "__main__":
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    plt.rcParams.update({"svg.hashsalt": "evaluate_bag", "axes.spines.top": False,
                         "axes.spines.right": False})
    try:
        report(sys.argv[1])
    except OSError as error:
        sys.exit(f"evaluation_report.py: {error}")
