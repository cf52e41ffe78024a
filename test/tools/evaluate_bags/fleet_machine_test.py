#!/usr/bin/env python3
"""How local workers share a machine: its GPUs, by another nvidia-smi, and its cores."""
import os
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src/tools/evaluate_bags"))
from fleet.machine import gpu_names, threads_each, worker_count

LIST = """GPU 0: NVIDIA A100-SXM4-40GB (UUID: GPU-5d5ba0d6-d33d-2b2c-524d-9e3d8d2b8a77)
  MIG 1g.5gb      Device  0: (UUID: MIG-c6d4f1ef-42e4-5de3-91c7-45d71c87eb3f)
GPU 1: NVIDIA A100-SXM4-40GB (UUID: GPU-01234567-d33d-2b2c-524d-9e3d8d2b8a77)
"""
FIRST, SECOND = (f"GPU-{start}-d33d-2b2c-524d-9e3d8d2b8a77" for start in ("5d5ba0d6", "01234567"))


class Machine(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        change = mock.patch.dict(os.environ, {"PATH": f"{self.folder}:/usr/bin:/bin"})
        change.start()
        self.addCleanup(change.stop)
        os.environ.pop("CUDA_VISIBLE_DEVICES", None)

    def text(self, name, content):
        path = os.path.join(self.folder, name)
        with open(path, "w") as file:
            file.write(content)
        return path

    def nvidia_smi(self, script):
        os.chmod(self.text("nvidia-smi", "#!/bin/sh\n" + script), 0o755)

    def cores(self, count):
        change = mock.patch.object(os, "sched_getaffinity", lambda _: set(range(count)))
        change.start()
        self.addCleanup(change.stop)

    def test_gpus(self):
        os.environ["PATH"] = self.folder
        self.assertEqual(gpu_names(), [], "no nvidia-smi")
        os.environ["PATH"] += ":/usr/bin:/bin"
        self.nvidia_smi(f'[ "$*" = -L ] || exit 3\ncat <<E\n{LIST}E\n')
        self.assertEqual(gpu_names(), [FIRST, SECOND])
        for given, names in (("1", ["1"]), ("1, 0", ["1", "0"]), ("", []), ("-1", []),
                             ("0,-1,1", ["0"]), (SECOND, [SECOND])):
            os.environ["CUDA_VISIBLE_DEVICES"] = given
            self.assertEqual(gpu_names(), names, given)
        self.nvidia_smi("echo NVIDIA-SMI has failed because it could not communicate\nexit 9\n")
        self.assertEqual(gpu_names(), [], "a driver that does not run, whatever is visible")

    def test_workers(self):
        self.cores(16)
        self.assertEqual(worker_count(None, 100, 0), 16)
        self.assertEqual(worker_count(None, 100, 2), 2)
        self.assertEqual(worker_count(5, 100, 2), 5)
        self.assertEqual(worker_count(5, 3, 0), 3)
        self.assertEqual(worker_count(None, 0, 0), 1)

    def test_threads(self):
        self.cores(16)
        self.assertEqual([threads_each(n, None) for n in (1, 2, 3, 16, 40)], [16, 8, 5, 1, 1])
        self.assertEqual(threads_each(2, self.text("c.yaml", "threads: 0\n")), 8)
        self.assertEqual(threads_each(2, self.text("c.yaml", "margin_m: 0\n")), 8)
        self.assertIsNone(threads_each(2, self.text("c.yaml", "threads: 3\n")))
        for unreadable in ("threads: [", "- threads", "", "\xff: 1"):
            self.assertEqual(threads_each(2, self.text("c.yaml", unreadable)), 8)
        self.assertEqual(threads_each(2, self.folder), 8)


if __name__ == "__main__":
    unittest.main()
