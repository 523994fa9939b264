"""Planted faults between solver and file: none of them may be released.

They come in at three places: into what assembles the program (a wrong sign, frame, unit, axis), into what prints it (lines
lost, doubled, out of place; settings and outputs), and into the files of a program in parts. tests/jobs/test_post_job.py plants
those in single lines of the text.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import camrob.jobs.release.attempt as job
import camrob.languages.krl.writer.write_krl as krl_writer
from camrob import post
from camrob.errors import VerificationError
from camrob.program.motion import Motion
from camrob.program.program import Program, ProgramEvent, ProgramEventKind
from camrob.redundancy.solution import Solution

ROOT = Path(__file__).resolve().parents[2]
CELL = ROOT / "cells" / "kr15_track_table"

HEAD = "TOOL PATH/CUT,TOOL,MILL\nTLDATA/MILL,10,0,50,0,0\nMSYS/0,0,0,1,0,0,0,1,0\nSPINDL/RPM,9000,CLW\nCOOLNT/ON\n"
CUT = (
    "RAPID\nGOTO/-30,-20,50,0.0871557427,0,0.9961946981\nFEDRAT/MMPM,600\nGOTO/-30,-20,0\nGOTO/30,-20,0\nGOTO/30,20,1\nGOTO/0,25,2\n"
    "DELAY/1.5\nGOTO/-30,20,1\nGOTO/-30,-19,0\nRAPID\nGOTO/-30,-20,50\n"
)
PART = HEAD + CUT + CUT.replace("-20", "-10").replace("30,20", "30,10") + "SPINDL/OFF\nCOOLNT/OFF\nEND-OF-PATH\n"
SETUP = "part_in_base = [60, -40, 200, 30, 0, 0]\n"


@pytest.fixture
def part(tmp_path: Path) -> Path:
    folder = tmp_path / "in"
    folder.mkdir()
    (folder / "setup.toml").write_text(SETUP)
    (folder / "part.cls").write_text(PART)
    return folder / "part.cls"


def refused(part: Path, tmp_path: Path, **options: object) -> str:
    """What stood against the release; nothing was left behind."""
    with pytest.raises(VerificationError, match="not released") as caught:
        post(part, cell=CELL, out=tmp_path / "out", report=False, **options)
    assert [f.name for f in tmp_path.iterdir()] == ["in"]
    return str(caught.value)


def test_the_part_itself_is_released(part: Path, tmp_path: Path) -> None:
    made = post(part, cell=CELL, out=tmp_path / "out", report=False)
    assert made.summary.verified.points == 16
    text = (tmp_path / "out" / "part.src").read_text()
    assert all(word in text for word in ("$ANOUT", "$OUT[2] = TRUE", "WAIT SEC 1.5", "C_DIS"))
    post(part, cell=CELL, out=tmp_path / "parts", report=False, max_lines=9)
    assert len(list((tmp_path / "parts").glob("*.src"))) > 2


# ---- in what assembles the program

Assembled = Callable[[Program], Program]


def column(field: str, k: int, change: Callable[[np.ndarray], np.ndarray]) -> Assembled:
    def plant(program: Program) -> Program:
        values = np.array(getattr(program, field))
        values[:, k] = change(values[:, k])
        return replace(program, **{field: np.round(values, 3 if field == "pose" and k < 3 else 4)})

    return plant


def order(field: str, columns: list[int]) -> Assembled:
    return lambda program: replace(program, **{field: np.array(getattr(program, field))[:, columns]})


def at_row(program: Program) -> int:
    """A LIN in the middle of the first cut."""
    return int(np.flatnonzero(np.asarray(program.speed) == 0.01)[2])


ROWS = ("kind", "pose", "axes", "external", "status", "turn", "speed", "approximate", "line", "region", "safe")


def rows(program: Program, pick: list[int]) -> Program:
    """The program with the rows `pick`; events stay with the row that they stood before."""
    moved = [replace(e, motion=pick.index(e.motion) if e.motion in pick else len(pick)) for e in program.events]
    return replace(program, **{name: np.asarray(getattr(program, name))[pick] for name in ROWS}, events=tuple(moved))


def dropped(program: Program) -> Program:
    k = at_row(program)
    return rows(program, [i for i in range(len(program)) if i != k])


def doubled(program: Program) -> Program:
    k = at_row(program)
    return rows(program, [*range(k + 1), *range(k, len(program))])


def swapped(program: Program) -> Program:
    k = at_row(program)
    return rows(program, [*range(k), k + 1, k, *range(k + 2, len(program))])


def one_row(field: str, change: Callable[[np.ndarray], np.ndarray], offset: int = 0) -> Assembled:
    def plant(program: Program) -> Program:
        values = np.array(getattr(program, field))
        k = at_row(program) + offset
        values[k] = change(values[k])
        return replace(program, **{field: values})

    return plant


def shifted(field: str) -> Assembled:
    """Values one row late."""
    return lambda program: replace(program, **{field: np.roll(np.array(getattr(program, field)), 1, axis=0)})


def rounded(field: str, decimals: int) -> Assembled:
    return lambda program: replace(program, **{field: np.round(np.array(getattr(program, field)), decimals)})


def turned(by: float) -> Assembled:
    def plant(program: Program) -> Program:
        external = np.array(program.external)
        external[at_row(program) :, 1] += by
        return replace(program, external=external.round(4))

    return plant


def xyz_instead_of_zyx(program: Program) -> Program:
    from scipy.spatial.transform import Rotation

    pose = np.array(program.pose)
    pose[:, 3:] = Rotation.from_euler("ZYX", pose[:, 3:], degrees=True).as_euler("XYZ", degrees=True).round(4)
    return replace(program, pose=pose)


ASSEMBLED: dict[str, Assembled] = {
    "the track's sign": column("external", 0, np.negative),
    "the table's sign": column("external", 1, np.negative),
    "the track in metres": column("external", 0, lambda v: v / 1000.0),
    "the table in radians": column("external", 1, np.radians),
    "E1 and E2 swapped": order("external", [1, 0]),
    "E2 a turn on, from a point on": turned(360.0),
    "E2 a degree on, from a point on": turned(1.0),
    "X's sign": column("pose", 0, np.negative),
    "Y's sign": column("pose", 1, np.negative),
    "the pose in metres": column("pose", 2, lambda v: v / 1000.0),
    "A in radians": column("pose", 3, np.radians),
    "B's sign": column("pose", 4, np.negative),
    "A, B, C as angles about X, Y, Z": xyz_instead_of_zyx,
    "A and C swapped": order("pose", [0, 1, 2, 5, 4, 3]),
    "A1's sign": column("axes", 0, np.negative),
    "A2 and A3 swapped": order("axes", [0, 2, 1, 3, 4, 5]),
    "A6 a turn on": column("axes", 5, lambda v: v + 360.0),
    "a stale base": lambda p: replace(p, base=np.array([0.0, 0.0, 0.5, 0.0, 0.0, 0.0])),
    "the inverse of the tool": lambda p: replace(p, tool=-np.asarray(p.tool)),
    "a tool 0.02 mm long": lambda p: replace(p, tool=np.asarray(p.tool) + np.array([0, 0, 0.02, 0, 0, 0])),
    "S of another arm": lambda p: replace(p, status=np.asarray(p.status) ^ 1),
    "S of the other wrist": lambda p: replace(p, status=np.asarray(p.status) ^ 4),
    "T of another turn": lambda p: replace(p, turn=np.asarray(p.turn) ^ 32),
    "a dropped point": dropped,
    "a doubled point": doubled,
    "two points swapped": swapped,
    "poses one row late": shifted("pose"),
    "external axes one row late": shifted("external"),
    "feeds one row late": lambda p: replace(p, speed=np.concatenate([p.speed[:3], p.speed[2:-2], p.speed[-1:]])),
    "millimetres a minute for metres a second": lambda p: replace(p, speed=np.asarray(p.speed) * 60.0),
    "one cut at the rapid speed": one_row("speed", lambda v: v * 10.0),
    "positions rounded to a tenth": rounded("pose", 1),
    "external axes rounded to a degree": rounded("external", 0),
    "a point lifted by 0.011 mm": one_row("pose", lambda v: v + np.array([0, 0, 0.011, 0, 0, 0])),
    "a point turned by 0.011 degrees": one_row("pose", lambda v: v + np.array([0, 0, 0, 0, 0.011, 0])),
    "a PTP in the cut": lambda p: one_row("approximate", np.zeros_like)(
        one_row("kind", lambda v: np.int8(Motion.PTP_POSE))(p)
    ),
}


@pytest.mark.parametrize("name", ASSEMBLED)
def test_what_is_assembled_wrong_is_not_released(
    part: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """The text then says what the (wrong) program means, so that only the CL points and the solution stand against it."""
    assemble = job.assemble_program

    def faulty(*arguments: object, **options: object) -> Program:
        return ASSEMBLED[name](assemble(*arguments, **options))

    monkeypatch.setattr(job, "assemble_program", faulty)
    refused(part, tmp_path)


def test_a_posture_that_was_not_solved_is_not_released(
    part: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Rolled about the tool's axis the tip and its axis are the same, and so is every program made of it."""
    assemble = job.assemble_program

    def faulty(
        name: str, cell: object, toolpath: object, path: object, solution: Solution, **options: object
    ) -> Program:
        q = np.array(solution.q)
        q[:, -1] += 0.3
        q[:, -2] -= (
            0.3  # A6 against the virtual roll about the same axis, were the tool straight; near enough to be seen
        )
        return assemble(name, cell, toolpath, path, replace(solution, q=q), **options)

    monkeypatch.setattr(job, "assemble_program", faulty)
    refused(part, tmp_path)


