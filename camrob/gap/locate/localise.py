"""Where the gap lies: along the path, by direction, by axis, and by what it depends on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import whole_gap
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import play
from camrob.units import deg_to_rad

__all__ = [
    "FURTHER",
    "REGIMES",
    "RegimeShare",
    "Segment",
    "Share",
    "axes_of",
    "directions_of",
    "lines_of",
    "regimes_of",
    "rms_of",
    "segments_of",
]

Array = NDArray[np.float64]

REGIMES = ("position", "direction", "speed", "acceleration", "load", "time")
FURTHER = ("force", "temperature", "track", "table")
"""Regimes that not every log or cell has."""

_MOST_SEGMENTS, _MOST_LINES = 24, 200  # that a page holds
_PARTS = 5  # that a stretch is cut into, to see how well its mean is known
_SURE = 4.0  # standard errors that a mean has to change by
_NEAR = np.array([1.0] * 4 + [0.0] + [1.0] * 4)  # samples from which an axis's shift at the one between is predicted
_FOLDS = 8
_DRAWS = 200
_RIDGE = 1e-3
_CONSTANT = 1e-9  # of its largest value: a feature that varies by less is a constant with rounding


@dataclass(frozen=True, slots=True)
class Segment:
    """Lines of the program, with rms, contour and tangential error, m; from_s, to_s: s since the start of the log.

    step: m that the mean gap changes by from the stretch before to this one, where that is more than its scatter; else 0.
    """

    log: str
    from_line: int
    to_line: int
    rms: float
    contour: float
    tangential: float
    from_s: float = 0.0
    to_s: float = 0.0
    samples: int = 0
    step: float = 0.0


def _tangent(scene: Scene) -> Array:
    """(N, 3) unit vector of motion at the TCP, 0 at rest."""
    v = scene.velocity(scene.nominal[:, :3, 3])
    size = np.linalg.norm(v, axis=1, keepdims=True)
    return np.where(size > 1e-6, v / np.maximum(size, 1e-12), 0.0)


def _errors(p: Panel) -> tuple[Array, Array]:
    """(N, 3) m the gap, 0 where not seen; (N, 3) m its size, what lies across the path, and along it."""
    good = p.w_tcp[:, 0] > 0.0
    gap = np.where(good[:, None], whole_gap(p), 0.0)
    tangent = _tangent(p.scene)
    along = np.sum(gap * tangent, axis=1)
    across = np.linalg.norm(gap - along[:, None] * tangent, axis=1)
    return gap, np.stack([np.linalg.norm(gap, axis=1), across, along], axis=1)


def segments_of(panels: Sequence[Panel]) -> tuple[Segment, ...]:
    """Stretches of the path between points where the mean gap changes most (binary splitting of its piecewise mean)."""
    out: list[Segment] = []
    for p in panels:
        good = p.w_tcp[:, 0] > 0.0
        gap, parts = _errors(p)
        line = p.scene.log.line if p.scene.log.has("line") else np.arange(len(p.scene)) + 2
        before: Array | None = None
        for a, b in _splits(gap, max(2, _MOST_SEGMENTS // len(panels))):
            ok = good[a:b]
            if not ok.any():
                continue
            here = gap[a:b][ok]
            rms, across, along = np.sqrt(np.mean(parts[a:b][ok] ** 2, axis=0)).tolist()
            out.append(
                Segment(
                    p.scene.name,
                    int(line[a:b].min()),
                    int(line[a:b].max()),
                    rms,
                    across,
                    along,
                    float(p.scene.t[a]),
                    float(p.scene.t[b - 1]),
                    int(ok.sum()),
                    _step(before, here),
                )
            )
            before = here
    return tuple(out)


def _step(before: Array | None, after: Array) -> float:
    """m between the means of two stretches (N, 3), 0 where that is not clearly more than how far the means are known."""
    if before is None or min(len(before), len(after)) < 2 * _PARTS:
        return 0.0
    error = 0.0
    for values in (before, after):
        means = np.array([part.mean(axis=0) for part in np.array_split(values, _PARTS)])
        error += float(np.sum(means.var(axis=0, ddof=1))) / _PARTS
    size = float(np.linalg.norm(after.mean(axis=0) - before.mean(axis=0)))
    return size if size > _SURE * np.sqrt(error) else 0.0


def lines_of(panels: Sequence[Panel]) -> tuple[Segment, ...]:
    """The program's lines one by one, those with the largest gap first (200 at the most); none where logs don't tell lines."""
    out: list[Segment] = []
    for p in panels:
        if p.scene.poses or not p.scene.log.has("line"):
            continue
        good = np.flatnonzero(p.w_tcp[:, 0] > 0.0)
        names, slot = np.unique(p.scene.log.line[good], return_inverse=True)
        count = np.bincount(slot)
        squares = [np.bincount(slot, weights=x**2) / count for x in _errors(p)[1][good].T]
        begin, end = np.full(len(names), np.inf), np.full(len(names), -np.inf)
        np.minimum.at(begin, slot, p.scene.t[good])
        np.maximum.at(end, slot, p.scene.t[good])
        for k in np.argsort(-squares[0])[:_MOST_LINES].tolist():
            line, (rms, across, along) = int(names[k]), (float(np.sqrt(x[k])) for x in squares)
            out.append(
                Segment(p.scene.name, line, line, rms, across, along, float(begin[k]), float(end[k]), int(count[k]))
            )
    return tuple(sorted(out, key=lambda s: -s.rms)[:_MOST_LINES])


def _splits(values: Array, most: int) -> list[tuple[int, int]]:
    """Stretches of (N, d) whose means differ most, at most so many."""
    sums = np.concatenate([np.zeros((1, values.shape[1])), np.cumsum(values, axis=0)])
    least = max(8, len(values) // (4 * most))
    parts = [(0, len(values))]

    def best(a: int, b: int) -> tuple[float, int]:
        if b - a < 2 * least:
            return 0.0, a
        cut = np.arange(a + least, b - least + 1)
        left, right = (sums[cut] - sums[a]), (sums[b] - sums[cut])
        whole = np.sum((sums[b] - sums[a]) ** 2) / (b - a)
        gain = np.sum(left**2, axis=1) / (cut - a) + np.sum(right**2, axis=1) / (b - cut) - whole
        k = int(np.argmax(gain))
        return float(gain[k]), int(cut[k])

    gains = [best(*parts[0])]
    while len(parts) < most:
        k = int(np.argmax([g for g, _ in gains]))
        if gains[k][0] <= 0.0:
            break
        (a, b), cut = parts[k], gains[k][1]
        parts[k : k + 1] = [(a, cut), (cut, b)]
        gains[k : k + 1] = [best(a, cut), best(cut, b)]
    return parts


@dataclass(frozen=True, slots=True)
class Share:
    """A figure and its 90 % interval, whole stretches of the path drawn anew."""

    value: float
    low: float
    high: float


def rms_of(vectors: Sequence[Array], blocks: Sequence[NDArray[np.int64]]) -> Share:
    """rms in m of some logs' vectors (N, d), by their blocks (N,)."""
    return _drawn(
        np.concatenate([np.sum(v**2, axis=1) for v in vectors]), None, np.concatenate(list(blocks)), root=True
    )


