"""The drives follow their set-points late."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.following import beyond_bounds, following
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import delayed, first_order

__all__ = ["EFFECT"]

_START = 0.02  # s
_LEAST = 1e-4  # s: less is as good as none, and its shape is the speed
_LEAST_DAMPING = 0.25  # of a drive: with less it would ring for several swings
_KEPT = 12  # states of which what was reckoned is kept
_SETTLED = 5.0  # lags after which what was before a run no longer counts
_STEP = 1e-4  # s, of the difference quotient
_OTHERWISE = 0.05  # of the lag that all have, by which an axis's own is another one

Array = NDArray[np.float64]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """One for all drives, and by how much each axis's own differs from it."""
    if any(s.poses or s.setpoint is None for s in scenes):
        return ()
    units = [Unit("servo_lag", "", (EffectParameter("tau_s", "s", 0.04, -0.002, 0.5),))]
    for a in scenes[0].axes if len(scenes[0].axes) > 1 else ():
        if moved(scenes, a) and (shows(scenes, a) or all(s.servo_gap is not None for s in scenes)):
            cycle = state.get("cycle_s", 0.0)
            lower, upper = (b + s * cycle for b, s in zip(beyond_bounds(scenes, a, 0.5), (-1.0, 1.0), strict=True))
            units.append(Unit("servo_lag", a, (EffectParameter(f"{a}_beyond_s", "s", 0.02, lower, upper),), key="own"))
    return tuple(units)


def _begin(scenes: Sequence[Scene]) -> State:
    """What logs with both ends of the drives say: the lag of most axes, of those that differ their own, and of each how late its
    set-points come to it.
    """
    found = following(scenes)
    common = found.common_lag
    if max((lag + found.delay[a] for a, lag in found.lag.items()), default=0.0) <= _LEAST:
        return {}
    own = {a: lag - common for a, lag in found.lag.items() if lag > _LEAST and abs(lag - common) > _OTHERWISE * common}
    late = {f"{a}_late_s": d for a, d in found.delay.items() if d > 0.0}
    return {"lag_s": max(common, 2.0 * _LEAST), **{f"{a}_s": beyond for a, beyond in own.items()}, **late}


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    """The same shape for the common part and an axis's own: that of the time constant which is their sum."""
    lags = {a: _lag_of(state, a) for a in scene.axes}
    own = {a: lag + _cycle(state, lag) for a, lag in lags.items()}
    split = scene.servo_gap is not None
    asked = {
        a: (own[a], state.get(f"{a}_late_s", 0.0), _cycle(state, lags[a]))
        for a in ([unit.axis] if unit.axis and split else scene.axes)
    }
    late = _late(scene, asked)
    moved = {a: behind for a, behind in late.items() if unit.axis in ("", a)}
    if split:
        return (Column(servo=moved),)
    return (Column(tcp=_carried(scene, moved, {a: own[a] * behind for a, behind in late.items()})),)


def _lag_of(state: State, axis: str) -> float:
    """s by which an axis trails a steady motion, by the state."""
    return max(state.get("lag_s", _START) + state.get(f"{axis}_s", 0.0), _LEAST)


def _cycle(state: State, lag: float) -> float:
    """s of the cycle in which a drive acts that trails by `lag`; 0 for all the time: one that made up for more than half of its
    error in a cycle would be no position loop.
    """
    cycle = state.get("cycle_s", 0.0)
    return cycle if cycle <= lag else 0.0


def _late(scene: Scene, own: Mapping[str, tuple[float, float, float]]) -> Mapping[str, Array]:
    """(N,) by axis, a second of lag: how far each is behind set-points that come to it late, with its own time constant, lateness
    and cycle. All units of a state ask for the same.
    """
    if (key := ("late", *own.items())) in scene.reckoned:
        return scene.reckoned[key]
    known = scene.encoder  # where the drives stand at the start of a run is seen
    late: dict[str, Array] = {}
    for tau, delay, cycle in sorted(set(own.values())):
        axes = [a for a in own if own[a] == (tau, delay, cycle)]
        k = [scene.index(a) for a in axes]
        start = None if known is None else known[:, k]
        asked = scene.command[:, k]
        asked = delayed(asked, scene.t, scene.pieces, delay) if delay else asked
        behind = first_order(asked, scene.t, scene.pieces, tau, cycle, start) - asked
        late |= {a: behind[:, i] / tau for i, a in enumerate(axes)}
    if len(scene.reckoned) >= _KEPT:
        scene.reckoned.clear()
    scene.reckoned[key] = late
    return late


