"""Starts a ROS master, monitors and load clients, separate from whatever else runs on the machine,
and ends them. Needs a devel space, Python and ROS, but no launch files."""
import json
import os
import re
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import time
import xmlrpc.client

# A shell without job control starts what runs in the background with SIGINT ignored, and the
# processes that this one starts would ignore it, too.
if signal.getsignal(signal.SIGINT) == signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

WAIT_S = 40  # of wall time; far longer than anything takes, also on a busy machine
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.dirname(os.path.dirname(HERE))
NAME = "/contact_monitor"
FRAME = "base"


def default_devel():
    """The devel space of the build that runs this test, or of test/run."""
    return os.path.join(os.environ.get("DCM_BINARY_DIR", os.path.join(ROOT, "build/test")), "devel")


def wait_until(condition, what):
    deadline = time.monotonic() + WAIT_S
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {WAIT_S} s in vain for {what}")
        time.sleep(0.02)


def free_port():
    with socket.socket() as one:
        one.bind(("127.0.0.1", 0))
        return one.getsockname()[1]


def robot(links):
    """URDF of as many boxes, each on a floating joint of its own."""
    text = f'<robot name="load"><link name="{FRAME}"/>'
    for n in range(links):
        text += (f'<link name="link_{n}"><collision><geometry><box size="0.2 0.2 0.1"/></geometry>'
                 f'</collision></link><joint name="joint_{n}" type="floating">'
                 f'<parent link="{FRAME}"/><child link="link_{n}"/></joint>')
    return text + "</robot>"


def scene(links, objects, **parameters):
    """Parameters of the master's tree for a monitor."""
    names = [f"object_{n}" for n in range(objects)]
    return {"/robot_description": robot(links),
            NAME: {"reference_frame": FRAME, **parameters,
                   "objects": [{"name": name, "topic": "/" + name} for name in names]}}


class Process:
    """A process whose output is kept in a file."""

    def __init__(self, command, environment, stdout=None):
        self.log = tempfile.TemporaryFile(mode="w+")
        self.process = subprocess.Popen(command, env=environment, stdout=stdout or self.log,
                                        stderr=subprocess.STDOUT if stdout is None else self.log,
                                        universal_newlines=True)
        self.pid = self.process.pid

    def output(self):
        self.log.seek(0)
        return self.log.read()

    def runs(self):
        return self.process.poll() is None

    def interrupt(self):
        """Sends SIGINT; seconds until it has ended, and its exit code."""
        start = time.monotonic()
        if self.runs():
            self.process.send_signal(signal.SIGINT)
        try:
            self.process.wait(WAIT_S)
        except subprocess.TimeoutExpired:
            self.kill()
        return time.monotonic() - start, self.process.returncode

    def kill(self):
        if self.runs():
            self.process.kill()
        self.process.wait()


class Client(Process):
    """test/load/load_client: sends, watches, and says how it goes."""

    def __init__(self, command, environment):
        super().__init__(command, environment, subprocess.PIPE)
        self.lines = []
        self._reader = threading.Thread(target=self._read, daemon=True)
        self._reader.start()

    def _read(self):
        for line in self.process.stdout:
            self.lines.append(json.loads(line))

    def finish(self):
        """Ends it; what it says of all its time."""
        self.interrupt()
        self._reader.join(WAIT_S)
        for line in self.lines:
            if line["kind"] == "summary":
                return line
        raise AssertionError(f"the load client ended without a summary: {self.output()}")


class Session:
    """A master with parameters, and what is started beside it. To be used with `with`."""

    def __init__(self, devel=None, tree=None):
        self.devel = os.path.abspath(devel or default_devel())
        self.tree = tree or {}
        self.uri = f"http://127.0.0.1:{free_port()}/"
        self.home = tempfile.TemporaryDirectory()
        paths = {"LD_LIBRARY_PATH": self.devel + "/lib",
                 "PYTHONPATH": self.devel + "/lib/python3/dist-packages",
                 "CMAKE_PREFIX_PATH": self.devel}
        if os.path.exists(os.path.join(ROOT, "package.xml")):  # it is searched, with all below it
            paths["ROS_PACKAGE_PATH"] = ROOT
        self.environment = dict(os.environ, ROS_MASTER_URI=self.uri, ROS_IP="127.0.0.1",
                                ROS_HOME=self.home.name, PYTHONUNBUFFERED="1")
        for name, path in paths.items():
            before = os.environ.get(name, "")
            self.environment[name] = path + (":" + before if before else "")
        self.environment.pop("ROS_HOSTNAME", None)
        os.environ.update(self.environment)  # for rospy and what it starts
        sys.path.insert(0, paths["PYTHONPATH"])
        self.processes = []
        self.master = None
        self.api = xmlrpc.client.ServerProxy(self.uri)

    def __enter__(self):
        signal.signal(signal.SIGTERM, lambda *_: sys.exit("ended by SIGTERM"))
        try:
            self.start_master()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for process in reversed(self.processes):
            process.kill()
        self.home.cleanup()

    def start_master(self):
        self.master = self.start(["rosmaster", "--core", "-p", re.search(r":(\d+)/", self.uri)[1]])
        wait_until(self._answers, "the master")
        for name, value in self.tree.items():
            self.api.setParam("/test", name, value)

    def _answers(self):
        try:
            return self.api.getPid("/test")[0] == 1
        except OSError:
            return False

    def start(self, command, **arguments):
        self.processes.append(Process(command, self.environment, **arguments))
        return self.processes[-1]

    def executable(self, name):
        return os.path.join(self.devel, "lib/deformable_contact_monitor", name)

    def monitor(self, wait=True, **arguments):
        """Starts one, and waits until the master knows its topics."""
        process = self.start([self.executable("contact_monitor")], **arguments)
        if wait:
            wait_until(lambda: self.knows(NAME + "/reload_robot", 2) or not process.runs(),
                       "the monitor")
            if not process.runs():
                raise AssertionError("the monitor ended: " + process.output())
        return process

    def client(self, **options):
        """Options of load_client, `first_mesh` for --first-mesh, True for a flag."""
        command = [self.executable("load_client")]
        for name, value in options.items():
            if value is not None and value is not False:
                command.append("--" + name if value is True else f"--{name}={value}")
        self.processes.append(Client(command, self.environment))
        return self.processes[-1]

    def knows(self, name, kind=0):
        """Whether the master knows a topic (kind 0: of publishers) or a service (2)."""
        return any(entry == name for entry, _ in self.api.getSystemState("/test")[2][kind])

    def node_api(self, node=NAME):
        """The node's own interface."""
        return xmlrpc.client.ServerProxy(self.api.lookupNode("/test", node)[2])
