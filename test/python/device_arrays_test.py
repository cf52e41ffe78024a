#!/usr/bin/env python3
"""Vertices in a device's memory: what is refused, and, where there is a device, contacts.

The refusals need no device: they are of objects that only say they are there. With
$DCM_REQUIRE_CUDA it is a failure if there is no device.
"""
import ctypes
import gc
import importlib
import os
import unittest
import weakref

import mesh_scenes
import numpy
from deformable_contact import Detector, Scene, StateChecker

VERTICES = numpy.array([[0, 0, 0], [4, 0, 0], [0, 4, 0]], numpy.float32)
FIELDS = {"version": 3, "shape": (3, 3), "typestr": "<f4", "data": (4096, True), "strides": None,
          "stream": 1}


class DeviceArray:

    def __init__(self, **fields):
        self.__cuda_array_interface__ = dict(FIELDS, **fields)


def scene_of_one():
    scene = Scene()
    scene.add_body("cloth", VERTICES, [[0, 1, 2]])
    return scene


class WithoutADevice(unittest.TestCase):

    def refused(self, text, vertices, **kwargs):
        with self.assertRaises(ValueError) as raised:
            scene_of_one().set_device_vertices(0, vertices, **kwargs)
        self.assertEqual(str(raised.exception), "cloth: " + text)

    def test_what_is_taken(self):
        for fields in ({}, {"version": 2}, {"stream": None}, {"stream": 2}, {"stream": 77777},
                       {"strides": (12, 4)}, {"data": (4096, False)}, {"mask": None}):
            scene_of_one().set_device_vertices(0, DeviceArray(**fields))
        array = DeviceArray(version=2)
        del array.__cuda_array_interface__["stream"], array.__cuda_array_interface__["strides"]
        scene_of_one().set_device_vertices(0, array)
        scene_of_one().set_device_vertices(0, array, stream=77777)
        scene = Scene()
        scene.add_body("empty", numpy.empty((0, 3)), numpy.empty((0, 3), int))
        scene.set_device_vertices(0, DeviceArray(shape=(0, 3), data=(0, False), strides=(4, 4)))

    def test_what_is_refused(self):
        interface = "vertices: its __cuda_array_interface__ "
        for what, fields in (
                ("has version 1, must be 2 or later", {"version": 1}),
                ("has version None", {"version": None}),
                ("has shape (9,), must be (n, 3)", {"shape": (9,)}),
                ("has shape (3, 4), must be (n, 3)", {"shape": (3, 4)}),
                ("has shape (-1, 3), must be (n, 3)", {"shape": (-1, 3)}),
                ("has shape 'x'", {"shape": ("x", 3)}),
                ("has shape None", {"shape": None}),
                ("has typestr '<f8', must be '<f4', float32", {"typestr": "<f8"}),
                ("has typestr '>f4', must be '<f4', float32", {"typestr": ">f4"}),
                ("has typestr 3", {"typestr": 3}),
                ("has strides (16, 4), must be contiguous", {"strides": (16, 4)}),
                ("has strides (4, 12), must be contiguous", {"strides": (4, 12)}),
                ("has strides (12,), must be contiguous", {"strides": (12,)}),
                ("has a mask, must have none", {"mask": 5}),
                ("has no data, but shape (3, 3)", {"data": (0, False)}),
                ("has data None", {"data": None}),
                ("has data ()", {"data": ()}),
                ("has data -1", {"data": (-1, False)}),
                ("has stream 0, which means none in particular", {"stream": 0}),
                ("has stream -1", {"stream": -1}),
                ("has stream 'x'", {"stream": "x"})):
            with self.subTest(what):
                self.refused(interface + what, DeviceArray(**fields))
        no_dict = DeviceArray()
        no_dict.__cuda_array_interface__ = 7
        self.refused(interface + "is no dict", no_dict)
        self.refused("vertices is not in a device's memory (it has no __cuda_array_interface__); "
                     "set_vertices takes it", VERTICES)
        self.refused("4 vertices, but its triangles are of a mesh with 3",
                     DeviceArray(shape=(4, 3)))

    def test_the_wrong_way_in_is_named(self):

        class OnDeviceAlone(DeviceArray):

            def __array__(self, *_args, **_kwargs):
                raise TypeError("on the device")

        with self.assertRaisesRegex(ValueError, "cloth: vertices is in a device's memory; "
                                                "set_device_vertices takes vertices from there"):
            scene_of_one().set_vertices(0, OnDeviceAlone())

    def test_the_cpu_refuses_them_by_name(self):
        scene = scene_of_one()
        scene.set_pair_enabled(0, 0)
        scene.set_device_vertices(0, DeviceArray())
        detector = Detector("cpu")
        with self.assertRaisesRegex(ValueError, "cloth"):
            detector.detect(scene)
        scene.set_vertices(0, VERTICES)
        self.assertTrue(detector.detect(scene).complete)

    def test_poses_that_are_refused(self):
        for what, fields in (("has typestr '<i4', must be '<f4' or '<f8'", {"typestr": "<i4"}),
                             ("has shape (-1, 4)", {"shape": (-1, 4)}),
                             ("has shape None", {"shape": None}),
                             ("has strides (8, 4), must be contiguous", {"strides": (8, 4)}),
                             ("has a mask, must have none", {"mask": 5}),
                             ("has no data, but shape (3, 3)", {"data": (0, False)})):
            with self.assertRaises(ValueError) as raised:
                StateChecker("cpu").check(scene_of_one(), [0], DeviceArray(**fields))
            self.assertIn("poses: its __cuda_array_interface__ " + what, str(raised.exception))
        with self.assertRaises((ValueError, RuntimeError)):  # no such memory, or no CUDA
            StateChecker("cpu").check(scene_of_one(), [0], DeviceArray())

    def test_other_errors_of_the_interface_are_passed_on(self):
        class WithGradients:
            @property
            def __cuda_array_interface__(self):
                raise RuntimeError("use detach()")
        for call in (lambda: scene_of_one().set_device_vertices(0, WithGradients()),
                     lambda: StateChecker("cpu").check(scene_of_one(), [0], WithGradients())):
            with self.assertRaisesRegex(RuntimeError, "use detach"):
                call()

    def test_an_array_is_kept_until_the_body_has_others(self):
        scene = scene_of_one()
        for replace in (lambda: scene.set_vertices(0, VERTICES),
                        lambda: scene.set_mesh(0, VERTICES, [[0, 1, 2]]),
                        lambda: scene.set_device_vertices(0, DeviceArray())):
            array = DeviceArray()
            kept = weakref.ref(array)
            scene.set_device_vertices(0, array)
            del array
            gc.collect()
            self.assertIsNotNone(kept())
            with self.assertRaises(ValueError):  # a refusal changes nothing
                scene.set_device_vertices(0, DeviceArray(shape=(4, 3)))
            self.assertIsNotNone(kept())
            replace()
            gc.collect()
            self.assertIsNone(kept())
        array = DeviceArray()
        kept = weakref.ref(array)
        scene.set_device_vertices(0, array)
        del array, scene
        gc.collect()
        self.assertIsNone(kept())


