"""Branch and bound over boxes of the freedoms and bundles of poses: that no posture along a path beats a value, compiled."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import kernel
from camrob.redundancy.proving.arm_shape import ArmShape
from camrob.redundancy.proving.enclosure import WAYS, bounds_of_box

__all__ = ["Bundles", "bound_of_box", "refute"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_DEPTH = 4000  # boxes that wait, at most
_WIDE = 0.3  # rad or m, weighed: half a box that is split before anything is asked of it
_SHARE = 1.0  # of a bundle's size, that boxes are split down to before it is


class Bundles(NamedTuple):
    """A tree of bundles of poses.

    poses (K, 9, 3): a frame's x, y, z and origin; twice, what z and the origin change by with a symbol of the bundle; and how
    far z and
    the origin of any of the bundle's poses are off that at most, m (the third of the row: 0). parts (K, 2): the two bundles
    that it falls into, -1 where it does not. size (K,): how far they lie apart, m and rad summed.
    target (K,): what is to be shown that none of its postures beats.
    """

    poses: Array
    parts: Ints
    size: Array
    target: Array


@kernel
def bound_of_box(shape: ArmShape, pose: Array, box: Array) -> Array:
    """Upper bounds (WAYS,) of 1/k_F over a box (2, 3) and a bundle (9, 3), 0 where a way has no posture."""
    best = np.zeros(WAYS)
    left = bounds_of_box(shape, pose, box, 15, best, np.zeros((WAYS, 7)))
    for k in range(WAYS):
        if not left >> k & 1:
            best[k] = 0.0
    return best


@kernel(nogil=True)
def refute(shape: ArmShape, bundles: Bundles, weight: Array, least: float, most: int) -> tuple[Array, int]:
    """What each bundle (K,) is shown not to beat, its target or more; how many boxes it took.

    weight (F,): how dear a box's width is along each freedom. Boxes that are still open at half a width of `least`, weighed, or
    when `most` boxes have been looked at, leave their own bound.
    """
    F = shape.lower.shape[0]
    boxes, alive, known = np.zeros((_DEPTH, 2, 3)), np.zeros(_DEPTH, np.int64), np.ones(_DEPTH)
    where = np.zeros(_DEPTH, np.int64)
    for i in range(F):
        boxes[0, 0, i] = 0.5 * (shape.lower[i] + shape.upper[i])
        boxes[0, 1, i] = 0.5 * (shape.upper[i] - shape.lower[i]) * (1.0 + 1e-12) + 1e-12
    alive[0] = (1 << WAYS) - 1
    count, used, shown = 1, 0, bundles.target.copy()
    best, below, box = np.empty(WAYS), np.empty((WAYS, 7)), np.empty((2, 3))
    while count > 0:
        count -= 1
        box[:] = boxes[count]
        ways, above, k = alive[count], known[count], where[count]
        if used >= most or count + 2 >= _DEPTH:
            shown[k] = max(shown[k], above)
            continue
        wide, widest = 0, -1.0
        for i in range(F):
            if weight[i] * box[1, i] > widest:
                wide, widest = i, weight[i] * box[1, i]
        if widest < _WIDE:
            used += 1
            left = bounds_of_box(shape, bundles.poses[k], box, ways, best, below)
            ways, above = 0, 0.0
            for way in range(WAYS):
                if left >> way & 1 and best[way] > shown[k]:
                    ways |= 1 << way
                    above = max(above, best[way])
            if ways == 0:
                continue
            if bundles.parts[k, 0] >= 0 and widest < _SHARE * bundles.size[k]:
                for side in range(2):
                    boxes[count] = box
                    alive[count], known[count], where[count] = ways, above, bundles.parts[k, side]
                    count += 1
                continue
            if widest < least:
                shown[k] = above
                continue
        for side in range(2):
            boxes[count] = box
            boxes[count, 1, wide] = 0.5 * box[1, wide]
            boxes[count, 0, wide] = box[0, wide] + (side - 0.5) * box[1, wide]
            alive[count], known[count], where[count] = ways, above, k
            count += 1
    return shown, used
