#!/usr/bin/env python3
"""Checks the rules of allowed contact on the Panda: those of its SRDF, which Python's XML reader
reads as well, and those of attached objects."""
import sys
import threading
import time
import unittest
import xml.etree.ElementTree as ElementTree

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from std_srvs.srv import Trigger
from visualization_msgs.msg import MarkerArray

from deformable_contact_monitor.msg import AllowedContact
from deformable_contact_monitor.srv import AttachObject, SetAllowedContacts
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, Log, Monitor, now)
from panda_scene import PandaScene

SEMANTIC = "/robot_description_semantic"
SHIRT = "tshirt"


def disabled_pairs(srdf):
    return {frozenset((e.get("link1"), e.get("link2")))
            for e in ElementTree.fromstring(srdf).findall("disable_collisions")}


class WhatMayTouch(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.diagnostics = Log("/diagnostics", DiagnosticArray)
        cls.scene = PandaScene(rospy.get_param("~data"))
        cls.scene.show_until_seen(cls.monitor)
        cls.services = {}
        for name, kind in (("attach_object", AttachObject), ("reload_robot", Trigger),
                           ("reset", Trigger), ("set_allowed_contacts", SetAllowedContacts)):
            rospy.wait_for_service(f"/contact_monitor/{name}", WAIT_S)
            cls.services[name] = rospy.ServiceProxy(f"/contact_monitor/{name}", kind)
        cls.stopped = threading.Event()
        cls.thread = threading.Thread(target=cls.play)
        cls.thread.start()

    @classmethod
    def tearDownClass(cls):
        cls.stopped.set()
        cls.thread.join()

    @classmethod
    def play(cls):
        while not cls.stopped.is_set():
            cls.scene.show(now(), 0, 0, (0, 0, 5))
            time.sleep(0.1)

    def tearDown(self):
        rospy.set_param(SEMANTIC, self.srdf)
        self.services["reload_robot"]()
        self.services["attach_object"](object=SHIRT)
        self.services["set_allowed_contacts"](replace=True)

    def setUp(self):
        self.srdf = rospy.get_param(SEMANTIC)

    def states_when(self, condition, what):
        """{pair of names: state}, of the first message from now on of which condition holds."""
        def states(message):
            return {frozenset((s.body_a, s.body_b)): s.state for s in message.states}
        return states(self.monitor.states.wait(what, lambda m: condition(states(m)),
                                               self.monitor.states.count()))

    def wait_for_allowed(self, expected, what):
        """States in which these pairs, and no others, are allowed, and all others are known."""
        def fits(states):
            return (allowed(states) == expected
                    and ContactState.UNKNOWN not in states.values())
        def allowed(states):
            return {pair for pair, state in states.items() if state == ContactState.ALLOWED}
        return self.states_when(fits, what)

    def test_the_srdfs_pairs_are_allowed_and_not_computed_and_no_others(self):
        disabled = disabled_pairs(self.srdf)
        links = list(self.scene.links)
        monitored = {frozenset((a, b)) for a in links for b in links if a != b}
        monitored |= {frozenset((link, SHIRT)) for link in links}
        self.assertLess(disabled, monitored)
        states = self.wait_for_allowed(disabled, "the SRDF's pairs as ALLOWED")
        self.assertEqual(set(states), monitored)
        # Cycles of the rules before may still be on their way.
        begin = self.monitor.states.messages[-1].header.stamp
        end = begin + rospy.Duration(0.5)
        self.monitor.contacts.wait("contacts of these rules", lambda m: m.header.stamp >= end, 0)
        with self.monitor.contacts.condition:
            cycles = [m for m in self.monitor.contacts.messages if m.header.stamp >= begin]
        for cycle in cycles:
            touching = {frozenset((cycle.bodies[p.body_a], cycle.bodies[p.body_b]))
                        for p in cycle.pairs}
            self.assertEqual(touching & disabled, set())

        rules = [AllowedContact(*sorted(pair), False, "test") for pair in disabled]
        self.services["set_allowed_contacts"](rules=rules)
        states = self.wait_for_allowed(set(), "rules that beat the SRDF")
        self.assertIn(ContactState.CONTACT, {states[pair] for pair in disabled})

    def test_the_srdf_is_read_again_with_the_robot(self):
        rule = "<disable_collisions link1='{}' link2='{}'/>"
        rospy.set_param(SEMANTIC, "<robot name='panda'>"
                        + rule.format("panda_hand", "panda_link0")
                        + rule.format("panda_hand", "panda_link99") + "</robot>")
        self.assertTrue(self.services["reload_robot"]().success)
        few = {frozenset(("panda_hand", "panda_link0"))}
        self.wait_for_allowed(few, "the other SRDF's pair")
        rospy.set_param(SEMANTIC, "<robot name='panda'>")
        answer = self.services["reload_robot"]()
        self.assertFalse(answer.success)
        self.assertIn(f"parameter '{SEMANTIC}': SRDF, line 1: not well-formed XML",
                      answer.message)
        self.wait_for_allowed(few, "the rules that were in force")

    def test_what_is_held_may_be_touched_by_those_that_hold_it(self):
        disabled = disabled_pairs(self.srdf)
        held_by = lambda *links: disabled | {frozenset((link, SHIRT)) for link in links}
        def attach(name, links):
            return self.services["attach_object"](object=name, links=links)
        answer = attach(SHIRT, ["panda_leftfinger", "panda_hand"])
        self.assertTrue(answer.success, answer.message)
        self.assertEqual(answer.message, "held: tshirt by panda_hand, panda_leftfinger")
        self.wait_for_allowed(held_by("panda_hand", "panda_leftfinger"), "two that hold it")

        for name, links, unknown in (("t-shirt", [], "'t-shirt'"),
                                     (SHIRT, ["panda_hand", "hand"], "'hand'")):
            answer = attach(name, links)
            self.assertFalse(answer.success)
            self.assertIn(unknown, answer.message)
        self.wait_for_allowed(held_by("panda_hand", "panda_leftfinger"), "no change")

        status = next(s for s in self.diagnostics.wait(
            "the held object", lambda m: self.allowed_status(m).get("held"),
            self.diagnostics.count()).status if s.name.endswith(": allowed"))
        self.assertEqual(status.level, DiagnosticStatus.OK)
        values = {value.key: value.value for value in status.values}
        self.assertEqual(values["held"], "tshirt by panda_hand, panda_leftfinger")
        self.assertEqual(values["rules: srdf"], f"{len(disabled)}, for {len(disabled)} pairs")
        self.assertIn("tshirt (attached)", values["panda_hand"])
        markers = Log("/contact_monitor/markers", MarkerArray)
        markers.wait("the text of what is held", lambda m: "held: " + values["held"] in {
            marker.text for marker in m.markers if marker.ns == "held"})
        markers.subscriber.unregister()

        self.services["set_allowed_contacts"](
            rules=[AllowedContact("panda_hand", SHIRT, False, "")])
        self.wait_for_allowed(held_by("panda_leftfinger"), "a rule of that pair, which is stronger")
        self.services["set_allowed_contacts"](
            rules=[AllowedContact("*", SHIRT, False, "")], replace=True)
        self.wait_for_allowed(held_by("panda_hand", "panda_leftfinger"), "a weaker wildcard")
        self.assertTrue(self.services["reload_robot"]().success)
        self.assertTrue(self.services["reset"]().success)
        self.wait_for_allowed(held_by("panda_hand", "panda_leftfinger"), "the same after a reload")
        self.assertTrue(attach(SHIRT, ["panda_rightfinger"]).success)
        self.wait_for_allowed(held_by("panda_rightfinger"), "the last call's links")
        self.assertEqual(attach(SHIRT, []).message, "nothing is held")
        self.wait_for_allowed(disabled, "nobody holding it")

    def allowed_status(self, message):
        return {value.key: value.value for s in message.status if s.name.endswith(": allowed")
                for value in s.values}


if __name__ == "__main__":
    rospy.init_node("what_may_touch_test")
    rostest.rosrun(PACKAGE, "what_may_touch", WhatMayTouch, sys.argv)
