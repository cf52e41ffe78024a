"""Shared by the rostests: logs of the monitor's output, meshes and transforms to send, and the
oracle's contacts. Every wait has a time limit."""
import io
import os
import struct
import subprocess
import tempfile
import threading
import time
import xmlrpc.client

import numpy as np
import rosgraph
import rospy
import roslib.packages
import tf2_py
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from deformable_contact_monitor.msg import (
    ContactArray, ContactEvent, ContactState, ContactStates, DeformableMesh, LinkMeshes)
from pose_meshes import merged, posed, write_ply

PACKAGE = "deformable_contact_monitor"
WAIT_S = 100  # of wall time; far longer than anything takes, also on a busy machine


def executable(name, package=PACKAGE):
    """Path of one of this build's executables, or of another package's."""
    return roslib.packages.find_node(package, name)[0]


def wait_until(condition, what):
    """Polls the condition. For what no message announces."""
    deadline = time.monotonic() + WAIT_S
    while not condition():
        if time.monotonic() > deadline:
            raise AssertionError(f"waited {WAIT_S} s in vain for {what}")
        time.sleep(0.01)


class Log:
    """Keeps all messages of a topic since it subscribed."""

    def __init__(self, topic, message_type):
        self.topic = topic
        self.messages = []
        self.condition = threading.Condition()
        self.subscriber = rospy.Subscriber(topic, message_type, self._store, tcp_nodelay=True)
        wait_until(lambda: self.subscriber.get_num_connections() > 0, f"a publisher of {topic}")

    def _store(self, message):
        with self.condition:
            self.messages.append(message)
            self.condition.notify_all()

    def count(self):
        with self.condition:
            return len(self.messages)

    def wait(self, what, wanted=lambda message: True, since=0):
        """Returns the first wanted message from number `since` on; waits for it if need be."""
        deadline = time.monotonic() + WAIT_S
        with self.condition:
            while True:
                for message in self.messages[since:]:
                    if wanted(message):
                        return message
                left = deadline - time.monotonic()
                if left <= 0:
                    raise AssertionError(f"waited {WAIT_S} s in vain for {what} on {self.topic}, "
                                         f"{len(self.messages) - since} messages came")
                self.condition.wait(left)


class Monitor:
    """Logs the output of the monitor with that name."""

    def __init__(self, name="/contact_monitor"):
        self.name = name
        self.contacts = Log(name + "/contacts", ContactArray)
        self.states = Log(name + "/contact_states", ContactStates)
        self.events = Log(name + "/contact_events", ContactEvent)

    def contacts_at(self, stamp):
        """Those of an object's cycle, or of a heartbeat; not those of the robot's own cycle, which
        may have that stamp, too."""
        def is_of_object(message):
            return not any(message.triggered) or any(
                on and kind == message.DEFORMABLE
                for on, kind in zip(message.triggered, message.body_kind))
        contacts = self.contacts.wait(
            f"contacts at {stamp}", lambda m: m.header.stamp == stamp and is_of_object(m))
        if "DCM_REQUIRE_CUDA" in os.environ and contacts.backend != "cuda":
            raise AssertionError(f"these contacts were found by {contacts.backend}")
        return contacts

    def states_of(self, contacts):
        """{(body_a, body_b): ContactState} of the cycle of these contacts."""
        # The monitor's own beats may have that stamp, too.
        message = self.states.wait(
            f"states of cycle {contacts.cycle}", lambda m: m.cycle == contacts.cycle
            and m.header.stamp == contacts.header.stamp)
        return {(s.body_a, s.body_b): s for s in message.states}

    def states_at(self, stamp):
        """{(body_a, body_b): state} of the cycle at that stamp."""
        states = self.states_of(self.contacts_at(stamp))
        return {pair: state.state for pair, state in states.items()}

    def robot_meshes(self, log):
        """{link: mesh} of the newest message of `log`, a Log of ~robot_meshes."""
        log.wait("robot meshes")
        return {mesh.link: to_mesh(mesh.vertices, mesh.triangles)
                for mesh in log.messages[-1].meshes}

    def robot_meshes_log(self):
        return Log(self.name + "/robot_meshes", LinkMeshes)


def transform_message(stamp, edges):
    """edges: {child: (parent, (translation, quaternion))}."""
    message = TFMessage()
    for child, (parent, (translation, quaternion)) in edges.items():
        transform = TransformStamped()
        transform.header.stamp = stamp
        transform.header.frame_id = parent
        transform.child_frame_id = child
        t, r = transform.transform.translation, transform.transform.rotation
        t.x, t.y, t.z = (float(value) for value in translation)
        r.x, r.y, r.z, r.w = (float(value) for value in quaternion)
        message.transforms.append(transform)
    return message


def mesh_message(name, stamp, frame, mesh, topology_id=1, keyframe=True):
    """A DeformableMesh; its triangles are left out if it is no keyframe."""
    message = DeformableMesh()
    message.header.stamp = stamp
    message.header.frame_id = frame
    message.object = name
    message.topology_id = topology_id
    message.vertices = mesh[0].flatten().tolist()
    message.triangles = mesh[1].flatten().tolist() if keyframe else []
    return message


class Transforms:
    """Publishes transforms, and computes poses from them by tf2, as the monitor must."""

    def __init__(self, listeners=1):
        self.buffer = tf2_py.BufferCore(rospy.Duration(1000))
        self.publisher = rospy.Publisher("/tf", TFMessage, queue_size=100)
        wait_until(lambda: self.publisher.get_num_connections() >= listeners, "listeners of /tf")

    def send(self, stamp, edges):
        message = transform_message(stamp, edges)
        for transform in message.transforms:
            self.buffer.set_transform(transform, "test")
        self.publisher.publish(message)

    def pose(self, reference_frame, frame, stamp):
        return pose_from(self.buffer, reference_frame, frame, stamp)


