#!/usr/bin/python3
"""Lets links hold the part of an object that is near them, as soon as some of it is.

Usage: hold.py OBJECT RADIUS LINK...  It calls attach_object of the node contact_monitor until that
succeeds, and prints the answer.
"""
import argparse
import sys

import rospy
from deformable_contact_monitor.srv import AttachObject


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("object", help="as configured in the monitor")
    parser.add_argument("radius", type=float, help="[m]")
    parser.add_argument("links", nargs="+", help="of the robot")
    options = parser.parse_args(rospy.myargv()[1:])
    rospy.init_node("hold")
    rospy.wait_for_service("contact_monitor/attach_object")
    attach = rospy.ServiceProxy("contact_monitor/attach_object", AttachObject)
    while not rospy.is_shutdown():
        answer = attach(options.object, options.links, options.radius)
        if answer.success:
            print(answer.message)
            return
        rospy.loginfo_throttle(5, "not held yet: " + answer.message)
        rospy.sleep(0.2)


if __name__ == "__main__":
    try:
        main()
    except (rospy.ROSInterruptException, rospy.ServiceException) as error:
        sys.exit("hold.py: " + str(error))
