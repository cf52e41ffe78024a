#!/usr/bin/env python3
"""Runs contact_test as rostest does, and checks the exit code, result file and text of each
failure."""
import concurrent.futures
import os
import socket
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import xml.etree.ElementTree as ElementTree

import rospy
import rostest
from dynamic_reconfigure.msg import Config, DoubleParameter
from rosgraph_msgs.msg import Clock

import boxes_scene
from boxes_scene import CLOTH, REFERENCE_FRAME
from monitor_test_support import PACKAGE, WAIT_S, MeshPublisher, Monitor, Transforms, executable
from played_monitor import PlayedMonitor, state

AT_ONCE = 6  # processes, so that none of them starves
SHORT_S = 3.0  # wait for what never comes; yet what is there must come within it


def run_contact_test(name, parameters, environment=None):
    """Exit code, failure ("" if there is none) and output of a contact_test of that name."""
    for parameter, value in {"link": "palm", "object": "cloth", **parameters}.items():
        rospy.set_param(f"/{name}/{parameter}", value)
    with tempfile.TemporaryDirectory() as folder:
        result = os.path.join(folder, "result.xml")
        ended = subprocess.run(
            [executable("contact_test"), "__name:=" + name, "--gtest_output=xml:" + result],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=3 * WAIT_S,
            universal_newlines=True, env={**os.environ, **(environment or {})})
        suite = ElementTree.parse(result).getroot()
    failures = [failure.text for failure in suite.iter("failure")]
    counts = [int(suite.get(count)) for count in ("tests", "failures", "errors")]
    if counts != [1, len(failures), 0]:
        raise AssertionError(f"{name}: no result of one test: {counts}\n{ended.stdout}")
    return ended.returncode, "".join(failures), ended.stdout


def near(distance_m):
    """A state of palm and cloth: NONE at an infinite distance."""
    made = state("NEAR" if distance_m < 9e9 else "NONE")
    made.min_separation = distance_m
    made.distance_low = 0.999 * distance_m if distance_m < 9e9 else 0.0
    return made


