"""Publishes meshes of simulators that live in Python: messages.publish_mesh()."""
import importlib
import threading
import time
import zlib

import numpy

_RESEND_S = 1.0  # triangles are sent again after so long, for a subscriber that missed them
_publishers = {}  # by topic
_lock = threading.Lock()  # guards _publishers and what they hold


def publish_mesh(topic, vertices, triangles, frame="base_link", name="", stamp=None):
    """Publishes one state of a deforming mesh as DeformableMesh. Call it for each state, after
    rospy.init_node(); the first call advertises the topic.

    vertices: (n, 3) numbers [m], rounded to float32. NaN and infinity hide a vertex.
    triangles: (m, 3) whole numbers, each below n; m > 0.
    frame: TF frame of the vertices.
    name: of the object in the monitor's parameters; "" fits any.
    stamp: rospy.Time of the state; None: now.

    Triangles go with a message only where a subscriber may not know them: in the first messages,
    when they or the number of vertices change, when somebody subscribes, and once a second. The
    last message is latched. The arrays are copied.

    Raises ValueError, before anything is sent, if an argument is not as it must be, and
    rospy.ROSException if there is no node. Any thread may call it.
    """
    rospy = importlib.import_module("rospy")
    messages = importlib.import_module("deformable_contact.messages")
    vertices, triangles = checked_mesh(vertices, triangles)
    if not isinstance(frame, str) or not frame or frame.startswith("/"):
        raise ValueError("frame is %r, must be a TF frame without leading '/'" % (frame,))
    if not isinstance(topic, str) or not topic:
        raise ValueError("topic is %r, must be a name" % (topic,))
    if not isinstance(name, str):
        raise ValueError("name is %r, must be a text" % (name,))
    # Stamps of received messages are of the base class.
    if stamp is not None and not isinstance(stamp, importlib.import_module("genpy").Time):
        raise ValueError("stamp is %r, must be a rospy.Time" % (stamp,))
    message = messages.DeformableMesh(object=name, vertices=vertices)
    message.header.frame_id = frame
    message.header.stamp = rospy.Time.now() if stamp is None else stamp
    topic = rospy.resolve_name(topic)
    with _lock:
        if topic not in _publishers:
            _publishers[topic] = (Topology(), rospy.Publisher(
                topic, messages.DeformableMesh, queue_size=1, latch=True, tcp_nodelay=True))
        topology, publisher = _publishers[topic]
        message.triangles = topology.to_send(triangles, len(vertices),
                                             publisher.get_num_connections(), time.monotonic())
        message.topology_id = topology.number
        publisher.publish(message)


def checked_mesh(vertices, triangles):
    """Returns copies as (n, 3) float32 and (m, 3) uint32. Raises ValueError with a clear text."""
    vertices, triangles = numpy.asarray(vertices), numpy.asarray(triangles)
    for what, array, kinds, must in (("vertices", vertices, "iuf", "real numbers"),
                                     ("triangles", triangles, "iu", "whole numbers")):
        if array.ndim != 2 or array.shape[1] != 3:
            raise ValueError("%s has shape %s, must be (n, 3)" % (what, array.shape))
        if array.dtype.kind not in kinds:
            raise ValueError("%s is of %s, must be %s" % (what, array.dtype, must))
        if len(array) == 0:
            raise ValueError("%s is empty" % what)
    bad = ((triangles < 0) | (triangles >= len(vertices))).any(axis=1)
    if bad.any():
        first = int(bad.argmax())
        raise ValueError("triangle %d uses the vertices %s, but there are %d" % (
            first, triangles[first].tolist(), len(vertices)))
    with numpy.errstate(over="ignore"):
        return numpy.array(vertices, numpy.float32, order="C"), numpy.array(
            triangles, numpy.uint32, order="C")


class Topology:
    """The triangles of one topic, and whether its subscribers know them."""

    def __init__(self):
        self.number = 0
        """The topology_id. Equal triangles have equal numbers, also after a restart."""
        self._known = None  # what was sent last: triangles, number of vertices, connections
        self._sent_s = 0.0

    def to_send(self, triangles, vertex_count, connections, now_s):
        """Returns the triangles, or none if every subscriber knows them. `now_s` may count from
        any time [s]."""
        is_new = self._known is None or self._known[1] != vertex_count or \
            not numpy.array_equal(self._known[0], triangles)
        if is_new:
            number = zlib.crc32(triangles.tobytes(), vertex_count & 0xFFFFFFFF)
            self.number = number if number != self.number else (number + 1) & 0xFFFFFFFF
        if not is_new and 0 < connections <= self._known[2] and now_s - self._sent_s < _RESEND_S:
            self._known = self._known[:2] + (connections,)
            return triangles[:0]
        self._known = triangles, vertex_count, connections
        self._sent_s = now_s
        return triangles
