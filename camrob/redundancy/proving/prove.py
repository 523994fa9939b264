"""How far a plan may be above the best that exists: its price held to bounds that are proved, piece by piece, as long as there is
time.

A path falls into pieces where its tool begins or ceases to lean against the turning axis; what moves between pieces cost is left
out, so that the bounds of the pieces add up to one of the whole. Upright pieces come first: their poses look alike from the arm,
and are proved some hundred times faster than leaning ones.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.progress import Share
from camrob.redundancy.clock import Clock
from camrob.redundancy.plan_report import PlanBasis
from camrob.redundancy.planning.course import relaxed
from camrob.redundancy.proving.plan_certificate import write_certificate
from camrob.redundancy.proving.statement import Statement, price_of, statement_of, worth_telling_apart
from camrob.redundancy.proving.whole_plan import Told, leaning, prove_plan
from camrob.runs import runs_of

__all__ = ["Piece", "PriceProof", "prove_prices"]

Array = NDArray[np.float64]

SHARE = 0.992
"""Of the best plan found, m: what the proof aims at; a higher aim costs time for the whole bound."""
_LEVELS = 6  # lattices at most: the last one's cells are some 2 mm
_AROUND = 15  # waypoints about a leaning one that go with it: short pieces lose the travel between them


@dataclass(frozen=True, slots=True)
class Piece:
    """Waypoints `begin` to before `end` of a plan: whether the tool leans there, what the plan pays, the bound, m."""

    plan: int
    begin: int
    end: int
    leans: bool
    price: float
    bound: float


@dataclass(frozen=True, slots=True)
class PriceProof:
    """A plan's price, m; the bound that is proved of it, piece by piece; whether the time ran out first."""

    price: float
    pieces: tuple[Piece, ...]
    out_of_time: bool

    @property
    def bound(self) -> float:
        """m: no plan is cheaper."""
        return sum(p.bound for p in self.pieces)


def prove_prices(
    cell: Cell, plans: Sequence[PlanBasis], file: Path, *, seconds: float, progress: Share | None = None
) -> PriceProof:
    """Prove a lower bound of what plans of one program cost together, and write its certificate.

    seconds: of all pieces together; a piece gets its share of what is left by its price. Raises CellError for a cell that the
    enclosures don't cover.
    """
    clock = Clock(seconds)
    price = sum(price_of(p, p.draft) for p in plans)
    todo: list[tuple[Piece, Statement, float]] = []
    for n, plan in enumerate(plans):
        stated = statement_of(plan.space, plan.objective, plan.w, worth_telling_apart(plan))
        full = relaxed(plan.space, plan.objective, plan.w, plan.draft, 1.0)
        for begin, end, leans in _runs(leaning(cell, stated.axis)):
            own = price_of(plan, plan.draft, begin, end)
            aim = SHARE * min(own, price_of(plan, full, begin, end))
            todo.append((Piece(n, begin, end, leans, own, 0.0), stated.between(begin, end), aim))
    todo.sort(key=lambda row: row[0].leans)
    proved: list[Piece] = []
    told: list[tuple[Statement, list[Told]]] = []
    late = False
    for k, (piece, stated, aim) in enumerate(todo):
        rest = sum(p.price for p, _stated, _aim in todo[k:])
        begun, part = clock.taken / seconds, Clock(piece.price / rest * (clock.left or 0.0))
        levels: list[Told] = []

        def share(_level: float, begun: float = begun, part: Clock = part) -> None:
            if progress is not None:
                progress(min(1.0, begun + part.taken / seconds))

        proof = prove_plan(
            cell, plans[piece.plan].objective, stated, aim, levels=_LEVELS, clock=part, told=levels, progress=share
        )
        late = late or part.up
        told.append((stated, levels))
        proved.append(replace(piece, bound=proof.bound))
    write_certificate(file, cell, plans[0].objective, told)
    return PriceProof(price, tuple(sorted(proved, key=lambda p: (p.plan, p.begin))), late)


def _runs(leans: NDArray[np.bool_]) -> list[tuple[int, int, bool]]:
    """From where to where the tool leans (W,), and where it doesn't."""
    wide = np.convolve(leans, np.ones(2 * _AROUND + 1), mode="full")[_AROUND : _AROUND + len(leans)] > 0
    return [(run.start, run.stop, bool(wide[run.start])) for run in runs_of(wide)]
