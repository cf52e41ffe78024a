#!/usr/bin/env python3
"""Replays bags to a monitor and evaluates them: the states of each cycle and its pairs must be the
same. The monitor may say UNKNOWN for lack of time: it lost a mesh, or a transform came too late."""
import collections
import csv
import os
import shutil
import subprocess
import sys
import tempfile
import unittest

import rosbag
import rospy
import rostest
import yaml
from rosbag.migration import MessageMigrator, fixbag2

from monitor_test_support import (
    PACKAGE, ContactState, Monitor, executable, grid, mesh_message, pairs_of, pose_from,
    transform_message, wait_until)
from pose_meshes import posed
from pr2_bag import FIXED_FRAME, recorded_transforms

SOURCE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")
ALL = bool(os.environ.get("DCM_REPLAY_ALL"))  # bags as long and as fast as they were recorded
STATES = {getattr(ContactState, name): name for name in
          ("NONE", "NEAR", "CONTACT", "ALLOWED", "UNKNOWN", "PASSED")}
# Reasons for UNKNOWN that more time or an earlier start would have removed.
LACK_OF_TIME = ("is late", "never seen", "no robot received yet", "no longer reaches back",
                "no triangles of topology_id", "no new mesh", "not looked at yet")


def ns(stamp):
    """A stamp [ns] as evaluate_bag writes it."""
    return int(stamp.replace(".", ""))


class Evaluation:
    """What evaluate_bag finds: stamps [ns] of its cycles, pairs by stamp and bodies, states."""

    def __init__(self, bag, config, options, out):
        subprocess.run([executable("evaluate_bag"), bag, "--config", config, "--out", out, "--pairs",
                        "--no-report", *options], check=True, timeout=100,
                       stdout=subprocess.DEVNULL)
        def rows(name):
            with open(os.path.join(out, name), newline="") as file:
                return list(csv.DictReader(file))
        self.stamps = {ns(row["stamp"]) for row in rows("frames.csv")}
        self.pairs = {}
        for row in rows("pairs.csv"):
            of_bodies = self.pairs.setdefault((ns(row["stamp"]), row["body_a"], row["body_b"]), set())
            of_bodies.add((int(row["triangle_a"]), int(row["triangle_b"])))
        self.stretches = {}
        for row in rows("links.csv"):
            self.stretches.setdefault((row["body_a"], row["body_b"]), []).append(
                (ns(row["from"]), ns(row["to"]), row["state"]))

    def state(self, bodies, stamp):
        """The state of two bodies in the cycle of that stamp; None: they had none."""
        found = {state for first, last, state in self.stretches.get(bodies, [])
                 if first <= stamp <= last}
        assert len(found) <= 1, (bodies, stamp, found)
        return found.pop() if found else None


def found_by(monitor, stamps):
    """{(stamp [ns], body_a, body_b): (state, reason, pairs)} of the monitor's cycles at these stamps.
    Objects of one stamp may have one cycle or several."""
    states = {}
    for message in list(monitor.states.messages):
        states.setdefault((message.cycle, message.header.stamp.to_nsec()), message)
    found = {}
    for contacts in list(monitor.contacts.messages):
        stamp = contacts.header.stamp.to_nsec()
        of_cycle = states.get((contacts.cycle, stamp))
        if stamp not in stamps or of_cycle is None:
            continue
        triggered = {body for body, own in zip(contacts.bodies, contacts.triggered) if own}
        pairs = pairs_of(contacts)
        for state in of_cycle.states:
            a, b = state.body_a, state.body_b
            if triggered & {a, b} and state.state != ContactState.ALLOWED:
                found[stamp, a, b] = (STATES[state.state], state.reason,
                                      {(i, j) for c, i, d, j in pairs if (c, d) == (a, b)})
    return found


