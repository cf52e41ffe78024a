#!/usr/bin/python3
"""Moves the three arms of three_arms.launch and a tissue below them.

Usage: moving_arms.py  It publishes joint states for PSM1, PSM2 and PSM3, and the tissue's mesh on
/tissue, 50 times a second.
"""
import argparse
import sys

import numpy
import rospy
from sensor_msgs.msg import JointState

from deformable_contact_monitor.msg import DeformableMesh

CELLS, SIZE_M = 24, 0.2
ARMS = ("PSM1", "PSM2", "PSM3")


def joints_at(seconds, arm):
    """Each arm dips into the tissue in turn; the first two cross now and then."""
    phase = seconds / 2 + 2 * numpy.pi / 3 * arm
    sides = (-0.5, 0.5, 0.0)
    return {"yaw": sides[arm] * (0.5 - 0.5 * numpy.cos(seconds / 5)), "pitch": 0.2 * numpy.sin(phase),
            "insertion": 0.135 + 0.02 * numpy.sin(phase), "roll": phase % 1, "jaw": 0.2}


def tissue():
    """A square grid: vertices (n, 3) and triangles (m, 3)."""
    steps = numpy.linspace(-SIZE_M / 2, SIZE_M / 2, CELLS + 1)
    x, y = numpy.meshgrid(steps, steps)
    corner = numpy.arange(CELLS * (CELLS + 1)).reshape(CELLS, CELLS + 1)[:, :-1].ravel()
    right, above = corner + 1, corner + CELLS + 1
    triangles = numpy.stack([corner, right, above, right, above + 1, above], axis=-1)
    return numpy.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=-1), triangles.ravel()


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("moving_arms")
    joints = [rospy.Publisher(f"/{arm}/joint_states", JointState, queue_size=1) for arm in ARMS]
    meshes = rospy.Publisher("/tissue", DeformableMesh, queue_size=1)
    vertices, triangles = tissue()
    mesh = DeformableMesh(object="tissue", topology_id=1, triangles=triangles.tolist())
    mesh.header.frame_id = "world"
    while not rospy.is_shutdown():
        now = rospy.Time.now()
        for arm, publisher in enumerate(joints):
            values = joints_at(now.to_sec(), arm)
            state = JointState(name=list(values), position=list(values.values()))
            state.header.stamp = now
            publisher.publish(state)
        vertices[:, 2] = 0.004 * numpy.sin(30 * vertices[:, 0] + 2 * now.to_sec())
        mesh.header.stamp, mesh.vertices = now, vertices.ravel().tolist()
        meshes.publish(mesh)
        rospy.rostime.wallsleep(0.02)


if __name__ == "__main__":
    try:
        main()
    except rospy.ROSInterruptException as error:
        sys.exit("moving_arms.py: " + str(error))
