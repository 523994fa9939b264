"""A motor's commutation is off: its torque ripples with the rotor's angle, and the drive with it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter

from camrob.gap.effects.common import moved
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

Array = NDArray[np.float64]

# of a following error: an ordinary ripple, and one beyond which a drive would trip
_USUAL, _MOST = deg_to_rad(0.001), deg_to_rad(0.1)
_LENGTH = mm_to_m(1.0) / deg_to_rad(1.0)  # m of a sliding axis to what is a rad of a turning one
_LOWEST = 2.0  # cycles within the travel
_STEPS = 6.0  # samples a cycle at the least
_HIGHEST = 2000.0  # cycles within the travel
_ROWS = 6000
_PADDED, _BESIDE, _FINE = 4, 151, 21  # of a spectrum: length of its padding, orders beside a peak, steps within one
_CLEAR = 30.0  # times the median of the orders beside it that a peak stands out by
_CHOICES = 50


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Where an axis's error repeats over its angle: an offset of the current, once, or a gain, twice and with the load."""
    if any(s.poses or s.servo_gap is None for s in scenes):
        return ()
    units = []
    for a in scenes[0].axes:
        order = _order(scenes, a) if moved(scenes, a) else None
        if order is None:
            continue
        linear = scenes[0].cell.joints[scenes[0].cell.index(a)].prismatic
        unit, scale = ("mm", _LENGTH) if linear else ("deg", 1.0)
        for kind in ("offset", "gain"):
            parameters = tuple(
                EffectParameter(f"{a}_{kind}_{wave}_{unit}", unit, scale * _USUAL, -scale * _MOST, scale * _MOST)
                for wave in ("cos", "sin")
            )
            units.append(Unit("motor_commutation", a, parameters, _CHOICES, f"{kind} {order:.6f}"))
    return tuple(units)


def _order(scenes: Sequence[Scene], axis: str) -> float | None:
    """Cycles a rad (a m) with which an axis's error repeats, less what follows its motion; None without clear ones."""
    parts = []
    for s in scenes:
        k = s.index(axis)
        if s.servo_gap is None:
            return None
        v, a = (s.velocity(s.command[:, [k]], n)[:, 0] for n in (1, 2))
        X = np.stack([np.ones(len(s)), v, a, np.sign(v)], axis=1)
        y = s.servo_gap[:, k]
        parts.append((s.link[:, k], y - X @ np.linalg.lstsq(X, y, rcond=1e-10)[0]))
    u, y = (np.concatenate(x) for x in zip(*parts, strict=True))
    step = max(1, len(u) // _ROWS)
    u, y = u[::step], y[::step]
    travelled = np.abs(np.diff(u))
    span, near = float(np.ptp(u)), float(np.median(travelled[travelled > 0.0])) if (travelled > 0.0).any() else 0.0
    if near <= 0.0 or span / near < _LOWEST * _STEPS:
        return None
    highest = min(1.0 / (_STEPS * near), _HIGHEST / span)
    width = 1.0 / (_STEPS * highest)
    at = ((u - u.min()) / width).astype(np.int64)
    length = 1 << int(np.ceil(np.log2(_PADDED * (int(at.max()) + 1))))
    orders = np.arange(length // 2 + 1) / (length * width)
    power = np.abs(np.fft.rfft(np.bincount(at, y), length)) ** 2
    used = (orders > _LOWEST / span) & (orders < highest)
    if np.count_nonzero(used) < _BESIDE // 2:
        return None
    # what follows no angle is smooth over orders: a peak stands out from those beside it
    clear = power / np.maximum(median_filter(power, _BESIDE), 1e-300)
    best = int(np.argmax(np.where(used, power * (clear > _CLEAR), 0.0)))
    if not used[best] or clear[best] <= _CLEAR:
        return None
    fine = np.linspace(orders[best - 1], orders[best + 1], _FINE)
    angle = 2.0 * np.pi * np.outer(fine, u)
    return float(fine[int(np.argmax((np.cos(angle) @ y) ** 2 + (np.sin(angle) @ y) ** 2))])


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    kind, _, order = unit.key.partition(" ")
    k = scene.index(unit.axis)
    angle = 2.0 * np.pi * float(order) * scene.link[:, k]
    if kind == "offset":
        return tuple(Column(servo={unit.axis: np.asarray(wave(angle))}) for wave in (np.cos, np.sin))
    load = scene.torque[:, k]
    size = (
        load / max(float(np.abs(load).max(initial=0.0)), 1e-9)
        if float(np.ptp(load)) > 1e-6
        else np.sign(scene.velocity(scene.command[:, [k]])[:, 0])
    )
    return tuple(Column(servo={unit.axis: size * wave(2.0 * angle)}) for wave in (np.cos, np.sin))


EFFECT = Effect(
    name="motor_commutation",
    physics="A motor's torque ripples with its rotor's electrical angle, once or (with the load) twice, and its drive follows.",
    stages=("setpoint_to_encoder",),
    regimes=("position", "load"),
    experiment="turn the axis alone slowly at two loads: ripples keep their place on the axis; a gain's grow with the load",
    units=_units,
    columns=_columns,
    accuracy=0.1,
)
