#!/usr/bin/python3
"""Judges one run of soft_loop.launch: how near the robot came to the object, exactly, and when the
guard slowed and stopped it.

It records meshes, transforms, the guard's output and the player's, until the player is done or has
stood still for --still seconds. Then it poses the links at the stamp of each mesh and asks the
library for the nearest distance. The monitor's answers are not used for that. It writes one JSON
file and ends.
"""
import argparse
import json
import os
import signal
import sys
import threading
import xmlrpc.client

import numpy
import rosgraph
import rospy
import tf2_ros
from deformable_contact import Detector, Scene
from std_msgs.msg import Bool, Float64
from visualization_msgs.msg import Marker

from deformable_contact_monitor.msg import ContactStates, DeformableMesh, LinkMeshes

FARTHEST_M = 5.0


class Log:
    """Times [s] and values of a topic."""

    def __init__(self, topic, kind):
        self.times, self.values = [], []
        self._lock = threading.Lock()
        rospy.Subscriber(topic, kind, self._on, queue_size=100)

    def _on(self, message):
        with self._lock:
            self.times.append(rospy.get_time())
            self.values.append(message.data)

    def copy(self):
        with self._lock:
            return {"t": list(self.times), "v": list(self.values)}

    def last(self, otherwise):
        return self.values[-1] if self.values else otherwise


class Meshes:
    """Vertices [m] of an object by stamp, in its frame, and its triangles."""

    def __init__(self, topic, is_rope):
        self.frames, self.triangles, self.frame_id = [], None, ""
        self._is_rope = is_rope
        rospy.Subscriber(topic, Marker if is_rope else DeformableMesh, self._on, queue_size=100,
                         buff_size=1 << 24)

    def _on(self, message):
        if self._is_rope:
            vertices = numpy.array([(p.x, p.y, p.z) for p in message.points])
            i = numpy.arange(len(vertices) - 1)
            self.triangles = numpy.stack([i, i + 1, i + 1], axis=-1)
        else:
            vertices = numpy.array(message.vertices).reshape(-1, 3)
            if message.triangles:
                self.triangles = numpy.array(message.triangles).reshape(-1, 3)
        self.frame_id = message.header.frame_id
        self.frames.append((message.header.stamp, vertices.astype(numpy.float32)))


def rotation_of(q):
    x, y, z, w = q.x, q.y, q.z, q.w
    return numpy.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def truth(meshes, links, buffer, radius_m, ignored):
    """Stamps [s] and exact distances [m] of the links from the object; 0: they touch."""
    scene = Scene()
    scene.add_body("object", meshes.frames[0][1], meshes.triangles)
    scene.set_radius(0, radius_m)
    scene.set_margin(0, FARTHEST_M)
    ids = {}
    for link in links:
        if link.link in ignored:
            continue
        vertices = numpy.array(link.vertices, dtype=numpy.float32).reshape(-1, 3)
        ids[link.link] = scene.add_body(link.link, vertices,
                                        numpy.array(link.triangles).reshape(-1, 3))
        scene.set_pair_enabled(0, ids[link.link])
    detector = Detector(backend="cpu", nearest=True, threads=1)
    stamps, distances = [], []
    for stamp, vertices in meshes.frames:
        try:
            for link, body in ids.items():
                pose = buffer.lookup_transform(meshes.frame_id, link, stamp).transform
                t = pose.translation
                scene.set_pose(body, rotation_of(pose.rotation), numpy.array([t.x, t.y, t.z]))
        except tf2_ros.TransformException:
            continue
        scene.set_vertices(0, vertices)
        nearest = detector.detect(scene).nearest
        stamps.append(stamp.to_sec())
        distances.append(min([pair.distance_m for pair in nearest], default=FARTHEST_M))
    return stamps, distances


class Judge:
    def __init__(self, arguments):
        self.arguments = arguments
        self.buffer = tf2_ros.Buffer(rospy.Duration(120), debug=False)
        self.listener = tf2_ros.TransformListener(self.buffer)
        self.meshes = Meshes(arguments.topic, arguments.radius > 0)
        self.time = Log("/trajectory_player/time", Float64)
        self.scale = Log("/trajectory_player/scale", Float64)
        self.done = Log("/trajectory_player/done", Bool)
        self.wanted = Log("/contact_guard/speed_scale", Float64)
        self.stop = Log("/contact_guard/stop", Bool)
        self.links, self.near_m, self.killed_s = None, FARTHEST_M, None
        rospy.Subscriber("/contact_monitor/robot_meshes", LinkMeshes, self._on_links)
        rospy.Subscriber("/contact_monitor/contact_states", ContactStates, self._on_states)

    def _on_links(self, message):
        self.links = message.meshes

    def _on_states(self, message):
        of_links = [s for s in message.states if s.state == s.NEAR]
        self.near_m = min([s.min_separation for s in of_links], default=FARTHEST_M)
        if self.near_m < self.arguments.kill_at and self.killed_s is None:
            self._kill_monitor()

    def _kill_monitor(self):
        """As a crash: nobody is told."""
        self.killed_s = rospy.get_time()
        master = rosgraph.Master(rospy.get_name())
        node = xmlrpc.client.ServerProxy(master.lookupNode("/contact_monitor"))
        os.kill(node.getPid(rospy.get_name())[2], signal.SIGKILL)

    def watch(self):
        """Until the run is over. Returns why."""
        began_s, moved_s, last = rospy.get_time(), None, 0.0
        while not rospy.is_shutdown():
            rospy.rostime.wallsleep(0.05)
            now = rospy.get_time()
            at = self.time.last(0.0)
            if at > last:
                last, moved_s = at, now
            if self.done.last(False):
                return "done"
            if moved_s is not None and now - moved_s > self.arguments.still:
                return "stands still"
            if now - began_s > self.arguments.longest:
                return "too long" if moved_s is not None else "never moved"
        return "ended from outside"

    def report(self, why):
        rospy.rostime.wallsleep(0.2)  # the transforms of the last mesh
        stamps, distances = truth(self.meshes, self.links or [], self.buffer, self.arguments.radius,
                                  self.arguments.ignore)
        return {
            "why": why, "stamps": stamps, "distances": distances, "killed_s": self.killed_s,
            "meshes": len(self.meshes.frames),
            **{name: log.copy() for name, log in
               (("time", self.time), ("scale", self.scale), ("wanted", self.wanted),
                ("stop", self.stop))}}


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("out", help="JSON file to write")
    parser.add_argument("--topic", default="/soft_object")
    parser.add_argument("--radius", type=float, default=0.0, help="the object is a rope [m]")
    parser.add_argument("--ignore", nargs="*", default=[], help="links that hold the object")
    parser.add_argument("--kill-at", type=float, default=-1.0, metavar="M",
                        help="kill the monitor once it tells of a distance below this [m]")
    parser.add_argument("--still", type=float, default=2.0, metavar="S")
    parser.add_argument("--longest", type=float, default=40.0, metavar="S")
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("loop_judge")
    judge = Judge(arguments)
    result = judge.report(judge.watch())
    with open(arguments.out + ".part", "w") as file:
        json.dump(result, file)
    os.replace(arguments.out + ".part", arguments.out)


if __name__ == "__main__":
    sys.exit(main())
