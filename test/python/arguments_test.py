#!/usr/bin/env python3
"""Arrays of every kind, and what is refused, with which words."""
import os
import pathlib
import tempfile
import unittest
import warnings

import numpy
from deformable_contact import Detector, Scene, read_mesh

VERTICES = [[0, 0, 0], [4, 0, 0], [0, 4, 0], [9, 9, 9]]
TRIANGLES = [[0, 1, 2]]
# One triangle that pierces the first, and one far off, which hides in other orders of the numbers.
PIERCING = [[1, 1, -1], [1, 1, 1], [1, 2, 1], [9, 8, 9], [8, 9, 9], [9, 9, 9]]
PIERCING_TRIANGLES = [[5, 4, 3], [0, 1, 2]]
CONTACT = [[0, 0, 1, 1]]


def unaligned(array):
    data = b"\0" + array.tobytes()
    return numpy.frombuffer(data, array.dtype, array.size, 1).reshape(array.shape)


def read_only(array):
    array = array.copy()
    array.setflags(write=False)
    return array


LAYOUTS = {
    "C": numpy.ascontiguousarray,
    "Fortran": numpy.asfortranarray,
    "every second row": lambda array: numpy.repeat(array, 2, axis=0)[::2],
    "columns of four": lambda array: numpy.pad(array, ((0, 0), (0, 1)))[:, :3],
    "backwards": lambda array: array[::-1, ::-1].copy()[::-1, ::-1],
    "unaligned": unaligned,
    "read-only": read_only,
    "big-endian": lambda array: array.astype(array.dtype.newbyteorder(">")),
}


class Arrays(unittest.TestCase):

    def contacts(self, vertices, triangles):
        scene = Scene()
        scene.add_body("floor", VERTICES, TRIANGLES)
        body = scene.add_body("empty", numpy.empty((0, 3)), numpy.empty((0, 3), int))
        scene.set_pair_enabled(0, body)
        scene.set_mesh(body, vertices, triangles)
        pairs = Detector("cpu").detect(scene).pairs.tolist()
        scene.set_vertices(body, numpy.add(vertices, 100))
        self.assertEqual(Detector("cpu").detect(scene).pairs.tolist(), [])
        scene.set_vertices(body, vertices)
        self.assertEqual(Detector("cpu").detect(scene).pairs.tolist(), pairs)
        return pairs

    def test_types_of_vertices(self):
        for dtype in "f2", "f4", "f8", "g", "i1", "i4", "i8", "i2":
            self.assertEqual(self.contacts(numpy.array(PIERCING, dtype), PIERCING_TRIANGLES),
                             CONTACT, dtype)
        self.assertEqual(self.contacts(PIERCING, PIERCING_TRIANGLES), CONTACT)

    def test_types_of_triangles(self):
        for dtype in "i1", "u1", "i2", "u2", "i4", "u4", "i8", "u8":
            self.assertEqual(self.contacts(PIERCING, numpy.array(PIERCING_TRIANGLES, dtype)),
                             CONTACT, dtype)

    def test_layouts(self):
        for name, layout in LAYOUTS.items():
            for types in ("f4", "u4"), ("f8", "i8"), ("f4", "i4"):
                vertices = layout(numpy.array(PIERCING, types[0]))
                triangles = layout(numpy.array(PIERCING_TRIANGLES, types[1]))
                numpy.testing.assert_array_equal(vertices, PIERCING)
                self.assertEqual(self.contacts(vertices, triangles), CONTACT, (name, types))

    def test_doubles_are_rounded_to_the_nearest_float(self):
        # The tip touches z = 0 only where 1e-60 becomes 0, and x = 16777217 rounds to even.
        tip = [[1, 1, 1e-60], [1, 1, 1], [1, 2, 1]]
        self.assertEqual(self.contacts(tip, TRIANGLES), [[0, 0, 1, 0]])
        scene = Scene()
        point = scene.add_body("point", [[16777217.0, 0, 0]] * 3, TRIANGLES)
        other = scene.add_body("other", numpy.full((3, 3), [16777216, 0, 0], "f4"), TRIANGLES)
        scene.set_pair_enabled(point, other)
        self.assertEqual(len(Detector("cpu").detect(scene).pairs), 1)

    def test_a_second_body_of_one_name_is_refused(self):
        scene = Scene()
        for name in "cloth", "":
            body = scene.add_body(name, VERTICES, TRIANGLES)
            refusal = "body '%s' is in the scene already \\(id %d\\)" % (name, body)
            with self.assertRaisesRegex(ValueError, refusal):
                scene.add_body(name, PIERCING, PIERCING_TRIANGLES)
        self.assertEqual(scene.names, ["cloth", ""])
        self.assertEqual(scene.triangle_count, 2 * len(TRIANGLES))

    def test_a_scene_without_enabled_pairs_warns(self):
        scene = Scene()
        scene.add_body("floor", VERTICES, TRIANGLES)
        scene.add_body("other", PIERCING, PIERCING_TRIANGLES)
        detector = Detector("cpu")
        for _ in range(2):
            with self.assertWarnsRegex(RuntimeWarning, "set_pair_enabled"):
                self.assertEqual(detector.detect(scene).pairs.tolist(), [])
            scene.set_pair_enabled(0, 1)
            with warnings.catch_warnings():
                warnings.simplefilter("error")
                self.assertEqual(detector.detect(scene).pairs.tolist(), CONTACT)
            scene.set_pair_enabled(0, 1, False)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            for without_pairs in scene, Scene():
                with self.assertRaisesRegex(RuntimeWarning, "no pair"):
                    detector.detect(without_pairs)

    def test_what_was_passed_may_change(self):
        vertices = numpy.array(PIERCING, "f4")
        triangles = numpy.array(PIERCING_TRIANGLES, "u4")
        scene = Scene()
        scene.add_body("floor", VERTICES, TRIANGLES)
        scene.add_body("piercing", vertices, triangles)
        scene.set_pair_enabled(0, 1)
        vertices += 100
        triangles[:] = 0
        self.assertEqual(Detector("cpu").detect(scene).pairs.tolist(), CONTACT)

    def test_ids_may_be_numpy_numbers(self):
        scene = Scene()
        scene.add_body("a", VERTICES, TRIANGLES)
        scene.set_pair_enabled(numpy.uint32(0), numpy.int64(0))
        self.assertTrue(scene.pair_enabled(0, 0))
        scene.set_pair_enabled(0, 0, False)
        self.assertEqual((scene.enabled_pairs(), scene.names, scene.body_count), ([], ["a"], 1))


