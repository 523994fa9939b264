"""Whole regimes of the logs withheld: the far end of the track, a table's angle, a speed, a place, a lap, a log.

Blocks in time tell whether a fit is noise; only a regime that took no part tells whether it holds where nobody has looked.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.gap.evidence.design import Design, Panel, sums_of
from camrob.gap.evidence.discrepancy import FieldGram
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.evidence.shrink import Shrinkage, settled
from camrob.gap.observation.laps import laps_of
from camrob.summaries.diagnosis_summary import WithheldRegime
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

__all__ = ["Regime", "regimes_of_logs", "regimes_withheld"]

Array = NDArray[np.float64]
Set = frozenset[int]
Rows = NDArray[np.bool_]

# between the middles of the two thirds
_LEAST_TRACK, _LEAST_TABLE, _LEAST_PLACE = mm_to_m(50.0), deg_to_rad(5.0), mm_to_m(100.0)
_LEAST_RATIO = 1.5  # of the speeds of the two thirds
_FEWEST, _LARGEST = 0.1, 0.6  # share of all samples that a regime holds
_LEAST_ROWS = 40
_BLOCKS = 10
_MAIN = 0.95  # of a direction: then it is called by its axis
_ERRORS = 2.0  # standard errors of the prediction
_MOST_LAPS, _MOST_LOGS = 12, 12


@dataclass(frozen=True)
class Regime:
    """A part of the logs. kind: track, table, speed, place, lap or log; what: in words; rows: (N,) a log."""

    kind: str
    what: str
    rows: tuple[Rows, ...]


def regimes_withheld(model: Model, members: Set) -> list[WithheldRegime]:
    """For each regime, the gap in it before and after `members`, fitted to all the rest together with what
    else the best set holds.

    The set was chosen, and what is not linear in it refined, on all samples. worse: with `members` taken away the gap is
    larger than without, by more than its interval and the fit's own uncertainty allow.
    """
    if not members:
        return []
    owner = model.design.owner
    found = np.flatnonzero(np.isin(owner, list(model.best.members)))
    asked = [(p.w_tcp[:, 0] > 0.0) & ~p.unknown_rows(found) for p in model.panels]
    regimes = list(regimes_of_logs(model.panels, asked))
    keep = np.flatnonzero(np.isin(owner, list(members)))
    out = []
    for regime, design in zip(regimes, _rest(model, regimes), strict=True):
        fitted = model.fit(model.best.members | model.evidence.always, design=design)
        values = np.where(np.isin(owner, list(members)), fitted.mean, 0.0)
        rows = [r & a for r, a in zip(regime.rows, asked, strict=True)]
        shrunk, doubt = _shrunk(model, rows, values, keep, fitted.spread.block(keep))
        low, high = shrunk.interval()
        beyond = shrunk.rms_after**2 - shrunk.rms_before**2 > (_ERRORS * doubt) ** 2
        out.append(
            WithheldRegime(
                regime=regime.kind,
                what=regime.what,
                samples=int(sum(r.sum() for r in rows)),
                rms_before_mm=m_to_mm(shrunk.rms_before),
                rms_after_mm=m_to_mm(shrunk.rms_after),
                shrink=shrunk.shrink,
                shrink_interval=(low, high),
                doubt_mm=m_to_mm(doubt),
                worse=bool(high < 0.0 and beyond),
            )
        )
    return out


def _shrunk(
    model: Model, rows: Sequence[Rows], values: Array, keep: NDArray[np.int64], cov: Array
) -> tuple[Shrinkage, float]:
    """The gap at some rows before and after what values (K,) move the TCP by, blocks are stretches of these rows; and m (rms), by
    how much that may be off as the values of `keep`, whose covariance is `cov`, are not known better.
    """
    before, after, doubts = [], [], []
    for p, here in zip(model.panels, rows, strict=True):
        if not here.any():
            continue
        gap = whole_gap(p)[here]
        before.append(settled(model, p, here, gap))
        after.append(settled(model, p, here, gap - p.moves(values, here)))
        X = p.moved_by(keep, here)
        doubts.append(np.einsum("nik,kl,nil->n", X, cov, X, optimize=True))
    count = sum(len(b) for b in before)
    block = (np.arange(count) * _BLOCKS) // max(count, 1)
    doubt = float(np.sqrt(np.mean(np.concatenate(doubts))))
    return Shrinkage(np.concatenate(before), np.concatenate(after), block), doubt


def _rest(model: Model, regimes: Sequence[Regime]) -> Iterator[Design]:
    """The design without each regime: its Gram matrices less those of the regime's rows.

    Rows that lie in the same regimes are summed once.
    """
    d = model.design
    A, b = np.zeros((len(regimes), *d.A.shape[1:])), np.zeros((len(regimes), d.A.shape[1]))
    yy, count = np.zeros(len(regimes)), np.zeros(len(regimes))
    fields = [FieldGram.empty(d.field) for _ in regimes] if d.field is not None else []
    for k, p in enumerate(model.panels):
        inside = np.stack([r.rows[k] for r in regimes], axis=1) if regimes else np.zeros((len(p.scene), 0), bool)
        for pattern, rows in _alike(inside):
            sums = sums_of(p, rows, smooth=bool(fields))
            for r in np.flatnonzero(pattern).tolist():
                A[r] += sums.A.sum(axis=0)
                b[r] += sums.b.sum(axis=0)
                yy[r] += sums.yy.sum()
                count[r] += sums.rows
                if sums.smooth is not None:
                    fields[r] = fields[r].more(*sums.smooth)
    whole = d.A.sum(axis=0), d.b.sum(axis=0), float(d.yy.sum()), float(d.rows.sum())
    for r in range(len(regimes)):
        yield replace(
            d,
            A=(whole[0] - A[r])[None],
            b=(whole[1] - b[r])[None],
            yy=np.array([whole[2] - yy[r]]),
            rows=np.array([whole[3] - count[r]]),
            field=d.field.less(fields[r]) if d.field is not None else None,
        )


def _alike(inside: Rows) -> Iterator[tuple[Rows, NDArray[np.int64]]]:
    """Patterns (R,) of `inside` (N, R) that are not empty, with the rows that have them."""
    patterns, slot = np.unique(inside, axis=0, return_inverse=True)
    order = np.argsort(slot.ravel(), kind="stable")
    ends = np.cumsum(np.bincount(slot.ravel(), minlength=len(patterns)))
    for pattern, rows in zip(patterns, np.split(order, ends[:-1]), strict=True):
        if pattern.any():
            yield pattern, rows


def regimes_of_logs(panels: Sequence[Panel], asked: Sequence[Rows]) -> Iterator[Regime]:
    """All regimes that hold enough of the samples `asked` for, and leave enough of them."""
    total = sum(int(a.sum()) for a in asked)
    for regime in (*_thirds(panels, asked), *_laps(panels), *_logs(panels)):
        count = sum(int((r & a).sum()) for r, a in zip(regime.rows, asked, strict=True))
        if _LEAST_ROWS <= count <= _LARGEST * total and (count >= _FEWEST * total or regime.kind in ("lap", "log")):
            yield regime


def _thirds(panels: Sequence[Panel], asked: Sequence[Rows]) -> Iterator[Regime]:
    """The lowest and the highest third of track, table, speed, and place along the work space's longest direction."""
    scenes = [p.scene for p in panels]
    for role, kind, least, unit in (
        (Role.CARRIAGE, "track", _LEAST_TRACK, "mm"),
        (Role.WORKPIECE, "table", _LEAST_TABLE, "degrees"),
    ):
        for joint in scenes[0].cell.joints:
            if joint.role is role:
                values = [s.link[:, s.index(joint.name)] for s in scenes]
                named = "mm" if joint.prismatic else unit
                yield from _ends(kind, joint.name, values, asked, named, least=least)
    if not any(s.poses for s in scenes):
        values = [np.linalg.norm(s.velocity(s.nominal[:, :3, 3]), axis=1) for s in scenes]
        yield from _ends("speed", "speed", values, asked, "mm/s", ratio=_LEAST_RATIO)
    places = np.concatenate([s.nominal[a, :3, 3] for s, a in zip(scenes, asked, strict=True)])
    along = np.linalg.svd(places - places.mean(axis=0), full_matrices=False)[2][0] if len(places) > 3 else np.eye(3)[0]
    along = along * np.sign(along[np.argmax(np.abs(along))])
    values = [s.nominal[:, :3, 3] @ along for s in scenes]
    yield from _ends("place", _direction(along), values, asked, "mm", least=_LEAST_PLACE)


