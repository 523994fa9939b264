"""The instrument's millimetre is not a millimetre."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from camrob.gap.effects.common import PPM
from camrob.gap.effects.effect import Column, Effect, EffectParameter, State, Unit
from camrob.gap.observation.scene import Scene

__all__ = ["EFFECT"]

_USUAL, _MOST, _COMMON = 2e-5, 2e-3, 2e-4  # air and temperature; a wrong scale bar; already much
_CHOICES = 10  # causes for which an instrument is the last to be blamed


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """One scale, as of a laser's wavelength or a scale bar; and how each axis of the frame departs from it, as of cameras."""
    if not all(s.tracked for s in scenes):
        return ()
    one = (EffectParameter("scale", "1", _USUAL, -_MOST, _MOST, _COMMON),)
    own = tuple(EffectParameter(f"{p}_beyond", "1", _USUAL, -_MOST, _MOST, _COMMON) for p in "xy")
    return (
        Unit("measurement_scale", "", one, _CHOICES, "scale"),
        Unit("measurement_scale", "", own, _CHOICES, "axes"),
    )


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    """About the middle of what was measured: where the instrument stands is its frame's affair."""
    away = scene.nominal[:, :3, 3] - scene.nominal[:, :3, 3].mean(axis=0)
    twists = np.zeros((len(scene), 6, 3))
    for k in range(3):
        twists[:, k, k] = away[:, k]
    if unit.key == "scale":
        return (Column(tcp=twists.sum(axis=2)),)
    return tuple(Column(tcp=twists[:, :, k] - twists[:, :, 2]) for k in range(2))


def _accuses(values: Mapping[str, float], alike: Sequence[str], keys: Sequence[str]) -> str:
    if "scale" not in values:
        return ""
    here = f" (here: {', '.join(alike)})" if alike else ""
    return (
        f"its lengths are {PPM * values['scale']:+.0f} ppm off; a track's scale and longer links would look alike{here}"
    )


EFFECT = Effect(
    name="measurement_scale",
    physics="All lengths that the instrument measures are too long by one share, or by a share of each axis of its frame.",
    stages=("encoder_to_tcp",),
    regimes=("position",),
    experiment="measure a calibrated scale bar at both ends of the work space with the instrument alone",
    remedy=(
        "nothing at the robot: check the instrument on a calibrated bar, and its values for air temperature and "
        "pressure"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.01,
    of_instrument=_accuses,
    of_machine=False,
)
