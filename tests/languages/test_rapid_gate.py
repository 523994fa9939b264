"""The gate over RAPID: a whole post is released, every planted fault in its text is refused, every legal rewrite passes."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from rapid_job import CELL, write_job

from camrob import PostResult, post
from camrob.cell.read_cell import read_cell
from camrob.cell.status_turn import StatusTurn
from camrob.errors import CamrobError, CellError, ProgramError
from camrob.jobs.simulate import simulate
from camrob.jobs.verify import VerifyResult, verify
from camrob.kinematics.frames import base_T_flange

ROOT = Path(__file__).resolve().parents[2]


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> PostResult:
    folder = tmp_path_factory.mktemp("rapid")
    return post(write_job(folder), cell=CELL, out=folder / "out", report=False)


def judged(made: PostResult, text: str, folder: Path) -> VerifyResult:
    """The verdict on another text of the program."""
    for name in ("part.nc", "setup.toml"):
        shutil.copy(made.out.parent / name, folder / name)
    shutil.copy(made.out / "part.pgf", folder / "part.pgf")
    (folder / "part.mod").write_bytes(text.encode("latin-1"))
    against = folder / "part.nc"
    return verify(
        folder / "part.mod", cell=CELL, against=against, setup=folder / "setup.toml", collisions=False, manifest=False
    )


def source(made: PostResult) -> str:
    return (made.out / "part.mod").read_bytes().decode("ascii")


def test_the_gate_releases_it_whole(made: PostResult, tmp_path: Path) -> None:
    assert set(made.files) == {"part.mod", "part.pgf", "part.json", "part.path.npz"}
    assert made.summary.witness.complete and made.summary.witness.judged_events >= 8
    assert "the RAPID reader" in made.summary.verified.by
    assert set(made.summary.manifest.program) == {"part.mod", "part.pgf"}
    text = source(made)
    assert (
        text.count("PERS tooldata") == 2
        and "tload" not in text
        and text.count("Stop;") == 2
        and text.count("MoveC") == 1
    )
    assert judged(made, text, tmp_path).ok is True


def line_with(text: str, *parts: str) -> str:
    """The first line that has all these parts."""
    return next(line for line in text.split("\r\n") if all(part in line for part in parts))


def numbers(pattern: str, add: float, nth: int = 0) -> Callable[[str], str]:
    """Adds to the number that the pattern's group 1 finds, the nth time."""

    def change(text: str) -> str:
        found = list(re.finditer(pattern, text))[nth]
        decimals = len(found[1].partition(".")[2])
        return f"{text[: found.start(1)]}{float(found[1]) + add:.{decimals}f}{text[found.end(1) :]}"

    return change


def swap(old: str, new: str, nth: int = 0) -> Callable[[str], str]:
    """Replaces the nth occurrence of a text."""

    def change(text: str) -> str:
        parts = text.split(old)
        return old.join(parts[: nth + 1]) + new + old.join(parts[nth + 1 :])

    return change


def drop(*parts: str) -> Callable[[str], str]:
    """Leaves out the first line with these parts."""
    return lambda text: text.replace(line_with(text, *parts) + "\r\n", "", 1)


def behind(part: str, added: str) -> Callable[[str], str]:
    """Puts a line behind the first that has this part."""

    def change(text: str) -> str:
        line = line_with(text, part)
        return text.replace(line + "\r\n", f"{line}\r\n        {added}\r\n", 1)

    return change


def exchanged(first: str, second: str) -> Callable[[str], str]:
    """The first two lines that have these parts, one in place of the other."""

    def change(text: str) -> str:
        a, b = line_with(text, first), line_with(text, second)
        return text.replace(a, "\0", 1).replace(b, a, 1).replace("\0", b, 1)

    return change


