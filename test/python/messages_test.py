#!/usr/bin/env python3
"""deformable_contact.messages against the generated classes, byte for byte."""
import ast
import io
import os
import pathlib
import pickle
import random
import struct
import tempfile
import unittest

import genpy
import numpy
import rosbag
import rospy
import rospy.msg
from deformable_contact import _publishing, messages
from deformable_contact_monitor import msg as generated
from geometry_msgs.msg import Point32

NAMES = "ContactArray", "ContactStates", "DeformableMesh", "LinkMesh", "LinkMeshes"
NUMBERS = {"bool": "?", "uint8": "B", "uint32": "I", "uint64": "Q", "float32": "f"}
STRINGS = "", "cloth", "finger_link", "T\u00fcll \u2713", "a b\n"


def random_value(kind, draw):
    """Of a ROS type, as the generated classes have it."""
    if kind.endswith("[]"):
        count = draw.choice([0, 1, 2, 3, 6, 9])
        if kind == "uint8[]":
            return bytes(draw.randrange(256) for _ in range(count))
        return [random_value(kind[:-2], draw) for _ in range(count)]
    if kind in NUMBERS:
        size = struct.calcsize(NUMBERS[kind])
        if kind == "bool":
            return bool(draw.randrange(2))
        if kind == "float32":
            return draw.choice([0.0, -0.0, 1.5, numpy.inf, -numpy.inf, numpy.nan, 2.0**-149])
        return draw.choice([0, 1, 7, 2**(8 * size - 1), 2**(8 * size) - 1])
    if kind == "string":
        return draw.choice(STRINGS)
    if kind == "time":
        return genpy.Time(draw.randrange(2**32), draw.randrange(10**9))
    if kind == "duration":
        return genpy.Duration(draw.randrange(-2**31, 2**31), draw.randrange(10**9))
    return random_message(genpy.message.get_message_class(kind), draw)


def random_message(cls, draw):
    return cls(*[random_value(kind, draw) for kind in cls._slot_types])


def to_bytes(message):
    out = io.BytesIO()
    message.serialize(out)
    return out.getvalue()


class AsTheGeneratedClasses(unittest.TestCase):

    def test_round_trips_byte_for_byte(self):
        draw = random.Random(1)
        for name in NAMES:
            cls = getattr(messages, name)
            for _ in range(60):
                original = random_message(getattr(generated, name), draw)
                data = to_bytes(original)
                read = cls().deserialize(data)
                self.assertEqual(to_bytes(read), data, name)
                # What a program builds of lists and generated messages.
                built = cls(*[getattr(original, slot) for slot in original.__slots__])
                self.assertEqual(to_bytes(built), data, name)
                self.assertEqual(to_bytes(getattr(generated, name)().deserialize(data)), data)

    def test_empty_messages(self):
        for name in NAMES:
            self.assertEqual(to_bytes(getattr(messages, name)()),
                             to_bytes(getattr(generated, name)()))
        contacts, mesh = messages.ContactArray(), messages.DeformableMesh()
        self.assertEqual((contacts.pairs.shape, contacts.pairs.dtype), ((0, 4), "u4"))
        self.assertEqual((contacts.geometry.shape, contacts.geometry.dtype),
                         ((0,), messages.GEOMETRY))
        self.assertEqual((mesh.vertices.shape, mesh.triangles.dtype), ((0, 3), "u4"))
        self.assertEqual(messages.ContactStates().states.dtype, messages.STATE)
        contacts = messages.ContactArray().deserialize(to_bytes(contacts))
        self.assertEqual(contacts.pairs.shape, (0, 4))

    def test_identities(self):
        for name in NAMES:
            cls, base = getattr(messages, name), getattr(generated, name)
            self.assertTrue(issubclass(cls, base) and issubclass(cls, genpy.Message))
            for attribute in ("_md5sum", "_type", "_full_text", "_has_header", "_slot_types",
                              "__slots__"):
                self.assertEqual(getattr(cls, attribute), getattr(base, attribute))

    def test_the_stub_has_the_fields_in_their_order(self):
        stub = ast.parse(pathlib.Path(messages.__file__).with_suffix(".pyi").read_text())
        classes = {node.name: node for node in stub.body if isinstance(node, ast.ClassDef)}
        self.assertEqual(set(classes), set(NAMES))
        for name, node in classes.items():
            fields = [line.target.id for line in node.body if isinstance(line, ast.AnnAssign)]
            self.assertEqual([field for field in fields if not field.isupper()],
                             getattr(generated, name).__slots__)


