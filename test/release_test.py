#!/usr/bin/env python3
"""What a release says of itself: one version everywhere, and pages that exist where they are named."""
import datetime
import os
import re
import subprocess
import unittest
from xml.etree import ElementTree

import yaml

SOURCE = os.environ.get("DCM_SOURCE_DIR") or os.path.dirname(os.path.dirname(os.path.abspath(__file__)))
BUILD = os.environ.get("DCM_BINARY_DIR")


def text_of(*path):
    with open(os.path.join(SOURCE, *path)) as file:
        return file.read()


def anchors(page):
    """The anchors of a page's headings, as code hosts make them; and "" for its top."""
    found = {""}
    for heading in re.findall(r"^#+ (.*)$", text_of(page), re.MULTILINE):
        words = re.sub(r"[^\w\- ]", "", heading.lower())
        found.add(words.replace(" ", "-"))
    return found


class Release(unittest.TestCase):

    def setUp(self):
        self.version = re.search(r"^project\(\w+ VERSION (\S+) ", text_of("CMakeLists.txt"), re.M)[1]

    def test_package_xml(self):
        package = ElementTree.fromstring(text_of("package.xml"))
        self.assertEqual(package.findtext("version"), self.version)

    def test_sections_of_the_change_log(self):
        """The newest is this version's, or what comes after it; each older one has an earlier date."""
        titles = re.findall(r"^(\S.*)\n-+$", text_of("CHANGELOG.rst"), re.MULTILINE)
        if titles[0] == "Forthcoming":
            del titles[0]
        versions, dates = zip(*(re.fullmatch(r"(\d+\.\d+\.\d+) \((\S+)\)", t).groups() for t in titles))
        self.assertEqual(versions[0], self.version)
        for values in ([tuple(map(int, v.split("."))) for v in versions],
                       [datetime.datetime.strptime(d, "%Y-%m-%d") for d in dates]):
            self.assertEqual(values, sorted(values, reverse=True))

    @unittest.skipUnless(BUILD, "there is no build")
    def test_what_was_built(self):
        """outside_test looks at the names of the libraries."""
        with open(os.path.join(BUILD, "CMakeCache.txt")) as file:
            has_ros = "\nWITH_ROS:BOOL=ON\n" in file.read()
        folder = "devel/lib/deformable_contact_monitor" if has_ros else "src/tools/detect_contacts"
        said = subprocess.run([os.path.join(BUILD, folder, "detect_contacts"), "--version"], check=True,
                              stdout=subprocess.PIPE, universal_newlines=True).stdout
        self.assertEqual(said, "detect_contacts %s\n" % self.version)

    def test_the_citation_names_this_version(self):
        self.assertIn("version = {%s}" % self.version, text_of("README.md"))


class Pages(unittest.TestCase):

    def test_issue_forms(self):
        folder = os.path.join(SOURCE, ".github", "ISSUE_TEMPLATE")
        for name in os.listdir(folder):
            with self.subTest(form=name):
                form = yaml.safe_load(text_of(folder, name))
                self.assertTrue(form["name"] and form["description"])
                ids = [field["id"] for field in form["body"]]
                self.assertEqual(len(ids), len(set(ids)))
                self.assertTrue(all(field["attributes"]["label"] for field in form["body"]))

    def check(self, links, folder=""):
        self.assertGreater(len(links), 5)
        for link in links:
            page, _, anchor = link.partition("#")
            self.assertIn(anchor, anchors(os.path.normpath(os.path.join(folder, page))), link)

    def test_links_of_pages(self):
        for page in (".github/CONTRIBUTING.md", "config/docs/console.md"):
            links = re.findall(r"\]\(([^)]+)\)", text_of(page))
            self.check([page + link if link[0] == "#" else os.path.dirname(page) + "/" + link
                        for link in links])

    def test_each_warning_names_its_page(self):
        """Warnings of the node and the monitor: all that they log but news."""
        named = []
        for room in "src/node", "src/monitor":
            for folder, _, files in os.walk(os.path.join(SOURCE, room)):
                for name in files:
                    text = re.sub(r'"\s*"', "", text_of(folder, name))
                    for line in re.findall(r"ROS_(?:WARN|ERROR|FATAL)\w*\(.*?\);\n", text, re.S) + \
                            re.findall(r"NODELET_FATAL\w*\(.*?\);\n", text, re.S):
                        page = re.search(r"\bsee (\S+\.md[^\s\"]*)\"", line)
                        self.assertTrue(page, f"{name} names no page: {line}")
                        named.append(page[1])
                    named += re.findall(r'"(config/docs/console\.md#[^"]*)"', text)
        self.assertGreater(len(named), 20)
        self.check(named)


if __name__ == "__main__":
    unittest.main()
