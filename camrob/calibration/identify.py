"""Which parameters measured poses can tell apart, before any number is fitted."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

__all__ = ["Identifiability", "Observability", "identify"]

Array = NDArray[np.float64]

_RANK = 1e-5  # of a column's own length: what is left of it beyond the others' span counts as nothing below
_WEAK = 1.0  # ordinary sizes of a parameter: a standard error beyond tells next to nothing of it
_SHARE = 0.05  # of the largest coefficient: below, a parameter is not named as one that another is merged with


@dataclass(frozen=True, slots=True)
class Observability:
    """Observability indices of the scaled Jacobian's singular values s_1 >= .. >= s_r over m measurements.

    o1 (Borm and Menq): (s_1 .. s_r)^(1/r) / sqrt(m); o2 (Driels and Pathre): s_r / s_1; o3 (Nahvi and others): s_r; o4
    (Nahvi and Hollerbach): s_r^2 / s_1; o5 (Sun and Hollerbach): 1 / sum(1/s).
    """

    o1: float
    o2: float
    o3: float
    o4: float
    o5: float

    @classmethod
    def of(cls, singular: Array, measurements: int) -> Observability:
        """The indices of singular values (r,), none 0."""
        s = np.sort(np.asarray(singular))[::-1]
        o1 = np.exp(np.mean(np.log(s))) / np.sqrt(measurements)
        return cls(float(o1), float(s[-1] / s[0]), float(s[-1]), float(s[-1] ** 2 / s[0]), float(1.0 / np.sum(1.0 / s)))


@dataclass(frozen=True, slots=True)
class Identifiability:
    """What the data say of P parameters.

    kept: names of those that can be fitted together. merged: name of a parameter that can't be told from others, to
    their names (its effect is part of theirs). unseen: those without any effect on what was measured. weak: those
    whose standard error would be several times their ordinary size. singular (kept,): values of the scaled, whitened
    Jacobian. left_out: all that are not kept, in the parameters' order.
    """

    kept: tuple[str, ...]
    merged: dict[str, tuple[str, ...]]
    unseen: tuple[str, ...]
    weak: tuple[str, ...]
    singular: tuple[float, ...]
    observability: Observability
    condition: float
    left_out: tuple[str, ...] = field(default=())


def identify(names: tuple[str, ...], J: Array, scales: Array) -> Identifiability:
    """Identifiability of parameters in their order: an earlier one keeps what it shares with a later one.

    J (m, P): derivatives of the measurements, divided by their noise. scales (P,): the parameters' ordinary sizes. Columns are
    orthogonalised in the parameters' order (Gram-Schmidt, twice); then, while a standard error is hopeless, the last of the
    parameters bound up with it goes. Raises ValueError where nothing can be fitted.
    """
    A = J * scales
    kept, merged, unseen, weak = _independent(names, A)
    while kept:
        _, s, Vt = np.linalg.svd(A[:, kept], full_matrices=False)
        cov = (Vt.T / s**2) @ Vt
        std = np.sqrt(np.diag(cov))
        worst = int(np.argmax(std))
        if std[worst] <= _WEAK:
            return Identifiability(
                kept=tuple(names[k] for k in kept),
                merged=merged,
                unseen=tuple(unseen),
                weak=tuple(weak),
                singular=tuple(float(v) for v in s),
                observability=Observability.of(s, len(J)),
                condition=float(s[0] / s[-1]),
                left_out=tuple(n for n in names if n in merged or n in unseen or n in weak),
            )
        bound = np.flatnonzero(np.abs(cov[worst] / (std[worst] * std)) > 0.9)
        goes = kept[int(bound[-1])]
        weak.append(names[goes])
        kept.remove(goes)
    raise ValueError("none of the parameters has an effect on what was measured")


def _independent(
    names: tuple[str, ...], A: Array
) -> tuple[list[int], dict[str, tuple[str, ...]], list[str], list[str]]:
    """Indices of columns that are not in the span of those before, and what became of the others."""
    m, P = A.shape
    Q, used = np.zeros((m, P)), 0
    R = np.zeros((P, P))
    kept: list[int] = []
    merged: dict[str, tuple[str, ...]] = {}
    unseen: list[str] = []
    weak: list[str] = []
    largest = float(np.linalg.norm(A, axis=0).max(initial=0.0))
    for k in range(P):
        length = float(np.linalg.norm(A[:, k]))
        if length <= 1e-9 * largest or length == 0.0:
            unseen.append(names[k])
            continue
        rest = A[:, k]
        along = np.zeros(used)
        for _ in range(2):
            part = Q[:, :used].T @ rest
            along += part
            rest = rest - Q[:, :used] @ part
        left = float(np.linalg.norm(rest))
        if left <= _RANK * length:
            shares = np.abs(np.linalg.solve(R[:used, :used], along)) if used else np.zeros(0)
            merged[names[k]] = tuple(
                names[kept[i]] for i in np.argsort(-shares) if shares[i] > _SHARE * shares.max(initial=0.0)
            )
        elif left < 1.0 / _WEAK:
            weak.append(names[k])
        else:
            R[:used, used], R[used, used] = along, left
            Q[:, used] = rest / left
            kept.append(k)
            used += 1
    return kept, merged, unseen, weak
