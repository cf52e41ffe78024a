"""What contact_test makes of its parameters, the monitor's and of messages. Knows no ROS master."""
import collections
import math
import re
import types
from ctypes import c_float

import rosgraph
from deformable_contact_monitor.msg import ContactState

from .contact_reader import certain_distance, is_of, margin_of, margins_of

STATES = {name: getattr(ContactState, name.upper())
          for name in ("none", "near", "contact", "allowed", "unknown", "passed")}
STATE_NAMES = {None: "not listed", **{value: name for name, value in STATES.items()}}
WITHOUT_PAIRS = ("none", "allowed", "unknown")
WITH_PAIRS = ("contact", "passed")  # near has some where the monitor lists near_pairs
MOST_PAIRS = 2**32 - 1  # that pair_count can say
# A mesh may be left out; by more [s], back or on, it is the clock.
TIME_JUMP_S = 5.0

NAMES = {"monitor": "contact_monitor", "link": None, "object": None, "state": None}
NUMBERS = {  # type, default, least, greatest
    "keeps_m": (float, 0.0, 1e-9, 1e6),  # 0: not set
    "min_pairs": (int, 0, 0, MOST_PAIRS), "max_pairs": (int, MOST_PAIRS, 0, MOST_PAIRS),
    "within_s": (float, 10.0, 0, 3600), "hold_s": (float, 0.0, 0, 3600),
    "max_age_s": (float, math.inf, 0.001, 3600), "wait_s": (float, 20.0, 0.1, 3600)}
EXPONENTIAL = re.compile(r"[-+]?(\d+\.?\d*|\.\d+)[eE][-+]?\d+")  # to YAML 1.1, 1e-3 is a text

# What the monitor's reason for UNKNOWN means for who reads the failure.
REASONS = (("mesh missing", r"no mesh yet"), ("mesh refused", r"mesh refused: "),
           ("mesh stale", r"newest mesh is |no new mesh|no mesh as old as"),
           ("monitor busy", r"busy: "),
           ("monitor reset", r"reset|time jump|not looked at yet|robot changed"),
           ("TF missing", r"TF .* never seen"),
           ("TF late", r"TF .* (is late|no longer reaches back)"),
           ("monitor disabled", r"disabled"), ("clock missing", r"no clock"),
           ("monitor too slow",
            r"not decided in time|(in the step: )?no time|the cycle ended later"),
           ("mesh incomplete", r".*triangles have a vertex that is not finite"),
           ("mesh deleted", r"(all markers were|marker .* was) deleted"),
           ("detection failed", r"(the step's )?detection failed"),
           ("memory limit", r".*memory_limit_mib"))


