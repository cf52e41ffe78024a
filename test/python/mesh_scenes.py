"""Scenes for the tests of the Python package, and what other programs say of them.

The oracle is $ORACLE_PAIRS (CGAL's exact predicates), brute force $DETECT_CONTACTS, also between
two states.
"""
import os
import pathlib
import subprocess
import tempfile

import numpy

SOURCE = pathlib.Path(__file__).resolve().parents[2]
DATA = pathlib.Path(os.environ.get("DCM_TEST_DATA") or SOURCE / "../shared/data")
IDENTITY = numpy.eye(3), numpy.zeros(3)


def soup(rng, triangles, on_grid=False):
    """Vertices and triangles that touch often, share vertices, and may be degenerate."""
    if on_grid:
        vertices = rng.integers(0, 5, (2 * triangles, 3)).astype(numpy.float32)
    else:
        vertices = rng.uniform(0, 3, (2 * triangles, 3)).astype(numpy.float32)
    return vertices, rng.integers(0, len(vertices), (triangles, 3)).astype(numpy.uint32)


def random_pose(rng):
    rotation, _ = numpy.linalg.qr(rng.normal(size=(3, 3)))
    rotation *= numpy.linalg.det(rotation)  # it does not mirror
    return rotation, rng.uniform(-1, 1, 3)


def posed(vertices, pose):
    """float32(R v + t), in the order that the contract states."""
    rotation, translation = pose
    if pose is IDENTITY:
        return vertices
    x, y, z = vertices.astype(numpy.float64).T
    rows = [((r[0] * x + r[1] * y) + r[2] * z) + t for r, t in zip(rotation, translation)]
    return numpy.stack(rows, axis=1).astype(numpy.float32)


def write_obj(path, vertices, triangles):
    with open(path, "w") as file:
        file.writelines("v %.9g %.9g %.9g\n" % tuple(vertex) for vertex in vertices)
        file.writelines("f %d %d %d\n" % tuple(triangle) for triangle in triangles + 1)


def _pairs(command):
    done = subprocess.run(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
    assert done.returncode == 0, done.stderr
    return {tuple(map(int, line.split())) for line in done.stdout.splitlines()}


def _pairs_of(meshes, program, *options):
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for number, (vertices, triangles) in enumerate(meshes):
            files.append(os.path.join(folder, "%d.obj" % number))
            write_obj(files[-1], vertices, triangles)
        return _pairs([program, *options, *files])


def oracle_pairs(meshes, adjacent="beyond_shared"):
    """Of all bodies, and of each with itself."""
    return _pairs_of(meshes, os.environ["ORACLE_PAIRS"], "--self", "--adjacent", adjacent)


def oracle_pairs_of_file(path, adjacent):
    return _pairs([os.environ["ORACLE_PAIRS"], "--self", "--adjacent", adjacent, str(path)])


def brute_force_pairs(meshes, margin_m=0.0):
    return _pairs_of(meshes, os.environ["DETECT_CONTACTS"], "--self", "--backend", "brute_force",
                     "--margin", repr(margin_m), "--pairs", "-")


def swept_pairs(meshes):
    """Of (earlier vertices, later vertices, triangles), each with itself too; with the times."""
    with tempfile.TemporaryDirectory() as folder:
        files = []
        for number, (earlier, later, triangles) in enumerate(meshes):
            for state, vertices in ("earlier", earlier), ("later", later):
                files.append(os.path.join(folder, "%d_%s.obj" % (number, state)))
                write_obj(files[-1], vertices, triangles)
        done = subprocess.run(
            [os.environ["DETECT_CONTACTS"], "--self", "--swept", "--backend", "brute_force",
             "--times", "-", *files], stdout=subprocess.PIPE, stderr=subprocess.PIPE, check=False)
        assert done.returncode == 0, done.stderr
    rows = [line.split() for line in done.stdout.splitlines()]
    return ({tuple(map(int, row[:4])): tuple(numpy.float32(row[4:])) for row in rows})


def as_set(pairs):
    """Of the rows; fails where one comes twice or they are not sorted."""
    rows = [tuple(row) for row in pairs.tolist()]
    assert rows == sorted(set(rows)), "not sorted, or not each once"
    return set(rows)
