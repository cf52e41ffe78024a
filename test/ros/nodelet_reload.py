#!/usr/bin/env python3
"""The monitor is unloaded and loaded again under load: it is gone when the manager says so, and
finds contacts after each load. $DCM_NODELET_RELOADS says how often (8)."""
import io
import os
import sys
import threading
import unittest

import numpy as np
import rosgraph
import rospy
import rostest
from nodelet.srv import NodeletList, NodeletLoad, NodeletLoadRequest, NodeletUnload
from tf2_msgs.msg import TFMessage

import boxes_scene
from boxes_scene import CLOTH, REFERENCE_FRAME
from deformable_contact_monitor.srv import GetContacts
from monitor_test_support import (
    PACKAGE, WAIT_S, ContactState, ContactStates, DeformableMesh, Log, RawMesh, mesh_message,
    to_mesh, transform_message)

LOADS = int(os.environ.get("DCM_NODELET_RELOADS", "8"))
NAME = "/monitor"


def heavy_message():
    """A mesh that takes long to read and is refused then, so that callbacks are busy and cycles are
    not."""
    mesh = to_mesh(np.zeros(3000000), [])
    data = io.BytesIO()
    mesh_message("another", rospy.Time(1), REFERENCE_FRAME, mesh).serialize(data)
    return RawMesh(data.getvalue())


class Load:
    """Sends transforms and meshes until it is stopped, and calls a service of the monitor whenever
    there is one."""

    def __init__(self):
        self.stopped = False
        self.tf = rospy.Publisher("/tf", TFMessage, queue_size=10)
        self.cloth, self.sheet = (rospy.Publisher(topic, DeformableMesh, queue_size=2)
                                  for topic in ("/cloth", "/sheet"))
        self.heavy = heavy_message()
        self.threads = [threading.Thread(target=work)
                        for work in (self._send, self._send_heavy, self._call, self._call)]
        for thread in self.threads:
            thread.start()

    def _send(self):
        while not self.stopped:
            stamp = rospy.Time.now()
            self.tf.publish(transform_message(stamp, boxes_scene.edges()))
            self.cloth.publish(mesh_message("cloth", stamp, REFERENCE_FRAME, CLOTH))
            rospy.sleep(0.02)

    def _send_heavy(self):
        while not self.stopped:
            self.sheet.publish(self.heavy)
            rospy.sleep(0.005)

    def _call(self):
        while not self.stopped:
            service = rospy.ServiceProxy(NAME + "/get_contacts", GetContacts)
            try:
                while not self.stopped:
                    service()
            except rospy.ServiceException:
                rospy.sleep(0.02)

    def stop(self):
        self.stopped = True
        for thread in self.threads:
            thread.join()


def of_the_monitor():
    """Names that the master knows of it: topics and services."""
    state = rosgraph.Master("/test").getSystemState()
    return {name for kind in (state[0], state[2]) for name, _ in kind
            if name.startswith(NAME + "/")}


class NodeletReload(unittest.TestCase):

    def test_each_load_finds_contacts_and_each_unload_leaves_nothing(self):
        for service in ("load_nodelet", "unload_nodelet", "list"):
            rospy.wait_for_service("/manager/" + service, WAIT_S)
        load = rospy.ServiceProxy("/manager/load_nodelet", NodeletLoad)
        unload = rospy.ServiceProxy("/manager/unload_nodelet", NodeletUnload)
        names = rospy.ServiceProxy("/manager/list", NodeletList)
        request = NodeletLoadRequest(name=NAME, type=PACKAGE + "/ContactMonitor")
        states = None
        work = Load()
        self.addCleanup(work.stop)
        for turn in range(LOADS):
            self.assertTrue(load(request).success, f"load {turn}")
            self.assertIn(NAME + "/reset", of_the_monitor())
            states = states or Log(NAME + "/contact_states", ContactStates)
            states.wait(f"contact after load {turn}", lambda m: {
                (s.body_a, s.body_b): s.state for s in m.states}.get(
                    ("palm", "cloth")) == ContactState.CONTACT, states.count())
            self.assertTrue(unload(name=NAME).success, f"unload {turn}")
            self.assertEqual(of_the_monitor(), set(), f"after unload {turn}")
            self.assertEqual(names().nodelets, [])


if __name__ == "__main__":
    rospy.init_node("nodelet_reload_test")
    rostest.rosrun(PACKAGE, "nodelet_reload", NodeletReload, sys.argv)
