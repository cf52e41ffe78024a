"""Compares a run with an earlier one, and decides which changes do not fail."""
import fnmatch
import os
import re

import yaml

from fleet.changes import KINDS, Change, changes_of

LIMITS = {"within_s": ("began", "ended"), "cycles": ("moved",), "ratio": ("latency",)}
NAMES = ("change", "bag", "link")
EXPONENTIAL = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+")  # to YAML 1.1, 1e-3 is a text


class BaselineError(Exception):
    """One line for the user."""


def _checked(rule):
    if not isinstance(rule, dict):
        raise ValueError(f"must be a list of maps, not of {rule!r}")
    unknown = sorted(str(key) for key in set(rule) - set(NAMES) - set(LIMITS))
    if unknown:
        raise ValueError(f"{unknown[0]} is unknown; there are {', '.join([*NAMES, *LIMITS])}")
    if rule.get("change") not in KINDS:
        raise ValueError(f"change must be one of {', '.join(KINDS)}, not {rule.get('change')!r}")
    for name in NAMES[1:]:
        if not isinstance(rule.get(name, ""), str):
            raise ValueError(f"{name} must be text, not {rule[name]!r}")
    for name, kinds in LIMITS.items():
        if name not in rule:
            continue
        if rule["change"] not in kinds:
            raise ValueError(f"{name} is no limit of {rule['change']}")
        if isinstance(rule[name], str) and EXPONENTIAL.fullmatch(rule[name]):
            rule[name] = float(rule[name])
        if isinstance(rule[name], bool) or not isinstance(rule[name], (int, float)) \
                or not rule[name] >= 0:
            raise ValueError(f"{name} must be a number of at least 0, not {rule[name]!r}")
    return rule


def read_allowed(path):
    """Reads and checks the rules of a yaml file."""
    try:
        with open(path) as file:
            rules = yaml.safe_load(file) or []
        if not isinstance(rules, list):
            raise ValueError("must be a list")
        return [_checked(rule) for rule in rules]
    except (OSError, ValueError, yaml.YAMLError) as error:
        raise BaselineError(f"{path}: {' '.join(str(error).split())}") from error


def _applies(rule, change):
    return (rule["change"] == change.kind and fnmatch.fnmatchcase(change.bag, rule.get("bag", "*"))
            and ("link" not in rule
                 or any(fnmatch.fnmatchcase(body, rule["link"]) for body in change.bodies)))


def is_allowed(change, rules):
    """A change fails unless a rule allows it. Latency depends on the machine and its load, so it
    fails only if it exceeds a rule's limit."""
    limits = [next((rule[name] for name in LIMITS if name in rule), float("inf"))
              for rule in rules if _applies(rule, change)]
    if change.kind == "latency":
        return not limits or change.amount <= max(limits)
    return any(change.amount <= limit for limit in limits)


def compare(baseline, out, names):
    """Returns the changes of all bags of `names`, and of those that only the baseline has."""
    earlier_bags = os.path.join(baseline, "bags")
    if not os.path.isdir(earlier_bags):
        raise BaselineError(f"{baseline}: no run of evaluate_bags (it has no folder bags)")
    found = []
    for name in names:
        old, new = os.path.join(earlier_bags, name), os.path.join(out, "bags", name)
        has_old, has_new = (os.path.exists(os.path.join(folder, "summary.json"))
                            for folder in (old, new))
        if has_old and has_new:
            try:
                found += changes_of(name, old, new)
            except Exception as error:  # pylint: disable=broad-except
                # Whatever fails for one bag must not cost the report of the others.
                text = " ".join(f"cannot be compared: {type(error).__name__}: {error}".split())
                found.append(Change(name, "bag", (), text, 0))
        elif has_old:
            found.append(Change(name, "bag", (), "has no result, and had one before", 0))
        elif has_new:
            found.append(Change(name, "bag", (), "has nothing to be compared with", 0))
    for folder, _, files in sorted(os.walk(earlier_bags)):
        name = os.path.relpath(folder, earlier_bags)
        if "summary.json" in files and name not in names:
            found.append(Change(name, "bag", (), "is no more among the bags", 0))
    return found
