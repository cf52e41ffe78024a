"""The command line of evaluate_bags."""
import argparse
import os

DESCRIPTION = """Runs evaluate_bag over many bags side by side, one process a bag, on Dask workers:
local ones, or those of a scheduler. A bag that was evaluated before is not evaluated again. Writes
fleet.csv, fleet.json and index.html, and a folder for each bag."""
EPILOG = """Exit code: 0: passed; 1: an expectation fails, exact runs disagree, or a change against
the baseline is not allowed; 2: bad input, or some bag could not be evaluated completely (2 takes
precedence over 1); 130: the run was stopped."""

# Options that are passed to evaluate_bag, with their numbers of words. evaluate_bag checks them.
FILES = {"--config": 1, "--expect": 1, "--robot-description": 1, "--srdf": 1, "--meshes": "+"}
VALUES = {"--reference-frame": 1, "--frame-prefix": 1, "--joint-states": 1,
          "--robot-description-topic": 1, "--robot-meshes-topic": 1, "--backends": 1,
          "--predicates": 1, "--geometry": 1, "--overlaps": 1, "--object": 1, "--name": 1,
          "--frame": 1, "--rate": 1, "--scale": 1, "--offset": 3, "--seed": 1, "--vertices": 1,
          "--pinned": 1, "--radius": 1, "--margin": 1, "--step": 1, "--floor": 1}
REPEATED = ("--tf-topic", "--topic")  # may be given several times
FLAGS = ("--pairs", "--no-report", "--loop")
NO_FILES = ("none", "auto")  # words of --srdf
NAMES_NO_FILE = "://"


def _whole_number(least, most):
    def read(text):
        if not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"must be a number in [{least}, {most}], not {text}")
        return int(text)
    return read


def _parser():
    parser = argparse.ArgumentParser("evaluate_bags", description=DESCRIPTION, epilog=EPILOG,
                                     allow_abbrev=False)
    parser.add_argument("bags", nargs="+", metavar="BAG_OR_FOLDER",
                        help="bags, each a recording of its own; a folder stands for every *.bag "
                             "and *.bag.active in and below it")
    parser.add_argument("--out", required=True, metavar="DIR",
                        help="folder to write to; all workers must see it")
    workers = parser.add_mutually_exclusive_group()
    workers.add_argument("--scheduler", metavar="tcp://HOST:8786", help="address of a running Dask scheduler")
    workers.add_argument("--workers", type=_whole_number(1, 4096), metavar="N",
                         help="local worker processes (default: one for each GPU, or for each core)")
    parser.add_argument("--threads", type=_whole_number(0, 1024), metavar="N",
                        help="threads of the cpu backend in each evaluate_bag; 0: all cores "
                        "(default: the configuration's, or else local workers share the cores)")
    parser.add_argument("--baseline", metavar="DIR", help="an earlier --out to compare with")
    parser.add_argument("--allow", metavar="yaml", help="rules for changes that do not fail")
    group = parser.add_argument_group("options of evaluate_bag")
    for name, words in {**FILES, **VALUES}.items():
        group.add_argument(name, nargs=words, metavar="TEXT")
    for name in REPEATED:
        group.add_argument(name, action="append", metavar="TEXT")
    for name in FLAGS:
        group.add_argument(name, action="store_true")
    return parser


def _given(arguments, name):
    return getattr(arguments, name[2:].replace("-", "_"))


def _check_files(parser, arguments):
    for name in FILES:
        for word in _given(arguments, name) or ():
            if word not in NO_FILES and NAMES_NO_FILE not in word and not os.path.isfile(word):
                parser.error(f"{name}: {word}: no such file")


def parse(words):
    """Arguments as attributes; `passed` has the words for evaluate_bag. Bad usage exits with 2."""
    parser = _parser()
    arguments = parser.parse_args(words)
    _check_files(parser, arguments)
    if arguments.allow and not arguments.baseline:
        parser.error("--allow: needs --baseline")
    arguments.passed = []
    for name in {**FILES, **VALUES}:
        if _given(arguments, name):
            arguments.passed += [name, *_given(arguments, name)]
    for name in REPEATED:
        for word in _given(arguments, name) or ():
            arguments.passed += [name, word]
    arguments.passed += [name for name in FLAGS if _given(arguments, name)]
    return arguments
