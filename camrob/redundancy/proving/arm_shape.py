"""What the enclosures know of a cell: its chain, and the arm as lengths and directions seen from its shoulder."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.errors import CellError
from camrob.kinematics.arm import Arm
from camrob.redundancy.planning.freedoms import PlanSpace, plan_space

__all__ = ["SYMBOLS", "ArmShape", "arm_shape"]

Array = NDArray[np.float64]

SYMBOLS = 3
"""Freedoms that an enclosure has symbols for; a form's other two are a bundle's."""
_SAME = 1e-9  # rad and m within which axes count as square to each other and levers as none; `enclosure` pads for it


class ArmShape(NamedTuple):
    """A cell for the enclosures.

    first (4, 4): `base` seen from the first joint's frame; after (E, 4, 4): each external joint's frame after its motion seen
    from the next one's, the last seen from the shoulder: origin on axis 1, y along axis 2 in the zero posture, z along axis 1.
    prismatic (E,). turning: which freedom turns the tool beside the roll, -1 for none; before, behind (3, 3): rotations from
    `base` to the frame that it turns in, and from there to the shoulder. lower, upper (F,): limits of the freedoms, a turn for
    endless ones; the last one is not the roll itself but - roll - mix * (the turning freedom): an upright tool then looks
    alike wherever that one stands.

    In the shoulder's frame, turned with axis 1: axis 2 passes (x2, z2); the wrist lies `aside` along y. upper_arm, forearm: the
    lengths across axis 2; zero_upper, zero_fore (2,): their directions (x, z) in the zero posture. fourth (3,): axis 4 along the
    forearm, square to it in the plane, along y. In the tool's frame: wrist (3,), axis six (3,) and lever (3,) from the wrist to
    the plate less `along` times axis 6; bent: whether that is anything; reach2: square of the wrist's distance from the plate.
    length: the characteristic one. q_lower, q_upper (6,): limits of the arm; third (3,): what to add to the angle from upper arm
    to forearm, and the limits of the sum; wrist_zero: the fifth joint's angle at which axes 4 and 6 are one.
    """

    first: Array
    after: Array
    prismatic: NDArray[np.bool_]
    turning: int
    mix: float
    before: Array
    behind: Array
    lower: Array
    upper: Array
    x2: float
    z2: float
    aside: float
    upper_arm: float
    forearm: float
    zero_upper: Array
    zero_fore: Array
    fourth: Array
    wrist: Array
    sixth: Array
    lever: Array
    along: float
    bent: bool
    reach2: float
    length: float
    q_lower: Array
    q_upper: Array
    third: Array
    wrist_zero: float


def arm_shape(cell: Cell, upright: Array) -> ArmShape:
    """The shape of a cell's arm; upright (3,): about where the tool's axis points, in `base`.

    Raises CellError where the enclosures don't cover it.
    """
    space = plan_space(cell)
    what = _not_covered(space)
    if what:
        raise CellError(
            f"cell {cell.name}: {what}, and the proof does not cover such cells", hint="the searched bound still holds"
        )
    h, o, foot_T_tool = space.arm.h, space.arm.o, np.linalg.inv(space.arm.tool_T_foot)
    E = np.array([np.cross(h[1], h[0]), h[1], h[0]])  # rows: shoulder's axes in the foot's frame
    E[0] /= np.linalg.norm(E[0])
    wrist, axis3, axis2 = (E @ (p - o[0]) for p in (space.arm.wrist, o[2], o[1]))
    fore, upper = (wrist - axis3)[[0, 2]], (axis3 - axis2)[[0, 2]]
    h4 = E @ h[3]
    along_fore = (h4[[0, 2]] @ fore) / (fore @ fore)
    across = (h4[[0, 2]] @ _turned(fore)) / (fore @ fore)
    R = foot_T_tool[:3, :3]
    reach = _plate(cell) - space.arm.wrist
    along = float(reach @ h[5])
    lever = reach - along * h[5]
    bent = bool(np.linalg.norm(lever) > _SAME)
    elbow = np.arctan2(_turned(upper) @ fore, upper @ fore)
    third = (
        np.array([space.lower[2], space.upper[2]]) if h[2] @ h[1] > 0.0 else -np.array([space.upper[2], space.lower[2]])
    )
    first, after = _frames(space, E, o[0])
    aside = float(wrist[1]) if abs(wrist[1]) > _SAME else 0.0
    turning = int(np.argmax(~space.prismatic)) if np.any(~space.prismatic) else -1
    before, behind = _rotations(first, after, turning)
    mix = 0.0 if turning < 0 else float(np.sign(before[2] @ upright) or 1.0)
    zero = np.arctan2(h[4] @ np.cross(h[5], h[3]), h[5] @ h[3])
    return ArmShape(
        np.ascontiguousarray(first),
        np.ascontiguousarray(after),
        space.prismatic,
        turning,
        mix,
        before,
        behind,
        np.where(space.u_endless, -np.pi, space.u_lower),
        np.where(space.u_endless, np.pi, space.u_upper),
        float(axis2[0]),
        float(axis2[2]),
        aside,
        float(np.linalg.norm(upper)),
        float(np.linalg.norm(fore)),
        upper / np.linalg.norm(upper),
        fore / np.linalg.norm(fore),
        np.array([along_fore, across, h4[1]]),
        (space.arm.tool_T_foot @ np.append(space.arm.wrist, 1.0))[:3],
        R.T @ h[5],
        R.T @ lever,
        along,
        bent,
        float(reach @ reach),
        float(space.chain.length),
        space.lower,
        space.upper,
        np.array([-elbow, *third]),
        float(zero),
    )


def _frames(space: PlanSpace, E: Array, origin: Array) -> tuple[Array, Array]:
    """`first` and `after` of a shape; E (3, 3), origin (3,): the shoulder's axes and origin in the foot's frame."""
    shoulder_T_foot = np.eye(4)
    shoulder_T_foot[:3, :3], shoulder_T_foot[:3, 3] = E, -E @ origin
    count = len(space.after)
    after = np.array([np.linalg.inv(space.after[i]) for i in range(count)]).reshape(count, 4, 4)
    first = np.linalg.inv(space.first)
    if count:
        after[-1] = shoulder_T_foot @ after[-1]
    else:
        first = shoulder_T_foot @ first
    return np.asarray(first, np.float64), after


def _rotations(first: Array, after: Array, turning: int) -> tuple[Array, Array]:
    """`before` and `behind` of a shape."""
    before, behind = np.array(first[:3, :3], np.float64), np.eye(3)
    for i in range(len(after)):
        if i < turning:
            before = np.asarray(after[i, :3, :3] @ before, np.float64)
        else:
            behind = np.asarray(after[i, :3, :3] @ behind, np.float64)
    return before, behind


def _turned(v: Array) -> Array:
    """(x, z) turned by a quarter about y."""
    return np.array([v[1], -v[0]])


def _plate(cell: Cell) -> Array:
    """The mounting plate's origin in the zero posture, seen from the foot."""
    joints = cell.joints[cell.arm_slice]
    foot_T_next = np.eye(4)
    for joint in joints[:-1]:
        foot_T_next = foot_T_next @ joint.before @ joint.after
    foot_T_next = foot_T_next @ joints[-1].before
    return np.asarray((foot_T_next @ np.append(Arm.of(cell).chain.plate, 1.0))[:3])


def _not_covered(space: PlanSpace) -> str:
    if space.screws is not None:
        return "its arm has no spherical wrist behind two parallel axes"
    if abs(float(space.arm.h[0] @ space.arm.h[1])) > _SAME:
        return "its second axis isn't square to the first"
    if len(space.free) > SYMBOLS:
        return f"it has {len(space.free)} spare freedoms, more than {SYMBOLS}"
    if not len(space.free) or not space.roll:
        return "its tool's turn about its own axis is no freedom"
    if np.sum(~space.prismatic) > 1:
        return "more than one of its external axes turns"
    if np.any(~np.isfinite(space.u_lower) & ~space.u_endless):
        return "a spare freedom has no limits"
    return ""
