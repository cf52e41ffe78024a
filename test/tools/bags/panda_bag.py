"""A Panda pushing into a T-shirt as a bag, and the contacts that the oracle finds in it."""
import os
import pathlib
import sys

import rosbag
import numpy as np
import rospy
import tf2_py

SOURCE = pathlib.Path(__file__).resolve().parents[3]
sys.path.insert(0, str(SOURCE / "test/ros"))

# pylint: disable=wrong-import-position
from deformable_contact_monitor.msg import LinkMesh, LinkMeshes
from adapted_messages import (
    array_message, cloud_message, depth_triangles, marker_message, polygon_message, shape_message)
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

    def marker_array(self, frame):
        array = array_message(self.panda.shirt_mesh(frame))
        for marker in array.markers:
            self._stamped(frame, marker)
        return array

    def cloud(self, frame):
        return self._stamped(frame, cloud_message(self.panda.shirt_mesh(frame)))

    def polygons(self, frame):
        return self._stamped(frame, polygon_message(self.panda.shirt_mesh(frame)))

    def cells(self):
        """A tetrahedron behind each triangle of the shirt: triangle k is 4k of their surface."""
        vertices, triangles = self.panda.shirt_mesh(0)
        return "".join(f"{len(vertices) + i} {a} {b} {c}\n"
                       for i, (a, b, c) in enumerate(triangles.tolist()))

    def cells_cloud(self, frame):
        """The points of cells(); nobody sees those that are not the shirt's."""
        vertices, triangles = self.panda.shirt_mesh(frame)
        unseen = np.full((len(triangles), 3), np.nan, np.float32)
        return self._stamped(frame, cloud_message((np.concatenate([vertices, unseen]), None)))

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

    def pixels(self, frame, rows):
        vertices = self.panda.shirt_mesh(frame)[0]
        return vertices[:len(vertices) // rows * rows]

    def depth_image(self, frame, rows):
        return self._stamped(frame, cloud_message((self.pixels(frame, rows), None), rows))

    def expected_of_images(self, rows, max_jump):
        """expected() of depth_image() as the object 'scene'."""
        def image(frame):
            pixels = self.pixels(frame, rows)
            return pixels, depth_triangles(pixels, rows, max_jump)
        return self.expected("scene", image)

    def expected(self, name="tshirt", mesh_of=None):
        """{frame: pairs as monitor_test_support.pairs_of() has them}."""
        mesh_of = mesh_of or self.panda.shirt_mesh
        buffer = tf2_py.BufferCore(rospy.Duration(1000))
        for frame in range(-1, FRAMES + 1):
            for transform in transform_message(stamp_of(frame), self.edges(frame)).transforms:
                buffer.set_transform(transform, "test")
        found = {}
        for frame in range(FRAMES):
            def pose(name, stamp=stamp_of(frame)):
                return pose_from(buffer, REFERENCE_FRAME, name, stamp)
            found[frame] = oracle_pairs(posed_links(self.panda.links, pose), name,
                                        posed(mesh_of(frame), pose(SHIRT_FRAME)))
        return found


def write_bag(path, events, compression="none", chunk=768 * 1024):
    """In the order of the events, whatever their times."""
    with rosbag.Bag(path, "w", compression=compression, chunk_threshold=chunk) as bag:
        for received, topic, message in events:
            bag.write(topic, message, received)
    return path