class Driver:
    """As much of CUDA's driver as it takes to put vertices onto the first device."""

    def __init__(self):
        self._cuda = ctypes.CDLL("libcuda.so.1")
        self.call("cuInit", 0)
        device, self._context = ctypes.c_int(), ctypes.c_void_p()
        self.call("cuDeviceGet", ctypes.byref(device), 0)
        self.call("cuDevicePrimaryCtxRetain", ctypes.byref(self._context), device)
        self.call("cuCtxSetCurrent", self._context)

    def call(self, name, *arguments):
        error = getattr(self._cuda, name)(*arguments)
        if error != 0:
            raise OSError("%s: error %d" % (name, error))

    def stream(self):
        stream = ctypes.c_void_p()
        self.call("cuStreamCreate", ctypes.byref(stream), 1)  # waits for no default stream
        return stream.value

    def array(self, vertices, **fields):
        at = ctypes.c_uint64()
        self.call("cuMemAlloc_v2", ctypes.byref(at), ctypes.c_size_t(max(vertices.nbytes, 1)))
        array = DeviceArray(shape=vertices.shape, data=(at.value, False), **fields)
        self.write(array, vertices)
        return array

    def write(self, array, vertices):
        at = ctypes.c_uint64(array.__cuda_array_interface__["data"][0])
        self.call("cuMemcpyHtoD_v2", at, ctypes.c_void_p(vertices.ctypes.data),
                  ctypes.c_size_t(vertices.nbytes))


def driver_or_skip():
    try:
        return Driver()
    except OSError as error:
        if os.environ.get("DCM_REQUIRE_CUDA"):
            raise
        raise unittest.SkipTest("no device: %s" % error)


