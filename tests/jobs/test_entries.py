"""`entries` of a cell: a program for the rest of a job from each operation on, each judged as a program of its own."""

from __future__ import annotations

import shutil
from pathlib import Path

import pytest
from process_story import PART, TWO_TOOLS, cell_with, posted
from rapid_job import CELL as RAPID_CELL
from rapid_job import write_job

import camrob
from camrob.errors import ToolpathError, VerificationError
from camrob.jobs.post import PostResult, _entry_name
from camrob.jobs.verify import verify
from camrob.languages import language_named
from camrob.toolpath.read import read_toolpath
from camrob.toolpath.region import EventKind
from camrob.toolpath.rest import beginnings, rest_from
from camrob.witness.judge import judge

OPTION = (r"^spindle_rpm = ", "entries = true\nspindle_rpm = ")
SECOND, THIRD = 12, 19  # the lines in which the second and the third tool begin


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> PostResult:
    folder = tmp_path_factory.mktemp("entries")
    return posted(folder, "part.nc", PART, setup=TWO_TOOLS, cell=cell_with(folder, OPTION))


def against(made: PostResult, name: str, begin: int, change=lambda text: text) -> list[str]:
    """What the witness has against one of the programs."""
    source = made.out.parent / "in" / "part.nc"
    program = made.out / name
    text = program.read_text()
    program.write_text(change(text), newline="")
    try:
        found = judge(program, made.out.parent / "cell", clfile=source, setup=source.parent / "setup.toml", begin=begin)
    finally:
        program.write_text(text, newline="")
    codes = [o.code for o in found.errors]
    assert found.complete or codes
    return codes


def test_each_operation_has_a_program_for_the_rest(made: PostResult) -> None:
    names = [file for file in made.files if file.endswith(".src")]
    assert names == ["part.src", "part_E02.src", "part_E03.src"]
    said = [(f.line, f.text) for f in made.findings if f.code == "entry"]
    assert [line for line, _ in said] == [SECOND, THIRD] and "part_E02" in said[0][1]
    for name, rpm, tool in (("part_E02", "4000", 2), ("part_E03", "3500", 1)):
        text = (made.out / f"{name}.src").read_text()
        assert f"DEF {name} ( )" in text and rpm in text and f"change to tool {tool}" in text


def test_the_witness_judges_each_as_a_program_of_its_own(made: PostResult) -> None:
    assert against(made, "part.src", 0) == []
    assert against(made, "part_E02.src", SECOND) == against(made, "part_E03.src", THIRD) == []
    assert (
        against(made, "part_E02.src", 0) and against(made, "part_E02.src", THIRD) and against(made, "part.src", SECOND)
    )
    still = against(made, "part_E02.src", SECOND, lambda text: text.replace("4000", "4100"))
    assert still
    cut = [line for line in (made.out / "part_E03.src").read_text().splitlines() if line.startswith("LIN")][2]
    assert against(made, "part_E03.src", THIRD, lambda text: text.replace(cut + "\n", "", 1))


