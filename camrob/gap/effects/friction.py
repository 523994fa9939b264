"""Friction holds the drives back, and most at reversals."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import moved
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.friction_course import CHOICES, Course, friction_course, settled
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.signals import delayed, play
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

Array = NDArray[np.float64]

_PEAK = 0.15  # s for which the drive's integral part needs to overcome a reversal
_TINY = 1e-30
_REST = 0.02  # share of an axis's ordinary speed below which it counts as turning round
_SLOW = tuple(deg_to_rad(v) for v in (0.1, 0.2, 0.35, 0.6, 1.0, 1.8, 3.0))  # speeds of which the same is said
# of the ordinary size: how far above 0 each part may be, and what is already a lot; and how far below (a controller that feeds
# friction forward may do too much of it, and some drives hold less where they are slow, or loaded)
_MOST, _MUCH = 200.0, 40.0
_LOWEST = {"constant": -4.0, "peak": -20.0} | dict.fromkeys(("second_peak", "held", "stribeck", "loaded"), -_MOST)
_TURNED = {"deg": deg_to_rad(0.01), "mm": mm_to_m(0.01)}  # way after which a held axis counts as having turned round


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    if any(s.poses or s.setpoint is None for s in scenes):
        return ()
    cell = scenes[0].cell
    units = []
    for a in scenes[0].axes:
        if not moved(scenes, a) or any(s.servo_gap is None and f"{a}.zero" not in s.places for s in scenes):
            continue
        linear = cell.joints[cell.index(a)].prismatic
        unit, usual = ("mm", mm_to_m(0.02)) if linear else ("deg", deg_to_rad(0.005))
        course = friction_course(scenes, a) if all(s.servo_gap is not None for s in scenes) else None
        parameters = tuple(
            EffectParameter(f"{a}_{k}_{unit}", unit, usual, _LOWEST[k] * usual, _MOST * usual, _MUCH * usual)
            for k in (course.parts if course else ("constant", "peak"))
        )
        units.append(Unit("friction", a, parameters, *((CHOICES, course.key) if course else ())))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    """A drive with an integral part loses the error at rest; one without holds it, until the axis has turned round. Where both
    ends of the drive are logged, its own course was found there.
    """
    if unit.key:
        return _of_course(scene, unit)
    command = scene.command[:, [scene.index(unit.axis)]]
    if state.get("held"):
        side = play(command[:, 0], scene.t, scene.pieces, _TURNED[unit.parameters[0].unit])
        return _of_sign(scene, unit, side[:, None])
    v = scene.velocity(command)
    ordinary = float(np.median(np.abs(v[np.abs(v) > 1e-9]))) if np.any(np.abs(v) > 1e-9) else 1.0
    rest = state.get("rest", 0.0) or _REST * ordinary
    return _of_sign(scene, unit, np.tanh(v / (rest + 1e-12)))


def _of_course(scene: Scene, unit: Unit) -> tuple[Column, ...]:
    """The same whatever the state: reckoned once."""
    key = "friction", unit.axis, unit.key
    if key not in scene.found:
        scene.found[key] = np.ascontiguousarray(-Course.of(unit.key).columns(scene, unit.axis).T)
    return tuple(Column(servo={unit.axis: part}) for part in scene.found[key])


def _of_sign(scene: Scene, unit: Unit, sign: Array) -> tuple[Column, ...]:
    peak = sign - settled(scene, sign, _PEAK)
    return tuple(Column(servo={unit.axis: -part[:, 0]}) for part in (sign, peak))


def _dead_zone(scene: Scene, state: State, values: Mapping[str, float], scale: float) -> Mapping[str, Array]:
    """How the drives would stand, did they rest until their set-points have crossed a zone as wide as what friction keeps them
    back to both sides: so does dry friction in a loop without an integral part, which its error alone has to overcome.
    """
    found = {}
    for axis in scene.axes:
        half = sum(v for n, v in values.items() if n.startswith((f"{axis}_constant", f"{axis}_held")))
        if half > 0.0:
            side = play(_trailed(scene, axis), scene.t, scene.pieces, 2.0 * scale * half)
            found[axis] = -scale * half * side
    return found


def _trailed(scene: Scene, axis: str) -> Array:
    """(N,) an axis's set-points, as late as its drive follows them by its speed."""
    command = scene.command[:, [scene.index(axis)]]
    v, gap = scene.velocity(command)[:, 0], scene.servo_gap
    late = 0.0 if gap is None else -float(v @ gap[:, scene.index(axis)]) / max(float(v @ v), _TINY)
    return np.asarray(delayed(command, scene.t, scene.pieces, late)[:, 0])


EFFECT = Effect(
    name="friction",
    physics="Dry friction keeps a drive behind its set-point on the side it comes from, and peaks where it turns round.",
    stages=("setpoint_to_encoder",),
    regimes=("direction", "speed"),
    experiment=(
        "run the axis alone both ways, at 10 % and at 50 % of its speed, with the motor's current logged: friction holds it back "
        "by as much at both, and the current climbs before it turns round, which it does not in a dead zone; a lag grows with "
        "the speed"
    ),
    remedy=(
        "have brake, grease and bearings of these axes looked at, then the drive's integral gain; keep axes from "
        "turning round or creeping where it matters"
    ),
    units=_units,
    columns=_columns,
    trials=(*({"rest": v, "held": 0.0} for v in (0.0, *_SLOW)), {"held": 1.0}),
    accuracy=0.1,
    at_reversals=True,
    stand_in=_dead_zone,
    stands_in="dead_zone",
)
