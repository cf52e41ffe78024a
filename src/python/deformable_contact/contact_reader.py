"""How to read ~contact_states safely: what is not known, too old or missing never counts as free.

As C++'s reader/contact_reader.h; both are tested by one table of cases. ContactReader needs no ROS
but messages and times that it is given; ContactSubscriber needs rospy.
"""
import io
import math
import threading
import time
from ctypes import c_float

NONE, NEAR, CONTACT, ALLOWED, UNKNOWN, PASSED = range(6)

_MOST_NAMES = 8
_GONE_AFTER_S = 2  # a monitor publishes at least once a second
CLOCK_SLACK_S = 0.1
"""ROS time may differ by so much between this process and the monitor's: states stamped farther
ahead are not known."""


class MoveAnswer:
    """True or false, and why not."""

    def __init__(self, because):
        self.yes = not because
        self.because = because

    def __bool__(self):
        return self.yes

    def __repr__(self):
        return "yes" if self.yes else "no: " + self.because


class NearestAnswer(float):
    """How far the nearest body is and where, or why that is not known. As a number it is a distance
    that is certain [m], >= 0: 0 if the two touch, or if anything is not known; infinity if nothing is
    within the monitor's margins.

    is_known, because: whether everything about the body is known, and why not.
    body, other: the body that was asked about (one of a pair if that was "*") and the nearest one;
        empty if nothing is known or within the margins.
    has_points: whether the points are known, which they are of NEAR and CONTACT.
    point, other_point: (x, y, z) in the frame of the message [m]: the nearest points of the two, or
        one point in the contact, twice.
    normal: unit vector (x, y, z) from `body` to `other`. In CONTACT it is zero without the
        monitor's contact_geometry; with it, it is that of the deepest pair, and may turn round
        between cycles.
    """

    def __new__(cls, distance_m, because="", state=None, asked="*"):
        answer = super().__new__(cls, distance_m)
        answer.because = because
        answer.is_known = not because
        answer.body = answer.other = ""
        answer.has_points = False
        answer.point = answer.other_point = answer.normal = (0.0, 0.0, 0.0)
        if state is not None:
            answer._tell(state, asked == "*" or is_of(state.body_a, asked))
        return answer

    @property
    def distance_m(self):
        return float(self)

    def _tell(self, state, is_a):
        ends = (state.body_a, state.point_a), (state.body_b, state.point_b)
        (self.body, point), (self.other, other_point) = ends if is_a else ends[::-1]
        self.has_points = state.state in (NEAR, CONTACT)
        self.point, self.other_point = _xyz(point), _xyz(other_point)
        self.normal = _xyz(state.normal, 1.0 if is_a else -1.0)


def certain_distance(state, tolerance_m):
    """The distance of a pair [m] that is certain, >= 0; 0 where it touches, or nothing is known;
    infinity where the pair is ALLOWED, and of NONE: nothing is within the monitor's margin.
    tolerance_m: of the message. A malformed message adds no distance: never more than
    min_separation is returned, and 0 if tolerance_m is NaN."""
    separation, low = state.min_separation, state.distance_low
    if state.state == ALLOWED:
        return math.inf
    if state.state not in (NONE, NEAR) or math.isnan(separation):
        return 0.0
    if state.state == NEAR and math.isinf(separation):
        return 0.0
    if low > 0 and math.isfinite(low):
        return max(0.0, min(low, separation))
    # If the tolerance is NaN, the inner call returns NaN and the outer one 0. Both depend on the
    # order of their arguments.
    return max(0.0, separation - max(tolerance_m, 0.0))


def is_of(name, body):
    """Whether the name is that of the body or of a part of it: "cloth:hem" is one of "cloth"."""
    return name == body or name.startswith(body + ":")


def margin_of(margins, name):
    """A part has the margin of its object, unless it has its own."""
    return margins.get(name, margins.get(name.rpartition(":")[0], margins["*"]))


def margins_of(parameters):
    """The margin of each body by its name, and of all others by "*" [m], from the private
    parameters of a monitor. A NONE of an object is certain to the least margin of its parts. Values
    of a wrong type are ignored: a monitor does not start with them."""
    def number(mapping, fallback):
        value = mapping.get("margin_m") if isinstance(mapping, dict) else mapping
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        return float(value) if is_number else fallback

    margins = {"*": number(parameters, 0.0)}
    links, objects = parameters.get("link_margin_m"), parameters.get("objects")
    def add(links, prefix):
        """The parameter server makes {left: {hand: 1}} of {left/hand: 1}."""
        for name, margin_m in links.items():
            if isinstance(margin_m, dict):
                add(margin_m, prefix + name + "/")
            else:
                margins[prefix + name] = number(margin_m, margins["*"])

    add(links if isinstance(links, dict) else {}, "")
    for one in objects if isinstance(objects, list) else ():
        if not isinstance(one, dict) or not isinstance(one.get("name"), str):
            continue
        own_m = least_m = number(one, margins["*"])
        parts = one.get("parts")
        for part in parts if isinstance(parts, list) else ():
            if isinstance(part, dict) and isinstance(part.get("name"), str):
                part_m = margins[one["name"] + ":" + part["name"]] = number(part, own_m)
                least_m = min(least_m, part_m)
        margins[one["name"]] = least_m
    return margins


