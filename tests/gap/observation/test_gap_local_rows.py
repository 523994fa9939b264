"""Poses that are far off and share a place are no gross readings: the place is said, and what to look at there."""

from __future__ import annotations

import numpy as np
import pytest
from gap_cells import ur10
from test_gap_instrument import spoilt
from test_gap_pose_sets import postures, seen_from

from camrob.gap.diagnose import diagnose
from camrob.gap.observation.noise import local_of
from camrob.gap.observation.scene import make_scene
from camrob.measurement.log import MeasurementLog
from camrob.report.diagnosis.head import head_lines

Array = np.ndarray


def off_where(log: MeasurementLog, rows: Array, turned_rad: float = 0.002) -> MeasurementLog:
    """The tool turned about the instrument's z by a little at some poses, as an encoder that reads wrong there does."""
    x, y = (np.where(rows, turned_rad * log.columns[n], 0.0) for n in "xy")
    columns = dict(log.columns) | {"x": log.columns["x"] - y, "y": log.columns["y"] + x}
    return MeasurementLog(columns, log.info, log.path)


def in_sector(log: MeasurementLog) -> Array:
    """A quarter of the poses, next to each other along A2."""
    order = np.argsort(log.columns["A2"])
    rows = np.zeros(len(log), bool)
    rows[order[10 : 10 + len(log) // 5]] = True
    return rows


def test_poses_off_in_a_sector_of_an_axis_are_that_sectors() -> None:
    log = seen_from(postures(80, 3))
    rows = in_sector(log)
    found = local_of(make_scene(off_where(log, rows, 0.01), ur10()))
    assert found is not None
    assert found.axis == "A2"
    assert (found.rows & rows).sum() >= rows.sum() - 2
    assert not (found.rows & ~rows).any()
    at = np.deg2rad(log.columns["A2"][rows])
    assert at.min() - 1e-9 <= found.low[0] < found.high[0] <= at.max() + 1e-9


def test_poses_off_in_a_part_of_the_room_are_that_parts() -> None:
    log = seen_from(postures(120, 5))
    place = np.stack([log.columns[n] for n in "xyz"], axis=1)
    middle = np.median(place, axis=0) + np.array([600.0, 300.0, 0.0])
    rows = np.zeros(len(log), bool)
    rows[np.argsort(np.linalg.norm(place - middle, axis=1))[:16]] = True
    columns = dict(log.columns) | {"z": log.columns["z"] + 6.0 * rows}
    found = local_of(make_scene(MeasurementLog(columns, log.info, log.path), ur10()))
    assert found is not None
    assert found.axis == ""
    assert (found.rows & rows).sum() >= 10


@pytest.mark.parametrize("seed", range(6))
def test_gross_readings_here_and_there_share_no_place(seed: int) -> None:
    log, _ = spoilt(seen_from(postures(100, seed), seed=seed), 0.12, 10.0)
    assert local_of(make_scene(log, ur10())) is None


@pytest.mark.slow(after=1)
def test_the_place_of_such_poses_is_said_first_and_nothing_is_no_gap() -> None:
    log = seen_from(postures(80, 3))
    said = diagnose([off_where(log, in_sector(log), 0.01)], ur10()).summary
    assert said.status in ("unexplained", "partly explained")
    assert said.unknown.probability > 0.9
    assert said.unknown.where.axes == ("A2",)
    assert said.unknown.where.regimes == ("position",)
    assert said.unknown.where.stage == "encoder_to_tcp"
    lines = dict(head_lines(said))
    assert lines["What"].startswith(f"{said.where.local[0].poses} of 80 poses are off by up to ")
    assert "A2 between" in lines["What"]
    assert said.unknown.isolated_by.startswith("look at what A2 meets with A2 between")
    assert said == type(said).from_json(said.to_json())
