"""[[clamping]]: a part that is worked from two sides gets a program for each, and no line of its file is in none or in both."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from process_story import KR15
from scipy.spatial.transform import Rotation

import camrob
from camrob.errors import CamrobError, InputError, JobError, VerificationError
from camrob.jobs.verify import verify
from camrob.witness.judge import judge

PART = """UNITS/MM
TOOL PATH/TOP,TOOL,MILL
LOADTL/1
MULTAX/ON
SPINDL/2000,RPM,CLW
COOLNT/ON
RAPID
GOTO/0,0,40,0,0,1
FEDRAT/300,MMPM
GOTO/0,0,20
GOTO/30,0,20
RAPID
GOTO/30,0,40
COOLNT/OFF
END-OF-PATH
TOOL PATH/BOTTOM,TOOL,MILL
RAPID
GOTO/10,5,-40,0,0,-1
FEDRAT/250,MMPM
GOTO/10,5,0
GOTO/20,15,0
RAPID
GOTO/20,15,-40
SPINDL/OFF
END-OF-PATH
FINI
"""
SETUP = """[[clamping]]
name = "top"
lines = [1, 15]
part_in_base = [0, 0, 198, 0, 0, 0]
[[clamping]]
name = "bottom"
lines = [16, 26]
part_in_base = [40, 10, 198, 90, 0, 180]
"""
# mm: X, Y, Z of the file's points in `base`, by hand: turned over and by 90 degrees about Z, x goes to Y and y to X
ON_TOP = [[0, 0, 238], [0, 0, 218], [30, 0, 218], [30, 0, 238]]
TURNED_OVER = [[45, 20, 238], [45, 20, 198], [55, 30, 198], [55, 30, 238]]
_TARGET = re.compile(r"(?:LIN|PTP) \{E6POS: X (\S+),Y (\S+),Z (\S+),A (\S+),B (\S+),C ([^,\s]+)")


def job(folder: Path, setup: str = SETUP, part: str = PART) -> Path:
    folder.mkdir(exist_ok=True)
    (folder / "part.cls").write_text(part)
    (folder / "setup.toml").write_text(setup)
    return folder / "part.cls"


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> camrob.PostResult:
    folder = tmp_path_factory.mktemp("clampings")
    return camrob.post(job(folder / "in"), cell=KR15, out=folder / "out", report=False)


def visited(program: Path, points: list[list[float]]) -> bool:
    """Whether the targets of a program's text are these points, in order, among others in the clear, from straight above."""
    rows = np.array([[float(v) for v in row] for row in _TARGET.findall(program.read_text())])
    at = 0
    for row in rows:
        upright = Rotation.from_euler("ZYX", row[3:], degrees=True).apply([0, 0, 1])
        assert upright[2] > 1.0 - 1e-9
        if at < len(points) and np.allclose(row[:3], points[at], atol=1e-3):
            at += 1
        else:
            assert row[2] > 230.0  # nothing else goes down to the part
    return at == len(points)


def test_a_program_for_each_side(made: camrob.PostResult) -> None:
    names = ["part_top", "part_bottom"]
    assert [made.summary.program, *(other.summary.program for other in made.others)] == names
    assert visited(made.out / "part_top.src", ON_TOP) and visited(made.out / "part_bottom.src", TURNED_OVER)
    assert not (made.out / "part.src").exists()
    for name, side, first, last in zip(names, ("top", "bottom"), (1, 16), (15, 26), strict=True):
        summary = json.loads((made.out / f"{name}.json").read_text())
        assert summary["clamping"] == side and [c["program"] for c in summary["clampings"]] == names
        assert summary["witness"]["complete"] and summary["witness"]["judged_points"] == summary["points"] == 4
        assert set(summary["manifest"]["program"]) == {f"{name}.src", f"{name}.dat"}
        text = (made.out / f"{name}.src").read_text()
        assert f"clamping {side}, lines {first} to {last}" in text
        assert text.count("$OUT[1] = TRUE") == 1 and text.rindex("$OUT[1] = FALSE") > text.index("$OUT[1] = TRUE")
        assert ("$OUT[2] = TRUE" in text) == (
            side == "top"
        )  # the file has switched the coolant off before the other side


