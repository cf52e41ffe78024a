"""What the tests of evaluate_bags share: six bags made from the Panda's, and the tool, which lies
beside $EVALUATE_BAG.

Most tests run the tool in this process, with Dask's workers as threads of it: each job is a process
all the same. Tests of workers, signals and schedulers start the tool as a process."""
import contextlib
import gc
import glob
import importlib.machinery
import importlib.util
import io
import json
import logging
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
from unittest import mock

import rospy
from tf2_msgs.msg import TFMessage

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "evaluate_bag"))
from evaluation_case import CONFIG, TOOL, EvaluationCase, main as run_tests, read_table
from panda_bag import AWAY_FROM, DATA, stamp_of

FLEET_TOOL = os.path.join(os.path.dirname(TOOL), "evaluate_bags")
URDF = str(DATA / "robots/panda_description/urdf/panda.urdf")
EXPECTATIONS = "- {link: panda_hand, object: tshirt, touches: sometime}\n"
CUT, FAR = "cut.bag", "lab/far.bag"
WHOLE = ("lab/bare.bag", "lab/late.bag", "lab/packed.bag", "one.bag")


def processes(word):
    """{pid: parent's pid} of those with the word in their command line."""
    found = {}
    for path in glob.glob("/proc/[0-9]*"):
        try:
            with open(path + "/cmdline", errors="replace") as file:
                command = file.read()
            with open(path + "/stat") as file:
                state, parent = file.read().rsplit(")", 1)[1].split()[:2]
        except OSError:
            continue
        if word in command and state != "Z":
            found[int(path[len("/proc/"):])] = int(parent)
    return found


def worker_threads(workers, _gpus, folder):
    """Stands in for dask_run.local_cluster."""
    from distributed import LocalCluster  # pylint: disable=import-outside-toplevel
    return LocalCluster(n_workers=workers, threads_per_worker=1, processes=False,
                        dashboard_address=None, local_directory=folder, memory_limit=0, silence_logs=logging.CRITICAL)


