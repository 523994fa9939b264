"""The instrument moves on its stand while it measures, or its target slips."""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.effects.common import PLACES, place_parameters
from camrob.gap.effects.effect import Column, Effect, State, Unit
from camrob.gap.observation.noise import plain_gap
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.unknown_frames import left_twists, right_twists
from camrob.measurement.log_info import MeasuredFrame
from camrob.summaries.fitted.since import Since
from camrob.units import deg_to_rad, mm_to_m

__all__ = ["APART", "EFFECT", "JUMP", "SLIP", "at_moment", "moment_key"]

APART = "apart "
"""How the key of a unit begins by which the instrument stood elsewhere on one log than on the first."""

JUMP, SLIP = "jump", "slip"
"""What happens at a moment: the instrument, or the robot's foot, is elsewhere from there on; the target, or the tool."""

_SHIFT, _TURN = mm_to_m(0.03), deg_to_rad(0.002)  # over a log
_SLIP, _SLIP_TURN = mm_to_m(0.3), deg_to_rad(0.05)
_ELSEWHERE, _ELSEWHERE_TURN = mm_to_m(1.0), deg_to_rad(0.05)
_CHOICES, _MOMENTS = 20, 100  # causes before which no instrument is blamed; moments at which a target may slip
_SETTLED, _SETTLES_IN = mm_to_m(0.1), 300.0  # m; s, in less than which no stand settles
_SETTLES = (0.3, 0.1, 0.6)  # of a log, in which a stand settles by all but a third of its way
_EDGE = 0.05  # of a log, in which no slip can be told from its end


def _units(scenes: Sequence[Scene], state: State) -> tuple[Unit, ...]:
    """Steadily, or settling, each log from its own beginning; a target that slips at one moment of a log, and where such a moment
    was found (`at_moment`), a frame that jumps; and an instrument that stood elsewhere on a further log, though all say one.
    """
    if not all(s.tracked for s in scenes):
        return ()
    names = [f"drift_{p}" for p in PLACES]
    units = [Unit("measurement_drift", "", place_parameters(names, _SHIFT, _TURN), _CHOICES, "steady")]
    if all(np.ptp(s.t) >= _SETTLES_IN for s in scenes):
        settled = place_parameters([f"settled_{p}" for p in PLACES], _SETTLED, _TURN)
        units.append(Unit("measurement_drift", "", settled, _CHOICES, "settling"))
    for scene in scenes:
        for kind in (SLIP, JUMP):
            moment = _told(state, kind, scene) or (_moment(scene) if kind == SLIP else None)
            if moment is not None:
                moved = place_parameters([f"{kind}_{p}" for p in PLACES], _SLIP, _SLIP_TURN)
                units.append(Unit("measurement_drift", "", moved, _MOMENTS, moment_key(kind, *moment, scene.name)))
    if all(s.log.info.measured_frame is MeasuredFrame.WORLD and not s.log.info.same_frame_as for s in scenes):
        for scene in scenes[1:]:
            moved = place_parameters([f"apart_{p}" for p in PLACES], _ELSEWHERE, _ELSEWHERE_TURN)
            units.append(Unit("measurement_drift", "", moved, _CHOICES, f"{APART}{scene.name}"))
    return tuple(units)


def at_moment(kind: str, at: float, sample: int, name: str, earlier: Collection[str]) -> dict[str, float]:
    """What the state holds of a moment (`JUMP`, `SLIP`): s, and the last sample before it, from 1, of a log; all logs but the
    earlier ones are behind it.
    """
    before = {f"{kind}_before|{log}": 1.0 for log in earlier}
    return {f"{kind}_s|{name}": at, f"{kind}_sample|{name}": float(sample), **before}


def moment_key(kind: str, at: float, sample: int, name: str) -> str:
    """The key of the unit that such a moment has."""
    return f"{kind} {at:.6f} {sample} {name}"


def _told(state: State, kind: str, scene: Scene) -> tuple[float, int] | None:
    key = f"{kind}_s|{scene.name}"
    return (state[key], int(state[f"{kind}_sample|{scene.name}"])) if key in state else None