def _carried(scene: Scene, moved: Mapping[str, Array], behind: Mapping[str, Array]) -> Array:
    """(N, 6) twist a second of lag of axes that it moves by (N,) each, with the arm half way between its set-points and where its
    drives stand, (N,) behind: millimetres off, its levers are others than at the set-points.
    """
    step, half = np.zeros_like(scene.link), scene.link.copy()
    for axis, one in behind.items():
        half[:, scene.index(axis)] += 0.5 * one
    for axis, one in moved.items():
        step[:, scene.index(axis)] = one
    return (scene.beyond(half + _STEP * step) - scene.beyond(half - _STEP * step)) / (2.0 * _STEP)


def _refine(state: State, values: Mapping[str, float]) -> dict[str, float]:
    """A drive that acts once a cycle is behind a ramp by its time constant less a cycle. So a value says how far behind it is by
    how far its column is, which holds however far off the time constant was that the column was made with; one less the cycle
    would run away from any lag shorter than it.
    """
    tau, before = values.get("tau_s", 0.0), state.get("lag_s", _START)
    lag = tau * before / (before + _cycle(state, before))
    found = dict(state) | ({"lag_s": lag} if lag > _LEAST else {})
    for name, beyond in values.items():
        if name.endswith("_beyond_s"):
            axis = name.removesuffix("_beyond_s")
            own = _lag_of(state, axis)
            own = (tau + beyond) * own / (own + _cycle(state, own))
            if own > _LEAST:
                found[f"{axis}_s"] = own - found.get("lag_s", before)
    return found


def _wider(scene: Scene, state: State) -> tuple[Column, ...]:
    """A drive of second order, of damping z and natural frequency w, lags by 2 z / w like one of first order, and by 1 / w^2 of
    the acceleration less (the series of 1 / (1 + 2 z s / w + s^2 / w^2), less that of 1 / (1 + tau s), tau = 2 z / w). Where
    encoders show the drives' own error, its part by acceleration is no likeness.
    """
    if scene.servo_gap is not None:
        return ()
    share = (state.get("lag_s", _START) / (2.0 * _LEAST_DAMPING)) ** 2
    acceleration = scene.velocity(scene.command, 2)
    total = np.zeros((len(scene), 6))
    for k, axis in enumerate(scene.axes):
        if f"{axis}.zero" in scene.places:
            total -= scene.shift(axis, share * acceleration[:, k])
    return (Column(tcp=total),)


def _late_whole(scene: Scene, state: State, values: Mapping[str, float], scale: float) -> Mapping[str, Array]:
    """How far each axis would be behind, were its set-points late by so many times its lag and followed at once. At the beginning
    of a run nobody knows what the set-points were before.
    """
    found = {}
    for k, axis in enumerate(scene.axes):
        lag = values.get("tau_s", 0.0) + values.get(f"{axis}_beyond_s", 0.0) - _cycle(state, _lag_of(state, axis))
        if abs(lag) > _LEAST:
            own = scene.command[:, [k]]
            if late := state.get(f"{axis}_late_s", 0.0):
                own = delayed(own, scene.t, scene.pieces, late)
            behind = (delayed(own, scene.t, scene.pieces, scale * lag) - own)[:, 0]
            for run in scene.pieces:
                behind[run][scene.t[run] < scene.t[run][0] + _SETTLED * abs(lag)] = np.nan
            found[axis] = behind
    return found


EFFECT = Effect(
    name="servo_lag",
    physics="Every drive is a first-order filter on its set-points, with nearly one time constant; continuous, or once a cycle.",
    stages=("setpoint_to_encoder",),
    regimes=("speed",),
    experiment="run the path at half speed: what lag causes halves, play and geometry stay",
    remedy="nothing is broken, all axes lag alike: lower the feed where it counts, or have the feed-forward switched on",
    odd_axis="have gain, feed-forward and filters of {axis} compared with those of the other axes",
    units=_units,
    columns=_columns,
    begin=_begin,
    refine=_refine,
    trials=({"cycle_s": 0.0}, {"cycle_s": 0.004}, {"cycle_s": 0.012}),
    accuracy=0.015,
    wider=_wider,
    stand_in=_late_whole,
    stands_in="setpoint_delay",
)
