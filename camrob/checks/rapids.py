"""Rapids of the CL file through stock that nothing has cut by then: reckoned coarsely, so that a sound file raises no alarm."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from camrob.findings import Finding
from camrob.toolpath.region import Move, Region, goes_on
from camrob.units import m_to_mm, mm_to_m

__all__ = ["rapids_in_stock"]

Array = NDArray[np.float64]

_SKIN = mm_to_m(0.1)  # that near to its faces the tool only touches the stock
_ASSUMED = mm_to_m(10.0)  # a tool's diameter where nobody states it
_LEAST = mm_to_m(1.0)  # of a cell of the grid
_MOST_CELLS = 4_000_000
_NEAR = 2  # cells: a diameter
_NEVER = 1 << 52


def rapids_in_stock(
    regions: Sequence[Region], box: Array, diameter: float, depth: Callable[[Array], Array] | None = None
) -> Finding | None:
    """A warning where the tool's tip goes in rapid through the stock, and no earlier cut has been within a diameter of there.

    box: (2, 3) m, least and greatest corner of the stock in the CL data's frame. diameter: m, of the widest tool, 0.0 where it
    isn't known. depth: of a stock that doesn't fill its box, how far points (N, 3) in the box lie within it, m, not above 0
    outside. What lies above a cut along the tool's axis counts as removed. The way down to a region's first point is camrob's
    own, along the tool's axis; it counts where the file has the tool come in rapid.
    """
    within = depth or (lambda points: _depth(points, box))
    worked = [r for r in regions if len(r)]
    starts = _starts(worked)
    count = np.cumsum([0, *(len(r) for r in worked)])
    hits: list[tuple[int, float]] = []
    rapid = [_inside_samples(r, s, box, within) for r, s in zip(worked, starts, strict=True)]
    if not any(len(points) for points, _ in rapid):
        return None
    grid = _Grid(box, diameter or _ASSUMED)
    for k, region in enumerate(worked):
        grid.cut(region, starts[k], box, int(count[k]))
    removed = grid.removed()
    for k, (points, row) in enumerate(rapid):
        through = removed[grid.cells(points)] > row + count[k]
        for n in np.unique(row[through]).tolist():
            deep = float(within(points[through & (row == n)]).max())
            hits.append((int(worked[k].line[n]), deep))
    if not hits:
        return None
    line, _ = hits[0]
    deepest = m_to_mm(max(deep for _, deep in hits))
    text = (
        f"the file moves in rapid through stock that has not been cut, {deepest:.1f} mm deep; "
        "correct it in the CAM system, or the [stock] of setup.toml"
    )
    return Finding("rapid-in-stock", text, line=line, count=len(hits))


def _starts(worked: Sequence[Region]) -> list[Array | None]:
    """(3,) where the tool is before each region's first motion, None where camrob brings it there from above."""
    out: list[Array | None] = []
    for k, region in enumerate(worked):
        known = k > 0 and (
            goes_on(worked[k - 1], region) or np.array_equal(region.position[0], worked[k - 1].position[-1])
        )
        out.append(np.asarray(worked[k - 1].position[-1]) if known else None)
    return out


def _ways(region: Region, start: Array | None, box: Array) -> tuple[Array, Array]:
    """Begin and end (N, 3) of each motion of a region."""
    end = np.asarray(region.position)
    begin = np.concatenate([end[:1] if start is None else start[None], end[:-1]])
    if start is None:
        begin[0] = end[0] + float(np.linalg.norm(box[1] - box[0])) * np.asarray(region.axis[0])
    return begin, end


def _sampled(begin: Array, end: Array, step: float) -> tuple[Array, NDArray[np.int64]]:
    """Points (M, 3) along ways (N, 3) at most `step` apart, their ends among them, and which way each is of."""
    counts = np.maximum(np.ceil(np.linalg.norm(end - begin, axis=1) / step), 1).astype(np.int64)
    row = np.repeat(np.arange(len(counts)), counts)
    share = (np.arange(len(row)) - np.repeat(np.cumsum(counts) - counts, counts) + 1.0) / counts[row]
    return begin[row] + share[:, None] * (end - begin)[row], row


def _depth(points: Array, box: Array) -> Array:
    """(N,) how far points lie within the box, from its nearest face; negative outside."""
    return np.asarray(np.minimum(points - box[0], box[1] - points).min(axis=1))


def _inside_samples(
    region: Region, start: Array | None, box: Array, within: Callable[[Array], Array]
) -> tuple[Array, NDArray[np.int64]]:
    """Points of a region's rapids within the stock, and the motions that they are of."""
    rapid = np.flatnonzero(np.asarray(region.move) == Move.RAPID)
    begin, end = _ways(region, start, box)
    low, high = np.minimum(begin, end)[rapid], np.maximum(begin, end)[rapid]
    rapid = rapid[np.all((high > box[0] + _SKIN) & (low < box[1] - _SKIN), axis=1)]
    points, row = _sampled(begin[rapid], end[rapid], _LEAST)
    inside = np.flatnonzero(_depth(points, box) > _SKIN)
    inside = inside[within(points[inside]) > _SKIN]
    return points[inside], rapid[row[inside]]


class _Grid:
    """When each cell of the stock, and of a rim around it, was first cut: the number of the motion."""

    def __init__(self, box: Array, diameter: float) -> None:
        size = box[1] - box[0]
        least = float(np.cbrt(np.prod(np.maximum(size, _LEAST)) / _MOST_CELLS))
        self.step = max(0.5 * diameter, _LEAST, least)
        self.low = box[0] - _NEAR * self.step
        self.shape = np.ceil(size / self.step).astype(np.int64) + 2 * _NEAR + 1
        self.first = np.full(self.shape, _NEVER)

    def cut(self, region: Region, start: Array | None, box: Array, begin: int) -> None:
        """A region's cuts, the first of whose motions is number `begin`: where they go, and what stands above along the axis."""
        cuts = np.flatnonzero(region.cutting)
        ways = _ways(region, start, box)
        points, row = _sampled(ways[0][cuts], ways[1][cuts], self.step)
        cell = self._cell(points)
        near = np.all((cell >= 0) & (cell < self.shape), axis=1)
        points, row, cell = points[near], row[near], cell[near]
        _, fresh = np.unique(np.ravel_multi_index(cell.T, self.shape), return_index=True)  # the earliest in each cell
        points, row = points[fresh], row[fresh]
        axis, time = np.asarray(region.axis)[cuts[row]], cuts[row] + begin
        for k in range(int(np.linalg.norm(self.shape)) + 1):
            cell = self._cell(points + k * self.step * axis)
            near = np.all((cell >= 0) & (cell < self.shape), axis=1)
            np.minimum.at(self.first, tuple(cell[near].T), time[near])

    def removed(self) -> NDArray[np.int64]:
        """When something within a diameter of each cell was first cut."""
        least = self.first
        for axis, n in enumerate(least.shape):  # a box is the same along each axis in turn
            padded = np.pad(least, [(_NEAR, _NEAR) if d == axis else (0, 0) for d in range(3)], mode="edge")
            shifted = (padded[(*[slice(None)] * axis, slice(k, k + n))] for k in range(2 * _NEAR + 1))
            least = reduce(np.minimum, shifted)
        return np.asarray(least)

    def cells(self, points: Array) -> tuple[NDArray[np.int64], ...]:
        """The index of the cells that points (N, 3) in the stock lie in."""
        return tuple(self._cell(points).T)

    def _cell(self, points: Array) -> NDArray[np.int64]:
        return np.asarray(np.floor((points - self.low) / self.step).astype(np.int64))
