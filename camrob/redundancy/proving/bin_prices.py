"""What a metre cut costs at least for tools seen alike, whatever the roll and branch, compiled: planes below the price."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.compiled import bare, kernel, part
from camrob.redundancy.proving.affine import SLACK
from camrob.redundancy.proving.arm_shape import ArmShape
from camrob.redundancy.proving.enclosure import WAYS
from camrob.redundancy.proving.seen_from_arm import bounds_of_bin

__all__ = ["corner_prices", "planes_of_bins"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_ROLLS = 8  # pieces of a turn to begin with
_MOST = 512  # pieces of a turn and planes of a bin, at most
_DEEP = 400  # boxes that wait, at most
_ROUGH = 0.05  # share of the price from which on a plane is rough
_FLATTER = 0.9  # share of a level plane that a sloping one's lowest place has at least
_MANY = 1000.0  # operations that a plane is made of, at most
_WORTH = (
    0.6,
    0.6,
    0.6,
    1.2,
    1.2,
)  # what widths cost a bound, measured: square root of the loss a m2 or rad2; axis, roll, tip


@bare
def _plane(power: float, threshold: float, form: Array, out: Array) -> float:
    """out (5,) <- middle and slopes (axis, axis, radius, height) of a plane below (threshold k_F)^power all over the box of a
    form that k_F^2 is nowhere below, whatever the roll; returns how far the price in the box's middle may be above it.
    """
    q, scale = 0.5 * power, threshold**power
    low = form[0] - form[6]
    for i in range(1, 6):
        low -= abs(form[i])
    flat = scale * max(low, 1.0) ** q * (1.0 - 100.0 * SLACK)
    for i in range(5):
        out[i] = 0.0
    y, over = form[0], 0.0
    if y > 1.0:
        top = scale * y**q
        slope = q * top / y
        middle = top - slope * (form[6] + abs(form[3])) - _MANY * SLACK * top
        if middle - slope * (abs(form[1]) + abs(form[2]) + abs(form[4]) + abs(form[5])) > _FLATTER * flat:
            out[0] = middle
            out[1], out[2], out[3], out[4] = slope * form[1], slope * form[2], slope * form[4], slope * form[5]
            return float(slope * (2.0 * form[6] + abs(form[3])))
        over = slope * form[6] + top - flat
    out[0] = flat
    spread = form[6]
    for i in range(1, 6):
        spread += abs(form[i])
    return float(max(over, 0.0)) if spread > 0.0 else np.inf  # a level form says that nothing better was known


@part
def _highest(shape: ArmShape, frame: Array, box: Array, ways: int, cap: float, most: int, deep: Array) -> float:
    """A bound of 1/k_F over a box, the highest first of `most` boxes that it is halved into; `cap` where none is above it.

    deep (P, 12): room, boxes with their ways and bounds.
    """
    best, below, one = np.empty(WAYS), np.empty((WAYS, 7)), np.zeros((2, 5))
    for i in range(5):
        deep[0, i], deep[0, 5 + i] = box[0, i], box[1, i]
    deep[0, 10], deep[0, 11] = ways, 1.0
    count, used = 1, 0
    while count > 0:
        top = 0
        for k in range(1, count):
            if deep[k, 11] > deep[top, 11]:
                top = k
        highest = deep[top, 11]
        if used >= most or count + 1 >= deep.shape[0]:
            return float(highest)
        wide, widest = 0, -1.0
        for i in range(5):
            one[0, i], one[1, i] = deep[top, i], deep[top, 5 + i]
            if _WORTH[i] * one[1, i] > widest:
                wide, widest = i, _WORTH[i] * one[1, i]
        middle, half, still = one[0, wide], one[1, wide], int(deep[top, 10])
        count -= 1
        deep[top] = deep[count]
        one[1, wide] = 0.5 * half * (1.0 + 1e-12) + 1e-15
        for side in range(2):
            one[0, wide] = middle + (side - 0.5) * half
            used += 1
            left = bounds_of_bin(shape, frame, one, still, best, below)
            open_, bound = 0, 0.0
            for way in range(WAYS):
                if left >> way & 1 and best[way] > cap:
                    open_ |= 1 << way
                    bound = max(bound, best[way])
            if open_ == 0:
                continue
            for i in range(5):
                deep[count, i], deep[count, 5 + i] = one[0, i], one[1, i]
            deep[count, 10], deep[count, 11] = open_, min(bound, highest)
            count += 1
    return cap


@bare
def _lowest(planes: Array, begin: int, end: int) -> float:
    """What planes `begin` to before `end` fall to in their bin."""
    least = np.inf
    for k in range(begin, end):
        low = planes[k, 0]
        for i in range(1, 5):
            low -= abs(planes[k, i])
        least = min(least, low)
    return float(least)


@part
def _planes(
    shape: ArmShape,
    power: float,
    threshold: float,
    frame: Array,
    box: Array,
    least: float,
    cap: float,
    few: int,
    planes: Array,
    store: Array,
    deep: Array,
) -> int:
    """planes (L, 5) <- planes of which the lowest, or the price at 1/k_F = cap, is below the price all over a bin; how many."""
    best, below, plane = np.empty(WAYS), np.empty((WAYS, 7)), np.empty(5)
    count, waiting = 0, _ROLLS
    for k in range(_ROLLS):
        half = np.pi / _ROLLS
        store[k, 0], store[k, 1], store[k, 2] = (2 * k + 1) * half - np.pi, half, (1 << WAYS) - 1
    while waiting > 0:
        waiting -= 1
        middle, half, ways = store[waiting, 0], store[waiting, 1], int(store[waiting, 2])
        box[0, 2], box[1, 2] = middle, half * (1.0 + 1e-12) + 1e-12
        left = bounds_of_bin(shape, frame, box, ways, best, below)
        first, rough, still = count, False, 0
        for way in range(WAYS):
            if left >> way & 1 and best[way] > cap:
                still |= 1 << way
                over = _plane(power, threshold, below[way], plane)
                rough = rough or over > _ROUGH * plane[0]
                planes[count] = plane
                count += 1
        if still == 0:
            continue
        if (
            half > least and first + WAYS * (waiting + 2) <= planes.shape[0]
        ):  # each piece that waits may leave a plane a way
            count = first
            for side in range(2):
                store[waiting, 0], store[waiting, 1] = middle + (side - 0.5) * half, 0.5 * half
                store[waiting, 2] = still
                waiting += 1
        elif rough and few > 0:
            top = _highest(shape, frame, box, still, cap, few, deep)
            level = (threshold / top) ** power * (1.0 - 100.0 * SLACK)
            if top <= cap:
                count = first
            elif level > _lowest(planes, first, count):
                count = first + 1
                planes[first] = 0.0
                planes[first, 0] = level
    return count


@kernel(nogil=True)
def planes_of_bins(
    shape: ArmShape, power: float, threshold: float, frame: Array, box: Array, cap: Array, least: float, few: int
) -> tuple[Ints, Array]:
    """Planes below the price for bins of tools seen alike: offset (B + 1,) and planes (P, 5), middle and slopes a half box.

    frame (B, 3, 3), box (B, 2, 5) of `bounds_of_bin`, the roll's aside; cap (B,): postures with no higher 1/k_F are passed over;
    least: half a piece of the roll that is not split any more; few: boxes that a rough piece is worth.
    """
    B = box.shape[0]
    offset, planes = np.zeros(B + 1, np.int64), np.empty((1024, 5))
    some, store, deep = np.empty((_MOST, 5)), np.empty((_MOST, 3)), np.empty((_DEEP, 12))
    for b in range(B):
        count = _planes(shape, power, threshold, frame[b], box[b].copy(), least, cap[b], few, some, store, deep)
        offset[b + 1] = offset[b] + count
        if offset[b + 1] > planes.shape[0]:
            more = np.empty((2 * offset[b + 1], 5))
            more[: offset[b]] = planes[: offset[b]]
            planes = more
        for k in range(count):
            planes[offset[b] + k] = some[k]
    return offset, planes[: offset[B]].copy()


@kernel(nogil=True)
def corner_prices(seen: Array, own: Ints, frame: Array, box: Array, offset: Ints, planes: Array, most: Array) -> Array:
    """Prices (M, 4) a metre at the corners of cells, below which no posture in the cell is: what is linear between them is lower.

    seen (M, SEEN, 4) of `seen_of_cells`; own (M,): the bin of each; frame, box, offset, planes of `planes_of_bins`; most (M,):
    the price at most.
    """
    out = np.empty((seen.shape[0], 4))
    form = np.empty((4, 4))
    for m in range(seen.shape[0]):
        b = own[m]
        for i in range(4):
            for c in range(4):  # the axis along x and y of the bin's frame, the radius, the height
                if i >= 2:
                    form[i, c] = seen[m, i - 2, c]
                else:
                    form[i, c] = 0.0
                    for r in range(3):
                        x = abs(frame[b, i, r]) if c == 3 else frame[b, i, r]
                        form[i, c] += x * seen[m, 2 + r, c]
            at = i if i < 2 else i + 1
            form[i, 0] -= box[b, 0, at]
            for c in range(4):
                form[i, c] /= box[b, 1, at]
        for c in range(4):
            out[m, c] = most[m]
        for k in range(offset[b], offset[b + 1]):
            middle, one, other = planes[k, 0], 0.0, 0.0
            for i in range(4):
                slope = planes[k, 1 + i]
                middle += slope * form[i, 0] - abs(slope) * (form[i, 3] + _MANY * SLACK)
                one += slope * form[i, 1]
                other += slope * form[i, 2]
            out[m, 0] = min(out[m, 0], middle - one - other)
            out[m, 1] = min(out[m, 1], middle - one + other)
            out[m, 2] = min(out[m, 2], middle + one - other)
            out[m, 3] = min(out[m, 3], middle + one + other)
    return out
