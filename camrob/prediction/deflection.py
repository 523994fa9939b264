"""The tool's deflection under the cutting force: joints that were found to yield, and what tool and holder give."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.error_model import ErrorModel
from camrob.calibration.terms import TermKind
from camrob.cell.joint import Role
from camrob.gap.fitted_units import FittedUnits
from camrob.gap.observation.scene import Scene

__all__ = ["CAUSE", "Deflection", "deflection", "known_compliance"]

Array = NDArray[np.float64]

CAUSE = "deflection under the cutting force"
_FORCE, _GRAVITY, _BY_AXES = "cutting_force", "joint_compliance", "axes"


@dataclass(frozen=True)
class Deflection:
    """twist: (N, 6) in `base`, m and rad. sensitivity: fitted parameter to the twist (N, 6) that a unit of it adds."""

    twist: Array
    sensitivity: Mapping[int, Array]


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


def deflection(scene: Scene, force: Array, known: Mapping[str, tuple[float, int]], give: Array) -> Deflection:
    """What a force (N, 3) N in `base` on the tip does; scene: the run, seen from `base`. give: (2,) m/N across and along the
    tool.
    """
    twist = np.zeros((len(scene), 6))
    sensitivity: dict[int, Array] = {}
    for joint in scene.cell.joints:
        if joint.role is not Role.ARM or joint.name not in known:
            continue
        value, parameter = known[joint.name]
        arm = scene.place(f"{joint.name}.zero")
        unit = arm * np.einsum("ni,ni->n", arm[:, :3], force)[:, None]
        twist += value * unit
        if parameter >= 0:
            sensitivity[parameter] = unit
    z = np.asarray(scene.nominal)[:, :3, 2]
    axial = np.sum(force * z, axis=1, keepdims=True) * z
    twist[:, :3] += give[0] * (force - axial) + give[1] * axial
    return Deflection(twist, sensitivity)
