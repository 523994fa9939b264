"""External axes keep from where they bring bodies together that no posture of the arm keeps apart: the arm on a column."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

import camrob
from camrob.jobs.files.inputs import read_inputs
from camrob.jobs.files.kept_apart import kept_apart

ROOT = Path(__file__).resolve().parents[3]
CELL = ROOT / "cells" / "kr15_track_table"
RELIEF = ROOT / "toolpaths" / "relief" / "relief.cls"
# its plate's underside lies 405 mm below the table's top where E1 is 0, the floor 655
FLOOR = -250.0


def on_a_column(folder: Path, low: float) -> Path:
    """The KR15 cell with its track upright: E1 lifts the arm, from `low` mm up."""
    shutil.copytree(CELL, folder, ignore=shutil.ignore_patterns("poses.csv"))
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    for old, new in (
        ("alpha_deg = 90, a_mm = 803", "alpha_deg = 0, a_mm = 803"),
        ("alpha_deg = 90, a_mm = 0, theta_deg = 0, d_mm = 0 }\naxis = { sign = 1, offset_mm",
         "alpha_deg = 180, a_mm = 0, theta_deg = 0, d_mm = 0 }\naxis = { sign = 1, offset_mm"),
        ("range_mm = [-1500, 1500]", f"range_mm = [{low}, 700]"),
        ('ignore = ["track", "A1"]', 'ignore = ["A1"]'),
    ):  # fmt: skip
        assert old in text
        text = text.replace(old, new)
    text = re.sub(r'\[\[shape\]\]\nname = "track bed".*?\n\n', "", text, flags=re.DOTALL)
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.parametrize("low", [-300.0, -200.0])
def test_a_lift_stays_above_the_floor(tmp_path: Path, low: float) -> None:
    cell = camrob.read_cell(on_a_column(tmp_path / "column", low))
    inputs = read_inputs(RELIEF, cell, None)
    kept = kept_apart(inputs)
    e1 = kept.cell.joints[cell.index("E1")]
    if low > FLOOR:
        assert kept.cell is inputs.cell and not kept.findings
    else:
        step = (700.0 - low) / 40
        assert FLOOR <= 1e3 * e1.lower <= FLOOR + step + 1.0 and e1.upper == pytest.approx(0.7)
        assert kept.text.startswith("E1 is kept to -") and "carriage plate would touch floor" in kept.text


def test_a_cell_whose_external_axes_bring_nothing_together_is_left_alone() -> None:
    inputs = read_inputs(RELIEF, camrob.read_cell(CELL), None)
    assert kept_apart(inputs).cell is inputs.cell


@pytest.mark.slow
def test_a_part_is_posted_that_would_be_cut_through_the_floor(tmp_path: Path) -> None:
    result = camrob.post(RELIEF, cell=on_a_column(tmp_path / "column", -300.0), out=tmp_path, report=False)
    assert "kept-apart" in [f.code for f in result.findings]
    lowest = min(float(v) for v in re.findall(r"E1 (\S+?),E2", (tmp_path / "relief.src").read_text()))
    assert FLOOR < lowest < -150.0
