#!/usr/bin/env python3
"""What nvcc is given for the CUDA backend: nothing that comes from ROS. catkin's flags are a host
compiler's (-pthread), and its include folders and definitions are no business of the backend."""
import json
import os
import shlex
import sys
import unittest

SOURCE_DIR = os.environ["DCM_SOURCE_DIR"]
COMMANDS = sys.argv.pop(1)


def words_of(command):
    return command.get("arguments") or shlex.split(command["command"])


class CudaFlags(unittest.TestCase):

    def test_nothing_of_ros_reaches_nvcc(self):
        with open(COMMANDS) as file:
            commands = [c for c in json.load(file) if c["file"].endswith(".cu")
                        and c["file"].startswith(os.path.join(SOURCE_DIR, "cuda", ""))]
        self.assertTrue(commands)
        for command in commands:
            words = words_of(command)
            folders = {os.path.realpath(word[2:]) for word in words if word.startswith("-I")}
            own = {os.path.realpath(os.path.join(SOURCE_DIR, folder)) for folder in ("", "src")}
            strange = [word for word in words if "pthread" in word or word == "-isystem"
                       or (word.startswith("-D") and word != "-DNDEBUG")]
            strange += sorted(folders - own)
            self.assertEqual(strange, [], command["file"])


if __name__ == "__main__":
    unittest.main()
