#!/usr/bin/env python3
"""Plans a path of straight joint motions for an arm of two links round a hanging cloth.

Usage: plan_path.py
"""
import numpy
from deformable_contact import Scene, StateChecker

STEP_RAD = 0.002  # between states that are checked; a motion is a way from state to state
LIMITS = numpy.array([[-1.5, -1.5, -2], [1.5, 1.5, 2]])  # of the joints [rad]


def free_share(checker, scene, arm, starts, goals, count):
    """Of so many states on each straight way from a start to its goal, how many are free."""
    ways = numpy.linspace(starts, goals, count, axis=1)
    free = checker.check(scene, arm.bodies, arm.poses(ways.reshape(-1, ways.shape[-1]))).free
    return free.reshape(len(ways), count).mean(axis=1)


def plan(checker, scene, arm, start, goal, rng, depth=4):
    """Joint positions from start to goal, straight between them, or None. It halves the way at a
    random place from where most of the straight ways to both ends is free, and goes on with the
    halves."""
    count = max(2, int(numpy.abs(goal - start).max() / STEP_RAD))
    if free_share(checker, scene, arm, start[None], goal[None], count)[0] == 1:
        return [start, goal]
    if depth == 0:
        return None
    middles = rng.uniform(*LIMITS, size=(200, len(start)))
    share = (free_share(checker, scene, arm, start + 0 * middles, middles, 20)
             + free_share(checker, scene, arm, middles, goal + 0 * middles, 20))
    middle = middles[numpy.argmax(share)]
    first = plan(checker, scene, arm, start, middle, rng, depth - 1)
    second = first and plan(checker, scene, arm, middle, goal, rng, depth - 1)
    return second and first + second[1:]


class Arm:
    """Two links of 0.5 m that turn about the y axis, and the base about the z axis."""

    def __init__(self, scene):
        bar = numpy.array([[x, y, z] for x in (0, .5) for y in (-.02, .02) for z in (-.02, .02)])
        sides = [[0, 1, 3, 2], [4, 5, 7, 6], [0, 1, 5, 4], [2, 3, 7, 6], [0, 2, 6, 4], [1, 3, 7, 5]]
        triangles = [[s[0], s[1], s[2]] for s in sides] + [[s[0], s[2], s[3]] for s in sides]
        self.bodies = [scene.add_body(name, bar, triangles) for name in ("upper", "lower")]

    @staticmethod
    def poses(joints):
        """(n, 2, 4, 4), of joint positions (n, 3) [rad]: base, shoulder, elbow."""
        poses = numpy.tile(numpy.eye(4), (len(joints), 2, 1, 1))
        origin = numpy.zeros((len(joints), 3))
        for link in range(2):
            pitch = joints[:, 1:2 + link].sum(axis=1)
            s, c = numpy.sin(pitch), numpy.cos(pitch)
            sz, cz, zero = numpy.sin(joints[:, 0]), numpy.cos(joints[:, 0]), 0 * pitch
            rows = [[cz * c, -sz, cz * s], [sz * c, cz, sz * s], [-s, zero, c]]
            poses[:, link, :3, :3] = numpy.moveaxis(numpy.array(rows), 2, 0)
            poses[:, link, :3, 3] = origin
            origin = origin + 0.5 * poses[:, link, :3, 0]
        return poses


def hanging_cloth(count=60):
    """Vertices and triangles of a wavy sheet, 0.6 m wide and 0.8 m high, in front of the arm."""
    y, z = numpy.meshgrid(numpy.linspace(-.3, .3, count), numpy.linspace(-.5, .3, count))
    x = 0.6 + 0.03 * numpy.sin(20 * y) * numpy.cos(9 * z)
    a = (numpy.arange(count - 1)[:, None] * count + numpy.arange(count - 1)).reshape(-1, 1)
    triangles = numpy.concatenate([a + [0, 1, count], a + [1, count + 1, count]])
    return numpy.stack([x, y, z], axis=-1).reshape(-1, 3), triangles


def main(_arguments=None):
    scene = Scene()
    cloth = scene.add_body("cloth", *hanging_cloth())
    arm = Arm(scene)
    for body in arm.bodies:
        scene.set_pair_enabled(cloth, body)
    start, goal = numpy.array([-.9, .1, .2]), numpy.array([.9, .1, .2])
    path = plan(StateChecker(), scene, arm, start, goal, numpy.random.default_rng(1))
    if path is None:
        print("no path was found")
    else:
        print("\n".join(" ".join("%7.3f" % position for position in state) for state in path))
    return scene, arm, path


if __name__ == "__main__":
    main()
