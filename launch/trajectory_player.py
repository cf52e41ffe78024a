#!/usr/bin/python3
"""Moves a robot's joints along a motion as a contact_guard lets them.

Usage: trajectory_player.py MOTION [--guard NAME] [--rate HZ] [--brake S] [--grasp NAME]

MOTION is a yaml file as soft_scene --motion reads it; it is played once. Time in the motion runs at
the guard's speed scale. A stop, and no news of the guard for --max-silence seconds, halt it. The
scale changes by at most 1 / BRAKE a second, as a robot brakes.

Publishes joint_states, ~time (std_msgs/Float64: how far the motion is [s]), ~scale
(std_msgs/Float64: the scale that holds) and ~done (std_msgs/Bool, latched). Holds of the motion call
NAME/attach_object (AttachObject).
"""
import argparse
import sys

import numpy
import rospy
import yaml
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64

from deformable_contact_monitor.srv import AttachObject


class Motion:
    """Joint positions over time, and when links take hold of the object."""

    def __init__(self, path):
        with open(path) as file:
            script = yaml.safe_load(file)
        try:
            self.joints = [str(name) for name in script["joints"]]
            points = numpy.array(script["points"], dtype=float)
            self.holds = [(float(hold[0]), hold[1:]) for hold in script.get("hold", [])]
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: not a motion: {error}")
        if points.ndim != 2 or points.shape[1] != len(self.joints) + 1:
            raise ValueError(f"{path}: each point is a time and {len(self.joints)} positions")
        self.times, self.positions = points[:, 0], points[:, 1:]
        if not (numpy.isfinite(points).all() and (numpy.diff(self.times) > 0).all()):
            raise ValueError(f"{path}: times must ascend, and all numbers be finite")

    @property
    def end_s(self):
        return float(self.times[-1])

    def at(self, time_s):
        """The positions [rad or m]. Between two points they start and end softly."""
        i = int(numpy.searchsorted(self.times, time_s, side="right"))
        if i == 0 or i == len(self.times):
            return self.positions[min(i, len(self.times) - 1)]
        share = (time_s - self.times[i - 1]) / (self.times[i] - self.times[i - 1])
        share = share * share * (3 - 2 * share)
        return self.positions[i - 1] + share * (self.positions[i] - self.positions[i - 1])


class Guard:
    """The newest scale and stop of a guard. Silence is a stop. Without a name all is free."""

    def __init__(self, name, max_silence_s):
        self._max_silence_s = max_silence_s if name else None
        self._scale, self._stop, self._heard = 0.0, True, None
        if name:
            rospy.Subscriber(f"{name}/speed_scale", Float64, self._on_scale, queue_size=1)
            rospy.Subscriber(f"{name}/stop", Bool, self._on_stop, queue_size=1)

    def _on_scale(self, message):
        self._scale = min(max(message.data, 0.0), 1.0)

    def _on_stop(self, message):
        self._stop, self._heard = message.data, rospy.get_time()

    def scale(self, now_s):
        if self._max_silence_s is None:
            return 1.0
        silent = self._heard is None or not 0 <= now_s - self._heard <= self._max_silence_s
        return 0.0 if silent or self._stop else self._scale


class Player:
    def __init__(self, motion, guard, rate_hz, brake_s, grasp, held):
        self._motion, self._guard, self._brake_s = motion, guard, brake_s
        self._grasp = rospy.ServiceProxy(f"{grasp}/attach_object", AttachObject) if grasp else None
        self._object = held
        self._period_s = 1 / rate_hz
        self._scale = self._time_s = 0.0
        self._holds = list(motion.holds)
        self._joints = rospy.Publisher("joint_states", JointState, queue_size=10)
        self._time = rospy.Publisher("~time", Float64, queue_size=10)
        self._scales = rospy.Publisher("~scale", Float64, queue_size=10)
        self._done = rospy.Publisher("~done", Bool, queue_size=1, latch=True)

    def run(self):
        rate = rospy.Rate(1 / self._period_s, reset=True)  # a simulator's clock may go back
        while not rospy.is_shutdown():
            self._step()
            if self._time_s >= self._motion.end_s:
                self._done.publish(True)
            rate.sleep()

    def _step(self):
        now = rospy.Time.now()
        most = self._period_s / self._brake_s if self._brake_s > 0 else 1.0
        wanted = self._guard.scale(now.to_sec())
        self._scale += min(max(wanted - self._scale, -most), most)
        self._time_s = min(self._time_s + self._scale * self._period_s, self._motion.end_s)
        self._take_hold()
        state = JointState(name=self._motion.joints, position=self._motion.at(self._time_s).tolist())
        state.header.stamp = now
        self._joints.publish(state)
        self._time.publish(self._time_s)
        self._scales.publish(self._scale)

    def _take_hold(self):
        while self._holds and self._holds[0][0] <= self._time_s:
            _, hold = self._holds.pop(0)
            if self._grasp is None:
                continue
            radius_m, links = (hold[0], hold[1:]) if hold else (0.0, [])
            try:
                answer = self._grasp(object=self._object, links=links, radius=radius_m)
                say = rospy.loginfo if answer.success else rospy.logerr
                say("%s", answer.message)
            except rospy.ServiceException as error:
                rospy.logerr("%s was not held: %s", " ".join(links) or "nothing", error)


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("motion", metavar="MOTION", help="yaml file: joints, points, hold")
    parser.add_argument("--guard", default="contact_guard", metavar="NAME",
                        help="the guard's node; '': none, at full speed")
    parser.add_argument("--rate", type=float, default=100, metavar="HZ", help="of joint_states")
    parser.add_argument("--brake", type=float, default=0.1, metavar="S",
                        help="time from full speed to a standstill")
    parser.add_argument("--max-silence", type=float, default=0.2, metavar="S",
                        help="no news of the guard for so long are a stop")
    parser.add_argument("--grasp", default="", metavar="NAME",
                        help="node that holds the object for links, such as soft_scene")
    parser.add_argument("--object", default="cloth", metavar="NAME",
                        help="of what links hold")
    arguments = parser.parse_args(rospy.myargv()[1:])
    if not (arguments.rate > 0 and arguments.brake >= 0):
        parser.error("--rate must be above 0 and --brake not below")
    try:
        motion = Motion(arguments.motion)
    except (OSError, ValueError, yaml.YAMLError) as error:
        parser.error(str(error))
    rospy.init_node("trajectory_player")
    guard = Guard(arguments.guard, arguments.max_silence)
    try:
        Player(motion, guard, arguments.rate, arguments.brake, arguments.grasp,
               arguments.object).run()
    except rospy.ROSInterruptException:
        pass


if __name__ == "__main__":
    sys.exit(main())
