#!/usr/bin/env python3
"""Runs README.md's examples for controllers unchanged. Builds the C++ one as a package of its own,
and plays the monitor for both."""
import importlib.util
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import threading
import unittest

import rospy
import rostest
from rosgraph_msgs.msg import Log as RosLog

from deformable_contact_monitor.msg import ContactState, ContactStates
from monitor_test_support import PACKAGE, Log, wait_until

ROOT = pathlib.Path(__file__).resolve().parents[2]
OUTSIDE = ROOT / "test" / "outside" / "controller"


def example(language):
    section = (ROOT / "README.md").read_text().split("### For controllers\n")[1].split("\n### ")[0]
    blocks = re.findall("```%s\n(.*?)```" % language, section, re.S)
    if len(blocks) != 1:
        raise AssertionError(f"{len(blocks)} examples in {language}")
    return blocks[0]


class Monitor:
    """Publishes one pair, whose state can be set, 20 times a second."""

    def __init__(self):
        self.state = ContactState(body_a="panda_hand", body_b="cloth", min_separation=float("inf"))
        self.silent = False
        self.cycle = 0
        self.publisher = rospy.Publisher("/contact_monitor/contact_states", ContactStates,
                                         queue_size=1)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not rospy.is_shutdown():
            rospy.rostime.wallsleep(0.05)
            if self.silent:
                continue
            self.cycle += 1
            message = ContactStates(cycle=self.cycle, states=[self.state])
            message.header.stamp = self.state.stamp = rospy.Time.now()
            try:
                self.publisher.publish(message)
            except rospy.ROSException:  # closed meanwhile: the test ends
                return


class Controllers(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.log = Log("/rosout", RosLog)
        cls.folder = pathlib.Path(tempfile.mkdtemp())
        cls.addClassCleanup(shutil.rmtree, str(cls.folder))

    def check(self, command):
        """The program says what is so, whatever happens."""
        self.monitor.state.state, self.monitor.silent = ContactState.NONE, False
        rospy.set_param("/contact_monitor/link_margin_m/panda_hand", 0.03125)
        rospy.set_param("/contact_monitor/margin_m", 0.03125)
        program = subprocess.Popen(command)
        try:
            self.says("the monitor's margin_m of 1 pair(s), such as panda_hand and cloth (0.03125 m), "
                      "is below clearance_m (0.05 m)")
            rospy.set_param("/contact_monitor/link_margin_m/panda_hand", 0.125)
            self.says("panda_hand may move: beyond the margin of 0.125 m")
            self.monitor.state.state = ContactState.CONTACT
            self.says("panda_hand and cloth: CONTACT")
            self.monitor.state.state = ContactState.ALLOWED
            self.says("panda_hand may move")
            self.check_rival()
            self.monitor.silent = True
            self.says("no states came for ")
        finally:
            program.terminate()
            program.wait(20)

    def check_rival(self):
        """A second node publishes the states, and ends."""
        rival = subprocess.Popen(["rostopic", "pub", "-r", "10", "/contact_monitor/contact_states",
                                  ContactStates._type, "{}", "__name:=a_rival"],
                                 stdout=subprocess.DEVNULL)
        try:
            self.says("two nodes publish /contact_monitor/contact_states: ")
        finally:
            rival.terminate()
            rival.wait(20)
        self.says("panda_hand may move")

    def says(self, text):
        self.log.wait(repr(text), lambda m: m.name == "/controller" and m.msg.startswith(text),
                      since=self.log.count())

    def test_in_cpp(self):
        (self.folder / "controller.cpp").write_text(example("cpp"))
        for step in (["-S", str(OUTSIDE), "-B", str(self.folder / "build"),
                      f"-DSOURCE={self.folder}/controller.cpp"],
                     ["--build", str(self.folder / "build")]):
            done = subprocess.run(["cmake"] + step, stdout=subprocess.PIPE,
                                  stderr=subprocess.STDOUT, universal_newlines=True)
            self.assertEqual(done.returncode, 0, done.stdout)
        self.check([str(self.folder / "build" / "controller")])

    @unittest.skipUnless(importlib.util.find_spec("deformable_contact"), "no Python package")
    def test_in_python(self):
        (self.folder / "controller.py").write_text(example("python"))
        self.check([sys.executable, str(self.folder / "controller.py")])

    @unittest.skipUnless(importlib.util.find_spec("deformable_contact"), "no Python package")
    def test_the_reader_beside_arrays_and_remapped(self):
        """rospy keeps the class of a topic's first subscriber, here one with arrays. No monitor has
        the parameters beside a topic in the root."""
        from deformable_contact import messages
        from deformable_contact.contact_reader import ContactSubscriber
        rospy.Subscriber("/states", messages.ContactStates, lambda states: None)
        reader = ContactSubscriber("/states", max_age_s=60)
        publisher = rospy.Publisher("/states", ContactStates, queue_size=1, latch=True)
        state = ContactState(body_a="panda_hand", body_b="cloth", min_separation=float("inf"))
        message = ContactStates(cycle=1, states=[state])
        message.header.stamp = state.stamp = rospy.Time.now()
        publisher.publish(message)
        wait_until(lambda: reader.may_move("panda_hand"), "a state")
        self.assertEqual(reader.nearest_text("panda_hand"), "beyond the monitor's margin")


if __name__ == "__main__":
    rospy.init_node("controllers_test")
    rostest.rosrun(PACKAGE, "controllers", Controllers, sys.argv)
