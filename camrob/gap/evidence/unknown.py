"""What the library doesn't know, as smooth functions of one quantity, steps at a moment, constants, or what gives way under load:
generic, so never a cause, only a place and a shape.

Each kind in which the library describes anything has such a free form, as broad as the library's own: where a cause is not in the
library, its form is, and no name of another kind has to stand for it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.cell.joint import Role
from camrob.gap.effects.common import (
    ANGLE,
    LENGTH,
    PLACES,
    arm_axes,
    constant,
    place_parameters,
    reach_moments,
    tool_mass,
    under_even_kilogram,
    under_flange_kilogram,
    under_force,
    under_kilogram,
)
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.effects.robot_size import ordinary_compliance, rated_payload
from camrob.gap.observation.scene import Scene
from camrob.units import deg_to_rad, mm_to_m

__all__ = [
    "CONSTANT",
    "DEGREE",
    "FORCE",
    "LAST_MOVE",
    "LINK",
    "LOAD",
    "UNKNOWN",
    "basis",
    "followed",
    "forms_of",
    "is_broad",
    "is_moment",
    "moment_of",
    "moment_words",
    "parts_of",
    "quantities",
    "target_columns",
    "targets",
]

Array = NDArray[np.float64]

DEGREE = 5  # of a shape: bends three times, and no more
CONSTANT = "constant"
"""The quantity's name where there is none: a place that is elsewhere or turned, always alike."""
LAST_MOVE = "last move of"
"""How the quantity's name begins that is the way of an axis from the pose before."""
_FROM = "from "  # how what begins at a moment is said
LINK = "link "
"""How the place's name begins that is an axis standing elsewhere in the link before it, its zero apart."""
LOAD = "load"
"""The quantity's name where it is gravity, on all axes at once."""
FORCE = "force"
"""The quantity's name where it is the force on the tool, on all axes at once."""
_ARM, _AXES, _CARRIED, _FOOT, _TIP = "arm", "axes", "tool's load", "foot", "tip"  # places of several axes
_TABLE = "table "  # how the place's name begins that is a table's axis standing elsewhere
# what is ordinary: of an axis's compliance; rad/m; of the rated payload; m/N
_FOOT_GIVES, _BY_REACH, _SHARE, _TIP_GIVES = 0.05, 1e-4, 0.33, 1e-6
_LINK_PARTS = ("x", "y", "rx", "ry")  # what lies along the axis is the next one's, or the tool's
_LINK_LENGTH, _LINK_ANGLE = mm_to_m(0.3), deg_to_rad(0.02)  # as castings and bearings are off
_CHOICES = 150  # places and quantities that could have been picked
_STILL = 1e-6  # in its own unit: does not change


def quantities(scene: Scene) -> dict[str, Array]:
    """(N,) each: what the gap may depend on, by name."""
    found: dict[str, Array] = {}
    for k, axis in enumerate(scene.axes):
        found[f"{axis}"] = scene.link[:, k]
        if not scene.poses:
            found[f"speed of {axis}"] = scene.speed[:, k]
            found[f"acceleration of {axis}"] = scene.acceleration[:, k]
        found[f"direction of {axis}"] = scene.sides[:, k]
        if scene.poses:
            found[f"{LAST_MOVE} {axis}"] = np.diff(scene.link[:, k], prepend=scene.link[0, k])
        found[f"torque on {axis}"] = scene.torque[:, k]
    found["time"] = scene.t
    if scene.temperature is not None:
        found["temperature"] = scene.temperature
    force = scene.force
    if force is not None:
        for k, part in enumerate("xyz"):
            found[f"force {part}"] = force[:, k]
    return {name: v for name, v in found.items() if float(np.ptp(v)) > _STILL}


def moment_of(scene: Scene) -> str:
    """The quantity's name where what moves is elsewhere from one moment of a log on; the moment is where its range begins."""
    return f"{_FROM}a moment of {scene.name} on"


def is_moment(quantity: str) -> bool:
    """Whether a quantity, or what a shape follows, is such a moment."""
    return quantity.startswith(_FROM)


def moment_words(quantity: str, at: float) -> str:
    """A moment's quantity, with the moment, s."""
    return quantity.replace("a moment", f"{at:.6g} s", 1)


def followed(scene: Scene, quantity: str, absent: float) -> Array:
    """(N,) a quantity on a log; `absent` all along where it doesn't change there (an axis at rest, no force, another log's
    moment).
    """
    given = {moment_of(scene): scene.t} if is_moment(quantity) else quantities(scene)
    return given.get(quantity, np.full(len(scene), absent))


