"""The discrepancy: what no effect explains, as a smooth field of low rank over posture, direction of motion, force and time.

Kennedy and O'Hagan (J. R. Statist. Soc. B 63, 2001, 425): a model that is compared with reality needs a term for what it lacks,
or its parameters take the lack's place. The term here is a Gaussian process with a proper prior of its own size, fitted beside
the effects and integrated out, so that an effect has to explain better than a smooth function of posture does. Its kernel is a
sum over single axes and pairs of them, as errors of gears, bearings and links are; its leading functions on the logged postures
(Nystrom) make it linear in the rows.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solve_triangular
from scipy.linalg.lapack import dpotrf, dtrtrs

from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.gap.observation.scene import Scene

__all__ = [
    "LENGTHS",
    "PARTS",
    "FieldGram",
    "Integrated",
    "SmoothBasis",
    "normalised",
    "posture_kernel",
    "smooth_basis",
    "unit_of",
]

Array = NDArray[np.float64]

PARTS = ("posture", "direction", "force", "time", "travel")
"""What the discrepancy is a function of, each with a size of its own."""

LENGTHS = (0.4, 0.8, 1.6)
"""rad over which an axis's errors change: a gear's few cycles, a bearing, a link that bends; each twice the one before."""
_TRACK = 0.5  # m of a sliding axis that count as a rad
_ANCHORS = 240  # postures that the kernel is laid out on
_RANK, _TAIL = 90, 1e-4  # functions at the most; share of the field's variance that is left out
_TURNED_RANK = 140  # functions at the most where what was measured on turns
_SOME = 2000  # rows that tell the field's variance well enough
_COSINES = 6  # over the logs' time
_DEGREE = 4  # of polynomials over a sliding axis's travel
_STILL = 1e-4  # rad or m
_STRIPE = 64  # postures whose kernel is reckoned at a time
_NONE = 1e-30  # variance of what does not change


@dataclass(frozen=True)
class SmoothBasis:
    """Functions of the discrepancy. axes: that it follows; anchors: (m, k) postures, normalised; mix: (m, r) from kernel values
    to functions, whose means over the logs are `middle` (r,); raw: (m, s) to those that hold all of the kernel on the anchors;
    unit: its variance that counts as 1; span: s, the logs' first time and last; part: (M,) of `PARTS`, by
    number. Each part's functions have unit variance over the logs together, and a constant of as much beside posture's.
    """

    axes: tuple[str, ...]
    anchors: Array
    mix: Array
    middle: Array
    raw: Array
    unit: float
    span: tuple[float, float]
    force: float
    part: NDArray[np.int64]
    tables: tuple[int, ...] = ()
    slides: tuple[tuple[str, float, float], ...] = ()

    def columns(self, scene: Scene) -> Array:
        """(N, M) functions at the samples of a log."""
        parts = [
            np.ones((len(scene), 1)),
            posture_kernel(normalised(scene, self.axes), self.anchors, self.tables) @ self.mix - self.middle,
        ]
        if (self.part == 1).any():
            parts.append(_directions(scene, self.axes))
        if (self.part == 2).any():
            force = scene.force
            parts.append(np.zeros((len(scene), 3)) if force is None else force / self.force)
        for axis, low, high in self.slides:
            x = 2.0 * (scene.link[:, scene.index(axis)] - low) / (high - low) - 1.0
            weight = np.sqrt(2.0 * np.arange(1.0, _DEGREE + 1.0) + 1.0) / np.arange(1.0, _DEGREE + 1.0)
            parts.append(np.polynomial.legendre.legvander(x, _DEGREE)[:, 1:] * weight)
        if (self.part == 3).any():
            at = np.clip((scene.t - self.span[0]) / (self.span[1] - self.span[0]), 0.0, 1.0)
            weight = 1.0 / np.arange(1.0, _COSINES + 1.0)
            parts.append(
                np.cos(np.pi * np.outer(at, np.arange(1, _COSINES + 1))) * weight * np.sqrt(2.0 / np.sum(weight**2))
            )
        return np.concatenate(parts, axis=1)

    def beyond(self, scene: Scene, rows: NDArray[np.int64]) -> Array:
        """(N, N) covariance of posture's part that its functions don't hold at some rows: 0 where the logs were, all of it far
        from there (Quinonero-Candela and Rasmussen, J. Mach. Learn. Res. 6, 2005, 1939, section 6).
        """
        postures = normalised(scene, self.axes)[rows]
        held = posture_kernel(postures, self.anchors, self.tables) @ self.raw
        return np.asarray((posture_kernel(postures, postures, self.tables) - held @ held.T) / self.unit)


def smooth_basis(scenes: Sequence[Scene]) -> SmoothBasis:
    """The functions that describe a discrepancy on some logs."""
    axes = tuple(
        a
        for k, a in enumerate(scenes[0].axes)
        if all(f"{a}.zero" in s.places for s in scenes) and any(float(np.ptp(s.link[:, k])) > _STILL for s in scenes)
    )
    postures = np.concatenate([normalised(s, axes) for s in scenes])
    anchors = postures[np.linspace(0, len(postures) - 1, min(_ANCHORS, len(postures))).astype(int)]
    some = postures[:: max(1, len(postures) // _SOME)]
    joints = [scenes[0].cell.joints[scenes[0].cell.index(a)] for a in axes]
    tables = tuple(k for k, j in enumerate(joints) if j.role is Role.WORKPIECE and not j.prismatic)
    values, vectors = np.linalg.eigh(posture_kernel(anchors, anchors, tables))
    good = values > 1e-10 * values[-1]
    raw = vectors[:, good] / np.sqrt(values[good])
    F = posture_kernel(some, anchors, tables) @ raw
    middle = F.mean(axis=0)
    variance, turned = np.linalg.eigh((F - middle).T @ (F - middle) / len(F))
    order = np.argsort(-variance)
    share = np.cumsum(variance[order]) / max(float(np.sum(variance)), _NONE)
    order = order[: min(_TURNED_RANK if tables else _RANK, int(np.searchsorted(share, 1.0 - _TAIL)) + 1)]
    unit = max(float(np.sum(variance[order])), _NONE)
    turned = turned[:, order] / np.sqrt(unit)
    paths = not any(s.poses for s in scenes)
    forces = [s.force for s in scenes]
    pushed = [f for f in forces if f is not None]
    force = float(np.sqrt(np.mean(np.concatenate(pushed) ** 2))) if len(pushed) == len(scenes) else 0.0
    slides = tuple((a, *_travel(scenes, a)) for a, j in zip(axes, joints, strict=True) if j.prismatic)
    # in the order of `columns`
    counts = {
        0: 1 + len(order),
        1: len(axes) * paths,
        2: 3 * (force > 0.0),
        4: _DEGREE * len(slides),
        3: _COSINES * paths,
    }
    part = np.repeat(list(counts), list(counts.values()))
    span = float(min(s.t[0] for s in scenes)), float(max(s.t[-1] for s in scenes))
    return SmoothBasis(axes, anchors, raw @ turned, middle @ turned, raw, unit, span, force, part, tables, slides)


def _travel(scenes: Sequence[Scene], axis: str) -> tuple[float, float]:
    """Lowest and highest value of an axis in some logs."""
    values = [s.link[:, s.index(axis)] for s in scenes]
    return float(min(v.min() for v in values)), float(max(v.max() for v in values))


def normalised(scene: Scene, axes: Sequence[str]) -> Array:
    """(N, k) rad of turning axes, and what counts as such of sliding ones."""
    return np.asarray(scene.link[:, [scene.index(a) for a in axes]] / unit_of(scene.cell, axes))


def unit_of(cell: Cell, axes: Sequence[str]) -> Array:
    """(k,) rad or m of some axes that count as one: as much as a rad of a turning one."""
    return np.array([_TRACK if cell.joints[cell.index(a)].prismatic else 1.0 for a in axes])


def posture_kernel(a: Array, b: Array, tables: Sequence[int], shorter: float = 1.0) -> Array:
    """(N, m) covariance of a field of unit size at some postures (N, k) and others (m, k), as `normalised` gives them.

    tables: columns of axes that turn the measured frame under what the robot leaves; shorter: factor of `LENGTHS`.
    """
    out = np.empty((len(a), len(b)))
    for first in range(0, len(a), _STRIPE):
        stripe = slice(first, first + _STRIPE)
        out[stripe] = _kernel_stripe(a[stripe], b, tables, shorter * LENGTHS[-1])
    return out


def _kernel_stripe(a: Array, b: Array, tables: Sequence[int], longest: float) -> Array:
    """`posture_kernel` of few postures (N, k), for which what it makes on the way stays near the processor; longest: rad."""
    total, squares = np.zeros((len(a), len(b))), np.zeros((len(a), len(b)))
    for k in range(a.shape[1]):
        # of lengths that double, each exponential is the fourth power of the next
        part = np.exp((a[:, k, None] - b[None, :, k]) ** 2 * (-0.5 / longest**2))
        one = part.copy()
        for _ in LENGTHS[1:]:
            part *= part
            part *= part
            one += part
        one /= len(LENGTHS)
        total += one
        squares += one**2
    count = max(a.shape[1], 1)
    out = (total + 0.5 * (total**2 - squares)) / (count + 0.5 * count * (count - 1))
    for k in tables:
        out = out * 0.5 * (1.0 + np.cos(a[:, k, None] - b[None, :, k]))
    return np.asarray(out)


def _directions(scene: Scene, axes: Sequence[str]) -> Array:
    """(N, k) sides on which the axes are, -1 to 1."""
    if scene.poses:
        return np.zeros((len(scene), len(axes)))
    return np.asarray(scene.sides[:, [scene.index(a) for a in axes]])


@dataclass(frozen=True)
class Integrated:
    """Gram quantities with the discrepancy integrated out: A (K, K), b (K,), yy; half_log: half the log determinant."""

    A: Array
    b: Array
    yy: float
    half_log: float

    def less(self, parts: Sequence[Integrated]) -> Integrated:
        """Without what parts of the discrepancy explain."""
        A, b, yy, half = self.A.copy(), self.b.copy(), self.yy, self.half_log
        for p in parts:
            A -= p.A
            b -= p.b
            yy, half = yy - p.yy, half + p.half_log
        return Integrated(A, b, yy, half)


@dataclass(frozen=True)
class FieldGram:
    """Weighted products of the discrepancy's functions by block and row of the twist: with columns, C (B, 6, K, M); among
    themselves, D (B, 6, M, M); with the gap, d (B, 6, M). part: (M,).
    """

    C: Array
    D: Array
    d: Array
    part: NDArray[np.int64]

    @classmethod
    def empty(cls, like: FieldGram) -> FieldGram:
        """Of no rows, in one block."""
        C, D, d = (np.zeros((1, *x.shape[1:])) for x in (like.C, like.D, like.d))
        return cls(C, D, d, like.part)

    def heated(self, temperature: float) -> FieldGram:
        """With every row weighing less by a factor."""
        C, D, d = (x / temperature for x in (self.C, self.D, self.d))
        return FieldGram(C, D, d, self.part)

    def turns_lowered(self, factor: float) -> FieldGram:
        """With the products of turns lower by a factor."""
        if factor == 1.0:
            return self
        by_row = np.repeat([1.0, factor], 3)
        C, D = (x * by_row[None, :, None, None] for x in (self.C, self.D))
        return FieldGram(C, D, self.d * by_row[None, :, None], self.part)

    def more(self, C: Array, D: Array, d: Array) -> FieldGram:
        """One block with further rows' sums."""
        return FieldGram(self.C + C, self.D + D, self.d + d, self.part)

    def less(self, other: FieldGram) -> FieldGram:
        """All blocks as one, without the rows of another."""
        C, D, d = (
            mine.sum(axis=0) - theirs for mine, theirs in ((self.C, other.C), (self.D, other.D), (self.d, other.d))
        )
        return FieldGram(C, D, d, self.part)

    def integrated(
        self, A: Array, b: Array, yy: float, sizes: Array, used: Sequence[int], temperature: float = 1.0
    ) -> Integrated:
        """A, b, yy of some blocks without what a field of sizes (2, parts) explains; of shifts in m, of turns in rad. Its rows
        weigh less by the temperature, as those of A, b and yy already do.
        """
        parts = [self.taken(k, sizes, used, temperature) for k in range(len(sizes))]
        return Integrated(A, b, yy, 0.0).less(parts)

    def taken(self, stage: int, sizes: Array, used: Sequence[int], temperature: float = 1.0) -> Integrated:
        """What a field of sizes (2, parts) explains of shifts (stage 0) or of turns (1) alone, as in `integrated`."""
        K = self.C.shape[2]
        A, b, yy, half = np.zeros((K, K)), np.zeros(K), 0.0, 0.0
        for row, S, keep in self._rows(sizes):
            if row // 3 != stage:
                continue
            C, D, d = (x[list(used), row].sum(axis=0) / temperature for x in (self.C, self.D, self.d))
            L, V = _halved(D, np.c_[C.T, d], S, keep)
            A += V[:, :-1].T @ V[:, :-1]
            b += V[:, :-1].T @ V[:, -1]
            yy += float(V[:, -1] @ V[:, -1])
            half += float(np.log(np.diag(L)).sum())
        return Integrated(A, b, yy, half)

    def fitted(self, values: Array, sizes: Array) -> Array:
        """(M, 6) weights of the functions beside effects of values (K,)."""
        out = np.zeros((len(self.part), 6))
        for row, S, keep in self._rows(sizes):
            C, D, d = (x[:, row].sum(axis=0) for x in (self.C, self.D, self.d))
            L, v = _halved(D, (d - C.T @ values)[:, None], S, keep)
            out[keep, row] = S[keep] * solve_triangular(L, v[:, 0], lower=True, trans=1)
        return out

    def response(self, sizes: Array) -> Array:
        """(M, 3, K) by how much less weight the functions get in shifts for each unit of the values beside them."""
        out = np.zeros((len(self.part), 3, self.C.shape[2]))
        for row, S, keep in self._rows(sizes):
            if row < 3:
                C, D = (x[:, row].sum(axis=0) for x in (self.C, self.D))
                L, v = _halved(D, C.T, S, keep)
                out[keep, row] = S[keep, None] * solve_triangular(L, v, lower=True, trans=1)
        return out

    def scatter(self, F: Array, sizes: Array) -> Array:
        """(3, M, N): V with the covariance V.T V of what the fitted field's shift in each direction may be off by, where its
        functions are F (N, M).
        """
        out = np.zeros((3, F.shape[1], len(F)))
        for row, S, keep in self._rows(sizes):
            if row < 3:
                out[row, keep] = _halved(self.D[:, row].sum(axis=0), F.T, S, keep)[1]
        return out

    def _rows(self, sizes: Array) -> list[tuple[int, Array, NDArray[np.bool_]]]:
        """Rows of the twist with a field of some size, its functions' deviations (M,), and which are not 0."""
        found = []
        for row in range(6):
            S = sizes[row // 3][self.part]
            if S.any() and self.D[:, row].any():
                found.append((row, S, S > 0.0))
        return found


def _halved(D: Array, right: Array, S: Array, keep: NDArray[np.bool_]) -> tuple[Array, Array]:
    """The Cholesky factor L of the posterior precision in deviations S of the prior, and L^-1 S right."""
    s = S[keep]
    P = D[np.ix_(keep, keep)] * np.outer(s, s)
    P[np.diag_indices_from(P)] += 1.0
    L, _ = dpotrf(P, lower=1, clean=1)
    V, _ = dtrtrs(L, s[:, None] * right[keep], lower=1)
    return L, V
