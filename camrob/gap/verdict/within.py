"""Whether a gap is none: every logged stage within its noise, or within what the log's user cares about, and which of the two."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from camrob.gap.evidence.shrink import Shrinkage
from camrob.gap.observation.scene import Scene
from camrob.kinematics.frames import base_T_tool
from camrob.units import m_to_mm, rad_to_deg

__all__ = ["BEYOND", "drives_beyond", "drives_on_work", "stages_within"]

Array = NDArray[np.float64]

BEYOND = "beyond"
"""What is said of a stage that is neither within its noise nor within the tolerance."""

_LOUD = 1.25  # times its noise that a gap within it may be, as its rms is not known better
_LEFT = 0.45  # of the noise: structure that is more than the nuisances of all that is absent
_STEP = 1e-6  # rad or m, of the difference quotient
_SOME = 300  # samples that tell an axis's lever over the work well enough
_SHOWN = 1.3  # times the stated noise that may show before the instrument isn't what was stated


def stages_within(scenes: Sequence[Scene], shrunk: Shrinkage, structure: float, noise: float) -> dict[str, str]:
    """By logged stage "noise", "tolerance" or `BEYOND`. shrunk: on withheld samples, its `before` the gap; structure: m of it
    that hang together; noise: m, 3-D rms.
    """
    said = {"encoder_to_tcp": _of_gap(scenes, shrunk, structure, noise)}
    if all(s.servo_gap is not None for s in scenes):
        drives = _drives(scenes, noise)
        said["setpoint_to_encoder"] = (
            BEYOND if BEYOND in drives.values() else "tolerance" if "tolerance" in drives.values() else "noise"
        )
    return said


def drives_beyond(scenes: Sequence[Scene], noise: float) -> tuple[str, str]:
    """The axis whose drive is farthest beyond its noise, and that in words; "" and "" where none is or nobody logged it."""
    if any(s.servo_gap is None for s in scenes):
        return "", ""
    on_work = drives_on_work(scenes)
    beyond = [a for a, said in _drives(scenes, noise).items() if said == BEYOND]
    if not beyond:
        return "", ""
    axis = max(beyond, key=lambda a: on_work[a])
    k, cell = scenes[0].index(axis), scenes[0].cell
    gap = np.concatenate([s.servo_gap[:, k] for s in scenes if s.servo_gap is not None])
    rms, linear = float(np.sqrt(np.mean(gap**2))), cell.joints[cell.index(axis)].prismatic
    size = f"{m_to_mm(rms):.3g} mm" if linear else f"{rad_to_deg(rms):.3g} degrees"
    over = f"{m_to_mm(on_work[axis]):.3g} mm over the work"
    return axis, f"between set-point and encoder, {axis} is off its set-point by {size} rms ({over})"


def _of_gap(scenes: Sequence[Scene], shrunk: Shrinkage, structure: float, noise: float) -> str:
    stated = np.array([s.sigma[0] for s in scenes]) * np.sqrt(3.0)
    instrument = float(np.sqrt(np.mean(stated**2))) if np.isfinite(stated).all() and (stated > 0.0).all() else noise
    quiet = structure < _LEFT * noise and noise < _SHOWN * instrument
    if shrunk.rms_before < _LOUD * instrument or quiet:
        return "noise"
    tolerance = _tolerance(scenes)
    return "tolerance" if shrunk.quantiles()["p95"][0] < tolerance else BEYOND


def _drives(scenes: Sequence[Scene], noise: float) -> Mapping[str, str]:
    """By axis. An encoder's noise that is not stated is taken to be within what the instrument could see of it."""
    on_work, tolerance = drives_on_work(scenes), _tolerance(scenes)
    said = {}
    for k, axis in enumerate(scenes[0].axes):
        linear = scenes[0].cell.joints[scenes[0].cell.index(axis)].prismatic
        infos = [s.log.info for s in scenes]
        stated = np.array([i.sigma_axis_length if linear else i.sigma_axis for i in infos])
        gap = np.concatenate([s.servo_gap[:, k] for s in scenes if s.servo_gap is not None])
        rms = float(np.sqrt(np.mean(gap**2)))
        quiet = rms < _LOUD * float(stated.max()) if np.isfinite(stated).all() else on_work[axis] < noise
        said[axis] = "noise" if quiet else "tolerance" if on_work[axis] < tolerance else BEYOND
    return said


def _tolerance(scenes: Sequence[Scene]) -> float:
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
