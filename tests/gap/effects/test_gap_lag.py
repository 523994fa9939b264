"""A lag of the drives where nobody logged encoders: millimetres behind, on an arm whose levers have changed by then."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from stranger_arms import UR, columns_of, driven, followed, placed

from camrob.cell.read_cell import read_cell
from camrob.gap.effects.registry import library
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo

LAG = 0.03  # s
(SERVO,) = [e for e in library() if e.name == "servo_lag"]


@pytest.mark.parametrize("own", [0.0, 0.02])
def test_a_lag_moves_the_tool_as_the_late_arm_stands(own: float, tmp_path: Path) -> None:
    """Against products of Denavit-Hartenberg rows; A2 is `own` s later than the others. Levers at the set-points would be 20
    micrometres off.
    """
    (tmp_path / "cell.toml").write_text(UR.cell)
    t, command = driven(UR, 20.0, 3)
    reached = followed(command, LAG)
    reached[:, 1] = followed(command[:, [1]], LAG + own)[:, 0]
    rows = np.arange(200, len(t) - 10, 4)
    T = placed(UR, reached[rows])
    columns = columns_of(UR, t[rows], reached[rows], T, setpoint=command[rows], sigma=0.0)
    told = {n: v for n, v in columns.items() if n not in UR.names}
    info = LogInfo(sigma_position=1e-5, sigma_angle=3e-5)
    scene = make_scene(MeasurementLog(told, info, Path("run.csv")), read_cell(tmp_path))
    tick = 0.004
    # what the hand-made drive does once a tick, as the time constant of one that acts so
    constant = [tick / (1.0 - np.exp(-tick / lag)) for lag in (LAG, LAG + own)]
    state = {"lag_s": constant[0] - tick, "A2_s": constant[1] - constant[0], "cycle_s": tick}
    units = {u.axis: u for u in SERVO.units([scene], state)}
    (common,), (beyond,) = (SERVO.columns(scene, units[a], state) for a in ("", "A2"))
    foretold = common.tcp * constant[0] + beyond.tcp * (constant[1] - constant[0])
    gap = T[:, :3, 3] - placed(UR, command[rows])[:, :3, 3]
    off = np.linalg.norm(foretold[:, :3] - gap, axis=1)[20:]
    assert np.sqrt(np.mean(gap**2)) > 2e-3
    assert np.sqrt(np.mean(off**2)) < 2e-6
