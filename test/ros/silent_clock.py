#!/usr/bin/env python3
"""Sets use_sim_time without a clock, then starts the clock, then stops it."""
import sys
import threading
import time
import unittest

import rospy
import rostest
from rosgraph_msgs.msg import Clock
from rosgraph_msgs.msg import Log as ConsoleLine

from monitor_test_support import PACKAGE, Log


class SilentClock(unittest.TestCase):

    def test_a_clock_is_missed_while_it_is_away(self):
        console = Log("/rosout", ConsoleLine)

        def warning(part):
            return console.wait(f"'{part}'", lambda m: m.level == ConsoleLine.WARN
                                and part in m.msg, console.count()).msg

        self.assertIn("it never came", warning("/clock is silent"))
        clock = rospy.Publisher("/clock", Clock, queue_size=1)
        runs = threading.Event()
        runs.set()

        def tick():
            stamp_s = 100.0
            while runs.is_set():
                stamp_s += 0.02
                clock.publish(Clock(rospy.Time.from_sec(stamp_s)))
                time.sleep(0.02)
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
