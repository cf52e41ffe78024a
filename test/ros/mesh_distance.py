"""The distance of two meshes that have no point in common, from every pair of their triangles."""
import numpy as np

MOST_PAIRS = 50000  # at a time


def dot(a, b):
    return np.einsum("...i,...i->...", a, b)


def point_segment(p, a, b):
    """Squared distances of points and segments."""
    along = b - a
    t = np.clip(dot(p - a, along) / np.maximum(dot(along, along), 1e-300), 0, 1)
    way = p - a - t[..., None] * along
    return dot(way, way)


def line_line(p, u, q, v):
    """Squared distances of segments p to p + u and q to q + v where their lines are nearest within
    both; infinite elsewhere, where an end is nearest."""
    way = p - q
    uu, uv, vv, uw, vw = dot(u, u), dot(u, v), dot(v, v), dot(u, way), dot(v, way)
    area = uu * vv - uv * uv
    with np.errstate(divide="ignore", invalid="ignore"):
        s, t = (uv * vw - vv * uw) / area, (uu * vw - uv * uw) / area
    is_within = (area > 0) & (s >= 0) & (s <= 1) & (t >= 0) & (t <= 1)
    s, t = np.where(is_within, s, 0), np.where(is_within, t, 0)
    nearest = way + s[..., None] * u - t[..., None] * v
    return np.where(is_within, dot(nearest, nearest), np.inf)


def point_face(p, a, b, c):
    """Squared distances of points and triangles' planes where the foot is within; else infinite."""
    normal = np.cross(b - a, c - a)
    is_within = dot(normal, normal) > 0
    for start, end in ((a, b), (b, c), (c, a)):
        is_within &= dot(np.cross(normal, end - start), p - start) >= 0
    height = dot(p - a, normal)
    return np.where(is_within, height ** 2 / np.maximum(dot(normal, normal), 1e-300), np.inf)


def least_squared(one, other):
    """Of pairs of triangles, float64 [n, 3, 3] each, that do not intersect."""
    least = np.full(len(one), np.inf)
    for a, b in ((one, other), (other, one)):
        for i in range(3):
            least = np.minimum(least, point_face(a[:, i], b[:, 0], b[:, 1], b[:, 2]))
            for j in range(3):
                least = np.minimum(least, point_segment(a[:, i], b[:, j], b[:, (j + 1) % 3]))
    for i in range(3):
        for j in range(3):
            p, q = one[:, i], other[:, j]
            least = np.minimum(least, line_line(p, one[:, (i + 1) % 3] - p,
                                                q, other[:, (j + 1) % 3] - q))
    return least.min()


def mesh_distance(one, other):
    """[m]; meaningless where they intersect."""
    a, b = (mesh[0].astype(np.float64)[mesh[1]] for mesh in (one, other))
    rows = max(1, MOST_PAIRS // len(a))
    return np.sqrt(min(
        least_squared(np.repeat(a, len(part), axis=0), np.tile(part, (len(a), 1, 1)))
        for part in (b[start:start + rows] for start in range(0, len(b), rows))))
