"""deformable_contact_monitor's ROS messages with numpy arrays in place of lists.

ContactArray, ContactStates, DeformableMesh, LinkMesh and LinkMeshes are the generated message
classes, of the same wire format and MD5 sum, for rospy.Subscriber and rospy.Publisher and for what
rosbag reads raw (message.deserialize(buffer)). Of their fields,

    float32[] vertices          is (n, 3) float32 [m], as Scene takes it
    uint32[] triangles          is (m, 3) uint32, as Scene takes it
    ContactPair[] pairs         is (k, 4) uint32, in the columns of Result.pairs
    ContactGeometry[] geometry  is (k,) of GEOMETRY: point_a, point_b, normal, separation, flags
    ContactState[] states       is (s,) of STATE: ContactState's fields, points as (3,), strings as
                                objects, stamp and since as secs and nsecs

other arrays of numbers are of shape (n,), and all else is as in the generated class. Arrays that
were received are read-only and share the message's bytes: nothing is copied (states and bool[]
are). Before it is sent a field may be any array or list that fits, also a list of generated
messages; what would not survive its type is refused with a genpy.SerializationError that names the
field. A vertices or triangles field that is no multiple of three long arrives as (n,).

publish_mesh() publishes arrays as DeformableMesh in one call.

ROS is imported at the first use of a class, the detector never.
"""
import importlib
import io
import struct

import numpy

from deformable_contact import _wire
from deformable_contact._publishing import publish_mesh
from deformable_contact._wire import GEOMETRY, STATE

__all__ = ["ContactArray", "ContactStates", "DeformableMesh", "GEOMETRY", "LinkMesh", "LinkMeshes",
           "STATE", "publish_mesh"]

_PACKAGE = "deformable_contact_monitor"
# Codecs for arrays of these messages.
_TABLES = {"ContactPair": _wire.Array("<u4", (4,), counts_rows=True),
           "ContactGeometry": _wire.Array(GEOMETRY, counts_rows=True),
           "ContactState": _wire.Table(STATE)}
# Names of arrays with rows of three numbers.
_TRIPLES = ("vertices", "triangles")


class _Message:
    """A message within another."""

    def __init__(self, cls):
        self._cls = cls
        self._fields = _fields(cls)

    def read(self, buffer, at):
        message = self._cls.__new__(self._cls)
        return message, _read_fields(self._fields, message, buffer, at)

    def write(self, message, out):
        _write_fields(self._fields, message, out)


def _codec(name, kind):
    """Returns the codec of a field, by its name and ROS type."""
    genpy = importlib.import_module("genpy")
    package, _, message = kind.rpartition("/")
    if kind.endswith("[]"):
        if package == _PACKAGE and message[:-2] in _TABLES:
            return _TABLES[message[:-2]]
        if _wire.is_number(kind[:-2]):
            return _wire.Array.of(kind[:-2], (3,) if name in _TRIPLES else ())
        return _wire.List(_codec(name, kind[:-2]))
    if _wire.is_number(kind):
        return _wire.Number(kind)
    if kind == "string":
        return _wire.String
    if kind == "time":
        return _wire.Time(genpy.Time, "uint32")
    if kind == "duration":
        return _wire.Time(genpy.Duration, "int32")
    if package == _PACKAGE:
        return _Message(_message_class(message))
    return _Message(getattr(importlib.import_module(package + ".msg"), message))


def _fields(cls):
    return [(name, _codec(name, kind)) for name, kind in zip(cls.__slots__, cls._slot_types)]


def _read_fields(fields, message, buffer, at):
    for name, codec in fields:
        value, at = codec.read(buffer, at)
        setattr(message, name, value)
    return at


def _write_fields(fields, message, out):
    for name, codec in fields:
        try:
            codec.write(getattr(message, name), out)
        except (AttributeError, TypeError, ValueError, struct.error) as error:
            genpy = importlib.import_module("genpy")
            raise genpy.SerializationError("%s.%s %s" % (message._type, name, error)) from error


def _equal(a, b):
    if isinstance(a, numpy.ndarray) or isinstance(b, numpy.ndarray):
        return numpy.array_equal(a, b)
    return a == b


def _message_class(name):
    """Derives a class from the generated one, with methods that keep arrays."""
    if name in globals():
        return globals()[name]
    genpy = importlib.import_module("genpy")
    base = getattr(importlib.import_module(_PACKAGE + ".msg"), name)
    fields = _fields(base)
    arrays = [(field, codec) for field, codec in fields if hasattr(codec, "empty")]

    def __init__(self, *args, **kwds):
        base.__init__(self, *args, **kwds)
        for field, codec in arrays:
            if len(getattr(self, field)) == 0:
                setattr(self, field, codec.empty())

    def serialize(self, buff):
        """Writes all or nothing."""
        whole = io.BytesIO()
        try:
            _write_fields(fields, self, whole)
        except genpy.SerializationError:
            # rospy has left room for the length, and would send it before its next message.
            if isinstance(buff, io.BytesIO) and buff.tell() > len(buff.getbuffer()):
                buff.seek(0, io.SEEK_END)
            raise
        buff.write(whole.getbuffer())

    def deserialize(self, buffer):
        try:
            _read_fields(fields, self, buffer, 0)
        except (ValueError, struct.error) as error:
            raise genpy.DeserializationError("%s: %s" % (self._type, error)) from error
        return self

    def __eq__(self, other):
        return isinstance(other, base) and all(
            _equal(getattr(self, slot), getattr(other, slot)) for slot in self.__slots__)

    cls = type(name, (base,), {
        "__doc__": base._type + ", with numpy arrays.", "__module__": __name__,
        "__slots__": base.__slots__, "__init__": __init__, "serialize": serialize,
        "deserialize": deserialize, "__eq__": __eq__, "__hash__": None})
    globals()[name] = cls
    return cls


def __getattr__(name):
    if name not in __all__:
        raise AttributeError("module %r has no attribute %r" % (__name__, name))
    return _message_class(name)


def __dir__():
    return sorted(set(globals()) | set(__all__))
