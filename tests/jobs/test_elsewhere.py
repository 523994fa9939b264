"""A refusal says where the part would have to be, and what it says is so."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from six_axes import six_axes

import camrob
from camrob.jobs.files.cells_and_samples import cell_from_urdf

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


def posted(folder: Path, part_in_base: str, cell: Path = CELL, method: str = "vjm") -> camrob.PostResult:
    folder.mkdir()
    (folder / "part.cls").write_text(CL)
    (folder / "setup.toml").write_text(f"part_in_base = {part_in_base}\nclearance_mm = 20\n")
    return camrob.post(folder / "part.cls", cell=cell, out=folder / "out", method=method, report=False)


def test_the_place_that_a_refusal_names_serves(tmp_path: Path) -> None:
    with pytest.raises(camrob.JobError) as caught:
        posted(tmp_path / "far", "[0, 0, 1300, 0, 0, 0]")
    found = re.search(
        r"moved by ([XYZ\d, +-]+) mm it can be followed and touches nothing .*: part_in_base = (\[[^]]*\])",
        str(caught.value),
    )
    assert found is not None, str(caught.value)
    assert posted(tmp_path / "near", found[2]).summary.points > 0


def test_reversed_tool_axes_are_named(tmp_path: Path) -> None:
    (tmp_path / "part.cls").write_text(CL.replace("40.0,0.0,0.0,1.0", "40.0,0.0,0.0,-1.0"))
    (tmp_path / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\nclearance_mm = 20\n")
    with pytest.raises(camrob.JobError, match="all tool axes point down as the part lies: turn it over"):
        camrob.post(tmp_path / "part.cls", cell=CELL, out=tmp_path / "out", report=False)


def held(folder: Path, table: str, track: str) -> Path:
    """The cell with a table that turns so far and a track that is so long."""
    shutil.copytree(CELL, folder, ignore=shutil.ignore_patterns("poses.csv"))
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    endless, long = "limits = { endless = true, speed_deg_s = 60", "range_mm = [-1500, 1500]"
    assert text.count(endless) == text.count(long) == 1
    text = text.replace(endless, f"limits = {{ range_deg = {table}, speed_deg_s = 60").replace(
        long, f"range_mm = {track}"
    )
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.parametrize("method", ["vjm", "planned"])
def test_it_serves_a_cell_whose_table_is_held_too(tmp_path: Path, method: str) -> None:
    """The part beside the table's middle, which turns by no more than 5 degrees."""
    cell = held(tmp_path / "cell", "[-5, 5]", "[-1500, 1500]")
    with pytest.raises(camrob.JobError) as caught:
        posted(tmp_path / "far", "[900, 0, 300, 0, 0, 0]", cell, method)
    found = re.search(
        r"moved by [XYZ\d, +-]+ mm it can be followed and touches nothing .*: part_in_base = (\[[^]]*\])",
        str(caught.value),
    )
    assert found is not None, str(caught.value)
    assert posted(tmp_path / "near", found[1], cell, method).summary.points > 0


