#!/usr/bin/env python3
"""evaluate_bag in parts: whatever the seams, what is joined is byte for byte what one run writes,
but for times."""
import csv
import io
import json
import os
import pathlib
import shutil
import subprocess
import sys

import rospy
from sensor_msgs.msg import JointState
from tf2_msgs.msg import TFMessage

from evaluation_case import CONFIG, DATA, TOOL, main, read_table
from panda_bag import FRAMES, stamp_of
from panda_scene import READY, SHIRT_FRAME
from parts_case import SWEPT, PartsCase, frame_of

EVERY_SEAM = FRAMES  # so many parts have a cycle each
RULES = "debounce_on_cycles: 2\ndebounce_off_cycles: 3\nsince_survives_s: 0.1\n"


def without_times(path):
    """A file's bytes; times are columns that end in _ms, and "times" in summary.json."""
    data = pathlib.Path(path).read_bytes()
    if path.endswith("summary.json"):
        summary = json.loads(data)
        assert summary.pop("times")["runs"], "no times"
        return json.dumps(summary, indent=2).encode()
    if not path.endswith("frames.csv"):
        return data
    rows = list(csv.reader(io.StringIO(data.decode(), newline="")))
    times = [i for i, name in enumerate(rows[0]) if name.endswith("_ms")]
    assert len(times) > 3, rows[0]
    for row in rows[1:]:
        for i in times:
            assert float(row[i]) >= 0, row
            row[i] = "0"
    text = io.StringIO(newline="")
    csv.writer(text, lineterminator="\n").writerows(rows)
    return text.getvalue().encode()


