"""The command line of evaluate_bags."""
import argparse
import os

DESCRIPTION = """Runs evaluate_bag over many bags, each in a process of its own, on Dask's workers:
local ones, or those of a scheduler. What is done is not done again. Writes fleet.csv, fleet.json
and index.html, and a folder for each bag."""
EPILOG = """Exit code: 0; 1 if an expectation fails, exact runs disagree, or a change against the
baseline is not allowed; 2 on bad input, or if some bag could not be evaluated whole (this goes
before 1); 130 if it was stopped."""

# Options of evaluate_bag by the number of their words; it checks them.
FILES = {"--config": 1, "--expect": 1, "--robot-description": 1, "--srdf": 1, "--meshes": "+"}
VALUES = {"--reference-frame": 1, "--backends": 1, "--predicates": 1, "--overlaps": 1, "--cloth": 1,
          "--object": 1, "--frame": 1, "--rate": 1, "--scale": 1, "--offset": 3, "--seed": 1}
FLAGS = ("--pairs", "--no-report", "--loop")
NO_FILES = ("none", "auto")  # words of --srdf
NAMES_NO_FILE = "://"


def _whole_number(least, most):
    def read(text):
        if not text.isdecimal() or not least <= int(text) <= most:
            raise argparse.ArgumentTypeError(f"must be a number in [{least}, {most}], not {text}")
        return int(text)
    return read


def _minutes(text):
    value = float(text)
    if not 0 <= value < float("inf"):
        raise argparse.ArgumentTypeError(f"must be a number of at least 0, not {text}")
    return value


def _parser():
    parser = argparse.ArgumentParser("evaluate_bags", description=DESCRIPTION, epilog=EPILOG,
                                     allow_abbrev=False)
    parser.add_argument("bags", nargs="+", metavar="BAG_OR_FOLDER",
                        help="bags, each alone; of a folder every *.bag in it and below")
    parser.add_argument("--out", required=True, metavar="DIR",
                        help="folder to write to, which all workers see")
    workers = parser.add_mutually_exclusive_group()
    workers.add_argument("--scheduler", metavar="tcp://HOST:8786", help="of a running Dask cluster")
    workers.add_argument("--workers", type=_whole_number(1, 4096), metavar="N",
                         help="local processes (default: one for each GPU, else for each core)")
    parser.add_argument("--threads", type=_whole_number(0, 1024), metavar="N",
                        help="of each evaluate_bag, for its cpu backend; 0: all cores (default: as "
                        "the configuration says, else local workers share the cores)")
    parser.add_argument("--split-minutes", type=_minutes, default=10, metavar="N",
                        help="a bag that was recorded for longer is a job for each N minutes, and "
                        "one that joins them; the result is the same; 0: never (default: 10)")
    parser.add_argument("--baseline", metavar="DIR", help="an earlier --out to compare with")
    parser.add_argument("--allow", metavar="yaml", help="changes that are no failure")
    group = parser.add_argument_group("options of evaluate_bag")
    for name, words in {**FILES, **VALUES}.items():
        group.add_argument(name, nargs=words, metavar="TEXT")
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
    arguments.passed += [name for name in FLAGS if _given(arguments, name)]
    return arguments
