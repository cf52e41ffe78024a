#!/usr/bin/env python3
"""Loads a robot whose mesh files do harm. Its other links must be usable, everything else must go
on while the files are read, and Ctrl-C must end the node meanwhile."""
import glob
import math
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest

import roslib.packages
import rospy
import rostest
from diagnostic_msgs.msg import DiagnosticArray
from std_srvs.srv import Trigger

from deformable_contact_monitor.msg import ContactState, LinkMeshes

from boxes_scene import CLOTH, REFERENCE_FRAME, UPRIGHT
from monitor_test_support import (
    PACKAGE, WAIT_S, Log, MeshPublisher, Monitor, Transforms, executable, now, pairs_of, touching,
    until_frames_are_seen, wait_until)

BOX = '<box size="0.1 0.1 0.1"/>'
END_S = 5  # from Ctrl-C to the end of a node; a reader may take 20 s
ITSELF = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>
<library_visual_scenes><visual_scene id="s"><node id="a"><instance_node url="#a"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""


def slow_dae():
    """COLLADA with polygons that take a reader about a second."""
    corners, faces = 19000, 40
    places = []
    for i in range(corners):
        angle, radius = 2 * math.pi * i / corners, 1 + 0.3 * (i % 2)
        places.append(f"{radius * math.cos(angle):.7f} {radius * math.sin(angle):.7f} 0")
    face = " ".join(str(i) for i in range(corners))
    params = "".join(f'<param name="{axis}" type="float"/>' for axis in "XYZ")
    return f"""<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset/>
<library_geometries><geometry id="g"><mesh><source id="p">
<float_array id="q" count="{3 * corners}">{" ".join(places)}</float_array><technique_common>
<accessor source="#q" count="{corners}" stride="3">{params}</accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<polylist count="{faces}"><input semantic="VERTEX" source="#v" offset="0"/>
<vcount>{f"{corners} " * faces}</vcount><p>{(face + " ") * faces}</p></polylist></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node>
<instance_geometry url="#g"/></node></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>
"""


def urdf(geometry_of):
    """A robot of those links, all on the first."""
    links = "".join(f'<link name="{link}"><collision><geometry>{geometry}</geometry></collision>'
                    "</link>" for link, geometry in geometry_of.items())
    first, *others = geometry_of
    joints = "".join(f'<joint name="{link}_joint" type="fixed"><parent link="{first}"/>'
                     f'<child link="{link}"/></joint>' for link in others)
    return f'<robot name="r">{links}{joints}</robot>'


def parent_of(reader):
    """Process id of a running read_link_mesh's parent; None if there is no such reader."""
    try:
        with open(f"/proc/{reader}/stat") as file:
            state, parent = file.read().split(" (read_link_mesh) ")[1].split()[:2]
    except (OSError, IndexError):
        return None  # ended, or another program
    return None if state == "Z" else int(parent)


def readers_of(process):
    """Process ids of its running read_link_mesh."""
    numbers = [int(os.path.basename(path)) for path in glob.glob("/proc/[0-9]*")]
    return [number for number in numbers if parent_of(number) == process.pid]


def stop_reader_of(process):
    """Keeps its read_link_mesh from ending by itself, and returns its process id."""
    wait_until(lambda: readers_of(process), "a reader")
    time.sleep(0.1)  # it first asks to die with its parent
    reader, = readers_of(process)
    os.kill(reader, signal.SIGSTOP)
    return reader


