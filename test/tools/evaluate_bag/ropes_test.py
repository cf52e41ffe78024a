#!/usr/bin/env python3
"""Bags of ropes and grains around a finger that moves: contacts are the pairs at most the radius
apart, by an oracle in float64."""
import importlib.util

import numpy as np
import rospy

from evaluation_case import EvaluationCase, main
from adapted_messages import (
    cloud_message, line_triangles, path_message, poses_message, separate_points, strip_message)
from deformable_contact_monitor.msg import LinkMesh, LinkMeshes
from mesh_distance import pairs_within
from monitor_test_support import transform_message
from panda_bag import SOURCE
from pose_meshes import posed, read_obj
from ropes import NODES, RADIUS_M, rope_around

POSES = 1000
POSES_OF_OTHERS = 60
START = rospy.Time(1000)
BOX = read_obj(SOURCE / "test/ros/box.obj")
FINGER = ((BOX[0] * np.array((0.025, 0.025, 0.15)) / np.abs(BOX[0]).max(axis=0)).astype(np.float32),
          BOX[1])
TYPES = {"cloud": ("polyline", "point_cloud", cloud_message),
         "poses": ("polyline", "pose_array", poses_message),
         "strip": ("polyline", "marker", strip_message),
         "grains": ("points", None, cloud_message)}
if importlib.util.find_spec("nav_msgs"):
    TYPES["path"] = ("polyline", "path", path_message)


def stamp_of(frame):
    return START + rospy.Duration(frame // 15, frame % 15 * 66666667)


def finger_pose(random):
    quaternion = random.normal(size=4)
    return tuple(random.uniform(-1, 1, 3)), tuple(quaternion / np.linalg.norm(quaternion))


class Ropes(EvaluationCase):

    @classmethod
    def setUpClass(cls):
        random = np.random.default_rng(3)
        cls.poses = [finger_pose(random) for _ in range(POSES)]
        ropes = (rope_around(random).astype(np.float32) for _ in range(POSES))
        cls.ropes = [posed((rope, None), pose)[0] for rope, pose in zip(ropes, cls.poses)]

    def events(self):
        links = LinkMeshes(meshes=[LinkMesh("finger", "test", FINGER[0].flatten().tolist(),
                                            FINGER[1].flatten().tolist())])
        events = [(START - rospy.Duration(1), "/contact_monitor/robot_meshes", links)]
        for frame, (pose, rope) in enumerate(zip(self.poses, self.ropes)):
            stamp = stamp_of(frame)
            events.append((stamp, "/tf", transform_message(stamp, {"finger": ("base", pose)})))
            for name, (_, _, message_of) in TYPES.items():
                if name != "cloud" and frame >= POSES_OF_OTHERS:
                    continue
                message = message_of((rope, None))
                message.header.stamp, message.header.frame_id = stamp, "base"
                events.append((stamp + rospy.Duration(0, 5000000), "/" + name, message))
        return events

    def config(self):
        objects = []
        for name, (kind, message, _) in TYPES.items():
            chosen = f"message: {message}, " if message else ""
            objects.append(
                f"{{name: {name}, topic: /{name}, type: {kind}, {chosen}radius_m: {RADIUS_M}}}")
        return f"reference_frame: base\nobjects: [{', '.join(objects)}]\n"

    def test_contacts_are_exactly_the_pairs_within_the_radius(self):
        done = self.run_tool("--config", self.text("ropes.yaml", self.config()), "--pairs",
                             self.bag("ropes.bag", self.events()))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found, touched = self.pairs(), 0
        for frame, (pose, rope) in enumerate(zip(self.poses, self.ropes)):
            finger = {"finger": posed(FINGER, pose)}
            of_line = pairs_within(finger, "", (rope, line_triangles(NODES)), RADIUS_M)
            touched += bool(of_line)
            stamp = f"{stamp_of(frame).secs}.{stamp_of(frame).nsecs:09d}"
            for name in TYPES:
                if name != "cloud" and frame >= POSES_OF_OTHERS:
                    continue
                expected = of_line if name != "grains" else pairs_within(
                    finger, "", (rope, separate_points(NODES)), RADIUS_M)
                of_object = {(a, i, "", k) for a, i, b, k in found.get(stamp, ()) if b == name}
                self.assertEqual(of_object, expected, f"frame {frame} of {name}")
        self.assertGreater(touched, POSES / 5)
        self.assertLess(touched, 4 * POSES / 5)
        rows = self.summary()["topics"]
        self.assertEqual(rows["/cloud"]["messages"], POSES)
        self.assertEqual(rows["/grains"]["messages"], POSES_OF_OTHERS)


if __name__ == "__main__":
    main()
