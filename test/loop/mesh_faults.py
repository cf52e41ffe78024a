#!/usr/bin/python3
"""Passes an object's messages on, late or with vertices missing, as bad cameras do.

Usage: mesh_faults.py FROM TO [--late S] [--missing SHARE]
"""
import argparse
import collections
import sys

import numpy
import rospy

from deformable_contact_monitor.msg import DeformableMesh


class Faults:
    def __init__(self, arguments):
        self._late_s, self._missing = arguments.late, arguments.missing
        self._waiting = collections.deque()
        self._random = numpy.random.RandomState(1)
        self._out = rospy.Publisher(arguments.to, DeformableMesh, queue_size=10)
        rospy.Subscriber(arguments.source, DeformableMesh, self._on, queue_size=100)

    def _on(self, message):
        if self._missing > 0:
            vertices = numpy.array(message.vertices, dtype=numpy.float32).reshape(-1, 3)
            vertices[self._random.uniform(size=len(vertices)) < self._missing] = numpy.nan
            message.vertices = vertices.ravel().tolist()
        self._waiting.append((rospy.get_time() + self._late_s, message))

    def run(self):
        while not rospy.is_shutdown():
            while self._waiting and self._waiting[0][0] <= rospy.get_time():
                self._out.publish(self._waiting.popleft()[1])
            rospy.rostime.wallsleep(0.002)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("source", metavar="FROM")
    parser.add_argument("to", metavar="TO")
    parser.add_argument("--late", type=float, default=0.0, metavar="S")
    parser.add_argument("--missing", type=float, default=0.0, metavar="SHARE")
    arguments = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("mesh_faults")
    Faults(arguments).run()


if __name__ == "__main__":
    sys.exit(main())
