"""Shapes of the unknown by what each takes of the gap beside frames that nobody reported: these are laid out on what is wrong, so
that what stays between them and the poses follows everything.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.scan import DRIVE, Shape
from camrob.gap.evidence.unknown import UNKNOWN

__all__ = ["beside_frames"]

Array = NDArray[np.float64]

_RANK = 1e-9  # of the largest singular value of columns


def beside_frames(model: Model, found: Sequence[Shape]) -> list[Shape]:
    """Shapes, those behind the encoders that take most first where frames or latencies are fitted; else as they are."""
    columns = np.flatnonzero(np.isin(model.design.owner, sorted(model.evidence.always)))
    if not len(columns):
        return list(found)
    frames = np.concatenate(
        [(p.tcp[:, :, columns] * p.w_tcp[:, :, None]).reshape(-1, len(columns)) for p in model.panels]
    )
    y = np.concatenate([(p.y_tcp * p.w_tcp).ravel() for p in model.panels])
    U, size, _ = np.linalg.svd(frames / np.maximum(np.linalg.norm(frames, axis=0), 1e-300), full_matrices=False)
    Q = U[:, size > _RANK * size[0]]
    left = y - Q @ (Q.T @ y)
    behind = [s for s in found if not s.target.startswith(DRIVE)]
    taken = {id(s): _taken(left, Q, _columns(model.panels, s)) for s in behind}
    return [
        *(s for s in found if s.target.startswith(DRIVE)),
        *sorted(behind, key=lambda s: -taken[id(s)]),
    ]


def _columns(panels: Sequence[Panel], shape: Shape) -> Array:
    """(6 N, d) weighed columns of a shape behind the encoders."""
    key = f"{shape.target}|{shape.quantity}"
    state = {f"{key}|lower": shape.lower, f"{key}|upper": shape.upper}
    (unit,) = UNKNOWN.units([p.scene for p in panels], state)
    own = [[c.tcp for c in UNKNOWN.columns(p.scene, unit, state) if c.tcp is not None] for p in panels]
    return np.concatenate(
        [(np.stack(c, axis=2) * p.w_tcp[:, :, None]).reshape(-1, len(c)) for p, c in zip(panels, own, strict=True)]
    )


def _taken(left: Array, Q: Array, X: Array) -> float:
    """Squares of what orthonormal columns Q leave, that columns X take of it."""
    Z = X - Q @ (Q.T @ X)
    rest = left - Z @ np.linalg.lstsq(Z, left, rcond=_RANK)[0]
    return float(left @ left - rest @ rest)
