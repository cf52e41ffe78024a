#!/usr/bin/env python3
"""Finds the contacts of two mesh files, or of one with itself, and draws them.

Usage: find_contacts.py MESH [OTHER] [--plot FILE.png | --show]
"""
import argparse
import sys

import numpy
from deformable_contact import Detector, Scene, read_mesh


def find_contacts(meshes):
    """The scene's result; each mesh is a list of name, vertices and triangles."""
    scene = Scene()
    for mesh in meshes:
        scene.add_body(*mesh)
    # Of one mesh: the body with itself.
    scene.set_pair_enabled(0, scene.body_count - 1)
    return Detector().detect(scene)


def summary(meshes, result):
    lines = ["%d contacts, %scomplete, in %.1f ms on %s" % (
        len(result.pairs), "" if result.complete else "not ", result.round_trip_ms,
        result.backend)]
    for body, (name, _, triangles) in enumerate(meshes):
        touching = len(touching_triangles(result, body))
        lines.append("%s: %d of %d triangles touch" % (name, touching, len(triangles)))
    return "\n".join(lines)


def touching_triangles(result, body):
    """Numbers of the body's triangles that are part of a contact."""
    a, b = result.pairs[:, :2], result.pairs[:, 2:]
    both = numpy.concatenate([a, b])
    return numpy.unique(both[both[:, 0] == body, 1])


def plot(meshes, result, path):
    """Contact triangles in red among the meshes' vertices; without a path, in a window."""
    import matplotlib
    if path:
        matplotlib.use("Agg")
    from matplotlib import pyplot
    from mpl_toolkits.mplot3d.art3d import Poly3DCollection

    figure = pyplot.figure(figsize=(8, 8))
    axes = figure.add_axes([0, 0, 1, 0.95], projection="3d")
    axes.computed_zorder = False  # contacts in front of all else; before matplotlib 3.4, by depth
    corners = []
    for body, (name, vertices, triangles) in enumerate(meshes):
        finite = vertices[numpy.isfinite(vertices).all(axis=1)]
        shown = finite[::max(1, len(finite) // 20000)]
        axes.scatter(*shown.T, s=0.3, alpha=0.2, zorder=1, label=name)
        touching = vertices[triangles[touching_triangles(result, body)]]
        axes.add_collection3d(Poly3DCollection(touching, facecolors="red", edgecolors="darkred",
                                               linewidths=0.3, zorder=2))
        # Small triangles alone would not show.
        axes.scatter(*touching.mean(axis=1).T, s=4, color="red", zorder=2, depthshade=False)
        corners += [finite.min(axis=0), finite.max(axis=0)]
    low, high = numpy.min(corners, axis=0), numpy.max(corners, axis=0)
    middle, half = (low + high) / 2, (high - low).max() / 2
    for at, set_limits in zip(middle, (axes.set_xlim, axes.set_ylim, axes.set_zlim)):
        set_limits(at - half, at + half)
    axes.set_title("%d contacts" % len(result.pairs))
    axes.legend(markerscale=10, loc="lower left")
    if path:
        figure.savefig(path, dpi=120)
    else:
        pyplot.show()


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("mesh", help="OBJ, PLY, STL or OFF")
    parser.add_argument("other", nargs="?", help="without it: contacts of MESH with itself")
    parser.add_argument("--plot", metavar="FILE", help="draw them into this picture")
    parser.add_argument("--show", action="store_true", help="draw them in a window")
    arguments = parser.parse_args()
    try:
        paths = [path for path in (arguments.mesh, arguments.other) if path]
        meshes = [(path, *read_mesh(path)) for path in paths]
    except (OSError, ValueError) as error:
        print("find_contacts: %s" % error, file=sys.stderr)
        return 2
    result = find_contacts(meshes)
    print(summary(meshes, result))
    if arguments.plot or arguments.show:
        plot(meshes, result, arguments.plot)
    return 0


if __name__ == "__main__":
    sys.exit(main())