def _moment(scene: Scene) -> tuple[float, int] | None:
    """Where the mean gap, seen in the tool's axes, changes most from before to after: s, and the number of the last sample before
    it, from 1; None for a short log.
    """
    gap = np.einsum("nij,ni->nj", scene.nominal[:, :3, :3], plain_gap(scene)[:, :3])
    count, edge = len(gap), max(6, int(_EDGE * len(scene)))
    cut = np.arange(edge, count - edge)
    if len(cut) == 0:
        return None
    before = np.cumsum(gap, axis=0)[cut - 1]
    after = gap.sum(axis=0) - before
    apart = np.sum((before / cut[:, None] - after / (count - cut)[:, None]) ** 2, axis=1) * cut * (count - cut)
    first = int(cut[int(np.argmax(apart))])
    return float(0.5 * (scene.t[first - 1] + scene.t[first])), first


def _columns(scene: Scene, unit: Unit, state: State) -> tuple[Column, ...]:
    kind, _, rest = unit.key.partition(" ")
    course: NDArray[np.float64]
    if kind == "steady":
        twists = left_twists(scene.nominal)
        course = (scene.t - scene.t[0]) / max(float(np.ptp(scene.t)), 1e-9)
    elif kind == "settling":
        twists = left_twists(scene.nominal)
        passed = (scene.t - scene.t[0]) / max(float(np.ptp(scene.t)), 1e-9)
        settles = state.get("settles", _SETTLES[0])
        course = np.expm1(-passed / settles) / np.expm1(-1.0 / settles)
    elif unit.key.startswith(APART):
        twists = left_twists(scene.nominal)
        course = np.full(len(scene), float(scene.name == rest))
    else:
        moment, _, name = rest.split(" ", 2)
        twists = (right_twists if kind == SLIP else left_twists)(scene.nominal)
        behind = f"{kind}_s|{name}" in state and f"{kind}_before|{scene.name}" not in state
        own = scene.t >= float(moment) if scene.name == name else np.full(len(scene), behind)
        course = own.astype(float)
    return tuple(Column(tcp=twists[:, :, k] * course[:, None]) for k in range(6))


def _accuses(values: Mapping[str, float], alike: Sequence[str], keys: Sequence[str]) -> str:
    said = []
    for key in sorted(keys):
        kind, _, rest = key.partition(" ")
        part = {"steady": "drift", "settling": "settled"}.get(kind, kind)
        size = float(np.linalg.norm([values.get(f"{part}_{p}_mm", 0.0) for p in PLACES[:3]]))
        how = f"it {'settled' if part == 'settled' else 'moved steadily'}, by {size:.2g} mm over a log"
        if key.startswith(APART):
            how = f"it stood elsewhere on {rest} than on the first log, by {size:.2g} mm"
        elif rest:
            moment, sample, name = rest.split(" ", 2)
            when = f"behind sample {sample} of {name} (t = {float(moment):.6g} s)"
            what = "its target slipped on the tool" if kind == SLIP else "its frame, or the robot's foot, jumped"
            how = f"{what} by {size:.2g} mm {when}"
        said.append(how)
    return "; ".join(said) or "it moved, or its target slipped, while it measured"


def _came(keys: Sequence[str]) -> Since | None:
    """At a moment, or between two logs, where it is nothing else."""
    if len(keys) != 1:
        return None
    if keys[0].startswith(APART):
        return Since(log=keys[0].removeprefix(APART), lasting=False)
    kind, _, rest = keys[0].partition(" ")
    if kind not in (SLIP, JUMP):
        return None
    moment, sample, name = rest.split(" ", 2)
    return Since(log=name, row=int(sample) + 1, t_s=float(moment), lasting=True)


EFFECT = Effect(
    name="measurement_drift",
    physics="The instrument's frame moves steadily, settles, or jumps, or its target slips at one moment.",
    stages=("encoder_to_tcp",),
    regimes=("time",),
    experiment=(
        "look whether the target sits fast on the tool, then measure a fixed nest before, half-way and after the run, the "
        "robot's part left as it is"
    ),
    remedy=(
        "nothing at the robot: fix the instrument's stand, let it warm up, check the seat of its target, and "
        "measure again"
    ),
    units=_units,
    columns=_columns,
    accuracy=0.02,
    trials=tuple({"settles": s} for s in _SETTLES),
    of_instrument=_accuses,
    of_machine=False,
    came=_came,
)
