"""What stands between a program that was written and its release."""

from __future__ import annotations

from pathlib import Path

import pytest

from camrob import post
from camrob.errors import CollisionError, VerificationError
from camrob.jobs.release import release
from camrob.jobs.release.refusal import advice, as_planned

CELL = Path(__file__).resolve().parents[3] / "cells" / "kr15_track_table"
INTO_THE_PART = "G21 G90 G17\nT1 M6\nS6000 M3\nG0 X-60 Y0 Z30\nG0 X60\nG1 X62 F300\nG0 Z60\nM30\n"
SETUP = (
    "part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\ndiameter_mm = 6\nlength_mm = 40\n"
    "[part]\nbox_mm = [-8, -50, 0, 8, 50, 45]\n"
)


@pytest.mark.parametrize(
    ("blind", "error", "said"),
    [
        (None, CollisionError, "touches part"),
        (lambda borders: [borders[1], borders[0]], VerificationError, "not checked along all of"),
        (lambda borders: [*borders[:-1], borders[-1] - 2], VerificationError, "not checked along all of"),
    ],
)
def test_collisions_are_looked_for_along_all_of_the_program(tmp_path: Path, monkeypatch, blind, error, said) -> None:
    """A rapid through a ridge of the part; where the check is given a part of the program only, it says so."""
    file = tmp_path / "ridge.nc"
    file.write_text(INTO_THE_PART)
    (tmp_path / "setup.toml").write_text(SETUP)
    if blind is not None:
        found = release._borders
        monkeypatch.setattr(release, "_borders", lambda back, inputs: blind(found(back, inputs)))
    with pytest.raises(error, match=said):
        post(file, cell=CELL, out=tmp_path / "out", report=False)
    assert not list((tmp_path / "out").glob("*.src"))


def test_planning_is_advised_only_where_the_job_was_not_planned() -> None:
    refused = CollisionError(f"A3 touches stock; {advice('collision')}", line=10, region="TOP")
    assert "--method planned" in str(refused)
    planned = as_planned(refused)
    assert type(planned) is CollisionError and (planned.line, planned.region) == (10, "TOP")
    assert (
        planned.what == "A3 touches stock; place the part elsewhere (camrob place), or raise clearance_mm in setup.toml"
    )


def test_no_clearance_is_advised_where_bodies_touch_within_a_cut(tmp_path: Path) -> None:
    file = tmp_path / "wall.nc"
    file.write_text("G21 G90 G17\nT1 M6\nS6000 M3\nG0 X-30 Y0 Z60\nG1 Z-40 F300\nX30\nG0 Z60\nM30\n")
    (tmp_path / "setup.toml").write_text(SETUP)
    with pytest.raises(CollisionError, match="while it cuts") as refused:
        post(file, cell=CELL, out=tmp_path / "out", report=False)
    assert "a longer or slimmer tool" in str(refused.value) and "clearance_mm" not in str(refused.value)


def test_a_planned_job_is_not_told_to_plan(tmp_path: Path) -> None:
    file = tmp_path / "ridge.nc"
    file.write_text(INTO_THE_PART)
    (tmp_path / "setup.toml").write_text(SETUP)
    with pytest.raises(CollisionError, match="touches part") as refused:
        post(file, cell=CELL, out=tmp_path / "out", report=False, method="planned")
    assert "place the part elsewhere" in str(refused.value) and "planned" not in str(refused.value)