class ReplayedBags(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.data = rospy.get_param("~data")
        cls.count = 0
        rospy.set_param("/use_sim_time", True)

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, *names):
        return os.path.join(self.data, *names)

    def start(self, *command):
        process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL)
        self.addCleanup(process.wait, 30)
        self.addCleanup(process.terminate)
        return process

    def monitor(self, config, urdf):
        """A monitor with these parameters. Its links come from a topic if there is no URDF."""
        type(self).count += 1
        name = f"/replay_{self.count}"
        rospy.set_param(name, dict(config, robot_description=name[1:] + "_urdf",
                                   robot_source="urdf" if urdf else "topic"))
        if urdf:
            with open(urdf) as file:
                rospy.set_param(name + "_urdf", file.read())
        self.start(executable("contact_monitor"), "__name:=" + name[1:])
        return Monitor(name)

    def publish_robot_state(self, joint_states, urdf):
        """Starts a robot_state_publisher, which makes /tf of the joint states on that topic."""
        with open(urdf) as file:
            rospy.set_param("/robot_description", file.read())
        self.addCleanup(rospy.delete_param, "/robot_description")
        self.start(executable("robot_state_publisher", "robot_state_publisher"),
                   f"joint_states:={joint_states}")

    def check(self, bag, config, urdf=None, rate=1.0, options=(), link_meshes=None, joint_states=None,
              most_lacking=0, least_share=0.5):
        """Replays and evaluates. `joint_states`: the topic of what /tf is made of, instead of the
        bag's; `most_lacking`: how many cycles lack time, whatever the machine; `least_share`: of the
        evaluated cycles, how many the monitor must have."""
        config = dict(config, tf_timeout_s=1.0)
        with open(os.path.join(self.folder, "config.yaml"), "w") as file:
            yaml.safe_dump(config, file)
        options = [*options, *(["--robot-description", urdf] if urdf else [])]
        evaluation = Evaluation(bag, file.name, options, os.path.join(self.folder, "out"))
        self.assertGreater(len(evaluation.stamps), 10)

        monitor = self.monitor(config, urdf)
        if joint_states:
            self.publish_robot_state(joint_states, urdf)
        topics = [*([joint_states] if joint_states else ["/tf", "/tf_static"]),
                  *(o["topic"] for o in config["objects"]), *([link_meshes] if link_meshes else [])]
        with rosbag.Bag(bag) as opened:
            recorded = set(opened.get_type_and_topic_info().topics)
        topics = [name for topic in topics for name in (topic, topic[1:]) if name in recorded]
        remapped = [f"{link_meshes}:={monitor.name}/robot_link_meshes"] if link_meshes else []
        player = self.start(
            "rosrun", "rosbag", "play", "--quiet", "--clock", "--hz=200", "--delay=0.5",
            "--wait-for-subscribers", "--rate", str(1 if ALL else rate), bag, *remapped,
            "--topics", *topics)
        wait_until(lambda: player.poll() is not None or monitor.contacts.count() > 0, "a cycle")
        player.wait(300)
        last = [max(evaluation.stamps)]
        wait_until(lambda: found_by(monitor, last), "the last cycle")
        found = found_by(monitor, evaluation.stamps)
        print(f"{os.path.basename(bag)}: {len({stamp for stamp, _, _ in found})} of "
              f"{len(evaluation.stamps)} cycles replayed,", end=" ")
        self.compare(found, evaluation, most_lacking, least_share)

    def compare(self, found, evaluation, most_lacking, least_share):
        lacking, states = set(), collections.Counter()
        for (stamp, a, b), (state, reason, pairs) in sorted(found.items()):
            with self.subTest(stamp=stamp, a=a, b=b, reason=reason):
                wanted = evaluation.state((a, b), stamp)
                if state == "UNKNOWN" and wanted not in (None, "UNKNOWN"):
                    self.assertTrue(any(text in reason for text in LACK_OF_TIME))
                    lacking.add(stamp)
                    continue
                self.assertEqual(state, wanted)
                self.assertEqual(pairs, evaluation.pairs.get((stamp, a, b), set()))
                states[state] += 1
        equal = ", ".join(f"{count} {state}" for state, count in sorted(states.items()))
        print(f"{len(lacking)} lacked time; equal states: {equal}", flush=True)
        stamps = {stamp for stamp, _, _ in found}
        self.assertGreater(len(stamps), least_share * len(evaluation.stamps))
        self.assertLessEqual(len(lacking), most_lacking + len(evaluation.stamps) // 10)
        self.assertTrue(set(states) - {"UNKNOWN"})

    def check_field(self, name, urdf="finger.urdf", rate=1.0, parameters=None, **more):
        """A bag whose object has its mesh on /cloth/mesh."""
        config = {"reference_frame": "base_link",
                  "objects": [{"name": "cloth", "topic": "/cloth/mesh"}], **(parameters or {})}
        self.check(self.path("field/bags", name), config,
                   urdf and self.path("field/bags", urdf), rate=rate, **more)

    def test_a_static_transform_that_changes(self):
        self.check_field("static_twice.bag", rate=5)

    def test_link_meshes_that_change(self):
        self.check_field("tool_change.bag", urdf=None, rate=5,
                         link_meshes="/contact_monitor/robot_meshes")

    def test_transforms_on_another_topic(self):
        self.check_field("ghost_tf.bag", rate=2)

    def test_frames_with_a_prefix(self):
        self.check_field("prefixed.bag", rate=2,
                         parameters={"frame_prefix": "left/", "reference_frame": "world"})

    def test_topics_without_a_slash(self):
        self.check_field("no_slash.bag", rate=2)

    def test_joint_states_alone(self):
        topic = "/robot/joint_states"
        self.check_field("robot_joints.bag", rate=2, joint_states=topic,
                         options=("--joint-states", topic))

    def test_link_meshes_of_two_monitors(self):
        for topic in ("/left_monitor/robot_meshes", "/right_monitor/robot_meshes"):
            with self.subTest(topic=topic):
                self.check_field("two_monitors.bag", urdf=None, rate=2, link_meshes=topic,
                                 options=("--robot-meshes-topic", topic))

    def test_two_cameras_see_one_cloth(self):
        """The one has it at the finger, the other elsewhere."""
        for topic in ("/cam1/mesh", "/cam2/mesh"):
            with self.subTest(topic=topic):
                self.check(self.path("field/bags/same_name_twice.bag"),
                           {"reference_frame": "base_link",
                            "objects": [{"name": "cloth", "topic": topic}]},
                           self.path("field/bags/finger.urdf"), rate=2)

    def test_what_comes_late(self):
        """Two objects whose meshes and transforms have a delay, in a frame whose static transform is
        recorded after a second, and again after two."""
        bag = os.path.join(self.folder, "late.bag")
        start = rospy.Time(1000)
        def transforms(stamp, frame, z):
            return transform_message(stamp, {frame: ("base_link", ((0, 0, z), (0, 0, 0, 1)))})
        events = [(start + rospy.Duration(0.99 + i), "/tf_static", transforms(start, "camera", i))
                  for i in range(2)]
        for i in range(60):
            stamp = start + rospy.Duration(0.05 * i)
            events.append((stamp + rospy.Duration(0.08), "/tf", transforms(stamp, "finger", 0)))
            for name, delay in ("near", 0.01), ("far", 0.16):
                mesh = mesh_message(name, stamp, "camera", grid(4, 0.15, 0.01))
                events.append((stamp + rospy.Duration(delay), "/" + name, mesh))
        with rosbag.Bag(bag, "w") as written:
            for received, topic, message in sorted(events, key=lambda event: event[0]):
                written.write(topic, message, received)
        self.check(bag, {"reference_frame": "base_link",
                         "objects": [{"name": name, "topic": "/" + name} for name in
                                     ("near", "far")]},
                   self.path("field/bags/finger.urdf"), most_lacking=20)

    def test_a_cloth_in_the_gripper_of_a_pr2(self):
        """The bag has no mesh, so a cloth is added that goes through the right gripper."""
        source = self.path("bags/pr2_arms_and_pressure.bag")
        bag = os.path.join(self.folder, "pr2.bag")
        recorded = recorded_transforms(source)
        with rosbag.Bag(source) as pr2, rosbag.Bag(bag, "w") as written:
            begin = rospy.Time.from_sec(pr2.get_start_time() + 1.5)
            end = begin + rospy.Duration(10 if ALL else 2)
            for topic, message, received in pr2.read_messages("/tf", end_time=end):
                written.write(topic, message, received)
            for i in range(40):
                stamp = begin + (end - begin) * (i / 40) - rospy.Duration(0.3)
                in_gripper = (grid(20, 0.12)[0] + [0.02, 0, 0.06 - 0.003 * i], grid(20, 0.12)[1])
                pose = pose_from(recorded, FIXED_FRAME, "r_gripper_tool_frame", stamp)
                mesh = mesh_message("cloth", stamp, FIXED_FRAME, posed(in_gripper, pose),
                                    keyframe=i % 5 == 0)
                written.write("/cloth", mesh, stamp + rospy.Duration(0.1))
        self.check(bag, {"reference_frame": "base_link",
                         "objects": [{"name": "cloth", "topic": "/cloth"}]},
                   self.path("bags/pr2.urdf"))

    def test_a_bag_of_version_0_1(self):
        """It begins between two meshes that have triangles. An evaluation reads ahead to the second
        one; a monitor has no cycle before."""
        bag = os.path.join(self.folder, "migrated.bag")
        rules = MessageMigrator([os.path.join(SOURCE, "msg", name)
                                 for name in ("from_0_1.bmr", "from_0_2.bmr")], False)
        old = os.path.join(SOURCE, "test/tools/bags/recorded_0_1.bag")
        self.assertEqual(fixbag2(rules, old, bag), [])
        with open(os.path.join(SOURCE, "config/demo.yaml")) as file:
            config = yaml.safe_load(file)
        self.check(bag, config, link_meshes="/contact_monitor/robot_meshes", most_lacking=10,
                   least_share=0.2)


if __name__ == "__main__":
    rospy.init_node("replayed_bags_test")
    rostest.rosrun(PACKAGE, "replayed_bags", ReplayedBags, sys.argv)
