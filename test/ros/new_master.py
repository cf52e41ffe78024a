#!/usr/bin/env python3
"""Kills the ROS master and starts it anew, which roscpp does not notice. The monitor must end and
say why, so that respawn helps; the nodelet must say so as well. The test starts its own masters
and is no node."""
import os
import re
import signal
import subprocess
import tempfile
import time
import xmlrpc.client

from pages import free_port

WAIT_S = 60  # of wall time; far longer than anything takes, also on a busy machine
HERE = os.path.dirname(os.path.abspath(__file__))
DEVEL = os.path.join(os.environ["DCM_BINARY_DIR"], "devel")
SAID = "was restarted, and this node is no longer registered with it"


def wait_until(condition, what):
    deadline = time.monotonic() + WAIT_S
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {WAIT_S} s in vain for {what}")
        time.sleep(0.1)


class Master:
    """A rosmaster with the monitor's parameters, which is killed without a word."""

    def __init__(self, uri, names):
        self.api = xmlrpc.client.ServerProxy(uri)
        self.process = subprocess.Popen(
            ["rosmaster", "--core", "-p", uri.rsplit(":", 1)[1].strip("/")],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        wait_until(self.answers, "the master")
        with open(os.path.join(HERE, "two_boxes.urdf")) as urdf:
            self.api.setParam("/test", "/robot_description", urdf.read())
        for name in names:
            self.api.setParam("/test", name, {"reference_frame": "base", "ignored_links": ["lost"],
                                              "objects": [{"name": "cloth", "topic": "/cloth"}]})

    def answers(self):
        try:
            return self.api.getPid("/test")[0] == 1
        except OSError:
            return False

    def knows(self, topic):
        return any(name == topic for name, _ in self.api.getSystemState("/test")[2][0])

    def kill(self):
        self.process.kill()
        self.process.wait()


class Node:
    """A process whose output is kept."""

    def __init__(self, command, environment):
        self.log = tempfile.TemporaryFile(mode="w+")
        self.process = subprocess.Popen(command, env=environment, stdout=self.log,
                                        stderr=subprocess.STDOUT)

    def output(self):
        self.log.seek(0)
        return self.log.read()

    def stop(self):
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGINT)
            try:
                self.process.wait(WAIT_S)
            except subprocess.TimeoutExpired:
                self.process.kill()


def main():
    uri = f"http://127.0.0.1:{free_port()}/"
    names = ("/contact_monitor", "/as_nodelet")
    with tempfile.TemporaryDirectory() as home:
        environment = dict(os.environ, ROS_MASTER_URI=uri, ROS_IP="127.0.0.1", ROS_HOME=home,
                           PYTHONUNBUFFERED="1")
        environment.pop("ROS_HOSTNAME", None)
        source = f". {DEVEL}/setup.sh; exec "
        master = Master(uri, names)
        nodes = [Node(["sh", "-c", source + command], environment) for command in (
            f"{DEVEL}/lib/deformable_contact_monitor/contact_monitor",
            "rosrun nodelet nodelet standalone deformable_contact_monitor/ContactMonitor "
            "__name:=as_nodelet")]
        try:
            for name in names:
                wait_until(lambda: master.knows(name + "/contacts"), f"the topics of {name}")
            time.sleep(4)  # so that each has seen itself there
            master.kill()
            time.sleep(4)
            assert nodes[0].process.poll() is None, "it must outlive a master that is away"
            master = Master(uri, names)
            wait_until(lambda: nodes[0].process.poll() is not None, "the monitor's end")
            assert nodes[0].process.returncode == 1, nodes[0].process.returncode
            assert SAID in nodes[0].output() and re.search("FATAL", nodes[0].output()), \
                nodes[0].output()
            wait_until(lambda: SAID in nodes[1].output(), "the nodelet's words")
            assert nodes[1].process.poll() is None, "a nodelet must not end its manager"
            nodes.append(Node(["sh", "-c", source + DEVEL +
                               "/lib/deformable_contact_monitor/contact_monitor"], environment))
            wait_until(lambda: master.knows("/contact_monitor/contacts"), "the one after it")
        finally:
            for node in nodes:
                node.stop()
            master.kill()


if __name__ == "__main__":
    main()
