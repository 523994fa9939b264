"""Logs with few decimals: in what steps axes and positions are written, and how much that alone leaves at the tool."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from camrob.gap.observation.scene import Scene
from camrob.measurement.log import POSITION
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["rounding_of", "rounding_of_drives"]

Array = NDArray[np.float64]

_DECIMALS = (0, 1, 2)  # with more, rounding is lost in any instrument's noise
_FEWEST = 10  # rows that all end alike: fewer may by chance
_WHOLE = 1e-6  # of a step: nearer to a multiple is one


def rounding_of(scene: Scene) -> list[tuple[str, float]]:
    """In words which values of a log are written in coarse steps, and the m (rms) that these leave at the tool: a step over the
    square root of 12 an axis, carried there; [] where all have more decimals, or moved in whole steps themselves.
    """
    found = []
    own = "" if scene.encoder is not None else "c"
    steps = {
        a: _step(np.asarray(scene.log.columns[f"{own}{a}"])) for a in scene.axes if f"{own}{a}" in scene.log.columns
    }
    coarse = {a: s for a, s in steps.items() if s > 0.0 and f"{a}.zero" in scene.places}
    if coarse:
        linear = {a: scene.cell.joints[scene.cell.index(a)].prismatic for a in coarse}
        total = 0.0
        for a, step in coarse.items():
            lever = float(np.sqrt(np.mean(np.sum(scene.places[f"{a}.zero"][:, :3] ** 2, axis=1))))
            total += (lever * (mm_to_m(step) if linear[a] else deg_to_rad(step))) ** 2 / 12.0
        most = max(coarse, key=lambda a: coarse[a])
        unit = "mm" if linear[most] else "degrees"
        found.append((f"its axis values stand in steps of {coarse[most]:g} {unit}", float(np.sqrt(total))))
    place = [_step(np.asarray(scene.log.columns[n])) for n in POSITION if n in scene.log.columns]
    if place and min(place) > 0.0:
        found.append(
            (
                f"its x, y, z stand in steps of {max(place):g} mm",
                mm_to_m(float(np.sqrt(sum(s**2 for s in place) / 12.0))),
            )
        )
    return found


def rounding_of_drives(scene: Scene) -> Array:
    """(k,) rad or m: what coarse steps of set-points and encoders alone leave (1 sigma) between them, by axis; 0 where all have
    more decimals.
    """
    out = np.zeros(len(scene.axes))
    for k, axis in enumerate(scene.axes):
        steps = [_step(np.asarray(scene.log.columns[n])) for n in (axis, f"c{axis}") if n in scene.log.columns]
        sliding = scene.cell.joints[scene.cell.index(axis)].prismatic
        size = float(np.sqrt(sum(s**2 for s in steps) / 12.0))
        out[k] = mm_to_m(size) if sliding else deg_to_rad(size)
    return out


def _step(values: Array) -> float:
    """The step, in its own unit, of which all values are multiples; 0 where they have more decimals, are few, or hardly move."""
    known = values[np.isfinite(values)]
    for decimals in _DECIMALS if len(np.unique(known)) >= _FEWEST else ():
        steps = known * 10.0**decimals
        if float(np.abs(steps - np.round(steps)).max()) < _WHOLE * 10.0**decimals:
            return float(10.0**-decimals)
    return 0.0
