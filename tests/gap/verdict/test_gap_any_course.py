"""Two names of a drive that work against each other, beside what drives made by hand do."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stranger_arms import TICK, UR, columns_of, driven, placed

from camrob.cell.read_cell import read_cell
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.observation.scene import make_scene
from camrob.gap.verdict.at_drives import any_course
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo

NAMES = {"friction", "setpoint_delay"}
TWO = [e for e in library() if e.name in NAMES]


def doubted(folder: Path, behind: Callable[[np.ndarray], np.ndarray]) -> frozenset[str]:
    """Of both names at A1, which is `behind` by its speed (rad/s)."""
    (folder / "cell.toml").write_text(UR.cell)
    t, command = driven(UR, 20.0, 3)
    reached = command.copy()
    reached[:, 0] -= behind(np.gradient(command[:, 0], TICK))
    rows = np.arange(200, len(t) - 10, 5)
    T = placed(UR, reached[rows])
    columns = columns_of(UR, t[rows], reached[rows], T, setpoint=command[rows], sigma=2e-5)
    info = LogInfo(sigma_position=2e-5, sigma_angle=3e-5)
    model = compare([make_scene(MeasurementLog(columns, info, Path("run.csv")), read_cell(folder))], TWO)
    both = {i for i, u in enumerate(model.units) if u.effect in NAMES and u.axis == "A1" and u.key != "held"}
    return any_course(replace(model, best=model.fit(model.evidence.always | both)), NAMES)


@pytest.mark.parametrize("power", [2, 3])
def test_a_power_of_the_speed_is_neither(power: int, tmp_path: Path) -> None:
    assert doubted(tmp_path, lambda v: 4e-3 * np.sign(v) * np.abs(v) ** power) == NAMES


@pytest.mark.parametrize("friction", [6e-5, -6e-5])
def test_a_delay_beside_dry_friction_is_both(friction: float, tmp_path: Path) -> None:
    """Less the friction too: a controller may feed more forward than there is."""
    assert doubted(tmp_path, lambda v: 1e-3 * v + friction * np.tanh(v / 2e-3)) == frozenset()
