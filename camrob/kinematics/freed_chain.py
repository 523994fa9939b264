"""A chain of any number of axes, six of which are solved for in closed form, the others given: all postures of a pose.

What is given are the freedoms: external axes, the virtual roll, the seventh axis of an arm, a lift beneath it. With them in place
the other six are an arm whose screw axes are known, wherever in the chain they stand, and `screw_arm` has its postures.
Which axes are given is taken from the geometry: of the choices that leave a closed form with all postures, the one whose axes
move most when the tool stands still, for these are what a grid is best laid over. A choice whose postures are searched for, and
may be missed, does only where there is no other.
"""

from __future__ import annotations

from itertools import combinations
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.compiled import kernel, part
from camrob.errors import CellError
from camrob.frame_steps import compose, move_joint
from camrob.kinematics.frames import base_T_joint_axes, base_T_tool, tool_jacobians
from camrob.kinematics.kernels import chain_arrays
from camrob.kinematics.screw_arm import OFFSET, ScrewArm, solve_screws
from camrob.kinematics.screw_families import screw_arm
from camrob.kinematics.spherical_wrist import BRANCH_OK

__all__ = ["FreedChain", "freed_chain", "freed_chains", "postures_at", "reach_chain"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_SOLVED = 6  # axes that a pose asks for
_COPLANAR = 1e-9  # m
_TRIED = 3  # postures of the given axes at which the six have to be of one family
_HARDER = 0.5  # what self-motion is worth where each pose costs a quartic, some 100 microseconds more
_SEEN = 40  # postures over which self-motion is looked at


class FreedChain(NamedTuple):
    """first (4, 4), after (n, 4, 4), prismatic (n,): the chain base to tool. six (6,): the axes solved for; given (k,): the
    others. family, mirrored: see `ScrewArm`. lower, upper, center (n,): limits, and where turns are counted from. endless (n,).
    """

    first: Array
    after: Array
    prismatic: NDArray[np.bool_]
    six: Ints
    given: Ints
    family: int
    mirrored: bool
    lower: Array
    upper: Array
    center: Array
    endless: NDArray[np.bool_]


def freed_chains(cell: Cell) -> list[FreedChain]:
    """The freed chains of a cell, one for each choice of axes that leaves a closed form with all postures, the best first; those
    that leave a searched one where there is no other.

    Raises CellError where no choice of six of its turning axes has one.
    """
    n = len(cell)
    arm = [i for i, j in enumerate(cell.joints) if not j.prismatic and j.role is Role.ARM]
    whole = chain_arrays(cell)
    lower, upper = cell.q_lower, cell.q_upper
    found: list[tuple[float, FreedChain]] = []
    for six in [tuple(arm)] if len(arm) == _SOLVED else combinations(arm, _SOLVED):
        family = _family(cell, six)
        if family is None:
            continue
        given = [i for i in range(n) if i not in six]
        worth = _self_motion(cell, given) * (1.0 if _plain(family) else _HARDER)
        chain = FreedChain(
            whole.first,
            whole.after,
            whole.prismatic,
            np.array(six, np.int64),
            np.array(given, np.int64),
            family.family,
            family.mirrored,
            lower,
            upper,
            _middle(lower, upper),
            cell.endless,
        )
        found.append((worth, chain))
    if not found:
        what = f"cell {cell.name}: no six of its turning axes have a closed form for all their postures"
        raise CellError(what, hint="use --method vjm")
    proved = [one for one in found if one[1].family != OFFSET]
    return [chain for _, chain in sorted(proved or found, key=lambda one: -one[0])]


def freed_chain(cell: Cell) -> FreedChain:
    """The best of `freed_chains`."""
    return freed_chains(cell)[0]


def _middle(lower: Array, upper: Array) -> Array:
    """The middle of the limits, 0 where an axis has none."""
    limited = np.isfinite(lower) & np.isfinite(upper)
    return np.where(limited, 0.5 * (np.where(limited, lower, 0.0) + np.where(limited, upper, 0.0)), 0.0)


def _family(cell: Cell, six: tuple[int, ...]) -> ScrewArm | None:
    """The closed form of six axes, the same wherever the others stand; None where there is none."""
    found = None
    rng = np.random.default_rng(3)
    for _ in range(_TRIED):
        q = rng.uniform(np.maximum(cell.q_lower, -1.0), np.minimum(cell.q_upper, 1.0) + 1e-9)
        q[list(six)] = 0.0
        axes = base_T_joint_axes(cell, q)[list(six)]
        arm = screw_arm(axes[:, :3, 2], axes[:, :3, 3], base_T_tool(cell, q))  # frames: foot is base
        if arm is None or not np.allclose(arm.h, arm.true_h) or (found and (found.family, found.mirrored) != arm[:2]):
            return None
        found = arm
    return found


def _plain(arm: ScrewArm) -> bool:
    """Whether the first two axes meet or are parallel, so that cones do."""
    return abs(float(np.cross(arm.h[0], arm.h[1]) @ (arm.o[1] - arm.o[0]))) < _COPLANAR


def _self_motion(cell: Cell, given: list[int]) -> float:
    """How much of the motions that leave the tool where it is lies in the given axes, on the average, 0 to 1."""
    if not given:
        return 0.0
    rng = np.random.default_rng(5)
    q = rng.uniform(np.maximum(cell.q_lower, -np.pi), np.minimum(cell.q_upper, np.pi), (_SEEN, len(cell)))
    total = 0.0
    for J in tool_jacobians(cell, q):
        null = np.linalg.svd(J)[2][6:]
        total += float(np.abs(np.linalg.det(null[:, given]))) ** (1.0 / len(given))
    return total / _SEEN


@part
def postures_at(chain: FreedChain, R: Array, p: Array, q: Array, Q: Array, why: Ints) -> int:
    """All postures of the six that put the tool at rotation R (3, 3), position p (3,) in `base`, the given axes held as in
    q (n,); the six's own entries are where turns are counted from. Q (8, 6), why (8,), as `solve_screws` fills them.
    """
    h, o = np.empty((6, 3)), np.empty((6, 3))
    T, d, foot = np.empty((3, 3)), np.empty(3), np.eye(4)
    for r in range(3):
        d[r] = chain.first[r, 3]
        for c in range(3):
            T[r, c] = chain.first[r, c]
    k = 0
    for i in range(chain.after.shape[0]):
        if k < 6 and chain.six[k] == i:
            for r in range(3):
                h[k, r], o[k, r] = T[r, 2], d[r]
            k += 1
        else:
            move_joint(T, d, chain.prismatic[i], q[i])
        compose(T, d, chain.after[i])
    for r in range(3):
        foot[r, 3] = -(T[0, r] * d[0] + T[1, r] * d[1] + T[2, r] * d[2])
        for c in range(3):
            foot[r, c] = T[c, r]
    near = np.empty(6)
    for i in range(6):
        near[i] = q[chain.six[i]]
    if chain.mirrored:
        g, a = np.empty((6, 3)), np.empty((6, 3))
        for i in range(6):
            for r in range(3):
                g[i, r], a[i, r] = -h[5 - i, r], o[5 - i, r]
        h, o = g, a
    return int(solve_screws(ScrewArm(chain.family, chain.mirrored, h, o, h, o, foot), R, p, near, Q, why))


@kernel
def reach_chain(chain: FreedChain, base_T_tool: Array, q: Array) -> Array:
    """Postures (K, n), K at most 8, that put the tool at a pose (4, 4) with the given axes as in q (n,); limits are not asked."""
    Q, why, R, p = np.empty((8, 6)), np.empty(8, np.int64), np.empty((3, 3)), np.empty(3)
    for r in range(3):
        p[r] = base_T_tool[r, 3]
        for c in range(3):
            R[r, c] = base_T_tool[r, c]
    postures_at(chain, R, p, q, Q, why)
    out = np.empty((8, q.shape[0]))
    count = 0
    for b in range(8):
        if why[b] == BRANCH_OK:
            for i in range(q.shape[0]):
                out[count, i] = q[i]
            for i in range(6):
                out[count, chain.six[i]] = Q[b, i]
            count += 1
    return out[:count]
