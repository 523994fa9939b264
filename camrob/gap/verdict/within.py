"""Whether a gap is none: every logged stage within its noise, or within what the log's user cares about, and which of the two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.shrink import Shrinkage
from camrob.gap.observation.scene import Scene
from camrob.gap.observation.two_encoders import motors_follow
from camrob.kinematics.frames import base_T_tool
from camrob.summaries.diagnosis_places import StageWithin
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["BEYOND", "Stage", "drives_beyond", "drives_on_work", "stages_within", "tolerance_of"]

Array = NDArray[np.float64]

BEYOND = "beyond"
"""What is said of a stage that is neither within its noise nor within the tolerance."""

_LOUD = 1.25  # times its noise that a gap within it may be, as its rms is not known better
_LEFT = 0.45  # of the noise: structure that is more than the nuisances of all that is absent
_STEP = 1e-6  # rad or m, of the difference quotient
_SOME = 300  # samples that tell an axis's lever over the work well enough
_SHOWN = 1.3  # times the stated noise that may show before the instrument isn't what was stated
# times the noise, from which a gap is none that hangs together in nothing: what rattles does not, row by row
_SHAKES = 1.6


@dataclass(frozen=True)
class Stage:
    """What a logged stage is within ("noise", "tolerance" or `BEYOND`), and by which values, m: its rms and 95 %, its noise,
    which LOG.toml told or the log shows, and the tolerance, 0 where nobody names one. axis: of drives, the one that decides,
    with its own values over the work.
    """

    within: str
    rms: float
    p95: float
    noise: float
    noise_told: bool
    tolerance: float
    axis: str = ""

    @property
    def summary(self) -> StageWithin:
        """In mm."""
        return StageWithin(
            within=self.within,
            rms_mm=m_to_mm(self.rms),
            p95_mm=m_to_mm(self.p95),
            noise_mm=m_to_mm(self.noise),
            noise_told=self.noise_told,
            tolerance_mm=m_to_mm(self.tolerance) if self.tolerance > 0.0 else None,
            axis=self.axis,
        )


def stages_within(scenes: Sequence[Scene], shrunk: Shrinkage, noise: float) -> dict[str, Stage]:
    """By logged stage. shrunk: on withheld samples, its `before` the gap; noise: m."""
    said = {}
    if all(s.servo_gap is not None for s in scenes):
        drives, order = _drives(scenes, noise), (BEYOND, "tolerance", "noise")
        # the axis that is worst of those within what the whole stage is within
        said["setpoint_to_encoder"] = min(drives.values(), key=lambda s: (order.index(s.within), -s.rms))
    if all(s.tracked for s in scenes):
        said["encoder_to_tcp"] = _of_gap(scenes, shrunk, noise)
    return said


def drives_beyond(scenes: Sequence[Scene], noise: float) -> tuple[str, str]:
    """The axis whose drive is farthest beyond its noise, and that in words; "" and "" where none is or nobody logged it."""
    if any(s.servo_gap is None for s in scenes):
        return "", ""
    on_work = drives_on_work(scenes)
    beyond = [a for a, said in _drives(scenes, noise).items() if said.within == BEYOND]
    if not beyond:
        return "", ""
    axis = max(beyond, key=lambda a: on_work[a])
    k, cell = scenes[0].index(axis), scenes[0].cell
    gap = np.concatenate([s.servo_gap[:, k] for s in scenes if s.servo_gap is not None])
    rms, linear = float(np.sqrt(np.mean(gap**2))), cell.joints[cell.index(axis)].prismatic
    size = f"{m_to_mm(rms):.3g} mm" if linear else f"{rad_to_deg(rms):.3g} degrees"
    over = f"{m_to_mm(on_work[axis]):.3g} mm over the work"
    words = f"between set-point and encoder, {axis} is off its set-point by {size} rms ({over})"
    if axis in motors_follow(scenes):
        words += "; its motor's own encoder follows the set-point, so that this lies between motor and link: "
        words += "the gear, its play or its wind-up"
    return axis, words


def _of_gap(scenes: Sequence[Scene], shrunk: Shrinkage, noise: float) -> Stage:
    sigma = np.array([s.sigma[0] for s in scenes]) * np.sqrt(3.0)
    known = bool(np.isfinite(sigma).all() and (sigma > 0.0).all())
    instrument = float(np.sqrt(np.mean(sigma**2))) if known else noise
    quiet = shrunk.structure(before=True) < _LEFT * noise and noise < _SHOWN * instrument
    quiet = quiet and shrunk.rms_before < _SHAKES * noise
    tolerance, p95 = tolerance_of(scenes), shrunk.quantiles()["p95"][0]
    if shrunk.rms_before < _LOUD * instrument or quiet:
        within = "noise"
    else:
        within = "tolerance" if p95 < tolerance else BEYOND
    return Stage(within, shrunk.rms_before, p95, instrument, known, tolerance)


def _drives(scenes: Sequence[Scene], noise: float) -> Mapping[str, Stage]:
    """By axis. An encoder's noise that nobody stated is taken to be within what the instrument could see of it."""
    on_work, tolerance = drives_on_work(scenes), tolerance_of(scenes)
    said = {}
    for k, axis in enumerate(scenes[0].axes):
        linear = scenes[0].cell.joints[scenes[0].cell.index(axis)].prismatic
        infos = [s.log.info for s in scenes]
        stated = np.array([i.sigma_axis_length if linear else i.sigma_axis for i in infos])
        gap = np.concatenate([s.servo_gap[:, k] for s in scenes if s.servo_gap is not None])
        rms, known = float(np.sqrt(np.mean(gap**2))), bool(np.isfinite(stated).all())
        lever = on_work[axis] / rms if rms > 0.0 else 0.0
        quiet = rms < _LOUD * float(stated.max()) if known else on_work[axis] < noise
        p95 = lever * float(np.quantile(np.abs(gap), 0.95))
        within = "noise" if quiet else "tolerance" if on_work[axis] < tolerance else BEYOND
        at_work = lever * float(stated.max()) if known else noise
        said[axis] = Stage(within, on_work[axis], p95, at_work, known, tolerance, axis)
    return said


def tolerance_of(scenes: Sequence[Scene]) -> float:
    """m that the users of all logs live with, 0 where one doesn't say."""
    stated = [s.log.info.tolerance for s in scenes]
    return float(min(stated)) if np.isfinite(stated).all() else 0.0


def drives_on_work(scenes: Sequence[Scene]) -> dict[str, float]:
    """m (rms) by axis: how far what its drive leaves moves the tool over the work, whatever frame was measured in."""
    total, count = dict.fromkeys(scenes[0].axes, 0.0), 0
    for scene in scenes:
        if scene.servo_gap is None:
            continue
        rows = np.unique(np.linspace(0, len(scene) - 1, min(len(scene), _SOME)).astype(int))
        at = base_T_tool(scene.cell, scene.postures(scene.link[rows]))[:, :3, 3]
        for k, axis in enumerate(scene.axes):
            moved = scene.link[rows].copy()
            moved[:, k] += _STEP
            there = base_T_tool(scene.cell, scene.postures(moved))[:, :3, 3]
            lever = np.linalg.norm(there - at, axis=1) / _STEP
            total[axis] += float(np.sum((lever * scene.servo_gap[rows, k]) ** 2))
        count += len(rows)
    return {a: float(np.sqrt(v / max(count, 1))) for a, v in total.items()}
