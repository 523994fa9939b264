"""The characteristic length of an arm: the one at which its best-conditioned posture is conditioned best (section 2.3)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.cell import Cell
from camrob.frozen import locked
from camrob.kinematics.kernels import ChainArrays, chain_arrays, inverse_kf_many

__all__ = ["BestCondition", "best_condition"]

Array = NDArray[np.float64]

_DRAWN = 4000  # postures that the search begins with
_LENGTHS = np.geomspace(0.03, 3.0, 25)  # m: from a hand's arm to the largest that is sold
_POLISHED = 12  # of them, the best, are walked down from
_SAME = 1e-9  # of k_F: a joint's part in it is nothing, or much more
_ROUNDED = 1e-10  # of k_F and of what is moved, where a walk ends


@dataclass(frozen=True, slots=True)
class BestCondition:
    """The length, m, k_F there (1 is ideal), and the posture q (n,) of it, its joints outside of the arm at HOME."""

    length: float
    kf: float
    q: Array

    def __post_init__(self) -> None:
        object.__setattr__(self, "q", locked(self.q, shape=(None,), name="q"))


def best_condition(cell: Cell, *, seed: int = 0) -> BestCondition:
    """Least k_F (eq. 16) of the bare arm over its postures within limits and over the length, searched from many starts."""
    from scipy.optimize import minimize

    chain, part = chain_arrays(cell), cell.arm_slice
    lower, upper = (
        np.where(np.isfinite(limit[part]), limit[part], side * np.pi)
        for limit, side in ((cell.q_lower, -1.0), (cell.q_upper, 1.0))
    )
    drawn = np.tile(cell.q_home, (_DRAWN, 1))
    drawn[:, part] = np.random.default_rng(seed).uniform(lower, upper, (_DRAWN, len(lower)))
    values = np.stack([inverse_kf_many(chain._replace(length=float(x)), drawn) for x in _LENGTHS])

    def kf(x: Array) -> float:
        q = np.array(cell.q_home)
        q[part] = np.clip(x[:-1], lower, upper)
        return _kf(chain._replace(length=float(np.exp(np.clip(x[-1], *np.log(_LENGTHS[[0, -1]]))))), q)

    best, least = np.array(cell.q_home[part]), np.inf
    for k in np.argsort(values.max(axis=0))[::-1][:_POLISHED]:
        start = np.append(drawn[k, part], np.log(_LENGTHS[int(np.argmax(values[:, k]))]))
        options = {"xatol": _ROUNDED, "fatol": _ROUNDED, "maxiter": 20_000, "maxfev": 20_000, "adaptive": True}
        found = minimize(kf, start, method="Nelder-Mead", options=options)
        if found.fun < least:
            best, least = np.asarray(found.x), float(found.fun)
    length = float(np.exp(best[-1]))
    q = np.array(cell.q_home)
    q[part] = np.clip(best[:-1], lower, upper)
    for i in range(*part.indices(len(cell))):  # a joint that has no part in it stays at HOME
        home = q.copy()
        home[i] = cell.q_home[i]
        if abs(_kf(chain._replace(length=length), home) - least) < _SAME:
            q = home
    return BestCondition(length, least, q)


def _kf(chain: ChainArrays, q: Array) -> float:
    return 1.0 / max(float(inverse_kf_many(chain, q[None])[0]), 1e-12)
