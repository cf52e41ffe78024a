"""Jobs on Dask's workers. A job is a process that a worker starts, so workers need neither our
modules nor our environment, and a bag that crashes its reader takes no worker along."""
import collections
import logging
import subprocess
import sys
import time

from distributed import Client, Nanny, Scheduler, SpecCluster, as_completed

RETRIES = 2
GPU = "GPU"  # Dask's resource that a worker with a GPU has one of
POLL_S = 0.1
CONNECT_S = 20
GONE = "the scheduler is gone; what is done is kept, the same command goes on with another"


def local_cluster(workers, gpus, folder):
    """Worker processes on this machine's loopback address, each with one bag at a time, and with
    one of `gpus` (words for CUDA_VISIBLE_DEVICES) where there are any."""
    # Without an address Dask shows its state to the whole network. Its own limit on memory is of
    # the worker, which needs next to none.
    address = {"host": "127.0.0.1", "dashboard_address": "127.0.0.1:0"}
    options = {"nthreads": 1, "memory_limit": 0, "local_directory": folder,
               "silence_logs": logging.CRITICAL, **address}
    specs = {}
    for i in range(workers):
        specs[i] = {"cls": Nanny, "options": dict(options)}
        if gpus:
            specs[i]["options"].update(env={"CUDA_VISIBLE_DEVICES": gpus[i % len(gpus)]},
                                       resources={GPU: 1})
    scheduler = {"cls": Scheduler,
                 "options": {"port": 0, "allowed_failures": RETRIES, **address}}
    return SpecCluster(workers=specs, scheduler=scheduler, silence_logs=logging.CRITICAL)


def connect(address):
    """Of a local cluster, or an address."""
    return Client(address, timeout=CONNECT_S)


def _failure(error):
    if isinstance(error, subprocess.CalledProcessError):
        lines = (error.stderr or b"").decode(errors="replace").splitlines()
        return lines[-1] if lines else f"the job ended with {error.returncode}"
    return " ".join(f"{type(error).__name__}: {error}".split())


class DaskRun:
    """Hands out as many jobs as there are places on workers: a job that waits at a worker would
    count as failed when that worker dies."""

    def __init__(self, client):
        self.client = client
        self.running = {}  # future: job
        self.done = as_completed()

    def run(self, jobs, on_end, on_wait):
        """on_end(job, text, failure) for each: what it wrote, or why there is nothing; returns
        jobs that go next. Those that are `given_up` by then are left out. on_wait(number of places)
        in between."""
        waiting = collections.deque(jobs)
        while waiting or self.running:
            places, resources = self._places()
            while waiting and len(self.running) < places:
                job = waiting.popleft()
                if not job.get("given_up"):
                    self._submit(job, resources)
            if not self.done.has_ready():
                on_wait(places)
                time.sleep(POLL_S)
                continue
            future = next(self.done)
            job = self.running.pop(future)
            if future.status == "finished":
                more = on_end(job, future.result().decode(), None)
            elif future.status == "error":
                more = on_end(job, None, _failure(future.exception()))
            else:  # cancelled, lost
                raise OSError(GONE)
            waiting.extendleft(reversed(more))

    def _places(self):
        """Where any worker has a GPU, those with one do the work."""
        if self.client.status != "running":
            raise OSError(GONE)
        workers = self.client.scheduler_info()["workers"].values()
        gpus = sum(int(worker["resources"].get(GPU, 0)) for worker in workers)
        if gpus:
            return gpus, {GPU: 1}
        return sum(worker["nthreads"] for worker in workers), None

    def _submit(self, job, resources):
        command = [sys.executable, job["script"], job["text"]]
        # The worker's terminal is not the job's: Ctrl-C there is the worker's to handle.
        future = self.client.submit(subprocess.check_output, command, stderr=subprocess.PIPE,
                                    start_new_session=True, retries=RETRIES, resources=resources,
                                    pure=False)
        self.running[future] = job
        self.done.add(future)