class Refusals(unittest.TestCase):

    def setUp(self):
        self.scene = Scene()
        self.scene.add_body("cloth", VERTICES, TRIANGLES)

    def refused(self, text, call, *args, error=ValueError, **kwargs):
        with self.assertRaises(error) as raised:
            call(*args, **kwargs)
        self.assertEqual(str(raised.exception), text)
        self.assertEqual((self.scene.body_count, self.scene.triangle_count), (1, 1))

    def test_shapes(self):
        for vertices, shape in ([[1, 2]], "(1, 2)"), ([1, 2, 3], "(3,)"), ([], "(0,)"), (1, "()"), (
                numpy.zeros((2, 3, 3)), "(2, 3, 3)"), (numpy.zeros((3, 2)).T[:, :2], "(2, 2)"):
            text = "cloth: vertices has shape %s, must be (n, 3)" % shape
            self.refused(text, self.scene.add_body, "cloth", vertices, TRIANGLES)
            self.refused(text, self.scene.set_mesh, 0, vertices, TRIANGLES)
            self.refused(text, self.scene.set_vertices, 0, vertices)
        self.refused("cloth: triangles has shape (1, 4), must be (n, 3)", self.scene.set_mesh, 0,
                     VERTICES, [[0, 1, 2, 3]])
        self.refused("cloth: 3 vertices, but its triangles are of a mesh with 4",
                     self.scene.set_vertices, 0, VERTICES[:3])

    def test_types(self):
        for vertices, dtype in ([[1j, 0, 0]], "complex128"), ([["a", "b", "c"]], "<U1"), (
                [[True, False, True]], "bool"), ([[None, 1, 2]], "object"):
            self.refused("cloth: vertices has dtype %s, must be real numbers" % dtype,
                         self.scene.set_vertices, 0, vertices)
        for triangles, dtype in ([[0., 1., 2.]], "float64"), ([[True, False, True]], "bool"):
            self.refused("cloth: triangles has dtype %s, must be integers" % dtype,
                         self.scene.set_mesh, 0, VERTICES, triangles)

    def test_indices_never_wrap_around(self):
        for dtype, index in (("i1", -1), ("i4", -1), ("i8", -1), ("i8", 2**32), ("i8", 2**32 + 1),
                             ("i8", -2**63), ("u8", 2**64 - 1), ("u8", 2**32), ("u4", 2**32 - 1),
                             ("i8", 4), ("u1", 4)):
            triangles = numpy.array([[0, 1, 2], [0, 1, index]], dtype)
            self.refused("cloth: triangle 1 refers to vertex %d, but there are 4 vertices" % index,
                         self.scene.set_mesh, 0, VERTICES, triangles)

    def test_poses(self):
        rotation = numpy.eye(3)
        self.refused("cloth: rotation has shape (9,), must be (3, 3)", self.scene.set_pose, 0,
                     rotation.ravel(), [0, 0, 0])
        self.refused("cloth: rotation has shape (3, 4), must be (3, 3)", self.scene.set_pose, 0,
                     numpy.zeros((3, 4)), [0, 0, 0])
        self.refused("cloth: translation has shape (1, 3), must be (3,)", self.scene.set_pose, 0,
                     rotation, [[0, 0, 0]])
        self.refused("cloth: rotation has dtype complex128, must be real numbers",
                     self.scene.set_pose, 0, rotation * 1j, [0, 0, 0])
        self.refused("cloth: its pose has a non-finite number", self.scene.set_pose, 0, rotation,
                     [0, float("nan"), 0])
        for wrong in 2 * rotation, -rotation, numpy.diag([1, 1, -1]), numpy.zeros((3, 3)), \
                rotation + numpy.eye(3, k=1) / 100:
            for function in self.scene.set_pose, self.scene.set_earlier:
                self.refused("cloth: rotation is no rotation: it scales, shears or mirrors",
                             function, 0, rotation=wrong, translation=[0, 0, 0])
        self.scene.set_pose(0, rotation + 1e-5, [0, 0, 0])  # as rounded by others

    def test_masked_arrays(self):
        masked = numpy.ma.masked_greater(numpy.array(VERTICES, float), 0.5)
        self.refused("cloth: vertices has masked values; fill or leave them out first",
                     self.scene.set_vertices, 0, masked)
        self.scene.set_vertices(0, numpy.ma.array(VERTICES))  # nothing is masked

    def test_margins(self):
        self.refused("cloth: margin -1.000000 m is not a finite number >= 0",
                     self.scene.set_margin, 0, -1)
        self.refused("cloth: margin inf m is not a finite number >= 0", self.scene.set_margin, 0,
                     float("inf"))

    def test_radii(self):
        self.refused("cloth: radius -1.000000 m is not a finite number >= 0",
                     self.scene.set_radius, 0, -1)
        self.refused("cloth: radius nan m is not a finite number >= 0", self.scene.set_radius, 0,
                     float("nan"))

    def test_bodies_that_do_not_exist(self):
        for body in 1, -1, 2**32, -2**63:
            text = "body %d does not exist; there are 1" % body
            self.refused(text, self.scene.set_mesh, body, VERTICES, TRIANGLES)
            self.refused(text, self.scene.set_vertices, body, VERTICES)
            self.refused(text, self.scene.set_pose, body, numpy.eye(3), [0, 0, 0])
            self.refused(text, self.scene.set_margin, body, 0)
            self.refused(text, self.scene.set_radius, body, 0)
            self.refused(text, self.scene.set_pair_enabled, 0, body)
            self.refused(text, self.scene.pair_enabled, body, 0)

    def test_options(self):
        self.refused("overlap is 2.000000, must be in [0, 1]; threads is -1, must be in [0, 1024] "
                     "(0: all)", Detector, overlap=2, threads=-1)
        self.refused("refresh_period is 0, must be >= 1", Detector, refresh_period=0)
        self.refused("backend 'gpu' is none of auto, cuda, cpu", Detector, "gpu")
        for name in "sure", "fast":
            self.refused(f"predicates '{name}' is none of exact, conservative", Detector,
                         predicates=name)
        self.refused("adjacent_pairs 'none' is none of beyond_shared, skip", Detector,
                     adjacent_pairs="none")
        self.refused("device is -1, must be in [0, 1023]", Detector, device=-1)
        self.refused("memory_limit_mib is 0, must be in [1, 1048576]", Detector,
                     memory_limit_mib=0)
        for time in -1.0, float("nan"):
            self.refused("max_time_s is %f, must be >= 0, or None" % time, Detector().detect,
                         self.scene, max_time_s=time)

    def test_what_numpy_cannot_read_is_named(self):
        self.refused("cloth: vertices is not an array", self.scene.set_vertices, 0, Opaque())


