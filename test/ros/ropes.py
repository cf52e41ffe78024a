"""Ropes around a finger, for tests of bodies with a radius."""
import numpy as np

NODES = 45
RADIUS_M = 1 / 128  # float32 has it exactly


def rope_around(random):
    """A helix of one to four turns around the z axis, a little crooked, in float64. It is sometimes
    nearer to a finger of 0.05 x 0.05 m than RADIUS_M, and sometimes not."""
    turn = np.linspace(0, 2 * np.pi * random.uniform(1, 4), NODES) + random.uniform(0, 6)
    distance = random.uniform(0.038, 0.056) + 0.002 * np.sin(3 * turn)
    rope = np.stack([distance * np.cos(turn), distance * np.sin(turn),
                     random.uniform(-0.005, 0.005) * (turn - turn[0])], axis=-1)
    return rope + np.append(random.uniform(-0.006, 0.006, 2), random.uniform(-0.1, 0.1))
