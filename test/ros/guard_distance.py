#!/usr/bin/env python3
"""Moves a cloth towards a box, as far and as fast as contact_guard lets it, and away again. The
distance of the two is known at each stamp, and so is the scale that belongs to it."""
import bisect
import os
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import rosgraph
import rospy
import rostest
from std_msgs.msg import Bool, Float64
from tf2_msgs.msg import TFMessage

import boxes_scene
from deformable_contact_monitor.msg import ContactState, ContactStates
from guarded_panda import write_obj
from monitor_test_support import (
    PACKAGE, Log, executable, grid, to_mesh, transform_message, wait_until)

TOP_M = 0.05  # of the palm, whose box is 0.1 m high
START_M = 0.7  # distance before each test; beyond the margin of 0.6 m
PERIOD_S = 0.01
STOP_M, LEAST_SCALE = 0.05, 0.1
SERVO_TOPIC = "/servo_server/internal/collision_velocity_scale"


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


class Cloth:
    """Sends the transform of the cloth's frame, at a height that changes by a speed [m/s]."""

    def __init__(self):
        self.lock = threading.Lock()
        self.speed = lambda: 0.0
        self.distance_m = START_M
        self.sent = []  # (stamp [s], distance)
        self.path = []  # (distance, speed towards the box)
        self.publisher = rospy.Publisher("/tf", TFMessage, queue_size=100)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        before = rospy.Time.now()
        while not rospy.is_shutdown():
            stamp = rospy.Time.now()
            if stamp > before:
                with self.lock:
                    self._move((stamp - before).to_sec(), stamp)
                before = stamp
            time.sleep(PERIOD_S)

    def _move(self, period_s, stamp):
        speed = self.speed()
        self.distance_m = max(0.01, self.distance_m - speed * period_s)
        self.path.append((self.distance_m, speed))
        self.sent.append((stamp.to_sec(), self.distance_m))
        edges = dict(boxes_scene.edges(links=("palm",)),
                     cloth=("base", ((0, 0, self.distance_m + TOP_M), boxes_scene.UPRIGHT)))
        try:
            self.publisher.publish(transform_message(stamp, edges))
        except rospy.ROSException:  # closed meanwhile: the test ends
            pass

    def move(self, speed):
        with self.lock:
            self.speed = speed
            self.path = []

    def at(self, distance_m):
        with self.lock:
            self.speed = lambda: 0.0
            self.distance_m = distance_m

    def distance_at(self, stamp_s):
        """As TF interpolates it; None if it was not sent yet."""
        with self.lock:
            i = bisect.bisect_left(self.sent, (stamp_s, 0))
            if i == 0 or i == len(self.sent):
                return None
            (t0, d0), (t1, d1) = self.sent[i - 1], self.sent[i]
            return d0 + (d1 - d0) * (stamp_s - t0) / (t1 - t0)


