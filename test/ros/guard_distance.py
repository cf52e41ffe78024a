#!/usr/bin/env python3
"""Moves a cloth towards a box, as far and as fast as contact_guard lets it, and away again. The
distance of the two is known at each stamp, and so is the scale that belongs to it. The test
publishes the clock, and moves it on when both guards have answered rightly: nothing depends on how
busy the machine is."""
import bisect
import sys
import unittest

import rosgraph
import rospy
import rostest
from rosgraph_msgs.msg import Clock
from std_msgs.msg import Bool, Float64
from tf2_msgs.msg import TFMessage

import boxes_scene
from deformable_contact_monitor.msg import ContactState
from monitor_test_support import (
    PACKAGE, Log, MeshPublisher, Monitor, grid, transform_message, until_frames_are_seen,
    wait_until)

TOP_M = 0.05  # of the palm, whose box is 0.1 m high
START_M = 0.7  # distance before each test; beyond the margin of 0.6 m
STEP_S = 0.04  # of ROS time
MOST_STEPS = 1500
STOP_M, LEAST_SCALE = 0.05, 0.1
SERVO_TOPIC = "/servo_server/internal/collision_velocity_scale"
FLAT_CLOTH = grid(10, 0.6)
FLAT_CLOTH[0][:, 2] = 0


def scale_at(distance_m):
    """What by_distance allows."""
    if distance_m <= STOP_M:
        return 0.0
    share = (distance_m - STOP_M) / (0.3 - STOP_M)
    return min(1.0, LEAST_SCALE + (1 - LEAST_SCALE) * share)


class Guard:

    def __init__(self, name, scale_topic=None):
        self.name = name
        self.stops = Log(f"/{name}/stop", Bool)
        self.warnings = Log(f"/{name}/warning", Bool)
        self.scales = Log(scale_topic or f"/{name}/speed_scale", Float64)

    def stop(self):
        return not self.stops.messages or self.stops.messages[-1].data

    def scale(self):
        return self.scales.messages[-1].data if self.scales.messages else 0.0

    def allowed(self):
        return 0.0 if self.stop() else self.scale()

    def is_free(self):
        return self.allowed() == 1

    def wait_for_answer(self):
        """Until two more outputs have come: the second was begun after the call."""
        since = self.warnings.count()  # the last of an output's three messages
        wait_until(lambda: self.warnings.count() >= since + 2, f"output of {self.name}")


class Cloth:
    """Sends the clock, the transforms and the mesh of one stamp after another. The height of the
    cloth changes by a speed [m/s]."""

    def __init__(self, guards):
        self.guards = guards
        self.time_s = 1000.0
        self.speed = lambda: 0.0
        self.distance_m = START_M
        self.sent = {}  # {stamp: distance}
        self.path = []  # (distance, speed towards the box)
        self.clock = rospy.Publisher("/clock", Clock, queue_size=10)
        self.transforms = rospy.Publisher("/tf", TFMessage, queue_size=100)
        self.monitor = Monitor()
        self.mesh = MeshPublisher("cloth", "/cloth")
        wait_until(lambda: self.clock.get_num_connections() >= 4, "all nodes on /clock")
        wait_until(lambda: self.transforms.get_num_connections() >= 1, "a listener of /tf")

    def step(self):
        """Sends one stamp and waits for the answers. Returns the monitor's contacts."""
        self.time_s += STEP_S
        stamp = rospy.Time.from_sec(self.time_s)
        speed = self.speed()
        self.distance_m = max(0.01, self.distance_m - speed * STEP_S)
        self.path.append((self.distance_m, speed))
        self.sent[stamp.to_nsec()] = self.distance_m
        edges = dict(boxes_scene.edges(links=("palm",)),
                     cloth=("base", ((0, 0, self.distance_m + TOP_M), boxes_scene.UPRIGHT)))
        states, contacts = self.monitor.states.count(), self.monitor.contacts.count()
        self.clock.publish(Clock(stamp))
        self.transforms.publish(transform_message(stamp, edges))
        self.mesh.send(stamp, "cloth", FLAT_CLOTH)
        found = self.monitor.contacts.wait(f"contacts at {stamp}",
                                           lambda m: m.header.stamp == stamp, since=contacts)
        self.monitor.states.wait(f"states at {stamp}", lambda m: m.cycle == found.cycle,
                                 since=states)
        for guard in self.guards:
            guard.wait_for_answer()
        return found

    def step_until(self, condition, what):
        for _ in range(MOST_STEPS):
            if condition():
                return
            self.step()
        raise AssertionError(f"{MOST_STEPS} steps were made in vain for {what}")

    def move(self, speed):
        self.speed = speed
        self.path = []

    def at(self, distance_m):
        self.speed = lambda: 0.0
        self.distance_m = distance_m


