"""Looking through what is left for shapes: gear orders axis by axis, and smooth functions of any quantity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import LEVER, Panel
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.unknown import (
    LINK,
    UNKNOWN,
    basis,
    followed,
    forms_of,
    is_broad,
    moment_of,
    quantities,
    targets,
)
from camrob.gap.nuisances import NUISANCE

__all__ = ["DRIVE", "Shape", "covered", "gear_orders", "shapes", "uncovered_forms"]

Array = NDArray[np.float64]

_HIGHEST_ORDER = 400.0  # cycles a turn of the axis: two a turn of its motor, behind a gear of 200
_CYCLES = 1.2  # an order is only one where the axis passes as many of its cycles
_RIDGE = 1e-9
_SMALL_UNIT, _COVERED = 3, 0.95  # columns that a unit has at most, and the share of a shape's energy that it shows
_SAME = 0.9999  # share of the energy of a constant from which it is another's
_SMALLEST = 0.01  # share of the ordinary sizes that a broad form may be offered with
_SPANNED = 600  # samples of a log that tell what columns can show
_RIGID = 6  # columns of a place that is elsewhere and turned
_EDGE = 8  # samples at either end of a log in which a step is no step
DRIVE = "drive "
"""How targets at the drives begin."""
_FORCE = "force"  # a regime, and the first word of a quantity
_ROUNDED = 1e-12  # of the weights: a cosine that varies by less is a constant, but for rounding
_NEARLY = 0.99  # of that gain: what is reckoned for all at once may be off by rounding
_GAIN = 40.0  # chi-square gained, a unit of temperature, for a shape to be worth a try


@dataclass(frozen=True, slots=True)
class Shape:
    """A target that follows a quantity: chi-square gained, the quantity's range, and how far it moves, (N,) of all panels."""

    target: str
    quantity: str
    gain: float
    fit: Array
    lower: float
    upper: float


def _behind(panel: Panel, residual: Array, term: str) -> tuple[Array, Array]:
    """(N,) the shift along a constant error's twist that explains the residual best, and its weight."""
    J = panel.scene.places[term] * panel.w_tcp
    weight = np.sum(J**2, axis=1)
    value = np.sum(J * residual * panel.w_tcp, axis=1) / np.maximum(weight, 1e-30)
    return value, weight


