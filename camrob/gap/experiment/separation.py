"""How far apart two rival explanations would be on a motion that was not run: what one predicts and the other can't mimic."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.design import Panel, make_panel
from camrob.gap.evidence.evidence import Fitted
from camrob.gap.evidence.model import Model, members_of
from camrob.gap.evidence.unknown import UNKNOWN, is_moment
from camrob.gap.experiment.motions import TrialMotion

__all__ = ["Rivals", "Separation", "rivals_of", "separation", "unknown_on"]

Array = NDArray[np.float64]

_LIKELY = 0.02  # a set that is that likely is a rival by itself
_ERRORS = 2.0  # standard errors by which what is unexplained may be less than its shapes as fitted


@dataclass(frozen=True)
class Rivals:
    """Two explanations of the same logs, by the names of what they don't share, each fitted."""

    first: tuple[str, ...]
    second: tuple[str, ...]
    fits: tuple[Fitted, Fitted]


@dataclass(frozen=True, slots=True)
class Separation:
    """What a motion would tell: rms in m at the TCP that the first explanation moves it by and the second can't, whatever its
    values; most, at: m, the largest of it, and where, as a share of the motion; sigmas: the same over all its samples in the
    instrument's noise. answers: m (rms), the gap that each is expected to show there, the noise in it.
    """

    motion: TrialMotion
    rms: float
    sigmas: float
    most: float
    at: float
    answers: tuple[float, float]


def rivals_of(model: Model, claimed: Sequence[str]) -> Rivals | None:
    """The best explanation and the closest other one; None where nothing is explained.

    The other is the likeliest further set, or where there is none of weight, the best in which one other effect stands in
    for the first that is claimed.
    """
    always = model.evidence.always
    names = list(model.sets)
    for other in names[1:3]:
        if model.sets[other] > _LIKELY and "unknown" not in other:
            own = [m for m in model.scores if model.evidence.effects_of(m) == other]
            if own:
                fitted = model.evidence.fit(max(own, key=lambda m: model.scores[m]) | always)
                return _named(model, fitted)
    if not claimed:
        return None
    taken = members_of(model, claimed[0])
    rest = model.best.members - taken
    inside = model.evidence.effects_of(model.best.members)
    fits = []
    for effect in model.effects:
        units = frozenset(i for i, u in enumerate(model.units) if u.effect == effect.name)
        if units and effect.name not in inside and effect.name != "unknown":
            fits.append(model.evidence.fit(rest | units | always))
    return _named(model, max(fits, key=lambda f: f.score)) if fits else None


def _named(model: Model, other: Fitted) -> Rivals | None:
    first, second = (model.evidence.effects_of(f.members) for f in (model.best, other))
    if first == second:
        return None
    return Rivals(tuple(sorted(first - second)), tuple(sorted(second - first)), (model.best, other))


def separation(model: Model, rivals: Rivals, motion: TrialMotion) -> Separation:
    """What a motion would tell two explanations apart by, the second one's values fitted anew to old and new samples."""
    noise = model.noises[0]
    kept = np.ones(len(motion.scene), bool)
    first, second = rivals.fits
    wanted = first.members | second.members
    panel = make_panel(motion.scene, 0, model.units, model.effects, model.states, noise, kept, 10, 0, wanted=wanted)
    free = np.flatnonzero(np.isin(model.design.owner, list(second.members)))
    X, y = _rows(panel, free, first.mean)
    old = model.evidence.design.A.sum(axis=0)[np.ix_(free, free)] / model.evidence.temperature
    wide = model.design.usual[free]
    now = second.mean[free]
    H = (X.T @ X + old) * np.outer(wide, wide) + 1e-9 * np.eye(len(free))
    change = wide * np.linalg.solve(H, wide * (X.T @ (y - X @ now)))
    mimic = second.mean.copy()
    mimic[free] = now + change
    left = y - X @ (now + change)
    apart = panel.moves(first.mean) - panel.moves(np.where(np.isin(np.arange(len(mimic)), free), mimic, 0.0))
    # parameters of what is out of a set are all but 0; they belong to neither prediction
    answers = [_rms_of(panel.moves(_effects_of(model, fitted)), model.noise) for fitted in rivals.fits]
    sizes = np.linalg.norm(apart, axis=1)
    farthest = int(np.argmax(sizes))
    return Separation(
        motion,
        _rms_of(apart),
        float(np.sqrt(left @ left)),
        most=float(sizes[farthest]),
        at=farthest / max(len(sizes) - 1, 1),
        answers=(answers[0], answers[1]),
    )


