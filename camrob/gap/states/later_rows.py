"""The comparison's sums by stretches of time, and those of effects that are at work in some stretches alone: no column is
reckoned again for them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.effect import Unit
from camrob.gap.evidence.design import Design, Panel, pool
from camrob.gap.evidence.discrepancy import FieldGram
from camrob.gap.evidence.model import Model

__all__ = ["Stretches", "stretches_of", "with_later"]

Array = NDArray[np.float64]

_MOST, _FEWEST_ROWS = 12, 6  # stretches of a log, and rows of one
# of what a parameter moves the tool by in all rows, that it is taken to do in the later ones at the least
_LEAST = 1e-3
_SOME = 600  # rows of a log that tell well enough how far effects move the tool


@dataclass(frozen=True)
class Stretches:
    """design: the model's, a block a stretch. log, first: (B,) the log of each and its first row there, from 0; moves: (B, K, K)
    sums of products of what units of two parameters move the tool by, m2, over `count` (B,) rows.
    """

    design: Design
    log: NDArray[np.int64]
    first: NDArray[np.int64]
    moves: Array
    count: Array


def stretches_of(model: Model) -> Stretches:
    """The sums of a comparison by stretches of time of each log."""
    panels: list[Panel] = []
    log: list[int] = []
    first: list[int] = []
    for k, p in enumerate(model.panels):
        count = max(1, min(_MOST, len(p.scene) // _FEWEST_ROWS))
        own = (np.arange(len(p.scene)) * count) // len(p.scene)
        first += [int(np.argmax(own == b)) for b in range(count)]
        panels.append(replace(p, block=len(log) + own))
        log += [k] * count
    pooled = pool(panels, model.units, model.basis)
    K, B = len(pooled.size), len(log)
    moves, rows = np.zeros((B, K, K)), np.zeros(B)
    for p in panels:
        step = max(1, len(p.scene) // _SOME)
        X, block = p.moved_by(np.arange(K), slice(None, None, step)), p.block[::step]
        for b in np.unique(block):
            apart = X[block == b].reshape(-1, K)
            moves[b], rows[b] = apart.T @ apart, float(np.count_nonzero(block == b))
    return Stretches(pooled.design(), np.array(log), np.array(first), moves, rows)


def with_later(stretches: Stretches, later: NDArray[np.bool_], units: Sequence[int], named: Sequence[Unit]) -> Design:
    """The design, all rows as one block, with further units, which are some of its own in some stretches alone. later: (B,);
    named: what the further ones are called.
    """
    d = stretches.design
    own = [np.flatnonzero(d.owner == i) for i in units]
    cols = np.concatenate(own) if own else np.zeros(0, np.int64)
    owner = np.concatenate([d.owner, *(np.full(len(c), len(d.units) + k) for k, c in enumerate(own))])
    moves = _beside(d.moves, stretches.moves[later].sum(axis=0) / stretches.count.sum(), cols)
    size = np.sqrt(np.maximum(np.diag(moves)[len(d.owner) :], (_LEAST * d.size[cols]) ** 2))
    A = _beside(d.A.sum(axis=0), d.A[later].sum(axis=0), cols)
    right = np.concatenate([d.b.sum(axis=0), d.b[later].sum(axis=0)[cols]])
    field = d.field
    if field is not None:
        C, D, d_ = (x.sum(axis=0, keepdims=True) for x in (field.C, field.D, field.d))
        C = np.concatenate([C, field.C[later].sum(axis=0, keepdims=True)[:, :, cols]], axis=2)
        field = FieldGram(C, D, d_, field.part)
    return Design(
        (*d.units, *named),
        owner,
        A[None],
        right[None],
        d.yy.sum(keepdims=True),
        d.rows.sum(keepdims=True),
        np.concatenate([d.size, size]),
        np.concatenate([d.usual, d.usual[cols]]),
        moves,
        field,
    )


def _beside(whole: Array, part: Array, cols: NDArray[np.int64]) -> Array:
    """Products (K + k, K + k) of columns and of some of them in a part of the rows, from the products (K, K) over all rows and
    over that part.
    """
    return np.block([[whole, part[:, cols]], [part[cols], part[np.ix_(cols, cols)]]])
