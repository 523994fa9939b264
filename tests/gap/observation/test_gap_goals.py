"""Goals of moves from pose to pose are no set-points: known by how they jump, and said."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from gap_cases import kr15, simulated
from stranger_arms import ONE, text

from camrob.cell.read_cell import read_cell
from camrob.errors import LogError
from camrob.gap.locate.by_stage import stage_gaps
from camrob.gap.observation.goals import goal_axes
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.read_log import read_log

STEP = 0.02  # s


def to_and_fro(
    seconds: float = 40.0, every: float = 2.0, fast: float = 20.0
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Times; goals in degrees, a new one every so many seconds; where an axis of 20 degrees a second is on its way there."""
    t = np.arange(0.0, seconds, STEP)
    goals = np.random.default_rng(2).uniform(-20, 20, int(seconds / every) + 1)[(t / every).astype(int)]
    at = np.empty_like(t)
    at[0] = goals[0]
    for k in range(1, len(t)):
        at[k] = at[k - 1] + np.clip(goals[k] - at[k - 1], -fast * STEP, fast * STEP)
    return t, goals, at


def log_of(folder: Path, t: np.ndarray, command: np.ndarray, encoder: np.ndarray) -> MeasurementLog:
    (folder / "cell.toml").write_text(ONE.cell)
    (folder / "log.csv").write_text(text({"t": t, "A1": encoder, "cA1": command}))
    return read_log(folder / "log.csv")


def test_goals_of_a_log_of_drives_alone_are_refused(tmp_path: Path) -> None:
    log = log_of(tmp_path, *to_and_fro())
    assert goal_axes(log, ["A1"]) == ("A1",)
    with pytest.raises(LogError, match="holds goals that jump in cA1, no set-points"):
        make_scene(log, read_cell(tmp_path))


def test_goals_that_a_drive_reaches_late_and_smoothly_are_goals_all_the_same(tmp_path: Path) -> None:
    t, goals, at = to_and_fro(fast=400.0)
    for k in range(1, len(t)):
        at[k] = at[k - 1] + 0.06 * (goals[k] - at[k - 1])
    assert goal_axes(log_of(tmp_path, t, goals, at), ["A1"]) == ("A1",)


@pytest.mark.parametrize("kind", ["followed", "late", "slow bus", "rests", "coarse"])
def test_set_points_that_a_drive_follows_are_no_goals(kind: str, tmp_path: Path) -> None:
    t, _, at = to_and_fro()
    at = np.convolve(np.pad(at, 10, mode="edge"), np.ones(21) / 21, "valid")
    command, encoder = at, at.copy()
    if kind == "late":
        for k in range(1, len(t)):
            encoder[k] = encoder[k - 1] + 0.1 * (command[k] - encoder[k - 1])
    if kind == "slow bus":
        command = at[np.arange(len(t)) // 4 * 4]
    if kind == "rests":
        encoder = encoder + np.random.default_rng(1).normal(0.0, 1e-3, len(t))
    if kind == "coarse":
        command = np.round(at, 1)
    assert goal_axes(log_of(tmp_path, t, command, encoder), ["A1"]) == ()


def test_beside_a_tracker_goals_are_passed_over_and_that_is_said() -> None:
    log = simulated()
    goals = {f"cA{n}": np.repeat(log.columns[f"cA{n}"][::200], 200)[: len(log)] for n in range(1, 7)}
    jumping = MeasurementLog(dict(log.columns) | goals, log.info, log.path)
    scene = make_scene(jumping, kr15())
    assert scene.setpoint is None and scene.encoder is not None
    assert any(m.startswith("no set-points, but goals that jump") for m in stage_gaps(scene, None).missing)
    plain = make_scene(log, kr15())
    assert plain.setpoint is not None
    assert not any("goals" in m for m in stage_gaps(plain, None).missing)
