"""A motor's commutation is off: its torque ripples with the rotor's angle, and the drive with it."""

from __future__ import annotations

from collections.abc import Sequence

from camrob.gap.effects.common import moved
from camrob.gap.effects.commutation_loop import Ripple
from camrob.gap.effects.commutation_search import CHOICES, commutation
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

# of a following error: an ordinary ripple, one that is already a lot, and one beyond which a drive would trip
_USUAL, _MUCH, _MOST = deg_to_rad(0.001), deg_to_rad(0.1), deg_to_rad(1.0)
_LENGTH = mm_to_m(1.0) / deg_to_rad(1.0)  # m of a sliding axis to what is a rad of a turning one
_TIMES = {0.5: "half", 1.0: "once", 2.0: "twice"}  # of the order that stands out


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Where an axis's error repeats over its angle, as its loop passes it on."""
    if any(s.poses or s.servo_gap is None for s in scenes):
        return ()
    units = []
    for a in scenes[0].axes:
        ripple = commutation(scenes, a) if moved(scenes, a) else None
        if ripple is None:
            continue
        linear = scenes[0].cell.joints[scenes[0].cell.index(a)].prismatic
        unit, scale = ("mm", _LENGTH) if linear else ("deg", 1.0)
        parameters = tuple(
            EffectParameter(
                f"{a}_{_TIMES[times]}_{weight}_{wave}_{unit}",
                unit,
                scale * _USUAL,
                -scale * _MOST,
                scale * _MOST,
                scale * _MUCH,
            )
            for times, weight in ripple.parts
            for wave in ("cos", "sin")
        )
        units.append(Unit("motor_commutation", a, parameters, CHOICES, ripple.key))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    """The same whatever the state: reckoned once."""
    key = "commutation", unit.axis, unit.key
    if key not in scene.found:
        ripple = Ripple.of(unit.key)
        scene.found[key] = [part for z in ripple.waves(scene, unit.axis, ripple.parts) for part in (z.real, z.imag)]
    return tuple(Column(servo={unit.axis: part}) for part in scene.found[key])


EFFECT = Effect(
    name="motor_commutation",
    physics="A motor's torque ripples with its electrical angle, once or (by the load) twice; its loop damps and turns that.",
    stages=("setpoint_to_encoder",),
    regimes=("position", "load", "speed"),
    experiment="turn the axis alone slowly at two loads: ripples keep their place on the axis; a gain's grow with the load",
    remedy="have the commutation offset and the current sensors of these drives calibrated",
    units=_units,
    columns=_columns,
    accuracy=0.1,
)
