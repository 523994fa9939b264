"""Rows of Craig's convention in a cell that programs are made for: the same machine to camrob and to the witness."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

import camrob
from camrob.cell.read_cell import read_cell
from camrob.kinematics.frames import base_T_tool
from camrob.witness.machine import read_machine

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
ROW = re.compile(r"dh = \{ alpha_deg = (\S+), a_mm = (\S+), theta_deg = (\S+), d_mm = (\S+) \}")


def without_bodies(folder: Path) -> str:
    """The cell's text without bodies and masses, whose frames are other ones behind modified rows."""
    shutil.copytree(KR15, folder)
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    return re.sub(r"(?ms)^\[\[(?:shape|mass)\]\].*?(?=^\[)", "", text)


@pytest.fixture
def modified(tmp_path: Path) -> Path:
    """The KR15 cell in modified rows: each takes alpha and a of the one before it."""
    text = without_bodies(tmp_path / "cell")
    rows = ROW.findall(text)[:-1]  # but the roll's
    before = iter([("0", "0"), *(row[:2] for row in rows[:-1])])

    def row(found: re.Match[str]) -> str:
        alpha, a = next(before)
        return f'dh = {{ convention = "modified", alpha_deg = {alpha}, a_mm = {a}, theta_deg = {found[3]}, d_mm = {found[4]} }}'

    text = ROW.sub(row, text, count=len(rows))
    assert rows[1][:2] == ("90", "0") and rows[-1][:2] == (
        "0",
        "0",
    )  # E1's last turn, now in A1's row; nothing behind A6's
    text = text.replace("foot_to_root = [0, 0, 0, 0, 180, 0]", "foot_to_root = [0, 0, 0, 180, 0, 90]")
    (tmp_path / "cell" / "cell.toml").write_text(text, encoding="utf-8")
    return tmp_path / "cell"


def test_both_readings_are_those_of_the_standard_rows(modified: Path) -> None:
    """poses.csv, which goes along, holds S and T as well."""
    cell, own = read_cell(modified), read_cell(KR15)
    machine, theirs = read_machine(modified), read_machine(KR15)
    rng = np.random.default_rng(4)
    for axes in rng.uniform(-90.0, 90.0, (20, 8)):
        np.testing.assert_allclose(base_T_tool(cell, cell.to_q(axes)), base_T_tool(own, own.to_q(axes)), atol=1e-12)
        for reading in ("base_T_flange", "base_T_root", "base_T_world"):
            one, other = (getattr(m, reading)(axes[None]) for m in (machine, theirs))
            np.testing.assert_allclose(one, other, atol=1e-12)


def test_a_part_is_posted_with_them_as_with_standard_rows(modified: Path, tmp_path: Path) -> None:
    plain = tmp_path / "plain"
    text = without_bodies(plain)
    (plain / "cell.toml").write_text(text, encoding="utf-8")
    shutil.copytree(ROOT / "toolpaths" / "engraving", tmp_path / "in", ignore=shutil.ignore_patterns("golden"))
    clfile = tmp_path / "in" / "engraving.cls"
    clfile.write_text("".join(clfile.read_text().splitlines(keepends=True)[:60]) + "END-OF-PATH\n")
    for cell in (modified, plain):
        camrob.post(clfile, cell=cell, out=tmp_path / f"out_{cell.name}", report=False)
    one, other = (tmp_path / f"out_{cell.name}" / "engraving.src" for cell in (modified, plain))
    assert one.read_text() == other.read_text()


def test_an_arm_in_short_is_no_arm_that_programs_are_made_for(tmp_path: Path) -> None:
    text = without_bodies(tmp_path / "cell")
    joint = r'(?ms)^\[\[joint\]\]\nname = "A\d".*?(?=^\[)'
    rows = "[arm]\ndh = [[0, 0, 0, 400], [-90, 0, 0, 0], [0, 600, 0, 0], [-90, 0, 0, 600], [90, 0, 0, 0], [-90, 0, 0, 90]]\n"
    text = re.sub(joint, "", text).replace("# $TOOL", f'{rows}standing = "datasheet"\n\n# $TOOL')
    (tmp_path / "cell" / "cell.toml").write_text(text, encoding="utf-8")
    (tmp_path / "cell" / "poses.csv").unlink()
    with pytest.raises(
        camrob.CellError, match=r'arm: is for a cell that is only measured.*convention = "modified", too'
    ):
        read_cell(tmp_path / "cell")
