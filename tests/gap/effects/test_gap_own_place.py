"""A name against the free form of its own place: what follows the same, but otherwise, is not that name's.

Arms are made by hand (`stranger_arms`), and what goes wrong on them is written down here from physics.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.signal import lsim
from stranger_arms import DEG, TICK, UR, columns_of, driven, followed, placed
from stranger_kinds import kinds, run
from stranger_logs import Brought, early
from test_gap_single_shape import beyond, panel
from test_gap_strangers import cell_of

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.servo_lag import EFFECT as LAG
from camrob.gap.evidence.scan import shapes
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.measurement.read_log import read_log


def said_of(case: Brought, folder: Path) -> dict[str, Any]:
    (folder / "run.csv").write_text(case.logs[0][1])
    (folder / "run.toml").write_text(case.logs[0][2])
    return diagnose([read_log(folder / "run.csv")], read_cell(cell_of(case.machine, folder))).summary.to_json()


def beliefs(said: dict[str, Any]) -> dict[str, float]:
    return {e["effect"]: e["probability"] for e in said["effects"]}


@pytest.mark.parametrize("poses", [True, False])
def test_what_is_elsewhere_from_a_moment_on_is_found_with_the_moment(poses: bool, tmp_path: Path) -> None:
    at = 402.0 if poses else 17.02
    one = panel(tmp_path, beyond(2, lambda t, q: 0.04 * DEG * (t > at)), poses=poses)
    best = shapes([one], [one.y_tcp], [None], 1.0, 1e-5, 8)[0]
    assert best.target == "A3"
    assert best.quantity == "from a moment of log.csv on"
    assert best.lower == pytest.approx(at, abs=12.0 if poses else 0.04)
    assert np.ptp(best.fit) == pytest.approx(0.04 * DEG, rel=0.1)


def test_what_drifts_smoothly_is_no_step(tmp_path: Path) -> None:
    one = panel(tmp_path, beyond(2, lambda t, q: 0.04 * DEG * np.sin(t / 10.0)), poses=False)
    best = next(s for s in shapes([one], [one.y_tcp], [None], 1.0, 1e-5, 8) if s.target == "A3")
    assert best.quantity == "time"


def test_a_step_belongs_to_its_own_log(tmp_path: Path) -> None:
    """The second of two logs is whole: what the first does from its middle on is not looked for there."""
    (tmp_path / "first").mkdir()
    (tmp_path / "second").mkdir()
    first = panel(tmp_path / "first", beyond(2, lambda t, q: 0.04 * DEG * (t > 17.02)), poses=False)
    second = panel(tmp_path / "second", beyond(2, lambda t, q: 0.0 * t), poses=False, name="other.csv")
    best = shapes([first, second], [first.y_tcp, second.y_tcp], [None, None], 1.0, 1e-5, 8)[0]
    assert best.quantity == "from a moment of log.csv on"
    assert np.ptp(best.fit[len(first.scene) :]) == 0.0


def test_a_drive_of_second_order_differs_from_one_of_first_order_by_what_lag_is_said_to_do_at_the_widest(
    tmp_path: Path,
) -> None:
    """1 / w^2 of the acceleration, a share of what damping 0.25 makes of the same lag 2 z / w."""
    natural, damping = 40.0, 0.7
    lag = 2.0 * damping / natural
    (tmp_path / "cell.toml").write_text(UR.cell)
    t, command = driven(UR, 20.0, 2)
    begun = command - command[0]
    second, first = (
        np.stack([lsim(system, u, t)[1] for u in begun.T], axis=1) + command[0]
        for system in (([natural**2], [1.0, 2.0 * damping * natural, natural**2]), ([1.0], [lag, 1.0]))
    )
    moved = placed(UR, second) - placed(UR, first)
    rows = np.arange(500, len(t) - 100, 5)
    columns = columns_of(UR, t[rows], command[rows], placed(UR, command[rows]), setpoint=command[rows], sigma=0.0)
    columns = {n: v for n, v in columns.items() if n not in UR.names}
    scene = make_scene(MeasurementLog(columns, LogInfo(), Path("log.csv")), read_cell(tmp_path))
    (column,) = LAG.wider(scene, {"lag_s": lag})
    assert column.tcp is not None
    share = (0.25 / damping) ** 2
    left = moved[rows][:, :3, 3] - share * column.tcp[:, :3]
    assert np.sqrt(np.mean(left**2)) < 0.15 * np.sqrt(np.mean(moved[rows][:, :3, 3] ** 2))


def giving_way(t: np.ndarray, reached: np.ndarray, T: np.ndarray) -> np.ndarray:
    """All axes give way behind their encoders by 6e-4 s2 of their acceleration."""
    return placed(UR, reached - 6e-4 * np.gradient(np.gradient(reached, TICK, axis=0), TICK, axis=0))


@pytest.mark.slow
def test_where_encoders_tell_stages_apart_what_follows_acceleration_is_as_sure_as_ever(tmp_path: Path) -> None:
    said = said_of(run(UR, reach=lambda u: followed(u, 0.03), bend=giving_way), tmp_path)
    assert beliefs(said)["acceleration_error"] > 0.95
    assert beliefs(said)["servo_lag"] > 0.95


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ur: servo of second order, no encoders", "lift: servo of second order, no encoders"])
def test_where_a_drive_of_second_order_shows_the_same_the_two_are_a_class(name: str, tmp_path: Path) -> None:
    said = said_of(kinds()[name](), tmp_path)
    entry = next(e for e in said["effects"] if e["effect"] == "acceleration_error")
    assert entry["probability"] < 0.8 < entry["class_probability"]
    assert entry["class"] == ["acceleration_error", "servo_lag"]
    assert beliefs(said)["servo_lag"] > 0.95


@pytest.mark.slow
def test_a_drive_that_lags_by_its_speed_is_late_for_sure_and_held_against_the_others(tmp_path: Path) -> None:
    """By lag or by a delay: 10 ms of either do the same."""

    def reach(command):
        out = command.copy()
        out[:, 0] = followed(command[:, :1], 0.01)[:, 0]
        return out

    (late,) = said_of(run(UR, reach=reach), tmp_path)["effects"]
    assert late["class"] == ["servo_lag", "setpoint_delay"]
    assert late["class_probability"] > 0.95
    assert "A1 compared with those of the other axes" in late["remedy"]


@pytest.mark.slow
@pytest.mark.parametrize("who", ["ur", "kr"])
def test_a_drive_that_falls_behind_by_the_square_of_its_speed_is_unknown_at_that_drive(
    who: str, tmp_path: Path
) -> None:
    said = said_of(kinds()[f"{who}: A1's drive is short of voltage"](), tmp_path)
    assert max(beliefs(said).values(), default=0.0) < 0.5
    assert said["unknown"]["probability"] > 0.95
    where = said["unknown"]["where"]
    assert (where["rung"], where["axes"], where["regimes"][:1]) == ("setpoint_to_encoder", ["A1"], ["speed"])


@pytest.mark.slow
@pytest.mark.parametrize("who", ["ur", "kr"])
def test_an_axis_that_slips_once_is_no_target_that_slips(who: str, tmp_path: Path) -> None:
    said = said_of(kinds()[f"{who}: A3 slips late on a run"](), tmp_path)
    assert max(beliefs(said).values(), default=0.0) < 0.5
    where = said["unknown"]["where"]
    assert (where["rung"], where["axes"], where["regimes"][:1]) == ("encoder_to_tcp", ["A3"], ["time"])
    assert "A3 is off by 0.04 degrees from 16.984 s of run.csv on" in said["unknown"]["text"]


@pytest.mark.slow
def test_a_target_that_slips_on_a_run_is_as_sure_as_ever(tmp_path: Path) -> None:
    def bend(t, reached, T):
        out = T.copy()
        out[t > 14.0, :3, 3] += np.einsum("nij,j->ni", T[t > 14.0, :3, :3], [3e-4, -2e-4, 1e-4])
        return out

    assert beliefs(said_of(run(UR, bend=bend), tmp_path))["measurement_drift"] > 0.95


@pytest.mark.slow
def test_what_goes_with_the_way_of_the_last_move_is_no_play(tmp_path: Path) -> None:
    """Readings taken early, by a library that lacks them: play follows the last move's side, not its length."""
    case = early(UR)
    (tmp_path / "set.csv").write_text(case.logs[0][1])
    (tmp_path / "set.toml").write_text(case.logs[0][2])
    log, cell = read_log(tmp_path / "set.csv"), read_cell(cell_of(UR, tmp_path))
    said = diagnose([log], cell, without=["early_reading"]).summary.to_json()
    assert max(beliefs(said).values(), default=0.0) < 0.5
    assert said["unknown"]["where"]["regimes"][:1] == ["direction"]
    assert "last move of" in said["unknown"]["text"]
