"""Names that a far larger claim shows as well where machines do it in a wider way than the library describes."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import nnls

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.model import Model, effect_rms, members_of
from camrob.gap.verdict.belief import BELIEF

__all__ = ["shown_by_wider"]

Array = NDArray[np.float64]

_SHOWN = 0.9  # share of a name's energy from which the wider description shows it


def shown_by_wider(model: Model, library: Sequence[Effect], claimed: Collection[str]) -> dict[str, list[str]]:
    """Claimed effects, and the claims that move the tool far more and that a machine may have in so wide a way that this shows as
    well: a drive of second order, described as one of first order, gives way with the acceleration beside it.
    """
    found: dict[str, list[str]] = {}
    sizes = {n: effect_rms(model, model.panels, n) for n in claimed}
    for effect in library:
        if effect.name not in sizes:
            continue
        columns = [effect.wider(p.scene, model.states[effect.name]) for p in model.panels]
        if not all(columns):
            continue
        X = np.concatenate(
            [
                np.stack([c.tcp[:, :3] * p.w_tcp[:, :3] for c in own if c.tcp is not None], axis=2).reshape(
                    -1, len(own)
                )
                for p, own in zip(model.panels, columns, strict=True)
            ]
        )
        for name, size in sizes.items():
            if name != effect.name and BELIEF.far_more * size < sizes[effect.name] and _shows(X, _pattern(model, name)):
                found.setdefault(name, []).append(effect.name)
    return found


def _pattern(model: Model, name: str) -> Array:
    """(3 N,) what an effect of the best set moves the TCP by, weighted."""
    values = model.values(members_of(model, name), model.best)
    return np.concatenate([(p.moves(values) * p.w_tcp[:, :3]).ravel() for p in model.panels])


def _shows(X: Array, y: Array) -> bool:
    """Whether columns X (M, d), each a share of 0 to 1 of it, show nearly all of a pattern y (M,)."""
    shares, left = nnls(X, y)
    return bool((shares <= 1.0).all() and left**2 < (1.0 - _SHOWN) * float(y @ y))