def basis(values: Array, lower: float, upper: float, name: str) -> Array:
    """(N, d) Legendre polynomials 1 .. DEGREE of a quantity over its range; the first alone for a direction. Beyond the range,
    where nothing is known, they stay as they are at its end. Of a moment, a step behind it.
    """
    if is_moment(name):
        return np.asarray(values > lower, float)[:, None]
    x = 2.0 * (values - lower) / max(upper - lower, 1e-12) - 1.0
    degree = 1 if name.startswith("direction") else DEGREE
    return np.asarray(np.polynomial.legendre.legvander(np.clip(x, -1.0, 1.0), degree)[:, 1:])


def targets(scene: Scene) -> tuple[str, ...]:
    """Where the unknown may sit: behind an axis's encoder, at its drive, or in the robot's foot."""
    behind = tuple(a for a in scene.axes if f"{a}.zero" in scene.places)
    drives = tuple(f"drive {a}" for a in scene.axes) if scene.servo_gap is not None else ()
    return (*behind, *drives, "foot x", "foot y", "foot z")


def _constants(scene: Scene) -> tuple[str, ...]:
    """Places that may be elsewhere by what no effect knows: the robot's foot, the tool, an axis's zero, an axis in its link."""
    foot = () if scene.frames.fitted_left else ("foot",)
    tool = () if scene.frames.fitted_right else ("tool",)
    seen = [a for a in arm_axes(scene.cell) if f"{a}.zero" in scene.places]
    work = (j.name for j in scene.cell.joints if j.role is Role.WORKPIECE)
    tables = [f"{_TABLE}{name}" for name in work if f"{name}.x" in scene.places]
    return (*foot, *tool, *seen, *(f"{LINK}{a}" for a in seen), *([_ARM] if seen else []), *tables)


def _loads(scene: Scene) -> tuple[str, ...]:
    """What may give way, each part in its own proportion, as "place|quantity": the axes under their own torques, the axes under
    what the tool weighs more than believed, the robot's foot; the axes, and the tip, under the force on the tool. Where the cell
    says no masses, the axes are bent by a kilogram spread over the links, and by one on the mounting plate.
    """
    weight = tuple(f"{place}|{LOAD}" for place in (_AXES, _CARRIED, _FOOT))
    return weight if scene.force is None else (*weight, *(f"{place}|{FORCE}" for place in (_AXES, _TIP)))


def forms_of(scene: Scene) -> tuple[str, ...]:
    """All free forms without a quantity of one axis, as "place|quantity": constants, and what gives way."""
    return (*(f"{place}|{CONSTANT}" for place in _constants(scene)), *_loads(scene))


def is_broad(form: str) -> bool:
    """Whether a free form, "place|quantity", is as broad as an effect of the library."""
    place, _, quantity = form.partition("|")
    return quantity in (LOAD, FORCE) or place == _ARM


def parts_of(form: str, scene: Scene) -> tuple[str, ...]:
    """Of a broad form, the axis that each of its columns belongs to, or the place ("tool") that it is as a whole."""
    place, _, quantity = form.partition("|")
    if quantity == CONSTANT:
        return tuple(t.partition(".")[0] for t in _terms(place, scene))
    axes = arm_axes(scene.cell)
    # where nobody knows what the links weigh, a kilogram on the plate stands for them too
    carried = ("tool",) * len(axes) if scene.cell.masses else axes
    return {_AXES: axes, _CARRIED: carried, _TIP: ("tool",) * 3}.get(place, (_FOOT,) * 4)


def _terms(place: str, scene: Scene) -> list[str]:
    if place == _ARM:
        links = [f"{a}.{p}" for a in arm_axes(scene.cell) if f"{a}.x" in scene.places for p in _LINK_PARTS]
        return [*links, *(f"tool.{p}" for p in PLACES[:5])]
    if place.startswith(_TABLE):
        return [f"{place.removeprefix(_TABLE)}.{p}" for p in _LINK_PARTS]
    if place.startswith(LINK):
        return [f"{place.removeprefix(LINK)}.{p}" for p in _LINK_PARTS]
    side = {"foot": "base", "tool": "tool"}.get(place)
    return [f"{place}.zero"] if side is None else [f"{side}.{p}" for p in PLACES]


def target_columns(scene: Scene, target: str, shape: Array) -> tuple[Column, ...]:
    """Columns of a target that moves as `shape` (N, d)."""
    kind, _, part = target.rpartition(" ")
    if kind == "drive":
        return tuple(Column(servo={part: shape[:, k]}) for k in range(shape.shape[1]))
    if kind == "foot":
        return tuple(Column(tcp=scene.place(f"root.{part}") * shape[:, k : k + 1]) for k in range(shape.shape[1]))
    return tuple(Column(tcp=scene.shift(part, shape[:, k])) for k in range(shape.shape[1]))


