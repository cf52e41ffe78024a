"""Writes fleet.csv and fleet.json, the results of all bags for programs."""
import csv
import io
import json
import os

from evaluation_report import write_whole
from fleet.changes import read_summary
from fleet.evaluation import BROKEN, PASSED, REFUSED, UNUSABLE

CRASHED = "crashed"
NOT_WHOLE = (UNUSABLE, REFUSED, CRASHED)
COLUMNS = ("bag", "state", "cycles", "complete_cycles", "pairs", "expectations", "broken",
           "detect_median_ms", "detect_p95_ms", "detect_most_ms", "changes", "not_allowed",
           "seconds", "machine", "identity", "message")
TABLES = ("fleet.csv", "fleet.json", "index.html")


def _numbers(folder):
    """Returns the figures of the bag's first run."""
    summary = read_summary(folder)
    run, times = summary["runs"][0], summary["times"]["runs"][0]["detect_ms"]
    return {"cycles": summary["cycles"], "complete_cycles": run["complete_cycles"],
            "pairs": run["pairs"], "expectations": summary["expectations"],
            "configuration_hash": summary["configuration_hash"], "detect_ms": times}


def bag_entry(out, record, changes):
    """Returns the entry of a bag in fleet.json. `record` is that of its job. `changes` is a list of
    (Change, allowed), or None without a baseline."""
    entry = {"bag": record["name"], "path": record["bag"], "state": record["state"],
             "message": record["message"], "warning": record.get("warning", ""),
             "seconds": record.get("seconds"),
             "machine": record.get("machine", ""), "identity": record.get("identity_hash", ""),
             "was_there": record.get("was_there", False), "folder": None, "cycles": 0,
             "complete_cycles": 0, "pairs": 0, "expectations": [], "detect_ms": None}
    folder = os.path.join("bags", record["name"])
    if record["state"] in (PASSED, BROKEN, UNUSABLE):
        entry.update(_numbers(os.path.join(out, folder)), folder=folder)
    if changes is not None:
        entry["changes"] = [{"kind": change.kind, "bodies": change.bodies, "text": change.text,
                             "allowed": allowed} for change, allowed in changes]
    return entry


def exit_code(fleet):
    """Incomplete evaluations take precedence over their findings."""
    if any(bag["state"] in NOT_WHOLE for bag in fleet["bags"]):
        return 2
    broken = any(bag["state"] == BROKEN for bag in fleet["bags"])
    return 1 if broken or fleet["not_allowed"] else 0


def _row(bag):
    ms = bag["detect_ms"] or {"median": "", "p95": "", "most": ""}
    changes = bag.get("changes")
    return (bag["bag"], bag["state"], bag["cycles"], bag["complete_cycles"], bag["pairs"],
            len(bag["expectations"]), sum(not e["holds"] for e in bag["expectations"]),
            ms["median"], ms["p95"], ms["most"], "" if changes is None else len(changes),
            "" if changes is None else sum(not change["allowed"] for change in changes),
            bag["seconds"], bag["machine"], bag["identity"],
            "; ".join(text for text in (bag["message"], bag["warning"]) if text))


def write_file(path, content):
    """Writes a file that gets its name only once it is complete. An OSError names it, which that of
    a full disk does not."""
    try:
        write_whole(path, content)
    except OSError as error:
        raise OSError(error.errno, error.strerror, path) from error


def write_tables(out, fleet):
    text = io.StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(COLUMNS)
    table.writerows(_row(bag) for bag in fleet["bags"])
    write_file(os.path.join(out, "fleet.csv"), text.getvalue().encode(errors="replace"))
    write_file(os.path.join(out, "fleet.json"),
               json.dumps(fleet, indent=1, sort_keys=True).encode(errors="replace"))
