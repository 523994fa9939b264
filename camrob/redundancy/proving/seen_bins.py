"""Cells of the external axes sorted into bins in which the tool is seen alike from the arm."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.redundancy.proving.seen_from_arm import SEEN

__all__ = ["Bins", "bins_of", "lies_within"]

Array = NDArray[np.float64]
Bools = NDArray[np.bool_]
Ints = NDArray[np.int64]

_WORTH = np.array([1.2, 1.2, 0.6, 0.6, 0.6])  # as widths are weighed in `bin_prices`
_ROUNDING, _LEAST = 1e-12, 1e-9  # m and rad: what is added to a box, and half of the smallest
_AT = [0, 1, 3, 4]  # of a box: all but the roll
_WIDER = 0.01  # of a box: what the checker's enclosure of its cells may be wider by; planes are to hold there too


class Bins(NamedTuple):
    """B bins: own (M,): of each cell; frame (B, 3, 3), box (B, 2, 5): as of `seen.bounds_of_bin`, the roll's place empty."""

    own: Ints
    frame: Array
    box: Array


def bins_of(seen: Array, width: float) -> Bins:
    """Bins of cells seen (M, SEEN, 4): the middles of a bin's cells lie within `width`, weighed; its box holds all."""
    feature = seen[:, :, 0] * _WORTH
    own = np.empty(len(seen), np.int64)
    frames: list[Array] = []
    boxes: list[Array] = []
    waiting = [np.arange(len(seen))] if len(seen) else []
    while waiting:
        some = waiting.pop()
        low, high = feature[some].min(axis=0), feature[some].max(axis=0)
        i = int(np.argmax(high - low))
        if high[i] - low[i] > width:
            below = feature[some, i] < 0.5 * (low[i] + high[i])
            if below.any() and not below.all():
                waiting += [some[below], some[~below]]
                continue
        own[some] = len(frames)
        frame, box = _bin(seen[some])
        frames.append(frame)
        boxes.append(box)
    return Bins(own, np.array(frames).reshape(-1, 3, 3), np.array(boxes).reshape(-1, 2, SEEN))


def lies_within(seen: Array, frame: Array, box: Array) -> Bools:
    """Which cells seen (M, SEEN, 4) lie in a box (M, 2, 5) of a frame (M, 3, 3) each, with half of the room that the box of cells
    of its own leaves them.
    """
    middle, far = _across(seen, frame[:, :2])
    off = np.abs(middle - box[:, 0, _AT]) + far
    return np.asarray(np.all(off * (1.0 + 0.5 * _WIDER) <= box[:, 1, _AT], axis=1))


def _across(seen: Array, rows: Array) -> tuple[Array, Array]:
    """The middles (M, 4) and how far cells reach from there: the axis along two rows (M, 2, 3) of a frame, radius, height."""
    across = np.einsum("mrc,mxr->mcx", seen[:, 2:, :3], rows)  # (M, 3, 2)
    left = np.einsum("mr,mxr->mx", seen[:, 2:, 3], np.abs(rows))
    middle = np.hstack([across[:, 0], seen[:, :2, 0]])
    far = np.hstack([np.abs(across[:, 1]) + np.abs(across[:, 2]) + left, np.abs(seen[:, :2, 1:]).sum(axis=2)])
    return middle, far


def _bin(seen: Array) -> tuple[Array, Array]:
    """The frame and the box of one bin."""
    z = seen[:, 2:, 0].mean(axis=0)
    z = z / np.linalg.norm(z)
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = x - (x @ z) * z
    x = x / np.linalg.norm(x)
    frame = np.array([x, np.cross(z, x), z])
    middle, far = _across(seen, np.broadcast_to(frame[:2], (len(seen), 2, 3)))
    low, high = (middle - far).min(axis=0), (middle + far).max(axis=0)
    box = np.zeros((2, SEEN))
    box[0, _AT] = 0.5 * (low + high)
    box[1, _AT] = np.maximum(0.5 * (high - low) + _ROUNDING, _LEAST) * (1.0 + _WIDER)
    return frame, box
