#!/usr/bin/python3
"""Prints each second which bodies touch, with how many triangle pairs, and the latency.

Usage: demo_report.py [--seconds N]. Ends by itself after N seconds of wall time: exit code 0 if
contacts were reported, also in the last 3 s; 1 if the monitor was silent.
"""
import argparse
import statistics
import sys
import threading
import time

import rospy
from deformable_contact_monitor.msg import ContactArray, ContactState, ContactStates
from rosgraph_msgs.msg import Log


MOST_SILENCE_S = 3


def why_incomplete(message):
    """Returns why a ContactArray is not complete: the first reason, and how many more there are."""
    reasons = list(message.skipped)
    if message.timed_out:
        reasons.append("out of time")
    if message.truncated:
        reasons.append("%d of %d pairs sent" % (len(message.pairs), message.pair_count))
    if message.rejected_triangles:
        reasons.append("%d triangles rejected" % message.rejected_triangles)
    if message.overlap < 1:
        reasons.append("the settings may lose contacts")
    if not reasons:
        return "no memory or no detection, see /diagnostics"
    return reasons[0] + (" and %d more" % (len(reasons) - 1) if reasons[1:] else "")


class Second:
    """The messages of one second."""

    def __init__(self):
        self.age_ms = []
        self.compute_ms = []
        self.incomplete = []  # why, for each cycle that was not complete
        self.states = []

    def touching(self):
        pairs = sorted((s for s in self.states if s.state == ContactState.CONTACT),
                       key=lambda s: -s.pair_count)
        return ["%s-%s %d" % (s.body_a, s.body_b, s.pair_count) for s in pairs]

    def unknown(self):
        return ["%s-%s" % (s.body_a, s.body_b) for s in self.states
                if s.state == ContactState.UNKNOWN]

    def line(self):
        if not self.age_ms:
            return "nothing from the monitor"
        text = "%3d cycles, latency %5.1f ms (worst %5.1f), of it detection %5.1f ms | " % (
            len(self.age_ms), statistics.median(self.age_ms), max(self.age_ms),
            statistics.median(self.compute_ms))
        touching = self.touching()
        text += "pairs: " + ", ".join(touching) if touching else "no contact"
        if self.unknown():
            text += " | UNKNOWN: " + ", ".join(self.unknown())
        elif self.incomplete:
            text += " | %d cycles incomplete, the last: %s" % (
                len(self.incomplete), self.incomplete[-1])
        return text


class Report:
    """Collects messages on rospy's threads. take() returns those since the last call."""

    def __init__(self):
        self._lock = threading.Lock()
        self._second = Second()
        rospy.Subscriber("contact_monitor/contacts", ContactArray, self._on_contacts,
                         queue_size=10, buff_size=2**24, tcp_nodelay=True)
        rospy.Subscriber("contact_monitor/contact_states", ContactStates, self._on_states,
                         queue_size=10, tcp_nodelay=True)
        rospy.Subscriber("/rosout_agg", Log, self._on_log, queue_size=10)

    def _on_contacts(self, message):
        with self._lock:
            self._second.age_ms.append(1e3 * message.age.to_sec())
            self._second.compute_ms.append(1e3 * message.compute_time.to_sec())
            if not message.complete:
                self._second.incomplete.append(why_incomplete(message))

    def _on_states(self, message):
        with self._lock:
            self._second.states = message.states

    @staticmethod
    def _on_log(message):
        if message.level >= Log.WARN and message.name != rospy.get_name():
            print("        %s: %s" % (message.name, message.msg), flush=True)

    def take(self):
        with self._lock:
            second, self._second = self._second, Second()
        return second


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--seconds", type=float, default=0, help="end after so long; 0: never")
    args = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("demo_report", disable_signals=False)
    report = Report()
    start = time.monotonic()
    last_cycle = -MOST_SILENCE_S
    tick = 0
    while not rospy.is_shutdown() and (args.seconds <= 0 or tick < args.seconds):
        tick += 1
        # Sleeps in wall time, so that a monitor that waits for /clock is reported as silent.
        time.sleep(max(0, start + tick - time.monotonic()))
        second = report.take()
        if second.age_ms:
            last_cycle = tick
        print("%5d s | %s" % (tick, second.line()), flush=True)
    return 0 if tick - last_cycle < MOST_SILENCE_S else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except rospy.ROSInterruptException:
        sys.exit(0)