class Parts(PartsCase):

    def cycles_in(self, path):
        with open(path) as file:
            lines = file.read().splitlines()
        return [json.loads(line)["cycle"] for line in lines[1:-1]]

    @staticmethod
    def said(done):
        """Warnings and the refusal, without progress."""
        return "\n".join(line for line in done.stderr.splitlines()
                         if line.startswith("evaluate_bag: "))

    def assert_like_one_run(self, counts, arguments, code=0):
        """The single run's summary, after a look at the joined ones."""
        one, joined = self.path("one"), self.path("joined")
        done = self.tool(*arguments, "--out", one)
        self.assertEqual(done.returncode, code, done.stdout + done.stderr)
        with open(one + "/summary.json") as file:
            summary = json.load(file)
        for count in counts:
            with self.subTest(parts=count):
                files = self.write_parts(count, arguments)
                cycles = [self.cycles_in(path) for path in files]
                self.assertEqual(sum(cycles, []), list(range(1, summary["cycles"] + 1)))
                self.assertGreater(sum(bool(part) for part in cycles), min(count, 2) - 1)
                again = self.tool(*arguments, "--out", joined, "--join", *reversed(files))
                self.assertEqual(again.returncode, code, again.stdout + again.stderr)
                self.assertEqual(self.said(again), self.said(done).replace(one, joined))
                self.assertEqual(sorted(os.listdir(one)), sorted(os.listdir(joined)))
                for name in os.listdir(one):
                    if name != "report.html":
                        self.assertEqual(without_times(f"{one}/{name}"),
                                         without_times(f"{joined}/{name}"), name)
                shutil.rmtree(joined)
        return summary

    def test_every_seam(self):
        summary = self.assert_like_one_run((1, 2, 3, 4, 5, 6, EVERY_SEAM),
                                           self.arguments(CONFIG + RULES))
        self.assertGreater(summary["runs"][0]["pairs"], 100)
        self.assertEqual(summary["cycles"], FRAMES)

    def test_every_seam_in_swept_motion(self):
        summary = self.assert_like_one_run((2, 3, EVERY_SEAM),
                                           self.arguments(CONFIG + RULES + SWEPT))
        self.assertGreater(summary["runs"][0]["swept"]["pairs"], 100)
        self.assertEqual(summary["runs"][0]["swept"]["cycles_with_a_step"], FRAMES - 1)

    def test_seams_within_a_debounce(self):
        """Contacts of one to four cycles, with pauses as long."""
        touching = {1, 3, 4, 7, 8, 9, 11, 13, 14, 15, 16}
        bag = self.bag(events=self.touching(touching))
        for motion in ("", SWEPT):
            self.assert_like_one_run((EVERY_SEAM,), self.arguments(CONFIG + RULES + motion, bag), 1)
            types = [row["type"] for row in read_table(self.path("one/events.csv"))]
            self.assertGreater(types.count("BEGIN"), 1)
            self.assertGreater(types.count("END"), 0)

    def test_an_object_that_pauses(self):
        """For longer than a mesh holds, and for less; its triangles came once, at the beginning."""
        events = []
        for received, topic, message in self.events:
            if topic == "/tshirt":
                if frame_of(message) in (3, 8, 9, 10, 11):
                    continue
                message = self.scene.shirt(frame_of(message), keyframe=frame_of(message) == 0)
            events.append((received, topic, message))
        bag = self.bag(events=events)
        for motion in ("", SWEPT):
            summary = self.assert_like_one_run(
                (4, 15), self.arguments(CONFIG + RULES + "max_mesh_age_s: 0.1\n" + motion, bag))
            self.assertEqual(summary["cycles"], 15)
            reasons = [row["reason"] for row in read_table(self.path("one/events.csv"))]
            self.assertIn("no new mesh within max_mesh_age_s", reasons)

    def hostile(self):
        """Two objects with clocks of their own, one of which jumps back; triangles that come last,
        or are refused; a mesh of another size; transforms of a link that end, and of the hand that
        come late; a static one behind all."""
        events, static = [], TFMessage()
        for received, topic, message in self.events:
            if topic == "/tf":
                frame = frame_of(message.transforms[0])
                fixed = [t for t in message.transforms if t.child_frame_id == "panda_link8"]
                static.transforms = fixed
                late = [t for t in message.transforms if t.child_frame_id == "panda_hand"]
                kept = [t for t in message.transforms if t not in fixed + late
                        and (frame < 7 or t.child_frame_id != "panda_link3")]
                events.append((received + rospy.Duration(1.2), "/tf", TFMessage(late)))
                message = TFMessage(kept)
            if topic == "/tshirt":
                frame = frame_of(message)
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
        return [*events, (events[-1][0] + rospy.Duration(60), "/tf_static", static)]

    def test_a_hostile_recording(self):
        config = CONFIG.replace("}]", "}, {name: other, topic: /other}]") + RULES
        bag = self.bag(events=self.hostile())
        for motion in ("", SWEPT):
            summary = self.assert_like_one_run((2, 3, 40), self.arguments(config + motion, bag), 1)
            self.assertGreater(summary["runs"][0]["pairs"], 100)
            self.assertGreater(summary["meshes_with_triangles_sent_later"], 0)
            reasons = " ".join(entry["reason"] for entry in summary["runs"][0]["unknown"])
            for reason in ("is late", "mesh refused", "vertex coordinates"):
                self.assertIn(reason, reasons)

    def test_margins_what_is_within_and_two_runs(self):
        config = (CONFIG + "margin_m: 0.02\ncontainment: true\n"
                  "pair_classes: [robot_deformable, deformable_self]\n")
        summary = self.assert_like_one_run((3,), [
            *self.arguments(config), "--backends", "cpu,brute_force"])
        self.assertEqual(summary["comparisons"][0]["cycles_that_differ"], 0)
        states = {row["state"] for row in read_table(self.path("one/links.csv"))}
        self.assertLessEqual({"NEAR", "CONTACT", "NONE"}, states)

    def test_objects_of_other_types(self):
        shapes = [(stamp_of(frame), "/shape", self.scene.shape(frame)) for frame in range(FRAMES)]
        others = [(stamp_of(frame) + rospy.Duration(1), topic, message) for frame in range(FRAMES)
                  for topic, message in (("/marker", self.scene.marker(frame)),
                                         ("/cloud", self.scene.cloud(frame)))]
        faces = DATA / "tshirt/000.obj"
        objects = [f"{{name: shape, topic: /shape, type: shape_mesh, frame_id: {SHIRT_FRAME}}}",
                   "{name: marker, topic: /marker, type: marker}",
                   f"{{name: cloud, topic: /cloud, type: point_cloud, faces: {faces}}}"]
        config = CONFIG.replace("}]", "}, " + ", ".join(objects) + "]")
        self.assert_like_one_run((3, EVERY_SEAM), self.arguments(
            config, self.bag(events=shapes + self.events + others)))

    def test_a_played_object(self):
        self.assert_like_one_run((3,), [
            str(DATA / "bags/pr2_arms_and_pressure.bag"), "--robot-description",
            str(DATA / "bags/pr2.urdf"), "--cloth", "300", "--scale", "0.6", "--offset", "0.5", "0",
            "1.0", "--rate", "5", "--no-report", "--pairs"])

    def test_joints_instead_of_transforms(self):
        """Poses by forward kinematics."""
        angles = [(received, message) for received, topic, message in self.events
                  if topic == "/tf"]
        events = [event for event in self.events if event[1] != "/tf"]
        for received, message in angles:
            frame = frame_of(message.transforms[0])
            state = JointState(name=[f"panda_joint{i + 1}" for i in range(7)]
                               + ["panda_finger_joint1", "panda_finger_joint2"],
                               position=[angle + 0.02 * frame for angle in READY] + [.02, .02])
            state.header.stamp = message.transforms[0].header.stamp
            shirt = TFMessage([t for t in message.transforms if t.child_frame_id == SHIRT_FRAME])
            events += [(received, "/joint_states", state), (received, "/tf", shirt)]
        bag = self.bag(events=sorted(events, key=lambda event: event[0]))
        urdf = str(DATA / "robots/panda_description/urdf/panda.urdf")
        summary = self.assert_like_one_run((3, EVERY_SEAM), [
            *self.arguments(CONFIG + RULES + SWEPT, bag), "--robot-description", urdf])
        self.assertIn("panda_hand", summary["poses"]["joint_states_frames"])
        self.assertGreater(summary["runs"][0]["pairs"], 100)

    def test_a_damaged_bag(self):
        """What could be read is the same, and so is the exit code."""
        data = bytearray(pathlib.Path(self.bag(chunk=4096)).read_bytes())
        at = data.index(b"tshirt", len(data) // 2)
        data[at - 4:at] = b"\xff\xff\xff\x7f"
        pathlib.Path(self.path("damaged.bag")).write_bytes(data)
        self.assert_like_one_run((3,), self.arguments(CONFIG, self.path("damaged.bag")), 2)

    def test_the_report(self):
        """Drawn from tables without times, it is the same, byte for byte."""
        arguments = [word for word in self.arguments(CONFIG + SWEPT) if word != "--no-report"]
        self.tool(*arguments, "--out", self.path("one"))
        files = self.write_parts(3, arguments)
        self.tool(*arguments, "--out", self.path("joined"), "--join", *files)
        reports = []
        for name in ("one", "joined"):
            folder = self.path(name)
            self.assertIn("Who touches whom", pathlib.Path(folder, "report.html").read_text())
            with open(folder + "/summary.json") as file:
                summary = json.load(file)
            summary["times"] = json.loads(json.dumps(summary["times"]), parse_float=lambda _: 1.)
            pathlib.Path(folder, "frames.csv").write_bytes(without_times(folder + "/frames.csv"))
            with open(folder + "/summary.json", "w") as file:
                json.dump(summary, file)
            subprocess.run([sys.executable, os.path.dirname(TOOL) + "/evaluation_report.py",
                            folder], check=True, timeout=300)
            reports.append(pathlib.Path(folder, "report.html").read_bytes())
        self.assertEqual(*reports)


if __name__ == "__main__":
    main()
