"""Rapids of the file through stock that nothing has cut: said first of all; sound files raise no alarm."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
import trimesh
from process_story import KR15, ROOT, posted

from camrob.cell.read_setup import read_setup
from camrob.checks.rapids import rapids_in_stock
from camrob.jobs.files.cell_for import cell_for
from camrob.jobs.files.granted import taken_for_granted
from camrob.jobs.files.inputs import read_inputs
from camrob.toolpath.read import read_toolpath
from camrob.units import mm_to_m

HEAD = "UNITS/MM\nLOADTL/1\nSPINDL/3000,RPM,CLW\nFEDRAT/500,MMPM\n"
END = "SPINDL/OFF\nFINI\n"
SETUP = """part_in_base = [0, 0, 198, 0, 0, 0]
[tool]
diameter_mm = 6
[stock]
box_mm = [-20, -20, -30, 60, 60, 0]
"""
BOX = mm_to_m(np.array([[-20.0, -20.0, -30.0], [60.0, 60.0, 0.0]]))
SLOT = "RAPID\nGOTO/0,0,20\nGOTO/0,0,-25\nGOTO/30,0,-25\n"
OUT = "RAPID\nGOTO/30,0,20\n"
DRILL = "CYCLE/DRILL,FEDTO,12,RAPTO,{rapto},RTRCTO,20,MMPM,300\nGOTO/10,10,0\nCYCLE/OFF\nRAPID\nGOTO/0,0,20\n"
DEEP = "CYCLE/DEEP,FEDTO,20,STEP,3,RAPTO,2,RTRCTO,10,MMPM,300\nGOTO/40,40,0\nCYCLE/OFF\n" + OUT
CASES = {  # motions, line of the first alarm (0: none), how many motions, how deep
    "down at the feed, out in rapid": (SLOT + OUT, 0, 0, 0.0),
    "RAPID, and only then FEDRAT": ("RAPID\nGOTO/0,0,20\nRAPID\nGOTO/0,0,-5\nGOTO/30,0,-5\n" + OUT, 8, 1, 5.0),
    "the first motion": ("RAPID\nGOTO/0,0,-5\nGOTO/30,0,-5\n" + OUT, 6, 1, 5.0),
    "across at depth": ("RAPID\nGOTO/0,0,20\nGOTO/0,0,-5\nRAPID\nGOTO/30,0,-5\nGOTO/40,0,-5\n" + OUT, 9, 1, 5.0),
    "back through the slot": (SLOT + "RAPID\nGOTO/5,0,-25\nRAPID\nGOTO/5,0,20\n", 0, 0, 0.0),
    "down into the slot again": (
        SLOT + OUT + "RAPID\nGOTO/9,1,20\nRAPID\nGOTO/9,1,-20\nGOTO/9,1,-25\n" + OUT,
        0,
        0,
        0.0,
    ),
    "down beside the slot": (
        SLOT + OUT + "RAPID\nGOTO/9,30,20\nRAPID\nGOTO/9,30,-20\nGOTO/9,30,-25\n" + OUT,
        14,
        2,
        15.0,
    ),
    "beside the stock": ("RAPID\nGOTO/-40,0,20\nRAPID\nGOTO/-40,0,-25\nGOTO/30,0,-25\n" + OUT, 0, 0, 0.0),
    "holes": ("RAPID\nGOTO/0,0,20\n" + DRILL.format(rapto=3) + DEEP, 0, 0, 0.0),
    "RAPTO below the surface": ("RAPID\nGOTO/0,0,20\n" + DRILL.format(rapto=-6), 8, 1, 6.0),
}


@pytest.mark.parametrize("case", CASES)
def test_rapids_through_what_is_not_cut(tmp_path: Path, case: str) -> None:
    way, line, count, depth = CASES[case]
    file = tmp_path / "part.apt"
    file.write_text(HEAD + way + END)
    found = rapids_in_stock(read_toolpath(file).regions, BOX, mm_to_m(6.0))
    if not line:
        assert found is None
    else:
        assert found is not None and (found.line, found.count) == (line, count) and f"{depth:.1f} mm deep" in found.text


@pytest.mark.parametrize("case", CASES)
def test_a_meshed_stock_is_judged_as_its_box(tmp_path: Path, case: str) -> None:
    """The same block as a mesh; what is deep is known to a ray's pitch."""
    way, line, count, depth = CASES[case]
    file = tmp_path / "part.apt"
    file.write_text(HEAD + way + END)
    (tmp_path / "stock.stl").write_bytes(trimesh.creation.box(bounds=1e3 * BOX).export(file_type="stl"))
    (tmp_path / "setup.toml").write_text(
        'part_in_base = [0, 0, 198, 0, 0, 0]\n[tool]\ndiameter_mm = 6\n[stock]\nmesh = "stock.stl"\n'
    )
    said = [f for f in read_inputs(file, cell_for("post", KR15), None).urgent if f.code == "rapid-in-stock"]
    assert [(f.line, f.count) for f in said] == [(line, count)] * bool(line)
    assert not said or f"{depth:.0f}." in said[0].text


