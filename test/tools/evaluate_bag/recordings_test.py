#!/usr/bin/env python3
"""evaluate_bag on recordings in any order and with parts missing: triangles that come late,
transforms wherever they are, joints instead of transforms, an object that is not there."""
import copy
import random

import rospy
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from evaluation_case import CONFIG, EvaluationCase, main, of_time, read_table
from monitor_test_support import mesh_message
from panda_bag import DATA, FRAMES, START, stamp_of
from panda_scene import READY, REFERENCE_FRAME
from pose_meshes import posed


class Recordings(EvaluationCase):

    def test_order_of_recording_does_not_matter(self):
        """Late transforms, shuffled meshes, static transforms at the end, bags in parts."""
        late = []
        for received, topic, message in self.events:
            delay = {"/tf": 1.5, "/tshirt": random.Random(str(received)).uniform(0, 0.3)}
            late.append((received + rospy.Duration(delay.get(topic, 0)), topic, message))
        late.sort(key=lambda event: event[0])
        # A keyframe that is late is missed by those before it, so all are keyframes here.
        late = [(t, topic, self.scene.shirt(round((m.header.stamp - START).to_sec() / 0.04)))
                if topic == "/tshirt" else (t, topic, m) for t, topic, m in late]
        stamps = [m.header.stamp for _, topic, m in late if topic == "/tshirt"]
        self.assertNotEqual(stamps, sorted(stamps))
        self.evaluate(self.bag("late.bag", late))
        self.assert_oracle_pairs()

        half = len(self.events) // 2
        parts = [self.bag("a.bag", self.events[:half]), self.bag("b.bag", self.events[half:])]
        self.evaluate(*reversed(parts))
        self.assert_oracle_pairs()

    def test_meshes_of_one_stamp_share_a_cycle(self):
        """The second object's are recorded three seconds later."""
        events = list(self.events)
        for received, topic, message in self.events:
            if topic == "/tshirt":
                frame = round((message.header.stamp - START).to_sec() / 0.04)
                other = self.scene.shirt(frame)
                other.object = "other"
                events.append((received + rospy.Duration(3), "/other", other))
        events.sort(key=lambda event: event[0])
        config = CONFIG.replace("}]", "}, {name: other, topic: /other}]")
        done = self.run_tool("--config", self.text("two.yaml", config), "--pairs",
                             self.bag("two.bag", events))
        self.assertEqual(done.returncode, 0, done.stderr)
        frames = read_table(self.path("out/frames.csv"))
        self.assertEqual([row["objects"] for row in frames], ["tshirt other"] * FRAMES)
        for row, pairs in zip(frames, self.expected.values()):
            self.assertEqual(int(row["pairs"]), 2 * len(pairs))

    def test_meshes_of_one_object_and_stamp_are_all_evaluated(self):
        """As of a clock that ticks slower than the meshes come. The later ones touch nothing."""
        events = []
        for received, topic, message in self.events:
            events.append((received, topic, message))
            if topic == "/tshirt":
                apart = copy.deepcopy(message)
                apart.vertices = [x + 50 for x in apart.vertices]
                events.append((received + rospy.Duration(0, 1000000), topic, apart))
        done = self.run_tool("--config", self.text("one.yaml", CONFIG),
                             self.bag("twice.bag", events))
        self.assertEqual(done.returncode, 0, done.stderr)
        frames = read_table(self.path("out/frames.csv"))
        wanted = [count for pairs in self.expected.values() for count in (len(pairs), 0)]
        self.assertEqual([int(row["pairs"]) for row in frames], wanted)

    def test_static_transforms_count_wherever_they_are(self):
        moving, static = [], TFMessage()
        for received, topic, message in self.events:
            if topic == "/tf":
                fixed = [t for t in message.transforms if t.child_frame_id == "panda_link8"]
                static.transforms = fixed
                message = TFMessage([t for t in message.transforms if t not in fixed])
            moving.append((received, topic, message))
        end = (moving[-1][0] + rospy.Duration(60), "/tf_static", static)
        self.evaluate(self.bag("static.bag", moving + [end]))
        self.assert_oracle_pairs()

    def test_an_object_that_is_not_in_the_bag(self):
        bag = str(DATA / "bags/pr2_arms_and_pressure.bag")
        summary = self.evaluate_pr2(bag, "--object", "cloth", "--vertices", "170", "--scale", "0.6", "--offset", "0.5", "0",
                                    "1.0", "--rate", "10", "--backends", "cpu,brute_force")
        self.assertGreater(summary["cycles"], 100)
        self.assertGreater(summary["runs"][0]["pairs"], 300)
        self.assertGreater(summary["runs"][0]["complete_cycles"], 100)
        self.assertEqual(summary["comparisons"][0]["cycles_that_differ"], 0)
        self.assertEqual(summary["topics"]["/tf"]["type"], "tf/tfMessage")
        shirt = [str(DATA / f"tshirt/{i:03d}.obj") for i in range(20)]
        summary = self.evaluate_pr2(bag, "--meshes", *shirt, "--scale", "0.09", "--name", "shirt",
                                    "--offset", "0.5", "-0.2", "0.8", "--rate", "20")
        self.assertEqual(summary["cycles"], 20)

    def with_meshes(self, mesh_of):
        """The scene with other meshes: mesh_of(frame)."""
        return [(t, topic, mesh_of(round((m.header.stamp - START).to_sec() / 0.04)))
                if topic == "/tshirt" else (t, topic, m) for t, topic, m in self.events]

    def test_triangles_that_come_later_are_taken(self):
        """A recording that began between two messages with triangles, or has them once."""
        for first in 5, FRAMES - 1:
            with self.subTest(first=first):
                summary = self.evaluate(self.bag(events=self.with_meshes(
                    lambda frame, first=first: self.scene.shirt(frame, keyframe=frame == first))))
                self.assert_oracle_pairs()
                self.assertEqual(summary["meshes_with_triangles_sent_later"], first)
        self.evaluate(self.bag())
        self.assertEqual(self.summary()["meshes_with_triangles_sent_later"], 0)

    def test_triangles_of_another_topology_are_not_taken(self):
        def mesh(frame):
            if frame < 3:  # another id
                return self.scene.shirt(frame, topology_id=7, keyframe=False)
            if frame < 6:  # other vertices under the same id
                shirt = self.scene.shirt(frame, keyframe=False)
                shirt.vertices = shirt.vertices[:-3]
                return shirt
            return self.scene.shirt(frame, keyframe=frame >= 8)
        summary = self.evaluate(self.bag(events=self.with_meshes(mesh)))
        self.assertEqual(summary["meshes_with_triangles_sent_later"], 2)
        rows = read_table(self.path("out/frames.csv"))
        self.assertEqual([row["complete"] for row in rows], 6 * ["no"] + (FRAMES - 6) * ["yes"])
        for row in rows[:6]:
            self.assertIn("no triangles of topology_id", row["skipped"])

    def test_an_object_that_pauses(self):
        """For longer than a mesh holds, and for less; its triangles came once, at the beginning."""
        kept = [frame for frame in range(FRAMES) if frame not in (3, 8, 9, 10, 11)]
        stamps = {stamp_of(frame) for frame in kept}
        events = [event for event in self.with_meshes(
            lambda frame: self.scene.shirt(frame, keyframe=frame == 0))
                  if event[1] != "/tshirt" or event[2].header.stamp in stamps]
        config = self.text("pause.yaml", CONFIG + "max_mesh_age_s: 0.1\nmotion: swept\n")
        done = self.run_tool("--config", config, self.bag(events=events))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(self.summary()["cycles"], len(kept))
        reasons = [row["reason"] for row in read_table(self.path("out/events.csv"))]
        self.assertIn("no new mesh within max_mesh_age_s", reasons)

    def test_a_gap_costs_nothing_of_what_was_before_it(self):
        """Two bags, a minute apart. TF keeps ten seconds, and the first one's last cycles wait for
        what may still come."""
        later = [(received + rospy.Duration(60), topic, of_time(message, 60))
                 for received, topic, message in self.events
                 if topic != "/contact_monitor/robot_meshes"]
        self.evaluate(self.bag(), self.bag("later.bag", later))
        rows = read_table(self.path("out/frames.csv"))
        self.assertEqual([row["complete"] for row in rows], 2 * FRAMES * ["yes"])
        self.assertEqual([row["pairs"] for row in rows[:FRAMES]],
                         [row["pairs"] for row in rows[FRAMES:]])

    def test_a_hostile_recording(self):
        """An object whose clock jumps back, triangles that come last or are rejected, a mesh of
        another size, transforms of a link that end and of another that come late."""
        events = []
        for received, topic, message in self.events:
            if topic == "/tf":
                frame = round((message.transforms[0].header.stamp - START).to_sec() / 0.04)
                late = [t for t in message.transforms if t.child_frame_id == "panda_hand"]
                kept = [t for t in message.transforms if t not in late
                        and (frame < 7 or t.child_frame_id != "panda_link3")]
                events.append((received + rospy.Duration(1.2), "/tf", TFMessage(late)))
                message = TFMessage(kept)
            if topic == "/tshirt":
                frame = round((message.header.stamp - START).to_sec() / 0.04)
                message = self.scene.shirt(frame, keyframe=frame in (9, 15))
                if frame == 15:
                    message.triangles = [*message.triangles[:-3], 0, 1, 99999999]
                other = self.scene.shirt(frame, keyframe=frame == FRAMES - 1)
                other.object = "other"
                other.header.stamp += rospy.Duration(.013 - (.6 if frame > 12 else 0))
                if frame == 5:
                    other.vertices = other.vertices[:-3]
                events.append((received + rospy.Duration(.1), "/other", other))
            events.append((received, topic, message))
        events.sort(key=lambda event: event[0])
        config = self.text("two.yaml", CONFIG.replace("}]", "}, {name: other, topic: /other}]"))
        bag = self.bag(events=events)
        for motion in ("", "motion: swept\n"):
            self.text("two.yaml", CONFIG.replace("}]", "}, {name: other, topic: /other}]") + motion)
            done = self.run_tool("--config", config, bag)
            self.assertEqual(done.returncode, 0, done.stderr)
            summary = self.summary()
            self.assertGreater(summary["runs"][0]["pairs"], 100)
            self.assertGreater(summary["meshes_with_triangles_sent_later"], 0)
            reasons = " ".join(entry["reason"] for entry in summary["runs"][0]["unknown"])
            for reason in ("is late", "mesh refused", "vertex coordinates"):
                self.assertIn(reason, reasons)

    def joint_states(self, frame):
        """What the scene's transforms were made of; the second finger mimics the first."""
        state = JointState()
        state.header.stamp = stamp_of(frame)
        state.name = [f"panda_joint{i + 1}" for i in range(7)] + ["panda_finger_joint1"]
        state.position = [angle + 0.02 * frame for angle in READY] + [0.02]
        return state

    def joint_events(self):
        return [(stamp_of(f) + rospy.Duration(0, 3000000), "/joint_states", self.joint_states(f))
                for f in range(-1, FRAMES + 1)]

    def without_tf(self):
        """The shirt where TF would have it."""
        events = []
        for received, topic, message in self.events:
            if topic == "/tshirt":
                frame = round((message.header.stamp - START).to_sec() / 0.04)
                mesh = posed(self.scene.panda.shirt_mesh(frame),
                             self.scene.edges(frame)["shirt"][1])
                message = mesh_message("tshirt", message.header.stamp, REFERENCE_FRAME, mesh)
            if topic != "/tf":
                events.append((received, topic, message))
        return events

    def evaluate_joints(self, events, **options):
        """With joint states and the URDF; the frames that they say."""
        bag = self.bag(events=sorted(events + self.joint_events(), key=lambda event: event[0]))
        summary = self.evaluate(bag, "--robot-description", self.scene.panda.urdf, **options)
        return set(summary["poses"]["joint_states_frames"])

    def test_joint_states_pose_the_links_where_there_is_no_tf(self):
        children = {joint.find("child").get("link") for joint in self.scene.panda.joints}
        self.assertEqual(self.evaluate_joints(self.without_tf(), report=True), children)
        self.assert_oracle_pairs()
        self.assertIn("from /joint_states and the URDF: ", self.report())
        # The shirt's frame by TF, the robot's by joints.
        shirt = [(t, topic, TFMessage([x for x in m.transforms if x.child_frame_id == "shirt"]))
                 if topic == "/tf" else (t, topic, m) for t, topic, m in self.events]
        self.assertEqual(self.evaluate_joints(shirt), children)
        self.assert_oracle_pairs()

    def test_transforms_go_before_joint_states(self):
        """Joints that stand elsewhere change nothing where TF has the frame."""
        def lie(frame):
            state = self.joint_states(frame)
            state.position = [0.3] * len(state.position)
            return state
        lies = [(t, topic, lie(round((m.header.stamp - START).to_sec() / 0.04)))
                for t, topic, m in self.joint_events()]
        bag = self.bag(events=sorted(self.events + lies, key=lambda event: event[0]))
        summary = self.evaluate(bag, "--robot-description", self.scene.panda.urdf)
        self.assert_oracle_pairs()
        self.assertEqual(summary["poses"]["joint_states_frames"], [])
        self.assertEqual(summary["poses"]["tf_frames"], len(self.scene.edges(0)))

    def test_joints_that_were_not_recorded_leave_their_links_unknown(self):
        events = self.without_tf()
        joints = []
        for received, topic, state in self.joint_events():
            state.name, state.position = state.name[:6], state.position[:6]
            joints.append((received, topic, state))
        bag = self.bag(events=sorted(events + joints, key=lambda event: event[0]))
        self.evaluate(bag, "--robot-description", self.scene.panda.urdf)
        states = {}
        for row in read_table(self.path("out/links.csv")):
            states.setdefault(row["body_a"], set()).add(row["state"])
        for link in ("panda_link7", "panda_hand", "panda_leftfinger"):
            self.assertEqual(states[link], {"UNKNOWN"})
        for link in ("panda_link0", "panda_link1", "panda_link6"):
            self.assertNotIn("UNKNOWN", states[link])

    def test_joint_states_alone_move_a_played_cloth(self):
        bag = self.bag("joints.bag", self.joint_events())
        done = self.run_tool(bag, "--robot-description", self.scene.panda.urdf, "--object", "cloth", "--vertices", "64",
                             "--offset", "0.6", "0", "1.2", "--rate", "20")
        self.assertEqual(done.returncode, 0, done.stderr)
        run = self.summary()["runs"][0]
        self.assertEqual((run["cycles"], run["complete_cycles"]), (17, 17))
        self.assertIn("stand where /joint_states and the URDF say", done.stdout)

    def test_a_simulation_that_undoes_steps_says_so(self):
        events = self.joint_events()
        for number, (_, _, state) in enumerate(events):
            state.position = [3 * (number % 2) + position for position in state.position]
        bag = self.bag("leaps.bag", events)
        done = self.run_tool(bag, "--robot-description", self.scene.panda.urdf, "--object", "cloth", "--vertices", "256",
                             "--offset", "0.4", "0", "0.7", "--rate", "50")
        self.assertRegex(done.stderr, "warning: object 'cloth': the simulation undid a step in [1-9][0-9]* of its "
                                      "states, and the object stayed where it was; the first time: .*would move at")

    def test_a_played_object_ends_with_the_transforms(self):
        """The robot's casters are the first whose transforms end."""
        summary = self.evaluate_pr2(str(DATA / "bags/pr2_arms_and_pressure.bag"), "--object", "cloth", "--vertices", "36",
                                    "--scale", "0.6", "--offset", "0.5", "0", "1.0")
        run = summary["runs"][0]
        self.assertGreater(run["cycles"], 300)
        self.assertEqual(run["complete_cycles"], run["cycles"])


if __name__ == "__main__":
    main()
