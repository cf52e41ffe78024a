#!/usr/bin/env python3
"""Compares states under a tolerance and a time budget with the exact distances of all triangles.
NONE must be certain and CONTACT within the tolerance. What is not decided in time must be
UNKNOWN, with bounds that hold."""
import collections
import math
import sys
import unittest

import numpy as np
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from visualization_msgs.msg import Marker, MarkerArray

import boxes_scene
from mesh_distance import mesh_distance
from monitor_test_support import (
    PACKAGE, ContactState, Log, MeshPublisher, Monitor, Transforms, now, oracle_pairs,
    posed_links, to_mesh, touching, until_frames_are_seen, wait_until)

NONE, NEAR, CONTACT = ContactState.NONE, ContactState.NEAR, ContactState.CONTACT
UNKNOWN = ContactState.UNKNOWN
LINKS = ("palm", "finger")
PALM_TOP_M, FINGER_TOP_M = 0.05, 0.15
LATE = "not decided in time"
ROUNDING_M = 1e-6

Setting = collections.namedtuple("Setting", "margin_m tolerance_m has_budget")
SETTINGS = {"exact": Setting(0.02, 0, False), "tolerant": Setting(0.02, 0.005, False),
            "ample": Setting(0.02, 0, True), "short": Setting(0.5, 0, True),
            "over": Setting(0.02, 0, True)}


def sheet(height_m, tilt=0.0, cells=20):
    """A flat cloth of 0.8 m over both links."""
    steps = np.linspace(-0.4, 0.4, cells + 1)
    x, y = (axis.flatten() for axis in np.meshgrid(steps, steps, indexing="ij"))
    corners = (np.arange(cells)[:, None] * (cells + 1) + np.arange(cells)).flatten()
    triangles = [(c, c + 1, c + cells + 1) for c in corners]
    triangles += [(c + 1, c + cells + 2, c + cells + 1) for c in corners]
    return to_mesh(np.stack([x, y, height_m + tilt * y], axis=1), triangles)


def adversarial_soup(low_m, count=6000):
    """Needles from a ring around the links, at that height, all through the same middle: any box
    around some of them holds the links, or nearly."""
    angle = np.random.RandomState(7).uniform(0, 2 * math.pi, count)
    ring = np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    beside = 0.01 * np.stack([-np.sin(angle), np.cos(angle), 0 * angle], axis=1)
    high = -0.25 * ring + [0, 0, 0.5]
    corners = np.stack([0.5 * ring + [0, 0, low_m], high - beside, high + beside], axis=1)
    return to_mesh(corners, np.arange(3 * count))


def problem_with(state, setting, distance_m):
    """What of a state is not true at that distance, 0 where they touch; empty if all is."""
    margin_m, tolerance_m, has_budget = setting
    apart_m = state.min_separation
    if state.distance_low > distance_m + ROUNDING_M:
        return "distance_low is more than the distance"
    if state.state == NONE:
        return "" if distance_m > margin_m - ROUNDING_M else "NONE within the margin"
    if state.state == NEAR:
        is_near = 0 < distance_m <= margin_m + tolerance_m + ROUNDING_M
        is_said = distance_m - tolerance_m - ROUNDING_M <= apart_m <= distance_m + ROUNDING_M
        return "" if is_near and is_said else "NEAR is not so"
    if state.state == CONTACT:
        return "" if distance_m <= tolerance_m + ROUNDING_M * (tolerance_m > 0) else "no contact"
    return "" if state.state == UNKNOWN and has_budget and state.reason else "not decided"


