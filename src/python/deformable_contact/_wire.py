"""Reads and writes the fields of serialized ROS messages as numpy arrays and Python types.

This is the only Python code of this package that knows ROS's wire format: little-endian numbers,
and a uint32 length before each string and array. Arrays of numbers are not copied.

A codec reads a field, codec.read(buffer, at) -> (value, end), and writes one, codec.write(value,
out). Both raise ValueError or struct.error if the bytes or the value do not fit."""
import io
import struct

import numpy

# The wire format of ContactGeometry.
GEOMETRY = numpy.dtype([("point_a", "<f4", (3,)), ("point_b", "<f4", (3,)),
                        ("normal", "<f4", (3,)), ("separation", "<f4"), ("flags", "u1")])
# A row of ContactStates.states.
STATE = numpy.dtype([
    ("stamp", [("secs", "<u4"), ("nsecs", "<u4")]), ("body_a", object), ("body_b", object),
    ("state", "u1"), ("reason", object), ("inside", "u1"), ("pair_count", "<u4"),
    ("min_separation", "<f4"), ("distance_low", "<f4"), ("point_a", "<f4", (3,)),
    ("point_b", "<f4", (3,)), ("normal", "<f4", (3,)), ("centroid", "<f4", (3,)),
    ("mean_normal", "<f4", (3,)), ("since", [("secs", "<i4"), ("nsecs", "<i4")])])


_NUMBERS = {"bool": "?", "int8": "b", "uint8": "B", "byte": "b", "char": "B", "int16": "h",
            "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
            "float32": "f", "float64": "d"}
_LENGTH = struct.Struct("<I")


def is_number(kind):
    """Returns True if the ROS type is a single number."""
    return kind in _NUMBERS


class Number:
    """A number of a ROS type."""

    def __init__(self, kind):
        self._format = struct.Struct("<" + _NUMBERS[kind])

    def read(self, buffer, at):
        return self._format.unpack_from(buffer, at)[0], at + self._format.size

    def write(self, value, out):
        out.write(self._format.pack(value))


class Time:
    """A genpy.Time of two uint32, or a genpy.Duration of two int32."""

    def __init__(self, cls, kind):
        self._cls = cls
        self._format = struct.Struct("<2" + _NUMBERS[kind])

    def read(self, buffer, at):
        return self._cls(*self._format.unpack_from(buffer, at)), at + self._format.size

    def write(self, value, out):
        out.write(self._format.pack(value.secs, value.nsecs))


class String:
    """A str. Bytes that are not UTF-8 are replaced, as the generated classes do."""

    @staticmethod
    def read(buffer, at):
        begin, end = _span(buffer, at, 1)
        return bytes(buffer[begin:end]).decode("utf-8", "rosmsg"), end

    @staticmethod
    def write(value, out):
        text = value.encode("utf-8") if isinstance(value, str) else value
        out.write(_LENGTH.pack(len(text)))
        out.write(text)


class List:
    """A list of elements without a fixed size."""

    def __init__(self, element):
        self._element = element

    def read(self, buffer, at):
        (count,) = _LENGTH.unpack_from(buffer, at)
        at += _LENGTH.size
        values = []
        for _ in range(count):
            value, at = self._element.read(buffer, at)
            values.append(value)
        return values, at

    def write(self, values, out):
        out.write(_LENGTH.pack(len(values)))
        for value in values:
            self._element.write(value, out)