def _of_constant(scene: Scene, form: str, share: float) -> Unit:
    place = form.partition("|")[0]
    axis = "" if place in ("foot", "tool", _ARM) else place.removeprefix(LINK).removeprefix(_TABLE)
    parts = [t.replace(".", "_").replace("zero", "rz") for t in _terms(place, scene)]
    length, angle = (_LINK_LENGTH, _LINK_ANGLE) if place.startswith((LINK, _ARM)) else (LENGTH, ANGLE)
    parameters = place_parameters([f"{place}_{p}" for p in parts], share * length, share * angle)
    return Unit("unknown", axis, parameters, len(_constants(scene)), form)


def _of_load(scene: Scene, form: str, share: float) -> Unit:
    place, _, quantity = form.partition("|")
    usual, own = ordinary_compliance(scene.cell), [f"{a} of {place} by {quantity}" for a in arm_axes(scene.cell)]
    if place == _FOOT:
        sizes = {f"foot about {p}": _FOOT_GIVES * usual for p in "xy"} | {f"foot by reach {p}": _BY_REACH for p in "xy"}
    elif place == _TIP:
        sizes = {f"tip along {p}": _TIP_GIVES for p in "xyz"}
    else:
        # by the kilogram, where the cell says no masses
        share = _SHARE if place == _CARRIED else 1.0
        by_kilogram = place == _CARRIED or (quantity == LOAD and not scene.cell.masses)
        sizes = dict.fromkeys(own, usual * share * (rated_payload(scene.cell) if by_kilogram else 1.0))
    parameters = tuple(EffectParameter(n, "rad", share * size, -np.inf, np.inf) for n, size in sizes.items())
    return Unit("unknown", "", parameters, len(_loads(scene)), form)


def _giving_way(scene: Scene, form: str) -> tuple[Column, ...]:
    place, _, quantity = form.partition("|")
    if quantity == FORCE:
        axes, tip = under_force(scene)
        return tip if place == _TIP else axes
    if place == _CARRIED:
        known = scene.cell.masses
        return (
            under_kilogram(scene, np.asarray(tool_mass(scene.cell).center)) if known else under_flange_kilogram(scene)
        )
    if place == _AXES and not scene.cell.masses:
        return under_even_kilogram(scene)
    if place == _AXES:
        return tuple(Column(tcp=scene.shift(a, scene.torque[:, scene.index(a)])) for a in arm_axes(scene.cell))
    moments = np.concatenate([scene.moments.sum(axis=0), reach_moments(scene)], axis=1)
    return tuple(Column(tcp=scene.place(f"root.r{'xy'[k % 2]}") * moments[:, k : k + 1]) for k in range(4))


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """`state` holds, by "target|quantity|lower" and "...|upper", the pairs that a scan has found and their ranges; of constants
    and of what gives way under load, the upper one is the share of what is ordinary that they are taken to be.
    """
    units = []
    for key in sorted(k.removesuffix("|lower") for k in state if k.endswith("|lower")):
        target, _, quantity = key.partition("|")
        if quantity in (CONSTANT, LOAD, FORCE):
            if all(key in forms_of(s) for s in scenes):
                form = _of_constant if quantity == CONSTANT else _of_load
                units.append(form(scenes[0], key, state[f"{key}|upper"]))
            continue
        step = is_moment(quantity)
        if not all(target in targets(s) and (step or quantity in quantities(s)) for s in scenes):
            continue
        count = 1 if step or quantity.startswith("direction") else DEGREE
        part = target.rpartition(" ")[2]
        linear = target.startswith("foot") or scenes[0].cell.joints[scenes[0].cell.index(part)].prismatic
        unit, usual = ("mm", mm_to_m(0.2)) if linear else ("deg", deg_to_rad(0.03))
        parameters = tuple(
            EffectParameter(f"{target} by {quantity} {n}", unit, usual, -np.inf, np.inf) for n in range(count + 1)
        )
        units.append(Unit("unknown", part if not target.startswith("foot") else "", parameters, _CHOICES, key))
    return tuple(units)


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    target, _, quantity = unit.key.partition("|")
    if quantity in (LOAD, FORCE):
        # a log without force says nothing of what gives way to it
        return _giving_way(scene, unit.key) or tuple(Column() for _ in unit.parameters)
    if quantity == CONSTANT:
        return constant(scene, _terms(target, scene))
    lower, upper = state[f"{unit.key}|lower"], state[f"{unit.key}|upper"]
    # where the quantity doesn't change, its shape stays at its beginning
    shape = basis(followed(scene, quantity, lower), lower, upper, quantity)
    # the constant belongs to the shape: no zero of an axis is to be blamed for it
    return target_columns(scene, target, np.concatenate([np.ones((len(scene), 1)), shape], axis=1))


UNKNOWN = Effect(
    name="unknown",
    physics="Something that the library has no physics for: a smooth function of one quantity, a step, or a constant.",
    stages=("setpoint_to_encoder", "encoder_to_tcp"),
    regimes=(),
    experiment="move the named axis alone through its range, everything else at rest, and measure",
    units=_units,
    columns=_columns,
    accuracy=0.05,
)