# ---- in what is printed

Text = Callable[[str], str]


def put(pattern: str, replacement: str) -> Text:
    def plant(text: str) -> str:
        changed = re.sub(pattern, replacement, text, count=1, flags=re.M)
        assert changed != text
        return changed

    return plant


PRINTED: dict[str, Text] = {
    "an exact stop rounded off": put(r"^(LIN \{X?[^}]*\})(?! C_DIS)$", r"\1 C_DIS"),
    "a rounding lost": put(r" C_DIS$", ""),
    "rounding by speed": put(r" C_DIS$", " C_VEL"),
    "the spindle never on": put(r"^\$OUT\[1\] = TRUE\n", ""),
    "the spindle at another speed": put(r"^\$ANOUT\[1\] = 9000", "$ANOUT[1] = 19000"),
    "the spindle's output's number": put(r"^\$OUT\[1\] = TRUE", "$OUT[3] = TRUE"),
    "the spindle off before the cut": put(r"^(LIN .*)$", "$OUT[1] = FALSE\n\\1"),
    "the spindle left on": put(r"^\$OUT\[1\] = FALSE\n", ""),
    "no time to run up": put(r"^WAIT SEC 3\.0\n", ""),
    "a shorter dwell": put(r"^WAIT SEC 1\.500", "WAIT SEC 0.500"),
    "a dwell elsewhere": lambda text: put(r"^(LIN .*\nLIN .*\n)", r"\1WAIT SEC 1.500\n")(
        put(r"^WAIT SEC 1\.500\n", "")(text)
    ),
    "no coolant": put(r"^\$OUT\[2\] = TRUE\n", ""),
    "ten times the acceleration": put(r"^\$ACC\.CP = 2\.", "$ACC.CP = 20."),
    "corners cut by 50 mm": put(r"^\$APO\.CDIS = 0\.5", "$APO.CDIS = 50.5"),
    "corners cut later on": put(r"^(LIN .*)$", "$APO.CDIS = 50.0\n\\1"),
    "orientation held": put(r"^\$ORI_TYPE = #VAR", "$ORI_TYPE = #CONSTANT"),
    "PTP at full speed": put(r"#VEL_PTP,10 ", "#VEL_PTP,100 "),
    "no external axes": put(r"^\$ACT_EX_AX = 2", "$ACT_EX_AX = 1"),
    "an output that nobody asked for": put(r"^(LIN .*)$", "$OUT[7] = TRUE\n\\1"),
    "a halt lost from nowhere": put(r"^(LIN .*)$", "HALT\n\\1"),
    "a return in the middle": put(r"^(LIN .*\nLIN .*\n)", r"\1RETURN\n"),
    "the rest behind a semicolon": put(r"^LIN ", ";LIN "),
    "a base set later on": put(r"^(LIN .*)$", "$BASE.X = 1.0\n\\1"),
    "a tool set later on": put(r"^(LIN .*)$", "$TOOL.Z = 400.0\n\\1"),
}


