#!/usr/bin/env python3
"""The package as a whole: its stubs, docstrings, imports, and the example."""
import ast
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

import deformable_contact
from deformable_contact import _core

SOURCE = pathlib.Path(os.environ["DCM_SOURCE_DIR"]) / "src/python"
FOLDER = pathlib.Path(deformable_contact.__file__).parent


def run_python(code, **environment):
    return subprocess.run([sys.executable, "-c", code], stdout=subprocess.PIPE,
                          stderr=subprocess.STDOUT, universal_newlines=True, check=False,
                          env=dict(os.environ, **environment))


def arguments_of(function):
    """(name, default) of each, without self, and whether it is by keyword only."""
    given = function.args
    defaults = [None] * (len(given.args) - len(given.defaults)) + given.defaults
    named = [(argument.arg, default, False) for argument, default in zip(given.args, defaults)]
    named += [(argument.arg, default, True)
              for argument, default in zip(given.kwonlyargs, given.kw_defaults)]
    return [(name, default and ast.literal_eval(default), by_keyword)
            for name, default, by_keyword in named if name != "self"]


# pybind11 before 2.6 has no arguments by keyword only.
KEYWORDS_ONLY = "*, device" in deformable_contact.Detector.__init__.__doc__


def as_built(arguments):
    """What the stub says, with keywords as this build has them."""
    return [(name, default, by_keyword and KEYWORDS_ONLY)
            for name, default, by_keyword in arguments]


def signature_of(value):
    """As pybind11 writes it into the docstring's first line."""
    line = re.sub(r" -> .*", "", value.__doc__.splitlines()[0])
    return ast.parse("def %s: pass" % line).body[0]


class Stubs(unittest.TestCase):

    def setUp(self):
        self.stub = ast.parse((FOLDER / "__init__.pyi").read_text())
        self.classes = {node.name: node for node in self.stub.body
                        if isinstance(node, ast.ClassDef)}
        if not hasattr(_core, "Robot"):
            del self.classes["Robot"]
        self.functions = {node.name: node for node in self.stub.body
                          if isinstance(node, ast.FunctionDef)}

    def test_names_are_those_of_the_module(self):
        public = {name for name in vars(_core) if not name.startswith("_")}
        self.assertEqual(set(self.classes) | set(self.functions), public)
        self.assertEqual(public - {"Robot"} | {"__version__"}, set(deformable_contact.__all__))
        if "Robot" not in public:
            with self.assertRaisesRegex(AttributeError, "Robot needs a build with ROS"):
                deformable_contact.Robot
        for name, stub in self.classes.items():
            members = {name for name in vars(getattr(_core, name)) if not name.startswith("_")}
            self.assertEqual({node.name for node in stub.body} - {"__init__"}, members, name)

    def test_properties_and_arguments_are_those_of_the_module(self):
        checked = 0
        for name, stub in self.classes.items():
            for node in stub.body:
                value = getattr(getattr(_core, name), node.name)
                self.assertEqual(bool(node.decorator_list), isinstance(value, property), node.name)
                if not isinstance(value, property) and (name, node.name) != ("Result", "__init__"):
                    self.assertEqual(as_built(arguments_of(node)),
                                     arguments_of(signature_of(value)), node.name)
                    checked += 1
        self.assertEqual(arguments_of(self.functions["read_mesh"]),
                         arguments_of(signature_of(_core.read_mesh)))
        self.assertEqual(checked, 26 if "Robot" in self.classes else 23)

    def test_everything_public_has_a_docstring(self):
        for name in self.functions:
            self.assertIn("\n\n", getattr(_core, name).__doc__, name)
        for name, stub in self.classes.items():
            self.assertTrue(getattr(_core, name).__doc__, name)
            for node in stub.body:
                text = getattr(getattr(_core, name), node.name).__doc__
                if not node.decorator_list:  # pybind11's own line is no docstring
                    text = text.partition("\n")[2]
                self.assertTrue(text.strip(), node.name)

    def test_the_package_is_typed(self):
        for name in "py.typed", "__init__.pyi", "messages.pyi":
            self.assertTrue((FOLDER / name).exists(), name)


