"""A compensated program says what it is, leaves HOME alone, and is held to its original and its calibration."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

import pytest
from calibration_sample import CELL, ROOT, axis_values, calibrate_cell, measure

import camrob
from camrob.calibration.calibration_file import calibration_text
from camrob.errors import InputError

CELL_FOLDER = ROOT / "cells" / "kr15_track_table"
PART = """PARTNO/A
UNITS/MM
SPINDL/6000,RPM,CLW
FEDRAT/500,MMPM
RAPID
GOTO/0,0,40,0,0,1
GOTO/0,0,0
CIRCLE/10,0,0,0,0,1,10
GOTO/20,0,0
GOTO/30,10,0
GOTO/40,0,0
RAPID
GOTO/40,0,40
FINI
"""


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with part.apt, its program in out, two calibrations (A3 off by 0.3 and 0.4 degrees), the corrected program."""
    folder = tmp_path_factory.mktemp("corrected")
    (folder / "part.apt").write_text(PART, encoding="utf-8")
    (folder / "setup.toml").write_text(
        "part_in_base = [0, 0, 200, 0, 0, 0]\n[tool]\ndiameter_mm = 6\nlength_mm = 80\n", encoding="utf-8"
    )
    camrob.post(folder / "part.apt", cell=CELL_FOLDER, out=folder / "out", report=False)
    for name, off in (("fit", 0.3), ("other", 0.4)):
        poses = measure(CELL, {"A3.zero": off * 3.14159265 / 180}, axis_values(CELL, 40), sigma=1e-9, sigma_angle=1e-9)
        result = calibrate_cell(CELL, poses, names=["A3.zero"], share=0.0)
        (folder / f"{name}.toml").write_text(calibration_text(result))
    program = folder / "out" / "part.src"
    camrob.compensate(program, cell=CELL_FOLDER, calibration=folder / "fit.toml", out=folder / "corrected")
    return folder


def held(folder: Path, program: Path, calibration: str = "fit") -> camrob.VerifyResult:
    return camrob.verify(
        program,
        cell=CELL_FOLDER,
        original=folder / "out" / "part.src",
        calibration=folder / f"{calibration}.toml",
        against=folder / "part.apt",
        manifest=False,
    )


def changed(folder: Path, place: Path, old: str, new: str) -> Path:
    """The corrected program with another text in it."""
    text = (folder / "corrected" / "part.src").read_bytes().decode("ascii")
    assert old in text
    place.write_bytes(text.replace(old, new, 1).encode("ascii"))
    return place


def test_its_head_says_of_which_program_and_for_which_machine(made: Path) -> None:
    original, corrected = (made / of / "part.src" for of in ("out", "corrected"))
    head = corrected.read_text(encoding="ascii").split("The original's own head")[0]
    assert (
        "CORRECTED by camrob compensate" in head and "mastered again" in head and "both together correct twice" in head
    )
    for name, file in (("part.src", original), ("fit.toml", made / "fit.toml")):
        assert re.search(
            rf"; [a-z ]+ {re.escape(name)}\n; sha256 {hashlib.sha256(file.read_bytes()).hexdigest()}\n", head
        )
    assert not re.search(r"20\d\d-", head)


def test_a_calibration_says_when_it_is_void(made: Path) -> None:
    head = [line for line in (made / "fit.toml").read_text(encoding="utf-8").splitlines() if line.startswith("#")]
    assert "mastered again" in " ".join(head) and "correct twice" in " ".join(head)


def test_home_stays_and_all_else_but_targets_too(made: Path) -> None:
    old, new = ((made / of / "part.src").read_text(encoding="ascii").splitlines() for of in ("out", "corrected"))
    at = next(k for k, line in enumerate(new) if "own head" in line) + 1
    below = new[at:]
    assert [line for line in old if "E6AXIS" in line] == [line for line in new if "E6AXIS" in line] != []
    pairs = list(zip(old[len(old) - len(below) :], below, strict=True))
    assert all(a == b or a.startswith(("LIN", "CIRC", "PTP {E6POS")) for a, b in pairs)
    assert sum(a != b for a, b in pairs) > 5


def test_it_is_verified_by_its_original_and_what_it_was_corrected_for(made: Path) -> None:
    result = held(made, made / "corrected" / "part.src")
    assert result.ok is True and result.summary.corrected is not None
    figures = result.summary.corrected
    assert figures.position_error_mm_max < 1e-3 and figures.moved_mm_max > 1.0
    assert (figures.original, figures.calibration) == ("part.src", "fit.toml")
    assert result.summary.against is not None and result.summary.against.met == result.summary.against.points


def test_the_original_is_not_the_corrected_program(made: Path) -> None:
    assert [e.code for e in held(made, made / "out" / "part.src").summary.errors] == ["corrected-otherwise"]


def test_another_calibration_is_found(made: Path) -> None:
    assert held(made, made / "corrected" / "part.src", "other").ok is False


@pytest.mark.parametrize(
    ("old", "new", "code"),
    [
        ("$OUT[1] = TRUE", "$OUT[2] = TRUE", "not-as-original"),
        ("$VEL.CP = 0.008333", "$VEL.CP = 0.018333", "not-as-original"),
        ("A2 -90.0000", "A2 -91.0000", "corrected-otherwise"),
        (" C_DIS", "", "not-as-original"),
    ],
)
def test_what_else_was_changed_is_found(made: Path, tmp_path: Path, old: str, new: str, code: str) -> None:
    result = held(made, changed(made, tmp_path / "part.src", old, new))
    assert result.ok is False and code in [e.code for e in result.summary.errors]


def test_what_is_given_by_halves_is_refused(made: Path) -> None:
    with pytest.raises(InputError, match="give both"):
        camrob.verify(made / "corrected" / "part.src", cell=CELL_FOLDER, original=made / "out" / "part.src")
