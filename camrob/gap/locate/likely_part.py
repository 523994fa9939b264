"""What sits in no axis, or follows several quantities: the foot, the tool, the instrument, an axis that follows all postures.

`single_shape` asks an axis, or one direction of the foot, for a function of one quantity. A spindle that creeps round, a mount
that gives, a floor that dips or a bent linkage are none, and were said there to be the axis that happens to turn with them. Here
each part moves in all its directions at once; every candidate is fitted to stretches of time and judged on those left out, less
what its number of values lets it take by chance.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.gap.effects.common import PLACES
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import some_rows, whole_gap
from camrob.gap.locate.steps import steps
from camrob.gap.locate.tipping import tipping, tool_by_weight

__all__ = ["FOOT", "INSTRUMENT", "TOOL", "LikelyPart", "likely_part"]

Array = NDArray[np.float64]

FOOT, TOOL, INSTRUMENT = "foot", "tool", "instrument"
"""Parts that are no axis."""

_MOST_ROWS = 700  # of a log that show a part well enough
_STRETCHES, _FOLDS = 48, 8  # of a log: short, so that a course in time is asked beside what it was fitted to
_DEGREE = 6  # of a course in time, a log: a floor that dips and comes back
_GROWS = 2  # powers of the time that a guide takes to get warm
_FEWEST, _OVERSAMPLED = 1.5, 4  # cycles of a period within a log
_MOST_TOLD, _ROWS_A_CYCLE = (
    3000,
    5.0,
)  # rows of a log among which a period is looked for, and of a path the fewest a cycle
# Hz, rates: poses stand at uneven times, and so show what turns between two of them
_FASTEST, _MOST_RATES = 1.0, 20_000
_EVEN = 0.1  # of the time between two poses: a clock whose steps differ by less is even
_HARMONICS = 2  # of a period: what rings behind a stroke is no sine
# share of the axes' own motion that a period shows, from which it is the motion's and not the time's
_SAME_COURSE = 0.4
_PUSH = 0.5  # of a strong acceleration (its 80 % quantile): what is loose rolls over under it
_RIDGE = 1e-8  # of a column's own square
_A_VALUE = 0.0015  # share that each fitted value costs
_STILL = 1e-6  # rad or m: an axis that doesn't move
_BENDS, _CREEPS = 4, 1e-3  # powers of the place on a rail; of its highest speed, under which an axis stands


_Candidate = tuple[str, str, Array, Array]


@dataclass(frozen=True, slots=True)
class LikelyPart:
    """moves: an axis, `FOOT`, `TOOL` or `INSTRUMENT`; follows: a regime; share: of the energy beyond the noise that was withheld,
    less the cost of its values; size: rms of what it does, of an axis that is off along its own motion in its own unit (rad or
    m), of all else m at the TCP; period: s of what comes back with the time, else None; along: whether it is such an axis.
    """

    moves: str
    follows: str
    share: float
    size: float
    period: float | None = None
    along: bool = False


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


def likely_part(panels: Sequence[Panel], noise: float, *, but: str = "") -> LikelyPart | None:
    """The part that explains most of some logs' gap at the TCP; None where nothing explains any. noise: m, 3-D rms; but: what it
    does not follow.
    """
    r = _rows(panels, _MOST_ROWS)
    energy = float(np.sum(r.gap**2)) - len(r.gap) * noise**2
    if energy <= 0.0 or len(np.unique(r.fold)) < _FOLDS:
        return None
    found: list[tuple[float, str, str, Callable[[], float], float | None, bool]] = []
    for moves, follows, levers, shape in _steady(r):
        if follows == but:
            continue
        X = _columns(levers, shape)
        if 3 * len(X) > 4 * X.shape[2]:
            share = float(_withheld(X, r.gap, r.fold).sum()) / energy - _A_VALUE * X.shape[2]
            along = levers.shape[2] == 1
            found.append((share, moves, follows, partial(_size, r, levers, shape, axis=along), None, along))
    for moves, taken, levers, shape, period in _returning(r, panels):
        share = taken / energy - _A_VALUE * levers.shape[2] * shape.shape[1]
        along = levers.shape[2] == 1
        found.append((share, moves, "time", partial(_size, r, levers, shape, axis=along), period, along))
    if not found:
        return None
    share, moves, follows, size_of, back, along = max(found, key=lambda f: f[0])
    return LikelyPart(moves, follows, share, size_of(), back, along) if share > 0.0 else None


def _taken(r: _Rows, levers: Array, shape: Array) -> float:
    """m2 that levers (N, 3, L) which follow a shape (N, d) take from folds that they were not fitted to."""
    return float(_withheld(_columns(levers, shape), r.gap, r.fold).sum())


def _columns(levers: Array, shape: Array) -> Array:
    """(N, 3, L d) m at the TCP a unit of each value, of levers (N, 3, L) that follow a shape (N, d)."""
    return np.asarray((levers[:, :, :, None] * shape[:, None, None, :]).reshape(len(shape), 3, -1))


def _size(r: _Rows, levers: Array, shape: Array, *, axis: bool) -> float:
    """rms of what a part does, beyond its mean: of an axis along it, else at the TCP."""
    X = _columns(levers, shape)
    solved = np.linalg.lstsq(X.reshape(-1, X.shape[2]), r.gap.ravel(), rcond=_RIDGE)[0]
    moved = (shape @ solved)[:, None] if axis else X @ solved
    return float(np.sqrt(np.mean(np.sum((moved - moved.mean(axis=0)) ** 2, axis=1))))


def _rows(panels: Sequence[Panel], most: int) -> _Rows:
    rows = tuple(some_rows(p, most) for p in panels)
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
    """Candidates: what moves, what it follows, levers (N, 3, L), shape (N, d)."""
    foot = np.stack([r.lever(f"root.{p}") for p in PLACES], axis=2)
    fixed = np.tile(np.eye(3), (len(r.gap), 1, 1))
    course = _by_log(r, _course)
    for n, x in ((FOOT, foot), (TOOL, r.turn), (INSTRUMENT, fixed)):
        yield n, "time", x, course
        yield from ((n, "time", x, step) for step in steps(r.t, r.log, partial(_taken, r, x)))
    yield INSTRUMENT, "position", fixed, _quadratic(_standard(r.tip))
    yield INSTRUMENT, "position", fixed, _quadratic(r.turn[:, :, 2])
    link = r.of([p.scene.link for p in r.panels])
    moving = np.ptp(link, axis=0) > _STILL
    postures = _quadratic(_standard(link[:, moving]))
    axes = r.panels[0].scene.axes
    behind = {a: r.lever(f"{a}.zero")[:, :, None] for a in _behind(r.panels[0])}
    yield from ((a, "position", lever, postures) for a, lever in behind.items())
    yield from _growing(r, behind)
    yield from tipping(r.panels, r.rows)
    yield TOOL, "load", *tool_by_weight(r.panels, r.rows, r.turn)
    yield from _external(r, foot)
    if any(p.scene.poses for p in r.panels):
        return
    speed, hard = (r.of([p.scene.velocity(p.scene.nominal[:, :3, 3], k) for p in r.panels]) for k in (1, 2))
    own = np.einsum("nji,nj->ni", r.turn, hard)
    own = own / max(float(np.abs(own).max()), 1e-12)
    fast = np.linalg.norm(speed, axis=1, keepdims=True) / max(float(np.linalg.norm(speed, axis=1).max()), 1e-12)
    one = np.ones((len(fast), 1))
    pushed = np.concatenate([one, own, own * np.abs(own), own**3], axis=1)
    for name, levers in ((FOOT, foot), (TOOL, r.turn)):
        yield name, "acceleration", levers, pushed
        yield name, "speed", levers, np.concatenate([one, fast, fast**2], axis=1)
    for a, lever in behind.items():
        k = axes.index(a)
        side = r.of([_rolled_over(p.scene.acceleration[:, k]) for p in r.panels])
        yield a, "acceleration", lever, np.stack([np.ones(len(side)), side], axis=1)


def _growing(r: _Rows, behind: Mapping[str, Array]) -> Iterator[_Candidate]:
    """Candidates for a guide or a screw that grows with the time: axes that slide are off in proportion to where they are."""
    scene = r.panels[0].scene
    slow = _by_log(r, lambda t: np.asarray(np.polynomial.legendre.legvander(_scaled(t), _GROWS)))
    for a, lever in behind.items():
        at = r.of([p.scene.link[:, p.scene.index(a)] for p in r.panels])
        if scene.cell.joints[scene.cell.index(a)].prismatic and np.ptp(at) > _STILL:
            yield a, "time", lever, np.concatenate([slow, slow * _scaled(at)[:, None]], axis=1)


def _behind(panel: Panel) -> list[str]:
    """Axes of which the tool shows how far their links are off."""
    return [a for a in panel.scene.axes if f"{a}.zero" in panel.scene.places]


def _external(r: _Rows, foot: Array) -> Iterator[_Candidate]:
    """Candidates for a carriage or a table: it moves as a whole, in all directions at once, with its own place or speed."""
    scene = r.panels[0].scene
    for a in scene.axes:
        k, joint = scene.index(a), scene.cell.joints[scene.cell.index(a)]
        table = joint.role is Role.WORKPIECE and f"{a}.x" in scene.places  # else nobody measures from the table
        if joint.role is not Role.CARRIAGE and not table:
            continue
        at = r.of([p.scene.link[:, k] for p in r.panels])
        if np.ptp(at) <= _STILL:
            continue
        levers = _of_table(r) if table else foot
        if joint.prismatic:
            yield a, "position", levers, np.asarray(np.polynomial.legendre.legvander(_scaled(at), _BENDS))
        else:
            waves = [f(order * at) for order in (1, 2) for f in (np.cos, np.sin)]
            yield a, "position", levers, np.stack([np.ones(len(at)), *waves], axis=1)
        if not any(p.scene.poses for p in r.panels):
            v = r.of([p.scene.velocity(p.scene.link[:, [k]])[:, 0] for p in r.panels])
            fast = v / np.abs(v).max()
            moves = np.abs(fast) > _CREEPS
            yield a, "speed", levers, np.stack([np.ones(len(v)), fast, np.abs(fast), moves], axis=1)


def _of_table(r: _Rows) -> Array:
    """(N, 3, 6) m of what is measured from a table, that moves along and turns about the axes of the world."""
    along = -r.of([p.scene.measured_R_world for p in r.panels])
    return np.concatenate([along, np.cross(along, r.tip[:, :, None], axis=1)], axis=2)


def _rolled_over(acceleration: Array) -> Array:
    """(N,) the side to which the last strong acceleration pushed, 0 before any."""
    size = np.abs(acceleration)
    strong = size > _PUSH * float(np.quantile(size[size > 0.01 * size.max()], 0.8)) if size.any() else size > 0.0
    last = np.maximum.accumulate(np.where(strong, np.arange(len(size)), -1))
    return np.asarray(np.where(last >= 0, np.sign(acceleration[last]), 0.0))


def _returning(r: _Rows, panels: Sequence[Panel]) -> Iterator[tuple[str, float, Array, Array, float]]:
    """What comes back with the time, in the tool's own frame and in the measured one, there of an axis too, each log in its own
    phase: the part, m2 that it takes of folds left out, its levers and shape, the period. None where the motion itself comes back
    with that period.

    Of thousands of rates one always fits; so each fold is judged at the rate that the others show.
    """
    # axes there and back by turns come back in their sides alone
    courses = [_standard(r.of(x)) for x in ([p.scene.link for p in r.panels], [p.scene.sides for p in r.panels])]
    told = _rows(panels, _MOST_TOLD)
    behind = [(a, r.lever(f"{a}.zero")[:, :, None]) for a in _behind(r.panels[0])]
    for name, levers in ((TOOL, r.turn), (INSTRUMENT, np.tile(np.eye(3), (len(r.gap), 1, 1)))):
        seen = np.einsum("nji,nj->ni", told.turn, told.gap) if name == TOOL else told.gap
        rates = _rates(told, seen)
        if rates is None:
            continue
        whole, *others = (np.c_[np.ones(len(r.t)), _by_log(r, partial(_turns, rate=rate))] for rate in rates)
        if not any(_shows(whole, course) for course in courses) and len(r.t) > 4 * whole.shape[1]:
            # what an axis does comes back where it is seen from, too
            for part, own in [(name, levers), *(behind if name == INSTRUMENT else [])]:
                folds = enumerate(_withheld(_columns(own, shape), r.gap, r.fold) for shape in others)
                yield part, sum(float(taken[k]) for k, taken in folds), own, whole, 1.0 / rates[0]


def _shows(shape: Array, course: Array) -> bool:
    """Whether a shape (N, d) shows much of a motion's own course (N, k)."""
    left = course - shape @ np.linalg.lstsq(shape, course, rcond=1e-9)[0]
    return float(np.sum(left**2)) <= (1.0 - _SAME_COURSE) * float(np.sum(course**2))