class ContactReader:
    """The newest states, and what may be concluded from them at a time. A body is named as in the
    monitor's output (a link or an object); "*" means all of them, thus every pair. Times are ROS
    times, such as rospy.Time.now(). One thread at a time.

    max_age_s: [s] > 0. A state whose own stamp is longer ago is not known, and nothing is where no
    message came for so long. More than the period of the slowest mesh; more than 1 s where every
    pair may be allowed, for the monitor then speaks once a second.
    clearance_m: [m] >= 0. A NEAR pair lets its bodies move while it is certainly farther apart than
    this; infinity: never.
    unlisted_may_move: whether a body that is in no state may move, if the message has states and the
        monitor knows the robot's links; else nothing is known of it. A part ("cloth:hem") may not
        if its body is in some state, nor may a body without a name.
    """

    def __init__(self, max_age_s=0.5, clearance_m=math.inf, unlisted_may_move=False):
        if not max_age_s > 0:
            raise ValueError("max_age_s must be above 0")
        if not clearance_m >= 0:
            raise ValueError("clearance_m must not be below 0")
        self.max_age_s = max_age_s
        self.clearance_m = clearance_m
        self.unlisted_may_move = unlisted_may_move
        self.newest = None
        """As stored last; None before that. Old and unknown states are among them."""
        self._latest_stamp = None  # of all messages of this run of the monitor
        self._received = None  # ROS time at which the newest came
        self._nothing_because = "no states came yet"

    def store(self, states, now):
        """A message that came at `now`. One that is older than what is there (a lower cycle, or an
        older stamp of the same cycle) is ignored, unless ROS time was reset or the monitor began
        anew. After one whose stamp is zero nothing is known: its monitor has no clock."""
        if self.newest is not None and _seconds(now, self._received) < 0:
            self.forget("ROS time went back")
        stamp = states.header.stamp
        goes_on = self.newest is not None and states.cycle >= self.newest.cycle
        if self.newest is not None:
            is_ahead = _seconds(self.newest.header.stamp, now) > CLOCK_SLACK_S
            if not is_ahead and self._is_older(states):
                return
        self._latest_stamp = max(self._latest_stamp, stamp) if goes_on else stamp
        self.newest = states
        self._received = now

    def forget(self, because):
        """Nothing is known until the next message."""
        self.newest = None
        self._nothing_because = because

    def may_move(self, body, now):
        """A MoveAnswer: yes only if the body is listed and each pair with it is known, fresh, and
        NONE, ALLOWED or NEAR beyond clearance_m; else no, because of the first pair that speaks
        against it."""
        because = self._silence(now)
        if because:
            return MoveAnswer(because)
        states = self._states_of(body)
        for state in states:
            because = self._doubt(state, now) or self._obstacle(state)
            if because:
                return MoveAnswer("%s and %s: %s" % (state.body_a, state.body_b, because))
        if states or self._unlisted_may_move(body):
            return MoveAnswer("")
        return MoveAnswer(_missing(body, self.newest.states))

    def nearest(self, body, now):
        """A NearestAnswer of the nearest of the body's pairs, by certain_distance(); of several at
        the same distance, of the first. As a number it may set a speed: it is 0 if one of the pairs
        is not known."""
        states = self._states_of(body) if self.newest is not None else []
        because = self._why_unknown(body, states, now)
        if because:
            return NearestAnswer(0.0, because)
        distances = [certain_distance(state, self.newest.tolerance) for state in states]
        least_m = min(distances, default=math.inf)
        if not math.isfinite(least_m):
            return NearestAnswer(least_m)
        return NearestAnswer(least_m, "", states[distances.index(least_m)], body)

    def nearest_text(self, body, now, margins=None):
        """nearest() in words: "0.1250 m, hand and cloth", "hand and cloth: CONTACT", "beyond the
        margin of 0.05 m" where no pair has a distance, or why nothing is known. margins: those of
        the monitor (margins_of()); None: they are not known."""
        states = self._states_of(body) if self.newest is not None else []
        because = self._why_unknown(body, states, now)
        if because:
            return because
        distances = [certain_distance(state, self.newest.tolerance) for state in states]
        least_m = min(distances, default=math.inf)
        if math.isfinite(least_m):
            state = states[distances.index(least_m)]
            pair = "%s and %s" % (state.body_a, state.body_b)
            if state.state in (CONTACT, PASSED):
                return "%s: %s" % (pair, "CONTACT" if state.state == CONTACT else "PASSED")
            return "%.4f m, %s" % (least_m, pair)
        pairs = [(state.body_a, state.body_b) for state in states if state.state == NONE]
        if not pairs:
            return "no pair that matters"  # none, or all are ALLOWED
        if margins is None:
            return "beyond the monitor's margin"
        return "beyond the margin of %g m" % min(
            max(margin_of(margins, name) for name in pair) for pair in pairs)

    def contacts(self, body, now):
        """Its pairs that are known to touch, or to have touched since their last cycle. None is no
        reason to move: ask may_move()."""
        if self._silence(now):
            return []
        return [state for state in self._states_of(body)
                if state.state in (CONTACT, PASSED) and not self._doubt(state, now)]

    def _why_unknown(self, body, states, now):
        """Why something about the body is not known; empty: all is."""
        because = self._silence(now)
        for state in states if not because else ():
            because = self._doubt(state, now)
            if because:
                return "%s and %s: %s" % (state.body_a, state.body_b, because)
        if because or states or self._unlisted_may_move(body):
            return because
        return _missing(body, self.newest.states)

    def _unlisted_may_move(self, body):
        """An empty list says nothing, and before the monitor knows the robot's links, it has a body
        "robot" in their place, which is UNKNOWN. A part that is not listed may be what touches in
        the states of its body."""
        whole = body.split(":")[0]
        return (self.unlisted_may_move and whole not in ("", "*") and len(self.newest.states) > 0
                and all(state.state != UNKNOWN for state in self._states_of("robot"))
                and not self._states_of(whole))

    def _states_of(self, body):
        return [state for state in self.newest.states
                if body == "*" or is_of(state.body_a, body) or is_of(state.body_b, body)]

    def _is_older(self, states):
        if states.header.stamp.to_nsec() == 0:
            return False
        if states.cycle == self.newest.cycle:
            return states.header.stamp < self.newest.header.stamp
        return states.cycle < self.newest.cycle and states.header.stamp <= self._latest_stamp

    def _silence(self, now):
        """Why nothing at all is known; empty: something is."""
        if now.to_nsec() == 0:
            return "ROS time is zero"
        if self.newest is None:
            return self._nothing_because
        if self.newest.header.stamp.to_nsec() == 0:
            return "the monitor has no clock: its stamp is zero"
        silent_s = _seconds(now, self._received)
        if silent_s < -CLOCK_SLACK_S:
            # It will come to the old times again, and the states belong to the first.
            self.forget("ROS time went back by %.3f s" % -silent_s)
            return self._nothing_because
        return "no states came for %.3f s" % silent_s if silent_s > self.max_age_s else ""

    def _doubt(self, state, now):
        """Why the state is not known; empty: it is."""
        if state.state == UNKNOWN:
            return "UNKNOWN: " + state.reason
        if state.state > PASSED:
            return "state %d is not known here" % state.state
        age_s = _seconds(now, state.stamp)
        if age_s > self.max_age_s:
            return "its state is %.3f s old" % age_s
        if age_s < -CLOCK_SLACK_S:
            return "its state is stamped %.3f s ahead" % -age_s
        no_number = (state.state == NEAR and not math.isfinite(state.min_separation) or
                     state.state == NONE and math.isnan(state.min_separation))
        if no_number:
            return "its distance is no number"
        is_below_0 = state.state == NONE and state.min_separation < 0
        return "its distance is below 0" if is_below_0 else ""

    def _obstacle(self, state):
        """Why a state that is known lets its bodies not move; empty: it does."""
        if state.state in (CONTACT, PASSED):
            return "CONTACT" if state.state == CONTACT else "PASSED"
        if state.state != NEAR:
            return ""
        distance_m = certain_distance(state, self.newest.tolerance)
        return "" if distance_m > self.clearance_m else "NEAR, %.4f m" % distance_m


