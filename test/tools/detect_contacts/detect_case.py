"""What the tests of detect_contacts share: small meshes, and the tool, $DETECT_CONTACTS."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

TOOL = os.environ["DETECT_CONTACTS"]
SOURCE = pathlib.Path(__file__).resolve().parents[3]
DATA = pathlib.Path(os.environ.get("DCM_TEST_DATA") or SOURCE / "../shared/data")

# A triangle in the plane z = 0, one that pierces it, one that touches its corner, one far off.
FLOOR = "v 0 0 0\nv 4 0 0\nv 0 4 0\nf 1 2 3\n"
PIERCING = "v 9 9 9\nv 9 8 9\nv 8 9 9\nv 1 1 -1\nv 1 1 1\nv 1 2 1\nf 1 2 3\nf 4 5 6\n"
TOUCHING = "v 4 0 0\nv 5 0 0\nv 5 0 1\nf 1 2 3\n"
ABOVE = "v 0 0 2\nv 4 0 2\nv 0 4 2\nf 1 2 3\n"


class Case(unittest.TestCase):
    """With a folder of its own."""

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def mesh(self, name, content):
        with open(self.path(name), "w") as file:
            file.write(content)
        return self.path(name)

    def run_tool(self, *arguments, **options):
        return subprocess.run([TOOL, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, errors="replace", check=False, **options)

    def works(self, *arguments):
        done = self.run_tool(*arguments)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done

    def pairs(self, *arguments):
        return self.works("--pairs", "-", *arguments).stdout

    def json(self, *arguments):
        return json.loads(self.works("--json", "-", *arguments).stdout)

    def assert_refused(self, arguments, *wanted, **options):
        done = self.run_tool(*arguments, **options)
        self.assertEqual(done.returncode, 2, done)
        self.assertRegex(done.stderr, r"\Adetect_contacts: [^\n]+\n\Z")
        for words in wanted:
            self.assertIn(words, done.stderr)
        return done
