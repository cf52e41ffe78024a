#!/usr/bin/env python3
"""evaluate_bags with long bags in parts: the tables of single runs, and parts that are done stay
done."""
import glob
import os
import subprocess

from fleet_case import CUT, FAR, WHOLE, FleetCase, main
from panda_bag import FRAMES, PERIOD

# The links come a second before the scene.
PARTS = 3
MINUTES = (1 + FRAMES * PERIOD.to_sec()) / 60 / PARTS * 1.1


class FleetParts(FleetCase):

    def run_in_parts(self, out, *more, code):
        return self.run_fleet(out, "--pairs", "--no-report", "--split-minutes", str(MINUTES), *more,
                              code=code)

    def parts(self, out="fleet"):
        return [path for path in glob.glob(self.path(out + "/parts/**"), recursive=True)
                if os.path.isfile(path)]

    def test_parts_are_like_single_runs(self):
        self.write_bags()
        log = self.path("log")
        self.fake_tool(f'*.bag) echo "$*" >>{log};;')
        fleet = self.run_in_parts("fleet", code=2)
        self.assertEqual(self.states(fleet),
                         {CUT: "refused", FAR: "broken", **dict.fromkeys(WHOLE, "passed")})
        with open(log) as file:
            calls = file.read().splitlines()
        for name in (FAR, *WHOLE):
            of_bag = [call for call in calls if f"bags/{name} " in call]
            self.assertEqual(sum("--join" in call for call in of_bag), 1, of_bag)
            self.assertGreater(sum("--part" in call for call in of_bag), 1)
            self.assertEqual(sum("--out" in call for call in of_bag), 1, of_bag)
        self.assert_like_single_runs("fleet", (FAR, *WHOLE))
        self.assertFalse(os.path.exists(self.path("fleet/parts")))

        again = self.run_in_parts("fleet", code=2)
        self.assertEqual({bag["bag"] for bag in again["bags"] if bag["was_there"]}, {FAR, *WHOLE})
        # In parts or in one, it is the same result.
        again = self.run_fleet("fleet", "--pairs", "--no-report", "--split-minutes", "0", code=2)
        self.assertEqual(again["were_there"], 1 + len(WHOLE))

    def test_stopped_it_keeps_parts(self):
        self.bag("bags/one.bag")
        log, asleep = self.path("log"), self.path("asleep")
        count = f'*.bag) echo "$*" >>{log}; '
        self.fake_tool(count + 'case "$*" in *"--part 3/"*) '
                       f"echo here >{asleep}; tail -f {asleep};; esac;;")
        running = self.start_fleet("fleet", "--workers", "1", "--no-report", "--pairs",
                                   "--split-minutes", str(MINUTES))
        self.stop_once(running, asleep)
        self.assertEqual(len(self.parts()), 2)

        os.remove(log)
        self.fake_tool(count + ";;")
        self.run_in_parts("fleet", code=0)
        with open(log) as file:
            calls = file.read()
        self.assertNotIn("--part 1/", calls, "what was done was done again")
        self.assertNotIn("--part 2/", calls)
        self.assertIn("--part 3/", calls)
        self.assert_like_single_runs("fleet", ["one.bag"])
        self.assertEqual(self.parts(), [])

    def test_what_cannot_be_had_in_parts_is_evaluated_in_one(self):
        """Predicates that depend on earlier cycles; a part that crashes; parts of other meshes."""
        self.bag("bags/one.bag")
        self.run_in_parts("fast", "--predicates", "fast", code=0)
        self.fake_tool('*.bag) case "$*" in *"--part 2/"*) kill -SEGV $$;; esac;;')
        self.run_in_parts("crash", code=0)
        self.assert_like_single_runs("crash", ["one.bag"])
        self.fake_tool('*.bag) case "$*" in *--join*) echo no >&2; exit 2;; esac;;')
        self.run_in_parts("join", code=0)
        self.assert_like_single_runs("join", ["one.bag"])
        for out in ("fast", "crash", "join"):
            self.assertEqual(self.parts(out), [])

    def test_progress_counts_parts(self):
        self.bag("bags/one.bag")
        self.fake_tool('*.bag) case "$*" in *"--part 2/"*) sleep 6;; esac;;')
        options = self.options("fleet", "--workers", "1", "--no-report", "--split-minutes",
                               str(MINUTES))
        done = subprocess.run(**options, timeout=300, check=False)
        self.assertRegex(done.stderr, rf"0 of 1 bags, 1 of {PARTS} parts, ")


if __name__ == "__main__":
    main()
