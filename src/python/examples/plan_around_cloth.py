#!/usr/bin/env python3
"""Plans a path of the demo's arm round a cloth, over the service ~check_states of contact_monitor.

The path goes straight from START to a point between and on to GOAL, in joint positions. Bisection
finds how little that point must be lifted towards the upright arm. Prints one position a line.
config/docs/plan_around_a_cloth.md explains it.
"""
import sys

import numpy as np
import rospy
from deformable_contact_monitor.msg import ContactState, StatesToCheck
from deformable_contact_monitor.srv import CheckStates

JOINTS = ["shoulder_pan", "shoulder_lift", "elbow", "wrist_bend"]
START, GOAL = np.array([-0.8, 0.7, 0.9, 0.2]), np.array([0.8, 0.7, 0.9, 0.2])
UPRIGHT = np.array([0.0, -0.3, 0.25, 0.0])
CLEARANCE_M = 0.02  # of each state
# The arm reaches 1 m, so no point of it moves more than the clearance between two states, and what
# is farther away than that from both is not touched between them either.
STEP_RAD = 0.02  # sum over the joints


def is_free(check, *points):
    states = np.concatenate([
        np.linspace(a, b, 2 + int(np.abs(b - a).sum() / STEP_RAD))
        for a, b in zip(points, points[1:])])
    checked = check(StatesToCheck(joint_names=JOINTS, positions=states.flatten(),
                                  margin=CLEARANCE_M)).checked
    if not checked.success:
        sys.exit(f"plan_around_cloth: {checked.reason}")
    return all(state == ContactState.NONE for state in checked.state)  # UNKNOWN is not free


def plan(check):
    """Returns the points of a path; nothing if there is no such path."""
    if is_free(check, START, GOAL):
        return [START, GOAL]
    middle, low, high = (START + GOAL) / 2, 0.0, 1.0
    if not is_free(check, START, UPRIGHT, GOAL):
        return []
    while high - low > 0.01:
        lift = (low + high) / 2
        low, high = ((low, lift) if is_free(check, START, middle + lift * (UPRIGHT - middle), GOAL)
                     else (lift, high))
    return [START, middle + high * (UPRIGHT - middle), GOAL]


if __name__ == "__main__":
    rospy.init_node("plan_around_cloth", anonymous=True)
    rospy.wait_for_service("contact_monitor/check_states", 30)
    path = plan(rospy.ServiceProxy("contact_monitor/check_states", CheckStates))
    for point in path:
        print(*point)
    sys.exit(0 if path else "plan_around_cloth: no such path is free")
