"""Writes index.html, the results of all bags for people. The page is index.html.jinja."""
import os

from evaluation_report import plt, template
from fleet.evaluation import PASSED
from fleet.latency import Latency
from fleet.tables import write_file

MOST_OPEN = 40  # rows of a table that are not folded
MOST_CHANGES = 500
MOST_EXPECTATIONS = 40


def _describe(bag, out):
    """Adds what the page shows of a bag. Latency counts as a change only where it is not allowed."""
    folder = bag["folder"]
    bag["has_report"] = bool(folder) and os.path.exists(os.path.join(out, folder, "report.html"))
    changes = [c for c in bag.get("changes", ()) if c["kind"] != "latency" or not c["allowed"]]
    bag["change_count"] = len(changes)
    bag["is_allowed"] = all(c["allowed"] for c in changes)
    bag["is_kept"] = all(e["holds"] for e in bag["expectations"])


def write_report(out, fleet):
    plt.rcParams.update({"svg.hashsalt": "evaluate_bags", "axes.spines.top": False,
                         "axes.spines.right": False})
    bags = fleet["bags"]
    for bag in bags:
        _describe(bag, out)
    broken = {e["text"] for bag in bags for e in bag["expectations"] if not e["holds"]}
    texts = sorted(dict.fromkeys(e["text"] for bag in bags for e in bag["expectations"]),
                   key=lambda text: text not in broken)
    changes = [dict(c, of=bag) for bag in bags for c in bag.get("changes", ())]
    changes += [dict(c, of={"bag": c["bag"], "folder": None}) for c in fleet["bags_gone"]]
    changes.sort(key=lambda change: change["allowed"])
    page = template("index.html.jinja", os.path.dirname(os.path.realpath(__file__))).render(
        fleet=fleet, latency=Latency(out, bags), most_open=MOST_OPEN,
        bags=sorted(bags, key=lambda bag: (bag["state"] == PASSED, bag["is_allowed"])),
        expectations=texts[:MOST_EXPECTATIONS], more_expectations=len(texts) - MOST_EXPECTATIONS,
        matrix=sorted((bag for bag in bags if bag["folder"]), key=lambda bag: bag["is_kept"]),
        with_baseline=fleet["baseline"] is not None, changes=changes[:MOST_CHANGES],
        more_changes=len(changes) - MOST_CHANGES)
    write_file(os.path.join(out, "index.html"), page.encode(errors="replace"))