class Contents(unittest.TestCase):

    def contacts(self):
        point = Point32(1, 2, 3)
        message = generated.ContactArray(bodies=["arm", "cloth"], triggered=[False, True],
                                         body_kind=b"\0\1", topology_ids=[0, 7])
        message.pairs = [generated.ContactPair(0, 5, 1, 6), generated.ContactPair(0, 8, 1, 9)]
        message.geometry = [generated.ContactGeometry(point, point, Point32(0, 0, 1), -0.5, 4)] * 2
        return message

    def test_contacts(self):
        read = messages.ContactArray().deserialize(to_bytes(self.contacts()))
        numpy.testing.assert_array_equal(read.pairs, [[0, 5, 1, 6], [0, 8, 1, 9]])
        numpy.testing.assert_array_equal(read.geometry["point_a"], [[1, 2, 3]] * 2)
        numpy.testing.assert_array_equal(read.geometry["normal"], [[0, 0, 1]] * 2)
        self.assertEqual(read.geometry["separation"].tolist(), [-0.5, -0.5])
        self.assertEqual(read.geometry["flags"].tolist(), [4, 4])
        self.assertEqual((read.triggered.tolist(), read.triggered.dtype), ([False, True], bool))
        self.assertEqual((read.body_kind.tolist(), read.topology_ids.tolist()), ([0, 1], [0, 7]))
        self.assertEqual(read.bodies, ["arm", "cloth"])
        self.assertEqual(read.LINK, 0)
        self.assertFalse(read.pairs.flags.writeable)

    def test_states(self):
        state = generated.ContactState(
            body_a="arm", body_b="cloth", state=2, pair_count=3, min_separation=0.25,
            centroid=Point32(1, 2, 3), since=genpy.Duration(-2, 5), reason="late", inside=1)
        read = messages.ContactStates().deserialize(
            to_bytes(generated.ContactStates(states=[state, generated.ContactState()])))
        states = read.states
        self.assertEqual(states["body_b"].tolist(), ["cloth", ""])
        self.assertEqual(states["state"].tolist(), [2, 0])
        self.assertEqual(states["centroid"].tolist(), [[1, 2, 3], [0, 0, 0]])
        self.assertEqual(states["since"]["secs"].tolist(), [-2, 0])
        self.assertEqual(states[0]["reason"], "late")
        self.assertEqual([name for name in messages.STATE.names], generated.ContactState.__slots__)
        self.assertEqual(read.states[read.states["state"] == 2]["pair_count"].tolist(), [3])
        self.assertEqual(read, messages.ContactStates().deserialize(to_bytes(read)))

    def test_meshes_of_links(self):
        mesh = generated.LinkMesh("arm", "arm.stl", [0, 1, 2, 3, 4, 5], [0, 1, 0])
        read = messages.LinkMeshes().deserialize(to_bytes(generated.LinkMeshes(meshes=[mesh] * 2)))
        self.assertIsInstance(read.meshes[1], messages.LinkMesh)
        self.assertEqual(read.meshes[1].vertices.tolist(), [[0, 1, 2], [3, 4, 5]])
        self.assertEqual(read.meshes[1].triangles.tolist(), [[0, 1, 0]])

    def test_arrays_of_any_layout(self):
        vertices = numpy.arange(12, dtype=numpy.float32).reshape(4, 3)
        triangles = numpy.array([[0, 1, 2], [1, 2, 3]], numpy.uint32)
        data = to_bytes(messages.DeformableMesh(vertices=vertices, triangles=triangles))
        for v, t in ((vertices.astype("f8"), triangles.astype("i8")),
                     (numpy.asfortranarray(vertices), numpy.asfortranarray(triangles)),
                     (vertices.ravel(), triangles.ravel()), (vertices.astype(">f4"), triangles),
                     (vertices.tolist(), triangles.tolist()),
                     (numpy.repeat(vertices, 2, axis=0)[::2], triangles)):
            self.assertEqual(to_bytes(messages.DeformableMesh(vertices=v, triangles=t)), data)
        pairs = numpy.array([[0, 1, 1, 2]], "i8")
        self.assertEqual(messages.ContactArray().deserialize(
            to_bytes(messages.ContactArray(pairs=pairs))).pairs.tolist(), pairs.tolist())

    def test_coordinates_that_are_no_multiple_of_three(self):
        data = to_bytes(generated.DeformableMesh(vertices=[1, 2, 3, 4]))
        read = messages.DeformableMesh().deserialize(data)
        self.assertEqual(read.vertices.shape, (4,))
        self.assertEqual(to_bytes(read), data)

    def test_equality_and_pickles(self):
        for name in NAMES:
            message = random_message(getattr(generated, name), random.Random(3))
            read = getattr(messages, name)().deserialize(to_bytes(message))
            copy = pickle.loads(pickle.dumps(read))
            self.assertEqual(to_bytes(copy), to_bytes(read))
            self.assertIs(type(copy), type(read))
        mesh = messages.DeformableMesh(vertices=[[1, 2, 3]])
        self.assertEqual(mesh, messages.DeformableMesh(vertices=numpy.array([[1., 2, 3]])))
        self.assertNotEqual(mesh, messages.DeformableMesh(vertices=[[1, 2, 4]]))
        self.assertNotEqual(mesh, 7)


