"""The run that shows what is unexplained alone: which axes, in which order, how far, how fast, and what to look for."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from camrob.gap.evidence.unknown import is_moment
from camrob.gap.observation.scene import Scene
from camrob.summaries.diagnosis_summary import Unknown

__all__ = ["axes_alone", "looks_like", "moving", "run_for_unknown"]

_STILL = 1e-3  # rad or m: an axis that the run moved by less can't be asked by moving it through its range
_NAMED = 4  # axes that are named one by one
_SPEEDS = "at 10 % and at 50 % of its speed"
_LOOKS = {
    "position": "the same deviation at the same place of the axis, both ways and at both speeds",
    "direction": "a step where the axis turns round, as large at both speeds",
    "speed": "a deviation that grows with the speed and changes its sign on the way back",
    "acceleration": "a deviation at the starts and stops alone, larger at the higher speed",
    "load": "the same deviation both ways and at both speeds, and more of it with another 5 kg at the tool",
    "temperature": "a deviation that is another one after an hour of running",
    "time": "a deviation that differs from one pass to the next",
}
_ANY = "a deviation: the same both ways (place or load), another one on the way back (play, friction), or more at speed (drive)"
_RUNS = {
    "load": "run the same program without and with 5 kg more at the tool: what follows the load grows, all else stays",
    "direction": "run the same program backwards: what follows the direction changes its sign, all else stays",
    "speed": "run the same program at half speed: what follows the speed halves, all else stays",
    "acceleration": "run the same program at half speed: what follows the acceleration falls to a quarter, all else stays",
    "temperature": "run the same program every ten minutes from cold for an hour: what the warmth does grows from run to run",
    "force": "run the same program in air: what the cutting force does is gone, all else stays",
}
_AT_REST = (
    "ask what went on around the cell meanwhile (a crane, a press, the sun on the stand). Then hold the arm at rest in one "
    "posture for 20 minutes from cold, one target on the tool and one on the foot: if both readings wander it is the instrument "
    "or its stand, if only the tool's does it is the arm"
)
_AGAIN = "run the same program from cold and again after an hour: what follows the time differs, all else stays"
_POSES = (
    "measure ten of the poses twice, the second time coming from the other side: what differs is scatter or play, what comes "
    "back is neither. Then "
)


_BY_HAND = (
    "pull at the tool by hand, a dial gauge between it and the plate, and look at the bolts of plate, tool changer and what it "
    "holds: what gives is loose. Then "
)
_BOTH_SIDES = (
    "measure five of the poses again from both sides, at once and after five seconds of rest: what the wait takes away was read "
    "too early, what the side changes is play or wind-up. Then "
)
_ONE_POSE = (
    "drive to one pose ten times and measure it each time: if that scatters by {size} too, it is the instrument or its target, "
    "and nothing in the arm is to be looked for. Then "
)
_ONE_PLACE = (
    "hold the arm at rest in one posture for a minute and log it: if that scatters by {size} too, it is the instrument or its "
    "target, and nothing in the arm is to be looked for. Then "
)
_BEFORE_AND_AFTER = (
    "drive {axis} to one and the same pose before, half-way through and after the run, and look whether it stands there: if it "
    "is off by more each time, its encoder loses counts (cable, coupling, brake); if it comes back, it is warmth. Then "
)


_SLIPPED = (
    "drive {axis} to its marks and look whether they still meet, and at its clamp, coupling and belt: off at once {since}, "
    "it slipped or was hit then. Then "
)


def _at_once(unknown: Unknown, axes: Sequence[str], scene: Scene) -> str:
    """What takes minutes and opens nothing, ahead of the long runs; "" for nothing."""
    regimes = unknown.where.regimes
    follows = regimes[0] if regimes else ""
    if follows == "load":
        return _BY_HAND
    moment = next((s.follows for s in unknown.shapes[:1] if is_moment(s.follows)), "")
    if moment and axes:
        return _SLIPPED.format(axis=axes[0], since=moment)
    if follows == "time" and axes:
        return _BEFORE_AND_AFTER.format(axis=axes[0])
    if scene.poses and follows == "direction":
        return _BOTH_SIDES
    if scene.tracked and not axes and not follows:
        return (_ONE_POSE if scene.poses else _ONE_PLACE).format(size=f"{unknown.rms_mm:.2g} mm")
    return _POSES if scene.poses else ""


def run_for_unknown(unknown: Unknown, suspects: Sequence[str], order: Sequence[str], scene: Scene) -> str:
    """What to do and run for what stays unexplained, by what it follows, and what to look for: what takes minutes first.

    suspects: axes at which it sits or that it follows; order: all axes, those whose shift explains most of it first.
    """
    regimes = unknown.where.regimes
    follows = regimes[0] if regimes else ""
    axes = moving(scene, suspects)
    if not axes and follows == "time":
        return _AT_REST if scene.tracked else _AGAIN
    if not axes and follows in _RUNS and not scene.poses:
        return (_BY_HAND if follows == "load" else "") + _RUNS[follows]
    return _at_once(unknown, axes, scene) + axes_alone(scene, axes or moving(scene, order), looks_like(unknown))


def axes_alone(scene: Scene, axes: Sequence[str], looks: str) -> str:
    """Axes alone, one after the other, through the range that the run used."""
    values = scene.cell.to_axis_values(scene.postures(np.asarray(scene.command)))
    ranges: list[str] = []
    for axis in axes[:_NAMED]:
        at = scene.cell.axis_names.index(axis)
        unit = "mm" if scene.cell.joints[scene.cell.index(axis)].prismatic else "degrees"
        low, high = (f"{v:.0f}".replace("-", "−") for v in (values[:, at].min(), values[:, at].max()))
        how = "" if ranges else "alone through its range "
        ranges.append(f"{axis} {how}({low} to {high} {unit})")
    rest = ", then the other axes" if len(axes) > _NAMED else ""
    what = "" if scene.tracked else ", set-points, encoders and motor currents logged"
    return f"run {', then '.join(ranges)}{rest}, both ways, {_SPEEDS}, the others at rest{what}; look for {looks}"


def looks_like(unknown: Unknown) -> str:
    """What a person sees of it where an axis moves alone, in words."""
    back, regimes = unknown.where.comes_back, unknown.where.regimes
    if back and regimes[:1] != ("time",):
        return f"a wave that comes back {back}, at the same places both ways and at both speeds"
    return _LOOKS.get(regimes[0], _ANY) if regimes else _ANY


def moving(scene: Scene, axes: Sequence[str]) -> list[str]:
    """Those of some axes that the run moved."""
    return [a for a in axes if np.ptp(np.asarray(scene.command)[:, scene.index(a)]) > _STILL]
