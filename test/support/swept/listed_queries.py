#!/usr/bin/env python3
"""Writes the queries that a scene of Sample-Scalable-CCD-Data lists, for $DCM_SWEPT_QUERIES.

    listed_queries.py SCENE TO     as TO/edge-edge/*.csv and TO/vertex-face/*.csv

SCENE is a folder of github.com/Continuous-Collision-Detection/Sample-Scalable-CCD-Data: two PLY
files in `frames`, pairs of box ids in `boxes`, their verdicts in `mma_bool`. Ids count vertices,
then edges (by the greater end, then the lesser one), then faces. Coordinates are written exactly.
"""
import glob
import json
import os
import struct
import sys

TYPES = {"float": "f", "double": "d", "uchar": "B", "uint8": "B", "int": "i", "int32": "i"}


def read_ply(path):
    """Vertices and triangles of a binary PLY file."""
    with open(path, "rb") as file:
        data = file.read()
    end = data.index(b"end_header\n") + len(b"end_header\n")
    counts, layout, element = {}, "", None
    order = ">" if b"big_endian" in data[:end] else "<"
    for line in data[:end].decode("ascii", "replace").splitlines():
        words = line.split()
        if words[:1] == ["element"]:
            element = words[1]
            counts[element] = int(words[2])
        elif words[:1] == ["property"] and element == "vertex":
            layout += TYPES[words[1]]
    vertex = struct.Struct(order + layout)
    vertices = [vertex.unpack_from(data, end + i * vertex.size)[:3]
                for i in range(counts["vertex"])]
    face = struct.Struct(order + "B3i")
    first = end + counts["vertex"] * vertex.size
    faces = [face.unpack_from(data, first + i * face.size) for i in range(counts["face"])]
    if any(f[0] != 3 for f in faces):
        raise ValueError(path + " has faces that are no triangles")
    return vertices, [f[1:] for f in faces]


def edges_of(triangles):
    ends = [(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)]
    return sorted({(max(e), min(e)) for e in ends})


def lines(points, verdict):
    for point in points:
        numbers = [str(n) for x in point for n in float(x).as_integer_ratio()]
        yield ",".join(numbers + ["1" if verdict else "0"]) + "\n"


def write_listed(scene, name, vertex_face, states, triangles, path):
    """All queries of one list, boxes/NAME.json."""
    edges = edges_of(triangles)
    count = len(states[0])
    with open(os.path.join(scene, "boxes", name + ".json")) as file:
        boxes = json.load(file)
    with open(os.path.join(scene, "mma_bool", name + "_mma_bool.json")) as file:
        verdicts = json.load(file)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as out:
        for (a, b), verdict in zip(boxes, verdicts):
            if vertex_face:
                corners = (a,) + triangles[b - count - len(edges)]
            else:
                corners = edges[a - count][::-1] + edges[b - count][::-1]
            for state in states:
                out.writelines(lines([state[i] for i in corners], verdict))
    print(f"{path}: {len(verdicts)} queries, {sum(verdicts)} meet")


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    scene, to = sys.argv[1:]
    frames = sorted(glob.glob(os.path.join(scene, "frames", "*.ply")))
    if len(frames) != 2:
        sys.exit(f"{scene}/frames has {len(frames)} PLY files, not 2")
    (before, triangles), (after, same) = map(read_ply, frames)
    if triangles != same:
        sys.exit(f"{scene}: not the same triangles in both frames")
    for list_ in sorted(glob.glob(os.path.join(scene, "boxes", "*.json"))):
        name = os.path.splitext(os.path.basename(list_))[0]
        vertex_face = name.endswith("vf")
        kind = "vertex-face" if vertex_face else "edge-edge"
        write_listed(scene, name, vertex_face, [before, after], triangles,
                     os.path.join(to, kind, name + ".csv"))


if __name__ == "__main__":
    main()