class HostileRobot(unittest.TestCase):

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.slow = urdf({"good": BOX, "bad": self.mesh("slow.dae", slow_dae())})

    def tearDown(self):
        self.folder.cleanup()

    def mesh(self, name, text):
        path = os.path.join(self.folder.name, name)
        with open(path, "w") as file:
            file.write(text)
        return f'<mesh filename="{path}"/>'

    def start(self, name, description, command=(executable("contact_monitor"),)):
        rospy.set_param("/robot_description", description)
        rospy.set_param(f"/{name}/reference_frame", REFERENCE_FRAME)
        rospy.set_param(f"/{name}/tf_timeout_s", 1.0)
        rospy.set_param(f"/{name}/objects", [{"name": "cloth", "topic": f"/{name}/cloth"}])
        node = subprocess.Popen([*command, "__name:=" + name])
        self.addCleanup(node.kill)
        return node

    def interrupt_and_expect_the_end(self, node):
        reader, = readers_of(node)
        start = time.monotonic()
        node.send_signal(signal.SIGINT)
        self.assertEqual(node.wait(WAIT_S), 0)
        self.assertLess(time.monotonic() - start, END_S)
        self.assertIsNone(parent_of(reader))

    def test_ctrl_c_while_the_node_starts(self):
        node = self.start("starting", self.slow)
        stop_reader_of(node)
        self.interrupt_and_expect_the_end(node)

    def test_a_reader_dies_with_its_node(self):
        node = self.start("killed", self.slow)
        reader = stop_reader_of(node)
        start = time.monotonic()
        node.kill()
        node.wait()
        wait_until(lambda: not parent_of(reader) is not None, "the reader's end")
        self.assertLess(time.monotonic() - start, END_S)

    def test_a_nodelet_finds_the_reader(self):
        """Its process is of another package."""
        mesh = self.mesh("triangle.obj", "v 0 0 0\nv 1 0 0\nv 0 2 3\nf 1 2 3\n")
        nodelet, = roslib.packages.find_node("nodelet", "nodelet")
        tip = (f'<link name="tip"><visual><geometry>{BOX}</geometry></visual></link>'
               '<joint name="j" type="fixed"><parent link="read"/><child link="tip"/></joint>')
        self.start("standalone", urdf({"read": mesh}).replace("</robot>", tip + "</robot>"),
                   (nodelet, "standalone", PACKAGE + "/ContactMonitor"))
        message = Log("/standalone/robot_meshes", LinkMeshes).wait("the robot")
        self.assertEqual([(link.link, len(link.triangles)) for link in message.meshes],
                         [("read", 3)])
        # A link that is not monitored, because it has visual geometry only, is named.
        Log("/diagnostics", DiagnosticArray).wait("the link that is not monitored", lambda array: any(
            value.key == "link tip" and value.value.startswith("not monitored: visual")
            for status in array.status for value in status.values))

    def test_a_bad_file_and_a_slow_reload_cost_nobody_else(self):
        node = self.start("reloading", urdf({"good": BOX, "bad": self.mesh("self.dae", ITSELF)}))
        monitor = Monitor("/reloading")
        transforms = Transforms()
        cloth = MeshPublisher("cloth", "/reloading/cloth")

        def cycle():
            stamp = now()
            transforms.send(stamp, {link: (REFERENCE_FRAME, ((0, 0, 0), UPRIGHT))
                                    for link in ("good", "bad")})
            cloth.send(stamp, REFERENCE_FRAME, CLOTH)
            return monitor.contacts_at(stamp)
        until_frames_are_seen(cycle)
        contacts = cycle()
        self.assertEqual(touching(pairs_of(contacts)), {"good"})
        self.assertTrue(any("its reader crashed" in text for text in contacts.skipped),
                        contacts.skipped)
        states = monitor.states_at(contacts.header.stamp)
        self.assertEqual(states["good", "cloth"], ContactState.CONTACT)
        self.assertEqual(states["bad", "cloth"], ContactState.UNKNOWN)

        rospy.set_param("/robot_description", self.slow)
        reload = threading.Thread(target=self.reload, daemon=True)
        reload.start()
        stop_reader_of(node)
        for _ in range(20):
            start = time.monotonic()
            cycle()
            self.assertLess(time.monotonic() - start, END_S)
            time.sleep(0.05)
        self.assertTrue(reload.is_alive() and readers_of(node), "the reload is over already")
        self.interrupt_and_expect_the_end(node)
        reload.join(WAIT_S)

    @staticmethod
    def reload():
        try:
            rospy.ServiceProxy("/reloading/reload_robot", Trigger)()
        except rospy.ServiceException:
            pass  # the node ends meanwhile


if __name__ == "__main__":
    rospy.init_node("hostile_robot_test")
    rostest.rosrun(PACKAGE, "hostile_robot", HostileRobot, sys.argv)
