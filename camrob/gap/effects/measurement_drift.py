"""The instrument moves on its stand while it measures, or its target slips."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import PLACES, place_parameters
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.unknown_frames import left_twists, right_twists
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["EFFECT"]

_SHIFT, _TURN = mm_to_m(0.03), deg_to_rad(0.002)  # over a log
_SLIP, _SLIP_TURN = mm_to_m(0.3), deg_to_rad(0.05)
_CHOICES, _MOMENTS = 20, 100  # causes before which no instrument is blamed; moments at which a target may slip
_EDGE = 0.05  # of a log, in which no slip can be told from its end


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Steadily over all logs' common clock, each log from its own beginning; and a target that slips at one moment of a log."""
    if not all(s.tracked for s in scenes):
        return ()
    names = [f"drift_{p}" for p in PLACES]
    units = [Unit("measurement_drift", "", place_parameters(names, _SHIFT, _TURN), _CHOICES, "steady")]
    for scene in scenes:
        moment = _moment(scene)
        if moment is not None:
            slipped = place_parameters([f"slip_{p}" for p in PLACES], _SLIP, _SLIP_TURN)
            units.append(Unit("measurement_drift", "", slipped, _MOMENTS, f"slip {moment:.6f} {scene.name}"))
    return tuple(units)


def _moment(scene: Scene) -> float | None:
    """s: where the mean gap, seen in the tool's axes, changes most from before to after; None for a short log."""
    gap = np.einsum("nij,ni->nj", scene.nominal[:, :3, :3], scene.tcp_gap[:, :3])
    count, edge = len(gap), max(6, int(_EDGE * len(scene)))
    cut = np.arange(edge, count - edge)
    if len(cut) == 0:
        return None
    before = np.cumsum(gap, axis=0)[cut - 1]
    after = gap.sum(axis=0) - before
    apart = np.sum((before / cut[:, None] - after / (count - cut)[:, None]) ** 2, axis=1) * cut * (count - cut)
    first = int(cut[int(np.argmax(apart))])
    return float(0.5 * (scene.t[first - 1] + scene.t[first]))


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    kind, _, rest = unit.key.partition(" ")
    course: NDArray[np.float64]
    if kind == "steady":
        twists = left_twists(scene.nominal)
        course = (scene.t - scene.t[0]) / max(float(np.ptp(scene.t)), 1e-9)
    else:
        moment, _, name = rest.partition(" ")
        twists = right_twists(scene.nominal)
        course = ((scene.t >= float(moment)) & (scene.name == name)).astype(float)
    return tuple(Column(tcp=twists[:, :, k] * course[:, None]) for k in range(6))


def _accuses(values: Mapping[str, float], alike: Sequence[str]) -> str:
    return "it moved, or its target slipped, while it measured"


EFFECT = Effect(
    name="measurement_drift",
    physics="The instrument's frame moves steadily while it measures, or its target slips on the tool at one moment.",
    stages=("encoder_to_tcp",),
    regimes=("time",),
    experiment="measure a fixed nest before, half-way and after the run, the robot's part left as it is",
    remedy=(
        "nothing at the robot: fix the instrument's stand, let it warm up, check the seat of its target, and "
        "measure again"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.02,
    of_instrument=_accuses,
    of_machine=False,
)