class ContactSubscriber:
    """A ContactReader that subscribes ~contact_states of a monitor and asks at the present ROS time.
    It warns if the monitor's margins are below clearance_m, when the first states come.
    `topic`: such as "contact_monitor/contact_states"; `rules`: ContactReader's arguments. Threads may
    call every function at any time. ROS time that stands still lets nothing grow old here: a program
    that moves a robot in real time watches that, too, or heeds contact_guard, which does."""

    def __init__(self, topic, **rules):
        import rospy
        from deformable_contact_monitor.msg import ContactStates

        self._monitor = rospy.resolve_name(topic).rpartition("/")[0]  # its private namespace
        self._margins, self._margins_read_s = None, -math.inf
        self._margins_checked = False
        self._now = rospy.Time.now
        self._lock = threading.Lock()
        self._reader = ContactReader(**rules)
        self._topic, self._heard_s = rospy.resolve_name(topic), {}
        self._subscriber = rospy.Subscriber(topic, ContactStates, self._store, queue_size=1,
                                            tcp_nodelay=True)

    def may_move(self, body):
        with self._lock:
            return self._reader.may_move(body, self._now())

    def nearest(self, body):
        with self._lock:
            return self._reader.nearest(body, self._now())

    def nearest_text(self, body):
        """As ContactReader's, with the margins of the monitor: below the topic's namespace on the
        parameter server, which is not asked again within a second."""
        margins = self._read_margins()
        with self._lock:
            return self._reader.nearest_text(body, self._now(), margins)

    def contacts(self, body):
        with self._lock:
            return self._reader.contacts(body, self._now())

    def _read_margins(self):
        """None if they are not known. A topic in the root has been remapped, and no monitor has the
        root's parameters."""
        import rospy

        if not self._monitor:
            return None
        if time.monotonic() - self._margins_read_s > 1:
            self._margins_read_s = time.monotonic()
            try:
                parameters = rospy.get_param(self._monitor, None)
            except OSError:  # there is no master
                parameters = None
            self._margins = margins_of(parameters) if isinstance(parameters, dict) else None
        return self._margins

    def _store(self, states):
        header = getattr(states, "_connection_header", None) or {}
        if not isinstance(states.states, list):
            states = self._without_arrays(states)
        with self._lock:
            problem = self._rivals(header.get("callerid", ""), time.monotonic())
            if problem:
                self._reader.forget(problem)
            else:
                self._reader.store(states, self._now())
        if states.states and not self._margins_checked:
            self._margins_checked = True
            self._check_margins(states)

    def _rivals(self, publisher, now_s):
        """Which two nodes publish the states, as a nodelet beside a node does; "": one alone. Nobody
        knows which of them is right."""
        self._heard_s[publisher] = now_s
        self._heard_s = {name: heard_s for name, heard_s in self._heard_s.items()
                         if now_s - heard_s <= _GONE_AFTER_S}
        if len(self._heard_s) == 1:
            return ""
        return "two nodes publish %s: %s and %s; stop one of them" % (
            (self._topic,) + tuple(sorted(self._heard_s)[:2]))

    @staticmethod
    def _without_arrays(states):
        """As the generated class. rospy keeps the class of a process's first subscriber of a topic,
        which may be that of deformable_contact.messages."""
        from deformable_contact_monitor.msg import ContactStates

        buff = io.BytesIO()
        states.serialize(buff)
        return ContactStates().deserialize(buff.getvalue())

    def _check_margins(self, states):
        """Warns where NONE, up to the margin, lets a body move that is nearer than clearance_m."""
        import rospy

        clearance_m = self._reader.clearance_m
        margins = self._read_margins() if math.isfinite(clearance_m) else None
        if margins is None:
            return
        below = [(state, margin_m) for state, margin_m in
                 ((state, max(margin_of(margins, state.body_a),
                              margin_of(margins, state.body_b))) for state in states.states)
                 if state.state != ALLOWED and c_float(margin_m).value < c_float(clearance_m).value]
        if below:
            state, margin_m = below[0]
            rospy.logwarn("the monitor's margin_m of %d pair(s), such as %s and %s (%g m), is below "
                          "clearance_m (%g m): beyond it no distance is known, and may_move() says "
                          "yes", len(below), state.body_a, state.body_b, margin_m, clearance_m)


def _xyz(point, sign=1.0):
    return sign * point.x, sign * point.y, sign * point.z


def _missing(body, states):
    """What is said of a body without states. Names the first bodies that have some, because most
    such names are misspelled."""
    if body == "*":
        return "no pair is monitored"
    names = sorted({name for state in states for name in (state.body_a, state.body_b)})
    listed = "; there are " + ", ".join(names[:_MOST_NAMES]) if names else ""
    more = ", ..." if len(names) > _MOST_NAMES else ""
    return (body or "''") + " is in no state" + listed + more


def _seconds(a, b):
    """a - b [s]."""
    return (a.to_nsec() - b.to_nsec()) / 1e9
