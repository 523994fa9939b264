"""Links of the arm without bodies: what is bare of a copied cell whose links were made longer, by how much, and of which body."""

from __future__ import annotations

import json
import shutil
from pathlib import Path

import pytest

from camrob.bodies.bare_links import bare_links
from camrob.cell.read_cell import read_cell
from camrob.cli.app import run

CELLS = Path(__file__).resolve().parents[2] / "cells"


def _copied(tmp_path: Path, *changes: tuple[str, str]) -> Path:
    folder = tmp_path / "cell"
    shutil.copytree(CELLS / "kr15_track_table", folder)
    (folder / "poses.csv").unlink()  # they are of the shorter arm
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    for old, new in changes:
        assert old in text
        text = text.replace(old, new, 1)
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    return folder


@pytest.mark.parametrize("name", sorted(folder.name for folder in CELLS.iterdir()))
def test_the_shipped_cells_have_bodies_as_long_as_their_links(name: str) -> None:
    assert bare_links(read_cell(CELLS / name)) == ()


@pytest.mark.parametrize("by", [100, 300])
def test_a_longer_forearm_is_bare_by_what_it_is_longer(by: int, tmp_path: Path) -> None:
    """Tubes end 430 mm behind A3 and begin 350 mm before the wrist: together 780 mm, of 600."""
    (bare,) = bare_links(read_cell(_copied(tmp_path, ("d_mm = -600 }", f"d_mm = {-780 - by} }}"))))
    assert (bare.first, bare.second, bare.length) == ("A4", "A5", pytest.approx(0.78 + by / 1000))
    assert bare.bare == pytest.approx(by / 1000 - 0.02, abs=0.003)  # 10 mm off either end count as covered
    assert bare.body in ("A3 tube", "A4 tube")


def test_what_neighbours_cover_about_the_axes_is_not_bare(tmp_path: Path) -> None:
    """The box ends 760 mm from A3's axis; a shoulder of 170 mm stands about A2's."""
    (bare,) = bare_links(read_cell(_copied(tmp_path, ("a_mm = 650", "a_mm = 1250"))))
    assert (bare.first, bare.second, bare.body, bare.group) == ("A2", "A3", "A2 upper arm", "A2")
    assert bare.bare == pytest.approx(1.25 - 0.76 - 0.17 - 0.01, abs=0.012)


def test_rows_that_begin_far_from_the_foot_are_measured_from_the_foot(tmp_path: Path) -> None:
    """The arm's first axis begins 2 m below the foot, as rows between a tilted table and an arm have it; nothing else changes."""
    lower = (("d_mm = -305", "d_mm = -2305"), ("d_mm = -675", "d_mm = -2675"))
    folder = _copied(tmp_path, *lower, ("foot_to_root = [0, 0, 0", "foot_to_root = [0, 0, -2000"))
    assert bare_links(read_cell(folder)) == ()


def test_a_link_that_nothing_is_drawn_of_is_not_called_bare(tmp_path: Path) -> None:
    text = (CELLS / "kr15_track_table" / "cell.toml").read_text(encoding="utf-8")
    shapes = text[text.index("[[shape]]") : text.index("[controller]")]
    assert bare_links(read_cell(_copied(tmp_path, (shapes, "")))) == ()


def test_check_and_post_say_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = _copied(tmp_path, ("d_mm = -600 }", "d_mm = -900 }"))
    run(["cell", "check", str(folder), "--json"])
    (text,) = json.loads(capsys.readouterr().out)["bare"]
    assert text.startswith("100 mm of the 900 mm from A4 to A5 have no body") and "too short by so much" in text
    run(["cell", "check", str(folder)])
    assert "of the 900 mm from A4 to A5" in " ".join(capsys.readouterr().out.split())
    part = tmp_path / "part.cls"
    part.write_text("FEDRAT/500\nGOTO/0,0,300,0,0,1\nGOTO/10,0,300\nGOTO/20,0,300\n", encoding="utf-8")
    status = run(["post", str(part), "--cell", str(folder), "--out", str(tmp_path / "out"), "--no-report", "--json"])
    found = json.loads(capsys.readouterr().out)
    assert status == 0 and [w["text"] for w in found["warnings"] if w["code"] == "bare-link"] == [
        f"{text}; lengthen it in cell.toml"
    ]
