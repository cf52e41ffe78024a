#!/usr/bin/env python3
"""Kills publisher, TF source, monitor and master and starts them again, lets the clock jump, and
fills the disk. What is no longer known must be UNKNOWN by its deadline, everything else must go
on, and everything must be known again afterwards."""
import json
import os
import threading
import time
import unittest

from load_support import NAME, Session, scene, wait_until

LINKS, OBJECTS = 2, 2
MAX_MESH_AGE_S = 0.5
SLACK_S = 2.0  # a busy machine's
LONGEST_SILENCE_S = 1.5
UNKNOWN = 4


class States:
    """~contact_states as they come, of whichever monitor there is."""

    def __init__(self):
        import rospy
        from deformable_contact_monitor.msg import ContactStates
        self.messages = []  # (when, {object: states of its pairs}, message)
        self.subscriber = rospy.Subscriber(NAME + "/contact_states", ContactStates, self._store,
                                           tcp_nodelay=True)

    def _store(self, message):
        states = {}
        for state in message.states:
            states.setdefault(state.body_b, set()).add(state.state)
        self.messages.append((time.monotonic(), states, message))

    def since(self, when):
        return [entry for entry in list(self.messages) if entry[0] >= when]

    def wait(self, what, wanted, since):
        """The first (when, states, message) whose states are wanted."""
        found = []

        def look():
            found.extend(entry for entry in self.since(since) if wanted(entry[1]))
            return found
        wait_until(look, what)
        return found[0]

    def longest_silence_s(self, since):
        times = [since] + [entry[0] for entry in self.since(since)] + [time.monotonic()]
        return max(after - before for before, after in zip(times, times[1:]))


def known(*names):
    return lambda states: all(name in states and UNKNOWN not in states[name] for name in names)


def unknown(*names):
    return lambda states: all(states.get(name) == {UNKNOWN} for name in names)


class Clock:
    """/clock, as far from wall time as it is told."""

    def __init__(self):
        import rospy
        from rosgraph_msgs.msg import Clock as Message
        self.offset_s = 1000.0
        self.ended = threading.Event()
        publisher = rospy.Publisher("/clock", Message, queue_size=10)

        def run():
            start = time.monotonic()
            while not self.ended.wait(0.01):
                passed_s = time.monotonic() - start
                publisher.publish(Message(rospy.Time.from_sec(self.offset_s + passed_s)))
        self.thread = threading.Thread(target=run, daemon=True)
        self.thread.start()

    def stop(self):
        self.ended.set()
        self.thread.join()