class GuardDistance(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        vertices, triangles = grid(10, 0.6)
        vertices[:, 2] = 0
        mesh = os.path.join(folder.name, "cloth.obj")
        write_obj(mesh, to_mesh(vertices.flatten(), triangles.flatten()))
        publisher = subprocess.Popen(
            [executable("scene_publisher"), "--meshes", mesh, "--loop", "--frame", "cloth",
             "--object", "cloth", "--topic", "/cloth", "--rate", "30"])
        cls.addClassCleanup(publisher.wait)
        cls.addClassCleanup(publisher.terminate)
        cls.cloth = Cloth()
        cls.states = Log("/contact_monitor/contact_states", ContactStates)
        cls.by_distance = Guard("by_distance")
        cls.by_time = Guard("by_time", SERVO_TOPIC)

    def setUp(self):
        self.cloth.at(START_M)
        for guard in self.by_distance, self.by_time:
            wait_until(guard.is_free, f"{guard.name} lets the cloth go")
        self.since = self.states.count()

    def near(self):
        """The states NEAR of this test, without the jump to its start."""
        found = []
        for message in self.states.messages[self.since:]:
            found += [state for state in message.states if state.state == ContactState.NEAR]
        return found

    def approach(self, guard, speed_mps):
        """Returns the scales from then on until the guard stops."""
        since = guard.scales.count()
        self.cloth.move(lambda: speed_mps * guard.allowed())
        wait_until(guard.stop, f"{guard.name} stops the cloth")
        self.assertLess(self.cloth.distance_m, 0.06)
        self.assertGreater(self.cloth.distance_m, 0.03)
        return [message.data for message in guard.scales.messages[since:]]

    def check_states(self):
        """Distances, points and normals are those of the scene."""
        states = self.near()
        self.assertGreater(len(states), 20)
        for state in states:
            distance_m = self.cloth.distance_at(state.stamp.to_sec())
            self.assertIsNotNone(distance_m)
            self.assertAlmostEqual(state.min_separation, distance_m, delta=2e-6)
            self.assertLessEqual(state.distance_low, state.min_separation)
            self.assertAlmostEqual(state.point_a.z, TOP_M, delta=1e-6)
            self.assertAlmostEqual(state.point_b.z, TOP_M + distance_m, delta=2e-6)
            self.assertAlmostEqual(state.normal.z, 1, delta=1e-6)
        return states

    def test_by_distance(self):
        scales = self.approach(self.by_distance, 0.15)
        states = self.check_states()

        def scale_at(distance_m):
            share = (distance_m - STOP_M) / (0.3 - STOP_M)
            return min(1.0, LEAST_SCALE + (1 - LEAST_SCALE) * share)
        expected = sorted(scale_at(state.min_separation) for state in states)
        slowed = [scale for scale in scales if 0 < scale < 1]
        self.assertGreater(len(slowed), 5)
        for scale in slowed:  # each belongs to some state
            i = min(bisect.bisect_left(expected, scale), len(expected) - 1)
            self.assertLess(min(abs(scale - e) for e in expected[max(0, i - 1):i + 1]), 1e-4)
        self.assertLess(min(slowed), 0.25)
        at = self.cloth.distance_m
        looks = self.states.count()
        wait_until(lambda: self.states.count() > looks + 10, "states")
        self.assertEqual(self.cloth.distance_m, at)
        self.assertTrue(self.by_distance.stop())

    def test_warns_before_it_stops(self):
        since = self.by_distance.warnings.count()
        self.approach(self.by_distance, 0.15)
        warned = [message.data for message in self.by_distance.warnings.messages[since:]]
        self.assertFalse(warned[0])
        self.assertIn(True, warned)
        self.assertTrue(warned[-1])
        self.cloth.at(0.25)  # between warn_distance_m and slow_distance_m
        wait_until(lambda: not self.by_distance.warnings.messages[-1].data, "no warning any more")
        self.cloth.at(0.15)
        wait_until(lambda: self.by_distance.warnings.messages[-1].data, "a warning")
        wait_until(lambda: not self.by_distance.stop(), "no stop")

    def test_by_time_to_contact(self):
        scales = self.approach(self.by_time, 0.4)
        self.check_states()
        self.assertGreater(len([scale for scale in scales if 0 < scale < 1]), 5)
        times = [(distance_m - STOP_M) / speed for distance_m, speed in self.cloth.path
                 if speed > 0.4 * 1.05 * LEAST_SCALE and distance_m < 0.5]
        # 1 s is asked for; the machine may be busy, so that a scale comes late.
        self.assertGreater(min(times), 0.5)
        # The distance alone slows only below 0.06 m.
        slowed_at = max(distance_m for distance_m, speed in self.cloth.path
                        if 0 < speed < 0.4 * 0.9)
        self.assertGreater(slowed_at, 0.2)

    def test_leaving_is_not_slowed(self):
        for guard in self.by_distance, self.by_time:
            self.cloth.at(0.055)
            wait_until(lambda g=guard: not g.stop() and g.scale() < 1, "a slow guard")
            since = guard.scales.count()
            self.cloth.move(lambda: -0.25)
            wait_until(lambda: self.cloth.distance_m > 0.25, "the cloth is away")
            later = guard.scales.count()
            wait_until(lambda: self.cloth.distance_m > 0.5, "the cloth is farther away")
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
