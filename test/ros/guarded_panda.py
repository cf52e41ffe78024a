"""A Panda above a cloth, whose joints move as a contact_guard lets them, and the programs around
it, which can be killed and started again."""
import os
import signal
import subprocess
import tempfile
import threading
import time

import roslib.packages
import rospy
from sensor_msgs.msg import JointState
from std_msgs.msg import Bool, Float64
from tf2_msgs.msg import TFMessage

from monitor_test_support import Log, executable, grid, transform_message, wait_until
from panda_scene import READY, REFERENCE_FRAME

NAMES = [f"panda_joint{i + 1}" for i in range(7)] + ["panda_finger_joint1", "panda_finger_joint2"]
SHOULDER = 1  # the joint that lowers the hand
CLOTH_AT_M = (0.35, 0.0, 0.27)  # the hand comes from 0.2 m above it
LOWERED_M = 0.06
FASTEST = 0.25  # [rad/s]
PERIOD_S = 0.02


class Guard:
    """Output of the guard of that name."""

    def __init__(self, name):
        self.name = name
        self.stops = Log(f"/{name}/stop", Bool)
        self.scales = Log(f"/{name}/speed_scale", Float64)

    def stop(self):
        return not self.stops.messages or self.stops.messages[-1].data

    def scale(self):
        return self.scales.messages[-1].data if self.scales.messages else 0.0

    def is_free(self):
        return not self.stop() and self.scale() == 1


class Arm:
    """Moves one joint at a speed that the guard scales, and stands still while it says stop. Sends
    joint states, and the transform of the cloth's frame, in a thread."""

    def __init__(self):
        self.guard = None
        self.direction = 0  # 1: towards the cloth
        self.turned = 0.0  # [rad]; 0: far from the cloth
        self.cloth_lowered_m = 0.0
        self.joints = rospy.Publisher("/joint_states", JointState, queue_size=10)
        self.transforms = rospy.Publisher("/tf", TFMessage, queue_size=100)
        threading.Thread(target=self._run, daemon=True).start()

    def _run(self):
        while not rospy.is_shutdown():
            if self.guard is not None and not self.guard.stop():
                step = self.direction * FASTEST * self.guard.scale() * PERIOD_S
                self.turned = min(max(0.0, self.turned + step), 1.0)
            try:
                self._send(rospy.Time.now())
            except rospy.ROSException:  # closed meanwhile: the test ends
                return
            time.sleep(PERIOD_S)

    def _send(self, stamp):
        joints = JointState(name=NAMES, position=READY + [0.02, 0.02])
        joints.position[SHOULDER] += self.turned
        joints.header.stamp = stamp
        self.joints.publish(joints)
        x, y, z = CLOTH_AT_M
        pose = (x, y, z - self.cloth_lowered_m), (0, 0, 0, 1)
        self.transforms.publish(transform_message(stamp, {"cloth": (REFERENCE_FRAME, pose)}))


class Programs:
    """The monitor, the mesh's publisher and the one of transforms, each a process."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        cloth = os.path.join(self.folder.name, "cloth.obj")
        write_obj(cloth, grid(20, 0.2))
        publisher = roslib.packages.find_node("robot_state_publisher", "robot_state_publisher")[0]
        self.commands = {
            "monitor": [executable("contact_monitor"), "__name:=contact_monitor"],
            "mesh": [executable("soft_scene"), "--meshes", cloth, "--loop", "--frame", "cloth",
                     "--name", "cloth", "--topic", "/cloth", "--rate", "30"],
            "transforms": [publisher, "__name:=robot_state_publisher"]}
        self.running = {}

    def start(self):
        """Those that do not run."""
        for name in set(self.commands) - set(self.running):
            self.running[name] = subprocess.Popen(self.commands[name])

    def kill(self, name):
        """As a crash: nobody is told."""
        self.running[name].send_signal(signal.SIGKILL)
        self.running.pop(name).wait()

    def end(self):
        for name in list(self.running):
            self.kill(name)
        self.folder.cleanup()


def write_obj(path, mesh):
    with open(path, "w") as file:
        for x, y, z in mesh[0]:
            file.write(f"v {x} {y} {z}\n")
        for a, b, c in mesh[1] + 1:
            file.write(f"f {a} {b} {c}\n")


def until_free(guard):
    wait_until(guard.is_free, f"{guard.name} lets the robot go at full speed")
