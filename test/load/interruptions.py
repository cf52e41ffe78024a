"""Sends SIGINT at random moments of a monitor's life. It must end soon, with exit code 0."""
import collections
import math
import os
import random
import signal
import threading
import time

from deaf_subscriber import DeafSubscriber
from load_support import NAME, Session, robot, scene, wait_until

LINKS = 2
# From the start of the process [s], and with what: `slow`: a robot whose file takes long to read;
# `dense`: meshes whose cycles last until max_cycle_s; `calls`: of services, all the time; `deaf`:
# subscribers that read nothing; `master`: a signal that it gets first, None: none.
Moment = collections.namedtuple("Moment", "after_s slow dense calls deaf master")
MOMENTS = {
    "start": Moment((0.0, 0.5), False, False, False, False, None),
    "robot": Moment((0.1, 2.0), True, False, False, False, None),
    "mesh": Moment((0.2, 1.0), False, False, False, False, None),
    "dense": Moment((0.5, 3.0), False, True, False, False, None),
    "service": Moment((0.3, 2.0), False, False, True, False, None),
    "reload": Moment((0.5, 4.0), True, True, True, False, None),
    "deaf": Moment((0.8, 2.0), False, True, False, True, None),
    "dead_master": Moment((0.2, 2.0), False, True, False, False, signal.SIGKILL),
    "hung_master": Moment((0.2, 2.0), False, True, False, False, signal.SIGSTOP),
}


def write_slow_robot(folder):
    """URDF of a robot with a link of half a million triangles as text, which takes long to read."""
    path = os.path.join(folder, "slow.obj")
    n = 500
    with open(path, "w") as file:
        for i in range(n * n):
            file.write(f"v {i // n / n:.6f} {i % n / n:.6f} {0.1 * math.sin(i):.6f}\n")
        for i in range(n * n - n - 1):
            file.write(f"f {i + 1} {i + 2} {i + n + 1}\nf {i + 2} {i + n + 2} {i + n + 1}\n")
    mesh = f'<collision><geometry><mesh filename="file://{path}"/></geometry></collision>'
    return robot(LINKS).replace("</robot>", f'<link name="slow">{mesh}</link><joint name="slow" '
                                'type="fixed"><parent link="base"/><child link="slow"/></joint>'
                                "</robot>")


def write_dense_mesh(folder, triangles=10000):
    """Triangles through one another around one point: fifty million pairs of them meet."""
    path = os.path.join(folder, "dense.off")
    generator = random.Random(1)
    with open(path, "w") as file:
        file.write(f"OFF\n{3 * triangles} {triangles} 0\n")
        for _ in range(triangles):
            a, b = ([generator.gauss(0, 0.3) for _ in range(3)] for _ in range(2))
            c = [generator.gauss(0, 0.02) - x - y for x, y in zip(a, b)]
            for corner in (a, b, c):
                file.write("{:.6f} {:.6f} {:.6f}\n".format(*corner))
        for n in range(triangles):
            file.write(f"3 {3 * n} {3 * n + 1} {3 * n + 2}\n")
    return path


def catches_sigint(pid):
    """False before roscpp has begun: then SIGINT ends a process as it does any other."""
    with open(f"/proc/{pid}/status") as status:
        caught = next(line for line in status if line.startswith("SigCgt:")).split()[1]
    return bool(int(caught, 16) >> (signal.SIGINT - 1) & 1)


def programs_running(path, folder):
    """The processes of this program that were given a file of the folder."""
    found = []
    for pid in filter(str.isdigit, os.listdir("/proc")):
        try:
            with open(f"/proc/{pid}/cmdline", "rb") as file:
                program, *given = file.read().split(b"\0")
            if program == path.encode() and any(os.fsencode(folder) in name for name in given):
                found.append(int(pid))
        except OSError:
            pass
    return found


class Callers:
    """Threads that call the monitor's services, those that are there."""

    def __init__(self):
        import rospy
        from deformable_contact_monitor.srv import GetContacts
        from std_srvs.srv import SetBool, Trigger
        self.rospy = rospy
        self.wanted = threading.Event()
        services = [("get_contacts", GetContacts, ()), ("set_enabled", SetBool, (True,)),
                    ("reload_robot", Trigger, ()), ("reset", Trigger, ())]
        for service in services:
            threading.Thread(target=self._call, args=service, daemon=True).start()

    def _call(self, name, kind, arguments):
        while True:
            self.wanted.wait()
            try:
                self.rospy.ServiceProxy(f"{NAME}/{name}", kind)(*arguments)
            except (self.rospy.ServiceException, self.rospy.exceptions.ROSException, OSError):
                time.sleep(0.02)


