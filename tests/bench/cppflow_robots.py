"""Fetch and Panda as CppFlow's problems have them: joints, ends, and capsules about their links.

The capsules (ends in the link's frame, radius, m) are those that Jrl, the kinematics library of CppFlow's authors, fits to the
published meshes (github.com/jstmn/Jrl, urdfs/*/capsules, MIT licence), to a tenth of a millimetre; so are the pairs that are
looked at: what is neither neighbouring nor named there as never or always touching.
"""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["ROBOTS", "Robot"]

Capsule = tuple[float, float, float, float, float, float, float]


@dataclass(frozen=True)
class Robot:
    """urdf: file of ../shared/benchmarks/urdf; tip: its link; joints: moving ones, root to tip; fixed: joints held at 0."""

    urdf: str
    tip: str
    joints: tuple[str, ...]
    capsules: dict[str, Capsule]
    pairs: tuple[tuple[str, str], ...]
    fixed: tuple[str, ...] = ()


_FETCH_CAPSULES: dict[str, Capsule] = {
    "base_link": (-0.175, 0, 0.18, 0.175, 0, 0.18, 0.18),
    "torso_lift_link": (-0.0232, 0.0001, 0.4737, -0.0355, -0.0008, 0.0940, 0.2069),
    "shoulder_pan_link": (-0.0001, 0, 0.0099, 0.1067, -0.0333, 0.0662, 0.0877),
    "shoulder_lift_link": (-0.0004, 0.0303, 0, 0.1271, 0, 0, 0.0771),
    "upperarm_roll_link": (0.1334, -0.0313, 0, -0.0177, 0, 0, 0.0702),
    "elbow_flex_link": (-0.0003, 0.0320, 0, 0.1341, 0, 0, 0.0697),
    "forearm_roll_link": (0.1231, -0.0613, 0, -0.0138, 0.0001, 0, 0.0650),
    "wrist_flex_link": (-0.0003, 0.0047, 0, 0.0573, 0, 0, 0.0869),
    "wrist_roll_link": (-0.0035, 0, 0, -0.0034, 0, 0, 0.0655),
    "gripper_link": (-0.1165, 0, 0.0011, -0.0695, 0, 0.0011, 0.0726),
    "head_tilt_link": (0, 0.0863, 0.003, 0, -0.0864, 0.003, 0.06),
}
_PANDA_CAPSULES: dict[str, Capsule] = {
    "panda_link0": (-0.0568, -0.0001, 0.0151, -0.0001, 0, 0.0515, 0.1053),
    "panda_link1": (0.0001, -0.0002, -0.1404, 0.0002, -0.0539, 0.0025, 0.0767),
    "panda_link2": (-0.0001, -0.1418, 0, -0.0001, 0.0015, 0.0535, 0.0771),
    "panda_link3": (0.0003, 0.0002, -0.0798, 0.0829, 0.0426, 0.0004, 0.0702),
    "panda_link4": (-0.0821, 0.0835, 0.0002, 0.0007, -0.0007, 0.0427, 0.0697),
    "panda_link5": (0.0002, 0.0103, -0.2437, 0, 0.0638, 0.0030, 0.0683),
    "panda_link6": (0.0871, 0.0087, -0.0004, 0.0231, 0.0068, 0.0060, 0.0760),
    "panda_link7": (-0.0051, -0.0051, 0.0733, 0.0328, 0.0330, 0.0813, 0.0501),
    "panda_hand": (-0.0001, 0.0606, 0.0313, 0, -0.0760, 0.0212, 0.0499),
}


def _with(link: str, others: str, ending: str = "_link") -> list[tuple[str, str]]:
    return [(link, other + ending) for other in others.split()]


_FETCH_PAIRS = (
    *_with("base_link", "elbow_flex forearm_roll wrist_flex wrist_roll gripper"),
    *_with("torso_lift_link", "upperarm_roll elbow_flex forearm_roll wrist_flex wrist_roll gripper"),
    ("shoulder_pan_link", "gripper_link"),
    ("shoulder_lift_link", "gripper_link"),
    *_with("head_tilt_link", "upperarm_roll elbow_flex forearm_roll wrist_flex wrist_roll gripper"),
    ("forearm_roll_link", "wrist_roll_link"),
)
_PANDA_PAIRS = tuple(
    pair
    for link, others in (
        ("panda_link0", "link5 link6 link7 hand"),
        ("panda_link1", "link5 link6 link7 hand"),
        ("panda_link2", "link5 link6 link7 hand"),
        ("panda_link3", "hand"),
        ("panda_link4", "hand"),
        ("panda_link5", "hand"),
        ("panda_link6", "hand"),
    )
    for pair in [(link, "panda_" + other) for other in others.split()]
)
_FETCH_ARM = tuple(
    f"{name}_joint"
    for name in (
        "shoulder_pan",
        "shoulder_lift",
        "upperarm_roll",
        "elbow_flex",
        "forearm_roll",
        "wrist_flex",
        "wrist_roll",
    )
)

ROBOTS = {
    "fetch": Robot("fetch.urdf", "gripper_link", ("torso_lift_joint", *_FETCH_ARM), _FETCH_CAPSULES, _FETCH_PAIRS),
    "fetch_arm": Robot("fetch.urdf", "gripper_link", _FETCH_ARM, _FETCH_CAPSULES, _FETCH_PAIRS, ("torso_lift_joint",)),
    "panda": Robot(
        "panda_arm_hand.urdf",
        "panda_hand",
        tuple(f"panda_joint{i}" for i in range(1, 8)),
        _PANDA_CAPSULES,
        _PANDA_PAIRS,
    ),
}
