"""The tool's deflection under the cutting force: joints that were found to yield, and what tool and holder give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.calibration.terms import TermKind
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.gap.effects.robot_size import COMPLIANCE_RATIO, compliances_beside, ordinary_compliance
from camrob.gap.fitted_units import FittedUnits
from camrob.gap.observation.scene import Scene

__all__ = ["CAUSE", "GRANTED", "Deflection", "Granted", "deflection", "granted_compliance", "known_compliance"]

Array = NDArray[np.float64]

CAUSE = "deflection under the cutting force"
GRANTED = 1.0 / 3.0**0.5
"""Standard deviation of a compliance that nobody measured, of itself: anything from none to twice as much is as likely."""
# the same, of all axes together: gears of an arm's size give half or twice what is ordinary
_ORDINARY = float(np.log(2.0))
_SHOWN = 2.0  # standard errors from which a compliance is told from none
_FORCE, _GRAVITY, _BY_AXES = "cutting_force", "joint_compliance", "axes"


class Granted(NamedTuple):
    """Compliances that nobody measured. by_axis: rad/Nm, each with a doubt of `GRANTED` of itself; alike: the share of themselves
    by which all of them may be wrong together.
    """

    by_axis: Mapping[str, float]
    alike: float


@dataclass(frozen=True)
class Deflection:
    """twist: (N, 6) in `base`, m and rad. sensitivity: fitted parameter to the twist (N, 6) that a unit of it adds; granted:
    (N, 6, G), twists of a standard deviation in G independent directions of compliances that nobody measured.
    """

    twist: Array
    sensitivity: Mapping[int, Array]
    granted: Array


def known_compliance(found: FittedUnits | None, model: ErrorModel, constants: Array) -> dict[str, tuple[float, int]]:
    """Axis to its compliance, rad/Nm, and the number of the fitted parameter that it is (-1: the calibration's constant).

    Compliance that was fitted to a logged force goes before that which was fitted to gravity; where several descriptions of the
    same axis were found, their sum is what yields.
    """
    known: dict[str, tuple[float, int]] = {}
    for term, value in zip(model.terms, constants, strict=True):
        if term.kind is TermKind.COMPLIANCE:
            known[model.cell.joints[term.joint].name] = (float(value), -1)
    if found is None:
        return known
    for wanted in (_GRAVITY, _FORCE):
        for k, own in enumerate(found.owner.tolist()):
            unit = found.units[own]
            if unit.effect == wanted and (wanted == _GRAVITY or unit.key == _BY_AXES):
                first = found.owner.tolist().index(own)
                axis = unit.axis or unit.parameters[k - first].name.partition("_")[0]
                known[axis] = (float(found.values[k]), k)
    return known


def granted_compliance(
    cell: Cell, known: Mapping[str, tuple[float, int]], found: FittedUnits | None, *, assumed: bool = True
) -> Granted:
    """The arm's axes whose compliance nobody has found, or can't tell from none, and what they are taken to have: what such axes
    have beside those that were found, and where none was, what is ordinary for an arm of its size. Gravity does not load A1 of an
    arm that stands upright, and the wrist's axes hardly: under the arm's own weight their compliance never shows, and yet no gear
    is stiff. Nothing is granted to arms of which no ratio between their axes is known.

    assumed: what is only ordinary counts, too.
    """
    names = cell.names[cell.arm_slice]
    shown = {a: c for a, (c, k) in known.items() if k < 0 or found is None or c > _SHOWN * np.sqrt(found.cov[k, k])}
    values = np.array([shown.get(name, 0.0) for name in names])
    measured = bool((values > 0.0).any())
    if len(names) != len(COMPLIANCE_RATIO) or not (measured or assumed):
        return Granted({}, 0.0)
    beside = compliances_beside(values, 0.0 if measured else ordinary_compliance(cell))
    by_axis = {name: float(c) for name, c in zip(names, beside, strict=True) if name not in shown}
    return Granted(by_axis, 0.0 if measured else _ORDINARY)


def deflection(
    scene: Scene, force: Array, known: Mapping[str, tuple[float, int]], granted: Granted, give: Array
) -> Deflection:
    """What a force (N, 3) N in `base` on the tip does; scene: the run, seen from `base`. known, granted: compliances of axes as
    found, and as taken for granted; give: (2,) m/N across and along the tool.
    """
    twist = np.zeros((len(scene), 6))
    taken: list[Array] = []
    sensitivity: dict[int, Array] = {}
    for joint in scene.cell.joints:
        if joint.role is not Role.ARM or not (joint.name in known or joint.name in granted.by_axis):
            continue
        value, parameter = (granted.by_axis[joint.name], -1) if joint.name in granted.by_axis else known[joint.name]
        arm = scene.place(f"{joint.name}.zero")
        unit = arm * np.einsum("ni,ni->n", arm[:, :3], force)[:, None]
        twist += value * unit
        if parameter >= 0:
            sensitivity[parameter] = unit
        if joint.name in granted.by_axis:
            taken.append(value * unit)
    z = np.asarray(scene.nominal)[:, :3, 2]
    axial = np.sum(force * z, axis=1, keepdims=True) * z
    twist[:, :3] += give[0] * (force - axial) + give[1] * axial
    doubts = [GRANTED * one for one in taken]
    if granted.alike:
        doubts.append(granted.alike * np.sum(taken, axis=0))
    return Deflection(twist, sensitivity, np.stack(doubts, axis=2) if doubts else np.zeros((len(scene), 6, 0)))