class Faults(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.session = Session(tree=scene(LINKS, OBJECTS, backend="cpu",
                                         max_mesh_age_s=MAX_MESH_AGE_S))
        cls.addClassCleanup(cls.session.__exit__)
        cls.session.__enter__()
        import rospy
        rospy.init_node("faults", disable_signals=True)
        cls.states = States()

    def setUp(self):
        self.clients = {}
        self.addCleanup(self.kill_clients)

    def kill_clients(self):
        for client in self.clients.values():
            client.kill()

    def start_client(self, name):
        """"tf", or an object's number."""
        options = {"objects": 0, "links": LINKS} if name == "tf" else {"first": name, "rate": 30}
        self.clients[name] = self.session.client(unwatched=True, **options)

    def start_all(self):
        """A monitor and all that it is fed with; from then on all is known."""
        since = time.monotonic()
        monitor = self.session.monitor()
        self.addCleanup(monitor.kill)
        self.start_clients()
        self.wait_until_known(since)
        return monitor

    def start_clients(self):
        for name in ("tf", *range(OBJECTS)):
            self.start_client(name)

    def wait_until_known(self, since):
        return self.states.wait("known states", known("object_0", "object_1"), since)

    def assert_in_time(self, killed, entry):
        """The UNKNOWN of `entry` came by the deadline of data that ended at `killed`."""
        self.assertLess(entry[0] - killed, MAX_MESH_AGE_S + SLACK_S)
        reasons = {state.reason for state in entry[2].states if state.state == UNKNOWN}
        self.assertNotIn("", reasons)
        return reasons

    def test_a_publisher_is_killed_and_comes_back(self):
        self.start_all()
        killed = time.monotonic()
        self.clients[0].kill()
        lost = self.states.wait("UNKNOWN", unknown("object_0"), killed)
        self.assert_in_time(killed, lost)
        self.start_client(0)
        back = self.states.wait("object_0 again", known("object_0"), lost[0])
        for _, states, _ in self.states.since(killed):
            self.assertNotIn(UNKNOWN, states["object_1"])
        self.assertGreater(back[0], lost[0])
        self.assertLess(self.states.longest_silence_s(killed), LONGEST_SILENCE_S)

    def test_the_source_of_tf_is_killed_and_comes_back(self):
        self.start_all()
        killed = time.monotonic()
        self.clients["tf"].kill()
        lost = self.states.wait("UNKNOWN", unknown("object_0", "object_1"), killed)
        reasons = self.assert_in_time(killed, lost)
        self.assertTrue(all("link_" in reason for reason in reasons), reasons)
        self.start_client("tf")
        self.wait_until_known(lost[0])
        self.assertLess(self.states.longest_silence_s(killed), LONGEST_SILENCE_S)

    def test_the_monitor_is_killed_and_respawned(self):
        since = time.monotonic()
        launched = self.session.start(
            ["roslaunch", "deformable_contact_monitor", "contact_monitor.launch", "respawn:=true",
             "config:=" + self.write_config()])
        self.addCleanup(launched.interrupt)
        self.start_clients()
        self.wait_until_known(since)
        pid = self.session.node_api().getPid("/test")[2]
        os.kill(pid, 9)
        killed = time.monotonic()
        again = self.wait_until_known(killed + 0.1)  # what had been sent may still come
        self.assertNotEqual(self.session.node_api().getPid("/test")[2], pid, launched.output())
        cycles = [message.cycle for _, _, message in self.states.since(killed)]
        self.assertIn(again[2].cycle, cycles)

    def write_config(self):
        path = os.path.join(self.session.home.name, "config.yaml")
        with open(path, "w") as file:
            json.dump(self.session.tree[NAME], file)  # YAML, too
        return path

    def test_the_clock_jumps_under_load(self):
        self.session.api.setParam("/test", "/use_sim_time", True)
        self.addCleanup(self.session.api.setParam, "/test", "/use_sim_time", False)
        clock = Clock()
        self.addCleanup(clock.stop)
        monitor = self.start_all()
        for jump_s in (100.0, -100.0, 0.3, -0.3, 3600.0, -900.0):
            jumped = time.monotonic()
            clock.offset_s += jump_s
            self.wait_until_known(jumped + MAX_MESH_AGE_S)
            self.assertLess(self.states.longest_silence_s(jumped), LONGEST_SILENCE_S)
            self.assertTrue(monitor.runs(), monitor.output())

    def test_nobody_can_write_what_it_says(self):
        with open("/dev/full", "w") as full:
            monitor = self.session.monitor(stdout=full)
        self.addCleanup(monitor.kill)
        since = time.monotonic()
        self.start_clients()
        self.wait_until_known(since)
        _, code = monitor.interrupt()
        self.assertEqual(code, 0)

    def test_z_a_master_that_is_away_costs_nothing(self):
        """It comes last. What happens when another one starts: test/ros/new_master.py."""
        monitor = self.start_all()
        killed = time.monotonic()
        self.session.master.kill()
        time.sleep(4)
        for _, states, _ in self.states.since(killed):
            self.assertTrue(known("object_0", "object_1")(states), states)
        self.assertLess(self.states.longest_silence_s(killed), LONGEST_SILENCE_S)
        _, code = monitor.interrupt()
        self.assertEqual(code, 0)


if __name__ == "__main__":
    unittest.main()
