"""A scene with the robot of two_boxes.urdf: where its links are, and which pairs are expected."""
from monitor_test_support import grid, oracle_pairs, posed_links

REFERENCE_FRAME = "base"
UPRIGHT = (0.0, 0.0, 0.0, 1.0)
PALM_AT, FINGER_AT, LOST_AT = (0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.0, 0.0)  # [m]
CLOTH = grid(12, 0.8)  # through palm and finger
SMALL_CLOTH = grid(5, 0.7)
FAR_CLOTH = grid(12, 0.8, height_m=3.0)


def edges(finger_at=FINGER_AT, links=("palm", "finger", "lost")):
    at = {"palm": PALM_AT, "finger": finger_at, "lost": LOST_AT}
    return {link: (REFERENCE_FRAME, (at[link], UPRIGHT)) for link in links}


def expected(meshes, transforms, stamp, cloth, name="cloth"):
    """The oracle's pairs of {link: mesh} and a cloth in the reference frame."""
    def pose(link):
        return transforms.pose(REFERENCE_FRAME, link, stamp)
    return oracle_pairs(posed_links(meshes, pose), name, cloth)
