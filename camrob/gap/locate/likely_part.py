"""What sits in no axis, or follows several quantities: the foot, the tool, the instrument, an axis that follows all postures.

`single_shape` asks an axis, or one direction of the foot, for a function of one quantity. A spindle that creeps round, a mount
that gives, a floor that dips or a bent linkage are none, and were said there to be the axis that happens to turn with them. Here
each part moves in all its directions at once; every candidate is fitted to stretches of time and judged on those left out, less
what its number of values lets it take by chance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import PLACES
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import some_rows, whole_gap

__all__ = ["FOOT", "INSTRUMENT", "TOOL", "LikelyPart", "likely_part"]

Array = NDArray[np.float64]

FOOT, TOOL, INSTRUMENT = "foot", "tool", "instrument"
"""Parts that are no axis."""

_MOST_ROWS = 700  # of a log that show a part well enough
_STRETCHES, _FOLDS = 48, 8  # of a log: short, so that a course in time is asked beside what it was fitted to
_DEGREE = 6  # of a course in time, a log: a floor that dips and comes back
_FEWEST, _MOST_CYCLES, _OVERSAMPLED = 1.5, 80.0, 4  # cycles of a period within a log
_ROWS_A_CYCLE = 5.0  # of a path, the fewest
_FASTEST, _MOST_RATES = (
    1.0,
    20_000,
)  # Hz, rates: poses stand at uneven times, and so show what turns between two of them
_HARMONICS = 2  # of a period: what rings behind a stroke is no sine
_SAME_COURSE = (
    0.4  # share of the axes' own motion that a period shows, from which it is the motion's and not the time's
)
_PUSH = 0.5  # of a strong acceleration (its 80 % quantile): what is loose rolls over under it
_RIDGE = 1e-8  # of a column's own square
_A_VALUE = 0.0015  # share that each fitted value costs
_STILL = 1e-6  # rad or m: an axis that doesn't move


_Candidate = tuple[str, str, Array, Array, float | None, float]


@dataclass(frozen=True, slots=True)
class LikelyPart:
    """moves: an axis, `FOOT`, `TOOL` or `INSTRUMENT`; follows: a regime; share: of the energy beyond the noise that was withheld,
    less the cost of its values; size: rms of what it does, of an axis in its own unit (rad or m), of other parts m at the TCP;
    period: s of what comes back with the time, else None.
    """

    moves: str
    follows: str
    share: float
    size: float
    period: float | None = None


@dataclass(frozen=True)
class _Rows:
    """Some rows of all logs: gap (N, 3), fold, number of the log (N,), t (N,), turn (N, 3, 3) and tip (N, 3) of the tool."""

    panels: tuple[Panel, ...]
    rows: tuple[NDArray[np.int64], ...]
    gap: Array
    fold: NDArray[np.int64]
    log: NDArray[np.int64]
    t: Array
    turn: Array
    tip: Array

    def of(self, values: Sequence[Array]) -> Array:
        """(N, ...) of what each log has (n, ...)."""
        return np.concatenate([v[r] for v, r in zip(values, self.rows, strict=True)])

    def lever(self, term: str) -> Array:
        """(N, 3) m a unit of a constant error."""
        return self.of([p.scene.place(term)[:, :3] for p in self.panels])


def likely_part(panels: Sequence[Panel], noise: float) -> LikelyPart | None:
    """The part that explains most of some logs' gap at the TCP; None where nothing explains any. noise: m, 3-D rms."""
    r = _rows(panels)
    energy = float(np.sum(r.gap**2)) - len(r.gap) * noise**2
    if energy <= 0.0 or len(np.unique(r.fold)) < _FOLDS:
        return None
    best, most = None, 0.0
    for candidate in (*_steady(r), *_returning(r)):
        X = _columns(candidate[2], candidate[3])
        if 3 * len(X) > 4 * X.shape[2]:
            share = _withheld(X, r.gap, r.fold) / energy - _A_VALUE * X.shape[2] - candidate[5]
            best, most = (candidate, share) if share > most else (best, most)
    if best is None:
        return None
    moves, follows, levers, shape, period, _ = best
    return LikelyPart(moves, follows, most, _size(r, levers, shape, axis=levers.shape[2] == 1), period)


def _columns(levers: Array, shape: Array) -> Array:
    """(N, 3, L d) m at the TCP a unit of each value, of levers (N, 3, L) that follow a shape (N, d)."""
    return np.asarray((levers[:, :, :, None] * shape[:, None, None, :]).reshape(len(shape), 3, -1))