class Imports(unittest.TestCase):

    def test_without_ros(self):
        done = run_python(
            "import sys\n"
            "for name in 'rospy', 'genpy', 'deformable_contact_monitor': sys.modules[name] = None\n"
            "import deformable_contact, deformable_contact.messages as messages\n"
            "assert 'deformable_contact._core' not in sys.modules\n"
            "assert messages.GEOMETRY.itemsize == 41\n"
            "try: messages.ContactArray\n"
            "except ImportError: pass\n"
            "else: raise SystemExit('no error')\n"
            "deformable_contact.Detector('cpu').detect(deformable_contact.Scene())\n",
            PYTHONWARNINGS="ignore")
        self.assertEqual((done.returncode, done.stdout), (0, ""))

    def test_without_a_device(self):
        done = run_python(
            "from deformable_contact import Detector, Scene\n"
            "detector = Detector()\n"
            "print(detector.detect(Scene()).backend, bool(detector.backend_problem))\n"
            "print(Detector('cpu').backend_problem == '')\n"
            "try: Detector('cuda')\n"
            "except RuntimeError as error: print(error)\n", CUDA_VISIBLE_DEVICES="",
            PYTHONWARNINGS="ignore")
        self.assertRegex(done.stdout, r"\Acpu True\nTrue\n[^\n]*CUDA[^\n]*\n\Z")

    def test_names(self):
        self.assertRegex(deformable_contact.__version__, r"\A\d+\.\d+\.\d+\Z")
        self.assertIn("Detector", dir(deformable_contact))
        self.assertEqual(deformable_contact.Scene.__module__, "deformable_contact")
        with self.assertRaisesRegex(AttributeError, "has no attribute 'Scenes'"):
            deformable_contact.Scenes
        with self.assertRaisesRegex(AttributeError, "has no attribute 'Contacts'"):
            from deformable_contact import messages
            messages.Contacts

    @unittest.skipUnless(KEYWORDS_ONLY, "pybind11 is older than 2.6")
    def test_options_are_keywords(self):
        with self.assertRaises(TypeError):
            deformable_contact.Detector("cpu", 0)


class Example(unittest.TestCase):

    FOLD = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 2 0\nf 1 2 3\nf 2 1 4\n"
    PIERCING = "v 0.2 0.2 -1\nv 0.2 0.2 1\nv 0.2 2 1\nf 1 2 3\n"

    def run_example(self, *arguments):
        return subprocess.run(
            [sys.executable, str(SOURCE / "examples/find_contacts.py"), *arguments],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, universal_newlines=True, check=False,
            env=dict(os.environ, MPLBACKEND="Agg", MPLCONFIGDIR=self.folder))

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.meshes = []
        for name, text in ("fold.obj", self.FOLD), ("piercing.obj", self.PIERCING):
            self.meshes.append(os.path.join(folder.name, name))
            pathlib.Path(self.meshes[-1]).write_text(text)

    def test_two_meshes_as_a_picture(self):
        picture = os.path.join(self.folder, "contacts.png")
        done = self.run_example(*self.meshes, "--plot", picture)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("2 contacts, complete", done.stdout)
        self.assertEqual(pathlib.Path(picture).read_bytes()[:8], b"\x89PNG\r\n\x1a\n")

    def test_one_mesh_with_itself(self):
        done = self.run_example(self.meshes[0])
        self.assertIn("1 contacts, complete", done.stdout)
        done = self.run_example(os.path.join(self.folder, "none.obj"))
        self.assertEqual(done.returncode, 2)
        self.assertRegex(done.stderr, r"\Afind_contacts: [^\n]*none.obj[^\n]*\n\Z")


if __name__ == "__main__":
    unittest.main()
