"""Writes pair_hashes.csv: one hash for the set of triangle pairs of two bodies in a cycle. It is
far smaller than pairs.csv, and enough to see whether the pairs changed."""
import csv
import hashlib
import itertools
import os

TITLE = ("stamp", "body_a", "body_b", "pairs", "sha256")


def _rows(pairs_path):
    with open(pairs_path, newline="", errors="replace") as file:
        rows = csv.DictReader(file)
        for (_, stamp), cycle in itertools.groupby(rows, lambda row: (row["cycle"], row["stamp"])):
            of_bodies = {}
            for row in cycle:
                bodies = (row["body_a"], row["body_b"])
                of_bodies.setdefault(bodies, []).append((int(row["triangle_a"]),
                                                         int(row["triangle_b"])))
            for bodies, pairs in sorted(of_bodies.items()):
                digest = hashlib.sha256(repr(sorted(pairs)).encode()).hexdigest()
                yield (stamp, *bodies, len(pairs), digest[:16])


def write_pair_hashes(folder):
    """Writes the hashes from pairs.csv. The order of a cycle's pairs does not matter."""
    with open(os.path.join(folder, "pair_hashes.csv"), "w", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(TITLE)
        table.writerows(_rows(os.path.join(folder, "pairs.csv")))


def read_pair_hashes(folder):
    """Returns {(body_a, body_b): {stamp: [hash, ...]}}. Two cycles may have the same stamp."""
    found = {}
    with open(os.path.join(folder, "pair_hashes.csv"), newline="") as file:
        for row in csv.DictReader(file):
            stamps = found.setdefault((row["body_a"], row["body_b"]), {})
            stamps.setdefault(row["stamp"], []).append(row["sha256"])
    return found
