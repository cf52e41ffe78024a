#!/usr/bin/env python3
"""What each local worker has of a machine; on one that says that it has two GPUs."""
import os
import pathlib
import sys
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src/tools/evaluate_bags"))
from fleet.places import CORES, environments
from fleet_case import FleetCase, main


class Shares(unittest.TestCase):

    def cores(self, count, cores):
        return [environment[CORES] for environment in environments(count, 0, cores)]

    def test_cores(self):
        self.assertEqual(self.cores(2, [0, 1, 2, 5]), ["0,2", "1,5"])
        self.assertEqual(self.cores(3, [0, 1, 2, 3]), ["0,3", "1", "2"])
        self.assertEqual(self.cores(3, [4, 7]), ["4", "7", "4"])

    def test_gpus(self):
        self.assertEqual([e["CUDA_VISIBLE_DEVICES"] for e in environments(3, 2, [0])],
                         ["0", "1", "0"])
        self.assertNotIn("CUDA_VISIBLE_DEVICES", environments(1, 0, [0])[0])


class Machine(FleetCase):

    def test_a_worker_for_each_gpu(self):
        """An nvidia-smi that lists two, and an evaluate_bag that says what it was given."""
        for name in ("a.bag", "b.bag"):
            self.bag("bags/" + name)
        here, there = self.path("a.bag.given"), self.path("b.bag.given")
        told = ('echo $CUDA_VISIBLE_DEVICES $(taskset -cp $$ | sed "s/.*: //")'
                f' >{self.folder}/$(basename "$1").given;'
                f' while ! [ -e {here} -a -e {there} ]; do sleep .1; done')
        self.fake_tool(f"*.bag) {told};;")  # neither ends before both have begun
        os.mkdir(self.path("bin"))
        smi = self.text("bin/nvidia-smi", "#!/bin/sh\necho GPU 0: one\necho GPU 1: another\n")
        os.chmod(smi, 0o755)
        path = os.environ["PATH"]
        os.environ["PATH"] = self.path("bin") + ":" + path
        self.addCleanup(os.environ.__setitem__, "PATH", path)
        self.run_fleet("fleet", "--no-report", code=0, workers=())
        given = sorted(pathlib.Path(file).read_text().split() for file in (here, there))
        cores = sorted(os.sched_getaffinity(0))
        self.assertEqual([gpu for gpu, _ in given], ["0", "1"])
        if len(cores) == 2:
            self.assertEqual([mine for _, mine in given], [str(core) for core in cores])


if __name__ == "__main__":
    main()
