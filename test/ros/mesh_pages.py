#!/usr/bin/env python3
"""Runs the examples of config/docs/mesh_from unchanged, until the monitor reports their contact."""
import importlib.util
import re
import sys

import rosgraph
import rospy
import rostest

from deformable_contact_monitor.msg import ContactState, ContactStates
from monitor_test_support import PACKAGE, Log, wait_until
from pages import PAGES, Page, PageCase

FOLDER = PAGES / "mesh_from"
OPTIONAL = {"pcl_msgs", "deformable_contact"}  # what a build may do without


def missing_packages(page):
    """The packages that the page's program imports and that are not there."""
    program = page.files().get("publisher.py", "")
    names = re.findall(r"^(?:import|from) (\w+)", program, re.M)
    return {name for name in names if not importlib.util.find_spec(name)}


class MeshPages(PageCase):

    def contact_of(self, page):
        """Starts a page's programs in a folder of their own, and waits for the contact."""
        folder = self.folder_of(page)
        # rostest has done what the first two lines do, and a Log does more than the last one.
        _, _, publish, launch, _ = Page(FOLDER / "README.md").commands()
        if "publisher.cpp" in page.files():
            publish, = page.commands()
        self.terminal(publish, folder)
        yaml = page.files()["monitor.yaml"]
        (topic,) = re.findall(r"topic: ([^,]+),", yaml)
        wait_until(lambda: any(name == topic for name, _ in rospy.get_published_topics()),
                   f"the publisher of {page.path.name}")
        self.terminal(launch, folder)
        states = Log("/contact_monitor/contact_states", ContactStates)

        def touches(message):
            return any(s.state == ContactState.CONTACT for s in message.states)
        states.wait(f"the contact of {page.path.name}", touches)
        self.doCleanups()
        wait_until(lambda: not any("/contact_monitor" in name for name in self.nodes()),
                   "the end of the monitor")

    @staticmethod
    def nodes():
        state = rosgraph.Master(rospy.get_name()).getSystemState()
        return {node for kind in state[:1] for _, nodes in kind for node in nodes}

    def test_each_page_has_its_contact(self):
        paths = sorted(path for path in FOLDER.glob("*.md") if path.name != "README.md")
        self.assertGreater(len(paths), 0)
        for path in paths:
            page = Page(path)
            missing = missing_packages(page)
            self.assertLessEqual(missing, OPTIONAL)
            if missing:
                print(f"SKIPPED: {path.name} needs {', '.join(missing)}")
                continue
            with self.subTest(page=path.name):
                self.contact_of(page)

    def test_the_index_names_each_page(self):
        index = (FOLDER / "README.md").read_text()
        for path in FOLDER.glob("*.md"):
            if path.name != "README.md":
                self.assertIn(f"({path.name})", index)


if __name__ == "__main__":
    rospy.init_node("mesh_pages_test")
    rostest.rosrun(PACKAGE, "mesh_pages", MeshPages, sys.argv)
