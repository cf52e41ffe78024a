"""Collects the results of a run: the content of fleet.json, and the lines for people."""
import subprocess
import time

from fleet.baseline import compare, is_allowed
from fleet.evaluation import BROKEN, PASSED
from fleet.tables import NOT_WHOLE, bag_entry, exit_code


def verdict_of(fleet):
    count = len(fleet["bags"])
    not_whole = sum(bag["state"] in NOT_WHOLE for bag in fleet["bags"])
    broken = sum(not e["holds"] for bag in fleet["bags"] for e in bag["expectations"])
    parts = []
    if not_whole:
        parts.append(f"{not_whole} of {count} bags could not be evaluated completely")
    if broken:
        parts.append(f"{broken} expectations broken")
    disagree = sum(bag["state"] == BROKEN and all(e["holds"] for e in bag["expectations"])
                   for bag in fleet["bags"])
    if disagree:
        parts.append(f"exact runs disagree in {disagree} bags")
    if fleet["not_allowed"]:
        parts.append(f'{fleet["not_allowed"]} changes that are not allowed')
    return "Failed: " + ", ".join(parts) if parts else f"Passed: {count} bags"


def fleet_of(run, arguments, records, rules, started):
    judged, gone = {name: [] for name in records}, []
    if arguments.baseline:
        for change in compare(arguments.baseline, run.out, list(records)):
            allowed = is_allowed(change, rules)
            if change.bag in judged:
                judged[change.bag].append((change, allowed))
            else:
                gone.append({"bag": change.bag, "kind": change.kind, "bodies": change.bodies,
                             "text": change.text, "allowed": allowed})
    bags = [bag_entry(run.out, records[name], judged[name] if arguments.baseline else None)
            for name in sorted(records)]
    version = subprocess.run([run.tool, "--version"], stdout=subprocess.PIPE, check=True,
                             universal_newlines=True).stdout.strip()
    fleet = {"version": version, "arguments": run.passed, "bags": bags, "bags_gone": gone,
             "baseline": arguments.baseline,
             "not_allowed": sum(not allowed for of in judged.values() for _, allowed in of)
             + sum(not change["allowed"] for change in gone),
             "machines": sorted({bag["machine"] for bag in bags if bag["machine"]}),
             "were_there": sum(bag["was_there"] for bag in bags),
             "times": {"elapsed_s": time.monotonic() - started}}
    fleet.update(exit_code=exit_code(fleet), verdict=verdict_of(fleet))
    return fleet


def _print_change(bag, change):
    bodies = " / ".join(change["bodies"])
    print(f'{bag}: {change["kind"]}: {bodies + ": " if bodies else ""}{change["text"]}')


def print_fleet(fleet, out):
    for bag in fleet["bags"]:
        if bag["state"] != PASSED:
            print(f'{bag["bag"]}: {bag["state"]}: {bag["message"]}')
        if bag["warning"]:
            print(f'{bag["bag"]}: {bag["warning"]}')
        for e in bag["expectations"]:
            if not e["holds"]:
                print(f'  FAILS: {e["text"]} ({e["failure"]})')
        for change in bag.get("changes", ()):
            if not change["allowed"]:
                _print_change(bag["bag"], change)
    for change in fleet["bags_gone"]:
        if not change["allowed"]:
            _print_change(change["bag"], change)
    print(fleet["verdict"])
    print(f'{fleet["times"]["elapsed_s"]:.1f} s, {fleet["were_there"]} bags were there; written to '
          f"{out}")
