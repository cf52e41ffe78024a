"""index.html: the fleet for people, in the style of a bag's own report."""
import csv
import html
import os
from urllib.parse import quote

from evaluation_report import STYLE, plt, table, to_svg, verdict, write_whole
from fleet.evaluation import PASSED

MOST_SLOW_CYCLES = 20
MOST_CHANGES = 500
MOST_EXPECTATIONS = 40
MOST_POINTS = 2000  # of a curve
MATRIX_STYLE = """
.matrix td + td, .matrix th + th { text-align: center; padding: .1rem .6rem; }
"""


def _link(bag):
    name = html.escape(bag["bag"])
    if not bag["folder"]:
        return name
    file = "report.html" if bag["has_report"] else "summary.json"
    return f'<a href="{html.escape(quote(bag["folder"] + "/" + file))}">{name}</a>'


def _of_cycles(out, bags):
    """[(milliseconds, bag, stamp)] of the first run of each."""
    found = []
    for bag in bags:
        if not bag["folder"]:
            continue
        first = None
        with open(os.path.join(out, bag["folder"], "frames.csv"), newline="",
                  errors="replace") as file:
            for row in csv.DictReader(file):
                first = first or row["run"]
                if row["run"] == first:
                    found.append((float(row["detect_ms"]), bag, row["stamp"]))
    return found


def _plot_latency(cycles):
    figure, axes = plt.subplots(figsize=(9, 3.2))
    times = sorted(ms for ms, _, _ in cycles)
    shown = sorted({round(k * (len(times) - 1) / MOST_POINTS) for k in range(MOST_POINTS + 1)})
    axes.step([times[k] for k in shown], [(k + 1) / len(times) for k in shown], where="post")
    axes.set(xlabel="time of a cycle [ms]", ylabel="share of all cycles", ylim=(0, 1.02))
    axes.set_xscale("log")
    axes.grid(alpha=.3, which="both")
    return to_svg(figure)


def _bags_table(fleet):
    titles = ["bag", "", "cycles", "complete", "pairs", "detect, median [ms]", "most"]
    with_baseline = fleet["baseline"] is not None
    rows = []
    for bag in fleet["bags"]:
        ms = bag["detect_ms"]
        row = [_link(bag), verdict(bag["state"] == PASSED, "passed", bag["state"]), bag["cycles"],
               bag["complete_cycles"], bag["pairs"], f'{ms["median"]:.3f}' if ms else "",
               f'{ms["most"]:.3f}' if ms else ""]
        if with_baseline:
            changes = [c for c in bag["changes"] if c["kind"] != "latency" or not c["allowed"]]
            count = str(len(changes))
            nothing = not bag["folder"] and not changes
            row.append("" if nothing else verdict(all(c["allowed"] for c in changes), count, count))
        rows.append(row + [html.escape("" if bag["state"] == PASSED else bag["message"])])
    return table(titles + (["changes"] if with_baseline else []) + ["why"], rows)


def _matrix(fleet):
    texts = []
    for bag in fleet["bags"]:
        texts += [e["text"] for e in bag["expectations"] if e["text"] not in texts]
    shown = texts[:MOST_EXPECTATIONS]
    head = "<th></th>" + "".join(f"<th>{i + 1}</th>" for i in range(len(shown)))
    names = "".join(f"<li>{html.escape(text)}</li>" for text in shown)
    rows = []
    for bag in fleet["bags"]:
        of_text = {e["text"]: e for e in bag["expectations"]}
        cells = []
        for text in shown:
            e = of_text.get(text)
            cell = "" if e is None else (
                f'<span title="{html.escape(e["failure"])}">'
                + verdict(e["holds"], "\u2713", "\u2717") + "</span>")
            cells.append(f"<td>{cell}</td>")
        rows.append(f"<tr><td>{_link(bag)}</td>{''.join(cells)}</tr>")
    more = len(texts) - len(shown)
    return (f'<ol>{names}</ol><table class="matrix"><tr>{head}</tr>{"".join(rows)}</table>'
            + (f"<p>And {more} more expectations in fleet.json.</p>" if more > 0 else ""))


def _changes_table(fleet):
    changes = [(bag["bag"], c) for bag in fleet["bags"] for c in bag["changes"]]
    changes += [(c["bag"], c) for c in fleet["bags_gone"]]
    changes.sort(key=lambda item: item[1]["allowed"])
    rows = [[html.escape(bag), html.escape(" / ".join(c["bodies"])), c["kind"],
             html.escape(c["text"]), verdict(c["allowed"], "allowed", "NOT ALLOWED")]
            for bag, c in changes[:MOST_CHANGES]]
    more = len(changes) - MOST_CHANGES
    return table(["bag", "bodies", "change", "", ""], rows) + (
        f"<p>And {more} more in fleet.json.</p>" if more > 0 else "")


def _about_table(fleet):
    seconds = fleet["times"]["elapsed_s"]
    rows = [("Options", " ".join(fleet["arguments"])), ("Version", fleet["version"]),
            ("Machines", ", ".join(fleet["machines"])),
            ("Bags", f'{len(fleet["bags"])}, of which {fleet["were_there"]} were there already'),
            ("Time", f"{seconds:.1f} s")]
    if fleet["baseline"]:
        rows.append(("Baseline", fleet["baseline"]))
    return table(["", ""], [[html.escape(name), html.escape(text)] for name, text in rows])


def write_report(out, fleet):
    plt.rcParams.update({"svg.hashsalt": "evaluate_bags", "axes.spines.top": False,
                         "axes.spines.right": False})
    for bag in fleet["bags"]:
        bag["has_report"] = bool(bag["folder"]) and os.path.exists(
            os.path.join(out, bag["folder"], "report.html"))
    parts = [f'<h1>Contacts in {len(fleet["bags"])} bags</h1>',
             f'<p>{verdict(fleet["exit_code"] == 0, fleet["verdict"], fleet["verdict"])}</p>',
             _bags_table(fleet)]
    if any(bag["expectations"] for bag in fleet["bags"]):
        parts += ["<h2>Expectations</h2>", _matrix(fleet)]
    if fleet["baseline"] is not None:
        parts += ["<h2>What changed</h2>", _changes_table(fleet)]
    cycles = _of_cycles(out, fleet["bags"])
    if cycles:
        slowest = sorted(cycles, key=lambda c: (-c[0], c[1]["bag"], c[2]))[:MOST_SLOW_CYCLES]
        parts += ["<h2>Latency</h2>", _plot_latency(cycles), "<h2>Slowest cycles</h2>",
                  table(["detect [ms]", "bag", "stamp"],
                        [[f"{ms:.3f}", _link(bag), stamp] for ms, bag, stamp in slowest])]
    parts += ["<h2>What was evaluated</h2>", _about_table(fleet)]
    text = ('<!DOCTYPE html><meta charset="utf-8"><title>Contacts in bags</title>'
            f"<style>{STYLE}{MATRIX_STYLE}</style>" + "\n".join(parts) + "\n")
    write_whole(os.path.join(out, "index.html"), text.encode(errors="replace"))
