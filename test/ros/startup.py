#!/usr/bin/env python3
"""Starts the monitor as a nodelet, and with parameters or a robot that it cannot use: it must then
refuse to start and name everything that is wrong."""
import re
import subprocess
import sys
import tempfile
import unittest

import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from rosgraph_msgs.msg import Log as ConsoleLine

import boxes_scene
from boxes_scene import CLOTH, REFERENCE_FRAME
from monitor_test_support import (
    PACKAGE, WAIT_S, Log, MeshPublisher, Monitor, Transforms, executable, now, pairs_of, touching,
    until_frames_are_seen)

GOOD = {"reference_frame": "base", "objects": [{"name": "cloth", "topic": "/cloth"}]}


def start_and_fail(name, parameters):
    """Exit code and output of a monitor that must end by itself."""
    for parameter, value in parameters.items():
        rospy.set_param(f"/{name}/{parameter}", value)
    ended = subprocess.run([executable("contact_monitor"), "__name:=" + name],
                           stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=WAIT_S,
                           universal_newlines=True)
    return ended.returncode, ended.stdout


def mean_times_ms(diagnostics):
    """{what: mean} of the timing in a DiagnosticArray; empty if it has none yet."""
    values = [value for status in diagnostics.status if status.name.endswith("timing")
              for value in status.values if value.key.endswith(" [ms]")]
    return {value.key[:-len(" [ms]")]: float(re.match(r"mean ([\d.]+), ", value.value).group(1))
            for value in values}


