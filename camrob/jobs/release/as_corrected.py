"""A program that `compensate` has made, held to its original: all else alike, the calibrated robot where that was sent."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from camrob.calibration.calibration_file import read_calibration
from camrob.calibration.compensate import difference_sizes, pose_difference
from camrob.cell.cell import Cell
from camrob.controller.replay import Replay
from camrob.errors import InputError
from camrob.findings import Finding, Severity
from camrob.jobs.closing.tool_chains import ToolChains
from camrob.program.motion import Motion
from camrob.program.program_text import ProgramText
from camrob.summaries.verify_summary import CorrectedFrom
from camrob.units import m_to_mm, mm_to_m, rad_to_deg

__all__ = ["hold_to_original"]

Array = NDArray[np.float64]

_OFF_MM, _OFF_DEG = 0.01, 0.01  # that the calibrated robot may miss the original by, as a program may its CL file
_SAME = 1e-9
_COLUMNS = ("kind", "status", "circular_angle_deg", "speed", "acceleration", "blend_mm", "blend", "wait", "external")


def hold_to_original(
    corrected: tuple[ProgramText, Replay],
    original: tuple[ProgramText, Replay],
    file: Path,
    calibration: Path,
    cell: Cell,
) -> tuple[CorrectedFrom, tuple[Finding, ...]]:
    """What a corrected program does besides moving its targets, and how far the calibrated robot is off the original's poses.

    corrected, original: texts and their replays. file: the original's. Raises LogError, StaleInputError for a calibration that is
    none of the cell, InputError where the one holds other motions than the other.
    """
    (text, run), (meant, planned) = corrected, original
    if len(text) != len(meant):
        hint = "give the program that it was made of; one that compensate --diagnosis has divided is not held to it"
        raise InputError(f"holds {len(meant)} motions, and {text.files[0]} {len(text)}", hint=hint, path=file)
    found = [f for check in (_elsewhere, _acts) if (f := check(text, meant)) is not None]
    reached = ToolChains.of(read_calibration(calibration, cell), planned.cells, planned.mounted).poses(
        np.asarray(run.q)
    )
    off = difference_sizes(pose_difference(np.asarray(planned.base_T_tool), reached))
    apart = np.abs(np.asarray(text.axes) - np.asarray(meant.axes)).max(axis=1)
    stays = (np.asarray(text.kind) == Motion.PTP_AXES) & (apart < _SAME)  # HOME, which asks for no pose
    held = (np.asarray(text.kind) != Motion.CIRC_VIA) & ~stays
    off[~held] = 0.0
    worst = (
        int(np.argmax(np.maximum(off[:, 0] / mm_to_m(_OFF_MM), rad_to_deg(off[:, 1]) / _OFF_DEG))) if len(off) else 0
    )
    if m_to_mm(off[worst, 0]) > _OFF_MM or rad_to_deg(off[worst, 1]) > _OFF_DEG:
        what = f"the calibrated robot misses the pose of {file.name} by {m_to_mm(off[worst, 0]):.4f} mm and "
        what += f"{rad_to_deg(off[worst, 1]):.4f} degrees: corrected by something else than this calibration, or in part only"
        found.append(_error("corrected-otherwise", what, text, worst))
    moved = np.linalg.norm((np.asarray(run.base_T_tool) - np.asarray(planned.base_T_tool))[:, :3, 3], axis=1)
    figures = CorrectedFrom(
        original=file.name,
        calibration=calibration.name,
        moved_mm_max=m_to_mm(float(moved[held].max(initial=0.0))),
        position_error_mm_max=m_to_mm(float(off[:, 0].max(initial=0.0))),
        axis_error_deg_max=rad_to_deg(float(off[:, 1].max(initial=0.0))),
    )
    return figures, tuple(found)


def _elsewhere(text: ProgramText, meant: ProgramText) -> Finding | None:
    """The first motion that differs in more than its target."""
    columns = [(name, np.asarray(getattr(text, name)), np.asarray(getattr(meant, name))) for name in _COLUMNS]
    columns += [(name, _frames(text, name), _frames(meant, name)) for name in ("tool", "base")]
    for name, new, old in columns:
        if new.shape != old.shape:
            return _error("not-as-original", "other external axes move than in the original", text, 0)
        unlike = ~np.isclose(new.astype(float), old.astype(float), rtol=0.0, atol=_SAME, equal_nan=True).reshape(
            len(text), -1
        ).all(axis=1)
        if unlike.any():
            what = f"{name.replace('_', ' ')} of the motion is not the original's: a correction moves targets alone"
            return _error("not-as-original", what, text, int(np.argmax(unlike)))
    return None


def _acts(text: ProgramText, meant: ProgramText) -> Finding | None:
    """The first output, wait or setting that is not the original's."""
    same = (
        text.actions == meant.actions
        and text.final_wait == meant.final_wait
        and dict(text.settings) == dict(meant.settings)
    )
    if same:
        return None
    pairs = enumerate(zip(text.actions, meant.actions, strict=False))
    row = next((a.motion for _, (a, b) in pairs if a != b), len(text) - 1)
    what = "what the program does beside moving is not what the original does"
    return _error("not-as-original", what, text, min(row, len(text) - 1))


def _frames(text: ProgramText, name: str) -> Array:
    """(N, 6) X..C of the tool or the base of each motion."""
    frames = np.stack([np.asarray(f.xyzabc) for f in getattr(text, f"{name}s")])
    return np.asarray(frames[np.asarray(getattr(text, name))])


def _error(code: str, what: str, text: ProgramText, row: int) -> Finding:
    return Finding(code, what, Severity.ERROR, line=int(text.line[row]), point=row)
