"""Where a long program is cut into sub-programs."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.errors import JobError

__all__ = ["split_parts"]


def split_parts(
    sizes: NDArray[np.int64],
    counted: NDArray[np.bool_],
    safe: NDArray[np.bool_],
    whole: NDArray[np.bool_],
    *,
    max_motions: int,
    max_bytes: int,
    line: NDArray[np.int64],
    start: int = 0,
) -> list[int]:
    """The motions before which to cut, from motion `start` on: ends of the parts, the last one being N.

    sizes: (N,) bytes that each row prints with what is written before it. counted: (N,) rows that are a motion.
    safe: (N,) rows after which a part may end. line: (N,) CL line of each row, for the error.
    whole: (N,) rows after which a part may end at need, in the middle of a cut: ends of motions. Each part is as long as
    its budget allows and ends at its last safe row; where none lies within the budget, at its last whole motion (a part
    has no initialisation, so that the controller runs on through the border). O(N). Raises JobError where not even one
    motion fits.
    """
    total = len(sizes)
    size_before = np.concatenate(([0], np.cumsum(sizes)))
    count_before = np.concatenate(([0], np.cumsum(counted)))
    allowed = np.flatnonzero(safe) + 1
    if not len(allowed) or allowed[-1] != total:
        allowed = np.append(allowed, total)
    mid_cut = np.flatnonzero(whole) + 1
    ends: list[int] = []
    while start < total:
        last = min(
            int(np.searchsorted(size_before, size_before[start] + max_bytes, side="right")) - 1,
            int(np.searchsorted(count_before, count_before[start] + max_motions, side="right")) - 1,
        )
        end = int(allowed[max(int(np.searchsorted(allowed, last, side="right")) - 1, 0)])
        if end > last or end <= start:  # no safe row within the budget: in the cut, after a whole motion
            end = int(mid_cut[max(int(np.searchsorted(mid_cut, last, side="right")) - 1, 0)])
        if end > last or end <= start:
            raise JobError(
                f"the program can't be split: a file may hold {max_motions} motions and {max_bytes} bytes, and motion "
                f"{start + 1} alone takes {int(size_before[start + 1] - size_before[start])} bytes; raise the budget",
                line=int(line[start]),
            )
        ends.append(end)
        start = end
    return ends