def _drawn(upper: Array, lower: Array | None, block: NDArray[np.int64], *, root: bool) -> Share:
    """sum(upper) / sum(lower) (the mean of `upper` without), or its root, with the interval over blocks drawn anew."""
    names, slot = np.unique(block, return_inverse=True)
    tops = np.bincount(slot, weights=upper, minlength=len(names))
    below = np.bincount(slot, weights=np.ones(len(upper)) if lower is None else lower, minlength=len(names))
    draws = np.random.default_rng(2).integers(0, len(names), (_DRAWS, len(names)))
    many = np.maximum(tops[draws].sum(axis=1), 0.0) / np.maximum(below[draws].sum(axis=1), 1e-30)
    one = max(float(tops.sum()), 0.0) / max(float(below.sum()), 1e-30)
    low, high = np.quantile(many, [0.05, 0.95])
    return Share(*((float(np.sqrt(x)) if root else float(x)) for x in (one, low, high)))


def directions_of(panels: Sequence[Panel]) -> dict[str, Share]:
    """rms in m along the measured frame's axes, along and across the path, along the tool's own axes (`tool_axis`: z), and
    along those of the work (`base`, which may turn with the table).
    """
    names = ("x", "y", "z", "along", "across", "tool_x", "tool_y", "tool_axis", "work_x", "work_y", "work_z")
    parts: dict[str, list[Array]] = {n: [] for n in names}
    blocks = []
    for p in panels:
        good = p.w_tcp[:, 0] > 0.0
        gap, tangent = whole_gap(p)[good], _tangent(p.scene)[good]
        along = np.sum(gap * tangent, axis=1)
        in_tool = np.einsum("nij,ni->nj", p.scene.nominal[good, :3, :3], gap)
        across = np.linalg.norm(gap - along[:, None] * tangent, axis=1)
        in_work = np.einsum("nij,ni->nj", p.scene.measured_R_base[good], gap)
        for name, values in zip(names, (*gap.T, along, across, *in_tool.T, *in_work.T), strict=True):
            parts[name].append(values[:, None])
        blocks.append(p.block[good])
    return {name: rms_of(v, blocks) for name, v in parts.items()}


