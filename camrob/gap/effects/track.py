"""The linear track: its scale, its direction, its straightness over the travel that the logs pass; an arm's own slides: scale."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.cell.joint import Role
from camrob.gap.effects.common import moved
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.rail_joints import CHOICES, SHIFTS, TURNS, piece, rail_joints
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

# powers of the place on the track that the carriage turns with; a constant about x and y is the foot's, not the track's
_POWERS = {"x": (1, 2), "y": (1, 2), "z": (0, 1, 2)}
_PARTS = {"beyond": SHIFTS, "turned": TURNS}  # kinds of units of a rail in pieces, and what they move
# of a long rail, m: the shortest wave that points of alignment a metre apart leave, and how many half waves at the most
_SHORTEST, _HALF_WAVES, _LONG = 0.9, 8, 4
_WAVE, _ROLL = mm_to_m(0.1), deg_to_rad(0.01)  # as rails are aligned, from point to point
_COURSES = {
    "waves": ("", _WAVE, "mm"),
    "rolls": ("r", _ROLL, "deg"),
}  # kinds of units of a long rail, and what they move
_SLOPE, _MOST = 2e-4, 20.0  # m a m, as rails are laid; times the ordinary size that no rail has


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    cell = scenes[0].cell
    units = [Unit("track", a, (_scale(a),), key="scale") for a in _stages(scenes)]
    for joint in cell.joints:
        if joint.role is not Role.CARRIAGE or not joint.prismatic or not moved(scenes, joint.name):
            continue
        tilt, bow, yaw = deg_to_rad(0.02), mm_to_m(0.2), deg_to_rad(0.02)
        lean = [EffectParameter(f"{joint.name}_r{p}_deg", "deg", tilt, -0.01, 0.01) for p in "xy"]
        bows = [
            EffectParameter(f"{joint.name}_bow{k}_{p}_mm", "mm", bow, -0.005, 0.005, beside=k == 0)
            for k in range(4)
            for p in "xyz"
        ]
        travel = np.concatenate([s.link[:, s.index(joint.name)] for s in scenes])
        middle, half = 0.5 * float(travel.max() + travel.min()), 0.5 * float(np.ptp(travel))
        units.append(Unit("track", joint.name, (_scale(joint.name),), key="scale"))
        units.append(Unit("track", joint.name, tuple(lean), key="direction"))
        units.append(Unit("track", joint.name, tuple(bows), key=f"straightness {middle:.6f} {half:.6f}"))
        for p in "xyz":
            turns = tuple(
                EffectParameter(f"{joint.name}_turn{k}_{p}_deg", "deg", yaw, -0.01, 0.01, beside=k == 0)
                for k in _POWERS[p]
            )
            units.append(Unit("track", joint.name, turns, key=f"turning {middle:.6f} {half:.6f} {p}"))
        units += _courses(joint.name, float(travel.min()), float(travel.max()))
        units += _pieces(scenes, joint.name)
    return tuple(units)


def _stages(scenes: Sequence[Scene]) -> list[str]:
    """Sliding axes of the arm itself, a lift's or a gantry's: how they lie is the geometry's, what their screws count is not."""
    slides = [j.name for j in scenes[0].cell.joints if j.role is Role.ARM and j.prismatic]
    return [a for a in slides if moved(scenes, a)]


def _scale(axis: str) -> EffectParameter:
    return EffectParameter(f"{axis}_scale", "1", 2e-4, -4e-3, 4e-3)


def _courses(axis: str, first: float, last: float) -> list[Unit]:
    """Of a rail that is long beside the way from one point that it was aligned at to the next: shifts and turns in half waves."""
    count = min(int(2.0 * (last - first) / _SHORTEST), _HALF_WAVES)
    if count < _LONG:
        return []
    units = []
    for kind, (turns, size, unit) in _COURSES.items():
        parameters = tuple(
            EffectParameter(
                f"{axis}_{kind}{k}_{turns}{p}_{unit}", unit, size, -_MOST * size, _MOST * size, beside=k == 0
            )
            for k in range(count + 1)
            for p in "xyz"
        )
        units.append(Unit("track", axis, parameters, key=f"{kind} {first:.6f} {last:.6f} {count}"))
    return units


def _pieces(scenes: Sequence[Scene], axis: str) -> list[Unit]:
    """Of a rail laid in pieces, what lies beyond each joint: off and sloping, or turned."""
    if any(s.poses or not s.tracked for s in scenes):
        return []
    step, slope, turn = mm_to_m(0.1), _SLOPE, deg_to_rad(0.01)
    units = []
    for k, joint in enumerate(rail_joints(scenes, axis)):
        shifts = [
            parameter
            for p in SHIFTS
            for parameter in (
                EffectParameter(f"{axis}_joint{k + 1}_{p}_mm", "mm", step, -_MOST * step, _MOST * step),
                EffectParameter(f"{axis}_joint{k + 1}_slope_{p}", "1", slope, -_MOST * slope, _MOST * slope),
            )
        ]
        turns = [
            EffectParameter(f"{axis}_joint{k + 1}_{p}_deg", "deg", turn, -_MOST * turn, _MOST * turn) for p in TURNS
        ]
        units.append(Unit("track", axis, tuple(shifts), CHOICES, f"beyond {joint:.6f}"))
        units.append(Unit("track", axis, tuple(turns), CHOICES, f"turned {joint:.6f}"))
    return units


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    u = scene.link[:, scene.index(unit.axis)]
    if unit.key == "scale":
        return (Column(tcp=scene.shift(unit.axis, u)),)
    if unit.key == "direction":
        return tuple(Column(tcp=scene.place(f"{unit.axis}.r{p}")) for p in "xy")
    kind, middle, *rest = unit.key.split()
    if kind in _PARTS:
        beyond = piece(scene, unit.axis, float(middle), _PARTS[kind])
        return tuple(Column(tcp=beyond[:, :, k]) for k in range(beyond.shape[2]))
    if kind in _COURSES:
        last, count = rest
        s = np.clip((u - float(middle)) / (float(last) - float(middle)), 0.0, 1.0)
        turns = _COURSES[kind][0]
        waves = [np.cos(np.pi * k * s) for k in range(int(count) + 1)]
        return tuple(Column(tcp=scene.place(f"root.{turns}{p}") * w[:, None]) for w in waves for p in "xyz")
    half, *about = rest
    s = (u - float(middle)) / float(half)
    if kind == "straightness":
        # straight where the track stood as the cell was measured, wherever that was: so with a shift and a slope
        shapes = [s**k for k in range(4)]
        return tuple(Column(tcp=scene.place(f"root.{p}") * w[:, None]) for w in shapes for p in "xyz")
    return tuple(Column(tcp=scene.place(f"root.r{about[0]}") * (s**k)[:, None]) for k in _POWERS[about[0]])


def _terms(unit: Unit, state: State) -> tuple[str, ...]:
    """Scale and direction; straightness and turning are no constant of the chain."""
    named = {"scale": (f"{unit.axis}.scale",), "direction": tuple(f"{unit.axis}.r{p}" for p in "xy")}
    return named.get(unit.key, ())


EFFECT = Effect(
    name="track",
    physics="The track's rack, or a slide's screw, is longer or shorter than it counts; a track is bent, or points elsewhere.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="drive the track alone from end to end and back, the arm's axes at rest",
    remedy=(
        "survey the rail (bolts, joints of the rack, level); where its scale is off, enter that on the controller; what "
        "stays straight and steady is corrected in the program"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.02,
    terms=_terms,
)
