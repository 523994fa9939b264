"""A HOME at which the arm touches itself: no place of a part can help, so that the cell's check names the bodies."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest
from six_axes import six_axes

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.errors import CollisionError
from camrob.jobs.files.cell_check import cell_check
from camrob.jobs.files.cells_and_samples import cell_from_urdf
from camrob.kinematics.kernels import chain_arrays, forward_many

ROOT = Path(__file__).resolve().parents[2]
CELLS, ENGRAVING = ROOT / "cells", ROOT / "toolpaths" / "engraving" / "engraving.cls"


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
    said, cure = "at HOME A3 housing touches A1 column", "change home_deg, or what is drawn of one of them"
    assert any(line.startswith(f"{said}: {cure}") for line in cell_check(folder).summary.home)
    with pytest.raises(CollisionError) as refused:  # and no place of the part is proposed
        post(ENGRAVING, cell=folder, out=tmp_path / "out", report=False)
    assert refused.value.what.startswith(f"the program was not released: {said}; {cure}")
    assert not (tmp_path / "out").exists() or not any((tmp_path / "out").iterdir())


def test_a_part_that_stands_where_the_tool_is_at_home_is_to_be_placed_elsewhere(tmp_path: Path) -> None:
    shutil.copytree(ENGRAVING.parent, tmp_path / "part")
    setup = tmp_path / "part" / "setup.toml"
    cell = read_cell(CELLS / "kr15_track_table")
    x, y, z = 1e3 * forward_many(chain_arrays(cell), cell.q_home[None])[0, :3, 3]
    text = setup.read_text(encoding="utf-8").replace(
        "[0, 0, 200, 0, 0, 0]", f"[{x:.1f}, {y:.1f}, {z + 100:.1f}, 0, 0, 0]"
    )
    setup.write_text(text, encoding="utf-8")
    with pytest.raises(CollisionError, match=r"at HOME .*stock.*; place the part elsewhere"):
        post(tmp_path / "part" / ENGRAVING.name, cell=CELLS / "kr15_track_table", out=tmp_path / "out", report=False)


def test_a_free_home_near_it_is_named_and_is_free(tmp_path: Path) -> None:
    folder = tmp_path / "cell"
    shutil.copytree(CELLS / "kr15_track_table", folder)
    settings = folder / "cell.toml"
    before, a2, behind = settings.read_text(encoding="utf-8").partition('name = "A2"')
    behind = behind.replace("home_deg = -90\n", "home_deg = -140\n", 1).replace(
        "home_deg = 0\n", "home_deg = -205\n", 1
    )
    settings.write_text(before + a2 + behind, encoding="utf-8")
    said = cell_check(folder).summary.home[0]
    assert "touches there" in said
    text = settings.read_text(encoding="utf-8")
    named = re.findall(r"(A\d) (-?\d+)", said.partition(": with ")[2])
    assert named
    for axis, value in named:
        text = re.sub(rf'(name = "{axis}"\n.*?home_deg = )[-\d.]+', rf"\g<1>{value}", text, count=1, flags=re.DOTALL)
    settings.write_text(text, encoding="utf-8")
    assert cell_check(folder).summary.home == ()


def test_bodies_that_touch_in_every_posture_are_drawn_into_each_other(tmp_path: Path) -> None:
    """No HOME helps: what is drawn has to change, or the two are neighbours that may touch."""
    folder = tmp_path / "cell"
    shutil.copytree(CELLS / "kr15_track_table", folder)
    settings = folder / "cell.toml"
    text = settings.read_text(encoding="utf-8")
    collar = (
        '[[shape]]\nname = "collar"\ngroup = "collar"\nframe = "flange"\nkind = "sphere"\nsize_mm = [400]\n'
        'at = [0, 0, 0, 0, 0, 0]\nignore = ["spindle", "tool"]\nstanding = "assumed"\n\n'
    )
    settings.write_text(text.replace("[controller]\n", collar + "[controller]\n", 1), encoding="utf-8")
    home = cell_check(folder).summary.home
    always = [line for line in home if "they touch in all of" in line]
    assert always and 'to ignore of "' not in always[0]
    group = re.findall(r'add "([^"]+)" to ignore of \'([^\']+)\'', always[0])
    assert group, always


def test_a_part_that_stands_in_the_shoulder_is_to_be_placed_elsewhere_and_no_neighbour(tmp_path: Path) -> None:
    """No HOME helps, and what the job brings may not be let touch the machine."""
    cell_from_urdf(six_axes(tmp_path), post=True, out=tmp_path)
    settings = tmp_path / "six" / "cell.toml"
    shoulder = (
        '[[shape]]\nname = "shoulder"\ngroup = "shoulder"\nframe = "A1"\nkind = "sphere"\nsize_mm = [450]\n'
        'at = [0, 0, 0, 0, 0, 0]\nstanding = "assumed"\n\n'
    )
    text = settings.read_text(encoding="utf-8").replace("[controller]\n", shoulder + "[controller]\n", 1)
    settings.write_text(text, encoding="utf-8")
    shutil.copytree(ENGRAVING.parent, tmp_path / "part")
    with pytest.raises(
        CollisionError, match=r"shoulder.*stock.*they touch in all of \d+ postures.*place the part elsewhere"
    ):
        post(tmp_path / "part" / ENGRAVING.name, cell=tmp_path / "six", out=tmp_path / "out", report=False)
