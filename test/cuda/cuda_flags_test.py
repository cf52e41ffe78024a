#!/usr/bin/env python3
"""What nvcc is given for the CUDA backend: nothing that comes from ROS. catkin's flags are a host
compiler's (-pthread), and its include folders and definitions are no business of the backend. And
no contraction where two evaluations of one expression must agree."""
import json
import os
import shlex
import sys
import unittest

SOURCE_DIR = os.environ["DCM_SOURCE_DIR"]
COMMANDS = sys.argv.pop(1)


# In the others no number decides twice: sweep and oversized look at each pair once, tiles makes each
# key once, fan_rings and rows have whole numbers alone.
MAY_CONTRACT = {"fan_rings.cu", "oversized.cu", "output.cu", "sweep_triangles.cu",
                "rows.cu", "sweep.cu", "tiles.cu", "brute_force_tiles.cu"}


def words_of(command):
    return command.get("arguments") or shlex.split(command["command"])


def commands_below(folder):
    with open(COMMANDS) as file:
        return [c for c in json.load(file) if c["file"].endswith(".cu")
                and c["file"].startswith(os.path.join(SOURCE_DIR, folder, ""))]


class CudaFlags(unittest.TestCase):

    def test_stages_do_not_contract(self):
        commands = commands_below("cuda/stages")
        self.assertTrue(commands)
        contracting = {os.path.basename(c["file"]) for c in commands
                       if "--fmad=false" not in words_of(c)}
        self.assertEqual(contracting - MAY_CONTRACT, set())

    def test_nothing_of_ros_reaches_nvcc(self):
        commands = commands_below("cuda")
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
