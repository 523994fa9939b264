"""Logs that tell less than a place: coordinates, normals, distances from somewhere."""

from __future__ import annotations

from datetime import datetime
from pathlib import Path

import numpy as np
import pytest

from camrob.errors import LogError
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame, info_text, read_info
from camrob.measurement.read_log import read_log
from camrob.measurement.sight import sighted

CENTER = np.array([0.5, 0.1, 0.3])  # m
TURN = np.linspace(0.0, 6.0, 200)
RING = CENTER + 0.15 * np.stack([np.cos(TURN), np.sin(TURN), 0.0 * TURN], axis=1)
CLOUD = np.random.default_rng(3).uniform(-1.0, 1.0, (200, 3))


def distances(places, center, *, zero=0.0, noise=0.0, **facts) -> MeasurementLog:
    d = np.linalg.norm(places - center, axis=1) + zero + noise * np.random.default_rng(4).standard_normal(len(places))
    return MeasurementLog({"t": np.arange(len(d), dtype=float), "A1": np.zeros(len(d)), "d": 1e3 * d}, LogInfo(**facts))


@pytest.mark.parametrize("zero", [0.0, -0.15])
@pytest.mark.parametrize("places", [RING, CLOUD], ids=["ring", "cloud"])
def test_where_distances_are_from_and_by_how_much_they_are_short_is_found(places, zero) -> None:
    log = distances(
        places, CENTER, zero=zero, noise=1e-5, distance_from_unknown=True, distance_zero_unknown=zero != 0.0
    )
    seen = sighted(log, places)
    np.testing.assert_allclose(seen.center, CENTER, atol=5e-5)
    assert float(np.sqrt(np.mean(seen.beyond(places) ** 2))) < 1e-5


def test_a_distance_counts_by_its_length_however_far_the_tool_is_from_where_it_is_meant() -> None:
    seen = sighted(distances(CLOUD, CENTER, distance_from=tuple(CENTER)), CLOUD + np.array([0.01, -0.02, 0.005]))
    np.testing.assert_allclose(seen.beyond(CLOUD), 0.0, atol=1e-12)
    assert seen.share == pytest.approx(1.0 / 3.0)


def test_of_some_coordinates_the_others_count_nothing() -> None:
    log = MeasurementLog({"t": np.arange(200.0), "A1": np.zeros(200), "x": 1e3 * CLOUD[:, 0], "z": 1e3 * CLOUD[:, 2]})
    seen = sighted(log, np.zeros((200, 3)))
    np.testing.assert_allclose(seen.beyond(CLOUD + np.array([0.0, 7.0, 0.0])), 0.0, atol=1e-12)
    np.testing.assert_allclose(seen.beyond(CLOUD - np.array([0.001, 0.0, 0.0]))[:, 0], 0.001, atol=1e-12)
    assert seen.share == pytest.approx(2.0 / 3.0)


def test_of_a_probed_face_only_what_lies_along_its_normal_counts() -> None:
    normal = np.tile([0.0, 3.0, 4.0], (200, 1))
    along = CLOUD + 0.01 * np.cross(normal, CLOUD)
    columns = dict(zip(("x", "y", "z", "nx", "ny", "nz"), (*(1e3 * along).T, *(normal / 5.0).T), strict=True))
    seen = sighted(MeasurementLog({"t": np.arange(200.0), "A1": np.zeros(200), **columns}), CLOUD)
    np.testing.assert_allclose(seen.beyond(CLOUD), 0.0, atol=1e-12)


def written(folder: Path, header: str, row: str, facts: str) -> Path:
    (folder / "log.csv").write_text(f"{header}\n{row}\n")
    (folder / "log.toml").write_text(facts)
    return folder / "log.csv"


@pytest.mark.parametrize(
    ("header", "facts", "what"),
    [
        ("t,d,x,A1", 'd_from_mm = "unknown"', "column d beside x"),
        ("t,nx,ny,nz,A1", "", "without a position"),
        ("t,d,A1", "d_from_mm = [1, 2]", "d_from_mm: is [1, 2]"),
        ("t,d,A1", "d_along = [0, 0, 0]", "d_along: is [0, 0, 0]"),
        ("t,d,A1", "d_along = [0, 0, 1]\nd_from_mm = [0, 0, 0]", "d_along: stands beside d_from_mm"),
        ("t,d,A1", "d_zero = 3", "d_zero: is 3"),
        ("t,d,A1", 'recorded = "yesterday"', "recorded: is 'yesterday'"),
        ("t,d,A1", "recorded = 12:00:00", "recorded: is '12:00:00'"),
    ],
)
def test_what_can_t_be_meant_is_refused(tmp_path, header, facts, what) -> None:
    with pytest.raises(LogError) as refused:
        read_log(written(tmp_path, header, ",".join("1" for _ in header.split(",")), facts))
    assert what in str(refused.value)


def test_a_distance_from_nowhere_is_refused_with_what_to_write() -> None:
    with pytest.raises(LogError, match="d_from_mm"):
        sighted(distances(CLOUD, CENTER), CLOUD)


def test_what_a_distance_is_from_is_written_as_it_was_read(tmp_path) -> None:
    for text in ('d_from_mm = "unknown"', "d_from_mm = [1, 2.5, -3]", "d_along = [0, 0.6, 0.8]", 'd_zero = "unknown"'):
        (tmp_path / "a.toml").write_text(text)
        info = read_info(tmp_path / "a.toml")
        (tmp_path / "b.toml").write_text(info_text(info))
        assert read_info(tmp_path / "b.toml") == info
    (tmp_path / "a.toml").write_text('d_from_mm = "unknown"')
    assert read_info(tmp_path / "a.toml").measured_frame is MeasuredFrame.UNKNOWN


@pytest.mark.parametrize(
    ("text", "moment"),
    [
        ("2026-11-28", datetime(2026, 11, 28)),
        ('"2026-11-28"', datetime(2026, 11, 28)),
        ("2026-11-28 14:30:00", datetime(2026, 11, 28, 14, 30)),
        ("2026-11-28T14:30:00+02:00", datetime(2026, 11, 28, 12, 30)),
    ],
)
def test_when_a_log_was_recorded(tmp_path, text, moment) -> None:
    (tmp_path / "a.toml").write_text(f"recorded = {text}\n")
    info = read_info(tmp_path / "a.toml")
    assert info.recorded == moment
    (tmp_path / "b.toml").write_text(info_text(info))
    assert read_info(tmp_path / "b.toml") == info
