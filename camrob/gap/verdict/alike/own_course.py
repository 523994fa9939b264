"""Names that follow time alone, held to the free form of their own place: the same pattern with any smooth course over time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.discrepancy import PARTS
from camrob.gap.evidence.model import Model, members_of

__all__ = ["off_course"]

_DEGREE = 4  # of polynomials over the logs' time that the pattern is multiplied by
_GAIN = 40.0  # chi-square gained, a unit of temperature, from which another course is shown: with four of them chance gives 4
_RANK = 1e-9


def off_course(model: Model, library: Sequence[Effect]) -> list[str]:
    """Effects of the best set that follow time alone and whose pattern, let loose in its course, surely explains more than the
    effect's description may be wrong by. An instrument that drifts steadily is a likeness of links that warm up.

    What the discrepancy shows over posture is taken away first; what it shows over time is the course's own.
    """
    inside = model.evidence.effects_of(model.best.members)
    asked = [e for e in library if e.name in inside and e.regimes == ("time",)]
    if not asked:
        return []
    ends = min(s.t[0] for s in model.scenes), max(s.t[-1] for s in model.scenes)
    posture = _over_posture(model)
    fitted = np.flatnonzero(np.isin(model.design.owner, list(model.best.members)))
    found = []
    for effect in asked:
        members = members_of(model, effect.name)
        values = model.values(members, model.best)
        columns, right, energy = [], [], 0.0
        for p, smooth in zip(model.panels, posture, strict=True):
            x = 2.0 * (p.scene.t - ends[0]) / max(ends[1] - ends[0], 1e-12) - 1.0
            pattern = p.twists(values)
            free = pattern[:, :, None] * np.polynomial.legendre.legvander(x, _DEGREE)[:, None, 1:]
            X = np.concatenate([p.tcp[:, :, fitted], free], axis=2) * p.w_tcp[..., None]
            columns.append(X.reshape(-1, X.shape[2]))
            right.append(((p.y_tcp - smooth) * p.w_tcp).ravel())
            energy += float(np.sum((pattern * p.w_tcp) ** 2))
        A, y = np.concatenate(columns), np.concatenate(right)
        gain = _left(A[:, : len(fitted)], y) - _left(A, y)
        if gain > max(_GAIN * model.evidence.temperature, effect.accuracy**2 * energy):
            found.append(effect.name)
    return found


def _left(A: np.ndarray, y: np.ndarray) -> float:
    """What columns A (M, K) leave of y (M,), squared."""
    scale = np.linalg.norm(A, axis=0)
    X = A[:, scale > 0.0] / scale[scale > 0.0]
    return float(np.sum((y - X @ np.linalg.lstsq(X, y, rcond=_RANK)[0]) ** 2))


def _over_posture(model: Model) -> list[np.ndarray]:
    """(N, 6) a log: the discrepancy's part over posture beside the best set."""
    field, sizes = model.evidence.field, model.evidence.sizes
    if field is None or sizes is None:
        return [np.zeros_like(p.y_tcp) for p in model.panels]
    own = model.basis.part == PARTS.index("posture")
    weights = field.fitted(model.best.mean, sizes)
    return [np.zeros_like(p.y_tcp) if p.smooth is None else p.smooth[:, own] @ weights[own] for p in model.panels]