def test_above_the_lower_step_of_a_meshed_stock_there_is_air(tmp_path: Path) -> None:
    """The box round it is full there, the stock is not."""
    foot, back = [[-20, -20, -30], [60, 60, -20]], [[-20, -20, -20], [0, 60, 0]]
    step = trimesh.util.concatenate([trimesh.creation.box(bounds=b) for b in (foot, back)])
    triangles = mm_to_m(np.asarray(step.triangles))
    for x, alarm in ((30.0, False), (-10.0, True)):
        file = tmp_path / "part.apt"
        file.write_text(
            f"{HEAD}RAPID\nGOTO/{x},20,20\nRAPID\nGOTO/{x},20,-18\nGOTO/{x},20,-19\nRAPID\nGOTO/{x},20,20\n{END}"
        )
        (tmp_path / "setup.toml").write_text('part_in_base = [0, 0, 198, 0, 0, 0]\n[stock]\nmesh = "stock.stl"\n')
        (tmp_path / "stock.stl").write_bytes(step.export(file_type="stl"))
        cell = cell_for("post", KR15)
        found = taken_for_granted(cell, read_setup(tmp_path / "setup.toml", cell), read_toolpath(file), triangles)
        assert ("rapid-in-stock" in [f.code for f in found]) is alarm


@pytest.mark.parametrize(
    ("way", "within"),
    [
        (CASES["across at depth"][0], True),
        (SLOT + OUT, True),
        ("RAPID\nGOTO/0,0,20\nGOTO/0,0,-5\nGOTO/30,0,-5\nGOTO/30,0,20\nRAPID\nGOTO/0,0,20\n", False),
    ],
)
def test_of_a_mesh_with_a_hole_it_is_said_that_rapids_are_not_judged(tmp_path: Path, way: str, within: bool) -> None:
    """Unless no rapid comes into its box."""
    file = tmp_path / "part.apt"
    file.write_text(HEAD + way + END)
    block = trimesh.creation.box(bounds=1e3 * BOX)
    top = np.all(np.isclose(block.triangles[:, :, 2], 0.0), axis=1)
    block.update_faces(~top)
    (tmp_path / "stock.stl").write_bytes(block.export(file_type="stl"))
    (tmp_path / "setup.toml").write_text('part_in_base = [0, 0, 198, 0, 0, 0]\n[stock]\nmesh = "stock.stl"\n')
    said = [f.code for f in read_inputs(file, cell_for("post", KR15), None).urgent if f.code.startswith("rapid")]
    assert said == ["rapids-not-judged"] * within


def test_it_is_said_first_and_the_program_is_the_files(tmp_path: Path) -> None:
    made = posted(tmp_path, "part.apt", HEAD + CASES["across at depth"][0] + END, setup=SETUP)
    assert made.summary.warnings[0].code == "rapid-in-stock" and made.summary.warnings[0].line == 9
    (tmp_path / "without").mkdir()
    bare = posted(tmp_path / "without", "part.apt", HEAD + CASES["across at depth"][0] + END)
    assert "rapid-in-stock" not in [w.code for w in bare.summary.warnings]


@pytest.mark.parametrize("name", ["engraving", "carving", "relief", "globe"])
def test_the_samples_raise_no_alarm(name: str) -> None:
    inputs = read_inputs(ROOT / "toolpaths" / name / f"{name}.cls", cell_for("post", KR15), None)
    assert "rapid-in-stock" not in [f.code for f in inputs.urgent]
