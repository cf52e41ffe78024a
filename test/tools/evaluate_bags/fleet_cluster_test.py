#!/usr/bin/env python3
"""evaluate_bags on a scheduler and two workers, started by hand as the README says, on this
machine's loopback address alone, used and stopped."""
import contextlib
import os
import signal
import subprocess
import time

try:
    from distributed import Client
except ImportError:
    Client = None  # main() skips

from fleet_case import CUT, FAR, WHOLE, FleetCase, main

LOOPBACK = ["--host", "127.0.0.1", "--dashboard-address", "127.0.0.1:0"]


class Cluster(FleetCase):

    def start(self, *command):
        with open(self.path("cluster.log"), "a") as log:
            process = subprocess.Popen(command, stdout=log, stderr=log, cwd=self.folder,
                                       start_new_session=True)
        self.addCleanup(self.stop, process)
        return process

    @staticmethod
    def stop(process):
        """With all that it started."""
        if process.poll() is None:
            process.terminate()
        try:
            process.wait(30)
        except subprocess.TimeoutExpired:
            os.killpg(process.pid, signal.SIGKILL)
            process.wait()

    def address(self):
        self.scheduler = self.start("dask-scheduler", *LOOPBACK, "--port", "0",
                                    "--scheduler-file", self.path("scheduler.json"))

        def scheduler_is_there():
            return os.path.exists(self.path("scheduler.json"))
        self.wait_for(scheduler_is_there, 60)

        def address_is_written():
            with open(self.path("scheduler.json")) as file:
                return [line.split('"')[3] for line in file if '"address"' in line]
        return self.wait_for(address_is_written, 20)[0]

    def worker(self, address, *more):
        return self.start("dask-worker", address, *LOOPBACK, "--nthreads", "1",
                          "--memory-limit", "0", "--local-directory", self.path("worker"), *more)

    def test_scheduler_and_two_workers(self):
        self.write_bags()
        address = self.address()
        self.assertTrue(address.startswith("tcp://127.0.0.1:"), address)
        workers = [self.worker(address) for _ in range(2)]
        running = self.start_fleet("fleet", "--scheduler", address, "--pairs", "--no-report")
        self.wait_for(self.jobs)
        # A machine that goes away: with its nanny, so that nobody starts it anew.
        os.killpg(workers[0].pid, signal.SIGKILL)
        out, err = running.communicate(timeout=500)
        self.assertEqual(running.returncode, 2, out + err)
        self.assertEqual(self.states(self.fleet("fleet")),
                         {CUT: "refused", FAR: "broken", **dict.fromkeys(WHOLE, "passed")})
        self.assert_like_single_runs("fleet", (FAR, *WHOLE))
        fleet = self.run_fleet("fleet", "--pairs", "--no-report", code=2,
                               workers=("--scheduler", address))
        self.assertEqual(fleet["were_there"], 5)

    def test_workers_with_a_gpu_do_the_work(self):
        """As Dask has it, a resource is what the worker's owner says it has."""
        self.bag("bags/one.bag")
        self.bag("bags/two.bag")
        address = self.address()
        self.worker(address)
        with_gpu = self.worker(address, "--resources", "GPU=1")

        with Client(address) as client:
            client.wait_for_workers(2)
        running = self.start_fleet("fleet", "--scheduler", address, "--no-report")
        sessions = set()
        while running.poll() is None:
            for worker in self.jobs().values():
                with contextlib.suppress(ProcessLookupError):
                    sessions.add(os.getsid(worker))
            time.sleep(.1)
        out, err = running.communicate()
        self.assertEqual(running.returncode, 0, out + err)
        self.assertEqual(sessions, {with_gpu.pid})

    def test_the_scheduler_goes(self):
        self.write_bags()
        address = self.address()
        self.worker(address)
        running = self.start_fleet("fleet", "--scheduler", address)

        def one_is_done():
            return os.path.exists(self.path("fleet/bags")) and self.jobs()
        self.wait_for(one_is_done)
        os.killpg(self.scheduler.pid, signal.SIGKILL)
        out, err = running.communicate(timeout=60)
        self.assertEqual(running.returncode, 2, out + err)
        self.assertIn("the scheduler is gone", err.splitlines()[-1])
        self.assertFalse(os.path.exists(self.path("fleet/fleet.json")))
        self.assertGreater(self.run_fleet("fleet", code=2)["were_there"], 0)


if __name__ == "__main__":
    main()