class Refusals(unittest.TestCase):

    def refused(self, text, message):
        with self.assertRaises(genpy.SerializationError) as raised:
            to_bytes(message)
        self.assertEqual(str(raised.exception), "deformable_contact_monitor/" + text)

    def test_a_refused_message_leaves_nothing_in_the_publishers_buffer(self):
        """As rospy serializes: behind room for the length, and the next message after that."""
        good, bad = messages.DeformableMesh(object="cloth"), messages.DeformableMesh(object="cloth")
        bad.vertices = numpy.zeros((4, 2), "f4")
        alone, after = io.BytesIO(), io.BytesIO()
        rospy.msg.serialize_message(alone, 0, good)
        with self.assertRaises(genpy.SerializationError):
            rospy.msg.serialize_message(after, 0, bad)
        rospy.msg.serialize_message(after, 0, good)
        self.assertEqual(after.getvalue(), alone.getvalue())

    def test_what_does_not_survive_its_type(self):
        mesh, contacts = messages.DeformableMesh, messages.ContactArray
        for index in -1, 2**32:
            self.refused("DeformableMesh.triangles has a number that uint32 cannot hold",
                         mesh(triangles=numpy.array([[0, 1, index]])))
        self.refused("DeformableMesh.triangles is of float64, must be of uint32",
                     mesh(triangles=[[0.0, 1, 2]]))
        self.refused("DeformableMesh.vertices is of complex128, must be of float32",
                     mesh(vertices=[[1j, 0, 0]]))
        self.refused("DeformableMesh.vertices has shape (1, 2), must be (n, 3)",
                     mesh(vertices=[[1.0, 2.0]]))
        self.refused("ContactArray.topology_ids has shape (1, 2), must be (n,)",
                     contacts(topology_ids=[[1, 2]]))
        for pairs, shape in ([[1, 2, 3]], "(1, 3)"), ([1, 2, 3, 4], "(4,)"):
            self.refused("ContactArray.pairs has shape %s, must be (n, 4)" % shape,
                         contacts(pairs=pairs))
        with self.assertRaisesRegex(genpy.SerializationError, "Array.geometry is of float64"):
            to_bytes(contacts(geometry=[1.0]))
        with self.assertRaisesRegex(genpy.SerializationError, "ContactStates.states is of"):
            to_bytes(messages.ContactStates(states=[1.0]))
        for field, value in ("cycle", -1), ("cycle", "x"), ("backend", 3), ("age", 3), (
                "pairs", 5), ("bodies", [3]), ("header", None):
            message = contacts()
            setattr(message, field, value)
            with self.assertRaisesRegex(genpy.SerializationError, field):
                to_bytes(message)

    def test_bytes_that_end_early_or_lie(self):
        draw = random.Random(5)
        for name in NAMES:
            data = to_bytes(random_message(getattr(generated, name), draw))
            for end in range(len(data)):
                with self.assertRaises(genpy.DeserializationError):
                    getattr(messages, name)().deserialize(data[:end])
        # Lengths that no buffer holds are neither allocated nor waited for.
        data = to_bytes(generated.DeformableMesh())
        for at, field in enumerate(("frame_id", "object", "", "vertices", "triangles")):
            at = 12 + 4 * at
            if field:
                with self.assertRaisesRegex(genpy.DeserializationError, r"\d bytes are announced"):
                    messages.DeformableMesh().deserialize(
                        data[:at] + b"\xff" * 4 + data[at + 4:])


class InRos(unittest.TestCase):

    def test_through_rospy(self):
        draw = random.Random(7)
        for name in NAMES:
            original = random_message(getattr(generated, name), draw)
            sent = getattr(messages, name)().deserialize(to_bytes(original))
            out = io.BytesIO()
            for seq in range(3):
                rospy.msg.serialize_message(out, seq, sent)
            queue = []
            rospy.msg.deserialize_messages(out, queue, getattr(messages, name))
            self.assertEqual(len(queue), 3)
            if hasattr(original, "header"):
                original.header.seq = 2
            self.assertEqual(to_bytes(queue[2]), to_bytes(original))
            # To a publisher of either class, a message of either class.
            for message in sent, original:
                for cls in getattr(messages, name), getattr(generated, name):
                    self.assertIs(rospy.msg.args_kwds_to_message(cls, (message,), {}), message)

    def test_through_a_bag(self):
        with tempfile.TemporaryDirectory() as folder:
            path = os.path.join(folder, "contacts.bag")
            pairs = numpy.arange(8, dtype=numpy.uint32).reshape(2, 4)
            with rosbag.Bag(path, "w") as bag:
                bag.write("contacts", messages.ContactArray(pairs=pairs, bodies=["a"]))
            with rosbag.Bag(path) as bag:
                for _, raw, _ in bag.read_messages(raw=True):
                    self.assertEqual(raw[2], messages.ContactArray._md5sum)
                    read = messages.ContactArray().deserialize(raw[1])
                    numpy.testing.assert_array_equal(read.pairs, pairs)
                for _, message, _ in bag.read_messages():
                    self.assertEqual(message.pairs[1].triangle_a, 5)