class FleetCase(EvaluationCase):

    def setUp(self):
        super().setUp()
        os.makedirs(self.path("bags/lab"))
        self.fleet_tool = FLEET_TOOL
        self.environment = {}  # of its process, beside this one's
        self.config = self.text("config.yaml", CONFIG)
        self.expect = self.text("expect.yaml", EXPECTATIONS)

    def write_bags(self):
        """Of what `touches: sometime` says, all but FAR keep it. Of late.bag one message was recorded
        before the clock began, 1 000 s earlier; it is one bag all the same."""
        without = [event for event in self.events if event[1] != "/contact_monitor/robot_meshes"]

        def from_frame(first):
            return [e for e in self.events if e[1] != "/tshirt" or e[2].header.stamp >=
                    stamp_of(first)]
        self.bag("bags/one.bag")
        self.bag("bags/lab/bare.bag", without)
        self.bag("bags/lab/packed.bag", compression="bz2", chunk=4096)
        self.bag("bags/lab/late.bag", [(rospy.Time(0, 1), "/tf", TFMessage()), *from_frame(5)])
        self.bag("bags/" + FAR, from_frame(AWAY_FROM))
        whole = pathlib.Path(self.path("bags/one.bag")).read_bytes()
        pathlib.Path(self.path("bags/" + CUT)).write_bytes(whole[:len(whole) // 2])

    def options(self, out, *more, robots=DATA / "robots"):
        command = [self.fleet_tool, self.path("bags"), "--out", self.path(out),
                   "--config", self.config, "--expect", self.expect,
                   "--robot-description", URDF, *more]
        return {"args": command, "stdout": subprocess.PIPE, "stderr": subprocess.PIPE,
                "universal_newlines": True, "start_new_session": True,
                "env": dict(os.environ, ROS_PACKAGE_PATH=str(robots), **self.environment)}

    def fake_tool(self, case):
        """Another evaluate_bag, which does what a case of sh says, or else what ours does. Its
        identity is the same whatever the case."""
        tools = self.path("tools")
        self.text("case", f'case "$1" in {case} esac')
        if not os.path.isdir(tools):
            os.mkdir(tools)
            for path in glob.glob(os.path.dirname(TOOL) + "/*"):
                os.symlink(path, os.path.join(tools, os.path.basename(path)))
            for name in ("evaluate_bags", "evaluate_bag"):
                os.remove(os.path.join(tools, name))
            shutil.copy(FLEET_TOOL, tools)
            self.text("tools/evaluate_bag",
                      f'#!/bin/sh\n. {self.path("case")}\nexec {TOOL} "$@"\n')
            os.chmod(self.path("tools/evaluate_bag"), 0o755)
        self.fleet_tool = os.path.join(tools, "evaluate_bags")

    def start_fleet(self, out, *more):
        """Ends with the test, whatever comes of that."""
        running = subprocess.Popen(**self.options(out, *more))

        def end():
            if running.poll() is None:
                os.killpg(running.pid, signal.SIGKILL)
                running.communicate()
        self.addCleanup(end)
        return running

    def stop_once(self, running, path):
        """By Ctrl-C once the file is there, which one that never ends writes; returns what stood on
        standard error."""
        def one_never_ends():
            self.assertIsNone(running.poll(), "ended too early")
            return os.path.exists(path)
        self.wait_for(one_never_ends)
        os.killpg(running.pid, signal.SIGINT)
        out, err = running.communicate(timeout=60)
        self.assertEqual(running.returncode, 130, out + err)
        return err

    def call_tool(self, arguments, robots=DATA / "robots"):
        """Runs the tool in this process. Returns (exit code, standard output, standard error)."""
        # Dask's clients that could not connect stop their loop when they are collected, with a lock
        # that a new client holds while it starts. So they must not wait until then.
        gc.collect()
        if os.path.dirname(FLEET_TOOL) not in sys.path:
            sys.path.insert(0, os.path.dirname(FLEET_TOOL))
        loader = importlib.machinery.SourceFileLoader("evaluate_bags_tool", self.fleet_tool)
        tool = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
        loader.exec_module(tool)
        out, err = io.StringIO(), io.StringIO()
        environment = {"ROS_PACKAGE_PATH": str(robots), **self.environment}
        with mock.patch.dict(os.environ, environment), \
                mock.patch("fleet.dask_run.local_cluster", worker_threads), \
                contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            try:
                code = tool.main(arguments)
            except SystemExit as end:  # of argparse
                code = end.code
        return code, out.getvalue(), err.getvalue()

    def run_fleet(self, out, *more, code, workers=("--workers", "2"), **options):
        found, text, errors = self.call_tool(self.options(out, *workers, *more)["args"][1:],
                                             **options)
        self.assertEqual(found, code, text + errors)
        return self.fleet(out)

    def fleet(self, out):
        """fleet.json, after a look at the other tables."""
        with open(self.path(out + "/fleet.json")) as file:
            fleet = json.load(file)
        rows = read_table(self.path(out + "/fleet.csv"))
        self.assertEqual([(row["bag"], row["state"]) for row in rows],
                         [(bag["bag"], bag["state"]) for bag in fleet["bags"]])
        self.assertTrue(os.path.exists(self.path(out + "/index.html")))
        self.assertFalse(os.path.exists(self.path(out + "/attempts")))
        return fleet

    def states(self, fleet):
        return {bag["bag"]: bag["state"] for bag in fleet["bags"]}

    def wait_for(self, condition, seconds=120):
        ends = time.monotonic() + seconds
        while time.monotonic() < ends:
            found = condition()
            if found:
                return found
            time.sleep(.1)  # jobs() reads all of /proc
        return self.fail(f"{condition.__name__} did not come in {seconds} s")

    def jobs(self):
        """{pid: parent's pid} of jobs of this test."""
        own = processes(self.folder)
        found = {pid: parent for pid, parent in processes("fleet_job.py").items() if pid in own}
        # What a job starts has the job's command line until it runs its own program.
        return {pid: parent for pid, parent in found.items() if parent not in found}

    def assert_like_single_runs(self, out, names):
        for name in names:
            with self.subTest(bag=name):
                done = self.run_tool(self.path("bags/" + name), "--config", self.config, "--expect",
                                     self.expect, "--robot-description", URDF, "--pairs",
                                     "--no-report")
                self.assertIn(done.returncode, (0, 1), done.stderr)
                self.assertEqual(self.outcome(self.path("out")),
                                 self.outcome(self.path(f"{out}/bags/{name}")))

    def outcome(self, folder):
        """All that a run found, without times."""
        frames = [{k: v for k, v in row.items() if not k.endswith("_ms")}
                  for row in read_table(folder + "/frames.csv")]
        with open(folder + "/summary.json") as file:
            summary = json.load(file)
        del summary["times"]
        texts = [pathlib.Path(folder, name).read_bytes()
                 for name in ("links.csv", "events.csv", "pairs.csv")]
        return frames, summary, texts


def main():
    if importlib.util.find_spec("distributed") is None:
        print("SKIPPED: there is no python3-distributed")
        raise SystemExit(77)
    run_tests()