class Array:
    """An array of numbers, in rows of one shape."""

    def __init__(self, dtype, row=(), counts_rows=False):
        self._dtype = numpy.dtype(dtype)
        self._row = row
        self._row_size = int(numpy.prod(row, dtype=int))
        # The length on the wire counts rows (an array of messages) or numbers.
        self._counted = self._row_size if counts_rows else 1

    @classmethod
    def of(cls, kind, row):
        """Returns a codec for numbers of a ROS type."""
        return cls("<" + _NUMBERS[kind], row)

    def read(self, buffer, at):
        begin, end = _span(buffer, at, self._counted * self._dtype.itemsize)
        if begin == end:
            return self.empty(), end
        count = (end - begin) // self._dtype.itemsize
        values = numpy.frombuffer(buffer, self._dtype, count, begin)
        if self._dtype == "?":
            values = values.view("u1") != 0
        return values.reshape((-1,) + self._row) if count % self._row_size == 0 else values, end

    def write(self, values, out):
        plain = self._plain(values)
        out.write(_LENGTH.pack(plain.size // self._counted))
        out.write(plain.reshape(-1).view("u1").data)

    def empty(self):
        return numpy.empty((0,) + self._row, self._dtype)

    def _plain(self, values):
        """Converts values to the wire's type. Raises ValueError if a value would change."""
        given = self._given(values)
        if given.shape[1:] != self._row and (given.ndim != 1 or self._counted > 1):
            raise ValueError("has shape %s, must be (n%s)" % (
                given.shape, "".join(", %d" % size for size in self._row) or ","))
        if given.dtype != self._dtype:
            is_whole = self._dtype.kind in "iu"
            if self._dtype.names or given.dtype.kind not in ("biu" if is_whole else "biuf"):
                raise ValueError("is of %s, must be of %s" % (given.dtype, self._dtype))
            if is_whole and given.size:
                limits = numpy.iinfo(self._dtype)
                if given.min() < limits.min or given.max() > limits.max:
                    raise ValueError("has a number that %s cannot hold" % self._dtype.name)
        return numpy.ascontiguousarray(given, self._dtype)

    def _given(self, values):
        if len(values) == 0:
            return self.empty()
        if isinstance(values, bytes):
            return numpy.frombuffer(values, "u1")
        if _are_messages(values):
            out = io.BytesIO()
            for value in values:
                value.serialize(out)
            return numpy.frombuffer(out.getvalue(), self._dtype).reshape((-1,) + self._row)
        return numpy.asarray(values)


class Table:
    """An array of messages with numbers and strings, as a table with a column for each field.
    Strings are columns of objects."""

    def __init__(self, dtype):
        self._dtype = dtype
        # Fields in the order of the wire: the name of a string, or the dtype of adjacent numbers.
        self._runs = []
        numbers = []
        for name in dtype.names:
            if dtype[name] != object:
                numbers.append((name, dtype[name]))
                continue
            if numbers:
                self._runs.append(numpy.dtype(numbers))
            self._runs.append(name)
            numbers = []
        if numbers:
            self._runs.append(numpy.dtype(numbers))

    def read(self, buffer, at):
        (count,) = _LENGTH.unpack_from(buffer, at)
        at += _LENGTH.size
        columns = [[] for _ in self._runs]
        for _ in range(count):
            for run, column in zip(self._runs, columns):
                if isinstance(run, str):
                    value, at = String.read(buffer, at)
                    column.append(value)
                else:
                    column.append(buffer[at:at + run.itemsize])
                    at += run.itemsize
            if at > len(buffer):
                raise ValueError("%d rows are announced, but the message ends" % count)
        table = numpy.empty(count, self._dtype)
        for run, column in zip(self._runs, columns):
            if isinstance(run, str):
                table[run] = column
            else:
                rows = numpy.frombuffer(b"".join(column), run)
                for name in run.names:
                    table[name] = rows[name]
        return table, at

    def write(self, values, out):
        out.write(_LENGTH.pack(len(values)))
        if _are_messages(values):
            for value in values:
                value.serialize(out)
            return
        table = numpy.asarray(values if len(values) else self.empty())
        if table.dtype != self._dtype or table.ndim != 1:
            raise ValueError("is of %s, must be rows of %s" % (table.dtype, self._dtype))
        columns = [table[run] if isinstance(run, str) else self._packed(table, run)
                   for run in self._runs]
        for row in zip(*columns):
            for run, value in zip(self._runs, row):
                if isinstance(run, str):
                    String.write(value, out)
                else:
                    out.write(value)

    def empty(self):
        return numpy.empty(0, self._dtype)

    @staticmethod
    def _packed(table, run):
        rows = numpy.empty(len(table), run)
        for name in run.names:
            rows[name] = table[name]
        data = rows.tobytes()
        return [data[at:at + run.itemsize] for at in range(0, len(data), run.itemsize)]


def _are_messages(values):
    return isinstance(values, (list, tuple)) and len(values) > 0 and hasattr(values[0], "serialize")


def _span(buffer, at, size):
    """Returns the begin and the end of an array of elements of `size` bytes, whose length is at
    `at`. Raises ValueError if the buffer is shorter."""
    (count,) = _LENGTH.unpack_from(buffer, at)
    begin = at + _LENGTH.size
    end = begin + count * size
    if end > len(buffer):
        raise ValueError("%d bytes are announced, but %d are left" % (end - begin,
                                                                       len(buffer) - begin))
    return begin, end
