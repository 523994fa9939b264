"""What no effect explains, as a field over posture that other runs can be asked about: where it was measured it is known, far
from there only its size is.

The diagnosis' discrepancy (`evidence/discrepancy.py`) is a Gaussian process. Its posterior is kept at a few of the logged
postures, which hold all of it where the logs were; elsewhere it is what a Gaussian process with these values there is
(Quinonero-Candela and Rasmussen, J. Mach. Learn. Res. 6, 2005, 1939; Titsias, AISTATS 2009, eq. 6): its mean goes back to a
constant, its deviation grows to that of its prior. Only what follows posture and travel counts: what follows direction, load or
time on these runs says nothing of another's, and belongs to the rest that is alike everywhere.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from camrob.gap.evidence.discrepancy import PARTS, normalised, posture_kernel
from camrob.gap.evidence.field_size import sizes_beside
from camrob.gap.evidence.model import Model, whole_gap
from camrob.gap.observation.scene import Scene
from camrob.measurement.log_info import MeasuredFrame
from camrob.summaries.fitted.diagnosis_fitted import UnexplainedSaid

__all__ = ["SHORTER", "SIZE_DOUBT", "UnexplainedAt", "UnexplainedField", "unexplained_field"]

Array = NDArray[np.float64]

SHORTER = 0.7
"""By this the lengths over which the field changes are taken shorter away from the logs than among them: how it goes on there
no log tells, and a long length makes it go on too surely (held to cells of other code in `docs/explanation/prediction.md`).
"""

SIZE_DOUBT = 0.35
"""Standard deviation of the logarithm of the field's size far from the logs: they show a few of its hills, beside constants of
the chain that take a part of them, and its size over all postures is another (held to cells of other code, in the same place).
"""

_POSTURES = 80  # kept at the most
_HELD = 0.01  # share of the field's variance over the logs that may be missing at a posture that isn't kept
_PARTS = 60  # of what is not known along a run, at the most
_JITTER = 1e-9  # of the kernel's own variance: what rounding needs
_OF_POSTURE = (PARTS.index("posture"), PARTS.index("travel"))
_DIGITS = 6  # of a number in the file


class UnexplainedAt(NamedTuple):
    """N samples: mean (N, 3) m, in `world` or `base` as the field is; known, beyond: (N,) m in any one direction, the standard
    deviation of what logs near by tell, and of what none tells, whose size is itself in doubt by `SIZE_DOUBT`; by_value:
    (N, 3, K + L) m by which the mean is less for a unit more of each fitted value, and of each that is open.
    """

    mean: Array
    known: Array
    beyond: Array
    by_value: Array


@dataclass(frozen=True)
class UnexplainedField:
    """A smooth error of the tool that posture decides and no effect explains. axes: that it follows; tables: columns of those
    that turn the part; postures: (m, k), normalised as `normalised` does, at which its shift is known: mean (m, 3) m, cov (m, m)
    m2 of each direction, by_value (m, 3, K) by how much less it is for a unit more of each fitted value, by_open (m, 3, L) of
    each that was not claimed (`unclaimed.py`). in_base: seen from `base`, else from `world`. variance: m2 of its prior, same: m2
    of a constant beside it. rest: m in one direction, what is neither an effect's nor the field's.
    """

    axes: tuple[str, ...]
    tables: tuple[int, ...]
    in_base: bool
    postures: Array
    mean: Array
    cov: Array
    by_value: Array
    variance: float
    same: float
    rest: float
    by_open: Array

    def kernel(self, a: Array, b: Array) -> Array:
        """(N, M) m2, prior covariance of a shift in one direction at postures (N, k) and others (M, k)."""
        return self.same + self.variance * posture_kernel(a, b, self.tables, SHORTER)

    @property
    def among(self) -> Array:
        """(m, m) m2, the kernel among the postures at which the field is known."""
        own = self.kernel(self.postures, self.postures)
        own[np.diag_indices_from(own)] *= 1.0 + _JITTER
        return own

    def at(self, scene: Scene) -> UnexplainedAt:
        """What is to be expected at the samples of a run, wherever it was measured."""
        asked = normalised(scene, self.axes)
        cross, share = self._shares(asked)
        known, beyond = (np.sqrt(v) for v in self._variances(cross, share))
        by_value = np.concatenate([self.by_value, self.by_open], axis=2)
        return UnexplainedAt(share @ self.mean, known, beyond, np.einsum("nm,mdk->ndk", share, by_value))

    def together(self, scene: Scene) -> Array:
        """(N, L) m, the L independent parts of which what is not known at the samples of a run is made, in any one direction:
        L L^T is its covariance there, but for a hundredth of the variance of its prior.
        """
        asked = normalised(scene, self.axes)
        cross, share = self._shares(asked)
        left = np.add(*self._variances(cross, share))
        parts, enough = np.zeros((len(asked), 0)), _HELD * (self.variance + self.same)
        while len(left) and parts.shape[1] < _PARTS and left.max() > enough:
            k = int(np.argmax(left))
            column = self.kernel(asked, asked[k : k + 1])[:, 0] + share @ (self.cov @ share[k] - cross[k])
            column = (column - parts @ parts[k]) / np.sqrt(left[k])
            parts, left = np.c_[parts, column], np.maximum(left - column**2, 0.0)
            left[k] = 0.0
        return parts

    def _shares(self, asked: Array) -> tuple[Array, Array]:
        """(N, m) m2, covariances of postures (N, k) with those that are known, and the shares of these in what is expected."""
        cross = self.kernel(asked, self.postures)
        return cross, cho_solve(cho_factor(self.among), cross.T).T

    def _variances(self, cross: Array, share: Array) -> tuple[Array, Array]:
        """(N,) m2 each in one direction: of what was measured near by, and of what none of it tells."""
        known = np.einsum("nm,ml,nl->n", share, self.cov, share, optimize=True)
        beyond = self.same + self.variance - np.einsum("nm,nm->n", share, cross)
        return np.maximum(known, 0.0), np.maximum(beyond, 0.0)

    def said(self) -> UnexplainedSaid:
        """The part of the JSON object."""

        def rows(values: Array) -> tuple[tuple[float, ...], ...]:
            return tuple(tuple(float(f"{v:.{_DIGITS}g}") for v in row) for row in values)

        return UnexplainedSaid(
            axes=self.axes,
            tables=self.tables,
            frame="base" if self.in_base else "world",
            postures=rows(self.postures),
            mean=rows(self.mean),
            covariance=rows(self.cov),
            by_value=rows(self.by_value.reshape(len(self.mean), -1)),
            by_open=rows(self.by_open.reshape(len(self.mean), -1)) if self.by_open.size else (),
            variance=self.variance,
            same=self.same,
            rest=self.rest,
        )

    @classmethod
    def of(cls, said: UnexplainedSaid) -> UnexplainedField:
        """What a JSON object holds."""
        m = len(said.postures)
        return cls(
            axes=said.axes,
            tables=said.tables,
            in_base=said.frame == "base",
            postures=np.asarray(said.postures, float).reshape(m, len(said.axes)),
            mean=np.asarray(said.mean, float).reshape(m, 3),
            cov=np.asarray(said.covariance, float).reshape(m, m),
            by_value=np.asarray(said.by_value, float).reshape(m, 3, -1),
            by_open=np.asarray(said.by_open, float).reshape(m, 3, -1) if said.by_open else np.zeros((m, 3, 0)),
            variance=said.variance,
            same=said.same,
            rest=said.rest,
        )


def unexplained_field(model: Model, members: frozenset[int], unclaimed: Sequence[int] = ()) -> UnexplainedField | None:
    """The discrepancy beside the claimed units `members` of the best set; None where there is none, or where logs were measured
    in several frames. unclaimed: units of which it is told, too, what the field would make up for.
    """
    field, basis = model.evidence.field, model.basis
    smooth = [p.smooth for p in model.panels if p.smooth is not None]
    in_base = {p.scene.log.info.measured_frame is MeasuredFrame.BASE for p in model.panels}
    if field is None or len(smooth) < len(model.panels) or len(in_base) > 1 or not basis.axes:
        return None
    sizes = sizes_beside(model.evidence, members, model.noises)
    values = model.values(members | model.evidence.always, model.best)
    own = np.isin(basis.part, _OF_POSTURE)
    if not sizes[0, PARTS.index("posture")]:
        return None
    weights = field.fitted(values, sizes)[:, :3] * own[:, None]
    postures = np.concatenate([normalised(p.scene, basis.axes) for p in model.panels])
    F = np.concatenate(smooth) * own
    some = np.linspace(0, len(postures) - 1, min(len(basis.anchors), len(postures))).astype(int)
    size = float(sizes[0, PARTS.index("posture")]) ** 2
    variance = size / basis.unit
    among = variance * posture_kernel(postures[some], postures[some], basis.tables, SHORTER)
    kept = some[_spanning(among, _HELD * size)]
    V = field.scatter(F[kept], sizes)
    owner = model.design.owner
    claimed = np.flatnonzero(np.isin(owner, sorted(members)))
    columns = np.concatenate([claimed, *(np.flatnonzero(owner == i) for i in unclaimed)]).astype(np.int64)
    turn = model.panels[0].scene.frames.left[:3, :3].T  # from the instrument's frame, where that is another
    by_value = np.einsum("de,nm,mek->ndk", turn, F[kept], field.response(sizes)[:, :, columns], optimize=True)
    return UnexplainedField(
        axes=basis.axes,
        tables=basis.tables,
        in_base=in_base.pop(),
        postures=postures[kept],
        mean=F[kept] @ weights @ turn.T,
        cov=np.einsum("dmi,dmj->ij", V, V) / 3.0,
        by_value=by_value[:, :, : len(claimed)],
        by_open=by_value[:, :, len(claimed) :],
        variance=variance,
        same=size,
        rest=_rest(model, values, weights),
    )


def _rest(model: Model, values: Array, weights: Array) -> float:
    """m in one direction: what values (K,) and a field of weights (M, 3) leave of the logs, beyond the noise."""
    columns, left = np.flatnonzero(values), []
    for p in model.panels:
        good = (p.w_tcp[:, 0] > 0.0) & ~p.unknown_rows(columns)
        left.append((whole_gap(p) - p.moves(values) - (0.0 if p.smooth is None else p.smooth @ weights))[good])
    square = float(np.mean(np.sum(np.concatenate(left) ** 2, axis=1)))
    return float(np.sqrt(max(square - model.noise**2, 0.0) / 3.0))


def _spanning(K: Array, tolerance: float) -> NDArray[np.int64]:
    """Rows of a covariance (n, n) beside which no other has more variance of its own than `tolerance`: by Cholesky's
    factorisation, the largest first.
    """
    left, L, kept = np.diag(K).copy(), np.zeros((len(K), 0)), list[int]()
    while len(kept) < min(_POSTURES, len(K)) and left.max() > tolerance:
        k = int(np.argmax(left))
        column = (K[:, k] - L @ L[k]) / np.sqrt(left[k])
        L, left = np.c_[L, column], np.maximum(left - column**2, 0.0)
        left[k] = 0.0
        kept.append(k)
    return np.array(kept or [0], np.int64)