def test_a_plan_is_advice_where_one_was_made_and_serves(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("camrob.redundancy.published.beginnings.other_beginnings", lambda cell, pose: [])
    cell, where = held(tmp_path / "cell", "[-40, 40]", "[-100, 700]"), "[-68, -684, 127, 0, -54, -32]"
    with pytest.raises(
        camrob.LimitError, match="--method planned, which chooses E2, E1, roll over the whole path, follows it"
    ):
        posted(tmp_path / "followed", where, cell)
    assert posted(tmp_path / "planned", where, cell, "planned").summary.method == "planned"


@pytest.mark.slow
def test_a_plan_that_finds_no_way_either_is_no_advice(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """On its side, with a track and a table that hardly move: the refusal goes on to a place where the part can lie."""
    monkeypatch.setattr("camrob.redundancy.published.beginnings.other_beginnings", lambda cell, pose: [])
    cell = held(tmp_path / "cell", "[-5, 5]", "[-100, 100]")
    with pytest.raises(camrob.LimitError, match="nor does --method planned, which chooses E2, E1, roll") as caught:
        posted(tmp_path / "followed", "[300, 0, 250, 0, -80, 0]", cell)
    assert "it can be followed and touches nothing" in str(caught.value)


def test_a_part_that_no_shift_brings_into_reach_is_reported_so(tmp_path: Path) -> None:
    text = CL.replace("/-60.0", "/-6000.0").replace("/60.0", "/6000.0")
    (tmp_path / "part.cls").write_text(text)
    (tmp_path / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\nclearance_mm = 20\n")
    with pytest.raises(
        camrob.UnreachableError, match="no shift of the part by up to 800 mm along the axes of base, nor"
    ):
        camrob.post(tmp_path / "part.cls", cell=CELL, out=tmp_path / "out", report=False)


def test_a_part_farther_off_than_any_shift_is_sent_to_where_the_tool_is_at_home(tmp_path: Path) -> None:
    with pytest.raises(camrob.UnreachableError) as caught:
        posted(tmp_path / "far", "[0, 0, 2600, 0, 0, 0]")
    found = re.search(r"touches nothing .*: part_in_base = (\[[^]]*\])", str(caught.value))
    assert found is not None, str(caught.value)
    assert posted(tmp_path / "near", found[1]).summary.points > 0


@pytest.mark.slow
def test_a_file_read_in_inches_that_is_in_millimetres(tmp_path: Path) -> None:
    """No place of the part helps: the refusal doubts the units."""
    (tmp_path / "part.cls").write_text(CL)
    (tmp_path / "setup.toml").write_text("part_in_base = [0, 0, 200, 0, 0, 0]\n")
    with pytest.raises(
        camrob.JobError, match=r"read as inches the path is 3048 mm wide, so it may be in mm \(--units mm\)"
    ):
        camrob.post(tmp_path / "part.cls", cell=CELL, out=tmp_path / "out", units="inch", report=False)


def test_an_arm_out_of_a_urdf_is_sent_to_a_place_before_its_tool(tmp_path: Path) -> None:
    """The part lies in the robot's foot, as the samples' do: no body of the arm is drawn that would say so."""
    cell_from_urdf(six_axes(tmp_path), post=True, out=tmp_path)
    with pytest.raises(camrob.JobError) as caught:
        posted(tmp_path / "foot", "[0, 0, 200, 0, 0, 0]", tmp_path / "six")
    said = str(caught.value)
    found = re.search(
        r"it can be followed and touches nothing .* not drawn\): part_in_base = (\[([-\d.]+), [^]]*\])", said
    )
    assert found is not None, said
    assert float(found[2]) > 500.0  # before the foot
    assert posted(tmp_path / "before", found[1], tmp_path / "six").summary.points > 0


@pytest.mark.slow
def test_a_collision_names_a_place_that_is_free(tmp_path: Path) -> None:
    """A wall of the cell stands in the part."""
    shutil.copytree(CELL, tmp_path / "cell", ignore=shutil.ignore_patterns("poses.csv"))
    settings = tmp_path / "cell" / "cell.toml"
    wall = (
        '[[shape]]\nname = "post"\ngroup = "post"\nframe = "world"\nkind = "box"\nsize_mm = [60, 60, 600]\n'
        'at = [40, 0, 300, 0, 0, 0]\nignore = ["table", "part", "stock"]\nstanding = "assumed"\n\n'
    )
    settings.write_text(settings.read_text(encoding="utf-8").replace("[controller]\n", wall + "[controller]\n", 1))
    with pytest.raises(camrob.CollisionError) as caught:
        posted(tmp_path / "in_it", "[0, 0, 200, 0, 0, 0]", tmp_path / "cell")
    found = re.search(r"it can be followed and touches nothing .*: part_in_base = (\[[^]]*\])", str(caught.value))
    assert found is not None, str(caught.value)
    assert posted(tmp_path / "beside", found[1], tmp_path / "cell").summary.collisions.count == 0
