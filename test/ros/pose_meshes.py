"""Reads, writes and transforms meshes. Shares no code with the monitor, so that tests can compare
the two. A mesh is (vertices float32 [n, 3], triangles [m, 3])."""
import xml.etree.ElementTree as ElementTree

import numpy as np


def read_obj(path, scale=1.0):
    """Triangles of an OBJ file without polygons; coordinates times `scale`, rounded to float32."""
    vertices, triangles = [], []
    with open(path) as file:
        for line in file:
            words = line.split()
            if words and words[0] == "v":
                vertices.append([float(word) * scale for word in words[1:4]])
            elif words and words[0] == "f":
                triangles.append([int(word.split("/")[0]) - 1 for word in words[1:4]])
    return np.array(vertices, np.float32), np.array(triangles, np.uint32)


def read_binary_stl(path):
    """Triangles in file order, three vertices of its own each."""
    with open(path, "rb") as file:
        file.seek(80)
        count = int(np.frombuffer(file.read(4), "<u4")[0])
        facet = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
        facets = np.frombuffer(file.read(count * facet.itemsize), facet)
    return (facets["corners"].reshape(-1, 3).astype(np.float32),
            np.arange(3 * count, dtype=np.uint32).reshape(-1, 3))


def write_ply(path, mesh):
    """Binary PLY with float32 coordinates, bit by bit."""
    vertices, triangles = mesh
    header = ("ply\nformat binary_little_endian 1.0\n"
              f"element vertex {len(vertices)}\n"
              "property float x\nproperty float y\nproperty float z\n"
              f"element face {len(triangles)}\n"
              "property list uchar int vertex_indices\nend_header\n")
    faces = np.zeros(len(triangles), np.dtype([("n", "u1"), ("corners", "<i4", 3)]))
    faces["n"] = 3
    faces["corners"] = triangles
    with open(path, "wb") as file:
        file.write(header.encode())
        file.write(np.ascontiguousarray(vertices, "<f4").tobytes())
        file.write(faces.tobytes())


def rotation(quaternion):
    """The matrix of (x, y, z, w) in double, in the order that src/monitor/input/transform_lookup.h gives."""
    x, y, z, w = (np.float64(value) for value in quaternion)
    n = np.sqrt(((x * x + y * y) + z * z) + w * w)
    x, y, z, w = x / n, y / n, z / n, w / n
    return np.array([
        [1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
        [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
        [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def posed(mesh, pose):
    """The mesh at pose (translation, quaternion), float32(R v + t); unchanged if that is None."""
    if pose is None:
        return mesh
    vertices, triangles = mesh
    translation, quaternion = pose
    v = vertices.astype(np.float64)
    rows = [((r[0] * v[:, 0] + r[1] * v[:, 1]) + r[2] * v[:, 2]) + np.float64(t)
            for r, t in zip(rotation(quaternion), translation)]
    return np.stack(rows, axis=1).astype(np.float32), triangles


def merged(meshes):
    """All meshes as one, and the (number of the mesh, its own triangle) of each triangle."""
    vertices, triangles, origins = [], [], []
    first = 0
    for number, (mesh_vertices, mesh_triangles) in enumerate(meshes):
        vertices.append(mesh_vertices)
        triangles.append(mesh_triangles + np.uint32(first))
        origins += [(number, triangle) for triangle in range(len(mesh_triangles))]
        first += len(mesh_vertices)
    return (np.concatenate(vertices), np.concatenate(triangles)), origins


def rpy_quaternion(rpy):
    """(x, y, z, w) of fixed-axis roll, pitch, yaw [rad]."""
    (sr, sp, sy), (cr, cp, cy) = np.sin(np.array(rpy) / 2), np.cos(np.array(rpy) / 2)
    return (sr * cp * cy - cr * sp * sy, cr * sp * cy + sr * cp * sy,
            cr * cp * sy - sr * sp * cy, cr * cp * cy + sr * sp * sy)


def numbers(text):
    return [float(word) for word in text.split()]


def origin_of(element):
    """(translation, quaternion) of an element's <origin>; the identity without one."""
    origin = element.find("origin")
    attributes = {} if origin is None else origin.attrib
    return (numbers(attributes.get("xyz", "0 0 0")),
            rpy_quaternion(numbers(attributes.get("rpy", "0 0 0"))))


def read_stl_links(urdf, package_folder):
    """Collision mesh of each link of a URDF whose geometry is one unscaled STL a link, in order."""
    links = {}
    for link in ElementTree.parse(urdf).getroot().findall("link"):
        for collision in link.findall("collision"):
            name = collision.find("geometry/mesh").get("filename").split("/", 3)[3]
            mesh = read_binary_stl(f"{package_folder}/{name}")
            links[link.get("name")] = posed(mesh, origin_of(collision))
    return links