TETRAHEDRON = (numpy.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]]),
               numpy.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]]))


class Publishing(unittest.TestCase):

    def test_arrays_are_converted_and_copied(self):
        points, triangles = TETRAHEDRON
        for given in points, points.tolist(), points.astype("f4"), numpy.asfortranarray(points):
            vertices, _ = _publishing.checked_mesh(given, triangles)
            self.assertEqual((vertices.dtype, vertices.flags.c_contiguous), ("f4", True))
            self.assertEqual(vertices.tolist(), points.tolist())
            self.assertFalse(numpy.shares_memory(vertices, given))
        vertices, copied = _publishing.checked_mesh([[numpy.nan, 1e300, 0]] * 4, triangles.tolist())
        self.assertEqual(vertices[0, 1], numpy.inf)
        self.assertEqual((copied.dtype, copied.tolist()), ("u4", triangles.tolist()))

    def test_bad_arrays_are_refused(self):
        points, triangles = TETRAHEDRON
        for vertices, faces, text in (
                (points[:, :2], triangles, "vertices has shape (4, 2), must be (n, 3)"),
                (points.ravel(), triangles, "vertices has shape (12,), must be (n, 3)"),
                (points * 1j, triangles, "vertices is of complex128, must be real numbers"),
                (points[:0], triangles, "vertices is empty"),
                (points, triangles[:0], "triangles is empty"),
                (points, triangles * 1.0, "triangles is of float64, must be whole numbers"),
                (points, triangles[:, :2], "triangles has shape (4, 2), must be (n, 3)"),
                (points[:3], triangles, "triangle 1 uses the vertices [0, 1, 3], but there are 3"),
                (points, triangles - 1, "triangle 0 uses the vertices [-1, 1, 0], but there are 4")):
            with self.assertRaises(ValueError) as raised:
                messages.publish_mesh("/cloth", vertices, faces)
            self.assertEqual(str(raised.exception), text)
        for arguments, text in (({"frame": "/base"}, "frame is '/base'"), ({"frame": ""}, "frame is"),
                                ({"topic": ""}, "topic is ''"), ({"stamp": 3.5}, "stamp is 3.5"),
                                ({"name": 7}, "name is 7")):
            with self.assertRaisesRegex(ValueError, text):
                messages.publish_mesh(**{"topic": "/cloth", "vertices": points,
                                         "triangles": triangles, **arguments})
        with self.assertRaises(rospy.ROSException):
            messages.publish_mesh("/cloth", points, triangles)  # there is no node

    def test_triangles_are_sent_where_a_subscriber_may_not_know_them(self):
        topology, triangles = _publishing.Topology(), numpy.array(TETRAHEDRON[1], "u4")

        def sent(triangles, connections, now_s, vertices=4):
            return len(topology.to_send(triangles, vertices, connections, now_s)) > 0
        self.assertTrue(sent(triangles, 0, 0.0), "at first")
        self.assertTrue(sent(triangles, 0, 0.1), "it is latched for the first subscriber")
        self.assertTrue(sent(triangles, 1, 0.2), "to a new subscriber")
        self.assertFalse(sent(triangles.copy(), 1, 0.3), "known")
        self.assertTrue(sent(triangles, 2, 0.4), "to a second one")
        self.assertFalse(sent(triangles, 1, 0.5), "known")
        self.assertTrue(sent(triangles, 2, 0.6), "to one that came instead")
        self.assertFalse(sent(triangles, 2, 1.5), "known")
        self.assertTrue(sent(triangles, 2, 1.6), "once a second")
        self.assertFalse(sent(triangles, 2, 1.7), "known")
        numbers = [topology.number]
        for changed, vertices in ((triangles[::-1].copy(), 4), (triangles, 4), (triangles, 5)):
            self.assertTrue(sent(changed, 2, 1.8, vertices), "changed")
            self.assertFalse(sent(changed, 2, 1.9, vertices), "known")
            numbers.append(topology.number)
        self.assertEqual(len(set(numbers)), 3)
        self.assertEqual(numbers[0], numbers[2], "of equal triangles")
        restarted = _publishing.Topology()
        restarted.to_send(triangles, 5, 0, 0.0)
        self.assertEqual(restarted.number, numbers[-1])


if __name__ == "__main__":
    unittest.main()
