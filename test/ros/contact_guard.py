#!/usr/bin/env python3
"""Moves a Panda towards a cloth, as far and as fast as contact_guard lets it, and away again."""
import re
import subprocess
import sys
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from rosgraph_msgs.msg import Log as ConsoleLine
from std_srvs.srv import Trigger

from deformable_contact_monitor.msg import ContactStates
from guarded_panda import LOWERED_M, Arm, Guard, Programs, until_free
from monitor_test_support import PACKAGE, WAIT_S, ContactState, Log, executable, wait_until


def states_in(logged, since):
    """All states of the monitor's messages from number `since` on."""
    return [state for message in logged.messages[since:] for state in message.states]


def touches(message):
    return any(state.state == ContactState.CONTACT for state in message.states)


class ContactGuard(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.arm = Arm()
        cls.programs = Programs()
        cls.addClassCleanup(cls.programs.end)
        cls.programs.start()
        cls.states = Log("/contact_monitor/contact_states", ContactStates)
        cls.diagnostics = Log("/diagnostics", DiagnosticArray)
        cls.before, cls.at, cls.latched = Guard("stops_before"), Guard("stops_at"), Guard("latched")

    def setUp(self):
        self.programs.start()
        self.arm.direction, self.arm.turned, self.arm.cloth_lowered_m = 0, 0.0, 0.0
        until_free(self.before)
        until_free(self.at)

    def approach(self, guard, stop_distance_m):
        """Until the guard stops the arm there; the numbers of messages at the beginning."""
        self.arm.guard = guard
        since = self.states.count(), guard.scales.count()
        self.arm.direction = 1
        self.states.wait(f"a distance of {stop_distance_m} m", since=since[0], wanted=lambda m: any(
            state.min_separation <= stop_distance_m for state in m.states))
        wait_until(guard.stop, f"{guard.name} stops the robot")
        return since

    def check_slowed(self, guard, since):
        scales = [message.data for message in guard.scales.messages[since:]]
        slowed = [scale for scale in scales if 0 < scale < 1]
        self.assertGreater(len(slowed), 5)
        self.assertLess(min(slowed), 0.3)
        self.assertEqual(scales[0], 1)

    def check_stands(self, guard):
        """For a while, in which the monitor looks many times."""
        at = self.arm.turned
        since, looks = guard.stops.count(), self.states.count()
        wait_until(lambda: self.states.count() > looks + 10 and guard.stops.count() > since + 25,
                   "states and stops")
        self.assertEqual({message.data for message in guard.stops.messages[since:]}, {True})
        self.assertEqual(self.arm.turned, at)

    def leave(self, guard):
        """The cloth is let down, and the arm goes back: never slowed, for the distance grows."""
        self.arm.direction = 0
        self.arm.cloth_lowered_m = LOWERED_M
        until_free(guard)
        since = guard.scales.count()
        self.arm.direction = -1
        wait_until(lambda: self.arm.turned == 0, "the arm is back")
        scales = {message.data for message in guard.scales.messages[since:]}
        self.assertLessEqual({1.0}, scales)
        self.assertLessEqual(scales, {0.0, 1.0}, "slowed while it left")

    def test_slows_and_stops_before_the_cloth_and_leaves_at_full_speed(self):
        states, scales = self.approach(self.before, 0.03)
        self.check_slowed(self.before, scales)
        self.check_stands(self.before)
        said = states_in(self.states, states)
        self.assertNotIn(ContactState.CONTACT, {state.state for state in said})
        self.assertLessEqual(min(state.min_separation for state in said
                                 if state.state == ContactState.NEAR), 0.03)
        self.leave(self.before)

    def test_slows_and_stops_at_the_cloth_and_leaves_at_full_speed(self):
        states, scales = self.approach(self.at, 0)
        self.assertTrue(any(touches(message) for message in self.states.messages[states:]))
        self.check_slowed(self.at, scales)
        self.check_stands(self.at)
        self.states.wait("a contact", touches, since=self.states.count())
        self.leave(self.at)

    def reason_of(self, guard, pattern):
        """Waits until the guard's diagnostics say that it stops because of the pattern."""
        self.diagnostics.wait(
            f"{pattern!r} in the diagnostics", since=self.diagnostics.count(),
            wanted=lambda m: any(guard.name in s.name and s.level == 2 and
                                 re.search("^stop: .*" + pattern, s.message) for s in m.status))

    def check_killed(self, program, pattern):
        self.arm.guard = self.at
        self.arm.direction = 1
        wait_until(lambda: self.arm.turned > 0.02, "the arm moves")
        self.programs.kill(program)
        wait_until(lambda: self.at.stop() and self.before.stop(), f"a stop without {program}")
        self.reason_of(self.at, pattern)
        at = self.arm.turned
        since = self.at.stops.count()
        wait_until(lambda: self.at.stops.count() > since + 50, "stops")
        self.assertEqual({message.data for message in self.at.stops.messages[since:]}, {True})
        self.assertEqual(self.arm.turned, at)
        self.assertEqual({message.data for message in self.at.scales.messages[since + 1:]}, {0.0})
        self.arm.direction, self.arm.turned = 0, 0.0
        self.programs.start()
        until_free(self.at)

    def test_the_console_says_why_it_stops_from_the_start_on(self):
        console = Log("/rosout", ConsoleLine)
        rospy.set_param("/misspelt/links", ["panda_hnad"])
        guard = subprocess.Popen([executable("contact_guard"), "__name:=misspelt"])
        self.addCleanup(guard.wait, WAIT_S)
        self.addCleanup(guard.terminate)
        stop = console.wait("the reason", lambda m: m.name == "/misspelt" and "no state" in m.msg)
        self.assertEqual(stop.level, ConsoleLine.WARN)
        self.assertRegex(stop.msg, "^stop: panda_hnad is in no state; there are cloth, panda_")

    def test_stops_while_there_is_no_monitor(self):
        self.check_killed("monitor", "no states came")

    def test_stops_while_there_is_no_mesh(self):
        self.check_killed("mesh", "and cloth: UNKNOWN: ")

    def test_stops_while_there_are_no_transforms(self):
        self.check_killed("transforms", "and cloth: UNKNOWN: ")

    def test_stops_while_two_nodes_publish_the_states(self):
        """This one says that the monitor's pair is allowed to touch."""
        states = rospy.Publisher("/contact_monitor/contact_states", ContactStates, queue_size=1)
        self.addCleanup(states.unregister)
        allowed = ContactState(body_a="panda_hand", body_b="cloth", state=ContactState.ALLOWED)

        def send(_):
            message = ContactStates(states=[allowed])
            message.header.stamp = allowed.stamp = rospy.Time.now()
            states.publish(message)
        timer = rospy.Timer(rospy.Duration(0.05), send)
        self.addCleanup(timer.shutdown)
        self.reason_of(self.at, "two nodes publish contact_monitor/contact_states: "
                       + " and ".join(sorted(["/contact_monitor", rospy.get_name()])))
        since, looks = self.at.stops.count(), self.states.count()
        wait_until(lambda: self.states.count() > looks + 40, "states of both")
        self.assertEqual({message.data for message in self.at.stops.messages[since:]}, {True})
        timer.shutdown()
        until_free(self.at)

    def test_a_latched_stop_is_released_when_its_cause_is_gone(self):
        release = rospy.ServiceProxy("/latched/release", Trigger)
        wait_until(lambda: release().success, "the release")
        until_free(self.latched)
        self.arm.guard = None
        self.arm.turned = 0.65
        wait_until(self.latched.stop, "a stop at the cloth")
        self.states.wait("a contact", touches, since=self.states.count())
        answer = release()
        self.assertFalse(answer.success)
        self.assertIn("CONTACT", answer.message)
        self.arm.turned = 0.0
        until_free(self.at)
        since = self.latched.stops.count()
        wait_until(lambda: self.latched.stops.count() > since + 25, "stops")
        self.assertTrue(self.latched.stop())
        wait_until(lambda: release().success, "the release")
        until_free(self.latched)

    def test_a_margin_that_is_too_small_is_said(self):
        """The monitor's is 0.15 m, and one guard's slow_distance_m 0.2 m."""
        self.diagnostics.wait(
            "the margin in the diagnostics",
            wanted=lambda m: any("latched" in s.name and "is below slow_distance_m" in s.message
                                 for s in m.status))

    def test_a_margin_that_changes_is_looked_at_again(self):
        """It was large enough at first."""
        def wait_for(is_said):
            self.diagnostics.wait(
                f"a margin that is said: {is_said}", since=self.diagnostics.count(),
                wanted=lambda m: any("stops_before" in s.name and
                                     ("is below slow_distance_m" in s.message) == is_said
                                     for s in m.status))

        wait_for(False)
        margin_m = rospy.get_param("contact_monitor/margin_m")
        rospy.set_param("contact_monitor/margin_m", 0.1)
        try:
            wait_for(True)
        finally:
            rospy.set_param("contact_monitor/margin_m", margin_m)
        wait_for(False)


if __name__ == "__main__":
    rospy.init_node("contact_guard_test")
    rostest.rosrun(PACKAGE, "contact_guard", ContactGuard, sys.argv)
