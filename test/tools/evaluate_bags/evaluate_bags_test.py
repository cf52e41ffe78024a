#!/usr/bin/env python3
"""evaluate_bags as its users see it: the tables of single runs, workers that die, going on."""
import contextlib
import errno
import glob
import io
import json
import os
import re
import runpy
import shutil
import signal
import subprocess
from unittest import mock

import rosbag

from fleet_case import (
    CONFIG, CUT, EXPECTATIONS, FAR, FLEET_TOOL, TOOL, WHOLE, FleetCase, main, processes)


class EvaluateBags(FleetCase):

    def records(self):
        return {path: os.stat(path).st_mtime_ns
                for path in glob.glob(self.path("fleet/bags/**/job.json"), recursive=True)}

    def test_a_worker_is_killed_and_the_fleet_goes_on(self):
        self.write_bags()
        running = self.start_fleet("fleet", "--workers", "2", "--pairs", "--no-report")
        job, worker = next(iter(self.wait_for(self.jobs).items()))
        self.assertNotEqual(worker, running.pid)
        os.kill(worker, signal.SIGKILL)

        def job_is_gone():
            return job not in self.jobs()
        self.wait_for(job_is_gone, 20)
        out, err = running.communicate(timeout=500)
        self.assertEqual(running.returncode, 2, out + err)
        fleet = self.fleet("fleet")
        self.assertEqual(self.states(fleet), {CUT: "refused", FAR: "broken",
                                              **dict.fromkeys(WHOLE, "passed")})
        self.assertIn("rosbag reindex", out)
        self.assertIn("FAILS: panda_hand touches tshirt (not once", out)
        self.assert_like_single_runs("fleet", (FAR, *WHOLE))
        self.assertFalse(os.path.exists(self.path("fleet/bags/" + CUT)))
        alone = self.run_tool(self.path("bags/" + CUT))
        self.assertEqual(alone.returncode, 2)
        self.assertEqual([bag["message"] for bag in fleet["bags"] if bag["bag"] == CUT],
                         alone.stderr.splitlines()[-1:])

        before = self.records()
        self.assertEqual(len(before), 5)
        again = self.run_fleet("fleet", "--pairs", "--no-report", code=2)
        self.assertEqual(self.records(), before, "what was done was done again")
        self.assertEqual({bag["bag"] for bag in again["bags"] if bag["was_there"]}, {FAR, *WHOLE})
        self.assertEqual(self.states(again), self.states(fleet))
        self.what_else_ends_a_fleet(before)

    def what_else_ends_a_fleet(self, before):
        os.remove(self.path("bags/" + CUT))
        fleet = self.run_fleet("fleet", "--pairs", "--no-report", code=1)
        self.assertEqual(set(self.states(fleet)), {FAR, *WHOLE})
        self.assertEqual(self.records(), before)
        self.text("expect.yaml", EXPECTATIONS + "- {link: panda_link0, object: tshirt, "
                  "touches: never}\n")
        os.remove(self.path("bags/" + FAR))
        fleet = self.run_fleet("fleet", "--pairs", "--no-report", code=0)
        self.assertEqual(fleet["were_there"], 0, "other expectations")
        # A bag that cannot be read any more leaves no earlier result behind.
        with open(self.path("bags/one.bag"), "r+b") as file:
            file.truncate(1000)
        fleet = self.run_fleet("fleet", "--pairs", "--no-report", code=2)
        self.assertEqual((self.states(fleet)["one.bag"], fleet["were_there"]), ("refused", 3))
        self.assertFalse(os.path.exists(self.path("fleet/bags/one.bag")))

    def test_stopped_it_leaves_what_is_done(self):
        self.write_bags()
        asleep = self.path("asleep")
        self.fake_tool(f"*late.bag) echo here >{asleep}; tail -f {asleep};;")
        running = self.start_fleet("fleet", "--workers", "1", "--no-report")
        self.assertNotIn("Traceback", self.stop_once(running, asleep))
        self.assertEqual(processes(self.folder), {})
        self.assertFalse(os.path.exists(self.path("fleet/attempts")))
        done = self.records()
        self.assertEqual(len(done), 2, "those before it in the order of names")
        self.fake_tool("none) ;;")
        fleet = self.run_fleet("fleet", "--no-report", code=2)
        self.assertEqual(fleet["were_there"], len(done))
        self.assertLessEqual(done.items(), self.records().items())

    def test_a_bag_that_fails_costs_itself_alone(self):
        """Another evaluate_bag ends by a signal at one bag; a link among the bags leads nowhere."""
        self.bag("bags/bad.bag")
        self.bag("bags/good.bag")
        os.symlink(self.path("no such file"), self.path("bags/gone.bag"))
        self.fake_tool(f'*bad.bag) echo attempt >>{self.path("attempts")}; kill -SEGV $$;;')
        code, out, errors = self.call_tool(
            self.options("fleet", "--workers", "1", "--no-report")["args"][1:])
        self.assertEqual(code, 2, out + errors)
        self.assertEqual(self.states(self.fleet("fleet")),
                         {"bad.bag": "crashed", "gone.bag": "refused", "good.bag": "passed"})
        self.assertRegex(out, "gone.bag: refused: evaluate_bag: .*gone.bag: cannot be read")
        with open(self.path("attempts")) as file:
            self.assertEqual(file.read().count("attempt"), 3)
        self.assertIn("bad.bag: crashed: ", out)

    def test_a_recording_that_never_ended_is_refused(self):
        """`rosbag record` left it when it was killed. First a whole bag is beside it."""
        self.bag("bags/good.bag")
        dead = self.path("bags/lab/dead.bag.active")
        with rosbag.Bag(self.path("dead"), "w") as bag:
            for received, topic, message in self.events:
                bag.write(topic, message, received)
            bag.flush()
            shutil.copy(self.path("dead"), dead)
        for other in ({"good.bag": "passed"}, {}):
            code, out, errors = self.call_tool(
                self.options("fleet", "--workers", "1", "--no-report")["args"][1:])
            self.assertEqual(code, 2, out + errors)
            self.assertEqual(self.states(self.fleet("fleet")),
                             {"lab/dead.bag.active": "refused", **other})
            self.assertRegex(out, r"lab/dead\.bag\.active: refused: [^\n]* mend it with: "
                             f"rosbag reindex {dead}\n")
            self.assertIn(f"Failed: 1 of {1 + len(other)} bags could not", out)
            with contextlib.suppress(FileNotFoundError):
                os.remove(self.path("bags/good.bag"))

    def test_what_cannot_be_judged_now_costs_no_earlier_result(self):
        """First no job can start, as on a worker that does not see the package; then a bag is away;
        then the configuration is wrong."""
        os.mkdir(self.path("store"))
        self.bag("store/one.bag")
        self.bag("bags/two.bag")
        os.symlink(self.path("store/one.bag"), self.path("bags/one.bag"))
        self.fake_tool("none) ;;")
        self.run_fleet("fleet", "--no-report", code=0)
        done = self.records()
        self.assertEqual(len(done), 2)
        script = self.path("tools/fleet_job.py")
        os.rename(script, script + ".away")
        fleet = self.run_fleet("fleet", "--no-report", code=2)
        self.assertEqual(set(self.states(fleet).values()), {"crashed"})
        self.assert_kept(fleet, "one.bag", "two.bag")
        self.assertEqual(self.records(), {}, "it may be out of date")
        os.rename(script + ".away", script)
        os.rename(self.path("store"), self.path("away"))
        fleet = self.run_fleet("fleet", "--no-report", code=2)
        self.assertEqual(self.states(fleet), {"one.bag": "refused", "two.bag": "passed"})
        self.assertEqual(fleet["were_there"], 1)
        self.assert_kept(fleet, "one.bag")
        os.rename(self.path("away"), self.path("store"))
        self.text("config.yaml", "[")
        fleet = self.run_fleet("fleet", "--no-report", code=2)
        self.assertEqual(set(self.states(fleet).values()), {"refused"})
        self.assert_kept(fleet, "one.bag", "two.bag")
        self.assertEqual(self.records(), {}, "it is out of date")
        self.text("config.yaml", CONFIG)
        fleet = self.run_fleet("fleet", "--no-report", code=0)
        self.assertEqual(fleet["were_there"], 2)
        self.assertEqual(self.records(), done)

    def assert_kept(self, fleet, *names):
        self.assertEqual([bag["bag"] for bag in fleet["bags"]
                          if bag["message"].endswith("; an earlier result is in kept/")], [*names])

    def test_a_report_that_could_not_be_drawn_is_drawn_by_the_next_run(self):
        """evaluate_bag draws none, as on a full disk, and neither does the script at first."""
        self.bag("bags/one.bag")
        self.fake_tool(f'*.bag) exec {TOOL} "$@" --no-report;;')
        script = self.path("tools/evaluation_report.py")
        drawn = self.path("fleet/bags/one.bag/report.html")
        os.rename(script, script + ".whole")
        self.text("tools/evaluation_report.py", "#!/bin/sh\necho a disk is full >&2\nexit 1\n")
        os.chmod(script, 0o755)
        warning = "no report.html: a disk is full"
        for were_there in (0, 1):
            code, out, errors = self.call_tool(self.options("fleet")["args"][1:])
            self.assertEqual(code, 0, out + errors)
            fleet = self.fleet("fleet")
            self.assertEqual((fleet["bags"][0]["state"], fleet["bags"][0]["warning"],
                              fleet["were_there"]), ("passed", warning, were_there))
            self.assertIn(f"one.bag: {warning}\n", out)
            with open(self.path("fleet/index.html")) as file:
                self.assertIn(warning, file.read())
            self.assertFalse(os.path.exists(drawn))
        done = self.records()
        os.rename(script + ".whole", script)
        fleet = self.run_fleet("fleet", code=0)
        self.assertEqual((fleet["bags"][0]["warning"], fleet["were_there"]), ("", 1))
        self.assertEqual(self.records(), done)
        self.assertTrue(os.path.exists(drawn))

    def test_what_cannot_be_written_is_named(self):
        """First a table of the fleet, then what a job writes."""
        self.bag("bags/one.bag")
        full = OSError(errno.ENOSPC, "No space left on device")
        options = self.options("fleet", "--no-report")["args"][1:]
        self.call_tool(options)  # also imports what is replaced below
        with mock.patch("fleet.tables.write_whole", side_effect=full):
            code, _, errors = self.call_tool(options)
        self.assertEqual(code, 2, errors)
        self.assertIn("No space left on device: '" + self.path("fleet/fleet.csv'"),
                      errors.splitlines()[-1])
        job = {"folder": os.getcwd(), "environment": {}, "out": self.path("fleet")}
        with mock.patch("fleet.evaluation.Evaluation", side_effect=full), \
                mock.patch("sys.argv", ["fleet_job.py", json.dumps(job)]), \
                self.assertRaises(SystemExit) as ended:
            runpy.run_path(os.path.join(os.path.dirname(FLEET_TOOL), "fleet_job.py"),
                           run_name="__main__")
        self.assertEqual(ended.exception.code, f'fleet_job.py: {self.path("fleet")}: {full}')

    def assert_usage(self, *words, **change):
        options = self.options("fleet", *change.get("more", ()))
        options["args"][1:2] = change.get("bags", [self.path("bags")])
        code, _, errors = self.call_tool(options["args"][1:])
        self.assertEqual(code, 2, errors)
        for word in words:
            self.assertIn(word, errors.splitlines()[-1])

    def test_bad_usage(self):
        self.assert_usage("no .bag file")
        self.assert_usage("no such file or folder", bags=[self.path("none")])
        self.bag("bags/one.bag")
        self.bag("one.bag")
        self.assert_usage("would both be one.bag", bags=[self.path("bags"), self.path("one.bag")])
        self.assert_usage("--srdf", "no such file", more=["--srdf", self.path("no.srdf")])
        self.assert_usage("--workers", more=["--workers", "0"])
        self.assert_usage("--split-minutes", more=["--split-minutes", "10"])  # of version 0.2
        self.assert_usage("not allowed with", more=["--workers", "1", "--scheduler", "tcp://a:1"])
        for address in ("tcp://127.0.0.1:1", "localhost", "foo://a:1", "tcp://127.0.0.1:x", ""):
            with mock.patch("fleet.dask_run.CONNECT_S", 1):  # nobody will answer
                self.assert_usage(f"--scheduler {address}: ", more=["--scheduler", address])
        with mock.patch("os.scandir", side_effect=PermissionError(13, "Permission denied", "bags")):
            self.assert_usage("bags: Permission denied, so bags may be missing")
        self.assert_usage("needs --baseline", more=["--allow", self.text("allow.yaml", "[]")])
        self.assert_usage("no run of evaluate_bags", more=["--baseline", self.path("bags")])

    def test_without_dask(self):
        self.environment = {"PYTHONPATH": self.folder}
        self.text("distributed.py", "raise ImportError('No module named distributed')")
        done = subprocess.run(**self.options("fleet"), check=False)
        self.assertEqual(done.returncode, 2, done)
        self.assertIn("install python3-distributed, ", done.stderr)
        self.assertNotIn("Traceback", done.stderr)

    def test_without_a_home(self):
        errors = io.StringIO()
        with mock.patch("os.path.expanduser", lambda path: path), \
                contextlib.redirect_stderr(errors), self.assertRaises(SystemExit) as ended:
            self.call_tool(["--help"])
        self.assertEqual(ended.exception.code, 2)
        self.assertRegex(errors.getvalue(), r"\Aevaluate_bags: this account has no home[^\n]*\n\Z")

    def test_every_option_of_evaluate_bag_passes(self):
        texts = [subprocess.run([tool, "--help"], stdout=subprocess.PIPE, check=True,
                                universal_newlines=True).stdout for tool in (TOOL, FLEET_TOOL)]
        single, fleet = (set(re.findall(r"(?<![\w-])--[a-z][a-z-]+", text)) for text in texts)
        self.assertEqual(single - fleet, {"--version"})


if __name__ == "__main__":
    main()