def altered(monkeypatch: pytest.MonkeyPatch, change: Callable[[dict[str, str]], dict[str, str]]) -> None:
    written = krl_writer.iter_krl

    def faulty(*arguments: object, **options: object):
        files = {name: data.decode().replace("\r\n", "\n") for name, data in written(*arguments, **options)}
        yield from ((name, text.replace("\n", "\r\n").encode()) for name, text in change(files).items())

    monkeypatch.setattr(krl_writer, "iter_krl", faulty)


@pytest.mark.parametrize("name", PRINTED)
def test_what_is_printed_wrong_is_not_released(
    part: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    altered(monkeypatch, lambda files: {**files, "part.src": PRINTED[name](files["part.src"])})
    refused(part, tmp_path)


# ---- in the files of a program in parts


def last_line_lost(files: dict[str, str]) -> dict[str, str]:
    return {**files, "part_001.src": re.sub(r"LIN [^\n]*\n(?=(;[^\n]*\n)*END\n)", "", files["part_001.src"])}


def calls(change: Callable[[list[str]], list[str]]) -> Callable[[dict[str, str]], dict[str, str]]:
    def plant(files: dict[str, str]) -> dict[str, str]:
        lines = files["part.src"].split("\n")
        places = [k for k, line in enumerate(lines) if re.fullmatch(r"part_\d+ \( \)", line)]
        lines[places[0] : places[-1] + 1] = change([lines[k] for k in places])
        return {**files, "part.src": "\n".join(lines)}

    return plant


IN_PARTS: dict[str, Callable[[dict[str, str]], dict[str, str]]] = {
    "a lost line at a part's border": last_line_lost,
    "a part that is not called": calls(lambda c: [c[0], *c[2:]]),
    "a part called twice": calls(lambda c: [c[0], c[0], *c[1:]]),
    "parts in another order": calls(lambda c: [c[1], c[0], *c[2:]]),
    "a part that is missing": lambda files: {n: t for n, t in files.items() if n != "part_002.src"},
    "a part cut off": lambda files: {**files, "part_002.src": files["part_002.src"].removesuffix("END\n")},
    "one part's text in another's file": lambda files: {
        **files,
        "part_002.src": files["part_001.src"].replace("DEF part_001", "DEF part_002"),
    },
    "no speed at the beginning of a part": lambda files: {
        **files,
        "part_002.src": re.sub(r"\$VEL\.CP = [^\n]*\n", "$VEL.CP = 0.200000\n", files["part_002.src"], count=1),
    },
}


@pytest.mark.parametrize("name", IN_PARTS)
def test_parts_that_do_not_fit_are_not_released(
    part: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    def change(files: dict[str, str]) -> dict[str, str]:
        changed = IN_PARTS[name](files)
        assert changed != files
        return changed

    altered(monkeypatch, change)
    refused(part, tmp_path, max_lines=9)


# ---- what a cell's own hooks call


def test_calls_of_the_cells_own_hooks_are_vouched_for(part: Path, tmp_path: Path) -> None:
    """An integrator's own subprogram for the spindle is no reason to refuse; any other unknown call is."""
    import shutil

    from camrob.jobs.verify import verify

    cell = Path(shutil.copytree(CELL, tmp_path / "in" / "cell"))
    toml = (cell / "cell.toml").read_text()
    (cell / "cell.toml").write_text(
        re.sub(r"^spindle_on = .*$", 'spindle_on = ["SPINDLE_START ({speed})"]', toml, flags=re.M)
    )
    post(part, cell=cell, out=tmp_path / "out", report=False)
    program = tmp_path / "out" / "part.src"
    assert b"SPINDLE_START (9000)" in program.read_bytes()
    assert verify(program, cell=cell, against=part).ok
    program.write_bytes(program.read_bytes().replace(b"SPINDLE_START", b"SPINDLE_STARZ"))
    assert not verify(program, cell=cell, against=part).ok


def test_events_of_a_program_are_what_the_text_does() -> None:
    """The kinds of events are all known to the check; a new one must be taught to it."""
    assert {k.value for k in ProgramEventKind} == {"hook", "comment", "dwell", "region", "tool", "load"}
    assert ProgramEvent(0, ProgramEventKind.DWELL, value=1.0).value == 1.0
