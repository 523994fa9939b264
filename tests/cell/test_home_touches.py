"""A HOME at which the arm touches itself: no place of a part can help, so that the cell's check names the bodies."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest

from camrob.jobs.files.cell_check import cell_check

CELLS = Path(__file__).resolve().parents[2] / "cells"


@pytest.mark.parametrize("name", sorted(folder.name for folder in CELLS.iterdir()))
def test_the_shipped_cells_touch_nothing_at_home(name: str) -> None:
    assert cell_check(CELLS / name).summary.home == ()


def test_an_arm_folded_onto_its_own_column_at_home_is_named(tmp_path: Path) -> None:
    folder = tmp_path / "cell"
    shutil.copytree(CELLS / "kr15_track_table", folder)
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    before, a2, behind = text.partition('name = "A2"')
    behind = behind.replace("home_deg = -90\n", "home_deg = -140\n", 1).replace(
        "home_deg = 0\n", "home_deg = -205\n", 1
    )
    (folder / "cell.toml").write_text(before + a2 + behind, encoding="utf-8")
    said = cell_check(folder).summary.home
    assert "at HOME A3 housing touches A1 column: change home_deg, or what is drawn of one of them" in said
