#!/usr/bin/env python3
"""What cuda/nvcc.cmake makes of an nvcc: an old one is left alone and said aloud, others are told
what they know to build for; below CMake 3.18 by flags. Each nvcc here is a script that answers."""
import os
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE_DIR = os.environ["DCM_SOURCE_DIR"]
CMAKE = sys.argv.pop(1)

KNOWN_TO_11_4 = "sm_35 sm_72 sm_75 sm_80 sm_86 sm_87"
KNOWN_TO_11_8 = KNOWN_TO_11_4 + " sm_89 sm_90"
KNOWN_TO_13_0 = "sm_75 sm_80 sm_86 sm_87 sm_88 sm_89 sm_90 sm_100 sm_110 sm_120 sm_121"

NVCC = """#!/bin/sh
case $1 in
  --version) echo "Cuda compilation tools, release {version}, V{version}.99" ;;
  --list-gpu-code) printf '%s\\n' {known} ;;
  *) exit 1 ;;
esac
"""

SCRIPT = """cmake_minimum_required(VERSION 3.16)
function(enable_language)
endfunction()
if(AS_VERSION)
  set(CMAKE_VERSION ${AS_VERSION})
endif()
set(DCM_CUDA_ENABLED OFF)
include(${NVCC_CMAKE})
foreach(name DCM_CUDA_ENABLED CMAKE_CUDA_ARCHITECTURES CMAKE_CUDA_STANDARD
    CMAKE_CUDA17_EXTENSION_COMPILE_OPTION CMAKE_CUDA_FLAGS)
  message(STATUS "${name} is '${${name}}'")
endforeach()
"""


def configured(version, known=KNOWN_TO_11_8, *arguments):
    """What CMake says, and the variables that it ends with."""
    with tempfile.TemporaryDirectory() as folder:
        nvcc = os.path.join(folder, "nvcc")
        with open(nvcc, "w") as file:
            file.write(NVCC.format(version=version, known=known))
        os.chmod(nvcc, 0o755)
        script = os.path.join(folder, "script.cmake")
        with open(script, "w") as file:
            file.write(SCRIPT)
        ran = subprocess.run(
            [CMAKE, "-DCMAKE_CUDA_COMPILER=" + nvcc,
             "-DNVCC_CMAKE=" + os.path.join(SOURCE_DIR, "cuda", "nvcc.cmake"), *arguments,
             "-P", script],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, universal_newlines=True)
        assert ran.returncode == 0, ran.stdout
        return ran.stdout, dict(re.findall(r"^-- (\w+) is '(.*)'$", ran.stdout, re.MULTILINE))


class Nvcc(unittest.TestCase):

    def test_an_old_one_is_left_alone_and_said_aloud(self):
        for version in ("9.2", "10.1", "11.2", "11.3"):
            said, variables = configured(version)
            self.assertIn("CUDA %s found, 11.4 needed: the CPU backend alone\n" % version, said)
            self.assertEqual(variables["DCM_CUDA_ENABLED"], "OFF")

    def test_it_builds_for_what_it_knows(self):
        for version, known, numbers in (("11.4", KNOWN_TO_11_4, (75, 80, 86, 87)),
                                        ("11.8", KNOWN_TO_11_8, (75, 80, 86, 87, 89, 90)),
                                        ("13.0", KNOWN_TO_13_0, (75, 80, 86, 87, 89, 90, 120))):
            variables = configured(version, known, "-DAS_VERSION=3.18.0")[1]
            self.assertEqual(variables["DCM_CUDA_ENABLED"], "ON")
            self.assertEqual(variables["CMAKE_CUDA_ARCHITECTURES"],
                             "".join("%d-real;" % n for n in numbers) + "75-virtual"
                             + (";90-virtual" if 90 in numbers else ""))
            self.assertEqual(variables["CMAKE_CUDA_STANDARD"], "17")
            self.assertEqual(variables["CMAKE_CUDA17_EXTENSION_COMPILE_OPTION"], "")
            self.assertEqual(variables["CMAKE_CUDA_FLAGS"], "")

    def test_what_is_asked_for_wins(self):
        variables = configured("11.8", KNOWN_TO_11_8, "-DCMAKE_CUDA_ARCHITECTURES=90")[1]
        self.assertEqual(variables["CMAKE_CUDA_ARCHITECTURES"], "90")

    def test_below_3_18_flags_say_it(self):
        for asked, codes in (("80-real;75-virtual", "80,code=sm_80 75,code=compute_75"),
                             ("86", "86,code=sm_86 86,code=compute_86")):
            variables = configured("11.4", KNOWN_TO_11_4, "-DAS_VERSION=3.16.3",
                                   "-DCMAKE_CUDA_ARCHITECTURES=" + asked)[1]
            self.assertEqual(variables["CMAKE_CUDA_STANDARD"], "17")
            self.assertEqual(variables["CMAKE_CUDA17_EXTENSION_COMPILE_OPTION"], "-std=c++17")
            self.assertEqual(variables["CMAKE_CUDA_FLAGS"].split(),
                             ["-gencode=arch=compute_" + code for code in codes.split()])


if __name__ == "__main__":
    unittest.main()
