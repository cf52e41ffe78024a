#!/usr/bin/env python3
"""Sends the Panda's link meshes on a topic: late, again, changed, and bad ones that are rejected.
The pairs of the T-shirt must be the oracle's for the link meshes sent last."""
import sys
import unittest

import numpy as np
import rospy
import rostest

from rosgraph_msgs.msg import Log as ConsoleLine

from deformable_contact_monitor.msg import ContactEvent, LinkMesh, LinkMeshes
from monitor_test_support import (
    PACKAGE, ContactState, Log, Monitor, now, pairs_of, peak_memory_mib, touching, wait_until,
    with_length)
from panda_scene import PandaScene

SHIRT_AT = (0.35, 0.05, 0.5)  # [m]


class LinkMeshesTopic(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        cls.monitor = Monitor()
        cls.robot_log = cls.monitor.robot_meshes_log()
        cls.scene = PandaScene(rospy.get_param("~data"))
        cls.stamp = None

    def cycle(self, frame=7):
        """Stamp, contacts and states of a new cycle."""
        self.stamp = now(after=self.stamp)
        self.scene.show(self.stamp, frame, 2, SHIRT_AT)
        return (self.stamp, self.monitor.contacts_at(self.stamp),
                self.monitor.states_at(self.stamp))

    def send(self, meshes):
        """Sends the robot."""
        self.publisher.publish(self.message_of(meshes))

    @staticmethod
    def message_of(meshes):
        message = LinkMeshes()
        for link, (vertices, triangles) in meshes.items():
            message.meshes.append(LinkMesh(link=link, source="test", vertices=vertices.flatten(),
                                           triangles=triangles.flatten()))
        return message

    def wait_for_robot(self, since):
        self.robot_log.wait("the new robot on ~robot_meshes", since=since)

    def check_cycle(self, meshes):
        stamp, contacts, states = self.cycle()
        expected = self.scene.expected(stamp, 7, meshes)
        self.assertGreater(len(touching(expected)), 1, "the scene is not what this test is about")
        self.assertEqual(pairs_of(contacts), expected)
        self.assertEqual(contacts.bodies, list(meshes) + ["tshirt"])
        self.assertTrue(contacts.complete, contacts.skipped)
        for link in meshes:
            wanted = ContactState.CONTACT if link in touching(expected) else ContactState.NONE
            self.assertEqual(states[link, "tshirt"], wanted, link)
        return expected

    def test_late_again_and_changed(self):
        # Late: what is not known yet is UNKNOWN, and not complete.
        _, contacts, states = self.cycle()
        self.assertEqual(states, {("robot", "tshirt"): ContactState.UNKNOWN})
        self.assertEqual(contacts.pairs, [])
        self.assertFalse(contacts.complete)
        self.assertTrue(contacts.skipped[0].startswith("robot: "), contacts.skipped)

        self.publisher = rospy.Publisher(self.monitor.name + "/robot_link_meshes", LinkMeshes,
                                         queue_size=1, latch=True)
        meshes = dict(self.scene.links)
        self.send(meshes)
        self.wait_for_robot(since=0)
        self.scene.show_until_seen(self.monitor)
        first = self.check_cycle(meshes)

        # Again: nothing happens.
        ended = self.ends()
        self.send(meshes)
        for _ in range(3):
            self.assertEqual(self.check_cycle(meshes), first)
        self.assertEqual(self.ends(), ended, "the same robot again ended contacts")

        # Changed: a link is gone, one has its triangles the other way round, one is inflated.
        del meshes["panda_link0"]
        vertices, triangles = meshes["panda_hand"]
        meshes["panda_hand"] = (vertices, triangles[::-1])
        vertices, triangles = meshes["panda_link7"]
        meshes["panda_link7"] = (vertices * np.float32(1.25), triangles[:150])
        self.send(meshes)
        self.wait_for_robot(since=1)
        self.assertEqual(self.robot_log.count(), 2, "the same robot was published again")
        self.assertEqual(list(self.monitor.robot_meshes(self.robot_log)), list(meshes))
        second = self.check_cycle(meshes)
        self.assertNotEqual(first, second)
        wait_until(lambda: self.ends() > ended, "the end of contacts with the old robot")

        # One link is malformed: it is UNKNOWN and named, the others stay.
        good = dict(meshes)
        vertices, triangles = meshes["panda_hand"]
        meshes["panda_hand"] = (vertices, np.full_like(triangles, 1000000))
        self.send(meshes)
        self.wait_for_robot(since=2)
        stamp, contacts, states = self.cycle()
        self.assertEqual(states["panda_hand", "tshirt"], ContactState.UNKNOWN)
        self.assertEqual([text.split(":")[0] for text in contacts.skipped], ["panda_hand"])
        self.assertFalse(contacts.complete)
        del good["panda_hand"]
        self.assertEqual(pairs_of(contacts), self.scene.expected(stamp, 7, good))

        self.check_what_is_rejected(good)

        # What is not a number is the same robot when it comes again.
        vertices, triangles = good["panda_link7"]
        good["panda_link7"] = (np.full_like(vertices, np.nan), triangles)
        count = self.robot_log.count()
        self.send(good)
        self.wait_for_robot(since=count)
        self.send(good)
        for _ in range(2):
            self.cycle()
        self.assertEqual(self.robot_log.count(), count + 1, "the same robot was published again")

    def check_what_is_rejected(self, good):
        # The bytes are damaged: nobody knows the links until the next message.
        console = Log("/rosout", ConsoleLine)
        before_mib = peak_memory_mib(self.monitor.name)
        last, _ = list(good.values())[-1]
        self.check_rejected(with_length(self.message_of(good), last.size, 2**29), console,
                            "meshes.vertices claims 2147483648 bytes", good)
        self.assertLess(peak_memory_mib(self.monitor.name), before_mib + 200)

        # A link is sent twice: nobody knows which shape is right, nor what else is wrong.
        twice = self.message_of(good)
        twice.meshes.append(twice.meshes[0])
        self.check_rejected(twice, console, "was sent twice in one message", good)

    def check_rejected(self, message, console, problem, links):
        count = self.robot_log.count()
        self.publisher.publish(message)
        console.wait("the error", lambda m: problem in m.msg and "every link is UNKNOWN" in m.msg)
        self.wait_for_robot(since=count)
        _, contacts, states = self.cycle()
        self.assertEqual({states[link, "tshirt"] for link in links}, {ContactState.UNKNOWN})
        self.assertIn(problem, contacts.skipped[0])
        # The same message again changes nothing; a good one does.
        ended, robots = self.ends(), self.robot_log.count()
        self.publisher.publish(message)
        self.cycle()
        self.assertEqual((self.ends(), self.robot_log.count()), (ended, robots))
        self.send(links)
        self.wait_for_robot(since=robots)
        stamp, contacts, _ = self.cycle()
        self.assertEqual(pairs_of(contacts), self.scene.expected(stamp, 7, links))

    def ends(self):
        return sum(event.type == ContactEvent.END for event in list(self.monitor.events.messages))


if __name__ == "__main__":
    rospy.init_node("link_meshes_topic_test")
    rostest.rosrun(PACKAGE, "link_meshes_topic", LinkMeshesTopic, sys.argv)
