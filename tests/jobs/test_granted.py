"""What nobody said is said first: no set-up, a part placed in metres, a cell without bodies."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from camrob import PostResult, post
from camrob.bodies.meshes import body_triangles
from camrob.cell.read_cell import read_cell
from camrob.cell.read_setup import read_setup
from camrob.errors import JobError
from camrob.jobs.files.granted import assumed_limits, taken_for_granted
from camrob.jobs.verify import verify
from camrob.toolpath.read import read_toolpath

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"
MILL = '[tool]\nname = "mill"\n'


def posted(folder: Path, setup: str | None, cell: Path = KR15) -> PostResult:
    shutil.copy(SAMPLE, folder)
    if setup is not None:
        (folder / "setup.toml").write_text(setup, encoding="utf-8")
    return post(folder / SAMPLE.name, cell=cell, out=folder / "out", report=False)


def codes(result: PostResult) -> list[str]:
    return [w.code for w in result.summary.warnings]


def test_no_set_up_is_the_first_warning(tmp_path: Path) -> None:
    result = posted(tmp_path, None)
    assert codes(result)[0] == "no-setup" and "assumed-limits" in codes(result)
    text = result.summary.warnings[0].text
    for said in (
        "the part's frame is taken for base itself",
        "(X 0.000 Y -41.764 Z 415.578 A 0.000 B 0.000 C -159.580)",
        "neither part nor stock",
        "write setup.toml beside the CL file",
    ):
        assert said in text
    program = tmp_path / "out" / "engraving.src"
    first = verify(program, cell=KR15, against=tmp_path / SAMPLE.name).summary.warnings[0]
    assert first.code == "no-setup"


def test_a_set_up_however_short_is_one(tmp_path: Path) -> None:
    assert "no-setup" not in codes(posted(tmp_path, "part_in_base = [0, 0, 200, 0, 0, 0]\n"))


def test_a_set_up_without_a_tool_says_which_tool_stands_in_for_it(tmp_path: Path) -> None:
    bare = "part_in_base = [0, 0, 200, 0, 0, 0]\n"
    (warning,) = [w for w in posted(tmp_path, bare).summary.warnings if w.code == "tool-unsaid"]
    assert "setup.toml says nothing of the tool" in warning.text
    assert "(X 0.000 Y -41.764 Z 415.578 A 0.000 B 0.000 C -159.580)" in warning.text
    assert "tool-unsaid" not in codes(posted(tmp_path, bare + MILL))


def test_inches_of_a_path_that_its_stock_bears_out_are_not_doubted(tmp_path: Path) -> None:
    """Foam of 2 m by 0.8 m, drawn in inches; and a file in mm that is read as inches, on its own small blank."""
    rows = "".join(f"G1 X{x:.3f} Y{y:.3f} F100\n" for y in (0, 10, 30) for x in (0, 40, 80))
    (tmp_path / "foam.nc").write_text(f"G20 G90 G17\nT1 M6\nS9000 M3\nG0 X0 Y0 Z1\nG1 Z-1 F50\n{rows}M30\n")
    for box, doubted in (("-10, -10, -60, 2040, 800, 0", False), ("-1, -1, -2, 81, 31, 0", True), ("", True)):
        stock = f"[stock]\nbox_mm = [{box}]\n" if box else ""
        (tmp_path / "setup.toml").write_text(f"part_in_base = [0, 0, 60, 0, 0, 0]\n{stock}", encoding="utf-8")
        cell = read_cell(KR15)
        setup = read_setup(tmp_path / "setup.toml", cell)
        mesh = None if setup.stock is None else body_triangles(setup.stock)
        found = taken_for_granted(cell, setup, read_toolpath(tmp_path / "foam.nc"), mesh)
        assert ("path-in-inches" in [f.code for f in found]) is doubted


def test_a_part_placed_in_metres_is_said_first(tmp_path: Path) -> None:
    result = posted(tmp_path, "part_in_base = [0, 0, 0.2, 0, 0, 0]\n")
    assert codes(result)[0] == "part-in-metres"
    text = result.summary.warnings[0].text
    assert "part_in_base = [0, 0, 0.2, ...] looks like metres" in text and "X, Y, Z are in mm" in text


@pytest.mark.slow(after=1)
@pytest.mark.parametrize(("place", "said"), [("0.2", True), ("2", False)])
def test_a_refusal_names_metres_as_its_likely_cause(tmp_path: Path, place: str, said: bool) -> None:
    """The part sinks into the table: what touches is said, and why that may be; no other place is sought for a likely slip."""
    deep = SAMPLE.read_text(encoding="utf-8").replace("-0.8000", "-180.0000")
    shutil.copy(SAMPLE.parent / "stock.stl", tmp_path)
    (tmp_path / "deep.cls").write_text(deep, encoding="utf-8")
    (tmp_path / "setup.toml").write_text(f"part_in_base = [0, 0, {place}, 0, 0, 0]\n", encoding="utf-8")
    with pytest.raises(JobError) as caught:
        post(tmp_path / "deep.cls", cell=KR15, out=tmp_path / "out", report=False)
    assert str(caught.value).count("looks like metres") == said
    assert ("with the part moved" in str(caught.value)) is not said
    assert "line " in str(caught.value)
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    ("place", "suspect"),
    [
        ("0.2, 0, 0.15, 0, 0, 0", True),
        ("-0.803, 1.25, -0.305, 90, 0, 0", True),
        ("0, 0, 2.5, 0, 0, 0", True),
        ("0, 0, 0, 45, 0, 0", False),  # base itself
        ("0, 0, 2, 0, 0, 0", False),  # two sheets of a millimetre
        ("0, 0, 3.5, 0, 0, 0", False),
        ("0.5, 0, 200, 0, 0, 0", False),
        ("200, 100, 150, 0, 0, 0", False),
    ],
)
def test_what_looks_like_metres(tmp_path: Path, place: str, suspect: bool) -> None:
    """Not all whole, all below 3, and the path ten times as wide: the engraving is 224 mm wide."""
    (tmp_path / "setup.toml").write_text(f"part_in_base = [{place}]\n{MILL}", encoding="utf-8")
    cell = read_cell(KR15)
    found = taken_for_granted(cell, read_setup(tmp_path / "setup.toml", cell), read_toolpath(SAMPLE))
    assert [f.code for f in found] == ["part-in-metres"] * suspect


@pytest.mark.parametrize(("width", "suspect"), [(6.0, False), (60.0, True)])
def test_a_tiny_part_may_lie_at_a_tiny_offset(tmp_path: Path, width: float, suspect: bool) -> None:
    lines = ["UNITS/MM", "SPINDL/RPM,9000,CLW", "FEDRAT/MMPM,300", "GOTO/0,0,5", f"GOTO/{width},0,5", "FINI", ""]
    (tmp_path / "small.apt").write_text("\n".join(lines), encoding="utf-8")
    (tmp_path / "setup.toml").write_text(f"part_in_base = [0.6, 0, 2.5, 0, 0, 0]\n{MILL}", encoding="utf-8")
    cell = read_cell(KR15)
    setup = read_setup(tmp_path / "setup.toml", cell)
    found = taken_for_granted(cell, setup, read_toolpath(tmp_path / "small.apt"))
    assert [f.code for f in found] == ["part-in-metres"] * suspect


def test_a_cell_without_bodies_is_said_first(tmp_path: Path) -> None:
    cell = Path(shutil.copytree(KR15, tmp_path / "cell"))
    text = (cell / "cell.toml").read_text(encoding="utf-8")
    bare = "".join(b for b in re.split(r"(?m)^(?=\[)", text) if not b.startswith("[[shape]]"))
    (cell / "cell.toml").write_text(bare, encoding="utf-8")
    result = posted(tmp_path, "part_in_base = [0, 0, 200, 0, 0, 0]\n", cell)
    assert codes(result)[0] == "no-bodies"
    assert "the cell describes no bodies: collisions are not checked" in result.summary.warnings[0].text
    assert result.summary.collisions.checked is False
    (tmp_path / "setup.toml").unlink()
    assert codes(posted(tmp_path, None, cell))[:2] == ["no-setup", "no-bodies"]


def test_the_tool_and_the_part_alone_are_no_cell_that_was_checked(tmp_path: Path) -> None:
    """What they do to each other says nothing of collisions of the machine."""
    cell = Path(shutil.copytree(KR15, tmp_path / "cell"))
    text = (cell / "cell.toml").read_text(encoding="utf-8")
    (cell / "cell.toml").write_text("".join(b for b in re.split(r"(?m)^(?=\[)", text) if not b.startswith("[[shape]]")))
    low = "part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\ndiameter_mm = 3\nlength_mm = 80\n"
    low += "[part]\nbox_mm = [-100, -50, -30, 100, 50, 10]\n"
    assert posted(tmp_path, low, cell).summary.collisions.checked is False


@pytest.mark.parametrize(("z", "said"), [(0.0, False), (-0.5, False), (-10.0, True)])
def test_a_stock_below_the_tables_top_is_said(tmp_path: Path, z: float, said: bool) -> None:
    plate = np.array([[-0.12, -0.05, 0.0], [0.12, -0.05, 0.0], [0.12, 0.05, 0.02]])[None]
    cell = read_cell(KR15)
    for place, beside in ((f"0, 0, {z}, 0, 0, 0", False), (f"0, 250, {z}, 0, 0, 0", True)):
        (tmp_path / "setup.toml").write_text(f"part_in_base = [{place}]\n", encoding="utf-8")
        setup = read_setup(tmp_path / "setup.toml", cell)
        found = taken_for_granted(cell, setup, read_toolpath(SAMPLE), plate)
        assert ("part-in-table" in [f.code for f in found]) is (said and not beside)


@pytest.mark.parametrize(
    ("tool", "code"),
    [
        ("diameter_mm = 3\nlength_mm = 80\ncorner_radius_mm = 1.5", None),
        ("diameter_mm = 2.95\nlength_mm = 1.5", None),  # reground, and short
        ("diameter_mm = 3\nlength_mm = 0.08", "tool-in-metres"),
        ("diameter_mm = 6\nlength_mm = 80", "another-tool"),
        ("diameter_mm = 3\nlength_mm = 80\ncorner_radius_mm = 0.2", "another-tool"),
    ],
)
def test_a_tool_in_metres_or_not_the_files_is_said(tmp_path: Path, tool: str, code: str | None) -> None:
    """The file's is a ball of 3 mm."""
    (tmp_path / "setup.toml").write_text(f"part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\n{tool}\n", encoding="utf-8")
    cell = read_cell(KR15)
    found = taken_for_granted(cell, read_setup(tmp_path / "setup.toml", cell), read_toolpath(SAMPLE))
    assert [f.code for f in found] == ([code] if code else [])