def _effects_of(model: Model, fitted: Fitted) -> Array:
    """(K,) fitted values of a set's effects, without frames that are not known."""
    return model.values(fitted.members - model.evidence.always, fitted)


def _rms_of(moved: Array, noise: float = 0.0) -> float:
    """m: rms of vectors (N, 3), with that of the noise."""
    return float(np.sqrt(np.mean(np.sum(moved**2, axis=1)) + noise**2))


def unknown_on(model: Model, motion: TrialMotion) -> float:
    """m (rms about the mean) by which what is unexplained surely moves the TCP on a motion: its shapes as fitted, or where it has
    none the discrepancy as it is known there.

    Shapes that a log can't tell apart may all but cancel there and not here: what two standard errors of their values, with their
    covariance, would show by themselves is taken off, in squares. Where one axis moves alone, shapes of the time say nothing of
    that axis, and don't count.
    """
    kept = np.ones(len(motion.scene), bool)
    found = members_of(model, UNKNOWN.name)
    shapes = frozenset(i for i in found if not (motion.axis and _follows_time(model.units[i].key)))
    panel = make_panel(
        motion.scene,
        0,
        model.units,
        model.effects,
        model.states,
        model.noises[0],
        kept,
        10,
        0,
        model.basis,
        wanted=shapes,
    )
    field, sizes = model.evidence.field, model.evidence.sizes
    if not found and field is not None and sizes is not None and panel.smooth is not None:
        moved = panel.smooth @ field.fitted(model.best.mean, sizes)[:, :3]
        return _rms_of(moved - moved.mean(axis=0))
    columns = np.flatnonzero(np.isin(model.design.owner, sorted(shapes)))
    X = panel.moved_by(columns)
    X = X - X.mean(axis=0)
    energy = float(np.sum((X @ model.best.mean[columns]) ** 2))
    doubt = float(np.einsum("nik,kl,nil->", X, model.best.spread.block(columns), X, optimize=True))
    return float(np.sqrt(max(energy - _ERRORS**2 * doubt, 0.0) / len(X)))


def _follows_time(key: str) -> bool:
    """Whether a free form, "place|quantity", goes by the time, or is a step at a moment."""
    quantity = key.partition("|")[2]
    return quantity == "time" or is_moment(quantity)


def _rows(panel: Panel, free: NDArray[np.int64], mean: Array) -> tuple[Array, Array]:
    """Whitened columns of some parameters, and what values (K,) predict, at the TCP and at the drives."""
    w = panel.w_tcp
    X = [(panel.tcp[:, :, free] * w[..., None]).reshape(w.size, len(free))]
    y = [(panel.twists(mean) * w).ravel()]
    if panel.servo is not None and panel.w_servo is not None:
        drives = np.zeros((*panel.servo.shape[:2], len(free)))
        at = {int(k): j for j, k in enumerate(panel.servo_columns)}
        for j, k in enumerate(free):
            if int(k) in at:
                drives[:, :, j] = panel.servo[:, :, at[int(k)]]
        X.append((drives * panel.w_servo[..., None]).reshape(panel.w_servo.size, len(free)))
        y.append((panel.errors(mean) * panel.w_servo).ravel())
    return np.concatenate(X), np.concatenate(y)
