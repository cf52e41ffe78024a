"""Finds the bags of the command line, and names them."""
import os

SUFFIX = ".bag"
# evaluate_bag refuses a bag that its recorder never closed, and says how to mend it.
UNFINISHED = SUFFIX + ".active"


class BagsError(Exception):
    """One line for the user."""


def _refuse(error):
    raise BagsError(f"{error.filename}: {error.strerror}, so bags may be missing")


def _below(folder):
    for at, folders, files in os.walk(folder, onerror=_refuse):
        folders.sort()
        for file in sorted(files):
            if file.endswith((SUFFIX, UNFINISHED)):
                yield os.path.join(at, file)


def find_bags(places):
    """Returns {name: absolute path} in the order of names, also of links whose file is gone. A bag in a folder is named by its path
    from the folder, any other by its file name, so the names are the same in every run."""
    found = {}
    for place in places:
        if os.path.isdir(place):
            paths = [(os.path.relpath(path, place), path) for path in _below(place)]
            if not paths:
                raise BagsError(f"{place}: no {SUFFIX} file in it")
        elif os.path.isfile(place) or os.path.islink(place):  # also a link to a file that is gone
            paths = [(os.path.basename(place), place)]
        else:
            raise BagsError(f"{place}: no such file or folder")
        for name, path in paths:
            path = os.path.abspath(path)
            if found.setdefault(name, path) != path:
                raise BagsError(f"{path} and {found[name]} would both be {name}: give a folder "
                                "that has both")
    for name in found:
        if any(other.startswith(name + os.sep) for other in found):
            raise BagsError(f"{name} is a bag and a folder with bags: rename one")
    return dict(sorted(found.items()))