def gear_orders(
    panels: Sequence[Panel], residuals: Sequence[Array], temperature: float, share: float = 0.0
) -> dict[str, float]:
    """Axis to the order of the ripple that explains most, for axes where one explains clearly and a share of all.

    residuals: (N, 6) a panel. A periodogram over the axis's angle, then a finer one about its peak.
    """
    found: dict[str, tuple[float, float]] = {}
    cell = panels[0].scene.cell
    for axis in panels[0].scene.axes:
        if cell.joints[cell.index(axis)].prismatic or any(f"{axis}.zero" not in p.scene.places for p in panels):
            continue
        parts = [_behind(p, r, f"{axis}.zero") for p, r in zip(panels, residuals, strict=True)]
        z, w = np.concatenate([a for a, _ in parts]), np.concatenate([b for _, b in parts])
        angle = np.concatenate([p.scene.link[:, p.scene.index(axis)] for p in panels])
        span = float(np.ptp(angle))
        if span < 0.05:
            continue
        step = float(np.median(np.abs(np.diff(angle)))) + 1e-9
        highest = min(_HIGHEST_ORDER, 0.7 * np.pi / step)
        lowest = max(1.0, _CYCLES * 2.0 * np.pi / span)
        if highest <= lowest:
            continue
        thin = slice(None, None, max(1, len(z) // 4000))
        best = _coarse_peak(z, w, angle, lowest, highest)
        fine = np.linspace(best - 0.4 * np.pi / span, best + 0.4 * np.pi / span, 41)
        best, gain = _peak(fine, z[thin], w[thin] * max(1, len(z) // 4000), angle[thin])
        spread = float(np.sum(w * (z - np.sum(w * z) / max(float(w.sum()), 1e-300)) ** 2))
        if gain > max(_GAIN * temperature, share * spread):
            found[f"{axis}_order"] = (gain, best)
    top = sorted(found.items(), key=lambda item: -item[1][0])[:3]
    return {key: order for key, (gain, order) in top if gain > 0.02 * top[0][1][0]}


def _coarse_peak(z: Array, w: Array, angle: Array, lowest: float, highest: float) -> float:
    """The order of the highest peak of a periodogram over binned angles."""
    width = np.pi / (4.0 * highest)
    at = ((angle - angle.min()) / width).astype(np.int64)
    bins = int(at.max()) + 1
    weight = np.bincount(at, w, bins)
    value = np.bincount(at, w * (z - np.sum(w * z) / w.sum()), bins)
    length = 1 << int(np.ceil(np.log2(4 * bins)))
    first, second = np.fft.rfft(value, length), np.fft.rfft(weight, length)
    orders = 2.0 * np.pi * np.arange(len(first)) / (length * width)
    use = np.flatnonzero((orders >= lowest) & (orders <= highest))
    double = np.abs(second[np.minimum(2 * use, len(second) - 1)])
    power = np.abs(first[use]) ** 2 / np.maximum(weight.sum() - double, 0.02 * weight.sum())
    return float(orders[use[int(np.argmax(power))]]) if len(use) else lowest


def _peak(orders: Array, z: Array, w: Array, angle: Array) -> tuple[float, float]:
    """Of evenly spaced orders the one whose cosine and sine, beside a constant, explain most of z, and the chi-square that they
    gain.
    """
    total = w.sum()
    wz = w * (z - np.sum(w * z) / total)
    turn = np.exp(1j * orders[0] * angle)
    step = np.exp(1j * (orders[1] - orders[0]) * angle)  # from each to the next
    sums = np.empty((len(orders), 3), np.complex128)  # of the turns, of their squares, and with z
    for row in sums:
        weighed = turn * w
        row[:] = weighed.sum(), weighed @ turn, turn @ wz
        turn *= step
    c, s = sums[:, 0].real, sums[:, 0].imag
    cc, ss = 0.5 * (total + sums[:, 1].real) - c**2 / total, 0.5 * (total - sums[:, 1].real) - s**2 / total
    cs = 0.5 * sums[:, 1].imag - c * s / total
    bc, bs = sums[:, 2].real, sums[:, 2].imag
    det = np.maximum(cc * ss - cs**2, 1e-12 * cc * ss + 1e-300)
    gain = (bc**2 * ss - 2.0 * bc * bs * cs + bs**2 * cc) / det
    shows = (np.minimum(cc, ss) > _ROUNDED * total) & (det >= 2e-3 * cc * ss)
    gain = np.where(shows, gain, 0.0)
    k = int(np.argmax(gain))
    return float(orders[k]), float(gain[k])


def shapes(
    panels: Sequence[Panel],
    residuals: Sequence[Array],
    servo: Sequence[Array | None],
    temperature: float,
    least: float,
    most: int,
) -> list[Shape]:
    """Smooth functions of one quantity, and steps at one moment, that explain clearly what is left and move the TCP by `least` m
    (rms), the best first: of each drive, whose error is in the log, its best alone, of what lies behind the encoders `most`.
    """
    given = [quantities(p.scene) for p in panels]
    names = [n for n in given[0] if all(n in g for g in given)]
    lower = {n: min(float(g[n].min()) for g in given) for n in names}
    upper = {n: max(float(g[n].max()) for g in given) for n in names}
    bases = {
        n: np.ascontiguousarray(np.concatenate([basis(g[n], lower[n], upper[n], n) for g in given]).T) for n in names
    }
    rows = {t: r for t in targets(panels[0].scene) if (r := _of_target(panels, residuals, servo, t)) is not None}
    gains = _gains(list(bases.values()), list(rows.values())) if rows else np.zeros((0, len(names)))
    tried = []
    for (target, (z, w)), own in zip(rows.items(), gains, strict=True):
        tried += [
            (gain, target, (n, bases[n], lower[n], upper[n])) for n, gain in zip(names, own.tolist(), strict=True)
        ]
        tried += [(_gain(step[1], z, w)[0], target, step) for step in _steps(panels, z, w)]
    found: list[Shape] = []
    for about, target, (name, X, low, high) in sorted(tried, key=lambda t: -t[0]):
        if about <= _NEARLY * _GAIN * temperature:
            break
        others = [s.target == target if target.startswith(DRIVE) else not s.target.startswith(DRIVE) for s in found]
        if sum(others) >= (1 if target.startswith(DRIVE) else most):
            continue
        gain, coefficients = _gain(X, *rows[target])
        fit = _fit(X, rows[target][1], coefficients)
        lever = np.concatenate([_lever(p, _term_of(target)) for p in panels])
        if gain > _GAIN * temperature and np.sqrt(np.mean((fit * lever) ** 2)) > least:
            found.append(Shape(target, name, gain, fit, low, high))
    return found


def _term_of(target: str) -> str:
    """The constant error that moves as a target does."""
    kind, _, part = target.rpartition(" ")
    return f"root.{part}" if kind == "foot" else f"{part}.zero"


def _of_target(
    panels: Sequence[Panel], residuals: Sequence[Array], servo: Sequence[Array | None], target: str
) -> tuple[Array, Array] | None:
    """What is left of a target, (N,) of all panels, and its weights; None where some panel doesn't tell it."""
    kind, _, part = target.rpartition(" ")
    if kind == "drive":
        rows = [
            (s[:, p.scene.index(part)], p.w_servo[:, p.scene.index(part)] ** 2)
            for p, s in zip(panels, servo, strict=True)
            if s is not None and p.w_servo is not None
        ]
    else:
        rows = [_behind(p, r, _term_of(target)) for p, r in zip(panels, residuals, strict=True)]
    if len(rows) < len(panels):
        return None
    return np.concatenate([a for a, _ in rows]), np.concatenate([b for _, b in rows])


def _gains(bases: Sequence[Array], rows: Sequence[tuple[Array, Array]]) -> Array:
    """(T, Q) chi-square that each of some functions (d, N) explains of each z (N,), of weights w (N,), as `_gain` says, from
    products that are summed for all of them at once: but for rounding where a function hardly changes.
    """
    Z, W = (np.stack(x) for x in zip(*rows, strict=True))
    total = np.maximum(W.sum(axis=1), 1e-300)
    Z = Z - (np.sum(W * Z, axis=1) / total)[:, None]
    out = []
    for X in bases:
        d = len(X)
        upper = np.triu_indices(d)
        sums = W @ np.concatenate([X, X[upper[0]] * X[upper[1]]]).T
        means, A = sums[:, :d] / total[:, None], np.empty((len(W), d, d))
        A[:, upper[0], upper[1]] = A[:, upper[1], upper[0]] = sums[:, d:]
        A -= means[:, :, None] * means[:, None, :] * total[:, None, None]
        b = (W * Z) @ X.T
        scale = np.sqrt(np.maximum(np.einsum("tii->ti", A), _ROUNDED * total[:, None] + 1e-300))
        solved = np.linalg.solve(
            A / (scale[:, :, None] * scale[:, None, :]) + _RIDGE * np.eye(d), (b / scale)[..., None]
        )
        out.append(np.sum(solved[..., 0] * b / scale, axis=1))
    return np.array(out).T


def _steps(panels: Sequence[Panel], z: Array, w: Array) -> list[tuple[str, Array, float, float]]:
    """Of each log the step that explains most of z (N,), of weights w (N,), beside a constant: the quantity, the step (1, N), and
    the moment twice, as its range.
    """
    found, first, total = [], 0, max(float(w.sum()), 1e-300)
    weight, pull = (np.cumsum(x[::-1])[::-1] for x in (w, w * (z - float(w @ z) / total)))  # from each sample on
    for p in panels:
        cut = np.arange(first + _EDGE, first + len(p.scene) - _EDGE)
        first += len(p.scene)
        if len(cut) == 0:
            continue
        end = (weight[first], pull[first]) if first < len(z) else (0.0, 0.0)
        own, pulled = weight[cut] - end[0], pull[cut] - end[1]
        gain = pulled**2 / np.maximum(own * (1.0 - own / total), 1e-300)
        at = int(cut[int(np.argmax(np.where(own > 0.0, gain, 0.0)))]) - first
        moment, name = float(0.5 * (p.scene.t[at - 1] + p.scene.t[at])), moment_of(p.scene)
        step = np.concatenate([basis(followed(q.scene, name, moment), moment, moment, name) for q in panels])
        found.append((name, np.ascontiguousarray(step.T), moment, moment))
    return found


def covered(found: Sequence[Shape], model: Model) -> list[bool]:
    """Of each shape, whether the library has nearly the same, so that it is nothing unknown: one small unit, or all that an
    effect has on the axes that the shape names.
    """
    design, total = model.design, np.zeros(len(found))
    B = np.zeros((len(design.owner), len(found)))
    ends = np.cumsum([len(p.scene) for p in model.panels])[:-1]
    for k, p in enumerate(model.panels):
        weighed = np.zeros((6 * len(p.scene), len(found)))
        for j, shape in enumerate(found):
            fit, (kind, _, part) = np.split(shape.fit, ends)[k], shape.target.rpartition(" ")
            if kind != "drive":
                y = ((p.scene.place(_term_of(shape.target)) * fit[:, None]) * p.w_tcp).T.ravel()
                weighed[:, j] = y * p.w_tcp.T.ravel()
            elif p.servo is None or p.w_servo is None:
                y = np.full(1, np.inf)
            else:
                axis = p.scene.index(part)
                y = fit * p.w_servo[:, axis]
                B[p.servo_columns, j] += p.servo[:, axis].T @ (y * p.w_servo[:, axis])
            total[j] += float(y @ y)
        if weighed.any():
            B += p.apart @ weighed
    named = {
        i: np.flatnonzero(design.owner == i)
        for i, u in enumerate(design.units)
        if u.effect not in (NUISANCE, UNKNOWN.name)
    }
    A, shown = design.A.sum(axis=0), np.zeros(len(found), np.bool_)
    for c in named.values():
        if len(c) <= _SMALL_UNIT:
            shown |= _shown(A, c, B) > _COVERED * total
    return [
        bool(s) or _by_effect(model, shape, named, A, b, t)
        for s, shape, b, t in zip(shown, found, B.T, total, strict=True)
    ]


def _by_effect(
    model: Model, shape: Shape, named: Mapping[int, NDArray[np.int64]], A: Array, b: Array, total: float
) -> bool:
    """Whether all that some effect has on the axes that a shape names shows the shape, of products b (K,) and energy `total`."""
    pushed = {e.name for e in model.effects if _FORCE in e.regimes}
    axes = {shape.target.rpartition(" ")[2], *shape.quantity.split()}
    sets: dict[str, list[int]] = {}
    for i, c in named.items():
        unit = model.design.units[i]
        if unit.axis in axes or (unit.effect in pushed and _FORCE in axes):
            sets.setdefault(unit.effect, []).extend(c.tolist())
    return any(_shown(A, np.array(c), b[:, None])[0] > _COVERED * total for c in sets.values())


def uncovered_forms(model: Model) -> dict[str, float]:
    """Free forms whose pattern the library lacks, which one of its names would otherwise mimic, and the share of their ordinary
    sizes that they are offered with.

    Of a place that is elsewhere, no unit as small as such a place shows it; of an axis in its link, no unit at all; of what is as
    broad as an effect, all axes elsewhere in their links or what gives way under load, no whole effect. These are as large as the
    gap at the most, as an effect's own priors are fitted to what it does.
    """
    design, scenes = model.design, [p.scene for p in model.panels]
    rows = [np.arange(len(s))[:: max(1, len(s) // _SPANNED)] for s in scenes]
    weighed = [
        np.take(p.tcp.transpose(2, 1, 0), at, axis=2) * p.w_tcp[at].T for p, at in zip(model.panels, rows, strict=True)
    ]
    X = np.concatenate([w.reshape(len(w), -1) for w in weighed], axis=1)
    A = X @ X.T
    apart = {NUISANCE, UNKNOWN.name, *(e.name for e in model.effects if e.orders)}
    named = {i: u.effect for i, u in enumerate(design.units) if u.effect not in apart}
    known = [np.flatnonzero(design.owner == i) for i in named]
    small = [c for c in known if len(c) <= _RIGID]
    whole = [np.flatnonzero(np.isin(design.owner, [i for i in named if named[i] == n])) for n in {*named.values()}]
    found = {}
    for form in (f for f in forms_of(scenes[0]) if all(f in forms_of(s) for s in scenes)):
        state = {f"{form}|lower": 0.0, f"{form}|upper": 1.0}
        unit = UNKNOWN.units(scenes, state)[0]
        twists = [
            np.stack([c.tcp[at] for c in UNKNOWN.columns(p.scene, unit, state) if c.tcp is not None])
            for p, at in zip(model.panels, rows, strict=True)
        ]
        Y = np.concatenate(
            [
                (t * p.w_tcp[at]).swapaxes(1, 2).reshape(len(t), -1)
                for t, p, at in zip(twists, model.panels, rows, strict=True)
            ],
            axis=1,
        )
        B, G = X @ Y.T, np.sum(Y**2, axis=1)
        usual = np.array([q.usual for q in unit.parameters])
        moved = sum(np.sum(t[:, :, :3] ** 2, axis=(1, 2)) for t in twists) / sum(len(at) for at in rows)
        # gravity has no torque on an upright axis, but for rounding, and little on a wrist's last one
        shown = G * usual**2 > (1.0 - _SAME) * np.max(G * usual**2)
        sets = whole if is_broad(form) else known if form.startswith(LINK) else small
        if shown.any() and not any(np.all(_shown(A, c, B[:, shown]) > _SAME * G[shown]) for c in sets):
            size = float(np.sqrt(np.sum(moved * usual**2)))
            found[form] = float(np.clip(model.gap / max(size, 1e-12), _SMALLEST, 1.0)) if is_broad(form) else 1.0
    return found


def _shown(A: Array, columns: NDArray[np.int64], B: Array) -> Array:
    """(d,) energy that some columns, with the Gram matrix A (K, K) of all, can show of patterns with products B (K, d)."""
    scale = np.sqrt(np.maximum(np.diag(A)[columns], 1e-300))
    G = A[np.ix_(columns, columns)] / np.outer(scale, scale) + _RIDGE * np.eye(len(columns))
    right = B[columns] / scale[:, None]
    return np.asarray(np.sum(right * np.linalg.solve(G, right), axis=0))


def _lever(panel: Panel, term: str) -> Array:
    """(N,) m by which the TCP moves for a unit of a constant error, turns counted at `LEVER`; 0 where it doesn't show."""
    if term not in panel.scene.places:
        return np.zeros(len(panel.scene))
    J = panel.scene.places[term]
    return np.asarray(np.sqrt(np.maximum(np.sum(J[:, :3] ** 2, axis=1), LEVER**2 * np.sum(J[:, 3:] ** 2, axis=1))))


def _gain(X: Array, z: Array, w: Array) -> tuple[float, Array]:
    """Chi-square that functions X (d, N) explain of z (N,), of weights w (N,), beyond a constant, and their coefficients (d,)."""
    total = w.sum()
    if total <= 0.0:
        return 0.0, np.zeros(len(X))
    # less their means first: products of what hardly changes would be but rounding
    Z = X - ((X @ w) / total)[:, None]
    weighed = Z * w
    A, b = weighed @ Z.T, weighed @ (z - float(w @ z) / total)
    scale = np.sqrt(np.maximum(np.diag(A), 1e-300))
    solved = np.linalg.solve(A / np.outer(scale, scale) + _RIDGE * np.eye(len(b)), b / scale)
    return float(solved @ (b / scale)), solved / scale


def _fit(X: Array, w: Array, coefficients: Array) -> Array:
    """(N,) of functions X (d, N) with some coefficients, beyond their mean by weights w (N,)."""
    return np.asarray(coefficients @ X - float(coefficients @ (X @ w)) / float(w.sum()))