def parse(tree):
    """Parameters as attributes; ValueError names all that is wrong with them."""
    wanted, problems = types.SimpleNamespace(), []
    for name in sorted(set(tree) - set(NAMES) - set(NUMBERS)):
        problems.append(f"{name} is unknown; there are {', '.join([*NAMES, *NUMBERS])}")
    for name, default in NAMES.items():
        value = tree.get(name, default)
        setattr(wanted, name, value)
        if name == "state" and "keeps_m" in tree:
            if value is not None:
                problems.append("state is set, which excludes keeps_m")
        elif value is None:
            problems.append(f"{name} is not set")
        elif not isinstance(value, str) or not value:
            problems.append(f"{name} must be a name, not {value!r}")
    for name, (kind, default, least, greatest) in NUMBERS.items():
        value = tree.get(name, default)
        if kind is float and isinstance(value, str) and EXPONENTIAL.fullmatch(value):
            value = float(value)
        setattr(wanted, name, value)
        is_kind = isinstance(value, (int, kind)) and not isinstance(value, bool)
        if name in tree and not (is_kind and least <= value <= greatest):
            noun = "a whole number" if kind is int else "a number"
            problems.append(f"{name} must be {noun} in [{least}, {greatest}], not {value!r}")
    if isinstance(wanted.state, str) and wanted.state not in STATES:
        problems.append(f"state must be one of {', '.join(STATES)}, not {wanted.state!r}")
    if isinstance(wanted.monitor, str) and not rosgraph.names.is_legal_name(wanted.monitor):
        problems.append(f"monitor must be a node's name, not {wanted.monitor!r}")
    if not problems and wanted.max_pairs < wanted.min_pairs:
        problems.append(f"max_pairs {wanted.max_pairs} is less than min_pairs {wanted.min_pairs}")
    if not problems and wanted.min_pairs > 0 and wanted.state in WITHOUT_PAIRS:
        problems.append(f"state {wanted.state} has no pairs, so min_pairs must be 0")
    if not problems and wanted.keeps_m > 0:
        for name in ("min_pairs", "max_pairs", "within_s"):
            if name in tree:
                problems.append(f"{name} is set, which excludes keeps_m")
        if is_of(wanted.link, wanted.object) or is_of(wanted.object, wanted.link):
            problems.append("keeps_m: a body has no distance from itself")
        return finished(wanted, problems)
    if not problems and wanted.max_pairs == 0 and wanted.state in WITH_PAIRS:
        problems.append(f"state {wanted.state} has pairs, so max_pairs must not be 0")
    return finished(wanted, problems)


def finished(wanted, problems):
    if problems:
        raise ValueError("; ".join(problems))
    # The monitor has distances and margins as float32.
    wanted.keeps_m = c_float(wanted.keeps_m).value
    return wanted


def settings_matter(wanted):
    """Whether some parameters of a monitor can keep it from showing what is wanted."""
    return wanted.keeps_m > 0 or wanted.min_pairs > 0 or wanted.max_pairs < MOST_PAIRS


def settings_problem(wanted, parameters):
    """Why a monitor with these private parameters cannot show what is wanted; empty: it can."""
    margins = margins_of(parameters)
    if wanted.keeps_m > 0:
        if any(is_of(wanted.link, name) and is_of(wanted.object, name)
               for name in object_names(parameters)):
            return "bad parameters: keeps_m: a body has no distance from itself"
        margin_m = max(margin_of(margins, body) for body in (wanted.link, wanted.object))
        if c_float(margin_m).value < wanted.keeps_m:
            return (f"margin too small: keeps_m is {wanted.keeps_m:.6g}, but the monitor knows no "
                    f"distance of the two beyond its margin_m of {margin_m:.6g} m")
    if wanted.state not in WITH_PAIRS:
        return ""
    if wanted.min_pairs > 1 and parameters.get("near_pairs") is True and max(margins.values()) > 0:
        return ("pairs not counted: min_pairs is set, but with the monitor's near_pairs, pairs "
                "within the margin count, too; set near_pairs to false")
    if wanted.max_pairs < MOST_PAIRS:
        for name in ("budget_ms", "tolerance_m"):
            if number_in(parameters, name, 0) > 0:
                return (f"pairs not counted: max_pairs is set, but with the monitor's {name}, only "
                        f"pairs that were found in time count; set {name} to 0")
    return ""


def object_names(parameters):
    objects = parameters.get("objects")
    names = [one.get("name") for one in objects if isinstance(one, dict)] \
        if isinstance(objects, list) else []
    return [name for name in names if name and isinstance(name, str)]


def time_jump_s(parameters):
    """By how much stamps of a monitor with these private parameters may differ [s]."""
    return max(TIME_JUMP_S, number_in(parameters, "max_mesh_age_s", 0) + 1)


def number_in(parameters, name, fallback):
    value = parameters.get(name)
    is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return float(value) if is_number else fallback


