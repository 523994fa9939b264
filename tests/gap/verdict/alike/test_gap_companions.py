"""A rail that is bent in waves is a track, however little of its slopes is known; one that is straight is none."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from strange_logs import columns_of, on_rail, poses, read, write

from camrob.jobs.diagnose import diagnose

LONG = 5000.0  # mm


def waves(ways: np.ndarray) -> np.ndarray:
    third, second = (np.sin(k * np.pi * ways / LONG) for k in (3, 2))
    return np.stack([0.0 * ways, 0.25 * third, 0.2 * second], axis=1)


def straight(ways: np.ndarray) -> np.ndarray:
    return np.zeros((len(ways), 3))


@pytest.mark.parametrize(("course", "bent"), [(waves, True), (straight, False)], ids=["waves", "straight"])
def test_a_rail_in_waves_is_a_track_under_an_instrument_that_stands_anywhere(
    tmp_path: Path, course, bent: bool
) -> None:
    q, ways = poses(90, 11), np.random.default_rng(12).uniform(0.0, LONG, 90)
    wrong = q + np.radians([0.05, 0, 0, 0, 0, 0])  # of A1, as of a foot that is turned
    columns = columns_of(q, read(on_rail(wrong, ways, course), open_frames=True)) | {"E1": ways}
    facts = ("poses = true", 'measured_frame = "unknown"', 'target = "unknown"')
    write(tmp_path, columns, facts, rail=True)
    diagnose(cell=tmp_path / "cell", log=[tmp_path / "log.csv"], out=tmp_path / "out")
    said = json.loads((tmp_path / "out" / "diagnosis.json").read_text())
    assert ("track" in {e["effect"] for e in said["effects"] if e["probability"] >= 0.5}) == bent
    assert said["together"]["rms_after_mm"] < 0.05
