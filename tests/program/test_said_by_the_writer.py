"""What the writer says and leaves unsaid: posture revisions have words of their own, a measured load is not written over."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import pytest

import camrob
from camrob.errors import CellError

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
PART = """PARTNO/A
UNITS/MM
SPINDL/6000,RPM,CLW
FEDRAT/500,MMPM
RAPID
GOTO/0,0,40,0,0,1
GOTO/0,0,0
GOTO/40,0,0
RAPID
GOTO/40,0,40
FINI
"""
SETUP = """part_in_base = [0, 0, 200, 0, 0, 0]
[tool]
diameter_mm = 6
length_mm = 80
mass_kg = 6
center_of_mass_mm = [0, 0, 120]
"""


def test_a_posture_revision_says_what_moves() -> None:
    """The golden program's own numbers: the same place before and after, and the table from the one angle to the other."""
    lines = (ROOT / "toolpaths" / "globe" / "golden" / "globe.src").read_text(encoding="ascii").splitlines()
    said = [k for k, line in enumerate(lines) if line.startswith("; posture revision, the tip stays: E2 ")]
    assert said
    for k in said:
        before = next(line for line in reversed(lines[:k]) if line.startswith(("LIN", "PTP {E6POS")))
        behind = [line for line in lines[k + 1 : k + 3] if line.startswith("LIN")]
        e2 = [float(re.search(r"E2 ([-\d.]+)", line)[1]) for line in (before, behind[0])]  # type: ignore[index]
        z = [re.search(r"Z ([-\d.]+)", line)[1] for line in (before, behind[0])]  # type: ignore[index]
        assert z[0] == z[1] and lines[k].endswith(f"E2 {e2[0]:.1f} to {e2[1]:.1f}")


def posted(folder: Path, lines: str) -> str:
    """The program's text on the KR15 cell with lines in [controller]; it has to be verified whole."""
    shutil.copytree(KR15, folder / "cell")
    toml = folder / "cell" / "cell.toml"
    toml.write_text(toml.read_text().replace("act_ex_ax = 2", f"act_ex_ax = 2\n{lines}"))
    (folder / "part.apt").write_text(PART)
    (folder / "setup.toml").write_text(SETUP)
    camrob.post(folder / "part.apt", cell=folder / "cell", out=folder / "out", report=False)
    program = folder / "out" / "part.src"
    assert camrob.verify(program, cell=folder / "cell", against=folder / "part.apt").ok is True
    return program.read_text(encoding="ascii")


def test_a_load_that_the_controller_measured_is_not_written_over(tmp_path: Path) -> None:
    assert "$LOAD = {M 6.000" in posted(tmp_path / "plain", "tool_number = 3")
    measured = posted(tmp_path / "measured", "tool_number = 3\nload_measured = true")
    assert "$LOAD" not in measured and "BAS (#TOOL,3 )" in measured


@pytest.mark.parametrize(
    "lines", ["load_measured = true", 'load_measured = true\ntool_number = 3\nbase_number = 2\nnumbering = "act"']
)
def test_a_load_that_nothing_activates_is_refused(tmp_path: Path, lines: str) -> None:
    with pytest.raises(CellError, match="load_measured"):
        posted(tmp_path / "cell", lines)


@pytest.mark.parametrize(("later", "codes"), [("$TOOL = {X 0,Y 0,Z 100,A 0,B 0,C 0}", set()), ("", {"tool-unknown"})])
def test_a_frame_by_number_that_nothing_uses_is_no_warning(tmp_path: Path, later: str, codes: set[str]) -> None:
    program = tmp_path / "p.src"
    program.write_text(
        f"DEF p ( )\nBAS (#TOOL,1 )\nBAS (#BASE,1 )\n{later}\n$BASE = {{X 0,Y 0,Z 0,A 0,B 0,C 0}}\n"
        "PTP {A1 0,A2 -90,A3 90,A4 0,A5 10,A6 0}\nEND\n"
    )
    assert {f.code for f in camrob.read_program(program).findings} == codes
