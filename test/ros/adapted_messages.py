"""A mesh as a message of another type than DeformableMesh; stamps and frames are the caller's."""
import numpy as np
from geometry_msgs.msg import Point, Pose, PoseArray, PoseStamped
from sensor_msgs.msg import PointCloud2, PointField
from shape_msgs.msg import Mesh, MeshTriangle
from visualization_msgs.msg import Marker, MarkerArray


def points(vertices):
    return [Point(*(float(value) for value in vertex)) for vertex in vertices]


def shape_message(mesh):
    return Mesh(vertices=points(mesh[0]),
                triangles=[MeshTriangle(vertex_indices=[int(i) for i in t]) for t in mesh[1]])


def marker_message(mesh):
    marker = Marker(ns="box", id=4, type=Marker.TRIANGLE_LIST)
    marker.scale.x = marker.scale.y = marker.scale.z = 1
    marker.points = points(mesh[0][mesh[1].flatten()])
    return marker


def array_message(mesh):
    """The mesh is marker 'box'/4, behind its points and before its edges, as simulators publish."""
    dots, surface, lines = (marker_message(mesh) for _ in range(3))
    dots.id, dots.type = 3, Marker.POINTS
    lines.id, lines.type, lines.points = 5, Marker.LINE_LIST, lines.points[:2]
    return MarkerArray(markers=[dots, surface, lines])


def polygon_message(mesh):
    """Polygons of any length; the package is not everywhere."""
    from pcl_msgs.msg import PolygonMesh, Vertices  # pylint: disable=import-outside-toplevel
    return PolygonMesh(cloud=cloud_message(mesh),
                       polygons=[Vertices([int(i) for i in polygon]) for polygon in mesh[1]])


def poses_of(mesh):
    return [Pose(position=point) for point in points(mesh[0])]


def poses_message(mesh):
    """The vertices in their order are a line, here and below."""
    return PoseArray(poses=poses_of(mesh))


def path_message(mesh):
    """The package is not everywhere."""
    from nav_msgs.msg import Path  # pylint: disable=import-outside-toplevel
    return Path(poses=[PoseStamped(pose=pose) for pose in poses_of(mesh)])


def strip_message(mesh):
    marker = Marker(ns="box", id=4, type=Marker.LINE_STRIP, points=points(mesh[0]))
    marker.scale.x = 0.125
    return marker


def line_triangles(nodes):
    """As config/docs/mesh_from/rope_tracker.md numbers them."""
    ends = np.arange(1, nodes, dtype=np.uint32)
    return np.stack([ends - 1, ends, ends], axis=1) if nodes > 1 else np.zeros((1, 3), np.uint32)


def separate_points(count):
    """As config/docs/mesh_from/grains.md numbers them."""
    return np.repeat(np.arange(count, dtype=np.uint32), 3).reshape(-1, 3)


def depth_triangles(pixels, rows, max_jump):
    """The triangles of a depth image by the rule in config/docs/mesh_from/depth_camera.md."""
    columns = len(pixels) // rows
    x, y, z = pixels.astype(np.float64).T
    squared = x * x + y * y + z * z
    squared[~np.isfinite(squared)] = 0
    triangles = []
    for a in range(columns * (rows - 1)):
        if a % columns == columns - 1:
            continue
        b, c, d = a + 1, a + columns, a + columns + 1
        ways = []
        for way in (((a, c, b), (b, c, d)), ((a, c, d), (a, d, b))):
            depths = [squared[list(triangle)] for triangle in way]
            ways.append([triangle for triangle, of in zip(way, depths)
                         if of.min() > 0 and of.max() <= (1 + max_jump) ** 2 * of.min()])
        triangles += max(ways, key=len)
    triangles += lone_pixels(squared, columns, (1 + max_jump) ** 2, {*sum(triangles, ())})
    return np.array(triangles, np.uint32).reshape(-1, 3)


def lone_pixels(squared, columns, most, in_triangle):
    """The lines and points, as triangles, of the pixels that are in none."""
    def neighbours(pixel):
        for step in (-columns - 1, -columns, 1 - columns, -1, 1, columns - 1, columns, columns + 1):
            other = pixel + step
            if 0 <= other < len(squared) and abs(other % columns - pixel % columns) <= 1:
                low, high = sorted(squared[[pixel, other]])
                if 0 < low and high <= most * low:
                    yield other
    made = []
    for pixel in np.flatnonzero(squared):
        if pixel not in in_triangle:
            near = list(neighbours(pixel))
            made += [(pixel, other, other) for other in near
                     if other in in_triangle or pixel < other]
            if not near:
                made.append((pixel, pixel, pixel))
    return made


def cloud_message(mesh, rows=1):
    """With a field between, doubles and gaps; `rows` must divide the vertices."""
    point = np.dtype({"names": ["x", "rgb", "y", "z"], "formats": ["<f4", "<u4", "<f8", "<f8"],
                      "offsets": [2, 6, 10, 18], "itemsize": 29})
    data = np.zeros(len(mesh[0]), point)
    for axis, name in enumerate("xyz"):
        data[name] = mesh[0][:, axis]
    width = len(data) // rows
    cloud = PointCloud2(height=rows, width=width, point_step=29, row_step=29 * width + 3)
    cloud.fields = [PointField("x", 2, PointField.FLOAT32, 1),
                    PointField("rgb", 6, PointField.UINT32, 1),
                    PointField("y", 10, PointField.FLOAT64, 1),
                    PointField("z", 18, PointField.FLOAT64, 1)]
    cloud.data = b"".join(data[i * width:(i + 1) * width].tobytes() + b"gap" for i in range(rows))
    return cloud