class Tolerance(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitors = {name: Monitor("/" + name) for name in SETTINGS}
        cls.markers = Log("/tolerant/markers", MarkerArray)
        cls.transforms = Transforms(listeners=len(SETTINGS))
        cls.publishers = {name: MeshPublisher(name, "/" + name, listeners=len(SETTINGS))
                          for name in ("cloth", "soup")}
        exact = cls.monitors["exact"]
        cls.meshes = exact.robot_meshes(exact.robot_meshes_log())
        cls.stamp = None

        def cycle():
            cls.send("cloth", sheet(3.0))
            all_contacts = [m.contacts_at(cls.stamp) for m in cls.monitors.values()]
            return max(all_contacts, key=lambda contacts: len(contacts.skipped))
        until_frames_are_seen(cycle)
        cls.on_cpu = cycle().backend == "cpu"

    @classmethod
    def send(cls, name, mesh):
        cls.stamp = now(after=cls.stamp)
        cls.transforms.send(cls.stamp, boxes_scene.edges(links=LINKS))
        cls.publishers[name].send(cls.stamp, boxes_scene.REFERENCE_FRAME, mesh)

    def distances(self, name, mesh):
        """{link: distance to it [m], exactly 0 where the oracle says that they touch}."""
        links = posed_links(self.meshes, lambda link: self.transforms.pose(
            boxes_scene.REFERENCE_FRAME, link, self.stamp))
        touched = touching(oracle_pairs(links, name, mesh))
        return {link: 0.0 if link in touched else mesh_distance(links[link], mesh)
                for link in LINKS}

    def states(self, monitor, name):
        """{link: its state with the object} of the newest mesh's cycle."""
        cycle = self.monitors[monitor].contacts_at(self.stamp).cycle
        message = self.monitors[monitor].states.wait(
            "its states", lambda m: m.header.stamp == self.stamp and m.cycle == cycle)
        self.assertAlmostEqual(message.tolerance, SETTINGS[monitor].tolerance_m, delta=1e-9)
        return {state.body_a: state for state in message.states if state.body_b == name}

    def look(self, name, mesh):
        """{monitor: {link: state}}, and the distances. None of them says what is not so."""
        self.send(name, mesh)
        distances = self.distances(name, mesh)
        states = {monitor: self.states(monitor, name) for monitor in SETTINGS}
        for monitor, setting in SETTINGS.items():
            self.assertEqual(set(states[monitor]), set(LINKS))
            for link, state in states[monitor].items():
                self.assertEqual(
                    problem_with(state, setting, distances[link]), "",
                    f"{monitor}, {link} {distances[link]:.6f} m off:\n{state}")
        return states, distances

    def settle(self, name, mesh, monitor, is_settled):
        """Bodies are exact until their tilings are made; CUDA stays so."""
        if not self.on_cpu:
            return

        def look():
            self.send(name, mesh)
            return is_settled(self.states(monitor, name))
        wait_until(look, f"{monitor} and the {name}")

    def settle_cloth(self):
        for monitor in ("tolerant", "ample"):
            self.settle("cloth", sheet(3.0), monitor,
                        lambda states: states["finger"].distance_low > 0)
        self.settle("cloth", sheet(3.0), "over", lambda states: states["finger"].reason == LATE)

    def expect(self, states, monitor, link, expected):
        self.assertEqual(states[monitor][link].state, expected, states[monitor][link])

    def test_far_near_within_the_tolerance_and_touching(self):
        self.settle_cloth()
        states, _ = self.look("cloth", sheet(3.0))
        for monitor in ("exact", "tolerant", "ample"):
            for link in LINKS:
                self.expect(states, monitor, link, NONE)
        if self.on_cpu:
            for monitor in ("tolerant", "ample"):
                self.assertGreater(states[monitor]["finger"].distance_low, 0.02)

        states, _ = self.look("cloth", sheet(FINGER_TOP_M + 0.012))  # within the margin alone
        for monitor in ("exact", "tolerant", "ample"):
            self.expect(states, monitor, "finger", NEAR)
            self.expect(states, monitor, "palm", NONE)

        states, _ = self.look("cloth", sheet(FINGER_TOP_M + 0.0002))
        self.expect(states, "exact", "finger", NEAR)
        self.expect(states, "ample", "finger", NEAR)
        self.expect(states, "tolerant", "finger", CONTACT)

        states, distances = self.look("cloth", sheet(0.1))
        self.assertEqual(distances["finger"], 0)
        for monitor in ("exact", "tolerant", "ample"):
            self.expect(states, monitor, "finger", CONTACT)
            self.expect(states, monitor, "palm", NONE)
        self.expect(states, "over", "finger", UNKNOWN)

    def test_any_sheet(self):
        self.settle_cloth()
        random = np.random.RandomState(3)
        found = {monitor: collections.Counter() for monitor in SETTINGS}
        for _ in range(30):
            top_m = random.choice((PALM_TOP_M, FINGER_TOP_M))
            states, _ = self.look("cloth", sheet(top_m + random.uniform(-0.01, 0.05),
                                                 tilt=random.uniform(-0.05, 0.05)))
            for monitor, of_links in states.items():
                found[monitor].update(state.state for state in of_links.values())
        for monitor in ("exact", "tolerant", "ample"):
            self.assertEqual(set(found[monitor]), {NONE, NEAR, CONTACT}, found)

    def test_a_witness_is_drawn_while_it_is_all_there_is(self):
        if not self.on_cpu:
            return
        self.settle_cloth()

        def drawn(action):
            return lambda array: any(m.ns == "witness: finger/cloth" and m.action == action
                                     for m in array.markers)

        def show(mesh, action):
            """Markers have a rate of their own."""
            since = self.markers.count()

            def look():
                self.send("cloth", mesh)
                self.states("tolerant", "cloth")
                return any(map(drawn(action), self.markers.messages[since:]))
            wait_until(look, f"markers with action {action}")
            return next(m for array in self.markers.messages[since:] for m in array.markers
                        if m.ns == "witness: finger/cloth" and m.action == action)
        marker = show(sheet(FINGER_TOP_M + 0.0002), Marker.ADD)
        on_finger, on_cloth = marker.points
        self.assertAlmostEqual(on_cloth.z, FINGER_TOP_M + 0.0002, delta=1e-6)
        self.assertLess(math.sqrt(sum((getattr(on_finger, c) - getattr(on_cloth, c)) ** 2
                                      for c in "xyz")), 0.005)
        self.assertLess(abs(on_finger.x - boxes_scene.FINGER_AT[0]), 0.026)
        show(sheet(0.1), Marker.DELETE)

    def test_diagnostics_say_what_was_decided_and_when(self):
        self.settle_cloth()
        self.look("cloth", sheet(3.0))
        diagnostics, found = Log("/diagnostics", DiagnosticArray), {}
        for monitor in ("exact", "tolerant", "over"):
            array = diagnostics.wait(f"those of {monitor}", lambda array, monitor=monitor: any(
                monitor in status.name and status.name.endswith("output")
                for status in array.status))
            found[monitor] = {status.name.split(": ")[-1]: status for status in array.status}
        self.assertNotIn("trade", found["exact"])
        output = found["tolerant"]["output"]
        self.assertEqual(output.message, "within tolerance_m" if self.on_cpu else "complete")
        self.assertEqual(output.level, DiagnosticStatus.OK)
        self.assertEqual(found["over"]["output"].level, DiagnosticStatus.WARN)

        trade = {monitor: {value.key: value.value for value in found[monitor]["trade"].values}
                 for monitor in ("tolerant", "over")}
        self.assertEqual(found["tolerant"]["trade"].level, DiagnosticStatus.OK)
        self.assertEqual(trade["tolerant"]["tolerance [m]"], "0.005")
        self.assertEqual(trade["tolerant"]["pairs of bodies decided"], "100.00 %")
        self.assertEqual(found["over"]["trade"].level, DiagnosticStatus.WARN)
        self.assertEqual(found["over"]["trade"].message, "states come later than budget_ms")
        self.assertLess(float(trade["over"]["pairs of bodies decided"].split()[0]), 50)
        self.assertGreater(float(trade["over"]["p99 over budget"]), 1.1)

    def test_an_adversarial_soup_has_an_answer_that_is_true(self):
        touching_soup, near_soup = adversarial_soup(-0.05), adversarial_soup(0.06)
        self.settle("soup", near_soup, "ample", lambda states: states["palm"].distance_low > 0)
        self.settle("soup", near_soup, "over", lambda states: states["finger"].reason == LATE)
        states, distances = self.look("soup", touching_soup)
        self.assertEqual(distances["finger"], 0)
        self.expect(states, "exact", "finger", CONTACT)
        self.expect(states, "ample", "finger", CONTACT)
        self.expect(states, "tolerant", "finger", CONTACT)
        for link in LINKS:
            self.expect(states, "over", link, UNKNOWN)
        if not self.on_cpu:
            return
        self.assertEqual(states["over"]["finger"].reason, LATE)

        def is_open(states):
            palm = states["palm"]
            return palm.state == UNKNOWN and palm.reason == LATE and palm.distance_low > 0
        self.settle("soup", near_soup, "short", is_open)
        states, distances = self.look("soup", near_soup)
        self.assertGreater(distances["palm"], 0.02)
        self.expect(states, "exact", "palm", NONE)
        self.expect(states, "ample", "palm", NONE)


if __name__ == "__main__":
    rospy.init_node("tolerance_test")
    rostest.rosrun(PACKAGE, "tolerance", Tolerance, sys.argv)
