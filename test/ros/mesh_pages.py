#!/usr/bin/env python3
"""Runs the examples of config/docs/mesh_from unchanged, until the monitor reports their contact."""
import importlib.util
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import unittest

import rosgraph
import rospy
import rostest

from deformable_contact_monitor.msg import ContactState, ContactStates
from monitor_test_support import PACKAGE, Log, wait_until

PAGES = pathlib.Path(__file__).resolve().parents[2] / "config" / "docs" / "mesh_from"

OPTIONAL = {"pcl_msgs", "deformable_contact"}  # what a build may do without


def blocks(page, language):
    return re.findall("```%s\n(.*?)```" % language, page.read_text(), re.S)


def missing_packages(page):
    """The packages that the page's program imports and that are not there."""
    (program,) = blocks(page, "python")
    names = re.findall(r"^(?:import|from) (\w+)", program, re.M)
    return {name for name in names if not importlib.util.find_spec(name)}


class MeshPages(unittest.TestCase):

    def start(self, *command, **options):
        process = subprocess.Popen(command, start_new_session=True, **options)
        self.addCleanup(self.stop, process)
        return process

    @staticmethod
    def stop(process):
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGINT)
        process.wait(60)

    def contact_of(self, page):
        """Starts a page's programs in a folder of their own, and waits for the contact."""
        folder = tempfile.mkdtemp()
        self.addCleanup(shutil.rmtree, folder)
        (program,) = blocks(page, "python")
        (pathlib.Path(folder) / "publisher.py").write_text(program)
        (yaml,) = blocks(page, "yaml")
        (pathlib.Path(folder) / "monitor.yaml").write_text(yaml)
        self.start(sys.executable, "publisher.py", cwd=folder)
        (topic,) = re.findall(r"topic: ([^,]+),", yaml)
        wait_until(lambda: any(name == topic for name, _ in rospy.get_published_topics()),
                   f"the publisher of {page.name}")
        self.start("roslaunch", PACKAGE, "contact_monitor.launch", f"config:={folder}/monitor.yaml")
        states = Log("/contact_monitor/contact_states", ContactStates)

        def touches(message):
            return any(s.state == ContactState.CONTACT for s in message.states)
        states.wait(f"the contact of {page.name}", touches)
        self.doCleanups()
        wait_until(lambda: not any("/contact_monitor" in name for name in self.nodes()),
                   "the end of the monitor")

    @staticmethod
    def nodes():
        state = rosgraph.Master(rospy.get_name()).getSystemState()
        return {node for kind in state[:1] for _, nodes in kind for node in nodes}

    def test_each_page_has_its_contact(self):
        pages = sorted(page for page in PAGES.glob("*.md") if page.name != "README.md")
        self.assertGreater(len(pages), 0)
        for page in pages:
            missing = missing_packages(page)
            self.assertLessEqual(missing, OPTIONAL)
            if missing:
                print(f"SKIPPED: {page.name} needs {', '.join(missing)}")
                continue
            with self.subTest(page=page.name):
                self.contact_of(page)

    def test_the_index_names_each_page(self):
        index = (PAGES / "README.md").read_text()
        for page in PAGES.glob("*.md"):
            if page.name != "README.md":
                self.assertIn(f"({page.name})", index)


if __name__ == "__main__":
    rospy.init_node("mesh_pages_test")
    rostest.rosrun(PACKAGE, "mesh_pages", MeshPages, sys.argv)
