"""Other verbs over RAPID: compensation, the poses to measure next; what the witness hears of events and of line ends."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import calibrate_cell, measure
from rapid_job import CELL
from rapid_sample import bracket, controller, read_module, written

from camrob import post
from camrob.calibration.calibration_file import calibration_text
from camrob.calibration.terms import standard_names
from camrob.cell.read_cell import read_cell
from camrob.errors import ProgramError
from camrob.jobs.compensate import compensate
from camrob.jobs.solving.measuring import plan_measuring
from camrob.languages import language_named
from camrob.languages.read_program import read_program
from camrob.witness.machine import read_machine
from camrob.witness.programs import run_program

SAMPLE = CELL.parents[1] / "toolpaths" / "engraving" / "engraving.cls"
RAPID = language_named("rapid")


def spread(count: int) -> np.ndarray:
    """Axis values (N, 7) all over the IRB 6700's range."""
    low, high = [-60, -40, -60, -120, 20, -150, -300], [60, 60, 50, 120, 110, 150, 300]
    return np.random.default_rng(2).uniform(low, high, (count, 7))


def test_a_rigid_shift_of_the_robot_shifts_the_program(tmp_path: Path) -> None:
    """Truth on paper: a robot 1 mm too far in +z of the world is sent 1 mm lower, wherever the table stands."""
    cell = read_cell(CELL)
    seen = measure(cell, {"base.z": 1e-3}, spread(60), sigma=1e-9, sigma_angle=1e-9)
    (tmp_path / "C.toml").write_text(calibration_text(calibrate_cell(cell, seen, names=["base.z"], share=0.0)))
    made = post(SAMPLE, cell=CELL, out=tmp_path / "out", report=False)
    result = compensate(made.out / "engraving.mod", cell=CELL, calibration=tmp_path / "C.toml", out=tmp_path / "new")
    assert (
        result.summary.error_before.mean_mm == pytest.approx(1.0, abs=1e-3) and result.summary.error_after.max_mm < 1e-3
    )
    old, new = (read_program(folder / "engraving.mod") for folder in (made.out, tmp_path / "new"))
    posed = ~np.isnan(old.pose[:, 0])
    apart = (np.asarray(new.pose) - np.asarray(old.pose))[posed]
    assert np.abs(apart[:, 2] + 1.0).max() < 1e-3 and np.abs(apart[:, :2]).max() < 1e-3
    for name in ("external", "speed", "blend", "status", "turn", "tool"):
        assert np.array_equal(getattr(new, name), getattr(old, name), equal_nan=True), name
    assert new.actions == old.actions and (tmp_path / "new" / "engraving.pgf").is_file()
    texts = [(folder / "engraving.mod").read_text().split("\n") for folder in (made.out, tmp_path / "new")]
    first, last = (next(k for k, s in enumerate(texts[1]) if said in s) for said in ("! CORRECTED", "own head"))
    assert np.array_equal(new.line, np.asarray(old.line) + last - first + 1)
    del texts[1][first : last + 1]
    for a, b in zip(*texts, strict=True):
        assert a == b or re.match(r"\s*Move", a)


def test_the_poses_to_measure_next_are_a_program(tmp_path: Path) -> None:
    cell = read_cell(CELL)
    names = [n for n in standard_names(cell, table=True) if not n.endswith("compliance")][:6]
    data = measure(cell, dict.fromkeys(names, 1e-4), spread(30))
    plan = plan_measuring(cell, data, names, np.asarray(data.q), 5, "a name that is much too long for RAPID_poses")
    for name, content in plan.files.items():
        (tmp_path / name).write_bytes(content)
    main = next(name for name in plan.files if name.endswith(".mod"))
    text = read_program(tmp_path / main)
    assert len(text) == 7 and not text.findings and text.wait[2:].tolist() == [text.wait[2]] * 5
    run = run_program(tmp_path / main, read_machine(CELL))
    assert not run.gaps and not run.objections and len(run) == 7


@pytest.mark.parametrize("odd", ["\r", "\x00"])
def test_what_one_system_takes_for_a_lines_end_and_another_not_is_refused(tmp_path: Path, odd: str) -> None:
    """Behind such a sign a remark may hide a motion."""
    text = written(bracket())["Bracket_7.mod"].decode().replace("! a remark", f"! a{odd}MoveL p1,v5,fine,tool0;")
    for read in (lambda: read_module(text, tmp_path), lambda: run_program(tmp_path / "part.mod", read_machine(CELL))):
        with pytest.raises(ProgramError, match="CR without its LF"):
            read()


def test_a_program_of_any_name_is_held_to_its_own_data() -> None:
    """What is meant names the data as they are printed."""
    program = bracket()
    silent = dataclasses.replace(program, events=(), loads=np.zeros((0, 7)))
    said = RAPID.meant(silent, controller()).opening
    assert [line for line in said if "TLOAD" in line] == ["T_BRACKET_7 . TLOAD := TSPINDLE . TLOAD"]
