#!/usr/bin/env python3
"""When an earlier result still holds, and what a record says, with another evaluate_bag: a script
that names the meshes it is told to."""
import json
import os
import pathlib
import sys
import tempfile
import unittest
from unittest import mock

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[3] / "src/tools/evaluate_bags"))
from fleet.evaluation import Evaluation
from fleet.identity import resolved

TOOL = """#!/bin/sh
[ "$1" = --version ] && echo 1 && exit
here=$(dirname "$0")
while [ "$1" != --out ]; do shift; done
cp "$here/summary.json" "$here/pairs.csv" "$2"
echo "damaged; what could be read is in $2" >&2
exit $(cat "$here/code")
"""
PACKAGE = "<package><name>arm</name></package>"


class Identity(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        change = mock.patch.dict(os.environ, {"ROS_PACKAGE_PATH": self.path("arm")})
        change.start()
        self.addCleanup(change.stop)
        for name in ("out", "out/attempts", "arm"):
            os.mkdir(self.path(name))
        self.text("arm/package.xml", PACKAGE)
        os.chmod(self.text("tool", TOOL), 0o755)
        self.text("pairs.csv", "cycle,stamp,body_a,triangle_a,body_b,triangle_b\n")
        self.text("a.bag", "")

    def path(self, name):
        return os.path.join(self.folder, name)

    def text(self, name, text):
        with open(self.path(name), "w") as file:
            file.write(text)
        return self.path(name)

    def evaluate(self, source="", code=0):
        links = [{"name": "hand", "source": source}]
        self.text("code", str(code))
        self.text("summary.json", json.dumps({"configuration": {"links": links},
                                              "verdict": "Passed"}))
        return Evaluation({
            "name": "a.bag", "bag": self.path("a.bag"), "out": self.path("out"), "run": "1",
            "attempts": self.path("out/attempts"), "stop": self.path("stop"), "threads": None,
            "tool": self.path("tool"), "arguments": []}).run()

    def was_there(self, source):
        return self.evaluate(source)["was_there"]

    def test_a_changed_mesh_is_noticed(self):
        names = (f"file://{self.folder}/arm/x.stl", f"{self.folder}/arm/x.stl",
                 f"file://localhost{self.folder}/arm/x.stl", "package://arm/x.stl",
                 f"file://{self.folder}/arm/%78.stl", "package://arm/%78%2estl")
        for name in names:
            source = "box 1 x 1 x 1 m; " + name
            with self.subTest(name):
                self.text("a.bag", name)
                self.text("arm/x.stl", "before")
                self.assertFalse(self.was_there(source))
                self.assertTrue(self.was_there(source))
                self.text("arm/x.stl", "after")
                self.assertFalse(self.was_there(source))
                os.remove(self.path("arm/x.stl"))
                self.assertFalse(self.was_there(source))
                self.assertTrue(self.was_there(source), "it is still missing")

    def test_names_are_those_of_the_resolver(self):
        for name, path in (("/a%20b", "/a%20b"), ("file:///a%20b%", "/a b%"), ("x.stl", "x.stl"),
                           ("/a://b", "/a://b"), ("package://arm//x", self.path("arm//x")),
                           ("package://none/x", None), ("http://host/x", None),
                           ("file://host/x", None), ("file://localhost", None),
                           ("file:///%00", None)):
            self.assertEqual(resolved(name), path, name)

    def test_a_message_names_the_folder_that_stays(self):
        record = self.evaluate(code=2)
        self.assertEqual((record["state"], record["message"]),
                         ("unusable", "damaged; what could be read is in "
                          + self.path("out/bags/a.bag")))
        self.assertTrue(os.path.exists(self.path("out/bags/a.bag/summary.json")))


if __name__ == "__main__":
    unittest.main()