def _course(t: Array) -> Array:
    """(N, d) a smooth course in time."""
    return np.asarray(np.polynomial.legendre.legvander(_scaled(t), _DEGREE))


def _turns(t: Array, rate: float) -> Array:
    """(N, 2 k) sines and cosines of a rate (Hz) and of its harmonics."""
    angle = 2.0 * np.pi * rate * np.outer(t, np.arange(1, _HARMONICS + 1))
    return np.asarray(np.c_[np.cos(angle), np.sin(angle)])


def _rates(r: _Rows, seen: Array) -> list[float] | None:
    """Hz of the highest peak of the sum of all logs' periodograms of (N, 3): of all rows first, then without each fold; None
    where no log is long enough.
    """
    own = [r.log == k for k in range(len(r.rows))]
    span = min(float(np.ptp(r.t[o])) for o in own)
    if any(p.scene.poses for p in r.panels):
        cycles = min(_FASTEST, *(_fastest(r.t[o]) for o in own)) * span
    else:
        cycles = min(int(o.sum()) for o in own) / _ROWS_A_CYCLE
    coarse = np.arange(_FEWEST, cycles, 1.0 / _OVERSAMPLED)[:_MOST_RATES] / max(span, 1e-12)
    if len(coarse) < 2 or span <= 0.0:
        return None
    # what differs from log to log is no course of the time
    seen = seen - np.stack([seen[o].mean(axis=0) for o in own])[r.log]
    near = np.linspace(-0.5, 0.5, 21) / (_OVERSAMPLED * span)
    rates = []
    for k, power in enumerate(_powers(r, own, seen, coarse).T):
        fine = float(coarse[int(np.argmax(power))]) + near
        rates.append(float(fine[int(np.argmax(_powers(r, own, seen, fine)[:, k]))]))
    return rates


