#!/usr/bin/env python3
"""The Python module contact_reader, by the table of cases that the C++ header is tested by, too."""
import json
import math
import pathlib
import unittest

import genpy
from deformable_contact_monitor.msg import ContactState, ContactStates
from geometry_msgs.msg import Point32

from deformable_contact import contact_reader

TABLE = json.loads((pathlib.Path(__file__).resolve().parent / "cases.json").read_text())
STATES = ("NONE", "NEAR", "CONTACT", "ALLOWED", "UNKNOWN", "PASSED")
SEPARATIONS = {"NONE": math.inf, "CONTACT": 0, "PASSED": 0}


def state_of(given, message):
    name = given["is"]
    state = ContactState(state=getattr(ContactState, name) if name in STATES else name)
    state.body_a, state.body_b = given["pair"].split()
    state.stamp = time_of(given["stamp"]) if "stamp" in given else message.header.stamp
    state.min_separation = float(given.get("m", SEPARATIONS.get(name, math.nan)))
    state.distance_low = float(given.get("low", 0))
    state.reason = given.get("why", "")
    for name, field in (("a", "point_a"), ("b", "point_b"), ("n", "normal")):
        setattr(state, field, Point32(*given.get(name, (0, 0, 0))))
    return state


def time_of(seconds):
    return genpy.Time.from_sec(seconds)


class Answers(unittest.TestCase):

    def check_case(self, case):
        reader = contact_reader.ContactReader(**case.get("rules", {}))
        cycle = 0
        for step in case["steps"]:
            if "forget" in step:
                reader.forget(step["forget"])
                continue
            now = time_of(step["now"])
            if "store" in step:
                cycle = step.get("cycle", cycle + 1)
                message = ContactStates(cycle=cycle, tolerance=step.get("tolerance", 0))
                message.header.stamp = time_of(step.get("stamp", step["now"]))
                message.states = [state_of(given, message) for given in step["store"]]
                reader.store(message, now)
                continue
            answer = reader.may_move(step["body"], now)
            self.assertEqual((bool(answer), answer.because), (not step["because"], step["because"]))
            self.check_nearest(reader.nearest(step["body"], now), step, answer)
            if "text" in step:
                margins = contact_reader.margins_of(step["monitor"]) if "monitor" in step else None
                self.assertEqual(reader.nearest_text(step["body"], now, margins), step["text"])
            self.assertEqual(["%s %s" % (state.body_a, state.body_b)
                              for state in reader.contacts(step["body"], now)], step["contacts"])

    def check_nearest(self, nearest, step, answer):
        self.assertEqual(nearest, float(step["nearest"]))
        self.assertEqual(nearest.distance_m, float(step["nearest"]))
        self.assertEqual(nearest.is_known, not nearest.because)
        if not nearest.is_known:
            self.assertEqual(nearest.because, answer.because)
        if "at" not in step:
            return
        expected = step["at"] + ["", ""][len(step["at"]):] + [(0, 0, 0)] * 3
        self.assertEqual([nearest.body, nearest.other], expected[:2])
        self.assertEqual(nearest.has_points, len(step["at"]) > 2)
        self.assertEqual([nearest.point, nearest.other_point, nearest.normal],
                         [tuple(point) for point in expected[2:5]])

    def test_cases(self):
        self.assertGreater(len(TABLE["cases"]), 30)
        for case in TABLE["cases"]:
            with self.subTest(case["name"]):
                self.check_case(case)

    def test_distances(self):
        for given in TABLE["distances"]:
            state = state_of(given, ContactStates())
            tolerance_m = float(given.get("tolerance", 0))
            self.assertEqual(contact_reader.certain_distance(state, tolerance_m),
                             float(given["distance"]), given)

    def test_bad_rules_are_refused(self):
        for rules in ({"max_age_s": 0}, {"max_age_s": math.nan}, {"clearance_m": -1},
                      {"clearance_m": math.nan}):
            with self.assertRaises(ValueError):
                contact_reader.ContactReader(**rules)

    def test_states_are_those_of_the_message(self):
        for name in STATES:
            self.assertEqual(getattr(contact_reader, name), getattr(ContactState, name))


if __name__ == "__main__":
    unittest.main()
