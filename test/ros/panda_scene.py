"""A scene with the Panda and the T-shirt of the shared data: where the links are, and which pairs
are expected."""
import os
import xml.etree.ElementTree as ElementTree

import numpy as np

from monitor_test_support import (
    MeshPublisher, Transforms, now, oracle_pairs, posed_links, until_frames_are_seen)
from pose_meshes import numbers, origin_of, posed, read_obj, read_stl_links

REFERENCE_FRAME = "panda_link0"
SHIRT_FRAME = "shirt"
SHIRT_SCALE = 0.09  # the frames have no unit; this makes it half a metre wide
READY = [0.0, -0.785, 0.0, -2.356, 0.0, 1.571, 0.785]  # [rad]


def quaternion_product(a, b):
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def joint_edges(joints, values, prefix=""):
    """The joints' links below their parents at these values [rad or m], by joint; for transforms."""
    edges = {}
    for joint in joints:
        translation, quaternion = origin_of(joint)
        if joint.get("type") in ("revolute", "continuous"):
            half = values[joint.get("name")] / 2
            turn = [value * np.sin(half) for value in numbers(joint.find("axis").get("xyz"))]
            quaternion = quaternion_product(quaternion, (*turn, np.cos(half)))
        elif joint.get("type") == "prismatic":
            axis = numbers(joint.find("axis").get("xyz"))
            translation = [t + values[joint.get("name")] * a for t, a in zip(translation, axis)]
        edges[prefix + joint.find("child").get("link")] = (
            prefix + joint.find("parent").get("link"), (translation, quaternion))
    return edges


class Panda:
    """Its links, and where they and the shirt's frame are."""

    def __init__(self, data):
        folder = os.path.join(data, "robots/panda_description")
        self.urdf = os.path.join(folder, "urdf/panda.urdf")
        self.data = data
        self.links = read_stl_links(self.urdf, folder)
        self.joints = ElementTree.parse(self.urdf).getroot().findall("joint")

    def shirt_mesh(self, frame):
        return read_obj(os.path.join(self.data, f"tshirt/{frame:03d}.obj"), SHIRT_SCALE)

    def edges(self, joint_angles, finger_m, shirt_pose):
        """Every link below its parent at these joint angles [rad], and the shirt's frame."""
        values = {f"panda_joint{i + 1}": angle for i, angle in enumerate(joint_angles)}
        values.update(panda_finger_joint1=finger_m, panda_finger_joint2=finger_m)
        return {SHIRT_FRAME: (REFERENCE_FRAME, shirt_pose), **joint_edges(self.joints, values)}

    def edges_at(self, step, shirt_at):
        """The robot and the shirt, which move with `step`."""
        angles = [angle + 0.02 * step for angle in READY]
        turned = np.array([np.sin(0.1 * step), 0.1, 0.0, np.cos(0.1 * step)])
        turned /= np.linalg.norm(turned)
        return self.edges(angles, 0.02, (shirt_at, turned))


class PandaScene(Panda):
    """Published."""

    def __init__(self, data):
        super().__init__(data)
        self.transforms = Transforms()
        self.shirt = MeshPublisher("tshirt", "/tshirt")

    def show_until_seen(self, monitor):
        """Until the monitor knows the frames."""
        def cycle():
            stamp = now()
            self.show(stamp, 0, 0, (0, 0, 5))
            return monitor.contacts_at(stamp)
        until_frames_are_seen(cycle)

    def show(self, stamp, frame, step, shirt_at):
        """Sends transforms and the T-shirt."""
        self.transforms.send(stamp, self.edges_at(step, shirt_at))
        self.shirt.send(stamp, SHIRT_FRAME, self.shirt_mesh(frame))

    def expected(self, stamp, frame, meshes):
        """The oracle's pairs for what show() sent, with the robot's link meshes."""
        def pose(link):
            return self.transforms.pose(REFERENCE_FRAME, link, stamp)
        return oracle_pairs(posed_links(meshes, pose), "tshirt",
                            posed(self.shirt_mesh(frame), pose(SHIRT_FRAME)))
