"""What is seen of the stock from six sides while it is cut: how far in the first material lies on each ray, and since when."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cutting.dexels import Dexels, Moves

__all__ = ["SeenSide", "SeenStock", "seen_stock"]

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

_RAYS = 24_000  # of the sides that change: what a page and a browser without a graphics card carry
_LOOK = 3_000  # rays of all sides, of the first look at which of them change
_FINEST = 5e-5  # m between rays: no screen shows less
_STAGES = 5  # of the cut's time: of what is cut again within one, the last is shown
_SIDES = tuple((d, facing) for d in range(3) for facing in (-1, 1))


@dataclass(frozen=True, slots=True)
class SeenSide:
    """One side's rays, U x V of them, along an axis of the part's frame.

    axis: 0, 1 or 2; facing: +1 where the side looks along the axis, else -1. first: (2,) coordinates of the first ray on the two
    other axes, in cyclic order, m. height: (S + 1, U, V) coordinate on the axis where the first material begins, before
    the cut and after each stage, NaN where the ray meets none, or none within the box; far: likewise, where that material ends.
    since: (S, U, V) s at which a stage changed it, NaN where it did not.
    """

    axis: int
    facing: int
    first: Array
    height: Array
    far: Array
    since: Array


@dataclass(frozen=True, slots=True)
class SeenStock:
    """The six sides of the box, lower to upper (3,) m, that the cut keeps within; pitch: m between its rays."""

    lower: Array
    upper: Array
    pitch: float
    sides: tuple[SeenSide, ...]


def seen_stock(stock: Array, moves: Moves, at: Array, *, rays: int = _RAYS) -> SeenStock | None:
    """The stock's triangles (T, 3, 3), m, as `moves`, which end at times `at` (N,) s, cut it; None where nothing is cut.

    Only the box round what is cut is looked at, with some `rays` rays on the sides that change: outside it the stock stays what
    it is. Raises InputError for stock whose mesh isn't closed.
    """
    box = _box_of_cut(stock, moves)
    if box is None:
        return None
    size = box[1] - box[0]
    areas = np.array([size[(d + 1) % 3] * size[(d + 2) % 3] for d, _ in _SIDES])
    rough = _looked_at(stock, moves, at, box, max(float(np.sqrt(areas.sum() / _LOOK)), _FINEST), 1)
    changes = np.array([np.isfinite(s.since).any() for s in rough.sides])
    if not changes.any():  # what is cut is finer than the first look
        changes[:] = True
    found = _looked_at(stock, moves, at, box, max(float(np.sqrt(areas[changes].sum() / rays)), _FINEST), _STAGES)
    return found if any(np.isfinite(s.since).any() for s in found.sides) else None


def _looked_at(stock: Array, moves: Moves, at: Array, box: tuple[Array, Array], pitch: float, stages: int) -> SeenStock:
    """The stock within a box, by rays of a pitch, m, after each of so many stages of the cut's time."""
    lower, upper = box[0] - 1.5 * pitch, box[1] + 1.5 * pitch
    dexels = Dexels(lower, upper, pitch).inside(stock)
    edges = np.linspace(float(at[0]), float(at[-1]), stages + 1)
    stage = np.clip(np.searchsorted(edges, at, side="left") - 1, 0, stages - 1)
    looks = [[_first(dexels, d, facing) for d, facing in _SIDES]]
    since: list[list[Array]] = []
    for k in range(stages):
        own = stage == k
        if own.any():  # the numbers of the moves stay those of the whole cut
            dexels.carve(Moves(moves.tip, moves.axis, np.where(own, moves.cutter, -1), moves.cutters))
        looks.append([_first(dexels, d, facing) for d, facing in _SIDES])
        since.append([_since(*pair, at, own) for pair in zip(looks[-2], looks[-1], strict=True)])
    sides = [
        SeenSide(
            d,
            facing,
            dexels.grid(d)[:2],
            np.stack([look[n][0] for look in looks]),
            np.stack([look[n][1] for look in looks]),
            np.stack([stages[n] for stages in since]),
        )
        for n, (d, facing) in enumerate(_SIDES)
    ]
    return SeenStock(lower, upper, pitch, tuple(sides))


def _box_of_cut(stock: Array, moves: Moves) -> tuple[Array, Array] | None:
    """The corners of a box round all places where a cutter may touch the stock's own box."""
    low, high = stock.reshape(-1, 3).min(axis=0), stock.reshape(-1, 3).max(axis=0)
    shape = moves.shape
    ends = np.concatenate([moves.tip, moves.tip + shape[:, None, 2:3] * moves.axis], axis=1)
    lower = np.maximum(ends.min(axis=1) - shape[:, :1], low)
    upper = np.minimum(ends.max(axis=1) + shape[:, :1], high)
    meets = np.all(lower < upper, axis=1) & (moves.cutter >= 0)
    if not meets.any():
        return None
    return lower[meets].min(axis=0), upper[meets].max(axis=0)


def _first(dexels: Dexels, d: int, facing: int) -> tuple[Array, Array, Ints]:
    """Where the first material of each ray of a side begins and ends, NaN for none, and the number of the move that cut it."""
    (edge, owner), count = dexels.stretches(d), dexels.count[d].astype(np.int64)
    last = np.maximum(2 * count - 1, 1)[:, :, None]
    near, far = (np.zeros_like(last), np.ones_like(last)) if facing < 0 else (last, last - 1)
    begins, ends = (np.take_along_axis(edge, k, axis=2)[:, :, 0] for k in (near, far))
    who = np.take_along_axis(owner, near, axis=2)[:, :, 0].astype(np.int64)
    face = dexels.lower[d] if facing < 0 else dexels.upper[d]
    none = (count == 0) | (begins == face)  # at the box's own face the stock goes on
    return np.where(none, np.nan, begins), np.where(none, np.nan, ends), who


def _since(
    before: tuple[Array, Array, Ints], after: tuple[Array, Array, Ints], at: Array, own: NDArray[np.bool_]
) -> Array:
    """When a stage of the cut changed what is seen (U, V), NaN where it did not. A ray without material left has its
    neighbours' time.
    """
    (old, *_), (new, _, who) = before, after
    changed = ~((old == new) | (np.isnan(old) & np.isnan(new)))
    known = changed & (who >= 0) & own[np.maximum(who, 0)] & ~np.isnan(new)
    out = np.full(old.shape, np.nan)
    out[known] = at[who[known]]
    if not known.any():
        out[changed] = float(at[own].max()) if own.any() else np.nan
    elif (changed & ~known).any():
        from scipy.ndimage import distance_transform_edt  # takes long to import: only where a ray goes through

        near = distance_transform_edt(~known, return_distances=False, return_indices=True)
        rest = changed & ~known
        out[rest] = out[tuple(index[rest] for index in near)]
    return out
