#!/usr/bin/env python3
"""Tests that parameters are documented once: config/contact_monitor.yaml agrees with what the node
reads (names, defaults, ranges, choices), and the tables of config/README.md are made from it."""
import importlib.machinery
import importlib.util
import os
import re
import subprocess
import sys
import unittest
from xml.etree import ElementTree

SOURCE_DIR = os.environ.get("DCM_SOURCE_DIR") or os.path.dirname(
    os.path.dirname(os.path.abspath(__file__)))
SCRIPT = os.path.join(SOURCE_DIR, "config", "parameter_table")
# One call of a ParameterReader function with a literal name. Those of `entry` read keys of maps.
CALL = re.compile(r'reader(?:->|\.)(\w+)\(\s*"(\w+)"([^;]*?)\)[);]', re.DOTALL)
# problems(Options) checks these, and a test of it the ranges.
CHECKED_ELSEWHERE = {"clusters", "iterations", "refresh_period", "threads"}


def text_of(*path):
    with open(os.path.join(SOURCE_DIR, *path)) as file:
        return file.read()


def load_script():
    sys.dont_write_bytecode = True
    loader = importlib.machinery.SourceFileLoader("parameter_table", SCRIPT)
    spec = importlib.util.spec_from_loader("parameter_table", loader)
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


def documented():
    """{name: (default, range)} of the YAML file."""
    script = load_script()
    return {name: (default, script.split(name, comment)[1])
            for _, name, default, comment in script.parameters()}


def constants(source):
    """{name: number} of the constants in a C++ file."""
    found = re.findall(r"constexpr \w+ (\w+) = (\d+)( << (\d+))?;", source)
    return {name: int(value) << int(shift or 0) for name, value, _, shift in found}


def read_by_node():
    """{name: (function, arguments)} of parameters.cpp, and the constants that they may use."""
    source = text_of("src", "monitor", "rules", "parameters.cpp")
    found = {name: (function, arguments) for function, name, arguments in CALL.findall(source)
             if function not in ("addProblem", "has")}
    for name in re.findall(r'frame\(&reader, "(\w+)"', source):
        found[name] = ("text", "")
    shared = text_of("src", "monitor", "rules", "part_parameters.h")
    return found, constants(source + shared)


class ParameterTable(unittest.TestCase):

    def test_readme_has_the_tables_that_the_script_prints(self):
        printed = subprocess.run([sys.executable, "-B", SCRIPT], stdout=subprocess.PIPE, check=True,
                                 universal_newlines=True).stdout
        readme = text_of("config", "README.md")
        script = load_script()
        self.assertEqual(readme.count(script.BEGIN), 1)
        self.assertEqual(readme.count(script.END), 1)
        found = readme.split(script.BEGIN)[1].split(script.END)[0]
        self.assertEqual(found.strip(), printed.strip(),
                         "config/README.md is out of date: run config/parameter_table --write")

    def test_the_node_reads_what_is_documented_and_nothing_else(self):
        read, _ = read_by_node()
        self.assertGreater(len(read), 40)
        self.assertEqual(sorted(read), sorted(documented()))

    def test_ranges_and_choices_are_those_of_the_node(self):
        read, values = read_by_node()
        compared = 0
        for name, (function, arguments) in read.items():
            _, documented_range = documented()[name]
            with self.subTest(parameter=name):
                if function == "choice":
                    choices = re.findall(r'"(\w+)"', arguments)
                    self.assertEqual(documented_range.split(", "), choices)
                    compared += 1
                elif function == "flag":
                    self.assertEqual(documented_range, "true, false")
                elif function in ("number", "numbers", "integer", "integers") and \
                        name not in CHECKED_ELSEWHERE:
                    low, high = [values.get(end, end) for end in
                                 re.split(r",\s*", arguments.strip())[-2:]]
                    unbounded = name == "max_contacts"  # bounded by what an int holds
                    expected = f">= {low}" if unbounded else f"[{low}, {high}]"
                    self.assertIn(expected, documented_range)
                    compared += 1
        self.assertGreater(compared, 25)

    def test_defaults_are_those_of_the_node(self):
        fields = text_of("src", "monitor", "rules", "parameters.h") + \
            text_of("src", "core", "options.h")
        compared = 0
        for name, (function, arguments) in read_by_node()[0].items():
            default, _ = documented()[name]
            field = re.match(r",\s*(?:p->|o\.)(\w+),", arguments)
            with self.subTest(parameter=name):
                if function == "choice":
                    first = re.search(r'"(\w+)"', arguments).group(1)
                    self.assertTrue(arguments.rstrip().endswith(", 0"), arguments)
                    self.assertEqual(default, first)
                    compared += 1
                elif field:
                    value = re.search(rf"\b{field.group(1)} = ([^;,]+)[;,]", fields).group(1)
                    if function in ("number", "integer"):
                        self.assertEqual(float(default), float(value.rstrip("F")))
                    elif value != "kSrdfAuto":
                        self.assertEqual(default, value.strip('"'))
                    compared += 1
        self.assertGreater(compared, 25)

    def test_every_link_leads_to_a_file_or_heading(self):
        for line in subprocess.run([sys.executable, "-B", SCRIPT], stdout=subprocess.PIPE,
                                   check=True, universal_newlines=True).stdout.splitlines():
            for path, anchor in re.findall(r"\]\(([^)#]*)(?:#([^)]+))?\)", line):
                self.assertTrue(os.path.exists(os.path.join(SOURCE_DIR, "config", path)), path)
                if anchor and not path:
                    headings = re.findall(r"^#+ (.*)$", text_of("config", "README.md"), re.M)
                    self.assertIn(anchor, [h.lower().replace(" ", "-") for h in headings])


class Launch(unittest.TestCase):

    def test_nothing_remains_of_an_earlier_start(self):
        """roslaunch deletes the private parameters of nodes with clear_params before it sets any."""
        nodes = [node for name in os.listdir(os.path.join(SOURCE_DIR, "launch"))
                 if name.endswith(".launch")
                 for node in ElementTree.fromstring(text_of("launch", name)).iter("node")
                 if node.get("type") in ("contact_monitor", "contact_guard", "nodelet")]
        self.assertEqual(len(nodes), 5)
        for node in nodes:
            self.assertEqual(node.get("clear_params"), "true", node.attrib)


if __name__ == "__main__":
    unittest.main()
