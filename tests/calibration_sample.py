"""Measured poses with planted errors, for the tests of calibration and compensation."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from camrob.calibration.calibrate import fit_cell
from camrob.calibration.calibration import Calibration, ErrorSize, robot_digest
from camrob.calibration.calibration_file import calibration_text
from camrob.calibration.error_model import ErrorModel
from camrob.calibration.measurements import Measurements
from camrob.calibration.parameters import ParameterSet
from camrob.calibration.terms import parameter_of, standard_names
from camrob.cell.cell import Cell
from camrob.cell.read_cell import read_cell
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.se3 import pose, rotation_exp, rotation_to_abc
from camrob.units import deg_to_rad, m_to_mm, mm_to_m, rad_to_deg

ROOT = Path(__file__).resolve().parents[1]
SHARED = ROOT.parent / "shared"
CELL = read_cell(ROOT / "cells" / "kr15_track_table")


def axis_values(cell: Cell, n: int, seed: int = 1) -> np.ndarray:
    """Axis values (N, axes) all over the cell's working range."""
    rng = np.random.default_rng(seed)
    arm = rng.uniform([-60, -120, 40, -120, -80, -150], [60, -50, 130, 120, 80, 150], (n, 6))
    external = rng.uniform(-600, 600, (n, len(cell.external_names)))
    return np.concatenate([arm, external], axis=1)


def drawn(cell: Cell, seed: int = 3, size: float = 0.5) -> dict[str, float]:
    """Errors of an ordinary robot: tenths of mm and of mrad, compliances of 1e-6 rad/Nm."""
    rng = np.random.default_rng(seed)
    out = {}
    for name in standard_names(cell, track=False):
        if name.startswith(("base", "tool")):
            continue
        if name.endswith("compliance"):
            out[name] = float(rng.uniform(0.5e-6, 4e-6))
        else:
            out[name] = float(rng.normal()) * size * 1e-3
    return out


def measure(
    cell: Cell,
    errors: dict[str, float],
    values: np.ndarray,
    *,
    sigma: float = 2e-5,
    sigma_angle: float = 1e-5,
    seed=5,
    **of,
) -> Measurements:
    """What a tracker sees of a cell with errors."""
    rng = np.random.default_rng(seed)
    q = cell.to_q(values)
    model = ErrorModel.of(cell, tuple(errors), **of)
    frames = model.poses(np.array(list(errors.values())), q)
    noise = pose(rotation_exp(rng.normal(0, sigma_angle, (len(q), 3))), rng.normal(0, sigma, (len(q), 3)))
    seen = frames.copy()
    seen[:, :3, 3] += noise[:, :3, 3]
    seen[:, :3, :3] = noise[:, :3, :3] @ frames[:, :3, :3]
    return Measurements(q, seen, True, sigma_position=sigma, sigma_angle=sigma_angle)


def log_of(cell: Cell, data: Measurements, info: LogInfo | None = None) -> MeasurementLog:
    """The same as a log."""
    values = cell.to_axis_values(np.asarray(data.q))
    columns = {"t": np.arange(len(data)) * 5.0}
    columns |= {n: m_to_mm(np.asarray(data.frames[:, k, 3])) for k, n in enumerate("xyz")}
    abc = rad_to_deg(rotation_to_abc(np.asarray(data.frames[:, :3, :3])))
    columns |= {n: abc[:, k] for k, n in enumerate("abc")}
    columns |= {n: values[:, k] for k, n in enumerate(cell.axis_names)}
    return MeasurementLog(
        columns, info or LogInfo(sigma_position=mm_to_m(0.02), sigma_angle=deg_to_rad(0.0006), poses=True)
    )


def calibrate_cell(cell: Cell, data: Measurements | Sequence[Measurements], **options) -> Calibration:
    """The calibration of `fit_cell` alone."""
    return fit_cell(cell, data, **options).calibration


def calibration(file: Path, values: dict[str, float], *, withheld: bool = True) -> Path:
    """A file that holds these constants of the KR15 cell alone."""
    cell = CELL
    parameters = ParameterSet.of(parameter_of(cell, n) for n in values).with_values(
        np.array(list(values.values())), np.full(len(values), 1e-6)
    )
    size = ErrorSize.of(np.full(50, 30e-6), np.zeros(50), oriented=False)
    made = Calibration(
        cell_name=cell.name,
        cell_digest=robot_digest(cell),
        parameters=parameters,
        errors={"calibrated/withheld": size} if withheld else {},
        condition=10.0,
        observability=(1.0,) * 5,
        scatter_position=2e-5,
        logs=(("log.csv", "0"),),
        rows=50,
        outliers=0,
        oriented=False,
        warnings=(),
    )
    file.write_text(calibration_text(made), encoding="utf-8")
    return file
