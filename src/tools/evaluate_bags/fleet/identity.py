"""Identifies what a bag's result was made of. With the same identity, a bag is not evaluated
again."""
import hashlib
import json
import os
import urllib.parse

import rospkg
import yaml

VARIABLES = ("ROS_PACKAGE_PATH", "LD_LIBRARY_PATH", "PYTHONPATH", "CMAKE_PREFIX_PATH")
CHUNK = 1 << 22


def hash_of(path, go_on=lambda: None):
    """Returns the hash of a file's content; None if there is no such file. Calls `go_on` now and
    then, which may raise to stop."""
    digest = hashlib.sha256()
    try:
        with open(path, "rb") as file:
            for chunk in iter(lambda: file.read(CHUNK), b""):
                digest.update(chunk)
                go_on()
    except (FileNotFoundError, IsADirectoryError, NotADirectoryError):
        return None
    return digest.hexdigest()


def _readable_hash(path, go_on):
    """hash_of(), or None of a file that cannot be read: what needs it says so."""
    try:
        return hash_of(path, go_on)
    except OSError:
        return None


def _percent_decoded(text):
    return os.fsdecode(urllib.parse.unquote_to_bytes(os.fsencode(text)))


def resolved(name):
    """Returns the path of a file name, or of a package:// or file:// name; None if it is
    unknown. The rules are those of src/robot/resource_resolver.cpp."""
    scheme, separator, rest = name.partition("://")
    host, slash, rest = rest.partition("/")
    if name.startswith("/") or not separator:
        path = name
    elif scheme == "file" and slash and host in ("", "localhost"):
        path = _percent_decoded(slash + rest)
    elif scheme == "package":
        try:
            path = rospkg.RosPack().get_path(host) + _percent_decoded(slash + rest)
        except rospkg.ResourceNotFound:
            return None
    else:
        return None
    return None if "\0" in path else path


def _strings(tree):
    if isinstance(tree, dict):
        for value in tree.values():
            yield from _strings(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from _strings(value)
    elif isinstance(tree, str):
        yield tree


def _named_in(path):
    """Returns all texts in a yaml file, some of which may name files. evaluate_bag reports a file
    that cannot be read."""
    try:
        with open(path, errors="replace") as file:
            return list(_strings(yaml.safe_load(file)))
    except (OSError, yaml.YAMLError):
        return []


def identity_of(tool, version, bag, arguments, go_on):
    """Returns the identity by everything that is known before the bag is read."""
    files = {}
    words = list(arguments)
    if "--config" in arguments:
        words += _named_in(arguments[arguments.index("--config") + 1])
    for word in words:
        path = resolved(word) if len(word) < 4096 and "\n" not in word else None
        content = _readable_hash(path, go_on) if path else None
        if content:
            files[word] = content
    reader = os.path.join(os.path.dirname(os.path.realpath(tool)), "read_link_mesh")
    return {"version": version, "tool": hash_of(tool, go_on), "bag": hash_of(bag, go_on),
            "reader": hash_of(reader, go_on),
            "arguments": arguments, "files": files,
            "packages": os.environ.get("ROS_PACKAGE_PATH", "")}


def meshes_of(summary, go_on):
    """Returns {name: hash} of the mesh files of the robot's links, which the evaluation named. The
    hash of a missing file is None."""
    names = {name for link in summary["configuration"]["links"]
             for name in link["source"].split("; ") if name.startswith("/") or "://" in name}
    return {name: _readable_hash(resolved(name) or "", go_on) for name in sorted(names)}


def are_same_meshes(meshes, go_on):
    """A mesh that was missing and still is counts as the same: its link stays UNKNOWN."""
    return all(_readable_hash(resolved(name) or "", go_on) == content
               for name, content in meshes.items())


def short_hash(tree):
    return hashlib.sha256(json.dumps(tree, sort_keys=True).encode()).hexdigest()[:16]
