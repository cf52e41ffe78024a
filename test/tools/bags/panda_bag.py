"""A Panda pushing into a T-shirt as a bag, and the contacts that the oracle finds in it."""
import os
import pathlib
import sys

import rosbag
import rospy
import tf2_py

SOURCE = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(SOURCE / "test/ros"))

# pylint: disable=wrong-import-position
from deformable_contact_monitor.msg import LinkMesh, LinkMeshes
from adapted_messages import cloud_message, marker_message, shape_message
from monitor_test_support import (
    mesh_message, oracle_pairs, pose_from, posed_links, transform_message)
from panda_scene import REFERENCE_FRAME, SHIRT_FRAME, Panda
from pose_meshes import posed

DATA = pathlib.Path(os.environ.get("DCM_TEST_DATA") or SOURCE / "../shared/data")
FRAMES = 20
PERIOD = rospy.Duration(0, 40000000)
START = rospy.Time(1000, 123456789)
KEYFRAME_EVERY = 5
AWAY_FROM = 15  # this frame on the shirt is far off


def stamp_of(frame):
    return START + rospy.Duration.from_sec(frame * PERIOD.to_sec())


class PandaBag:

    def __init__(self):
        self.panda = Panda(str(DATA))

    def edges(self, frame):
        return self.panda.edges_at(frame, (0.35, 0.05, 2.5 if frame >= AWAY_FROM else 0.5))

    def shirt(self, frame, **arguments):
        return mesh_message("tshirt", stamp_of(frame), SHIRT_FRAME, self.panda.shirt_mesh(frame),
                            **arguments)

    def shape(self, frame):
        return shape_message(self.panda.shirt_mesh(frame))

    def marker(self, frame):
        return self._stamped(frame, marker_message(self.panda.shirt_mesh(frame)))

    def cloud(self, frame):
        return self._stamped(frame, cloud_message(self.panda.shirt_mesh(frame)))

    @staticmethod
    def _stamped(frame, message):
        message.header.stamp = stamp_of(frame)
        message.header.frame_id = SHIRT_FRAME
        return message

    def link_meshes(self):
        message = LinkMeshes()
        for name, (vertices, triangles) in self.panda.links.items():
            message.meshes.append(LinkMesh(name, "test", vertices.flatten().tolist(),
                                           triangles.flatten().tolist()))
        return message

    def events(self):
        """[(time of receipt, topic, message)], as a recorder beside the robot would get them."""
        events = [(START - rospy.Duration(1), "/contact_monitor/robot_meshes", self.link_meshes())]
        for frame in range(-1, FRAMES + 1):
            stamp = stamp_of(frame)
            transforms = transform_message(stamp, self.edges(frame))
            events.append((stamp + rospy.Duration(0, 3000000), "/tf", transforms))
            if 0 <= frame < FRAMES:
                mesh = self.shirt(frame, keyframe=frame % KEYFRAME_EVERY == 0)
                events.append((stamp + rospy.Duration(0, 5000000), "/tshirt", mesh))
        return events

    def expected(self):
        """{frame: pairs as monitor_test_support.pairs_of() has them}."""
        buffer = tf2_py.BufferCore(rospy.Duration(1000))
        for frame in range(-1, FRAMES + 1):
            for transform in transform_message(stamp_of(frame), self.edges(frame)).transforms:
                buffer.set_transform(transform, "test")
        found = {}
        for frame in range(FRAMES):
            def pose(name, stamp=stamp_of(frame)):
                return pose_from(buffer, REFERENCE_FRAME, name, stamp)
            found[frame] = oracle_pairs(posed_links(self.panda.links, pose), "tshirt",
                                        posed(self.panda.shirt_mesh(frame), pose(SHIRT_FRAME)))
        return found


def write_bag(path, events, compression="none", chunk=768 * 1024):
    """In the order of the events, whatever their times."""
    with rosbag.Bag(path, "w", compression=compression, chunk_threshold=chunk) as bag:
        for received, topic, message in events:
            bag.write(topic, message, received)
    return path
