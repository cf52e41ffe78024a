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
# A time in which two bodies kept one state. Stamps are text.
Stretch = collections.namedtuple("Stretch", "episode begin end cycles")
KINDS = ("appeared", "vanished", "began", "ended", "moved", "unknown", "expectation", "latency",
         "bag")


def read_summary(folder):
    with open(os.path.join(folder, "summary.json"), errors="replace") as file:
        return json.load(file)


def _stretches(folder, run):
    """Returns {(body_a, body_b): {state: [Stretch]}} of a run. The rows of two bodies are in the
    order of their cycles; an episode begins where the clock goes back."""
    found, last = {}, {}
    with open(os.path.join(folder, "links.csv"), newline="", errors="replace") as file:
        for row in csv.DictReader(file):
            if row["run"] != run:
                continue
            bodies = (row["body_a"], row["body_b"])
            episode, end = last.get(bodies, (0, row["from"]))
            if float(row["from"]) < float(end):
                episode += 1
            last[bodies] = (episode, row["to"])
            state = TOUCHING[0] if row["state"] in TOUCHING else row["state"]
            found.setdefault(bodies, {}).setdefault(state, []).append(
                Stretch(episode, row["from"], row["to"], int(row["cycles"])))
    return found


def _by_time(stretch):
    return stretch[0], float(stretch[1])


def _overlapping(old, new):
    """Returns [([old stretches], [new ones])], where those of an entry overlap. Two stretches of
    one run never do, so mostly an entry has one of each."""
    groups, last = [], (-1, 0.0)
    every = [(stretch, side) for side, of in enumerate((old, new)) for stretch in of]
    for stretch, side in sorted(every, key=lambda entry: _by_time(entry[0])):
        if _by_time(stretch) > last:
            groups.append(([], []))
        groups[-1][side].append(stretch)
        last = max(last, (stretch.episode, float(stretch.end)))
    return groups


def _of_ends(begins, ends):
    """Yields what differs between (old, new) begins and ends."""
    for kind, (was, now) in (("began", begins), ("ended", ends)):
        if was != now:
            by = float(now) - float(was)
            yield kind, f"at {now}, before at {was} ({by:+.3f} s)", abs(by)


def _of_stretches(old, new):
    """Yields (kind, text, amount) for the contacts of two bodies."""
    for was, now in _overlapping(old, new):
        if not was or not now:
            for stretch in was + now:
                yield ("vanished" if was else "appeared",
                       f"contact from {stretch.begin} to {stretch.end}", 0)
        elif len(was) == len(now):
            for a, b in zip(was, now):
                yield from _of_ends((a.begin, b.begin), (a.end, b.end))
        else:
            yield from _of_ends((was[0].begin, now[0].begin), (was[-1].end, now[-1].end))
            yield "ended", f"{len(now)} contacts, before {len(was)}, from {now[0].begin} to " \
                           f"{now[-1].end}", float("inf")


def _of_pairs(old, new):
    """Finds cycles in which other triangles touch. A cycle with contact in only one of the runs
    does not count: the contact began, ended, appeared or vanished, which is another kind of
    change."""
    moved = {}
    for stamp in sorted(set(old) & set(new), key=float):
        was, now = collections.Counter(old[stamp]), collections.Counter(new[stamp])
        cycles = min(sum((was - now).values()), sum((now - was).values()))
        if cycles:
            moved[stamp] = cycles
    if moved:
        cycles = sum(moved.values())
        first = next(iter(moved))
        yield "moved", f"other triangles; cycles: {cycles}, the first at {first}", cycles


def _looked_at(states):
    """Returns {episode: (cycles, first stamp, last stamp)}."""
    found = {}
    for stretch in sorted((s for of in states.values() for s in of), key=_by_time):
        cycles, first, _ = found.get(stretch.episode, (0, stretch.begin, ""))
        found[stretch.episode] = (cycles + stretch.cycles, first, stretch.end)
    return found


def _of_cycles(old, new):
    """Finds episodes in which less was looked at."""
    looked_at = _looked_at(new)
    for episode, (cycles, first, last) in _looked_at(old).items():
        now, begin, end = looked_at.get(episode, (0, "", ""))
        if now < cycles or float(begin) > float(first) or float(end) < float(last):
            span = f" from {begin} to {end}" if now else ""
            yield "unknown", f"looked at in {now} cycles{span}, before {cycles} from {first} to " \
                             f"{last}", 0


def _of_unknown(old, new):
    """Finds what was judged in one of the runs only."""
    if old and not new:
        if TOUCHING[0] not in old:  # otherwise the contact has vanished, which is said
            yield "unknown", "the two are no longer monitored", 0
        return
    yield from _of_cycles(old, new)
    for state in ("UNKNOWN", "ALLOWED"):
        was, now = ({stretch[:3] for stretch in of.get(state, [])} for of in (old, new))
        if was != now:
            _, begin, end = min(was ^ now, key=_by_time)
            yield "unknown", f"{state} {len(now)} times, before {len(was)}; the first that " \
                             f"differs: from {begin} to {end}", 0


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
    old, new = read_summary(old_folder), read_summary(new_folder)
    old_links = _stretches(old_folder, old["runs"][0]["name"])
    new_links = _stretches(new_folder, new["runs"][0]["name"])
    old_pairs, new_pairs = read_pair_hashes(old_folder), read_pair_hashes(new_folder)
    for bodies in sorted(set(old_links) | set(new_links) | set(old_pairs) | set(new_pairs)):
        was, now = old_links.get(bodies, {}), new_links.get(bodies, {})
        for kind, text, amount in (
                *_of_stretches(was.get(TOUCHING[0], []), now.get(TOUCHING[0], [])),
                *_of_pairs(old_pairs.get(bodies, {}), new_pairs.get(bodies, {})),
                *_of_unknown(was, now)):
            found.append(Change(bag, kind, bodies, text, amount))
    for kind, text in _of_expectations(old, new):
        found.append(Change(bag, kind, (), text, 0))
    was, now = _median_ms(old), _median_ms(new)
    if was > 0:
        found.append(Change(bag, "latency", (), f"median {now:.3f} ms, before {was:.3f} ms "
                            f"(ratio {now / was:.2f})", now / was))
    return found
