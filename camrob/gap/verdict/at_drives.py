"""Names of the drives where logs hold both ends: what an encoder shows, nothing behind it can be the likeness of, however much
stays there. And which of them these logs can't tell apart, or are any course.

A drive short of voltage falls behind with the square of its speed: so does a delay, less a friction that pushes. Each stands far
out, and all that both leave is noise.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from camrob.gap.effects.effect import Effect
from camrob.gap.evidence.design import Panel
from camrob.gap.evidence.model import Model, effect_rms, members_of
from camrob.gap.evidence.scan import DRIVE
from camrob.gap.evidence.shrink import Shrinkage, Trial, drives_gap
from camrob.gap.evidence.unknown import DEGREE
from camrob.gap.verdict.belief import BELIEF
from camrob.gap.verdict.remains import claims

__all__ = [
    "any_course",
    "at_drives",
    "behind_encoders",
    "behind_motors",
    "misread",
    "moved_at_drives",
    "not_told_apart",
    "shaped_at_drives",
    "stays_at_drives",
    "without_drives_rest",
]

Array = NDArray[np.float64]

_MOST = 0.5  # of what a name does at the drives
_TINY = 1e-12
# times the noise, within which the tool is at the set-points, and from which encoders are not
_AT_SETPOINTS, _FAR_FROM_THEM = 1.2, 10.0
_BENT = 0.01  # of how late encoders are, what their own levers, which are others by then, make of it
_SCALES = (0.5, 1.5)  # times the fitted values, between which a stand-in is tried
_STEADY = frozenset({"speed", "acceleration"})  # regimes of what a delay shows too, its second order with its first


def at_drives(model: Model, library: Sequence[Effect]) -> frozenset[str]:
    """Effects that work between set-point and encoder alone, where every log tells both."""
    both = all(p.servo is not None for p in model.panels)
    return frozenset(e.name for e in library if both and e.stages == ("setpoint_to_encoder",))


def behind_encoders(model: Model) -> frozenset[str]:
    """Effects that work behind the encoders alone, where every log tells both ends of the drives."""
    both = all(p.servo is not None for p in model.panels)
    return frozenset(e.name for e in model.effects if both and e.stages == ("encoder_to_tcp",))


def without_drives_rest(model: Model, trial: Trial) -> Trial:
    """Withheld samples without what lies between set-point and encoder and the best set does not explain, where logs tell it: it
    is read off the log, so that nothing behind the encoders is to be held to it. An axis that stands half a degree beside its
    set-point would else speak against a zero of 0.15 degrees the other way.
    """
    values = model.values(model.best.members, model.best)
    panels = tuple(p if p.y_servo is None else replace(p, y_servo=p.errors(values)) for p in trial.panels)
    return replace(trial, panels=panels)


def misread(model: Model, trial: Trial, together: Shrinkage, drives: Collection[str]) -> frozenset[str]:
    """What explains late encoders, and all that cancels it, where the tool is at the set-points within the noise: then the
    encoders' record is late and not the drives. The instrument's clock would have to trail by just as much.
    """
    claimed = model.evidence.effects_of(model.best.members)
    if not claimed.intersection(drives):
        return frozenset()
    late = max(effect_rms(model, trial.panels, n) for n in claimed.intersection(drives))
    silent = together.rms_before <= float(np.hypot(_AT_SETPOINTS * model.noise, _BENT * late))
    return claimed if silent and late >= _FAR_FROM_THEM * model.noise else frozenset()


def behind_motors(model: Model, names: Collection[str], axes: Collection[str]) -> frozenset[str]:
    """Those of some names of the drives that do most of what they do on axes whose motors follow their set-points."""
    found = []
    for name in model.evidence.effects_of(model.best.members).intersection(names) if axes else ():
        values, own = model.values(members_of(model, name), model.best), np.zeros(len(model.scenes[0].axes))
        for p in model.panels:
            own += np.sum(np.nan_to_num(p.errors(values) * _weights(p)) ** 2, axis=0)
        there = float(sum(own[model.scenes[0].index(a)] for a in axes))
        if there > _MOST * float(own.sum()):
            found.append(name)
    return frozenset(found)


def shaped_at_drives(model: Model) -> bool:
    """Whether the best set holds a shape of the unknown at a drive."""
    units = (model.units[i] for i in model.best.members)
    return any(u.effect == "unknown" and u.key.startswith(DRIVE) for u in units)


def moved_at_drives(model: Model, names: Collection[str]) -> float:
    """How far effects of the best set together move the drives of the fitted logs, carried to the TCP, m (rms)."""
    values = model.values(frozenset(i for i in model.best.members if model.units[i].effect in names), model.best)
    return _rms([p.carried(p.errors(values))[_told(p)] for p in model.panels])


def stays_at_drives(model: Model, withheld: Shrinkage, probability: Mapping[str, float]) -> float:
    """m (rms, carried to the TCP) that the claims leave between set-points and encoders beyond these' noise, on withheld samples
    or on the fitted ones, whichever is more.
    """
    values = model.values(claims(model, probability), model.best)
    fitted = _rms([(drives_gap(p, _told(p)) - p.carried(p.errors(values))[_told(p)]) for p in model.panels])
    noise = _rms([_noise(p) for p in model.panels])
    return float(np.sqrt(max(max(fitted, withheld.rms_after) ** 2 - noise**2, 0.0)))


def _told(panel: Panel) -> NDArray[np.bool_]:
    return np.asarray(panel.w_tcp[:, 0] > 0.0)


def _noise(panel: Panel) -> Array:
    """(M, k) m that the noise of each encoder moves the TCP by."""
    if panel.w_servo is None:
        raise ValueError("a log without set-points or encoders tells no encoder's noise")
    sigma = np.divide(1.0, panel.w_servo, out=np.zeros_like(panel.w_servo), where=panel.w_servo > 0.0)
    one = np.eye(sigma.shape[1])
    sizes = [np.linalg.norm(panel.carried(sigma * axis), axis=1) for axis in one]
    return np.asarray(np.stack(sizes, axis=1)[_told(panel)])


def _rms(parts: Sequence[Array]) -> float:
    return float(np.sqrt(np.mean(np.sum(np.concatenate(parts) ** 2, axis=1))))


def not_told_apart(model: Model, library: Sequence[Effect], claimed: Collection[str]) -> dict[str, list[str]]:
    """Claimed effects, and the one that would leave nearly as little between set-point and encoder in their place, alone or in
    that of all names of the best set that follow speed and acceleration: by fewer squares of what stays, at the temperature,
    than a value has to stand out by to be nearly sure. Of logs that tell both ends.
    """
    found: dict[str, list[str]] = {}
    if any(p.y_servo is None for p in model.panels):
        return found
    inside = model.evidence.effects_of(model.best.members)
    steady = {e.name for e in library if e.name in inside and _STEADY.issuperset(e.regimes)}
    for effect in library:
        if effect.name not in claimed or not effect.stands_in:
            continue
        for replaced in ({effect.name}, steady - {effect.stands_in}):
            if effect.name in replaced and _clearer(model, effect, replaced) < BELIEF.stands_out:
                found |= {name: [effect.stands_in] for name in replaced.intersection(claimed)}
    return found


def _clearer(model: Model, effect: Effect, replaced: Collection[str]) -> float:
    """By how many squares, a value of its own, some effects leave less than the stand-in of one of them does in their place."""
    lag = model.values(members_of(model, effect.name), model.best)
    named = {q.name: float(v) for q, v in zip(model.design.parameters, lag, strict=True) if v != 0.0}
    if not named:
        return np.inf
    # what is left out is a nuisance with values of its own, fitted beside these: it would take the lag's part
    mean = model.values(model.best.members, model.best)
    values = model.values(frozenset(i for i in model.best.members if model.units[i].effect in replaced), model.best)

    def beyond(scale: float) -> float:
        """Squares that are left more so."""
        total = 0.0
        for p in model.panels:
            instead = np.zeros_like(p.errors(values))
            for axis, signal in effect.stand_in(p.scene, model.states[effect.name], named, scale).items():
                instead[:, p.scene.index(axis)] = signal
            total += _more_squares(p, mean, p.errors(values) - instead)
        return total

    least = minimize_scalar(beyond, bounds=_SCALES, method="bounded", options={"xatol": 1e-5}).fun
    return float(least / model.evidence.temperature) / len(named)


def _more_squares(panel: Panel, mean: Array, back: Array) -> float:
    """By how many weighed squares more is left at the drives with `back` (N, k) put back, where that is known."""
    left = _gap_of(panel) - panel.errors(mean)
    return float(np.nansum(((left + back) ** 2 - left**2) * _weights(panel) ** 2))


def any_course(model: Model, names: Collection[str]) -> frozenset[str]:
    """Those of some names of the drives that do most of what they do on axes where they mostly cancel, and where a smooth
    function of the speed in their place leaves more by fewer squares than a name has to stand out by to be nearly sure. Of logs
    that tell both ends.
    """
    asked = sorted(model.evidence.effects_of(model.best.members).intersection(names))
    if len(asked) < 2:
        return frozenset()
    done = {n: [p.errors(model.values(members_of(model, n), model.best)) for p in model.panels] for n in asked}
    whole, there = dict.fromkeys(asked, 0.0), dict.fromkeys(asked, 0.0)
    for k in range(len(model.scenes[0].axes)):
        w = _joined([_weights(p) for p in model.panels], k)
        own = {n: _joined(parts, k) * w for n, parts in done.items()}
        shared = _work_against(list(own.values())) and _smooth_shows(model, k, w, np.sum(list(own.values()), axis=0))
        for n, moved in own.items():
            energy = float(moved @ moved)
            whole[n] += energy
            there[n] += energy if shared else 0.0
    return frozenset(n for n in asked if there[n] > _MOST * whole[n])


def _work_against(parts: Sequence[Array]) -> bool:
    """Whether parts (N,) do far less together than each for itself."""
    both = np.sum(parts, axis=0)
    return sum(float(d @ d) for d in parts) > BELIEF.cancels * float(both @ both)


def _smooth_shows(model: Model, k: int, w: Array, together: Array) -> bool:
    """Whether a smooth function of an axis's speed leaves nearly as little as names do that move its drive by `together` (N,), in
    sigmas, as weights w (N,) say.
    """
    mean = model.values(model.best.members, model.best)
    left = _joined([_gap_of(p) - p.errors(mean) for p in model.panels], k) * w
    speed = _joined([p.scene.speed for p in model.panels], k)
    X = np.polynomial.legendre.legvander(2.0 * (speed - speed.min()) / max(np.ptp(speed), _TINY) - 1.0, DEGREE)
    X, y = X * w[:, None], left + together
    rest = y - X @ np.linalg.lstsq(X, y)[0]
    return float(rest @ rest - left @ left) < BELIEF.stands_out * model.evidence.temperature


def _joined(parts: Sequence[Array], k: int) -> Array:
    """(N,) an axis's column of all logs; 0 where nothing is told."""
    return np.asarray(np.nan_to_num(np.concatenate([p[:, k] for p in parts])))


def _gap_of(panel: Panel) -> Array:
    if panel.y_servo is None:
        raise ValueError("a log without set-points or encoders tells no drive's error")
    return panel.y_servo


def _weights(panel: Panel) -> Array:
    if panel.w_servo is None:
        raise ValueError("a log without set-points or encoders tells no encoder's noise")
    return panel.w_servo
