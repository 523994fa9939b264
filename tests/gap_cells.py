"""Cells other than the KR15's for tests of the diagnosis, and logs of them made by hand."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

import gap_cases
import numpy as np

from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.cell.joint import dh_after, dh_before
from camrob.cell.read_cell import read_cell
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.se3 import rotation_to_abc

DATA = Path(__file__).resolve().parent / "data"


@cache
def ur10() -> Cell:
    return read_cell(DATA / "ur10")


@cache
def column() -> Cell:
    """The KR15 with all its masses on a column: E1 lifts it, straight up; no table."""
    cell = gap_cases.kr15()
    joints = [j for j in cell.joints if j.name != "E2"]
    joints[0] = replace(joints[0], before=dh_before(theta=0.0, d=0.0), after=dh_after(a=0.0, alpha=np.pi))
    first = np.eye(4)
    first[:3, 3] = [-0.803, 0.0, -0.305]
    return replace(
        cell,
        joints=tuple(joints),
        base_T_first=first,
        base_follows_table=False,
        controller_section=None,
        resolve_section=None,
        shapes=(),
    )


def edge(cell: Cell, axis: np.ndarray) -> np.ndarray:
    """SI axis values (N, k) in degrees and mm."""
    linear = [cell.joints[cell.index(n)].prismatic for n in cell.axis_names]
    return np.where(linear, 1e3 * axis, np.rad2deg(axis))


def axis_columns(cell: Cell, axis: np.ndarray, prefix: str = "") -> dict[str, np.ndarray]:
    """SI axis values (N, k) as columns of a log."""
    return {f"{prefix}{n}": v for n, v in zip(cell.axis_names, edge(cell, axis).T, strict=True)}


def log_of(
    cell: Cell,
    t: np.ndarray,
    axis: np.ndarray,
    errors: Mapping[str, float],
    *,
    sigma_mm: float = 0.02,
    seed: int = 0,
    more: Mapping[str, np.ndarray] | None = None,
    **facts: Any,
) -> MeasurementLog:
    """A log of a cell with constant errors (terms of the error model) at SI axis values (N, k), encoders and set-points alike."""
    values = edge(cell, axis)
    poses = ErrorModel.of(cell, list(errors)).poses(np.array(list(errors.values())), cell.to_q(values))
    rng = np.random.default_rng(seed)
    place = 1e3 * poses[:, :3, 3] + rng.normal(0.0, sigma_mm, (len(t), 3))
    turn = np.rad2deg(rotation_to_abc(poses[:, :3, :3]))
    columns = {"t": t, **dict(zip("xyz", place.T, strict=True)), **dict(zip("abc", turn.T, strict=True))}
    columns |= axis_columns(cell, axis) | axis_columns(cell, axis, "c") | dict(more or {})
    info = LogInfo(sigma_position=1e-3 * sigma_mm, sigma_angle=1e-5, **facts)
    return MeasurementLog(columns, info, Path("made.csv"))


def not_finite(value: Any, where: str = "") -> list[str]:
    """Places in a summary that hold NaN or infinity."""
    if isinstance(value, Mapping):
        return [f for k, v in value.items() for f in not_finite(v, f"{where}/{k}")]
    if isinstance(value, list | tuple):
        return [f for k, v in enumerate(value) for f in not_finite(v, f"{where}/{k}")]
    return [where] if isinstance(value, float) and not np.isfinite(value) else []


@cache
def single() -> Cell:
    """The UR10's first axis alone, with a tip half a metre off it."""
    cell = ur10()
    tip = np.eye(4)
    tip[0, 3] = 0.5
    return replace(
        cell,
        joints=cell.joints[:1],
        masses=cell.masses[:1],
        flange_T_tool=tip,
        controller_section=None,
        resolve_section=None,
    )


@cache
def seven() -> Cell:
    """The UR10 with one more axis behind its sixth, across it."""
    cell = ur10()
    last = replace(cell.joints[-1], after=dh_after(a=0.0, alpha=np.pi / 2))
    more = replace(cell.joints[-1], name="A7", before=dh_before(theta=0.0, d=0.15))
    return replace(cell, joints=(*cell.joints[:-1], last, more), controller_section=None, resolve_section=None)