class Interruptions:
    """Starts monitors and interrupts them; `found` holds what breaks the promise."""

    def __init__(self, session, within_s):
        self.session = session
        self.within_s = within_s
        self.reader = session.executable("read_link_mesh")
        self.robots = {False: robot(LINKS), True: write_slow_robot(session.home.name)}
        self.callers = Callers()
        self.dense_mesh = write_dense_mesh(session.home.name)
        self._start_load()
        self.times_s = collections.defaultdict(list)
        self.uncaught = collections.Counter()
        self.found = []

    def _start_load(self):
        self.load = [
            self.session.client(unwatched=True, objects=1, links=LINKS, rate=30),
            self.session.client(unwatched=True, objects=1, first=1, rate=2, mesh=self.dense_mesh)]

    def _start_master_again(self):
        """With the load, which it does not know any more."""
        for process in self.load + [self.session.master]:
            process.kill()
            self.session.processes.remove(process)
        self.session.start_master()
        self._start_load()

    def interrupt_at(self, name, after_s):
        moment = MOMENTS[name]
        api = self.session.api
        api.setParam("/test", "/robot_description", self.robots[moment.slow])
        classes = ["robot_deformable"] + (["deformable_self"] if moment.dense else [])
        api.setParam("/test", NAME + "/pair_classes", classes)
        (self.callers.wanted.set if moment.calls else self.callers.wanted.clear)()
        monitor = self.session.monitor(wait=False)
        start = time.monotonic()
        deaf = self._connect_deaf(monitor) if moment.deaf else []
        time.sleep(max(0, start + after_s - time.monotonic()))
        if moment.master is not None:
            self.session.master.process.send_signal(moment.master)
        caught = monitor.runs() and catches_sigint(monitor.pid)
        runs = monitor.runs()
        seconds, code = monitor.interrupt()
        self.callers.wanted.clear()
        for one in deaf:
            one.close()
        for client in self.load:
            if not client.runs():
                raise AssertionError("the load ended: " + client.output())
        self._judge(f"{name} after {after_s:.3f} s", caught, runs, seconds, code, monitor)
        self.times_s[name].append(seconds)
        self.uncaught[name] += not caught
        self.session.processes.remove(monitor)
        if moment.master is not None:
            self._start_master_again()

    def _connect_deaf(self, monitor):
        from deformable_contact_monitor.msg import ContactArray, ContactStates
        wait_until(lambda: self.session.knows(NAME + "/reload_robot", 2) or not monitor.runs(),
                   "the monitor")
        api = self.session.node_api()
        return [DeafSubscriber(api, f"{NAME}/{topic}", kind, f"/deaf_{i}") for i in range(2)
                for topic, kind in (("contacts", ContactArray), ("contact_states", ContactStates))]

    def _judge(self, what, caught, runs, seconds, code, monitor):
        if not runs:
            self.found.append(f"{what}: it had ended by itself: {monitor.output()[-1000:]}")
        elif code != 0 and (caught or code != -signal.SIGINT):
            self.found.append(f"{what}: exit code {code}: {monitor.output()[-1000:]}")
        if seconds > self.within_s:
            self.found.append(f"{what}: out after {seconds:.2f} s")
        ends = time.monotonic() + self.within_s
        while self._readers() and time.monotonic() < ends:
            time.sleep(0.02)
        left = self._readers()
        if left:
            self.found.append(f"{what}: its reader of link files lives on: {left}")

    def _readers(self):
        """Of the slow robot, the only one with a file; other tests have readers, too."""
        return programs_running(self.reader, self.session.home.name)

    def describe(self):
        lines = ["moment       times  before roscpp catches it  out after: mean, most [s]"]
        for name, times_s in self.times_s.items():
            lines.append(f"{name:12} {len(times_s):5}  {self.uncaught[name]:24}  "
                         f"{sum(times_s) / len(times_s):.3f}, {max(times_s):.3f}")
        return "\n".join(lines)


def run_interruptions(times, within_s, seed, devel=None, say=print, moments=tuple(MOMENTS)):
    """What broke the promise; says what was done."""
    generator = random.Random(seed)
    with Session(devel, scene(LINKS, 2, backend="cpu")) as session:
        import rospy
        rospy.init_node("interrupt", anonymous=True, disable_signals=True)
        work = Interruptions(session, within_s)
        said = 0
        for n in range(times):
            name = moments[n % len(moments)]
            work.interrupt_at(name, generator.uniform(*MOMENTS[name].after_s))
            for problem in work.found[said:]:
                say("BROKEN: " + problem)
            said = len(work.found)
            if (n + 1) % 20 == 0:
                say(f"{n + 1} of {times}, {len(work.found)} bad")
        say(work.describe())
        return work.found