def test_two_entries_of_one_name_are_no_two_programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever gives them their names: one would lie there as the other, the operations between them left out."""
    monkeypatch.setattr("camrob.jobs.post._entry_name", lambda title, *_: f"{title}_E02")
    with pytest.raises(VerificationError, match="two of the job's programs are written into part_E02"):
        posted(tmp_path, "part.nc", PART, setup=TWO_TOOLS, cell=cell_with(tmp_path, OPTION))


def test_verify_takes_the_line(made: PostResult) -> None:
    source = made.out.parent / "in" / "part.nc"
    assert verify(made.out / "part_E02.src", cell=made.out.parent / "cell", against=source, begin=SECOND).ok
    assert verify(made.out / "part_E02.src", cell=made.out.parent / "cell", against=source).ok is False
    with pytest.raises(ToolpathError, match="no operation that can be entered begins in line 5"):
        verify(made.out / "part_E02.src", cell=made.out.parent / "cell", against=source, begin=5)


CL = """UNITS/MM
TOOL PATH/A,TOOL,MILL
LOADTL/3
SPINDL/2000,RPM,CLW
COOLNT/ON
RAPID
GOTO/0,0,20
FEDRAT/300,MMPM
GOTO/0,0,0
GOTO/9,0,0
RAPID
GOTO/9,0,20
END-OF-PATH
TOOL PATH/B,TOOL,MILL
STOP
RAPID
GOTO/5,5,20
GOTO/5,5,0
COOLNT/OFF
GOTO/9,5,0
RAPID
GOTO/9,5,20
END-OF-PATH
FINI
"""


def test_tool_spindle_and_coolant_are_what_they_were(tmp_path: Path) -> None:
    file = tmp_path / "part.cls"
    file.write_text(CL)
    toolpath = read_toolpath(file)
    assert beginnings(toolpath) == [(17, "B")]
    (region,) = rest_from(toolpath, 17).regions
    begun = [(e.kind, e.value) for e in region.events if e.point == 0 and e.kind is not EventKind.MESSAGE]
    assert begun == [(EventKind.TOOL_CHANGE, 3), (EventKind.SPINDLE_ON, 2000), (EventKind.COOLANT_ON, 0)]
    assert [e.kind for e in region.events if e.point] == [EventKind.COOLANT_OFF]
    assert (region.position[0] * 1e3).tolist() == [5, 5, 20]


CHANGED = "LOADTL/4\nSPINDL/3000,RPM,CLW\n"


@pytest.mark.parametrize(
    ("head", "begun"),
    [
        (CHANGED, ["tool_change", "spindle_on", "coolant_on"]),  # a change of tools ends no coolant
        (CHANGED + "COOLNT/OFF\n", ["tool_change", "spindle_on"]),  # nothing is on that it could switch off
        ("SPINDL/OFF\nCOOLNT/OFF\n" + CHANGED + "COOLNT/ON\n", ["tool_change", "spindle_on", "coolant_on"]),
        ("SPINDL/2500,RPM,CLW\nCOOLNT/OFF\nCOOLNT/ON\n", ["tool_change", "spindle_on", "coolant_on"]),
        ("COOLNT/OFF\n", ["tool_change", "spindle_on"]),
    ],
)
def test_an_entry_begins_with_what_is_on_there(tmp_path: Path, head: str, begun: list[str]) -> None:
    file = tmp_path / "part.cls"
    text = CL.replace("TOOL PATH/B,TOOL,MILL\nSTOP\n", "TOOL PATH/B,TOOL,MILL\n" + head)
    file.write_text(text.replace("TOOL PATH/B,TOOL,MILL", "TOOL PATH/B,TOOL,BALL") if "LOADTL" in head else text)
    toolpath = read_toolpath(file)
    (region,) = rest_from(toolpath, beginnings(toolpath)[0][0]).regions
    assert sorted(e.kind.value for e in region.events if e.point == 0) == sorted(begun)
    assert region.events[0].kind is EventKind.TOOL_CHANGE


def test_a_subprogram_that_comes_back_is_no_place_to_enter(tmp_path: Path) -> None:
    file = tmp_path / "part.nc"
    hole = "O7\nG0 X5. Y5. Z20.\nG1 Z0. F60.\nG0 Z20.\nM99\n"
    body = "T1 M6\nS3000 M3\nG0 X0. Y0. Z20.\nM98 P7\nT2 M6\nS3000 M3\nM98 P7\nM30\n" + hole
    file.write_text("%\nO1\nG21 G90 G17\n" + body + "%\n")
    assert beginnings(read_toolpath(file)) == []


@pytest.mark.parametrize("language", ["krl", "rapid"])
def test_no_entry_takes_anothers_name(language: str) -> None:
    names = [_entry_name("a_name_of_four_and_twenty", number, language_named(language)) for number in range(2, 1200)]
    assert len(set(names)) == len(names) and names[0].endswith("_E02") and names[-1].endswith("_E1199")
    assert max(map(len, names)) <= 24


def test_a_rapid_program_that_is_split_has_entries_too(tmp_path: Path) -> None:
    cell = tmp_path / "cell"
    shutil.copytree(RAPID_CELL, cell)
    text = (cell / "cell.toml").read_text(encoding="utf-8")
    (cell / "cell.toml").write_text(
        text.replace("[controller]\n", "[controller]\nentries = true\n", 1), encoding="utf-8"
    )
    job = write_job(tmp_path / "in")
    made = camrob.post(job, cell=cell, out=tmp_path / "out", max_lines=4, report=False)
    begin = next(f.line for f in made.findings if f.code == "entry")
    assert {"part_001.mod", "part_E02.mod", "part_E02.pgf", "part_E02_001.mod"} <= set(made.files)
    assert verify(made.out / "part.mod", cell=cell, against=job).ok
    assert verify(made.out / "part_E02.mod", cell=cell, against=job, begin=begin).ok
    assert verify(made.out / "part_E02.mod", cell=cell, against=job).ok is False
