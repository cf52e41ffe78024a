"""index.html: the fleet for people, in the style of a bag's own report."""
import html
import os
from urllib.parse import quote

from evaluation_report import STYLE, plt, table, verdict, write_whole
from fleet.evaluation import PASSED
from fleet.latency import Latency

MOST_OPEN = 40  # rows of a table that are not folded
MOST_CHANGES = 500
MOST_EXPECTATIONS = 40
CROSS = "\u2717"
FLEET_STYLE = """
body { max-width: 76rem; } svg { max-width: 62rem; } a { white-space: nowrap; }
summary { cursor: pointer; }
.matrix td + td, .matrix th + th { text-align: center; padding: .25rem .6rem; }
"""


def _link(bag):
    name = html.escape(bag["bag"])
    if not bag["folder"]:
        return name
    file = "report.html" if bag["has_report"] else "summary.json"
    return f'<a href="{html.escape(quote(bag["folder"] + "/" + file))}">{name}</a>'


def _long_table(titles, rows):
    """What is most of interest comes first; what is beyond MOST_OPEN is folded."""
    more = rows[MOST_OPEN:]
    return table(titles, rows[:MOST_OPEN]) + (
        f"<details><summary>And {len(more)} more</summary>{table(titles, more)}</details>"
        if more else "")


def _bags_table(fleet):
    titles = ["bag", "", "cycles", "complete", "pairs", "detect, median [ms]", "most [ms]"]
    with_baseline = fleet["baseline"] is not None
    rows = []
    for bag in sorted(fleet["bags"], key=lambda bag: (bag["state"] == PASSED, _is_good(bag))):
        ms = bag["detect_ms"]
        row = [_link(bag), verdict(bag["state"] == PASSED, "passed", bag["state"])]
        row += [bag["cycles"], bag["complete_cycles"], bag["pairs"], f'{ms["median"]:.3f}',
                f'{ms["most"]:.3f}'] if ms else [""] * 5
        if with_baseline:
            row.append(_changes_cell(bag))
        rows.append(row + [html.escape("" if bag["state"] == PASSED else bag["message"])])
    return _long_table(titles + (["changes"] if with_baseline else []) + ["why"], rows)


def _is_good(bag):
    return bag["state"] == PASSED and all(c["allowed"] for c in bag.get("changes", ()))


def _changes_cell(bag):
    changes = [c for c in bag["changes"] if c["kind"] != "latency" or not c["allowed"]]
    if not changes:
        return "0" if bag["folder"] else ""
    count = str(len(changes))
    return verdict(all(c["allowed"] for c in changes), count, count)


def _cell(expectation):
    if expectation is None:
        return ""
    if expectation["holds"]:
        return verdict(True, "\u2713", "")
    return f'<span title="{html.escape(expectation["failure"])}">{verdict(False, "", CROSS)}</span>'


def _matrix(fleet):
    """Bags that break some expectation come first, and expectations that are broken."""
    broken, texts = set(), {}
    for bag in fleet["bags"]:
        for e in bag["expectations"]:
            texts[e["text"]] = True
            if not e["holds"]:
                broken.add(e["text"])
    shown = sorted(texts, key=lambda text: text not in broken)[:MOST_EXPECTATIONS]
    rows = []
    for bag in sorted((bag for bag in fleet["bags"] if bag["folder"]),
                      key=lambda bag: all(e["holds"] for e in bag["expectations"])):
        of_text = {e["text"]: e for e in bag["expectations"]}
        rows.append([_link(bag), *(_cell(of_text.get(text)) for text in shown)])
    names = "".join(f"<li>{html.escape(text)}</li>" for text in shown)
    more = len(texts) - len(shown)
    return (f"<ol>{names}</ol>" + (f"<p>And {more} more in fleet.json.</p>" if more > 0 else "")
            + '<div class="matrix">'
            + _long_table(["bag", *(str(i + 1) for i in range(len(shown)))], rows) + "</div>")


def _changes_table(fleet):
    changes = [(_link(bag), c) for bag in fleet["bags"] for c in bag["changes"]]
    changes += [(html.escape(c["bag"]), c) for c in fleet["bags_gone"]]
    changes.sort(key=lambda item: item[1]["allowed"])
    rows = [[bag, html.escape(" / ".join(c["bodies"])), c["kind"],
             html.escape(c["text"]), verdict(c["allowed"], "allowed", "NOT ALLOWED")]
            for bag, c in changes[:MOST_CHANGES]]
    more = len(changes) - MOST_CHANGES
    return _long_table(["bag", "bodies", "change", "", ""], rows) + (
        f"<p>And {more} more in fleet.json.</p>" if more > 0 else "")


def _latency_table(latency):
    shares = {"median [ms]": .5, "p95": .95, "p99": .99, "most": 1}
    return table(["cycles", *shares], [[len(latency.times), *(
        f"{latency.quantile(share):.3f}" for share in shares.values())]])


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
    latency = Latency(out, fleet["bags"])
    if latency.times:
        parts += ["<h2>Latency</h2>", _latency_table(latency), latency.plot(),
                  "<h2>Slowest cycles</h2>",
                  table(["detect [ms]", "bag", "stamp"],
                        [[f"{ms:.3f}", _link(bag), stamp] for ms, bag, stamp in latency.slowest])]
    parts += ["<h2>What was evaluated</h2>", _about_table(fleet)]
    text = ('<!DOCTYPE html><meta charset="utf-8"><title>Contacts in bags</title>'
            f"<style>{STYLE}{FLEET_STYLE}</style>" + "\n".join(parts) + "\n")
    write_whole(os.path.join(out, "index.html"), text.encode(errors="replace"))
