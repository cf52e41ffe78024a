"""A run over many bags: its folder, its jobs, and their results."""
import contextlib
import fcntl
import json
import os
import shutil
import time
import uuid

from fleet import dask_run, machine
from fleet.changes import read_summary
from fleet.evaluation import KEPT, REFUSED, size_of
from fleet.identity import VARIABLES
from fleet.progress import Progress
from fleet.tables import CRASHED, TABLES

STOP_S = 5  # time for jobs to notice the stop file [s]


class FolderError(Exception):
    """One line for the user."""


class Run:
    """One run over many bags. Incomplete results are in its folder of attempts."""

    def __init__(self, arguments, tools):
        """`tools`: the folder with evaluate_bag and fleet_job.py."""
        self.out = os.path.abspath(arguments.out)
        self.passed = arguments.passed
        self.threads = arguments.threads
        self.id = uuid.uuid4().hex[:12]
        self.attempts = os.path.join(self.out, "attempts")
        self.stop = os.path.join(self.attempts, self.id + ".stop")
        self.script = os.path.join(tools, "fleet_job.py")
        self.tool = os.path.join(tools, "evaluate_bag")

    @contextlib.contextmanager
    def folder(self):
        """Locks the folder while the context lasts, and removes the tables of an earlier run."""
        os.makedirs(self.out, exist_ok=True)
        with open(os.path.join(self.out, ".lock"), "w") as lock:
            try:
                fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            except BlockingIOError:
                raise FolderError(f"{self.out}: another evaluate_bags writes there") from None
            for name in TABLES:
                with contextlib.suppress(FileNotFoundError):
                    os.remove(os.path.join(self.out, name))
            shutil.rmtree(self.attempts, ignore_errors=True)
            os.makedirs(self.attempts)
            try:
                yield
            finally:
                shutil.rmtree(self.attempts, ignore_errors=True)

    def stop_jobs(self):
        """Asks the jobs to stop, and waits until they have, for STOP_S at most."""
        with open(self.stop, "w"):
            pass
        ends = time.monotonic() + STOP_S
        while self._has_attempts() and time.monotonic() < ends:
            time.sleep(.1)

    def _set_aside(self, name):
        """Moves an earlier result away, because this run cannot tell whether it still holds. A
        later job of the same identity brings it back. Returns whether there is an earlier result.
        """
        result, kept = (os.path.join(self.out, folder, name) for folder in ("bags", KEPT))
        if os.path.isdir(result):
            shutil.rmtree(kept, ignore_errors=True)
            os.makedirs(os.path.dirname(kept), exist_ok=True)
            os.rename(result, kept)
        return os.path.isdir(kept)

    def _has_attempts(self):
        return any(name.startswith(self.id + "-") for name in os.listdir(self.attempts))

    def job(self, name, bag):
        """Returns a job for fleet_job.py, which needs neither our modules nor our environment."""
        environment = {key: os.environ[key] for key in VARIABLES if key in os.environ}
        text = json.dumps({
            "name": name, "bag": bag, "out": self.out, "attempts": self.attempts, "run": self.id,
            "stop": self.stop, "tool": self.tool, "arguments": self.passed,
            "threads": self.threads, "folder": os.getcwd(), "environment": environment})
        return {"name": name, "bag": bag, "script": self.script, "text": text}

    def evaluate(self, bags, address):
        """Evaluates the bags on the workers at `address`. Returns {name: record}."""
        sizes = {name: size_of(path) for name, path in bags.items()}
        progress = Progress(len(bags), sum(sizes.values()))
        records = {}

        def on_end(job, text, failure):
            name = job["name"]
            records[name] = json.loads(text) if failure is None else {
                "name": name, "bag": job["bag"], "state": CRASHED, "message": failure}
            record, cycles = records[name], 0
            if record["state"] not in (REFUSED, CRASHED):
                cycles = read_summary(os.path.join(self.out, "bags", name))["cycles"]
            elif self._set_aside(name):
                record["message"] += f"; an earlier result is in {KEPT}/"
            progress.add(sizes[name], cycles, record.get("was_there", False))

        client = dask_run.connect(address)
        try:
            jobs = [self.job(name, path) for name, path in bags.items()]
            dask_run.DaskRun(client).run(jobs, on_end, progress.show)
        finally:
            progress.clear()
            client.close()
        return records


def evaluate_on_workers(run, bags, arguments):
    """Evaluates the bags on the scheduler of the arguments, or on local workers."""
    if arguments.scheduler is not None:
        return _evaluate(run, bags, arguments.scheduler)
    gpus = machine.gpu_names()
    workers = machine.worker_count(arguments.workers, len(bags), len(gpus))
    if run.threads is None:
        run.threads = machine.threads_each(workers, (arguments.config or [None])[0])
    cluster = dask_run.local_cluster(workers, gpus, os.path.join(run.attempts, "dask"))
    try:
        return _evaluate(run, bags, cluster)
    finally:
        cluster.close()


def _evaluate(run, bags, address):
    try:
        return run.evaluate(bags, address)
    except BaseException:
        run.stop_jobs()
        raise
