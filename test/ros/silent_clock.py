#!/usr/bin/env python3
"""Sets use_sim_time without a clock, then starts a clock at a tenth of real time, then stops it."""
import sys
import threading
import time
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Clock
from rosgraph_msgs.msg import Log as ConsoleLine

import boxes_scene
from boxes_scene import CLOTH, REFERENCE_FRAME
from deformable_contact_monitor.msg import ContactState
from monitor_test_support import PACKAGE, Log, MeshPublisher, Monitor, Transforms


class Simulator:
    """Publishes transforms at 50 Hz and meshes at 30 Hz of its own time, which is ten times slower
    than real time."""

    def __init__(self):
        self.clock = rospy.Publisher("/clock", Clock, queue_size=1)
        self.transforms = Transforms()
        self.cloth = MeshPublisher("cloth", "/cloth")
        self.step = 0

    def steps(self, count, clock=True, meshes=True):
        for self.step in range(self.step + 1, self.step + 1 + count):
            stamp = rospy.Time.from_sec(100 + self.step / 1000)
            if clock:
                self.clock.publish(Clock(stamp))
            if self.step % 20 == 0:
                self.transforms.send(stamp, boxes_scene.edges())
            if meshes and self.step % 33 == 7:
                self.cloth.send(stamp, REFERENCE_FRAME, CLOTH)
            time.sleep(0.01)


class SilentClock(unittest.TestCase):

    def test_a_clock_is_missed_while_it_is_away(self):
        console, monitor = Log("/rosout", ConsoleLine), Monitor()
        simulator = Simulator()

        def warning(part):
            return console.wait(f"'{part}'", lambda m: m.level == ConsoleLine.WARN
                                and part in m.msg, console.count()).msg

        simulator.steps(200, clock=False)
        monitor.states.wait("states of both links", lambda m: len(m.states) == 2)
        for message in list(monitor.states.messages):
            self.assertFalse(message.complete)
            self.assertEqual({state.state for state in message.states} - {ContactState.UNKNOWN},
                             set())
        self.assertFalse(any(message.complete for message in list(monitor.contacts.messages)))
        self.assertIn("it never came", warning("/clock is silent"))
        Log("/diagnostics", DiagnosticArray).wait("an error for want of a clock", lambda m: any(
            status.level == DiagnosticStatus.ERROR and "no clock: use_sim_time is set" in status.message
            for status in m.status if status.name.endswith("status")))

        simulator.steps(50)  # the frames must have been seen once
        since = monitor.contacts.count()
        simulator.steps(300)
        contacts = monitor.contacts.messages[since:]
        self.assertGreater(len(contacts), 5)
        for message in contacts:
            self.assertTrue(message.complete, message.skipped)
        runs = threading.Event()
        runs.set()

        def tick():
            while runs.is_set():
                simulator.steps(1, meshes=False)
        thread = threading.Thread(target=tick)
        thread.start()
        try:
            self.assertNotIn("clock", warning("no mesh for"))
        finally:
            runs.clear()
            thread.join()
        self.assertIn("it stands still", warning("/clock is silent"))


if __name__ == "__main__":
    rospy.init_node("silent_clock_test")
    rostest.rosrun(PACKAGE, "silent_clock", SilentClock, sys.argv)