def axes_of(panels: Sequence[Panel]) -> dict[str, Share]:
    """Share of the gap's energy that a slow shift of each axis alone would explain, through its Jacobian.

    The shift at a sample is predicted from those around it, so that noise explains nothing; of single poses, from each itself.
    """
    shares: dict[str, Share] = {}
    for axis in panels[0].scene.axes:
        gained, total = [], []
        for p in panels:
            y = p.y_tcp.copy()
            y[:, :3] = whole_gap(p)
            w = p.w_tcp
            seen = w[:, :3] > 0.0
            total.append(np.sum((y[:, :3] * seen) ** 2, axis=1))
            if f"{axis}.zero" not in p.scene.places:
                gained.append(np.zeros(len(y)))
                continue
            J = p.scene.places[f"{axis}.zero"] * w
            upper, lower = np.sum(J * y * w, axis=1), np.sum(J**2, axis=1)
            if not p.scene.poses and len(y) > len(_NEAR):
                upper, lower = (np.convolve(x, _NEAR, mode="same") for x in (upper, lower))
            z = upper / np.maximum(lower, 1e-30)
            left = y[:, :3] - p.scene.places[f"{axis}.zero"][:, :3] * z[:, None]
            gained.append(total[-1] - np.sum((left * seen) ** 2, axis=1))
        block = np.concatenate([p.block for p in panels])
        shares[axis] = _drawn(np.concatenate(gained), np.concatenate(total), block, root=False)
    return shares


@dataclass(frozen=True)
class RegimeShare:
    """The share of an energy that a regime explains, its 90 % interval, and how likely it would seem to without doing so."""

    share: float
    interval: tuple[float, float]
    p_value: float


def regimes_of(panels: Sequence[Panel], noise: float, names: Sequence[str] = REGIMES) -> dict[str, RegimeShare]:
    """Share of withheld energy beyond the noise that smooth functions of each regime explain, alone; intervals of 90 %.

    Ridge regression of the TCP vectors on low polynomials; stretches of the path are withheld in turn. The shares need not
    add up: regimes overlap on any one path.
    """
    found: dict[str, RegimeShare] = {}
    y = np.concatenate([whole_gap(p) for p in panels])
    good = np.concatenate([p.w_tcp[:, 0] > 0.0 for p in panels])
    block = np.concatenate([p.block for p in panels]) % _FOLDS
    y = y - y[good].mean(axis=0)
    for name in names:
        X = np.concatenate([_features(p.scene, name) for p in panels])
        X = _standardised(X)
        if X.shape[1] == 0 or good.sum() < 40:
            found[name] = RegimeShare(0.0, (0.0, 0.0), 1.0)
            continue
        found[name] = _withheld_share(X[good], y[good], block[good], noise)
    return found


