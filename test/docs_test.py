#!/usr/bin/env python3
"""The site that config/docs/Doxyfile makes: without a warning, with all pages and all that others
see."""
import glob
import os
import re
import subprocess
import tempfile
import unittest

SOURCE_DIR = os.environ["DCM_SOURCE_DIR"]
INCLUDE_DIR = os.path.join(os.environ["DCM_BINARY_DIR"], "devel", "include",
                           "deformable_contact_monitor")
PACKAGES = os.path.join(os.environ["DCM_BINARY_DIR"], "devel", "lib", "python3", "dist-packages")
WITHOUT_A_PAGE = {"core/export.h", "core/host_device.h"}  # macros


def doxyfile():
    with open(os.path.join(SOURCE_DIR, "config", "docs", "Doxyfile")) as file:
        return file.read()


def public_headers():
    headers = set()
    for room in ("core", "cuda", "reader"):
        for folder, _, files in os.walk(os.path.join(INCLUDE_DIR, room)):
            headers |= {os.path.relpath(os.path.join(folder, name), INCLUDE_DIR) for name in files}
    return headers - WITHOUT_A_PAGE


class Docs(unittest.TestCase):

    def test_every_public_header_is_named(self):
        named = set(re.findall(r"(?:src/)?((?:core|cuda|reader)/\S+\.h)", doxyfile()))
        self.assertEqual(named, public_headers())

    def test_pages_without_a_warning(self):
        with tempfile.TemporaryDirectory() as folder:
            settings = doxyfile() + f"OUTPUT_DIRECTORY = {folder}\n"
            env = dict(os.environ, PYTHONPATH=PACKAGES)
            done = subprocess.run(["doxygen", "-"], input=settings, cwd=SOURCE_DIR, env=env,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                                  universal_newlines=True)
            self.assertEqual(done.returncode, 0, done.stdout)
            pages = {}
            for name in os.listdir(os.path.join(folder, "html")):
                if name.endswith(".html"):
                    with open(os.path.join(folder, "html", name), errors="replace") as file:
                        pages[name] = file.read()
            for name, page in pages.items():
                for picture in re.findall(r'<img src="([^":]+)"', page):
                    self.assertTrue(os.path.exists(os.path.join(folder, "html", picture)),
                                    f"{name}: {picture}")
        start = pages["index.html"]
        for name in os.listdir(os.path.join(SOURCE_DIR, "config", "docs")):
            if name.endswith(".md") and name != "main_page.md":
                self.assertIn(f'"config_docs_{name[:-3]}.html"', start)
        self.assertLess(start.index("config_docs_start"), start.index("msg_README"))
        prefix = "structdeformable__contact__monitor_1_1"
        messages = [name[:-4] for name in os.listdir(os.path.join(SOURCE_DIR, "msg"))
                    if name.endswith(".msg")]
        self.assertGreater(len(messages), 9)
        for message in messages:
            self.assertIn(f"{prefix}{message}.html", pages)
        self.assertIn("touched since the pair", pages[prefix + "ContactState.html"])
        self.assertIn("ids count up from 0", pages["classdeformable__contact__monitor_1_1Scene.html"])
        python = pages["classdeformable__contact_1_1Scene.html"]
        self.assertIn("add_body", python)
        if glob.glob(os.path.join(PACKAGES, "deformable_contact", "_core*")):
            self.assertIn("(n, 3)", python, "docstrings")


if __name__ == "__main__":
    unittest.main()