CUT = r"MoveL \[\[-80\.000,-50\.000,202\.000\]"
FAULTS: dict[str, Callable[[str], str]] = {
    "a tool half a millimetre longer": numbers(r"t_part:=\[TRUE,\[\[165\.00000,0\.00000,(\S+?)\]", 0.5),
    "a tool that leans otherwise": swap("0.96592583,0.00000000,-0.25881905", "0.96480000,0.00000000,-0.26298500"),
    "a quaternion of the other hand": swap("0.96592583,0.00000000,-0.25881905", "0.96592583,0.00000000,0.25881905"),
    "a tool that stands": swap("t_part:=[TRUE", "t_part:=[FALSE"),
    "another load": numbers(r"\[(38\.500),", -10.0),
    "another centre of the load": numbers(r"38\.500,\[(40\.000)", 60.0),
    "the other tool": swap("fine,t_part", "fine,t2_part", 3),
    "a work object elsewhere": numbers(r"\[1,0,0,0\]\],\[\[(0\.00000),", 1.0),
    "a work object that stands": swap('FALSE,"STN1"', 'TRUE,""'),
    "a work object on another unit": swap('"STN1"', '"STN2"'),
    "a part that the robot holds": swap("[FALSE,FALSE,", "[TRUE,FALSE,"),
    "no work object": swap("\\WObj:=w_part", "", 4),
    "a target 0.05 mm off": numbers(r"MoveL \[\[(-80\.000),-50\.000,202\.000\]", 0.05),
    "a target off by a digit": numbers(r"MoveL \[\[-80\.000,-50\.000,(202\.000)\]", 1.0),
    "a tool that leans by a degree": lambda t: re.sub(rf"({CUT},\[[^,]*,)0\.00000000", r"\g<1>0.00870000", t, count=1),
    "a quaternion that is none": lambda t: re.sub(rf"({CUT},\[)[^\]]*", r"\g<1>0.5,0,0,0.5", t, count=1),
    "cf1": swap("[-1,0,-1,0],[3.3", "[0,0,-1,0],[3.3"),
    "cf6": swap("[-1,0,-1,0],[3.3", "[-1,0,0,0],[3.3"),
    "cf6 half a turn on": swap("[-1,0,-1,0],[3.3", "[-1,0,2,0],[3.3"),
    "cfx: the wrist": swap("[-1,0,-1,0],[3.3", "[-1,0,-1,1],[3.3"),
    "cfx: the elbow": swap("[-1,0,-1,0],[3.3", "[-1,0,-1,2],[3.3"),
    "the table past its limit": lambda t: re.sub(rf"({CUT}.*?\],\[)62\.", r"\g<1>782.", t, count=1),
    "a line less": lambda t: drop("MoveL [[-80.000,-50.000,202.000]")(t),
    "a line that is a comment": swap("MoveL [[-80.000,-50.000,202.000]", "! MoveL [[-80.000,-50.000,202.000]"),
    "two lines exchanged": exchanged("MoveL [[-100.000,-50.000,202.000]", "MoveL [[-80.000,-50.000,202.000]"),
    "a cut by axes": lambda t: re.sub(CUT, "MoveJ [[-80.000,-50.000,202.000]", t, count=1),
    "an arc's other side": lambda t: t.replace("MoveC [[-90.000,", "MoveC [[-70.000,", 1),
    "an arc's middle elsewhere": lambda t: t.replace("MoveC [[-90.000,", "MoveC [[-89.000,", 1),
    "faster": swap("[5.000,100.000", "[50.000,100.000", 1),
    "a feed ten times slower": swap("[5.000,100.000", "[0.500,100.000", 1),
    "turning slower": swap("[5.000,100.000", "[5.000,1.000", 1),
    "joint motions faster": swap("j_part:=[500.000,", "j_part:=[5000.000,"),
    "joint motions' axes faster": swap("500.000,50.000,500.000,20.000", "500.000,50.000,500.000,200.000"),
    "a wider zone": swap("z_part:=[FALSE,0.500,0.500,0.500", "z_part:=[FALSE,5.000,5.000,5.000"),
    "a wide predefined zone": swap(",z_part,", ",z50,", 1),
    "a rounded end before a wait": lambda t: t.replace(
        (a := line_with(t, "MoveC")), a.replace("fine", "z_part"), 1
    ).replace("WaitTime\\InPos,1.500", "WaitTime 1.500"),
    "a rounded bottom": lambda t: t.replace(
        (a := line_with(t, "MoveL [[-100.000,-50.000,245.000]")), a.replace("fine", "z200"), 1
    ),
    "ten times the acceleration": swap(
        "AccMax:=2.0000,TRUE\\DecelMax:=2.0000", "AccMax:=20.0000,TRUE\\DecelMax:=20.0000"
    ),
    "no limit of acceleration": drop("PathAccLim"),
    "half of all speeds": swap("VelSet 100", "VelSet 50"),
    "the wrist free": swap("SingArea\\Off", "SingArea\\Wrist"),
    "the tool turns with the circle": swap("CirPathMode\\ObjectFrame", "CirPathMode\\PathFrame"),
    "displaced": swap("PDispOff;", "PDispOn p1,t_part;"),
    "axes displaced": swap("EOffsOff;", "EOffsSet [1,0,0,0,0,0];"),
    "a unit that is off": swap("ActUnit STN1", "DeactUnit STN1"),
    "no coolant": drop("doCoolant,1"),
    "coolant too late": exchanged("doCoolant,1", "MoveL [[-100.000,-50.000,202.000]"),
    "coolant off too soon": exchanged("doCoolant,0", "MoveC"),
    "another spindle speed": swap("3000/2400", "3300/2400"),
    "the spindle off in between": behind("MoveL [[-80.000,-50.000,202.000]", "SetDO doSpindle,0;"),
    "the spindle never on": drop("doSpindle,1"),
    "a tool changed with the spindle on": drop("SetDO doSpindle,0"),
    "a shorter dwell": swap("InPos,1.500", "InPos,0.500"),
    "no dwell": drop("InPos,1.500"),
    "another tool's number": swap("tool 2", "tool 3"),
    "no stop for the tool": drop("Stop;"),
    "an output that nobody knows": behind("MoveC", "SetDO doElse,1;"),
    "a call that nobody knows": behind("MoveC", "doElse 3;"),
    "a statement that nobody knows": behind("MoveC", "SoftAct 3,20;"),
    "a branch": lambda t: t.replace((a := line_with(t, "doCoolant,1")), f"IF di1=1 THEN\r\n{a}\r\nENDIF", 1),
    "a frame set on the way": behind("MoveC", "t_part.tframe:=[[165,0,406.788],[0,0.96592583,0,-0.25881905]];"),
    "a way back too soon": behind("MoveC", "RETURN;"),
    "an end too soon": behind("MoveC", "EXIT;"),
    "two statements in a line": swap("SetDO doCoolant,1;", "SetDO doCoolant,1; SetDO doCoolant,0;"),
    "a motion behind a comment's line end": lambda t: behind(
        "MoveC",
        "! a remark\r\n" + line_with(t, "MoveL [[-80.000,-50.000,202.000]").replace("-80.000,-50", "-80.000,-40"),
    )(t),
    "torn off": lambda t: t[: len(t) // 2],
}


@pytest.mark.parametrize("fault", FAULTS)
def test_each_planted_fault_is_refused(made: PostResult, tmp_path: Path, fault: str) -> None:
    text = source(made)
    wrong = FAULTS[fault](text)
    assert wrong != text
    try:
        found = judged(made, wrong, tmp_path)
    except ProgramError as error:  # what can't be read at all
        assert str(tmp_path) in str(error)
        return
    assert found.ok is not True, [f.text for f in found.findings][:5]


LEGAL: dict[str, Callable[[str], str]] = {
    "line ends of Unix": lambda t: t.replace("\r\n", "\n"),
    "small letters": lambda t: t.replace("MoveL", "movel").replace("SetDO", "SETDO").replace("t_part", "T_Part"),
    "blanks": lambda t: t.replace("MoveL [", "MoveL  [ ").replace("],[", "] , ["),
    "statements over lines": lambda t: t.replace("],[5.000", "],\r\n      [5.000"),
    "other spellings of numbers": lambda t: t.replace("5.000,100.000", "5,1E2").replace("9E9", "9E+09"),
    "remarks": lambda t: t.replace("MoveC", "! MoveL p1,v5,fine,tool0;\r\n MoveC").replace(
        "fine,t_part", "fine ,t_part"
    ),
    "the head of a backup": lambda t: "%%%\r\n  VERSION:1\r\n  LANGUAGE:ENGLISH\r\n%%%\r\n\r\n" + t,
    "stops at corners": lambda t: re.sub(r",z_part,(t2?_part\\WObj)", r",fine,\1", t, count=1),
}


@pytest.mark.parametrize("rewrite", LEGAL)
def test_each_legal_rewrite_passes(made: PostResult, tmp_path: Path, rewrite: str) -> None:
    text = source(made)
    other = LEGAL[rewrite](text)
    assert other != text
    found = judged(made, other, tmp_path)
    assert found.ok is True, [f.text for f in found.findings][:5]


def test_a_shipped_sample_is_posted_split_and_simulated(tmp_path: Path) -> None:
    sample = ROOT / "toolpaths" / "engraving" / "engraving.cls"
    result = post(sample, cell=CELL, out=tmp_path / "out", max_lines=60, report=False)
    modules = sorted(f for f in result.files if f.endswith(".mod"))
    assert len(modules) > 2 and "engraving.pgf" in result.files
    assert result.summary.witness.complete and result.summary.points == 899
    assert verify(result.out / "engraving.mod", cell=CELL, against=sample, collisions=False).ok is True
    run = simulate(result.out / "engraving.mod", cell=CELL, out=tmp_path / "log.csv")
    assert run.summary.motions == len(result.program) and run.summary.approximation.corners > 0
    text = "".join((result.out / name).read_text() for name in modules)
    assert text.count("tSpindle.tload") == 1  # nobody states a mass: the controller's own load
    (result.out / modules[-1]).unlink()
    with pytest.raises(CamrobError, match="which isn't beside it"):
        verify(result.out / "engraving.mod", cell=CELL, against=sample, collisions=False, manifest=False)


def test_a_table_that_no_unit_turns_is_refused(tmp_path: Path) -> None:
    cell = shutil.copytree(CELL, tmp_path / "cell")
    text = (cell / "cell.toml").read_text()
    (cell / "cell.toml").write_text(text.replace('mechanical_unit = "STN1" ', '#mechanical_unit = "STN1" '))
    with pytest.raises(CellError, match="the work object stands still"):
        post(ROOT / "toolpaths" / "engraving" / "engraving.cls", cell=cell, out=tmp_path / "out", report=False)


def test_the_reach_of_its_name() -> None:
    """From axis 1 to the wrist with lower and upper arm in one line, level: the 2.65 m of the robot's name."""
    cell = read_cell(CELL)
    stretched = StatusTurn.of(cell).stretch_deg
    assert stretched == pytest.approx(-np.degrees(np.arctan2(1182.5, 200.0)))
    level = np.array([0.0, 90.0, stretched, 0.0, 0.0, 0.0, 0.0])
    plate = base_T_flange(cell, cell.to_q(level))
    wrist = plate[:3, 3] - 0.2 * plate[:3, 2]  # A5 to the plate
    assert wrist[0] + 1.9 == pytest.approx(2.65, abs=0.005) and wrist[2] + 0.7 == pytest.approx(0.78)


def test_an_axis_that_the_cell_lacks_is_9e9(made: PostResult, tmp_path: Path) -> None:
    """ABB passes over its value: a warning, of which the release of a program of camrob's own makes a refusal."""
    text = source(made)
    result = judged(made, text.replace(",9E9,9E9,9E9,9E9,9E9]", ",0,9E9,9E9,9E9,9E9]"), tmp_path)
    assert [w.code for w in result.summary.warnings if w.code == "axis-absent"] == ["axis-absent"]