def _standardised(X: Array) -> Array:
    """Columns of (N, d) with mean 0 and deviation 1, those left out that vary by no more than rounding does."""
    largest = np.abs(X).max(axis=0, initial=0.0)
    scaled = X / np.where(largest > 0.0, largest, 1.0)
    scaled = scaled - scaled.mean(axis=0)
    spread = scaled.std(axis=0)
    kept = spread > _CONSTANT
    return np.asarray(scaled[:, kept] / spread[kept])


def _withheld_share(X: Array, y: Array, block: NDArray[np.int64], noise: float) -> RegimeShare:
    names = np.unique(block)
    A, b = X.T @ X, X.T @ y
    before, gained = [], []
    for k in names:
        rows = block == k
        Ak, bk = A - X[rows].T @ X[rows], b - X[rows].T @ y[rows]
        ridge = _RIDGE * np.trace(Ak) / len(Ak) + 1e-12
        solved = np.linalg.solve(Ak + ridge * np.eye(len(Ak)), bk)
        before.append(np.sum(y[rows] ** 2) - rows.sum() * noise**2)
        gained.append(np.sum(y[rows] ** 2) - np.sum((y[rows] - X[rows] @ solved) ** 2))
    before_, gained_ = np.maximum(np.array(before), 1e-18), np.array(gained)
    draws = np.random.default_rng(1).integers(0, len(names), (_DRAWS, len(names)))
    shares = np.clip(gained_[draws].sum(axis=1) / before_[draws].sum(axis=1), 0.0, 1.0)
    low, high = np.quantile(shares, [0.05, 0.95])
    share = float(np.clip(gained_.sum() / before_.sum(), 0.0, 1.0))
    return RegimeShare(share, (float(low), float(high)), float(np.mean(gained_[draws].sum(axis=1) <= 0.0)))


def _features(scene: Scene, regime: str) -> Array:
    """(N, d) smooth functions of a regime."""
    x = scene.link - scene.link.mean(axis=0)
    if regime == "position":
        return np.concatenate([x, x**2, x[:, :-1] * x[:, 1:], np.sin(3.0 * x), np.cos(3.0 * x)], axis=1)
    roles = {"track": Role.CARRIAGE, "table": Role.WORKPIECE}
    if regime in roles:
        role = roles[regime]
        own = [k for k, a in enumerate(scene.axes) if scene.cell.joints[scene.cell.index(a)].role is role]
        return np.concatenate([x[:, own], x[:, own] ** 2, x[:, own] ** 3], axis=1)
    if regime == "force":
        force = scene.force
        return np.zeros((len(scene), 0)) if force is None else force
    if regime == "temperature":
        warm = scene.temperature
        return np.zeros((len(scene), 0)) if warm is None else np.stack([warm, warm**2], axis=1)
    if regime == "load":
        force = scene.force
        return scene.torque if force is None else np.concatenate([scene.torque, force], axis=1)
    if regime == "time":
        t = (scene.t - scene.t[0]) / max(float(np.ptp(scene.t)), 1e-9)
        parts = [t, t**2, t**3]
        if scene.temperature is not None:
            parts.append(scene.temperature)
        return np.stack(parts, axis=1)
    if scene.poses:
        return np.zeros((len(scene), 0))
    if regime == "direction":
        width = deg_to_rad(0.02)
        return np.stack([play(x[:, k], scene.t, scene.pieces, width) for k in range(x.shape[1])], axis=1)
    return scene.velocity(scene.command, 1 if regime == "speed" else 2)
