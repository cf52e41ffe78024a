#!/usr/bin/env python3
"""config/install_packages: where another ROS than Debian's is sourced, rosdep and nothing else."""
import os
import subprocess
import tempfile
import unittest

SCRIPT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "config",
                      "install_packages")


class InstallPackages(unittest.TestCase):

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.bin = os.path.join(folder.name, "bin")
        self.calls = os.path.join(folder.name, "calls")
        os.mkdir(self.bin)
        open(self.calls, "w").close()

    def fake(self, name, does="true"):
        """A command that writes down how it was called."""
        path = os.path.join(self.bin, name)
        with open(path, "w") as file:
            file.write(f'#!/bin/sh\necho {name} "$@" >>{self.calls}\n{does}\n')
        os.chmod(path, 0o755)

    def run_it(self, distro, *sections):
        env = dict(os.environ, PATH=f"{self.bin}:/usr/bin:/bin")
        env.pop("ROS_DISTRO", None)
        if distro:
            env["ROS_DISTRO"] = distro
        return subprocess.run([SCRIPT, *sections], env=env, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True)

    def called(self):
        with open(self.calls) as file:
            return file.read().splitlines()

    def fake_all(self, dpkg="true", rosdep="true"):
        for name in ("apt-get", "sudo"):
            self.fake(name)
        self.fake("dpkg-query", dpkg)
        self.fake("rosdep", rosdep)

    def test_another_ros_is_served_by_rosdep_alone(self):
        self.fake_all()
        done = self.run_it("noetic", "build", "run")
        self.assertEqual(done.returncode, 0, done.stdout)
        calls = self.called()
        self.assertEqual(len(calls), 1, calls)
        self.assertRegex(calls[0], r"^rosdep install --from-paths \S+ --ignore-src "
                                   r"--rosdistro noetic -y$")

    def test_a_failure_of_rosdep_is_said(self):
        self.fake_all(rosdep="exit 3")
        done = self.run_it("noetic", "build")
        self.assertEqual(done.returncode, 1)
        self.assertIn("rosdep failed", done.stdout)

    def test_without_rosdep_it_says_how_to_get_it(self):
        for name in ("dirname", "readlink", "bash", "env", "sed", "paste"):
            os.symlink(os.path.join("/usr/bin", name), os.path.join(self.bin, name))
        env = {"PATH": self.bin, "ROS_DISTRO": "noetic"}
        done = subprocess.run([SCRIPT, "build"], env=env, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, universal_newlines=True)
        self.assertEqual(done.returncode, 1, done.stdout)
        self.assertIn("rosdep init", done.stdout)

    def test_on_debian_it_is_apt_alone(self):
        for distro in (None, "Debian"):
            self.fake_all(dpkg="exit 1")
            done = self.run_it(distro, "fuzz")
            self.assertEqual(done.returncode, 0, done.stdout)
            calls = [call for call in self.called() if not call.startswith("dpkg-query")]
            self.assertTrue(calls and not any("rosdep" in call for call in calls), calls)
            self.assertIn("clang", " ".join(calls))

    def test_bad_usage(self):
        self.fake_all()
        self.assertEqual(self.run_it("noetic").returncode, 2)
        for distro in (None, "noetic"):
            self.assertEqual(self.run_it(distro, "no_such_section").returncode, 2)


if __name__ == "__main__":
    unittest.main()
