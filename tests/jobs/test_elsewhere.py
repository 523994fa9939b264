"""A refusal says where the part would have to be, and what it says is so."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

import camrob

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"
# two grooves of the sample's size are enough
CL = """TOOL PATH/GROOVE,TOOL,BALL_3
TLDATA/MILL,3.0000,1.5000,80.0000,0.0000,0.0000
MSYS/0.0,0.0,0.0,1.0,0.0,0.0,0.0,1.0,0.0
FEDRAT/MMPM,600.0
GOTO/-60.0,0.0,40.0,0.0,0.0,1.0
GOTO/-60.0,0.0,0.0
GOTO/60.0,0.0,0.0
GOTO/60.0,40.0,0.0
GOTO/60.0,40.0,40.0
END-OF-PATH
"""


def posted(folder: Path, part_in_base: str) -> camrob.PostResult:
    folder.mkdir()
    (folder / "part.cls").write_text(CL)
    (folder / "setup.toml").write_text(f"part_in_base = {part_in_base}\nclearance_mm = 20\n")
    return camrob.post(folder / "part.cls", cell=CELL, out=folder / "out", report=False)


def test_the_place_that_a_refusal_names_serves(tmp_path: Path) -> None:
    with pytest.raises(camrob.JobError) as caught:
        posted(tmp_path / "far", "[0, 0, 1300, 0, 0, 0]")
    found = re.search(
        r"moved by (Z -\d+) mm it can be followed and touches nothing .*: part_in_base = (\[[^]]*\])", str(caught.value)
    )
    assert found is not None, str(caught.value)
    assert posted(tmp_path / "near", found[2]).summary.points > 0


def test_a_part_that_no_shift_brings_into_reach_is_reported_so(tmp_path: Path) -> None:
    with pytest.raises(camrob.UnreachableError, match="no shift of the part by up to 800 mm along the axes of base"):
        posted(tmp_path / "far", "[0, 0, 2600, 0, 0, 0]")


def test_a_file_read_in_inches_that_is_in_millimetres(tmp_path: Path) -> None:
    """No place of the part helps: the refusal doubts the units."""
    (tmp_path / "part.cls").write_text(CL)
    (tmp_path / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    with pytest.raises(
        camrob.JobError, match=r"read as inches the path is 3048 mm wide, so it may be in mm \(--units mm\)"
    ):
        camrob.post(tmp_path / "part.cls", cell=CELL, out=tmp_path / "out", units="inch", report=False)