def _fastest(t: Array) -> float:
    """Hz of the fastest wave that poses can tell from a slower one: those at even times no more than one of two poses."""
    step = np.diff(t)
    even = float(np.ptp(step)) < _EVEN * float(np.median(step))
    return 0.5 / float(np.median(step)) if even else np.inf


def _powers(r: _Rows, own: Sequence[NDArray[np.bool_]], seen: Array, rates: Array) -> Array:
    """(F, 1 + folds) m2 of the sines of some evenly spaced rates, over all logs: of all rows, and without each fold. Each rate
    turns the one before it on.
    """
    out = np.zeros((len(rates), 1 + _FOLDS))
    for o in own:
        by_fold = np.flatnonzero(o)[np.argsort(r.fold[o], kind="stable")]
        t, z = r.t[by_fold], seen[by_fold]
        names, firsts, counts = np.unique(r.fold[by_fold], return_index=True, return_counts=True)
        rest = np.full(_FOLDS, float(len(t)))
        rest[names] = np.maximum(len(t) - counts, 1)
        sums = np.zeros((_FOLDS, 3), np.complex128)
        turn = np.exp(2j * np.pi * rates[0] * t)
        step = np.exp(2j * np.pi * (rates[1] - rates[0]) * t)
        for row in out:
            sums[names] = np.add.reduceat(turn[:, None] * z, firsts)
            whole = sums.sum(axis=0)
            row[0] += float(np.sum(np.abs(whole) ** 2)) / len(t)
            row[1:] += np.sum(np.abs(whole - sums) ** 2, axis=1) / rest
            turn *= step
    return out


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


def _withheld(X: Array, gap: Array, fold: NDArray[np.int64]) -> Array:
    """(folds,) m2 that columns (N, 3, k), beside a constant, take of a gap (N, 3) from each fold, fitted to the others."""
    X = np.concatenate([X, np.tile(np.eye(3), (len(X), 1, 1))], axis=2)
    X = X / (np.sqrt(np.einsum("nik,nik->k", X, X)) + 1e-30)
    A, b = [], []
    for k in range(_FOLDS):
        own = X[fold == k].reshape(-1, X.shape[2])
        A.append(own.T @ own)
        b.append(own.T @ gap[fold == k].ravel())
    whole, right, gained = np.sum(A, axis=0) + _RIDGE * np.eye(X.shape[2]), np.sum(b, axis=0), []
    for Ak, bk in zip(A, b, strict=True):
        solved = np.linalg.solve(whole - Ak, right - bk)
        gained.append(float(2.0 * solved @ bk - solved @ Ak @ solved))
    return np.array(gained)
