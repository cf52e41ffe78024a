#!/usr/bin/env python3
"""Starts rviz with the camera on what a monitor monitors: its robot and its objects.

Waits for the links and meshes of the monitor, then watches where they move. Then it becomes rviz, with
config/demo.rviz and a camera that sees all. rviz gets every other argument, and remappings (a:=b);
"rviz --help" lists rviz's own options.
"""
import argparse
import itertools
import math
import os
import re
import sys
import time

import numpy as np

HERE = os.path.dirname(os.path.realpath(__file__))
CONFIG = os.path.join(HERE, "../config/demo.rviz")
HALF_ANGLE = math.radians(45) / 2  # of rviz's orbit camera, vertically; it sees more sideways
ROOM = 0.9  # largest fraction of the picture's height


def box_of(points):
    """Returns lowest and highest coordinates of the finite points; None if there are none."""
    points = [p for p in points if all(map(math.isfinite, p))]
    return (tuple(map(min, zip(*points))), tuple(map(max, zip(*points)))) if points else None


def view_of(box):
    """Returns the focus and the distance [m] of an orbit camera that sees the box from any side."""
    low, high = box
    radius = max(math.dist(low, high) / 2, 0.05)
    return [(a + b) / 2 for a, b in zip(low, high)], radius / (ROOM * math.sin(HALF_ANGLE))


def with_view(text, focus, distance):
    """Returns the rviz configuration `text` with that view."""
    for name, value in zip(("Distance", "X", "Y", "Z"), (distance, *focus)):
        # Replaces the first match only: X and Y further down are the place of the window.
        text, count = re.subn(rf"^(      (?:  )?{name}: ).*$", rf"\g<1>{value:.3f}", text, 1, re.M)
        if count != 1:
            raise ValueError(f"the configuration has no {name} of a view")
    return text


class Look:
    """Collects the monitor's links and meshes."""

    def __init__(self, monitor):
        import rospy
        import tf2_ros
        from deformable_contact_monitor.msg import DeformableMesh, LinkMeshes
        self.frame = rospy.get_param(monitor + "/reference_frame", "base_link")
        self.transforms = tf2_ros.Buffer()
        self.listener = tf2_ros.TransformListener(self.transforms)
        self.parts = {}  # by name: frame, flat vertices
        self.robot = False
        # Of the other types the camera knows nothing.
        objects = [one for one in rospy.get_param(monitor + "/objects", [])
                   if one.get("type", "deformable_mesh") == "deformable_mesh"]
        # Names of several robots' links have their prefixes already.
        several = rospy.get_param(monitor + "/robots", [])
        self.prefix = "" if several else rospy.get_param(monitor + "/frame_prefix", "")
        self.expected = len(objects)
        self.subscribers = [rospy.Subscriber(monitor + "/robot_meshes", LinkMeshes, self.on_robot)]
        for one in objects:
            topic = one.get("topic") or f"~objects/{one['name']}/mesh"
            topic = topic.replace("~", monitor + "/", 1)
            self.subscribers.append(rospy.Subscriber(
                topic, DeformableMesh, self.on_mesh, "object " + one["name"], queue_size=1))

    def on_robot(self, message):
        for mesh in message.meshes:
            self.parts["link " + mesh.link] = self.prefix + mesh.link, mesh.vertices
        self.robot = True

    def on_mesh(self, message, name):
        self.parts[name] = message.header.frame_id, message.vertices

    def points(self):
        """Returns the corners of all parts with a transform, in the reference frame, and whether no part
        is missing."""
        import rospy
        import tf2_ros
        found = []
        parts = list(self.parts.items())
        complete = self.robot and sum(n.startswith("object ") for n, _ in parts) == self.expected
        for _, (frame, vertices) in parts:
            corners = box_of(zip(*[iter(vertices)] * 3))
            if corners is None:
                continue
            try:
                pose = self.transforms.lookup_transform(self.frame, frame, rospy.Time(0)).transform
            except tf2_ros.TransformException:
                complete = False
                continue
            found += moved(pose, list(itertools.product(*zip(*corners))))
        return found, complete


def moved(pose, points):
    """Returns the points moved by a geometry_msgs/Transform."""
    q, t = pose.rotation, pose.translation
    u, points = [q.x, q.y, q.z], np.array(points)
    once = np.cross(u, points) + q.w * points
    return (points + 2 * np.cross(u, once) + [t.x, t.y, t.z]).tolist()


def parse(words):
    """Returns the options of this program, the words for rviz, and remappings, for both. Ends the
    program at --help, before anything of ROS starts."""
    parser = argparse.ArgumentParser(description=__doc__, allow_abbrev=False,
                                     formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--monitor", metavar="NAME", default="/contact_monitor",
                        help="the monitor's node (default: %(default)s)")
    parser.add_argument("--wait", metavar="SECONDS", type=float, default=10,
                        help="longest wait for links and meshes [s] (default: %(default)s)")
    parser.add_argument("--watch", metavar="SECONDS", type=float, default=4,
                        help="how long it then watches them [s] (default: %(default)s)")
    remappings = [word for word in words if ":=" in word]
    arguments, for_rviz = parser.parse_known_args([word for word in words if ":=" not in word])
    return arguments, for_rviz, remappings


def main():
    arguments, for_rviz, remappings = parse(sys.argv[1:])
    import rospy
    rospy.init_node("framed_rviz", anonymous=True)
    look = Look(rospy.resolve_name(arguments.monitor))
    end = time.monotonic() + arguments.wait
    points, watches = [], False
    while time.monotonic() < end and not rospy.is_shutdown():
        seen, complete = look.points()
        points += seen
        if complete and not watches:
            end, watches = time.monotonic() + arguments.watch, True
        time.sleep(0.2)
    if rospy.is_shutdown():
        return  # Ctrl-C
    with open(CONFIG) as file:
        text = file.read()
    box = box_of(points)
    if box is not None:
        text = with_view(text, *view_of(box))
    path = os.path.join(os.environ.get("ROS_HOME", os.path.expanduser("~/.ros")), "framed.rviz")
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write(text)
    rospy.signal_shutdown("becomes rviz")
    os.execvp("rviz", ["rviz", "-d", path, "-f", look.frame, *for_rviz, *remappings])


if __name__ == "__main__":
    main()
