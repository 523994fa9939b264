"""Nothing about the KR15 cell is in the code: other chains are other folders."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.jobs.verify import verify

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"


def _without(text: str, *joints: str) -> str:
    """cell.toml without some joints and what names them."""
    parts = re.split(r"(?m)^(?=\[\[)", text)
    kept = [p for p in parts if not re.match(rf'\[\[joint\]\]\nname = "({"|".join(joints)})"', p)]
    text = "".join(kept)
    for name in joints:
        text = re.sub(rf'{name} = "\w+", ', "", text)
        text = text.replace(f'frame = "{name}"', 'frame = "world"')
    return text


@pytest.fixture
def make_cell(tmp_path):
    def make(change, *, poses: bool = False) -> Path:
        """Another cell; the KR15's poses.csv goes along only where it is true of it."""
        folder = tmp_path / "cell"
        shutil.copytree(KR15, folder, ignore=None if poses else shutil.ignore_patterns("poses.csv"))
        file = folder / "cell.toml"
        file.write_text(change(file.read_text()))
        return folder

    return make


def test_an_arm_alone_whose_foot_stands_where_the_track_put_it(make_cell, tmp_path):
    def change(text: str) -> str:
        text = _without(text, "E1", "E2")
        text = text.replace("base_to_first = [0, 0, 0, 0, 0, 0]", "base_to_first = [-803, 0, -305, 0, 180, 0]")
        text = text.replace("base_follows_table = true", "base_follows_table = false")
        return (
            "\n".join(line for line in text.splitlines() if not line.startswith(("base_template", "act_ex_ax"))) + "\n"
        )

    cell = make_cell(change)
    result = post(SAMPLE, cell=cell, out=tmp_path / "out", report=False)
    text = (tmp_path / "out" / "engraving.src").read_text()
    assert ",E1 " not in text and ",E2 " not in text
    assert result.summary.external_travel == {}
    assert verify(tmp_path / "out" / "engraving.src", cell=cell, against=SAMPLE).ok


def test_a_track_alone(make_cell, tmp_path):
    def change(text: str) -> str:
        text = _without(text, "E2")
        # the table's row moves into what stands before the chain: Tz(-305) Tx(803) Rx(90 deg) at theta = 180 degrees
        text = text.replace("base_to_first = [0, 0, 0, 0, 0, 0]", "base_to_first = [-803, 0, -305, 180, 0, 90]")
        text = text.replace("base_follows_table = true", "base_follows_table = false")
        return (
            "\n".join(line for line in text.splitlines() if not line.startswith(("base_template", "act_ex_ax"))) + "\n"
        )

    cell = make_cell(change)
    machine, whole = read_cell(cell), read_cell(KR15)
    assert machine.external_names == ("E1",)
    from camrob.kinematics.frames import base_T_tool

    q = whole.q_home
    assert np.allclose(base_T_tool(machine, q[1:]), base_T_tool(whole, q), atol=1e-12)
    result = post(SAMPLE, cell=cell, out=tmp_path / "out", report=False)
    assert set(result.summary.external_travel) == {"E1_mm"}


def test_an_arm_without_a_spherical_wrist(make_cell, tmp_path):
    """Axis 5 moved 40 mm off: no closed form, so the numeric arm serves the solver, the replay and verify."""

    def change(text: str) -> str:
        old = 'name = "A4"\nrole = "arm"\ntype = "revolute"\ndh = { alpha_deg = 90, a_mm = 0,'
        assert old in text
        return text.replace(old, old.replace("a_mm = 0", "a_mm = 40"))

    cell = make_cell(change)
    shutil.copytree(SAMPLE.parent, tmp_path / "in")
    clfile = tmp_path / "in" / "engraving.cls"
    clfile.write_text("".join(SAMPLE.open().readlines()[:23]) + "END-OF-PATH\n")  # its first letter
    result = post(clfile, cell=cell, out=tmp_path / "out", report=False)
    assert result.summary.verified.position_error_mm_max < 0.002
    text = (tmp_path / "out" / "engraving.src").read_text()
    assert "PTP {E6POS" not in text and "PTP {E6AXIS" in text  # KUKA defines no Status for such an arm
    assert verify(tmp_path / "out" / "engraving.src", cell=cell, against=clfile).ok


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("method", ["vjm", "planned"])
def test_the_rolls_name_is_nobodys_business(make_cell, tmp_path, method):
    """A joint is the roll by its role: called otherwise, even like another axis's kin, the program is the same."""
    cell = make_cell(lambda text: text.replace('name = "roll"', 'name = "A_spin"'), poses=True)
    assert read_cell(cell).axis_names == read_cell(KR15).axis_names
    for folder, out in ((KR15, "a"), (cell, "b")):
        post(SAMPLE, cell=folder, out=tmp_path / out, report=False, method=method)
    one, two = ((tmp_path / out / "engraving.src").read_bytes() for out in ("a", "b"))
    assert one == two
    assert verify(tmp_path / "b" / "engraving.src", cell=cell, against=SAMPLE).ok
