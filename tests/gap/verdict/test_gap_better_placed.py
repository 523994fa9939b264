"""Names that are likely give way to a place without a name that foretells far more; a name that is at work does not."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from stranger_arms import UR, Faults, columns_of, scattered, true_poses

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.summaries.diagnosis_summary import DiagnosisSummary


def said_of(folder: Path, *, loose: float = 0.0, give: float = 0.0) -> DiagnosisSummary:
    """Of forty poses of a UR beside a smooth rest: a tool that tips over (m) to the side that is below, A2's give (rad/Nm)."""
    (folder / "cell.toml").write_text(UR.cell)
    axis = scattered(UR, 40, 4)
    T = true_poses(UR, axis, Faults(rest=2e-5, give={1: give}), 6)
    for side, far in ((0, 1.0), (1, 0.5)):
        T[:, :3, 3] += far * loose * np.tanh(T[:, 2, side, None] / 0.2) * T[:, :3, side]
    columns = columns_of(UR, np.arange(len(T)) * 9.0, axis, T, turned=False)
    log = MeasurementLog(columns, LogInfo(sigma_position=1e-5, poses=True), Path("log.csv"))
    return diagnose([log], read_cell(folder)).summary


def test_a_loose_tool_is_no_compliance(tmp_path: Path) -> None:
    """It was joint compliance at 78 %, and geometry beside it."""
    said = said_of(tmp_path, loose=3e-4)
    assert not said.claimed
    assert said.unknown.probability > 0.5
    assert (said.unknown.where.axes, said.unknown.where.regimes[:1]) == (("A6",), ("load",))


def test_a_soft_axis_stays_one(tmp_path: Path) -> None:
    assert "joint_compliance" in [e.effect for e in said_of(tmp_path, give=3e-6).claimed]
