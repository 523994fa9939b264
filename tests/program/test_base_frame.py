"""Where the cell's base lies on the controller: the frame that a cell states is written, judged, or left to the controller."""

from __future__ import annotations

import re
import shutil
from collections.abc import Callable
from pathlib import Path

import pytest
from rapid_job import CELL as RAPID_CELL
from rapid_job import write_job

import camrob
from camrob.errors import CamrobError, CellError
from camrob.jobs.release.opinion import hold_to_witness
from camrob.witness.judge import judge

FOLDER = Path(__file__).resolve().parents[2] / "cells" / "kr15_track_table"
PART = """UNITS/MM
SPINDL/RPM,3000,CLW
MULTAX/ON
FROM/-50,0,40,0,0,1
RAPID
GOTO/-50,0,10
FEDRAT/MMPM,600
GOTO/-50,0,0
GOTO/0,0,0
GOTO/40,30,0
RAPID
GOTO/40,30,40
FINI
"""
FRAME = "base_frame = [1600, -150, 200, 30, 0, 0]"
MEASURED = f"{FRAME}\nbase_measured = true\nbase_number = 2\ntool_number = 3"
TURNING = "base_frame = [10, 0, -20, 0, 0, 15]"
SAID = "{X 1600.00000,Y -150.00000,Z 200.00000,A 30.00000,B 0.00000,C 0.00000}"

Made = Callable[[str], Path]


def cell_with(folder: Path, lines: str) -> Path:
    """The cell with its table at rest, and these lines; the turning one where `lines` begin with its frame."""
    shutil.copytree(FOLDER, folder)
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    if not lines.startswith(TURNING):
        text = text.replace("base_follows_table = true", "base_follows_table = false")
        text = re.sub(r"(?m)^(base_template|act_ex_ax) = .*\n", "", text)
    (folder / "cell.toml").write_text(text.replace("[controller]\n", f"[controller]\n{lines}\n"), encoding="utf-8")
    return folder


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    known: dict[str, Path] = {}

    def post(lines: str) -> Path:
        if lines not in known:
            folder = tmp_path_factory.mktemp("base")
            (folder / "part.apt").write_text(PART, encoding="utf-8")
            (folder / "setup.toml").write_text(
                "part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\ndiameter_mm = 6\nlength_mm = 80\n", encoding="utf-8"
            )
            camrob.post(folder / "part.apt", cell=cell_with(folder / "cell", lines), out=folder / "out", report=False)
            known[lines] = folder
        return known[lines]

    return post


def source(folder: Path) -> str:
    return (folder / "out" / "part.src").read_text(encoding="ascii")


def judged(folder: Path, text: str, out: Path, *, cell: Path | None = None, config: str = "") -> camrob.VerifyResult:
    shutil.copytree(folder / "out", out)
    (out / "part.src").write_text(text, encoding="ascii", newline="\r\n")
    if config:
        (out / "$config.dat").write_text(config, encoding="ascii")
    return camrob.verify(out / "part.src", cell=cell or folder / "cell", against=folder / "part.apt", manifest=False)


def test_the_frame_that_is_stated_is_the_base(made: Made) -> None:
    """The robot stands as it did to the cell's base, so that targets stay: only where that lies is another matter."""
    plain, said, measured = (source(made(lines)) for lines in ("", FRAME, MEASURED))
    targets = [
        [line for line in text.splitlines() if line.startswith(("PTP", "LIN"))] for text in (plain, said, measured)
    ]
    assert targets[0] == targets[1] == targets[2] and len(targets[0]) > 5
    assert "$BASE = {X 0.00000,Y 0.00000," in plain
    assert f"$BASE = {SAID}" in said
    assert "$BASE = BASE_DATA[2]" in measured and "BAS (#BASE,2 )" in measured and SAID not in measured


@pytest.mark.parametrize(
    "lines", [FRAME, MEASURED, MEASURED + '\nnumbering = "tables"', MEASURED + '\nnumbering = "act"', TURNING]
)
def test_it_is_verified_whole(made: Made, lines: str) -> None:
    folder = made(lines)
    result = camrob.verify(folder / "out" / "part.src", cell=folder / "cell", against=folder / "part.apt")
    assert result.ok is True and not result.summary.not_judged
    assert "BASE_DATA[2] =" not in source(folder)
    assert camrob.simulate(folder / "out" / "part.src", cell=folder / "cell", out=folder / "log.csv").summary.rows > 100