class Startup(unittest.TestCase):

    def test_the_nodelet_finds_the_same_contacts(self):
        monitor = Monitor()
        meshes = monitor.robot_meshes(monitor.robot_meshes_log())
        transforms = Transforms()
        cloth = MeshPublisher("cloth", "/cloth")

        def cycle():
            stamp = now()
            transforms.send(stamp, boxes_scene.edges())
            cloth.send(stamp, REFERENCE_FRAME, CLOTH)
            return monitor.contacts_at(stamp)
        until_frames_are_seen(cycle)
        contacts = cycle()
        expected = boxes_scene.expected(meshes, transforms, contacts.header.stamp, CLOTH)
        self.assertEqual(touching(expected), {"palm", "finger"})
        self.assertEqual(pairs_of(contacts), expected)
        self.assertTrue(contacts.complete, contacts.skipped)

        timed = Log("/diagnostics", DiagnosticArray).wait("times", mean_times_ms)
        times = mean_times_ms(timed)
        self.assertGreater(times["detection"], 0)
        self.assertGreater(times["cycle"], times["detection"])
        self.assertGreater(times["latency"], times["detection"])
        self.assertTrue(any(what.startswith("stage ") for what in times), times)
        output = [value.value for status in timed.status if status.name.endswith("output")
                  for value in status.values if value.key == "truncated"]
        self.assertEqual(output, ["false"])

    def test_cuda_asked_for_by_name_and_not_to_be_had_is_an_error(self):
        for parameter, value in {**GOOD, "backend": "cuda", "device": 1023}.items():
            rospy.set_param(f"/no_such_device/{parameter}", value)
        node = subprocess.Popen([executable("contact_monitor"), "__name:=no_such_device"],
                                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(node.wait, WAIT_S)
        self.addCleanup(node.terminate)

        def status(diagnostics):
            return [status for status in diagnostics.status
                    if "no_such_device" in status.name and status.name.endswith("status")
                    and {"backend": "cpu"}.items() <= values(status).items()]

        def values(status):
            return {value.key: value.value for value in status.values}

        found, = status(Log("/diagnostics", DiagnosticArray).wait("the status", status))
        self.assertEqual(found.level, DiagnosticStatus.ERROR)
        self.assertIn("contacts are computed on the CPU, because CUDA cannot be used: ", found.message)
        self.assertEqual(values(found)["backend asked for"], "cuda")
        self.assertNotEqual(values(found)["backend problem"], "")

    def test_the_console_says_what_is_watched_and_missing(self):
        console = Log("/rosout", ConsoleLine)
        for parameter, value in {**GOOD, "reference_frame": "attic", "ignored_links": ["lost"],
                                 "objects": [{"name": "sheet", "topic": "/sheet"}]}.items():
            rospy.set_param(f"/first_start/{parameter}", value)
        said = tempfile.TemporaryFile("w+")
        self.addCleanup(said.close)
        node = subprocess.Popen([executable("contact_monitor"), "__name:=first_start"],
                                stdout=said, stderr=subprocess.DEVNULL)
        self.addCleanup(node.wait, WAIT_S)
        self.addCleanup(node.terminate)
        block = console.wait("the block", lambda m: m.name == "/first_start" and "\n" in m.msg)
        self.assertEqual(block.level, ConsoleLine.INFO)
        lines = block.msg.split("\n")
        self.assertEqual(lines[0], "looks for contacts in frame 'attic':")
        for line in ("  missing  a mesh of 'sheet' on /sheet, on which nobody publishes",
                     "  missing  TF of 2 of 2 links: TF frame 'attic' never seen"):
            self.assertIn(line, lines)
        # roscpp complains where another test's node looks for one that had this port before.
        with console.condition:
            first = next(m.msg for m in console.messages if m.name == "/first_start"
                         and not m.file.endswith("/libros/connection.cpp"))
        self.assertEqual(first, block.msg)
        said.seek(0)  # a file has it at once, too
        self.assertIn("\n".join(lines), said.read())

    def test_bad_parameters_are_refused_all_of_them(self):
        bad = {"tf_timeout_s": 7.5, "predicates": "sloppy", "max_contacts": -3,
               "overlap": "much", "pair_classes": ["robot_robot"],
               "objects": [{"name": "cloth"}, {"name": "cloth"}]}
        code, output = start_and_fail("bad_parameters", {**GOOD, **bad})
        self.assertGreater(code, 0, output)
        for name in bad:
            self.assertIn(name, output)
        for value in ("7.5", "sloppy", "-3", "much", "robot_robot", "cloth"):
            self.assertIn(value, output)

    def test_two_objects_with_one_topic_are_refused(self):
        objects = [{"name": "cloth", "topic": "/cloth"}, {"name": "cable", "topic": "cloth"}]
        code, output = start_and_fail("one_topic", {**GOOD, "objects": objects})
        self.assertGreater(code, 0, output)
        self.assertIn("objects 'cloth' and 'cable' have one topic, /cloth", output)
        self.assertIn("see config/docs/console.md#it-does-not-start", output)

    def test_a_robot_that_cannot_be_had_is_refused(self):
        code, output = start_and_fail("no_robot", {**GOOD, "robot_description": "/nowhere"})
        self.assertGreater(code, 0, output)
        self.assertIn("/nowhere", output)

        rospy.set_param("/broken_description", "<robot name='r'><link></robot>")
        code, output = start_and_fail("bad_robot",
                                      {**GOOD, "robot_description": "/broken_description"})
        self.assertGreater(code, 0, output)
        self.assertIn("/broken_description", output)

    def test_an_srdf_that_is_named_and_cannot_be_had_is_refused(self):
        uri = "package://no_such_package/a.srdf"
        code, output = start_and_fail("no_srdf", {**GOOD, "srdf": uri})
        self.assertGreater(code, 0, output)
        self.assertIn(f"~srdf '{uri}': package 'no_such_package' not found", output)

    def test_an_srdf_that_is_found_and_broken_is_an_error_and_stops_nobody(self):
        rospy.set_param("/odd_description", rospy.get_param("/robot_description"))
        rospy.set_param("/odd_description_semantic", "<robot/>")
        for parameter, value in {**GOOD, "robot_description": "/odd_description"}.items():
            rospy.set_param(f"/odd_srdf/{parameter}", value)
        node = subprocess.Popen([executable("contact_monitor"), "__name:=odd_srdf"],
                                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        self.addCleanup(node.wait, WAIT_S)
        self.addCleanup(node.terminate)

        def allowed(diagnostics):  # an error as soon as the robot is read
            return [s for s in diagnostics.status
                    if "odd_srdf" in s.name and s.name.endswith(": allowed")
                    and s.level == DiagnosticStatus.ERROR]

        found, = allowed(Log("/diagnostics", DiagnosticArray).wait("an error", allowed))
        self.assertIn("the SRDF is not used: parameter '/odd_description_semantic': SRDF, line 1: "
                      "robot without name", found.message)

    def test_robots_that_cannot_be_had_are_refused_by_name(self):
        description = {"description": "/robot_description"}
        left, right = ({**description, "frame_prefix": side} for side in ("left/", "right/"))
        rospy.set_param("/broken_arm", "<robot name='r'><link></robot>")
        for name, robots, words in (
                ("clash", [left, right, left], "'left/base' is a link of robots[0], "),
                ("missing", [left, {"description": "/nowhere"}], "no text parameter '/nowhere'"),
                ("nameless", [left, {"frame_prefix": "a/"}], "~robots[1]/description is missing"),
                ("broken", [left, {"description": "/broken_arm"}], "parameter '/broken_arm': "),
                ("no_srdf", [left, {**right, "srdf": "/no.srdf"}], "~robots: srdf of "
                 "'/robot_description' with frame_prefix 'right/': '/no.srdf': ")):
            with self.subTest(name=name):
                code, output = start_and_fail("robots_" + name, {**GOOD, "robots": robots})
                self.assertGreater(code, 0, output)
                self.assertIn(words, output)

    def test_strict_geometry_refuses_a_missing_mesh_file(self):
        code, output = start_and_fail("strict", {**GOOD, "strict_geometry": True})
        self.assertGreater(code, 0, output)
        self.assertIn("no_such_package/meshes/lost.stl", output)


if __name__ == "__main__":
    rospy.init_node("startup_test")
    rostest.rosrun(PACKAGE, "startup", Startup, sys.argv)