def why_unknown(state):
    """(what is the matter, in the monitor's words) with a pair whose state is UNKNOWN."""
    if not state.reason:
        return "state unknown", "the monitor gives no reason"
    text = state.reason
    for body in (state.body_a, state.body_b):
        if state.reason.startswith(body + ": "):
            text = state.reason[len(body) + 2:]
    fallback = "state unknown" if text == state.reason else "body unusable"
    what = next((what for what, pattern in REASONS if re.match(pattern, text)), fallback)
    return what, state.reason


class Judge:
    """Follows two bodies through the monitor's messages; knows stamps, no clock and no waiting."""

    def __init__(self, wanted):
        self.wanted = wanted
        self.bodies = sorted((wanted.link, wanted.object))
        self.latest = None  # newest message
        self.state = None  # the pair's in it; None: it is not listed
        self.started_s = None  # stamp at which monitor, mesh and TF were first there
        self.held_since_s = None
        self.newest_s = None
        self.last = None  # what the latest message said of the pair
        self.lag_s = 0.0  # of the pair's stamps behind the clock
        self.time_jump_s = TIME_JUMP_S  # by how much its stamps may differ
        self.seen = []  # (stamp [s], state, pairs) since the start
        self.ages_s = []
        self.least_m = math.inf  # with keeps_m
        self.passed = False
        self.failure = ""

    def take(self, message, age_s):
        """The next ContactStates, age_s after its stamp; then `passed` or `failure` may be set,
        and it is over."""
        self.latest = message
        self.state = self._state_in(message)
        stamp_s = self._stamp_s(message.header.stamp.to_sec() + age_s)
        last, self.last = self.last, str(self.state)
        is_later = stamp_s != self.newest_s
        if not is_later and last == self.last:
            return  # a cycle of others: nothing new
        if self.state is not None:
            age_s += (message.header.stamp - self.state.stamp).to_sec()
        if self.started_s is None:
            if not self._is_start():
                return
            self.started_s = self.newest_s = stamp_s
        if is_later:
            self.ages_s.append(age_s)
        self.seen.append((stamp_s, self.state and self.state.state,
                          self.state.pair_count if self.state else 0))
        if abs(stamp_s - self.newest_s) > self.time_jump_s:
            self.failure = (f"time jump: stamps went from {self.newest_s:.3f} to {stamp_s:.3f}; "
                            "let a test see one run of a bag or simulator, without a pause")
            return
        self.newest_s = max(self.newest_s, stamp_s)
        self._judge(stamp_s)

    def _state_in(self, message):
        """The pair's state. A part that is UNKNOWN may touch although its body's own state is NONE
        or NEAR, so the part's state is the pair's then."""
        state = next((state for state in message.states
                      if sorted((state.body_a, state.body_b)) == self.bodies), None)
        if state is None or state.state not in (ContactState.NONE, ContactState.NEAR):
            return state
        for of_parts in message.states:
            if of_parts.state == ContactState.UNKNOWN and self._is_of_parts(of_parts):
                return of_parts
        return state

    def _is_of_parts(self, state):
        """Whether a state is of parts of the two bodies, or of a part of one and the other."""
        return any(all(map(is_of, names, self.bodies))
                   for names in ((state.body_a, state.body_b), (state.body_b, state.body_a)))

    def _stamp_s(self, now_s):
        """Of the pair's state. What is not known is stamped by the clock, and put in line."""
        if self.state is None:
            return now_s - self.lag_s
        stamp_s = self.state.stamp.to_sec()
        if self.state.state in (ContactState.UNKNOWN, ContactState.ALLOWED):
            return stamp_s - self.lag_s
        self.lag_s = now_s - stamp_s
        return stamp_s

    def _is_start(self):
        if self.state is None:
            return False
        return self.state.state != ContactState.UNKNOWN or self.wanted.state == "unknown"

    def distance_m(self):
        """Certain distance of the pair in the latest message; NaN where nothing is known. Without a
        tolerance it is the distance itself, and not the next float32 below."""
        if self.state is None or self.state.state in (ContactState.UNKNOWN, ContactState.ALLOWED):
            return math.nan
        if self.state.state == ContactState.NEAR and self.latest.tolerance == 0:
            return self.state.min_separation
        return certain_distance(self.state, self.latest.tolerance)

    def _judge_distance(self, stamp_s):
        distance_m = self.distance_m()
        if not math.isnan(distance_m):
            self.least_m = min(self.least_m, distance_m)
        if not distance_m >= self.wanted.keeps_m:  # also if it is not known
            where = "" if math.isnan(distance_m) else f" at {distance_m:.6g} m"
            self.failure = (f"not kept: {self.wish()}, but {STATE_NAMES[self.seen[-1][1]]}{where} "
                            f"at {stamp_s:.3f}; {self.sight()}")
        elif self.newest_s - self.started_s >= self.wanted.hold_s:
            self._end()

    def _end(self):
        wanted = self.wanted
        self.passed = max(self.ages_s) <= wanted.max_age_s
        if not self.passed:
            old = sum(age_s > wanted.max_age_s for age_s in self.ages_s)
            self.failure = (f"too old: {self.wish()}, but {old} messages came more than "
                            f"max_age_s {wanted.max_age_s:g} after their stamp; {self.sight()}")

    def _judge(self, stamp_s):
        wanted = self.wanted
        if wanted.keeps_m > 0:
            self._judge_distance(stamp_s)
            return
        _, state, pairs = self.seen[-1]
        holds = state == STATES[wanted.state] and wanted.min_pairs <= pairs <= wanted.max_pairs
        by_s = self.started_s + wanted.within_s
        if self.held_since_s is None:
            if holds and stamp_s <= by_s:
                self.held_since_s = self.newest_s  # stamps may have gone back
            elif self.newest_s >= by_s:
                self.failure = self._never_held()
                return
        elif not holds:
            held_s = self.newest_s - self.held_since_s
            self.failure = (f"not held: {self.wish()} since {self.held_since_s:.3f}, for "
                            f"{held_s:.3f} of {wanted.hold_s:g} s, until it "
                            f"was {STATE_NAMES[state]} with {pairs} pairs at {stamp_s:.3f}")
            return
        if self.held_since_s is not None and self.newest_s - self.held_since_s >= wanted.hold_s:
            self._end()

    def _never_held(self):
        wanted = self.wanted
        counts = [pairs for _, state, pairs in self.seen if state == STATES[wanted.state]]
        if not counts:
            what = "wrong state"
        elif counts[-1] < wanted.min_pairs:
            what = "too few pairs"
        else:
            what = "too many pairs" if counts[-1] > wanted.max_pairs else "too late"
        return f"{what}: not {self.wish()} within {wanted.within_s:g} s; {self.sight()}"

    def wish(self):
        """What was asked for."""
        wanted = self.wanted
        if wanted.keeps_m > 0:
            return f"{wanted.link} and {wanted.object} keep {wanted.keeps_m:.6g} m"
        text = f"{wanted.link} and {wanted.object} in state {wanted.state}"
        if wanted.min_pairs > 0:
            text += f", at least {wanted.min_pairs} pairs"
        return text + (f", at most {wanted.max_pairs} pairs" if wanted.max_pairs < MOST_PAIRS
                       else "")

    def sight(self):
        """What was seen since the start."""
        stamps, states, pairs = zip(*self.seen)
        counts = ", ".join(f"{STATE_NAMES[state]} {count}"
                           for state, count in collections.Counter(states).most_common())
        least = f", least distance {self.least_m:.6g} m" if math.isfinite(self.least_m) else ""
        return (f"seen in {len(states)} messages from {min(stamps):.3f} to {max(stamps):.3f}: "
                f"{counts}; {min(pairs)} to {max(pairs)} pairs, greatest age "
                f"{max(self.ages_s):.3f} s{least}; last {STATE_NAMES[states[-1]]} with "
                f"{pairs[-1]} pairs")