def _direction(along: Array) -> str:
    k = int(np.argmax(along))
    if along[k] > _MAIN:
        return "xyz"[k]
    return " ".join(f"{v:+.2f} {n}" for v, n in zip(along, "xyz", strict=True) if abs(v) >= 0.05).removeprefix("+")


def _ends(
    kind: str,
    name: str,
    values: Sequence[Array],
    asked: Sequence[Rows],
    unit: str,
    *,
    least: float = 0.0,
    ratio: float = 1.0,
) -> Iterator[Regime]:
    """The third with the lowest values and that with the highest, where these differ enough."""
    all_ = np.concatenate([v[a] for v, a in zip(values, asked, strict=True)])
    if len(all_) < 3 * _LEAST_ROWS:
        return
    sixth, third, two, last = np.quantile(all_, [1.0 / 6.0, 1.0 / 3.0, 2.0 / 3.0, 5.0 / 6.0])
    if last - sixth < least or last < ratio * sixth or two <= third:
        return

    def shown(value: float) -> str:
        at_edge = rad_to_deg(value) if unit == "degrees" else m_to_mm(value)
        return f"{at_edge:.2g} {unit}" if kind == "speed" and at_edge < 10.0 else f"{at_edge + 0.0:.0f} {unit}"

    # where it stands at one value for long, that value belongs to the regime
    low, high = np.mean(all_ < third) < _FEWEST, np.mean(all_ > two) < _FEWEST
    yield Regime(kind, f"{name} below {shown(third)}", tuple(v <= third if low else v < third for v in values))
    yield Regime(kind, f"{name} above {shown(two)}", tuple(v >= two if high else v > two for v in values))


def _laps(panels: Sequence[Panel]) -> Iterator[Regime]:
    """Each lap of a log whose path repeats."""
    for k, p in enumerate(panels):
        laps = laps_of(p.scene)
        for n in range(min(len(laps), _MOST_LAPS)):
            rows = tuple(laps[n] if i == k else np.zeros(len(q.scene), bool) for i, q in enumerate(panels))
            of = f" of {p.scene.name}" if len(panels) > 1 else ""
            yield Regime("lap", f"lap {n + 1} of {len(laps)}{of}", rows)


def _logs(panels: Sequence[Panel]) -> Iterator[Regime]:
    """Each log of several."""
    for k, p in enumerate(panels[:_MOST_LOGS] if len(panels) > 1 else ()):
        yield Regime("log", p.scene.name, tuple(np.full(len(q.scene), i == k) for i, q in enumerate(panels)))