@pytest.mark.parametrize(
    ("lines", "old", "new"),
    [
        (FRAME, "X 1600.00000,", "X 1601.00000,"),
        (FRAME, SAID, "{X 0.00000,Y 0.00000,Z 0.00000,A 0.00000,B 0.00000,C 0.00000}"),
        (MEASURED, "$BASE = BASE_DATA[2]", "$BASE = $NULLFRAME"),
        (TURNING, "X 10.00000,", "X 0.00000,"),
    ],
)
def test_another_base_is_refused(made: Made, tmp_path: Path, lines: str, old: str, new: str) -> None:
    folder = made(lines)
    assert old in source(folder)
    assert judged(folder, source(folder).replace(old, new), tmp_path / "out").ok is False
    verdict = judge(tmp_path / "out" / "part.src", folder / "cell", clfile=folder / "part.apt")
    with pytest.raises(CamrobError):
        hold_to_witness(verdict, tmp_path / "out")


def test_a_program_of_another_origin_is_refused(made: Made, tmp_path: Path) -> None:
    assert judged(made(FRAME), source(made(FRAME)), tmp_path / "out", cell=made("") / "cell").ok is False


def test_the_controllers_own_row_counts_where_it_is_at_hand(made: Made, tmp_path: Path) -> None:
    folder = made(MEASURED)
    row = "DEFDAT $CONFIG PUBLIC\nBASE_DATA[2]={X %s,Y -150.0,Z 200.0,A 30.0,B 0.0,C 0.0}\nENDDAT\n"
    assert judged(folder, source(folder), tmp_path / "same", config=row % "1600.0").ok is True
    assert judged(folder, source(folder), tmp_path / "other", config=row % "1610.0").ok is False


def test_a_measured_row_is_not_to_be_written(made: Made, tmp_path: Path) -> None:
    folder = made(MEASURED + '\nnumbering = "tables"')
    text = source(folder).replace("$BASE = ", f"BASE_DATA[2] = {SAID}\n$BASE = ", 1)
    judged(folder, text, tmp_path / "out")
    verdict = judge(tmp_path / "out" / "part.src", folder / "cell", clfile=folder / "part.apt")
    assert [o.text.split()[0] for o in verdict.warnings if o.code == "table-row"] == ["BASE_DATA[2]"]


def test_who_says_nothing_is_told(made: Made, tmp_path: Path) -> None:
    def codes(lines: str) -> dict[str, str]:
        folder = made(lines)
        out = camrob.post(folder / "part.apt", cell=folder / "cell", out=tmp_path / str(len(lines)), report=False)
        return {w.code: w.text for w in out.summary.warnings}

    assert "base_frame" in codes("")["base-unsaid"]
    tables = 'numbering = "tables"\ntool_number = 3\nbase_number = 2'
    assert "over BASE_DATA[2]" in codes(tables)["base-unsaid"]
    for lines in (FRAME, MEASURED, TURNING, "base_frame = [0, 0, 0, 0, 0, 0]"):
        assert "base-unsaid" not in codes(lines)


def test_the_head_says_which_frames_have_to_agree(made: Made) -> None:
    """The root stands 803 before the table's axis and 305 below its top (the cell's own page), turned by 30 degrees here."""
    assert "; base: zeros, so the controller's world has to be the cell's\n" in source(made(""))
    assert "; base: BASE_DATA[2] of the controller, which has to be the cell's base\n" in source(made(MEASURED))
    x, y = 1600.0 - 803.0 * 3**0.5 / 2.0, -150.0 - 803.0 / 2.0
    assert f"; the robot's root there: X {x:.3f} Y {y:.3f} Z -105.000 A 30.000 B 0.000 C 0.000 (E at 0)\n" in source(
        made(FRAME)
    )


@pytest.mark.parametrize(
    "lines", ["base_measured = true", "base_measured = 1\nbase_number = 2", "base_frame = [1, 2, 3]"]
)
def test_what_says_no_base_is_refused(tmp_path: Path, lines: str) -> None:
    with pytest.raises(CellError, match="base_"):
        camrob.post(write_job(tmp_path), cell=cell_with(tmp_path / "cell", lines), out=tmp_path / "out")


def test_a_work_object_likewise(tmp_path: Path) -> None:
    """RAPID's oframe, in the unit that carries it."""
    cell = tmp_path / "cell"
    shutil.copytree(RAPID_CELL, cell)
    text = (cell / "cell.toml").read_text(encoding="utf-8")
    (cell / "cell.toml").write_text(
        text.replace("[controller]\n", "[controller]\nbase_frame = [10, -5, 30, 90, 0, 0]\n")
    )
    part = write_job(tmp_path)
    camrob.post(part, cell=cell, out=tmp_path / "out", report=False)
    module = tmp_path / "out" / "part.mod"
    said = "[[10,-5,30],[0.70710678,0,0,0.70710678]]"
    assert said in re.sub(r"(\.\d*?)0+(?=[,\]])", r"\1", module.read_text()).replace(".,", ",").replace(".]", "]")
    assert camrob.verify(module, cell=cell, against=part).ok is True
    assert camrob.verify(module, cell=RAPID_CELL, against=part, manifest=False).ok is False
