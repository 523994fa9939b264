"""What recorders do to a run: encoders or set-points a row late, values that are renewed now and then, targets read in turn."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from strange_logs import columns_of, run, seen, write

from camrob.cell.read_cell import read_cell
from camrob.gap.observation.as_recorded import as_recorded
from camrob.measurement.read_log import read_log

T, Q = run(20.0, 0.02, 1)
WRONG = (0, 0.05, 0, 0, 0, 0)


def behind(values: np.ndarray, rows: int) -> np.ndarray:
    return np.concatenate([values[:1].repeat(rows, axis=0), values[:-rows]])


def held(values: np.ndarray, rows: int) -> np.ndarray:
    return values[np.arange(len(values)) // rows * rows]


def encoders(q: np.ndarray = Q) -> np.ndarray:
    return q + np.random.default_rng(2).normal(0.0, 1e-5, q.shape)


def recorded(folder: Path, encoder: np.ndarray, setpoint: np.ndarray, place: np.ndarray | None = None):
    """The log as it comes out, what is said of it, and as it was."""
    write(folder, columns_of(encoder, seen(Q, wrong_deg=WRONG) if place is None else place, T, setpoint), ())
    log = read_log(folder / "log.csv")
    found = as_recorded([log], [read_cell(folder / "cell")])
    return found.logs[0], " | ".join(found.said), log


AXES = [f"A{k}" for k in range(1, 7)]


@pytest.mark.parametrize("rows", [1, 3])
def test_encoders_that_are_written_late_are_one_cause(tmp_path: Path, rows: int) -> None:
    log, said, was = recorded(tmp_path, behind(encoders(), rows), Q)
    assert f"the encoder values of log.csv stand {rows} row" in said and len(log) == len(was) - rows
    assert np.array_equal(log.columns["A2"], was.columns["A2"][rows:]) and np.array_equal(
        log.columns["x"], was.columns["x"][:-rows]
    )


def test_set_points_that_are_written_late_are_brought_to_what_no_drive_is_ahead_of(tmp_path: Path) -> None:
    log, said, was = recorded(tmp_path, encoders(), behind(Q, 2))
    assert "the set-points of log.csv stand 2 rows (0.040 s) behind its encoder values" in said
    assert np.array_equal(log.columns["cA2"], was.columns["cA2"][2:])


def test_drives_that_lag_and_readings_that_come_late_stay_as_they_are(tmp_path: Path) -> None:
    """The arm is where its encoders say; a whole row of delay alone, and a lag of a row and a half."""
    for late in (behind(Q, 1), 0.5 * (behind(Q, 1) + behind(Q, 2))):
        log, said, was = recorded(tmp_path, encoders(late), Q, seen(late, wrong_deg=WRONG))
        assert not said and len(log) == len(was)
    assert not recorded(tmp_path, encoders(), Q, behind(seen(Q, wrong_deg=WRONG), 1))[1]


@pytest.mark.parametrize("which", ["set-points", "encoder values"])
def test_rows_in_which_values_are_new_stand_for_those_in_which_they_are_old(tmp_path: Path, which: str) -> None:
    pair = (encoders(), held(Q, 5)) if which == "set-points" else (held(encoders(), 5), Q)
    log, said, was = recorded(tmp_path, *pair)
    assert f"its {which} are new in one row of 5 alone" in said and len(log) < 0.5 * len(was)
    apart = np.abs(log.axes(AXES) - log.setpoints(AXES)).max()
    assert apart < 0.01 < 1.0 < np.abs(was.axes(AXES) - was.setpoints(AXES)).max()


def test_a_coarse_encoder_that_turns_evenly_is_no_old_value(tmp_path: Path) -> None:
    even = np.outer(np.linspace(0.0, 0.25, len(T)), [1.0, 0, 0, 0, 0, 0]) + Q[:1]
    coarse = np.radians(np.round(np.degrees(even) / 0.05) * 0.05)
    log, said, was = recorded(tmp_path, coarse, even, seen(even, wrong_deg=WRONG))
    assert not said and len(log) == len(was)


def test_targets_that_were_read_in_turn_are_told_apart(tmp_path: Path) -> None:
    place = seen(Q, wrong_deg=WRONG)
    assert not recorded(tmp_path, encoders(), Q, place)[1]
    place[::2] += [0.1, 0.0, 0.0]
    assert "every second reading of log.csv lies (0.10" in recorded(tmp_path, encoders(), Q, place)[1]


def test_an_instrument_that_was_moved_is_told_with_the_line(tmp_path: Path) -> None:
    place = seen(Q, wrong_deg=WRONG)
    place[700:] += [18.0, -12.0, 8.0]
    said = recorded(tmp_path, encoders(), Q, place)[1]
    assert "from line 702 of log.csv on, readings lie (18" in said and "was moved" in said