def pose_from(buffer, reference_frame, frame, stamp):
    """(translation, quaternion) of the frame; None if it is the reference frame."""
    if frame == reference_frame:
        return None
    transform = buffer.lookup_transform_core(reference_frame, frame, stamp).transform
    t, r = transform.translation, transform.rotation
    return (t.x, t.y, t.z), (r.x, r.y, r.z, r.w)


class MeshPublisher:
    """One deformable object."""

    def __init__(self, name, topic, listeners=1):
        self.name = name
        self.publisher = rospy.Publisher(topic, DeformableMesh, queue_size=10)
        wait_until(lambda: self.publisher.get_num_connections() >= listeners,
                   f"{listeners} subscriber(s) of {topic}")

    def send(self, stamp, frame, mesh, **arguments):
        self.publisher.publish(mesh_message(self.name, stamp, frame, mesh, **arguments))


def raw_message(message_type, data):
    """A message of that type that is sent as these bytes."""
    class Raw(message_type):
        def serialize(self, buff):
            buff.write(data)
    return Raw()


def with_length(message, length, claim):
    """The message, sent with the last length of that value changed to what it claims to be."""
    whole = io.BytesIO()
    message.serialize(whole)
    data = bytearray(whole.getvalue())
    struct.pack_into("<I", data, data.rindex(struct.pack("<I", length)), claim)
    return raw_message(type(message), bytes(data))


def peak_memory_mib(node):
    """Returns the peak memory [MiB] of the process of that node."""
    api = xmlrpc.client.ServerProxy(rosgraph.Master("/test").lookupNode(node))
    pid = api.getPid("/test")[2]
    with open(f"/proc/{pid}/status") as status:
        line = next(line for line in status if line.startswith("VmHWM:"))
    return int(line.split()[1]) / 1024


def to_mesh(vertices, triangles):
    return (np.array(vertices, np.float32).reshape(-1, 3),
            np.array(triangles, np.uint32).reshape(-1, 3))


def grid(cells, size_m, height_m=0.0):
    """A square cloth of cells x cells x 2 triangles around the origin, a little wavy."""
    steps = np.linspace(-size_m / 2, size_m / 2, cells + 1)
    x, y = (axis.flatten() for axis in np.meshgrid(steps, steps, indexing="ij"))
    z = height_m + 0.02 * size_m * np.sin(40 * x + 3) * np.cos(31 * y)
    triangles = []
    for i in range(cells):
        for j in range(cells):
            a = i * (cells + 1) + j
            b, c, d = a + 1, a + cells + 1, a + cells + 2
            triangles += [(a, b, c), (b, d, c)]
    return np.stack([x, y, z], axis=1).astype(np.float32), np.array(triangles, np.uint32)


def now(after=None):
    """Returns the current time, or the next millisecond after `after` if that is later."""
    stamp = rospy.Time.now()
    return stamp if after is None or stamp > after else after + rospy.Duration(0, 1000000)


def wait_for_transforms(send):
    """Repeats send(), which sends a mesh and returns its contacts, until no link lacks a transform.
    For transforms that are sent once."""
    wait_until(lambda: not send().skipped, "transforms of all links")


def until_frames_are_seen(cycle):
    """Repeats cycle(), which sends transforms and a mesh and returns contacts, until all frames are
    known: the monitor does not wait for transforms of a frame that it never saw."""
    wait_until(lambda: not any("never seen" in text for text in cycle().skipped),
               "transforms of all frames")


def pairs_of(contacts):
    """Returns {(body, triangle, body, triangle)}. Fails if a pair is there twice."""
    pairs = [(contacts.bodies[p.body_a], p.triangle_a, contacts.bodies[p.body_b], p.triangle_b)
             for p in contacts.pairs]
    if len(set(pairs)) != len(pairs) or contacts.pair_count != len(pairs):
        raise AssertionError("a pair was sent twice, or pair_count is wrong")
    return set(pairs)


def oracle_pairs(links, name, mesh):
    """Returns what pairs_of() must be for {link: posed mesh} and the object's posed mesh."""
    return oracle_pairs_between(links, {name: mesh})


def oracle_pairs_between(first, second):
    """Returns what pairs_of() must be for the bodies of two {name: posed mesh}."""
    merged_bodies = [merged(list(bodies.values())) for bodies in (first, second)]
    with tempfile.TemporaryDirectory() as folder:
        files = [os.path.join(folder, file) for file in ("first.ply", "second.ply")]
        for file, (mesh, _) in zip(files, merged_bodies):
            write_ply(file, mesh)
        lines = subprocess.run([executable("oracle_pairs")] + files, check=True, timeout=WAIT_S,
                               stdout=subprocess.PIPE, universal_newlines=True).stdout.splitlines()
    pairs = set()
    for line in lines:
        pair = ()
        for bodies, (_, origins), word in zip((first, second), merged_bodies, line.split()[1::2]):
            body, triangle = origins[int(word)]
            pair += (list(bodies)[body], triangle)
        pairs.add(pair)
    return pairs


def touching(pairs):
    """The links in pairs."""
    return {pair[0] for pair in pairs}


def posed_links(meshes, pose_of):
    return {link: posed(mesh, pose_of(link)) for link, mesh in meshes.items()}
