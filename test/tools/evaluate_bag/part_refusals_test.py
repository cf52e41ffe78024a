#!/usr/bin/env python3
"""evaluate_bag in parts: records that do not go together, and bad usage, are refused."""
import os

from evaluation_case import CONFIG, main
from parts_case import SWEPT, PartsCase


class PartRefusals(PartsCase):

    def assert_no_join(self, arguments, files, *wanted):
        done = self.tool(*arguments, "--out", self.path("joined"), "--join", *files)
        self.assertEqual(done.returncode, 2, done)
        last = done.stderr.splitlines()[-1]
        self.assertRegex(last, r"\Aevaluate_bag: [^\n]+\Z")
        for words in wanted:
            self.assertIn(words, last)
        self.assertFalse(os.path.exists(self.path("joined/summary.json")))
        self.assertFalse(os.path.exists(self.path("joined/frames.csv")))

    def changed(self, path, change):
        """A copy of the file with other lines."""
        with open(path) as file:
            lines = file.read().splitlines(keepends=True)
        return self.text("changed.records", "".join(change(lines)))

    def test_records_that_do_not_go_together_are_refused(self):
        arguments = self.arguments(CONFIG)
        one, two, three = self.write_parts(3, arguments)
        half, = self.write_parts(2, arguments)[1:]
        self.assert_no_join(arguments, [one, three], three, "part 2/3 is missing")
        self.assert_no_join(arguments, [one, two], two, "part 3/3 is missing")
        self.assert_no_join(arguments, [one, two, two, three], two, "part 2/3 is there twice")
        self.assert_no_join(arguments, [one, half], half, "part 2/2 does not go with part 1/3")
        self.assert_no_join(arguments, [one, two, self.path("none")], "none: cannot be read")
        self.assert_no_join(arguments, [one, two, self.config_file], "no records of evaluate_bag")
        self.assert_no_join(self.arguments(CONFIG + SWEPT), [one, two, three], one,
                            "records of other configuration")
        self.assert_no_join([*self.arguments(CONFIG), "--predicates", "conservative"],
                            [one, two, three], one, "records of other runs")
        self.assert_no_join(self.arguments(CONFIG, self.bag("short.bag", self.events[:-2])),
                            [one, two, three], one, "records of other bags")
        arguments = self.arguments(CONFIG)
        moved = self.bag("moved.bag", self.touching({1, 2, 3}))
        self.assert_no_join(self.arguments(CONFIG, moved), [one, two, three], one,
                            "has the contacts of another scene at cycle 1 ")
        for change, words in (
                (lambda lines: lines[:-1], "cut off"),
                (lambda lines: lines[:-1] + [lines[-1][:-3]], "cut off"),
                (lambda lines: lines[:2] + lines[3:], "has another cycle in place of cycle 8 "),
                (lambda lines: lines[:2] + [lines[2][:-9] + "\n"] + lines[3:], "no JSON"),
                (lambda lines: [lines[0].replace('"version":"', '"version":"9'), *lines[1:]],
                 "another version"),
                (lambda lines: [lines[0].replace('["cpu"]', '["cuda"]'), *lines[1:]],
                 "another backend"),
                (lambda lines: [line.replace('"contacts":[', '"contacts":[99999,')
                                for line in lines], "is damaged: "),
                (lambda lines: [line.replace('"left_out":', '"left":') for line in lines],
                 "is damaged: ")):
            with self.subTest(words=words):
                wrong = self.changed(two, change)
                self.assert_no_join(arguments, [one, wrong, three], wrong, words)
        wrong = self.changed(three, lambda lines: lines[:-1] + [lines[-2]] + lines[-1:])
        self.assert_no_join(arguments, [one, two, wrong], wrong, "goes on behind")
        wrong = self.changed(three, lambda lines: lines[:-2] + lines[-1:])
        self.assert_no_join(arguments, [one, two, wrong], wrong, "ends before cycle 20 ")

    def test_bad_usage(self):
        records = self.path("records")
        for words, wanted in (
                (["--part", "1/2"], "--records"), (["--records", records], "--part"),
                (["--part", "3/2", "--records", records], "--part: 3/2 is not"),
                (["--part", "0/2", "--records", records], "--part: 0/2 is not"),
                (["--part", "2", "--records", records], "--part: 2 is not"),
                (["--part", "1/2x", "--records", records], "--part: 1/2x is not"),
                (["--part", "1/2", "--records", records, "--join", records], "--join"),
                (["--part", "1/2", "--records", records, "--predicates", "fast"],
                 "auto fast finds depends"),
                (["--part", "1/2", "--records", records, "--overlaps", "0.5"],
                 "overlap 0.5 finds depends"),
                (["--part", "1/2", "--records", records, "--backends", "fcl"], "fcl finds depends"),
                (["--part", "1/2", "--records", self.path("no/folder")], "no/folder")):
            with self.subTest(words=words):
                done = self.tool(*self.arguments(CONFIG), *words)
                self.assertEqual(done.returncode, 2, done)
                self.assertIn(wanted, done.stderr.splitlines()[-1])
                self.assertFalse(os.path.exists(records))


if __name__ == "__main__":
    main()
