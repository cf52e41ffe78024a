"""One bag's evaluation on the machine of a worker: a process of evaluate_bag in a folder of its
own, which gets its name once it is whole."""
import ctypes
import json
import os
import shutil
import signal
import socket
import subprocess
import tempfile
import time

from fleet.identity import are_same_meshes, identity_of, meshes_of, short_hash
from fleet.pair_hashes import write_pair_hashes

POLL_S = 0.2
RECORD = "job.json"
PASSED, BROKEN, UNUSABLE, REFUSED = "passed", "broken", "unusable", "refused"


class Stopped(Exception):
    """The run was stopped, or the worker is gone."""


class Crashed(Exception):
    """The attempt came to nothing; another may do better."""


def _die_with_parent():
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGKILL)


class Evaluation:

    def __init__(self, job):
        """`job`: as fleet.dask_run makes it."""
        self.job = job
        self.parent = os.getppid()
        self.final = os.path.join(job["out"], "bags", job["name"])
        self.parts = os.path.join(job["out"], "parts", job["name"])
        self.attempt = None  # folder

    def run(self):
        """The record of the bag's result: one that is there already, or a new one."""
        identity = self.job.get("identity")
        if identity is None:  # the first job of the bag
            version = subprocess.run([self.job["tool"], "--version"], stdout=subprocess.PIPE,
                                     check=True, universal_newlines=True).stdout.strip()
            identity = identity_of(self.job["tool"], version, self.job["bag"],
                                   self.job["arguments"], self._go_on)
            record = self._earlier(identity)
            self._forget_parts("" if record else self._records_of("", identity))
            if record:
                return dict(record, bag=self.job["bag"], was_there=True)
            if self.job["parts"] > 1:
                return {"split": identity}
        self.attempt = tempfile.mkdtemp(prefix=self.job["run"] + "-", dir=self.job["attempts"])
        os.chmod(self.attempt, 0o755)
        try:
            if "part" in self.job:
                return self._find_contacts(identity)
            return dict(self._evaluate(identity), was_there=False)
        finally:
            shutil.rmtree(self.attempt, ignore_errors=True)

    def _records_of(self, number, identity):
        """The file of a part; those of another identity have another name."""
        return os.path.join(self.parts,
                            f'{short_hash(identity)}-of-{self.job["parts"]}-{number}')

    def _forget_parts(self, but):
        """All that an earlier run left, but those whose paths begin thus."""
        for name in os.listdir(self.parts) if os.path.isdir(self.parts) else ():
            path = os.path.join(self.parts, name)
            if not but or not path.startswith(but):
                os.remove(path)

    def _find_contacts(self, identity):
        """A part that is there is not made again."""
        number = self.job["part"]
        path = self._records_of(number, identity)
        if os.path.exists(path):
            return {"was_there": True}
        made = os.path.join(self.attempt, "records")
        code, last_line = self._run_tool("--part", f'{number}/{self.job["parts"]}', "--records",
                                         made)
        if code != 0:
            return {"refused": last_line}
        os.makedirs(self.parts, exist_ok=True)
        os.replace(made, path)
        return {"was_there": False}

    def _join(self, identity):
        """Nothing where there are no parts, or they do not go together any more."""
        files = [self._records_of(number + 1, identity) for number in range(self.job["parts"])]
        if self.job["parts"] == 1 or not all(os.path.exists(path) for path in files):
            return None
        code, last_line = self._run_tool("--out", self.attempt, "--join", *files)
        is_whole = os.path.exists(os.path.join(self.attempt, "summary.json"))
        return (code, last_line) if is_whole else None

    def _go_on(self):
        if os.getppid() != self.parent:
            raise Stopped("the worker is gone")
        if os.path.exists(self.job["stop"]):
            raise Stopped("stopped")

    def _earlier(self, identity):
        try:
            with open(os.path.join(self.final, RECORD)) as file:
                record = json.load(file)
            same = (record["identity"] == identity
                    and are_same_meshes(record["meshes"], self._go_on))
        except (OSError, ValueError, KeyError):
            return None
        return record if same else None

    def _evaluate(self, identity):
        started = time.monotonic()
        code, last_line = self._join(identity) or self._run_tool("--out", self.attempt)
        record = {"name": self.job["name"], "bag": self.job["bag"], "message": last_line,
                  "machine": socket.gethostname(), "seconds": time.monotonic() - started,
                  "bytes": os.path.getsize(self.job["bag"])}
        summary_path = os.path.join(self.attempt, "summary.json")
        if not os.path.exists(summary_path):
            if code != 2:
                raise Crashed(f"evaluate_bag ended with {code} and no summary: {last_line}")
            shutil.rmtree(self.parts, ignore_errors=True)
            return dict(record, state=REFUSED)
        with open(summary_path, errors="replace") as file:
            summary = json.load(file)
        write_pair_hashes(self.attempt)
        if "--pairs" not in self.job["arguments"]:
            os.remove(os.path.join(self.attempt, "pairs.csv"))
        if self.job["parts"] > 1:
            record["seconds"] = summary["times"]["elapsed_s"]  # of all parts
        record.update(state={0: PASSED, 1: BROKEN, 2: UNUSABLE}[code], identity=identity,
                      identity_hash=short_hash(identity), meshes=meshes_of(summary, self._go_on))
        if code != 2:
            record["message"] = summary["verdict"]
        with open(os.path.join(self.attempt, RECORD), "w") as file:
            json.dump(record, file, indent=1, sort_keys=True)
        self._publish()
        return record

    def _run_tool(self, *more):
        """(exit code, last line on standard error)"""
        arguments = [*self.job["arguments"], *more]
        if "--pairs" not in arguments:
            arguments.append("--pairs")
        if self.job["threads"] is not None:
            arguments += ["--threads", str(self.job["threads"])]
        with tempfile.TemporaryFile() as errors:
            # A session of its own: what evaluate_bag starts ends with it.
            tool = subprocess.Popen([self.job["tool"], self.job["bag"], *arguments],
                                    stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
                                    stderr=errors,
                                    preexec_fn=_die_with_parent, start_new_session=True)
            try:
                while True:
                    try:
                        code = tool.wait(POLL_S)
                        break
                    except subprocess.TimeoutExpired:
                        self._go_on()
            finally:
                if tool.poll() is None:
                    os.killpg(tool.pid, signal.SIGKILL)
                    tool.wait()
            errors.seek(0)
            lines = errors.read().decode(errors="replace").splitlines()
        last = lines[-1] if lines else ""
        if code not in (0, 1, 2):
            raise Crashed(f"evaluate_bag ended with {code}: {last}")
        return code, last

    def _publish(self):
        """An earlier result is there until the new one is."""
        os.makedirs(os.path.dirname(self.final), exist_ok=True)
        if os.path.isdir(self.final):
            os.rename(self.final, tempfile.mkdtemp(prefix=self.job["run"] + "-old-",
                                                   dir=self.job["attempts"]))
        os.rename(self.attempt, self.final)
        shutil.rmtree(self.parts, ignore_errors=True)
