"""The distance of two meshes, from every pair of their triangles."""
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


def segment_crosses(p, q, a, b, c):
    """Whether segments go through triangles. Where rounding decides, the distance of their edges
    and ends is as good as 0."""
    normal = np.cross(b - a, c - a)
    above, below = dot(p - a, normal), dot(q - a, normal)
    sides = [dot(np.cross(end - p, start - p), q - p) for start, end in ((a, b), (b, c), (c, a))]
    is_within = np.all(np.array(sides) >= 0, axis=0) | np.all(np.array(sides) <= 0, axis=0)
    return (above * below < 0) & is_within


def squared_distances(one, other):
    """Of pairs of triangles, float64 [n, 3, 3] each."""
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
    for a, b in ((one, other), (other, one)):
        for i in range(3):
            crosses = segment_crosses(a[:, i], a[:, (i + 1) % 3], b[:, 0], b[:, 1], b[:, 2])
            least = np.where(crosses, 0, least)
    return least


def distances(one, other):
    """Those of all pairs of triangles of two meshes [m], one row for each triangle of `other`."""
    a, b = (mesh[0].astype(np.float64)[mesh[1]] for mesh in (one, other))
    rows = max(1, MOST_PAIRS // len(a))
    parts = [b[start:start + rows] for start in range(0, len(b), rows)]
    return np.sqrt(np.concatenate([
        squared_distances(np.tile(a, (len(part), 1, 1)), np.repeat(part, len(a), axis=0))
        .reshape(len(part), len(a)) for part in parts]))


def mesh_distance(one, other):
    """[m]"""
    return distances(one, other).min()


def pairs_within(links, name, mesh, radius_m):
    """Returns what pairs_of() must be for {link: posed mesh} and the posed mesh of an object with a
    radius: the pairs whose distance, rounded to float32, is at most the radius."""
    pairs = set()
    for link, of_link in links.items():
        apart = distances(of_link, mesh).astype(np.float32)
        pairs |= {(link, int(i), name, int(k))
                  for k, i in np.argwhere(apart <= np.float32(radius_m))}
    return pairs
