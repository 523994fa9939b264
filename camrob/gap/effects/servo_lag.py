"""The drives follow their set-points late."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import moved, shows
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import delayed, first_order

__all__ = ["EFFECT"]

_START = 0.02  # s
_LEAST = 1e-4  # s: less is as good as none, and its shape is the speed
_LEAST_DAMPING = 0.25  # of a drive: with less it would ring for several swings
_KEPT = 12  # states of which what was reckoned is kept
_SETTLED = 5.0  # lags after which what was before a run no longer counts
_STEP = 1e-4  # s, of the difference quotient

Array = NDArray[np.float64]


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """One for all drives, and by how much each axis's own differs from it."""
    if any(s.poses or s.setpoint is None for s in scenes):
        return ()
    units = [Unit("servo_lag", "", (EffectParameter("tau_s", "s", 0.04, -0.002, 0.5),))]
    for a in scenes[0].axes if len(scenes[0].axes) > 1 else ():
        if moved(scenes, a) and (shows(scenes, a) or all(s.servo_gap is not None for s in scenes)):
            units.append(Unit("servo_lag", a, (EffectParameter(f"{a}_beyond_s", "s", 0.02, -0.5, 0.5),), key="own"))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    """The same shape for the common part and an axis's own: that of the time constant which is their sum."""
    cycle = state.get("cycle_s", 0.0)
    own = {a: max(state.get("lag_s", _START) + state.get(f"{a}_s", 0.0), _LEAST) + cycle for a in scene.axes}
    split = scene.servo_gap is not None
    late = _late(scene, {a: own[a] for a in ([unit.axis] if unit.axis and split else scene.axes)}, cycle)
    moved = {a: behind for a, behind in late.items() if unit.axis in ("", a)}
    if split:
        return (Column(servo=moved),)
    return (Column(tcp=_carried(scene, moved, {a: own[a] * behind for a, behind in late.items()})),)


def _late(scene: Scene, own: Mapping[str, float], cycle: float) -> Mapping[str, Array]:
    """(N,) by axis, a second of lag: how far each is behind with its own time constant. All units of a state ask for the same."""
    if (key := (cycle, tuple(own.items()))) in scene.reckoned:
        return scene.reckoned[key]
    known = scene.encoder  # where the drives stand at the start of a run is seen
    late: dict[str, Array] = {}
    for tau in sorted(set(own.values())):
        axes = [a for a in own if own[a] == tau]
        k = [scene.index(a) for a in axes]
        start = None if known is None else known[:, k]
        behind = first_order(scene.command[:, k], scene.t, scene.pieces, tau, cycle, start) - scene.command[:, k]
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
    """A drive that acts once a cycle is behind a ramp by its time constant less a cycle."""
    lag = values.get("tau_s", 0.0) - state.get("cycle_s", 0.0)
    kept = {k: v for k, v in state.items() if k in ("lag_s", "cycle_s")}
    beyond = {f"{n.removesuffix('_beyond_s')}_s": v for n, v in values.items() if n.endswith("_beyond_s")}
    return {**kept, **beyond, **({"lag_s": lag} if lag > 0.0 else {})}


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
        lag = values.get("tau_s", 0.0) + values.get(f"{axis}_beyond_s", 0.0) - state.get("cycle_s", 0.0)
        if abs(lag) > _LEAST:
            own = scene.command[:, [k]]
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
    refine=_refine,
    trials=({"cycle_s": 0.0}, {"cycle_s": 0.004}, {"cycle_s": 0.012}),
    accuracy=0.015,
    wider=_wider,
    stand_in=_late_whole,
    stands_in="setpoint_delay",
)