@pytest.mark.parametrize(("scale", "aside", "said"), [(1.0, 0.0, False), (1e-3, 0.0, True), (1.0, 0.4, True)])
def test_a_stock_that_the_path_does_not_meet_is_said(tmp_path: Path, scale: float, aside: float, said: bool) -> None:
    plate = np.array([[-0.12, -0.05, 0.0], [0.12, -0.05, 0.0], [0.12, 0.05, 0.02]])[None]
    (tmp_path / "setup.toml").write_text(f"part_in_base = [0, 0, 200, 0, 0, 0]\n{MILL}", encoding="utf-8")
    cell = read_cell(KR15)
    setup = read_setup(tmp_path / "setup.toml", cell)
    found = taken_for_granted(cell, setup, read_toolpath(SAMPLE), scale * plate + [aside, 0.0, 0.0])
    assert [f.code for f in found] == ["stock-apart"] * said


def test_limits_that_are_partly_known_are_told_from_those_that_are_guessed(tmp_path: Path) -> None:
    """A data sheet prints ranges and speeds; accelerations and jerks stay a guess, and the warning says that much and no more."""
    shutil.copytree(KR15, tmp_path / "cell")
    file = tmp_path / "cell" / "cell.toml"
    kinds = {
        "range_deg": "datasheet",
        "speed_deg_s": "datasheet",
        "acceleration_deg_s2": "assumed",
        "jerk_deg_s3": "assumed",
    }
    known = f", standing = {{ {', '.join(f'{key} = {kind!r}' for key, kind in kinds.items())} }} }}"
    head, rest = file.read_text(encoding="utf-8").split('name = "A1"\n', 1)
    rest = rest.replace("jerk_deg_s3 = 3500 }", f"jerk_deg_s3 = 3500{known}", 1)
    file.write_text(f'{head}name = "A1"\n{rest}', encoding="utf-8")
    (said,) = assumed_limits(read_cell(tmp_path / "cell"))
    assert said.text.startswith("acceleration and jerk of A1; limits of A2, A3, A4, A5, A6, E1, E2 are assumed")
