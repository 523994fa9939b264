"""Drives that lag on an arm that bends behind them by more: arm, drives and bend by other code than the library's."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from stranger_arms import UR, columns_of, driven, followed, placed

from camrob.cell.read_cell import read_cell
from camrob.gap.diagnose import diagnose
from camrob.gap.effects.registry import library
from camrob.gap.evidence.comparison import compare
from camrob.gap.evidence.model import Model
from camrob.gap.evidence.shrink import doubt_of_shrinkage, drives_gap, shrinkage, trial_of
from camrob.gap.observation.scene import make_scene
from camrob.gap.verdict import verdict
from camrob.gap.verdict.at_drives import at_drives, moved_at_drives, shaped_at_drives, stays_at_drives
from camrob.gap.verdict.beside_more import beside_more
from camrob.gap.verdict.delivers import delivered
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.report.diagnosis.head import head_lines

LAG = 0.004  # s
BEND = 2e-3  # m, to either side, as A2 swings: what the library has no name for here
SERVO = [e for e in library() if e.name == "servo_lag"]
SAID = {"servo_lag": 0.97}


@pytest.fixture(scope="module")
def model(tmp_path_factory: pytest.TempPathFactory) -> Model:
    folder = tmp_path_factory.mktemp("arm")
    (folder / "cell.toml").write_text(UR.cell)
    t, command = driven(UR, 20.0, 3)
    reached = followed(command, LAG)
    rows = np.arange(200, len(t) - 10, 5)
    T = placed(UR, reached[rows])
    T[:, :3, 3] += BEND * np.sin(2.0 * reached[rows, 1:2]) * np.array([0.6, 0.0, 0.8])
    columns = columns_of(UR, t[rows], reached[rows], T, setpoint=command[rows], sigma=2e-5)
    info = LogInfo(sigma_position=2e-5, sigma_angle=3e-5)
    scene = make_scene(MeasurementLog(columns, info, Path("run.csv")), read_cell(folder))
    found = compare([scene], SERVO)
    own = frozenset(i for i, u in enumerate(found.units) if u.effect == "servo_lag" and not u.axis)
    return replace(found, best=found.fit(found.best.members | own))


def test_what_the_drives_lack_is_taken_however_much_the_arm_bends(model: Model) -> None:
    trial = trial_of(model, ())
    own = frozenset(i for i in model.best.members if model.units[i].effect == "servo_lag")
    whole, there = (shrinkage(model, trial, model.best.members, own, at_drives=d) for d in (False, True))
    assert there.shrink > 0.9
    assert whole.rms_after > 4.0 * doubt_of_shrinkage(model, trial, own)
    assert whole.rms_after > 0.5e-3
    assert stays_at_drives(model, there, SAID) < 0.1 * moved_at_drives(model, ["servo_lag"])
    (panel,) = model.panels
    gap = drives_gap(panel, np.ones(len(panel.scene), np.bool_))
    assert moved_at_drives(model, ["servo_lag"]) == pytest.approx(np.sqrt(np.mean(np.sum(gap**2, axis=1))), rel=0.05)


def test_a_name_of_the_drives_is_held_to_what_stays_there(model: Model) -> None:
    trial = trial_of(model, ())
    own = frozenset(i for i in model.best.members if model.units[i].effect == "servo_lag")
    together = shrinkage(model, trial, model.best.members, own)
    assert at_drives(model, SERVO) == {"servo_lag"}
    assert beside_more(model, trial, together, SAID, SERVO)["servo_lag"] == pytest.approx(0.97)
    assert delivered(model, trial, SAID, ["servo_lag"])["servo_lag"] == pytest.approx(1.0, abs=0.05)


def test_no_shape_behind_the_encoders_rivals_what_these_show(model: Model) -> None:
    shape = next(i for i, u in enumerate(model.units) if u.effect == "unknown" and not u.key.startswith("drive "))
    beside = replace(
        model, best=model.fit(model.best.members | {shape}), sets={frozenset({"servo_lag", "unknown"}): 1.0}
    )
    assert not shaped_at_drives(beside)
    ((_, held),) = verdict._evidence(beside, SERVO)
    assert held == 1.0
    blind = replace(beside, panels=tuple(replace(p, servo=None, y_servo=None) for p in beside.panels))
    ((_, held),) = verdict._evidence(blind, SERVO)
    assert held == 0.0


@pytest.mark.parametrize("drives", [False, True])
def test_encoders_that_a_recorder_smooths_are_no_lag_of_the_drives(drives: bool, tmp_path: Path) -> None:
    """The tool at the set-points, the encoders' record 20 ms late; and, for comparison, drives that are."""
    (tmp_path / "cell.toml").write_text(UR.cell)
    cell = read_cell(tmp_path)
    logs = []
    for seed in (3, 4):
        t, command = driven(UR, 20.0, seed)
        late = followed(command, 0.02)
        rows = np.arange(200, len(t) - 10, 8)
        T = placed(UR, (late if drives else command)[rows])
        columns = columns_of(UR, t[rows], late[rows], T, setpoint=command[rows], turned=False, seed=seed)
        logs.append(MeasurementLog(columns, LogInfo(sigma_position=1e-5), tmp_path / f"run{seed}.csv"))
    said = diagnose(logs[:1], cell, withheld=logs[1:]).summary
    assert [e.effect for e in said.claimed] == (["servo_lag"] if drives else [])
    if not drives:
        assert said.status == "unexplained" and said.unknown.where.stage == "setpoint_to_encoder"
        assert dict(head_lines(said))["What"].startswith("The record of the encoders, and not the machine")
