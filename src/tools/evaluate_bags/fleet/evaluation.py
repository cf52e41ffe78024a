"""Evaluates one bag on a worker's machine: runs evaluate_bag in a temporary folder, which gets its
name once the result is complete."""
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
KEPT = "kept"  # folder of results of which a run could not tell whether they hold
PASSED, BROKEN, UNUSABLE, REFUSED = "passed", "broken", "unusable", "refused"


class Stopped(Exception):
    """The run was stopped, or the worker is gone."""


class Crashed(Exception):
    """The attempt has no result; another attempt may succeed."""


def _die_with_parent():
    pr_set_pdeathsig = 1
    ctypes.CDLL(None).prctl(pr_set_pdeathsig, signal.SIGKILL)


def size_of(bag):
    """Returns the bytes of a bag; 0 if it cannot be read, as a link to a file that is gone."""
    try:
        return os.path.getsize(bag)
    except OSError:
        return 0


class Evaluation:

    def __init__(self, job):
        """`job` is the JSON of Run.job()."""
        self.job = job
        self.parent = os.getppid()
        self.final = os.path.join(job["out"], "bags", job["name"])
        self.kept = os.path.join(job["out"], KEPT, job["name"])
        self.attempt = None  # folder

    def run(self):
        """Returns the record of the bag's result: an earlier one that still holds, or a new one."""
        version = subprocess.run([self.job["tool"], "--version"], stdout=subprocess.PIPE,
                                 check=True, universal_newlines=True).stdout.strip()
        identity = identity_of(self.job["tool"], version, self.job["bag"], self.job["arguments"],
                               self._go_on)
        record = self._earlier(identity)
        if record:
            return dict(record, bag=self.job["bag"], was_there=True, warning=self._draw_missing())
        self.attempt = tempfile.mkdtemp(prefix=self.job["run"] + "-", dir=self.job["attempts"])
        os.chmod(self.attempt, 0o755)
        try:
            record = dict(self._evaluate(identity), was_there=False)
            if record["state"] != REFUSED:
                record["warning"] = self._draw_missing()
            return record
        finally:
            shutil.rmtree(self.attempt, ignore_errors=True)

    def _go_on(self):
        if os.getppid() != self.parent:
            raise Stopped("the worker is gone")
        if os.path.exists(self.job["stop"]):
            raise Stopped("stopped")

    def _earlier(self, identity):
        record = self._holding(self.final, identity)
        if record is None:
            record = self._holding(self.kept, identity)
            if record is not None:
                self._publish(self.kept)
        return record

    def _holding(self, folder, identity):
        """Returns the record of the result in the folder; None if none is there that holds."""
        try:
            with open(os.path.join(folder, RECORD)) as file:
                record = json.load(file)
            same = (record["identity"] == identity
                    and are_same_meshes(record["meshes"], self._go_on))
        except (OSError, ValueError, KeyError):
            return None
        return record if same else None

    def _evaluate(self, identity):
        started = time.monotonic()
        code, last_line = self._evaluate_bag()
        record = {"name": self.job["name"], "bag": self.job["bag"], "message": last_line,
                  "machine": socket.gethostname(), "seconds": time.monotonic() - started,
                  "bytes": size_of(self.job["bag"])}
        summary_path = os.path.join(self.attempt, "summary.json")
        if not os.path.exists(summary_path):
            if code != 2:
                raise Crashed(f"evaluate_bag ended with {code} and no summary: {last_line}")
            return dict(record, state=REFUSED)
        with open(summary_path, errors="replace") as file:
            summary = json.load(file)
        write_pair_hashes(self.attempt)
        if "--pairs" not in self.job["arguments"]:
            os.remove(os.path.join(self.attempt, "pairs.csv"))
        record.update(state={0: PASSED, 1: BROKEN, 2: UNUSABLE}[code], identity=identity,
                      identity_hash=short_hash(identity), meshes=meshes_of(summary, self._go_on))
        if code != 2:
            record["message"] = summary["verdict"]
        with open(os.path.join(self.attempt, RECORD), "w") as file:
            json.dump(record, file, indent=1, sort_keys=True)
        self._publish(self.attempt)
        shutil.rmtree(self.kept, ignore_errors=True)
        return record

    def _draw_missing(self):
        """Draws the result's report if it is asked for and missing. Returns why it cannot be drawn,
        else ""."""
        if "--no-report" in self.job["arguments"] \
                or os.path.exists(os.path.join(self.final, "report.html")):
            return ""
        script = os.path.join(os.path.dirname(self.job["tool"]), "evaluation_report.py")
        try:
            code, last_line = self._run_tool([script, self.final])
        except OSError as error:
            code, last_line = None, str(error)
        return f"no report.html: {last_line}" if code != 0 else ""

    def _evaluate_bag(self):
        """Returns evaluate_bag's exit code and its last line on standard error."""
        arguments = [*self.job["arguments"], "--out", self.attempt]
        if "--pairs" not in arguments:
            arguments.append("--pairs")
        if self.job["threads"] is not None:
            arguments += ["--threads", str(self.job["threads"])]
        code, last = self._run_tool([self.job["tool"], self.job["bag"], *arguments])
        # The folder of the attempt will be gone.
        last = last.replace(self.attempt, self.final)
        if code not in (0, 1, 2):
            raise Crashed(f"evaluate_bag ended with {code}: {last}")
        return code, last

    def _run_tool(self, command):
        """Returns the exit code and the last line on standard error."""
        with tempfile.TemporaryFile() as errors:
            # The tool gets its own session, so that everything it starts can be ended with it.
            tool = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
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
        return code, lines[-1] if lines else ""

    def _publish(self, folder):
        """Replaces an earlier result, which stays until the new one is complete."""
        os.makedirs(os.path.dirname(self.final), exist_ok=True)
        if os.path.isdir(self.final):
            os.rename(self.final, tempfile.mkdtemp(prefix=self.job["run"] + "-old-",
                                                   dir=self.job["attempts"]))
        os.rename(folder, self.final)