class GuardDistance(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.by_distance = Guard("by_distance")
        cls.by_time = Guard("by_time", SERVO_TOPIC)
        cls.cloth = Cloth((cls.by_distance, cls.by_time))
        until_frames_are_seen(cls.cloth.step)

    def setUp(self):
        self.cloth.at(START_M)
        for guard in self.by_distance, self.by_time:
            self.cloth.step_until(guard.is_free, f"{guard.name} to let the cloth go")
        self.since = self.cloth.monitor.states.count()

    def near(self):
        """The states NEAR of this test."""
        found = []
        for message in self.cloth.monitor.states.messages[self.since:]:
            found += [state for state in message.states if state.state == ContactState.NEAR]
        return found

    def approach(self, guard, speed_mps, is_right):
        """Returns the scales from then on until the guard stops. After each step, is_right(distance,
        allowed scale) must become true."""
        since = guard.scales.count()
        self.cloth.move(lambda: speed_mps * guard.allowed())
        for _ in range(MOST_STEPS):
            wait_until(lambda: is_right(self.cloth.distance_m, guard.allowed()),
                       f"the scale of {guard.name} at {self.cloth.distance_m} m")
            if self.cloth.distance_m < 0.06 and guard.stop():
                break
            # It also stops where the clock reached it later than the states did.
            wait_until(lambda: not guard.stop(), f"{guard.name} at {self.cloth.distance_m} m")
            self.cloth.step()
        self.assertTrue(guard.stop())
        self.assertGreater(self.cloth.distance_m, 0.03)
        return [message.data for message in guard.scales.messages[since:]]

    def approach_by_distance(self):
        return self.approach(
            self.by_distance, 0.15,
            lambda distance_m, scale: abs(scale - scale_at(distance_m)) < 1e-4)

    def check_states(self):
        """Distances, points and normals are those of the scene."""
        states = self.near()
        self.assertGreater(len(states), 20)
        for state in states:
            distance_m = self.cloth.sent[state.stamp.to_nsec()]
            self.assertAlmostEqual(state.min_separation, distance_m, delta=2e-6)
            self.assertLessEqual(state.distance_low, state.min_separation)
            self.assertAlmostEqual(state.point_a.z, TOP_M, delta=1e-6)
            self.assertAlmostEqual(state.point_b.z, TOP_M + distance_m, delta=2e-6)
            self.assertAlmostEqual(state.normal.z, 1, delta=1e-6)
        return states

    def test_by_distance(self):
        scales = self.approach_by_distance()
        states = self.check_states()
        expected = sorted(scale_at(state.min_separation) for state in states)
        slowed = [scale for scale in scales if 0 < scale < 1]
        self.assertGreater(len(slowed), 5)
        for scale in slowed:  # each belongs to some state
            i = min(bisect.bisect_left(expected, scale), len(expected) - 1)
            self.assertLess(min(abs(scale - e) for e in expected[max(0, i - 1):i + 1]), 1e-4)
        self.assertLess(min(slowed), 0.25)
        at = self.cloth.distance_m
        for _ in range(10):
            self.cloth.step()
        self.assertEqual(self.cloth.distance_m, at)
        self.assertTrue(self.by_distance.stop())

    def test_warns_before_it_stops(self):
        since = self.by_distance.warnings.count()
        self.approach_by_distance()
        warned = [message.data for message in self.by_distance.warnings.messages[since:]]
        self.assertFalse(warned[0])
        self.assertIn(True, warned)
        self.assertTrue(warned[-1])
        self.cloth.at(0.25)  # between warn_distance_m and slow_distance_m
        warnings = self.by_distance.warnings.messages
        self.cloth.step_until(lambda: not warnings[-1].data, "no warning any more")
        self.cloth.at(0.15)
        self.cloth.step_until(lambda: warnings[-1].data, "a warning")
        self.cloth.step_until(lambda: not self.by_distance.stop(), "no stop")

    def test_by_time_to_contact(self):
        speed_mps, least_s = 0.4, 0.7  # 1 s is asked for, and is missed while it speeds up

        def is_late_enough(distance_m, scale):
            return scale <= LEAST_SCALE or distance_m - STOP_M > least_s * speed_mps * scale
        scales = self.approach(self.by_time, speed_mps, is_late_enough)
        self.check_states()
        self.assertGreater(len([scale for scale in scales if 0 < scale < 1]), 5)
        # The distance alone slows only below 0.06 m.
        slowed_at = max(distance_m for distance_m, speed in self.cloth.path
                        if 0 < speed < 0.4 * 0.9)
        self.assertGreater(slowed_at, 0.2)

    def test_leaving_is_not_slowed(self):
        for guard in self.by_distance, self.by_time:
            self.cloth.at(0.055)
            self.cloth.step_until(lambda g=guard: not g.stop() and g.scale() < 1, "a slow guard")
            since = guard.scales.count()
            self.cloth.move(lambda: -0.25)
            self.cloth.step_until(lambda: self.cloth.distance_m > 0.25, "the cloth to be away")
            wait_until(lambda g=guard: g.allowed() == 1, f"{guard.name} to see that it leaves")
            later = guard.scales.count()
            self.cloth.step_until(lambda: self.cloth.distance_m > 0.5, "the cloth to be farther")
            self.assertGreater(guard.scales.count(), later)
            scales = [message.data for message in guard.scales.messages[since:]]
            self.assertEqual(set(scales[later - since:]), {1.0}, guard.name)

    def test_servo_would_get_the_scale(self):
        topics = dict(rosgraph.Master("/test").getTopicTypes())
        self.assertEqual(topics[SERVO_TOPIC], "std_msgs/Float64")
        self.assertNotIn("/by_time/speed_scale", topics)


if __name__ == "__main__":
    rospy.init_node("guard_distance_test")
    rostest.rosrun(PACKAGE, "guard_distance", GuardDistance, sys.argv)
