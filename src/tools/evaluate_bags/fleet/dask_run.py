"""Runs jobs on Dask workers. A job is a process that a worker starts. So workers need neither our
modules nor our environment, and a bag that crashes its reader does not crash a worker."""
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
    """Starts worker processes on this machine's loopback address. Each has one bag at a time, and
    one of `gpus` (words for CUDA_VISIBLE_DEVICES) if there are any."""
    # Without an address, Dask would listen on all network interfaces. Its memory limit applies to
    # the worker, which hardly needs memory, so it is off.
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
    """Returns a client of a local cluster, or of a scheduler's address. Raises OSError."""
    try:
        return Client(address, timeout=CONNECT_S)
    except (OSError, ValueError, TypeError, RuntimeError, ImportError) as error:
        if not isinstance(address, str):
            raise
        raise OSError(f"--scheduler {address}: {error}; it must be the address of a running "
                      "scheduler, as tcp://HOST:8786") from error


def _failure(error):
    if isinstance(error, subprocess.CalledProcessError):
        lines = (error.stderr or b"").decode(errors="replace").splitlines()
        return lines[-1] if lines else f"the job ended with {error.returncode}"
    return " ".join(f"{type(error).__name__}: {error}".split())


class DaskRun:
    """Hands out only as many jobs as the workers have places: a job that waits at a worker would
    count as failed when that worker dies."""

    def __init__(self, client):
        self.client = client
        self.running = {}  # future: job
        self.done = as_completed()

    def run(self, jobs, on_end, on_wait):
        """Runs the jobs. Calls on_end(job, text, failure) for each: `text` is what the job wrote, or
        `failure` says why it failed. Calls on_wait(number of places) in between."""
        waiting = collections.deque(jobs)
        while waiting or self.running:
            places, resources = self._places()
            while waiting and len(self.running) < places:
                self._submit(waiting.popleft(), resources)
            if not self.done.has_ready():
                on_wait(places)
                time.sleep(POLL_S)
                continue
            future = next(self.done)
            job = self.running.pop(future)
            if future.status == "finished":
                on_end(job, future.result().decode(), None)
            elif future.status == "error":
                on_end(job, None, _failure(future.exception()))
            else:  # cancelled, lost
                raise OSError(GONE)

    def _places(self):
        """Counts the places. If any worker has a GPU, only those with a GPU do the work."""
        if self.client.status != "running":
            raise OSError(GONE)
        workers = self.client.scheduler_info()["workers"].values()
        gpus = sum(int(worker["resources"].get(GPU, 0)) for worker in workers)
        if gpus:
            return gpus, {GPU: 1}
        return sum(worker["nthreads"] for worker in workers), None

    def _submit(self, job, resources):
        command = [sys.executable, job["script"], job["text"]]
        # A session of its own keeps Ctrl-C in the worker's terminal from the job.
        future = self.client.submit(subprocess.check_output, command, stderr=subprocess.PIPE,
                                    start_new_session=True, retries=RETRIES, resources=resources,
                                    pure=False)
        self.running[future] = job
        self.done.add(future)