class Opaque:

    def __array__(self, *_args, **_kwargs):
        raise TypeError("not for numpy")


class Files(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_a_mesh(self):
        path = self.folder / "quad.obj"
        path.write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0.1\nf 1 2 3 4\n")
        for name in path, str(path), os.fsencode(path):
            vertices, triangles = read_mesh(name)
            numpy.testing.assert_array_equal(
                vertices, numpy.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0.1]], "f4"))
            numpy.testing.assert_array_equal(triangles, [[0, 1, 2], [0, 2, 3]])
            self.assertEqual((vertices.dtype, triangles.dtype), ("f4", "u4"))
            self.assertTrue(vertices.flags.writeable)

    def test_files_that_cannot_be_opened(self):
        with self.assertRaises(FileNotFoundError) as raised:
            read_mesh(self.folder / "none.obj")
        self.assertEqual(raised.exception.filename, str(self.folder / "none.obj"))
        with self.assertRaises(IsADirectoryError):
            read_mesh(self.folder)
        with self.assertRaises(TypeError):
            read_mesh(7)

    def test_files_that_are_no_meshes(self):
        for name, content, what in (
                ("a.obj", "", ": is empty"), ("b.obj", "v 0 0 0\n", ": holds no triangle"),
                ("c.txt", "x", ": cannot tell the format from the name; mesh files end in .obj, "
                               ".off, .ply or .stl")):
            path = self.folder / name
            path.write_text(content)
            with self.assertRaises(ValueError) as raised:
                read_mesh(path)
            self.assertEqual(str(raised.exception), str(path) + what)


if __name__ == "__main__":
    unittest.main()
