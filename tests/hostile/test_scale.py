"""Inputs of unusual size or shape: found and named, not choked on. tests/bench/scale_faults.py runs the full sizes."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from camrob import post
from camrob.cli import app as cli

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
sys.path.insert(0, str(ROOT / "tests" / "bench"))

from scale_faults import SETUP, blanks, long_line, many_regions, wavy_spiral  # noqa: E402


def written(folder: Path, lines: Iterator[str]) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "setup.toml").write_text(SETUP)
    with (folder / "part.cls").open("w") as file:
        file.writelines(lines)
    return folder / "part.cls"


@pytest.mark.slow
def test_one_point_out_of_reach_among_many(tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Named with its line, its axis and how far it is; the same file without it is posted."""
    part = written(tmp_path / "in", wavy_spiral(20_000, unreachable=True))
    wanted = next(k for k, line in enumerate(part.read_text().splitlines(), 1) if ",-9000.0000" in line)
    assert cli.run(["post", str(part), "--cell", str(CELL), "--out", str(tmp_path / "out")]) == 3
    printed = capfd.readouterr().err
    assert printed.count("\n") == 1 and f"line {wanted}" in printed and "out of reach" in printed and "mm" in printed
    assert [f.name for f in tmp_path.iterdir()] == ["in"]
    made = post(written(tmp_path / "in", wavy_spiral(20_000)), cell=CELL, out=tmp_path / "out", report=False)
    assert made.summary.points == 20_002


@pytest.mark.slow
def test_many_regions_of_one_point(tmp_path: Path) -> None:
    made = post(written(tmp_path / "in", many_regions(400)), cell=CELL, out=tmp_path / "out", report=False)
    assert len(made.summary.regions) == 400 and made.summary.verified.points == 400


@pytest.mark.slow
@pytest.mark.parametrize(("lines", "message"), [(blanks(200), "empty"), (long_line(100), "part.cls:4:")])
def test_much_of_nothing(tmp_path: Path, capfd: pytest.CaptureFixture[str], lines: Iterator[str], message: str) -> None:
    part = written(tmp_path / "in", lines)
    assert cli.run(["post", str(part), "--cell", str(CELL), "--out", str(tmp_path / "out")]) == 2
    shown = capfd.readouterr().err
    assert shown.count("\n") == 1 and message in shown and len(shown) < 400