def test_each_is_judged_against_its_own_part_of_the_file(made: camrob.PostResult, tmp_path: Path) -> None:
    source = made.out.parent / "in" / "part.cls"
    for own, other in (("top", "bottom"), ("bottom", "top")):
        program = made.out / f"part_{own}.src"
        assert verify(program, cell=KR15, against=source, clamping=own).ok
        assert verify(program, cell=KR15, against=source, clamping=other).ok is False
    with pytest.raises(InputError, match="none is named; name one of top, bottom"):
        verify(made.out / "part_top.src", cell=KR15, against=source)
    lain = job(tmp_path / "lain", SETUP.replace("90, 0, 180", "90, 0, 179.9"))
    program = made.out / "part_bottom.src"
    found = judge(program, KR15, clfile=lain, setup=lain.with_name("setup.toml"), clamping="bottom")
    assert found.errors
    longer = job(tmp_path / "longer", part=PART.replace("GOTO/20,15,0\n", "GOTO/20,15,0\nGOTO/20,16,0\n"))
    setup = tmp_path / "longer.toml"
    setup.write_text(SETUP.replace("26]", "27]"))
    assert judge(program, KR15, clfile=longer, setup=setup, clamping="bottom").errors


@pytest.mark.parametrize(
    ("change", "error"),
    [
        (("[16, 26]", "[19, 26]"), r"part\.cls:18: BOTTOM moves the tool and lies in no clamping; there are: top 1-15"),
        (("[1, 15]", "[1, 18]"), "lines 16-18 lie in two, top and bottom"),
        (("[1, 15]", "[1, 12]"), r"part\.cls:13: TOP moves the tool and lies in no clamping"),
        (("[1, 15]\n", "[1, 11]\n") , "TOP"),
        (('"bottom"', '"Top"'), "appears twice"),
        (('"bottom"', '"the other side"'), "give 1 to 8 letters and digits"),
        (("[16, 26]", "[16.5, 26]"), "are no lines of a file"),
        (("[[clamping]]", "part_in_base = [0, 0, 198, 0, 0, 0]\n[[clamping]]"), "stands beside"),
        (("part_in_base = [0, 0, 198, 0, 0, 0]\n", ""), "part_in_base: is missing"),
        (("[16, 26]", "[16, 17]"), "lies in no clamping"),
    ],
)  # fmt: skip
def test_what_is_refused(tmp_path: Path, change: tuple[str, str], error: str) -> None:
    with pytest.raises(InputError, match=error):
        camrob.post(job(tmp_path / "in", SETUP.replace(*change, 1)), cell=KR15, out=tmp_path / "out", report=False)
    assert not (tmp_path / "out").exists()


def test_an_operation_is_not_cut_in_two(tmp_path: Path) -> None:
    setup = SETUP.replace("[1, 15]", "[1, 10]").replace("[16, 26]", "[11, 26]")
    with pytest.raises(InputError, match="TOP, from line 8 on, lies in clampings top and bottom"):
        camrob.post(job(tmp_path / "in", setup), cell=KR15, out=tmp_path / "out", report=False)


def test_the_witness_finds_a_line_in_no_clamping_by_itself(made: camrob.PostResult, tmp_path: Path) -> None:
    source = job(tmp_path / "in", SETUP.replace("[16, 26]", "[20, 26]"))
    with pytest.raises(InputError, match="line 18 moves the tool in no clamping"):
        judge(made.out / "part_top.src", KR15, clfile=source, clamping="top")


def test_nothing_is_left_where_one_side_can_not_be_done(tmp_path: Path) -> None:
    source = job(tmp_path / "in", SETUP.replace("90, 0, 180", "90, 0, 0"))
    with pytest.raises(JobError):
        camrob.post(source, cell=KR15, out=tmp_path / "out", report=False)
    assert not (tmp_path / "out").exists()


def test_a_second_side_is_asked_for(tmp_path: Path) -> None:
    source = job(tmp_path / "in", "part_in_base = [0, 0, 198, 0, 0, 0]\n")
    with pytest.raises(CamrobError) as refused:
        camrob.post(source, cell=KR15, out=tmp_path / "out", report=False)
    text = str(refused.value)
    assert "BOTTOM (line 18) comes from below the part and others don't" in text
    asked = re.search(r"clamping = \[\{.*?\}\]", text)
    assert asked is not None
    places = iter(("[0, 0, 198, 0, 0, 0]", "[40, 10, 198, 90, 0, 180]"))
    copied = re.sub(r"\[X, Y, Z, A, B, C[^]]*\]", lambda _: next(places), asked[0])
    made = camrob.post(job(tmp_path / "again", copied + "\n"), cell=KR15, out=tmp_path / "out", report=False)
    assert [made.summary.program, made.others[0].summary.program] == ["part_side1", "part_side2"]
    assert visited(tmp_path / "out" / "part_side2.src", TURNED_OVER)


def test_two_clampings_of_one_name_are_no_two_programs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Whatever gives them their names: the second side's program would lie there alone."""
    monkeypatch.setattr("camrob.jobs.post._clamping_name", lambda title, *_: title)
    with pytest.raises(VerificationError, match=r"two of the job's programs are written into part\.src"):
        camrob.post(job(tmp_path / "in"), cell=KR15, out=tmp_path / "out", report=False)
    assert not list((tmp_path / "out").glob("*.src"))