def _size(r: _Rows, levers: Array, shape: Array, *, axis: bool) -> float:
    """rms of what a part does, beyond its mean: of an axis along it, else at the TCP."""
    X = _columns(levers, shape)
    solved = np.linalg.lstsq(X.reshape(-1, X.shape[2]), r.gap.ravel(), rcond=_RIDGE)[0]
    moved = (shape @ solved)[:, None] if axis else X @ solved
    return float(np.sqrt(np.mean(np.sum((moved - moved.mean(axis=0)) ** 2, axis=1))))


def _rows(panels: Sequence[Panel]) -> _Rows:
    rows = tuple(some_rows(p, _MOST_ROWS) for p in panels)
    gap = np.concatenate([whole_gap(p)[r] for p, r in zip(panels, rows, strict=True)])
    stretch = [np.arange(len(r)) * (1 if p.scene.poses else _STRETCHES) for p, r in zip(panels, rows, strict=True)]
    fold = [(s // (1 if p.scene.poses else max(len(s), 1))) % _FOLDS for p, s in zip(panels, stretch, strict=True)]
    nominal = np.concatenate([p.scene.nominal[r] for p, r in zip(panels, rows, strict=True)])
    return _Rows(
        panels=tuple(panels),
        rows=rows,
        gap=gap - gap.mean(axis=0),
        fold=np.concatenate(fold),
        log=np.repeat(np.arange(len(rows)), [len(r) for r in rows]),
        t=np.concatenate([p.scene.t[r] for p, r in zip(panels, rows, strict=True)]),
        turn=nominal[:, :3, :3],
        tip=nominal[:, :3, 3],
    )


def _steady(r: _Rows) -> Iterator[_Candidate]:
    """Candidates: what moves, what it follows, levers (N, 3, L), shape (N, d), period, and the share that it has by chance."""
    foot = np.stack([r.lever(f"root.{p}") for p in PLACES], axis=2)
    fixed = np.tile(np.eye(3), (len(r.gap), 1, 1))
    course = _by_log(r, _course)
    yield from ((n, "time", x, course, None, 0.0) for n, x in ((FOOT, foot), (TOOL, r.turn), (INSTRUMENT, fixed)))
    yield INSTRUMENT, "position", fixed, _quadratic(_standard(r.tip)), None, 0.0
    yield INSTRUMENT, "position", fixed, _quadratic(r.turn[:, :, 2]), None, 0.0
    link = r.of([p.scene.link for p in r.panels])
    moving = np.ptp(link, axis=0) > _STILL
    postures = _quadratic(_standard(link[:, moving]))
    axes = r.panels[0].scene.axes
    behind = {a: r.lever(f"{a}.zero")[:, :, None] for a in axes if f"{a}.zero" in r.panels[0].scene.places}
    yield from ((a, "position", lever, postures, None, 0.0) for a, lever in behind.items())
    if any(p.scene.poses for p in r.panels):
        return
    speed, hard = (r.of([p.scene.velocity(p.scene.nominal[:, :3, 3], k) for p in r.panels]) for k in (1, 2))
    own = np.einsum("nji,nj->ni", r.turn, hard)
    own = own / max(float(np.abs(own).max()), 1e-12)
    fast = np.linalg.norm(speed, axis=1, keepdims=True) / max(float(np.linalg.norm(speed, axis=1).max()), 1e-12)
    one = np.ones((len(fast), 1))
    pushed = np.concatenate([one, own, own * np.abs(own), own**3], axis=1)
    for name, levers in ((FOOT, foot), (TOOL, r.turn)):
        yield name, "acceleration", levers, pushed, None, 0.0
        yield name, "speed", levers, np.concatenate([one, fast, fast**2], axis=1), None, 0.0
    for a, lever in behind.items():
        k = axes.index(a)
        side = r.of([_rolled_over(p.scene.acceleration[:, k]) for p in r.panels])
        yield a, "acceleration", lever, np.stack([np.ones(len(side)), side], axis=1), None, 0.0


def _rolled_over(acceleration: Array) -> Array:
    """(N,) the side to which the last strong acceleration pushed, 0 before any."""
    size = np.abs(acceleration)
    strong = size > _PUSH * float(np.quantile(size[size > 0.01 * size.max()], 0.8)) if size.any() else size > 0.0
    last = np.maximum.accumulate(np.where(strong, np.arange(len(size)), -1))
    return np.asarray(np.where(last >= 0, np.sign(acceleration[last]), 0.0))


def _returning(r: _Rows) -> Iterator[_Candidate]:
    """Candidates that come back with the time, in the tool's own frame and in the measured one, each log in its own phase; none
    where the motion itself comes back with that period.
    """
    link = _standard(r.of([p.scene.link for p in r.panels]))
    for name, levers in ((TOOL, r.turn), (INSTRUMENT, np.tile(np.eye(3), (len(r.gap), 1, 1)))):
        seen = np.einsum("nji,nj->ni", levers, r.gap)
        found = _rate(r, seen - seen.mean(axis=0))
        if found is None:
            continue
        rate, by_chance = found
        shape = np.c_[np.ones(len(r.t)), _by_log(r, partial(_turns, rate=rate))]
        left = link - shape @ np.linalg.lstsq(shape, link, rcond=1e-9)[0]
        if float(np.sum(left**2)) > (1.0 - _SAME_COURSE) * float(np.sum(link**2)):
            yield name, "time", levers, shape, 1.0 / rate, by_chance


def _course(t: Array) -> Array:
    """(N, d) a smooth course in time."""
    return np.asarray(np.polynomial.legendre.legvander(_scaled(t), _DEGREE))


def _turns(t: Array, rate: float) -> Array:
    """(N, 2 k) sines and cosines of a rate (Hz) and of its harmonics."""
    angle = 2.0 * np.pi * rate * np.outer(t, np.arange(1, _HARMONICS + 1))
    return np.asarray(np.c_[np.cos(angle), np.sin(angle)])


def _rate(r: _Rows, seen: Array) -> tuple[float, float] | None:
    """Hz of the highest peak of the sum of all logs' periodograms of (N, 3), and the share of the energy that the highest peak of
    noise has (that of so many gamma variates of three directions); None where no log is long enough.
    """
    own = [r.log == k for k in range(len(r.rows))]
    span = min(float(np.ptp(r.t[o])) for o in own)
    if any(p.scene.poses for p in r.panels):
        cycles = _FASTEST * span
    else:
        cycles = min(_MOST_CYCLES, min(int(o.sum()) for o in own) / _ROWS_A_CYCLE)
    rates = np.arange(_FEWEST, cycles, 1.0 / _OVERSAMPLED)[:_MOST_RATES] / max(span, 1e-12)
    if len(rates) == 0 or span <= 0.0:
        return None
    peak = float(rates[int(np.argmax(_power(r, own, seen, rates)))])
    fine = peak + np.linspace(-0.5, 0.5, 21) / (_OVERSAMPLED * span)
    by_chance = 2.0 * (np.log(len(rates)) + 2.0 * np.log1p(np.log(len(rates)))) / (3.0 * len(seen))
    return float(fine[int(np.argmax(_power(r, own, seen, fine)))]), by_chance


def _power(r: _Rows, own: Sequence[NDArray[np.bool_]], seen: Array, rates: Array) -> Array:
    """(F,) m2 of the sines of some rates, over all logs."""
    waves = [(np.exp(2j * np.pi * np.outer(rates, r.t[o])), seen[o]) for o in own]
    return np.asarray(np.sum([np.sum(np.abs(w @ s) ** 2, axis=1) / len(s) for w, s in waves], axis=0))


def _by_log(r: _Rows, shape: Callable[[Array], Array]) -> Array:
    """(N, L d) a shape of the time for each log by itself."""
    parts = []
    for k in range(len(r.rows)):
        own = r.log == k
        values = shape(r.t[own])
        part = np.zeros((len(r.t), values.shape[1]))
        part[own] = values
        parts.append(part)
    return np.concatenate(parts, axis=1)


def _scaled(x: Array) -> Array:
    return np.asarray(2.0 * (x - x.min()) / max(float(np.ptp(x)), 1e-12) - 1.0)


def _standard(x: Array) -> Array:
    return np.asarray((x - x.mean(axis=0)) / np.maximum(x.std(axis=0), 1e-12))


def _quadratic(x: Array) -> Array:
    """(N, d) 1, x, and all products of two."""
    i, j = np.triu_indices(x.shape[1])
    return np.concatenate([np.ones((len(x), 1)), x, x[:, i] * x[:, j]], axis=1)


def _withheld(X: Array, gap: Array, fold: NDArray[np.int64]) -> float:
    """m2 that columns (N, 3, k), beside a constant, take of a gap (N, 3) from folds that they were not fitted to."""
    X = np.concatenate([X, np.tile(np.eye(3), (len(X), 1, 1))], axis=2)
    X = X / (np.sqrt(np.einsum("nik,nik->k", X, X)) + 1e-30)
    A, b = [], []
    for k in range(_FOLDS):
        own = X[fold == k].reshape(-1, X.shape[2])
        A.append(own.T @ own)
        b.append(own.T @ gap[fold == k].ravel())
    whole, right, gained = np.sum(A, axis=0) + _RIDGE * np.eye(X.shape[2]), np.sum(b, axis=0), 0.0
    for Ak, bk in zip(A, b, strict=True):
        solved = np.linalg.solve(whole - Ak, right - bk)
        gained += float(2.0 * solved @ bk - solved @ Ak @ solved)
    return gained