class ContactTestFailures(unittest.TestCase):

    def check(self, cases, environment=None):
        """cases: {name: (parameters, pattern of the failure, "" to pass)}"""
        with concurrent.futures.ThreadPoolExecutor(AT_ONCE) as pool:
            running = {name: pool.submit(run_contact_test, name, parameters, environment)
                       for name, (parameters, _) in cases.items()}
        problems = []
        for name, (_, pattern) in cases.items():
            code, failure, output = running[name].result()
            rospy.loginfo("%s: %s", name, failure.splitlines()[0] if failure else "passed")
            try:
                self.assertEqual(code, 1 if pattern else 0)
                self.assertRegex(failure, rf"\A{pattern}" if pattern else r"\A\Z")
                self.assertRegex(output, pattern or r"test_contact\] \.\.\. ok")
            except AssertionError as problem:
                problems.append(f"{name}: {problem}\n{output}")
        if problems:
            self.fail("\n".join(problems))

    def check_played(self, cases):
        """cases: {name: (parameters, pattern, PlayedMonitor's arguments by name)}"""
        for name, (_, _, played) in cases.items():
            PlayedMonitor("/played/" + name, **played)
        self.check({name: ({"monitor": "/played/" + name, **parameters}, pattern)
                    for name, (parameters, pattern, _) in cases.items()})

    def test_parameters(self):
        bad = {"state": "touching", "hold": 2, "within_s": -1, "object": 3}
        self.check({"bad_parameters": (bad, (
            "bad parameters: of /bad_parameters: hold is unknown; .*; object must be a name, not "
            r"3; within_s must be a number in \[0, 3600\], not -1; state must be one of none, "))})

    def test_the_monitor(self):
        missing = {"state": "none", "wait_s": SHORT_S}
        touching = {"play": lambda t: state("CONTACT", 5)}
        self.check_played({
            "runs": ({"state": "contact", "hold_s": 0.5, "min_pairs": 5, "max_pairs": 5}, "",
                     touching),
            "no_monitor": ({**missing, "monitor": "/nowhere"},
                           "monitor missing: nobody published /nowhere/contact_states within 3 s; "
                           ".* are on: .*/contact_monitor/contact_states", touching),
            "silent": (missing,
                       "monitor silent: /contact_test_failures.* advertises /played/silent/c",
                       {"play": lambda t: None}),
            "no_link": ({**missing, "link": "hand"},
                        "no such body: hand; /played/no_link has cloth, finger, palm", touching),
            "no_pair": ({**missing, "object": "finger"},
                        "pair not monitored: palm and finger; enable it in pair_classes", touching),
            "no_reason": (missing, "state unknown: the monitor gives no reason",
                          {"play": lambda t: state("UNKNOWN")})})

    def test_what_was_seen(self):
        contact = {"state": "contact", "within_s": 0.5}
        none = {"state": "none", "within_s": 0, "hold_s": 1.5}
        apart, touching = lambda t: state("NONE"), lambda t: state("CONTACT", 3)
        self.check_played({
            "wrong_state": (contact,
                            "wrong state: not palm and cloth in state contact within 0.5 s; seen "
                            r"in \d+ messages from [0-9.]+ to [0-9.]+: none \d+; 0 to 0 pairs",
                            {"play": apart}),
            "too_few": ({**contact, "min_pairs": 4}, "too few pairs: .*; 3 to 3 pairs",
                        {"play": touching}),
            "too_many": ({**contact, "max_pairs": 2}, "too many pairs: .*; 3 to 3 pairs",
                         {"play": touching}),
            "not_held": ({**contact, "hold_s": 3},
                         "not held: .*, for [01].[0-9]+ of 3 s, until it was near with 1 pairs",
                         {"play": lambda t: state("CONTACT", 3) if t < 1 else state("NEAR", 1)}),
            "turns_unknown": (none, "not held: .* until it was unknown .*; unknown because mesh "
                                    "stale: cloth: newest mesh is 0.7 s old",
                              {"play": lambda t: state("NONE") if t < 1 else
                               state("UNKNOWN", reason="cloth: newest mesh is 0.7 s old")}),
            "too_old": ({**none, "max_age_s": 0.5}, "too old: .*greatest age [0-9]",
                        {"play": apart, "stamp": lambda now, t: now - rospy.Duration(0.6)}),
            "time_jump": (none, "time jump: stamps went from", {
                "play": apart,
                "stamp": lambda now, t: now + rospy.Duration(60 if t > 1 else 0)}),
            "stops": (none, r"monitor silent: no message for [3-9].\d s",
                      {"play": lambda t: apart(t) if t < 0.5 else None}),
            "is_replaced": ({**none, "hold_s": 4}, r"monitor silent: no message for [3-9].\d s",
                            {"play": lambda t: None if 1 < t < 5 else state("NONE")}),
            "slow": ({**none, "wait_s": 4}, "too slow: undecided after 5.5 s",
                     {"play": apart, "stamp": lambda now, t: now - rospy.Duration(0.99 * t)})})

    def test_a_distance(self):
        keeps = {"keeps_m": 0.25, "hold_s": 1}
        for name in ("keeps", "keeps_beyond_the_margin", "nears", "turns_lost"):
            rospy.set_param(f"/played/{name}/margin_m", 0.25)
        rospy.set_param("/played/sees_little/margin_m", 0.1)
        self.check_played({
            "keeps": (keeps, "", {"play": lambda t: near(0.25)}),
            "keeps_beyond_the_margin": (keeps, "", {
                "play": lambda t: near(float("inf") if t < 0.5 else 0.3)}),
            "nears": ({**keeps, "hold_s": 5},
                      "not kept: palm and cloth keep 0.25 m, but near at 0.2 m at .*; seen in "
                      ".*least distance 0.2 m", {"play": lambda t: near(0.3 if t < 1 else 0.2)}),
            "turns_lost": ({**keeps, "hold_s": 5}, "not kept: .*, but unknown at .*; unknown "
                                                   "because mesh stale: cloth: newest mesh is 0.7",
                           {"play": lambda t: near(0.3) if t < 1 else
                            state("UNKNOWN", reason="cloth: newest mesh is 0.7 s old")}),
            "sees_little": (keeps, "margin too small: keeps_m is 0.25, but the monitor knows no "
                                   "distance of the two beyond its margin_m of 0.1 m; of /played/s",
                            {"play": lambda t: near(0.09)})})

    def test_a_margin_that_changes(self):
        """The parameter server may say what is not in force, and a margin may fall meanwhile."""
        for name in ("was_less", "becomes_less"):
            rospy.set_param(f"/played/{name}/margin_m", 0.25)

        def say(name, margin_m):
            updates[name].publish(Config(doubles=[DoubleParameter("margin_m", margin_m)]))
        updates = {name: rospy.Publisher(f"/played/{name}/parameter_updates", Config, latch=True,
                                         queue_size=1) for name in ("was_less", "becomes_less")}
        say("was_less", 0.1)
        say("becomes_less", 0.25)

        def falls_for_a_while(t):
            if 1 < t < 1.5:
                say("becomes_less", 0.1 if t < 1.25 else 0.25)
            return near(float("inf"))
        keeps = {"keeps_m": 0.25, "hold_s": 3}
        too_small = "margin too small: .* of 0.1 m; of /played/"
        self.check_played({
            "was_less": (keeps, too_small, {"play": lambda t: near(float("inf"))}),
            "becomes_less": (keeps, too_small, {"play": falls_for_a_while})})

    def test_two_monitors(self):
        rival = subprocess.Popen([sys.executable, "-c", """
import rospy
from deformable_contact_monitor.msg import ContactState, ContactStates
rospy.init_node("rival")
states = rospy.Publisher("/played/rivals/contact_states", ContactStates, queue_size=1)
while not rospy.is_shutdown():
    rospy.sleep(0.1)
    message = ContactStates(states=[ContactState(body_a="palm", body_b="cloth")])
    message.header.stamp = message.states[0].stamp = rospy.Time.now()
    states.publish(message)
"""])
        self.addCleanup(rival.wait)
        self.addCleanup(rival.kill)
        self.check_played({"rivals": (
            {"state": "none", "hold_s": 10}, "two monitors: .* and .* publish /played/rivals/",
            {"play": lambda t: state("NONE")})})

    def test_no_master(self):
        with socket.socket() as unused:
            unused.bind(("localhost", 0))  # does not listen
            uri = f"http://localhost:{unused.getsockname()[1]}"
            self.check({"no_master": ({}, f"master missing: no ROS master at {uri}")},
                       {"ROS_MASTER_URI": uri})

    def test_simulated_time(self):
        rospy.set_param("/use_sim_time", True)  # nobody else starts meanwhile
        self.addCleanup(rospy.delete_param, "/use_sim_time")
        self.check({"no_clock": ({"state": "none", "wait_s": SHORT_S},
                                 "clock missing: use_sim_time is set, but nothing came on")})
        begun = rospy.Time.now()

        def at_half_speed(now, _=None):
            return rospy.Time(1000) + (now - begun) * 0.5
        clock = rospy.Publisher("/clock", Clock, queue_size=10)
        timer = rospy.Timer(rospy.Duration(0.01),
                            lambda event: clock.publish(Clock(at_half_speed(event.current_real))))
        self.addCleanup(timer.shutdown)
        self.check_played({"half_speed": (
            {"state": "none", "within_s": 0, "hold_s": 1, "max_age_s": 0.5}, "",
            {"play": lambda t: state("NONE"), "stamp": at_half_speed})})

    def test_of_a_real_monitor(self):
        Monitor()  # waits for it
        transforms = Transforms()
        meshes = {name: MeshPublisher(name, "/" + name)
                  for name in ("cloth", "broken", "still", "adrift")}
        beyond = CLOTH[1] + len(CLOTH[0])
        begun = rospy.Time.now()
        transforms.send(begun, boxes_scene.edges(links=["finger"]))
        transforms.send(begun, boxes_scene.edges(links=["palm"]))
        meshes["still"].send(begun, REFERENCE_FRAME, CLOTH)
        ended = threading.Event()

        def feed():
            while not ended.is_set():
                stamp = rospy.Time.now()
                transforms.send(stamp, boxes_scene.edges(links=["palm"]))
                time.sleep(0.1)  # the monitor waits only 10 ms for a transform that is late
                meshes["cloth"].send(stamp, REFERENCE_FRAME, CLOTH)
                meshes["broken"].send(stamp, REFERENCE_FRAME, (CLOTH[0], beyond))
                meshes["adrift"].send(stamp, "nowhere", CLOTH)
                time.sleep(0.1)
        feeder = threading.Thread(target=feed)
        feeder.start()
        self.addCleanup(feeder.join)
        self.addCleanup(ended.set)
        time.sleep(1)  # for what came once to be too old
        missing = {"state": "none", "wait_s": SHORT_S}
        self.check({
            "touches": ({"state": "contact", "hold_s": 1, "min_pairs": 2, "max_age_s": 5}, ""),
            "no_mesh": ({**missing, "object": "absent"},
                        "mesh missing: absent: no mesh yet; no state of the pair within 3 s"),
            "bad_mesh": ({**missing, "object": "broken"}, "mesh refused: .*triangle 0"),
            "old_mesh": ({**missing, "object": "still"}, r"mesh stale: still: newest mesh is \d"),
            "no_frame": ({**missing, "object": "adrift"}, "TF missing: .*'nowhere' never seen"),
            "late_frame": ({**missing, "link": "finger"}, "TF late: .* is late: wanted"),
            "no_file": ({**missing, "link": "lost"}, "body unusable: .*no_such_package/meshes/"),
            "with_itself": ({**missing, "link": "cloth"}, "pair not monitored: cloth and cloth")})


if __name__ == "__main__":
    rospy.init_node("contact_test_failures")
    rostest.rosrun(PACKAGE, "contact_test_failures", ContactTestFailures, sys.argv)