class OnADevice(unittest.TestCase):

    def test_contacts_are_those_of_the_same_vertices_on_the_host(self):
        driver = driver_or_skip()
        detector = Detector("cuda")
        for seed in range(6):
            rng = numpy.random.default_rng(seed)
            host, device = Scene(), Scene()
            meshes = [mesh_scenes.soup(rng, 300) for _ in range(2)]
            for number, (vertices, triangles) in enumerate(meshes):
                for scene in host, device:
                    scene.add_body("body %d" % number, vertices, triangles)
                    scene.set_pair_enabled(0, scene.body_count - 1)
            streams = [{"stream": 1}, {"stream": None}, {"stream": 2},
                       {"stream": driver.stream()}]
            arrays = [driver.array(vertices, **streams[(seed + body) % 4])
                      for body, (vertices, _) in enumerate(meshes)]
            for _ in range(3):
                for body, array in enumerate(arrays):
                    vertices = rng.uniform(0, 3, meshes[body][0].shape).astype(numpy.float32)
                    host.set_vertices(body, vertices)
                    driver.write(array, vertices)
                    device.set_device_vertices(body, array)
                expected = mesh_scenes.as_set(Detector("cpu").detect(host).pairs)
                self.assertGreater(len(expected), 100)
                self.assertEqual(mesh_scenes.as_set(detector.detect(device).pairs), expected)
                self.assertEqual(mesh_scenes.as_set(detector.detect(host).pairs), expected)

    def test_states_of_poses_on_the_device_are_those_on_the_host(self):
        driver = driver_or_skip()
        rng = numpy.random.default_rng(1)
        scene = Scene()
        bodies = [scene.add_body(name, *mesh_scenes.soup(rng, 60)) for name in ("still", "moved")]
        scene.set_pair_enabled(*bodies)
        scene.set_margin(bodies[0], 1)
        poses = numpy.tile(numpy.eye(4), (200, 1, 1, 1))
        poses[:, 0, :3, 3] = rng.uniform(-6, 6, (200, 3))
        for kind, stream in (("<f8", 1), ("<f4", driver.stream())):
            given = poses.astype(kind)
            array = driver.array(given, typestr=kind, stream=stream)
            expected = StateChecker("cpu").check(scene, bodies[1:], given, nearest=True)
            for backend in "cuda", "cpu":
                states = StateChecker(backend).check(scene, bodies[1:], array, nearest=True)
                numpy.testing.assert_array_equal(states.distances, expected.distances)
            self.assertTrue(0 < expected.touches.sum() < 200)

    def test_arrays_of_other_libraries_while_their_streams_still_write(self):
        driver_or_skip()
        tried = 0
        for module, writer in ("cupy", CupyWriter), ("torch", TorchWriter):
            try:
                library = importlib.import_module(module)
            except ImportError:
                continue
            tried += 1
            rng = numpy.random.default_rng(tried)
            vertices, triangles = mesh_scenes.soup(rng, 300)
            scene, detector = Scene(), Detector("cuda")
            scene.add_body(module, vertices, triangles)
            scene.set_pair_enabled(0, 0)
            arrays = writer(library, vertices)
            for _ in range(5):
                vertices = rng.uniform(0, 3, vertices.shape).astype(numpy.float32)
                arrays.write_late(vertices)
                scene.set_device_vertices(0, arrays.array, **arrays.stream())
                found = mesh_scenes.as_set(detector.detect(scene).pairs)
                scene.set_vertices(0, vertices)
                self.assertEqual(found, mesh_scenes.as_set(Detector("cpu").detect(scene).pairs))
                self.assertGreater(len(found), 100)
        if not tried:
            self.skipTest("neither CuPy nor PyTorch")


class CupyWriter:
    """A CuPy array whose interface names the stream that writes it."""

    def __init__(self, cupy, vertices):
        self._cupy = cupy
        self._stream = cupy.cuda.Stream(non_blocking=True)
        self._wait = cupy.RawKernel(
            'extern "C" __global__ void wait() { long long t = clock64(); '
            'while (clock64() - t < 100000000) {} }', "wait")
        self._array = cupy.asarray(vertices)
        cupy.cuda.Device().synchronize()

    def write_late(self, vertices):
        late = self._cupy.asarray(vertices)
        self._cupy.cuda.Device().synchronize()
        with self._stream:
            self._wait((1,), (1,), ())
            self._array[:] = late

    @property
    def array(self):
        with self._stream:
            interface = self._array.__cuda_array_interface__
        assert interface["stream"] == self._stream.ptr
        return Kept(self._array, interface)

    @staticmethod
    def stream():
        return {}


class Kept(DeviceArray):

    def __init__(self, array, interface):
        super().__init__(**interface)
        self._array = array


class TorchWriter:
    """A PyTorch tensor, whose interface names no stream."""

    def __init__(self, torch, vertices):
        self._torch = torch
        self._stream = torch.cuda.Stream()
        self.array = torch.tensor(vertices, device="cuda")
        torch.cuda.synchronize()

    def write_late(self, vertices):
        late = self._torch.tensor(vertices, device="cuda")
        self._torch.cuda.synchronize()
        with self._torch.cuda.stream(self._stream):
            self._torch.cuda._sleep(100000000)
            self.array.copy_(late)

    def stream(self):
        return {"stream": self._stream.cuda_stream}


if __name__ == "__main__":
    unittest.main()
