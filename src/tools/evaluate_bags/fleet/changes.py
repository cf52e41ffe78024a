"""Finds what changed in a bag's contacts between two evaluations, by the tables of their first
runs."""
import collections
import csv
import json
import os

from fleet.pair_hashes import read_pair_hashes

TOUCHING = ("CONTACT", "PASSED")

# kind: one of KINDS; amount: seconds of began and ended, cycles of moved, the ratio of latency.
Change = collections.namedtuple("Change", "bag kind bodies text amount")
KINDS = ("appeared", "vanished", "began", "ended", "moved", "unknown", "expectation", "latency",
         "bag")


def read_summary(folder):
    with open(os.path.join(folder, "summary.json"), errors="replace") as file:
        return json.load(file)


def _stretches(folder):
    """Returns {(body_a, body_b): {state: [(from, to)]}} in the order of time. Stamps are text."""
    found, first = {}, None
    with open(os.path.join(folder, "links.csv"), newline="", errors="replace") as file:
        for row in csv.DictReader(file):
            first = first or row["run"]
            if row["run"] != first:
                continue
            state = TOUCHING[0] if row["state"] in TOUCHING else row["state"]
            states = found.setdefault((row["body_a"], row["body_b"]), {})
            states.setdefault(state, []).append((row["from"], row["to"]))
    for states in found.values():
        for stretches in states.values():
            stretches.sort(key=lambda stretch: float(stretch[0]))
    return found


def _overlap(a, b):
    return float(a[0]) <= float(b[1]) and float(b[0]) <= float(a[1])


def _of_stretches(old, new):
    """Yields (kind, text, amount) for the contacts of two bodies."""
    for stretch in new:
        if not any(_overlap(stretch, other) for other in old):
            yield "appeared", f"contact from {stretch[0]} to {stretch[1]}", 0
    for stretch in old:
        others = [other for other in new if _overlap(stretch, other)]
        if not others:
            yield "vanished", f"contact from {stretch[0]} to {stretch[1]}", 0
            continue
        for kind, was, now in (("began", stretch[0], others[0][0]),
                               ("ended", stretch[1], others[-1][1])):
            if was != now:
                by = float(now) - float(was)
                yield kind, f"at {now}, before at {was} ({by:+.3f} s)", abs(by)
        if len(others) > 1:
            yield "ended", f"{len(others)} contacts where one was, from {others[0][0]} to " \
                           f"{others[-1][1]}", float("inf")


def _of_pairs(old, new):
    """Finds cycles in which other triangles touch. A cycle with contact in only one of the runs
    does not count: the contact began, ended, appeared or vanished, which is another kind of
    change."""
    moved = [stamp for stamp in sorted(set(old) & set(new), key=float)
             if sorted(old[stamp]) != sorted(new[stamp])]
    if moved:
        text = f"other triangles; cycles: {len(moved)}, the first at {moved[0]}"
        yield "moved", text, len(moved)


def _of_unknown(old, new):
    """Finds what was judged in one of the runs only."""
    if old and not new:
        if TOUCHING[0] not in old:  # otherwise the contact has vanished, which is said
            yield "unknown", "the two are no longer monitored", 0
        return
    for state in ("UNKNOWN", "ALLOWED"):
        was, now = old.get(state, []), new.get(state, [])
        if was == now:
            continue
        text = f"{len(now)} times, before {len(was)}"
        changed = sorted(set(now) ^ set(was), key=lambda stretch: float(stretch[0]))
        yield "unknown", f"{state} {text}; the first that differs: from {changed[0][0]} to " \
                         f"{changed[0][1]}", 0


def _of_expectations(old, new):
    was = {e["text"]: e["holds"] for e in old["expectations"]}
    now = {e["text"]: e["holds"] for e in new["expectations"]}
    for text in sorted(set(was) | set(now)):
        if was.get(text) != now.get(text):
            words = {True: "kept", False: "broken", None: "not asked"}
            yield "expectation", f"{text}: {words[now.get(text)]}, before {words[was.get(text)]}"


def _median_ms(summary):
    runs = summary["times"]["runs"]
    return runs[0]["detect_ms"]["median"] if runs else 0


def changes_of(bag, old_folder, new_folder):
    """Returns the changes of a bag: first those of pairs of bodies, then those of the whole bag."""
    found = []
    old_links, new_links = _stretches(old_folder), _stretches(new_folder)
    old_pairs, new_pairs = read_pair_hashes(old_folder), read_pair_hashes(new_folder)
    for bodies in sorted(set(old_links) | set(new_links) | set(old_pairs) | set(new_pairs)):
        old, new = old_links.get(bodies, {}), new_links.get(bodies, {})
        for kind, text, amount in (
                *_of_stretches(old.get(TOUCHING[0], []), new.get(TOUCHING[0], [])),
                *_of_pairs(old_pairs.get(bodies, {}), new_pairs.get(bodies, {})),
                *_of_unknown(old, new)):
            found.append(Change(bag, kind, bodies, text, amount))
    old, new = read_summary(old_folder), read_summary(new_folder)
    for kind, text in _of_expectations(old, new):
        found.append(Change(bag, kind, (), text, 0))
    was, now = _median_ms(old), _median_ms(new)
    if was > 0:
        found.append(Change(bag, "latency", (), f"median {now:.3f} ms, before {was:.3f} ms "
                            f"(ratio {now / was:.2f})", now / was))
    return found
