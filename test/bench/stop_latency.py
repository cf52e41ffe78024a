#!/usr/bin/env python3
"""Measures from the stamp of a mesh that touches to contact_guard's stop, as a subscriber gets it:
    rostest --text test/bench/stop_latency.test samples:=300 cells:=12
Each mesh's transforms are sent before it, for a moment that lies ahead of its stamp, so that none
is waited for. The mesh that touches has no triangles: as the protocol wants it, they were sent
before."""
import io
import pathlib
import struct
import sys
import time
import unittest

import numpy as np
import rospy
import rostest
from std_msgs.msg import Bool

sys.path.append(str(pathlib.Path(__file__).resolve().parents[1] / "ros"))
import boxes_scene  # noqa: E402
from monitor_test_support import (  # noqa: E402
    PACKAGE, WAIT_S, DeformableMesh, MeshPublisher, Transforms, grid, mesh_message, raw_message,
    wait_until)

PERIOD_S = 1 / 30
AHEAD = rospy.Duration(0.02)


class Stops:
    """When the newest stop began, in ROS time; None while there is none."""

    def __init__(self):
        self.began = None
        rospy.Subscriber("/contact_guard/stop", Bool, self._store, tcp_nodelay=True)

    def _store(self, message):
        if not message.data:
            self.began = None
        elif self.began is None:
            self.began = rospy.Time.now()


def serialized(mesh, keyframe):
    """Before it is timed: Python takes long for it."""
    buffer = io.BytesIO()
    mesh_message("cloth", rospy.Time(), boxes_scene.REFERENCE_FRAME, mesh,
                 keyframe=keyframe).serialize(buffer)
    return bytearray(buffer.getvalue())


class StopLatency(unittest.TestCase):

    def send(self, mesh):
        """A mesh as serialized() gives it. Its stamp is taken as late as a publisher can."""
        message = raw_message(DeformableMesh, mesh)
        self.transforms.send(rospy.Time.now() + AHEAD, boxes_scene.edges())
        stamp = rospy.Time.now()
        struct.pack_into("<II", mesh, 4, stamp.secs, stamp.nsecs)  # after header.seq
        self.cloth.publisher.publish(message)
        return stamp

    def until_free(self, mesh):
        deadline = time.monotonic() + WAIT_S
        for _ in range(3):
            while self.send(mesh) and self.stops.began is not None:
                self.assertLess(time.monotonic(), deadline, "never free")
                time.sleep(PERIOD_S)
            time.sleep(PERIOD_S)

    def test_measure(self):
        cells = rospy.get_param("~cells")
        touching = serialized(grid(cells, 0.8), keyframe=False)
        apart = serialized(grid(cells, 0.8, height_m=3.0), keyframe=True)
        self.stops = Stops()
        self.transforms = Transforms()
        self.cloth = MeshPublisher("cloth", "/cloth")
        latencies_ms = []
        while len(latencies_ms) < rospy.get_param("~samples"):
            self.until_free(apart)
            if self.stops.began is not None:  # for another reason
                continue
            stamp = self.send(touching)
            wait_until(lambda: self.stops.began is not None, "a stop")
            latencies_ms.append((self.stops.began - stamp).to_sec() * 1e3)
        p50, p99 = np.percentile(latencies_ms, [50, 99])
        print(f"{2 * cells * cells} triangles, {len(latencies_ms)} stops: p50 {p50:.1f} ms, "
              f"p99 {p99:.1f} ms, most {max(latencies_ms):.1f} ms", flush=True)


if __name__ == "__main__":
    rospy.init_node("stop_latency")
    rostest.rosrun(PACKAGE, "stop_latency", StopLatency, sys.argv)
