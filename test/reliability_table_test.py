#!/usr/bin/env python3
"""The table "Failures that users hit" in README.md: every test that it names exists and is run."""
import os
import re
import unittest

TEST_DIR = os.path.dirname(os.path.abspath(__file__))
FAILURES = 36


def text_of(*path):
    with open(os.path.join(TEST_DIR, *path)) as file:
        return file.read()


def rows():
    """The cells of each row."""
    table = text_of("README.md").split("## Failures that users hit\n")[1].split("\n## ")[0]
    lines = [line for line in table.splitlines() if line.startswith("| ")][1:]
    return [[cell.strip() for cell in line.strip("|").split(" | ")] for line in lines]


def tests_of(cell):
    """(file, name) of each test in a cell like "`a_test.cpp` Name, Name; `b.py` test_name"."""
    for entry in cell.split("; "):
        match = re.fullmatch(r"`(\S+)` (\w+(?:, \w+)*)", entry)
        if not match:
            raise AssertionError(f"no file with its tests: {entry!r}")
        for name in match.group(2).split(", "):
            yield match.group(1), name


def is_run(path):
    """Whether a CMakeLists.txt on the way to the file adds it; of a rostest, the script's name."""
    folder, stem = os.path.dirname(path), os.path.splitext(os.path.basename(path))[0]
    while True:
        cmake = os.path.join(folder, "CMakeLists.txt")
        if os.path.exists(os.path.join(TEST_DIR, cmake)) and \
                re.search(rf"\b{stem}\b", text_of(cmake)):
            return True
        if not folder:
            return False
        folder = os.path.dirname(folder)


class ReliabilityTable(unittest.TestCase):

    def test_every_row_has_its_parts(self):
        self.assertEqual(len(rows()), FAILURES)
        for row in rows():
            self.assertEqual(len(row), 3, row)
            self.assertTrue(all(row), row)

    def test_every_test_that_it_names_exists(self):
        for row in rows():
            for path, name in tests_of(row[2]):
                with self.subTest(failure=row[0], test=f"{path} {name}"):
                    self.assertTrue(is_run(path), "no CMakeLists.txt adds that file")
                    python, gtest = rf"def {name}\(", rf"^TEST(_F|_P)?\(\w+, {name}\)"
                    pattern = python if path.endswith(".py") else gtest
                    found = re.search(pattern, text_of(path), re.MULTILINE)
                    self.assertTrue(found, "no test of that name there")


if __name__ == "__main__":
    unittest.main()
