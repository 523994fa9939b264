"""How a tool is seen from the arm: what 1/k_F depends on, whatever way table, track and axis 1 brought it there, compiled.

A turn about axis 1 leaves 1/k_F alone. So a pose is five numbers (`SEEN`): the tip's distance from axis 1 and its height, and the
tool's axis along the radius, across it, and up; and the roll, which is free. Poses and places of the external axes that
look alike from the arm share what is enclosed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel, part
from camrob.redundancy.proving.affine import (
    SLACK,
    Form,
    cosine_sine,
    highest,
    inverse,
    lowest,
    minus,
    mixed,
    plus,
    root,
    scaled,
    square,
    times,
)
from camrob.redundancy.proving.arm_shape import ArmShape
from camrob.redundancy.proving.enclosure import Vector, bounds_of_arm, moved, unturned

__all__ = ["SEEN", "Lattice", "bounds_of_bin", "seen_of_cells"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

SEEN = 5
"""Radius, height, axis along the radius, across it, up."""
_NEAR = 0.01  # share of the farthest squared distance from axis 1 in a cell below which nothing is said of the cell


class Lattice(NamedTuple):
    """The lattice of the external axes: low, step, half (2,): its first node, its step, half a cell, padded."""

    low: Array
    step: Array
    half: Array


@part
def _constant(c: float) -> Form:
    return c, 0.0, 0.0, 0.0, 0.0, 0.0, SLACK * abs(c)


@part
def _put(out: Array, i: int, x: Form) -> None:
    out[i, 0], out[i, 1], out[i, 2], out[i, 3] = x[0], x[1], x[2], x[6]


@kernel(nogil=True)
def seen_of_cells(shape: ArmShape, tip: Array, axis: Array, lattice: Lattice, where: Ints, cell: Ints) -> Array:
    """How the poses where (M,) of tips and axes (W, 3) are seen all over cells (M, 2) of the external axes: forms (M, SEEN, 4).

    A form: its middle, what it changes by from the middle of the cell to the end along each external axis, and what is left; of a
    cell that is too near axis 1, NaN.
    """
    out = np.empty((cell.shape[0], SEEN, 4))
    for m in range(cell.shape[0]):
        o, n = tip[where[m]], axis[where[m]]
        p = moved(shape.first, (_constant(o[0]), _constant(o[1]), _constant(o[2])))
        R = shape.first[:3, :3]
        z = (
            _constant(R[0, 0] * n[0] + R[0, 1] * n[1] + R[0, 2] * n[2]),
            _constant(R[1, 0] * n[0] + R[1, 1] * n[1] + R[1, 2] * n[2]),
            _constant(R[2, 0] * n[0] + R[2, 1] * n[1] + R[2, 2] * n[2]),
        )
        for i in range(shape.after.shape[0]):
            middle = lattice.low[i] + (cell[m, i] + 0.5) * lattice.step[i]
            half, e = lattice.half[i], SLACK * (abs(middle) + lattice.half[i])
            u = (middle, half if i == 0 else 0.0, half if i == 1 else 0.0, 0.0, 0.0, 0.0, e)
            if shape.prismatic[i]:
                p = p[0], p[1], minus(p[2], u)
            else:
                c, s = cosine_sine(u)
                p, z = unturned(c, s, p), unturned(c, s, z)
            p = moved(shape.after[i], p)
            B = shape.after[i]
            z = (
                mixed(B[0, 0], z[0], B[0, 1], z[1], B[0, 2], z[2], 0.0),
                mixed(B[1, 0], z[0], B[1, 1], z[1], B[1, 2], z[2], 0.0),
                mixed(B[2, 0], z[0], B[2, 1], z[1], B[2, 2], z[2], 0.0),
            )
        far = plus(square(p[0]), square(p[1]))
        low, high = lowest(far), highest(far)
        if low < _NEAR * high:
            out[m] = np.nan
            continue
        radius = root(far, low, high)
        over = inverse(radius, np.sqrt(low), np.sqrt(high))
        _put(out[m], 0, radius)
        _put(out[m], 1, p[2])
        _put(out[m], 2, times(plus(times(z[0], p[0]), times(z[1], p[1])), over))
        _put(out[m], 3, times(minus(times(z[1], p[0]), times(z[0], p[1])), over))
        _put(out[m], 4, z[2])
    return out


@part
def _along(k: Array, turn: tuple[Form, Form], axes: tuple[Vector, Vector, Vector]) -> Vector:
    """A vector (3,) of the tool seen from the shoulder."""
    c, s = turn
    one, other = mixed(k[0], c, -k[1], s, 0.0, c, 0.0), mixed(k[0], s, k[1], c, 0.0, c, 0.0)
    X, Y, Z = axes
    whole: Vector = (
        plus(plus(times(one, X[0]), times(other, Y[0])), scaled(Z[0], k[2])),
        plus(plus(times(one, X[1]), times(other, Y[1])), scaled(Z[1], k[2])),
        plus(plus(times(one, X[2]), times(other, Y[2])), scaled(Z[2], k[2])),
    )
    return whole


@part
def bounds_of_bin(shape: ArmShape, frame: Array, box: Array, alive: int, best: Array, below: Array) -> int:
    """`enclosure.bounds_of_box` for tools seen alike.

    frame (3, 3): rows x, y and z, about where the tool's axis points, in the plane of the tip's radius; box (2, 5): middle and
    half of what the axis goes along x and along y, of the roll about it, of the tip's radius and of its height.
    """
    x, y, z = frame[0], frame[1], frame[2]
    a = (box[0, 0], box[1, 0], 0.0, 0.0, 0.0, 0.0, SLACK * (abs(box[0, 0]) + box[1, 0]))
    b = (box[0, 1], 0.0, box[1, 1], 0.0, 0.0, 0.0, SLACK * (abs(box[0, 1]) + box[1, 1]))
    roll = (box[0, 2], 0.0, 0.0, box[1, 2], 0.0, 0.0, SLACK * (abs(box[0, 2]) + box[1, 2]))
    radius = (box[0, 3], 0.0, 0.0, 0.0, box[1, 3], 0.0, SLACK * (abs(box[0, 3]) + box[1, 3]))
    height = (box[0, 4], 0.0, 0.0, 0.0, 0.0, box[1, 4], SLACK * (abs(box[0, 4]) + box[1, 4]))
    # the axis is a x + b y + c z; the frame is carried there by the least turn, which takes x to x (1 - a a') - y a b' - z a,
    # with a' = a / (1 + c)
    aa, bb = square(a), square(b)
    flat = plus(aa, bb)
    most = max(highest(flat), 0.0)
    if most > 0.5:
        for way in range(4):
            best[way] = 1.0
            below[way] = 0.0
            below[way, 0] = 1.0 - SLACK
        return alive
    one = (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    under = minus(one, flat)
    c = root(under, max(lowest(under), 0.25), highest(under))
    more = plus(c, one)
    share = inverse(more, lowest(more), highest(more))
    xx, xy, yy = minus(one, times(aa, share)), times(times(a, b), share), minus(one, times(bb, share))
    X = (
        mixed(x[0], xx, -y[0], xy, -z[0], a, 0.0),
        mixed(x[1], xx, -y[1], xy, -z[1], a, 0.0),
        mixed(x[2], xx, -y[2], xy, -z[2], a, 0.0),
    )
    Y = (
        mixed(-x[0], xy, y[0], yy, -z[0], b, 0.0),
        mixed(-x[1], xy, y[1], yy, -z[1], b, 0.0),
        mixed(-x[2], xy, y[2], yy, -z[2], b, 0.0),
    )
    Z = (
        mixed(x[0], a, y[0], b, z[0], c, 0.0),
        mixed(x[1], a, y[1], b, z[1], c, 0.0),
        mixed(x[2], a, y[2], b, z[2], c, 0.0),
    )
    turn, axes = cosine_sine(roll), (X, Y, Z)
    w, h6 = _along(shape.wrist, turn, axes), _along(shape.sixth, turn, axes)
    r = h6
    if shape.bent:
        r = _along(shape.lever, turn, axes)
    w = plus(w[0], radius), w[1], plus(w[2], height)
    left: int = bounds_of_arm(shape, w, h6, r, alive, best, below)
    return left
