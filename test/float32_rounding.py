#!/usr/bin/env python3
"""Looks for functions in which the compiler may leave out a rounding to float32.

Usage: test/float32_rounding.py BUILD [FLAG...]

Some releases of g++ replace the conversion of vectors of double to float and back by nothing. So
this compiles every C++ file of src and cuda again, as BUILD/compile_commands.json says, with the
FLAGs added, and reads what the vectorizers have made of it. It lists each function in which a vector
of double becomes one of float, and a vector of float one of double. First it compiles three lines
that are known to go wrong, without the project's flags, to see whether this compiler is affected.

Exit code: 0 if there is no such function, 1 if there is one or a file does not compile, 77 if the
compiler has no such dumps (clang) or rounds the three lines right.
"""
import json
import os
import re
import shlex
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor

DUMPS = ["-fdump-tree-slp=stdout", "-fdump-tree-vect=stdout", "-S", "-o", os.devnull]
FUNCTION = re.compile(r"^;; Function (.*) \(\w+, funcdef_no=", re.MULTILINE)
VARIABLE = re.compile(r"^  (?:const )?vector\(\d+\) (\w+) (\S+);$", re.MULTILINE)
CAST = re.compile(r"= \(vector\(\d+\) (\w+)\) (\S+);$", re.MULTILINE)

SAMPLE = """
void two(const double* a, double* o) {
  float f = a[0] * 3, g = a[1] * 3;
  o[0] = f; o[1] = g;
}
"""


def suspects(dump):
    """Returns the names of the functions of a dump that convert vectors in both directions."""
    found = []
    starts = list(FUNCTION.finditer(dump)) + [None]
    for start, end in zip(starts, starts[1:]):
        body = dump[start.end() : end.start() if end else len(dump)]
        types = {name: kind for kind, name in VARIABLE.findall(body)}
        casts = set()
        for to, name in CAST.findall(body):  # such as vect__13.27_3808, of the variable vect__13.27
            variable = name if name in types else name.rpartition("_")[0]
            casts.add((types.get(variable), to))
        if {("double", "float"), ("float", "double")} <= casts and start.group(1) not in found:
            found.append(start.group(1))
    return found


def compile_again(command, folder, flags, text=None):
    """Returns the dumps of a compile command. Raises CalledProcessError if it fails."""
    words = [w for w in shlex.split(command) if os.path.basename(w) not in ("ccache", "-c")]
    if "-o" in words:
        place = words.index("-o")
        del words[place : place + 2]
    return subprocess.run(words + flags + DUMPS, cwd=folder, input=text, check=True,
                          stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                          universal_newlines=True).stdout


def is_affected(compiler):
    """Returns whether the compiler is g++ and folds the three lines at -O3."""
    try:
        dump = compile_again(compiler + " -x c++ -O3 -", None, [], SAMPLE)
    except subprocess.CalledProcessError:
        return False
    return suspects(dump) == ["two"]


def main():
    if len(sys.argv) < 2 or sys.argv[1].startswith("-"):
        print(__doc__)
        return 0 if sys.argv[1:] in (["-h"], ["--help"]) else 2
    build, flags = sys.argv[1], sys.argv[2:]
    root = os.path.dirname(os.path.dirname(os.path.realpath(__file__)))
    with open(os.path.join(build, "compile_commands.json")) as file:
        entries = json.load(file)
    rooms = tuple(os.path.join(root, room, "") for room in ("src", "cuda"))
    entries = [e for e in entries if e["file"].startswith(rooms) and e["file"].endswith(".cpp")]
    compilers = {[w for w in shlex.split(e["command"]) if os.path.basename(w) != "ccache"][0]
                 for e in entries}
    if not any(is_affected(compiler) for compiler in compilers):
        print("SKIPPED: this compiler does not leave out roundings, or has no dumps of g++")
        return 77
    wrong = 0

    def look(entry):
        name = os.path.relpath(entry["file"], root)
        try:
            dump = compile_again(entry["command"], entry["directory"], flags)
            return ["%s: %s" % (name, function) for function in suspects(dump)]
        except subprocess.CalledProcessError as error:
            return ["%s does not compile: %s" % (name, error.stderr.strip())]

    with ThreadPoolExecutor(os.cpu_count()) as pool:
        for lines in pool.map(look, entries):
            wrong += len(lines)
            for line in lines:
                print(line, flush=True)
    print("%d files, %d functions that may not round to float32" % (len(entries), wrong))
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
