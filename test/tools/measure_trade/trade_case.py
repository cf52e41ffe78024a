"""What the tests of measure_trade share: a waving cloth that sinks through a floor and a post, and
the tool, $MEASURE_TRADE."""
import csv
import json
import math
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

TOOL = os.environ["MEASURE_TRADE"]
SOURCE = pathlib.Path(__file__).resolve().parents[3]
DATA = pathlib.Path(os.environ.get("DCM_TEST_DATA") or SOURCE / "../shared/data")
PARAMETERS = SOURCE / "config/contact_monitor.yaml"

FLOOR = "v -9 -9 0\nv 9 -9 0\nv 0 9 0\nf 1 2 3\n"
POST = "v 0.5 0.5 -3\nv 0.52 0.5 -3\nv 0.5 0.5 0.4\nf 1 2 3\n"
ABOVE = "v 0 0 50\nv 1 0 50\nv 0 1 50\nf 1 2 3\n"
SETTING = ("backend", "predicates", "overlap", "clusters", "fuzzifier", "iterations",
           "refresh_period")


def quick(**changes):
    """Options for a few settings and cycles, so that a run takes no time."""
    options = {"clusters": "0,6", "overlaps": "0,1", "predicates": "exact,conservative",
               "fuzzifiers": "2", "iterations": "1,0", "refresh_periods": "1", "cycles": "4",
               "warm_up": "1", "repeats": "1"}
    options.update(changes)
    return [word for name, value in options.items()
            for word in ("--" + name.replace("_", "-"), value)]


def cloth(height, n=12):
    step = 1 / n
    lines = [f"v {i * step} {j * step} {height + 0.1 * math.sin(9 * i * step + 4 * j * step)}"
             for i in range(n + 1) for j in range(n + 1)]
    for i in range(n):
        for j in range(n):
            a = i * (n + 1) + j + 1
            lines += [f"f {a} {a + n + 1} {a + n + 2}", f"f {a} {a + n + 2} {a + 1}"]
    return "\n".join(lines) + "\n"


class Case(unittest.TestCase):

    @classmethod
    def setUpClass(cls):
        """Copies the tool without the scripts beside it that draw plots: they take far longer than
        the measurements, so only tests of plots run the tool in its place."""
        folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, folder)
        cls.tool_without_plots = shutil.copy(TOOL, folder)

    def setUp(self):
        self.folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, self.folder)

    def path(self, *names):
        return os.path.join(self.folder, *names)

    def mesh(self, name, content):
        with open(self.path(name), "w") as file:
            file.write(content)
        return self.path(name)

    def sinking(self):
        """Onto the post from the second state on, onto the floor in the third and fourth."""
        return [self.mesh(f"cloth_{i}.obj", cloth(height))
                for i, height in enumerate((1, 0.3, 0.05, -0.05))]

    def run_tool(self, *arguments, plots=False, **options):
        tool = TOOL if plots else self.tool_without_plots
        return subprocess.run([tool, *arguments], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                              text=True, check=False, cwd=self.folder, **options)

    def works(self, *arguments, **options):
        done = self.run_tool(*arguments, **options)
        self.assertEqual(done.returncode, 0, done)
        return done

    def table(self, name, out="trade"):
        with open(self.path(out, name), newline="") as file:
            return list(csv.DictReader(file))

    def summary(self, out="trade"):
        with open(self.path(out, "summary.json")) as file:
            return json.load(file)

    def assert_refused(self, arguments, *wanted, **options):
        done = self.run_tool(*arguments, **options)
        self.assertEqual(done.returncode, 2, done)
        self.assertRegex(done.stderr, r"\Ameasure_trade: [^\n]+\n\Z")
        self.assertEqual(done.stdout, "")
        for words in wanted:
            self.assertIn(words, done.stderr)

    def scene(self):
        return [*self.sinking(), "--against", self.mesh("floor.obj", FLOOR),
                self.mesh("post.obj", POST), self.mesh("far.obj", ABOVE)]
