#!/usr/bin/env python3
"""Local workers of evaluate_bags share a machine: a GPU each, and the cores."""
import os
import re
import subprocess

import psutil  # Dask needs it

from fleet_case import FleetCase, main

GPUS = ("GPU-5d5ba0d6-d33d", "GPU-01234567-d33d")
CORES = len(os.sched_getaffinity(0))


class Workers(FleetCase):

    def setUp(self):
        super().setUp()
        self.bags = [f"{number}.bag" for number in range(2)]
        for name in self.bags:
            self.bag("bags/" + name)
        self.log = self.path("log")

    def calls(self):
        """{bag: (device, threads)} since the last call of this, and lines of another form."""
        found, others = {}, []
        with open(self.log) as file:
            for line in file:
                call = re.fullmatch(r"(\S*) (\S*)/bags/(\S+) (.*)\n", line)
                if call is None:
                    others.append(line)
                    continue
                threads = re.search(r"--threads (\d+)", call.group(4))
                found[call.group(3)] = call.group(1), threads and int(threads.group(1))
        os.remove(self.log)
        return found, others

    def test_each_worker_has_a_gpu(self):
        lines = "\n".join(f"GPU {i}: A card (UUID: {name})" for i, name in enumerate(GPUS))
        self.text("nvidia-smi", f"#!/bin/sh\ncat <<E\n{lines}\nE\n")
        os.chmod(self.path("nvidia-smi"), 0o755)
        self.environment = {"PATH": f'{self.folder}:{os.environ["PATH"]}'}
        busy = self.path("busy-")
        self.fake_tool(f'*.bag) echo "$CUDA_VISIBLE_DEVICES $*" >>{self.log}\n'
                       f"mkdir {busy}$CUDA_VISIBLE_DEVICES || echo shared >>{self.log}\n"
                       f"sleep 1; rmdir {busy}$CUDA_VISIBLE_DEVICES;;")
        self.run_processes("fleet")
        calls, others = self.calls()
        self.assertEqual(others, [])
        self.assertEqual(set(calls), set(self.bags))
        self.assertEqual({device for device, _ in calls.values()}, set(GPUS))
        self.environment["CUDA_VISIBLE_DEVICES"] = "1"
        self.run_processes("other")
        calls, others = self.calls()
        self.assertEqual((others, {device for device, _ in calls.values()}), ([], {"1"}))

    def run_processes(self, out):
        done = subprocess.run(**self.options(out, "--no-report"), timeout=500, check=False)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def test_workers_share_the_cores(self):
        self.fake_tool(f'*.bag) echo "none $*" >>{self.log};;')

        def threads(out, *more, **options):
            fleet = self.run_fleet(out, "--no-report", *more, code=0, **options)
            if fleet["were_there"] == len(self.bags):
                return set()
            return {threads for _, threads in self.calls()[0].values()}
        self.assertEqual(threads("two"), {max(CORES // 2, 1)})
        self.assertEqual(threads("one", workers=("--workers", "1")), {CORES})
        self.assertEqual(threads("five", "--threads", "5"), {5})
        self.assertEqual(threads("five", "--threads", "3"), set(), "it is the same result")
        with open(self.config, "a") as file:
            file.write("threads: 3\n")
        self.assertEqual(threads("three"), {None})

    def test_they_listen_on_loopback_alone(self):
        asleep = self.path("asleep")
        self.fake_tool(f"*.bag) echo here >{asleep}; tail -f {asleep};;")
        running = self.start_fleet("fleet", "--workers", "2")

        def workers_are_there():
            return os.path.exists(asleep)
        self.wait_for(workers_are_there)
        ours = [running.pid, *(process.pid for process in
                               psutil.Process(running.pid).children(recursive=True))]
        places = {connection.laddr.ip for connection in psutil.net_connections("inet")
                  if connection.pid in ours and connection.status == psutil.CONN_LISTEN}
        self.assertEqual(places, {"127.0.0.1"})


if __name__ == "__main__":
    main()
