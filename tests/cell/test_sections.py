"""[controller] and [resolve] of a cell.toml are needed by the verbs that use them, and by no other."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from camrob import post
from camrob.cell.read_cell import read_cell
from camrob.errors import CellError
from camrob.jobs.calibrate import calibrate
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.jobs.feed import feed
from camrob.jobs.place import place
from camrob.jobs.simulate import simulate
from camrob.jobs.studies.line import line
from camrob.jobs.studies.weld import weld
from camrob.jobs.verify import verify
from camrob.kinematics.frames import base_T_tool, world_T_base
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.measurement.write_log import write_log
from camrob.se3 import xyzabc_from_frame
from camrob.units import m_to_mm, rad_to_deg

ROOT = Path(__file__).resolve().parents[2]
KR15 = ROOT / "cells" / "kr15_track_table"
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"
PROGRAM = ROOT / "toolpaths" / "engraving" / "golden" / "engraving.src"


def without(folder: Path, *sections: str, cell: str = "kr15_track_table") -> Path:
    """A copy of a shipped cell without some sections."""
    shutil.copytree(ROOT / "cells" / cell, folder)
    text = (folder / "cell.toml").read_text(encoding="utf-8")
    blocks = re.split(r"(?m)^(?=\[)", text)
    kept = [b for b in blocks if not any(re.match(rf"\[{s}[\].]", b) for s in sections)]
    assert len(kept) < len(blocks) or not sections
    (folder / "cell.toml").write_text("".join(kept), encoding="utf-8")
    return folder


def refused(cell: Path, section: str, verb: str, job: Callable[..., object], *given: object, **named: object) -> None:
    with pytest.raises(CellError) as caught:
        job(*given, cell=cell, **named)
    hint = "add it; the README.md of cells/kr15_track_table explains its keys"
    assert str(caught.value) == f"{cell / 'cell.toml'}: has no [{section}], which camrob {verb} needs; {hint}"


@pytest.fixture(scope="module")
def measured(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Poses at rest of a KR15 whose A2 stands 0.1 degrees off."""
    cell = read_cell(KR15)
    rng = np.random.default_rng(3)
    axes = np.array([0, -80, 80, 0, 60, 0, 0, 0]) + rng.uniform(-1, 1, (60, 8)) * [60, 25, 30, 90, 40, 120, 500, 0]
    q = cell.to_q(axes + np.eye(8)[1] * 0.1)
    poses = xyzabc_from_frame(world_T_base(cell, q) @ base_T_tool(cell, q))
    noise = rng.normal(0.0, 0.01, (60, 3))
    columns = {n: axes[:, k] for k, n in enumerate(cell.axis_names)}
    columns |= {n: m_to_mm(poses[:, k]) + noise[:, k] for k, n in enumerate("xyz")}
    columns |= {n: rad_to_deg(poses[:, 3 + k]) for k, n in enumerate("abc")}
    file = tmp_path_factory.mktemp("measured") / "m.csv"
    write_log(MeasurementLog({"t": np.arange(60.0), **columns}, LogInfo(poses=True)), file)
    return file


def test_a_cell_without_both_is_read(tmp_path: Path) -> None:
    bare, whole = read_cell(without(tmp_path / "cell", "controller", "resolve")), read_cell(KR15)
    assert bare.digest != whole.digest
    assert bare.checked_for("camrob calibrate") is bare
    with pytest.raises(CellError, match=r"cell\.toml: has no \[controller\], which this job needs; add it"):
        _ = bare.controller
    with pytest.raises(CellError, match=r"cell\.toml: has no \[resolve\], which this job needs; add it"):
        _ = bare.resolve
    with pytest.raises(CellError, match=r"has no \[resolve\], which camrob post needs"):
        read_cell(without(tmp_path / "other", "resolve")).checked_for("camrob post", controller=True, resolve=True)


@pytest.mark.slow
def test_linear_axes_of_an_arm_are_told_their_role(tmp_path: Path) -> None:
    shutil.copytree(KR15, tmp_path / "gantry")
    file = tmp_path / "gantry" / "cell.toml"
    text = file.read_text(encoding="utf-8")
    turning = re.search(r'name = "A1"\n.*?\n\n', text, re.DOTALL)
    assert turning is not None
    linear = turning[0].replace("revolute", "prismatic").replace("_deg_s", "_mm_s")
    for key in ("offset", "home", "reference", "range"):
        linear = linear.replace(f"{key}_deg", f"{key}_mm")
    file.write_text(text.replace(turning[0], linear), encoding="utf-8")
    with pytest.raises(
        CellError, match=r"not six that turn; .*linear axes that carry six that turn are of role carriage"
    ):
        read_cell(tmp_path / "gantry")


def test_without_resolve(tmp_path: Path, measured: Path) -> None:
    cell, out = without(tmp_path / "cell", "resolve"), tmp_path / "out"
    refused(cell, "resolve", "post", post, SAMPLE, out=out)
    refused(cell, "resolve", "place", place, SAMPLE, out=out)
    assert not out.exists()
    log, found = tmp_path / "LOG.csv", tmp_path / "C.toml"
    assert verify(PROGRAM, cell=cell).ok
    assert verify(PROGRAM, cell=cell, against=SAMPLE).ok
    simulate(PROGRAM, cell=cell, out=log)
    diagnose(cell=cell, log=[log], program=PROGRAM, out=out)
    calibrate(measured, cell=cell, out=found, parameters=["A2.zero"])
    compensate(PROGRAM, cell=cell, calibration=found, out=tmp_path / "new")
    assert (tmp_path / "new" / "engraving.src").is_file()


@pytest.mark.slow
def test_without_controller(tmp_path: Path, measured: Path) -> None:
    cell, out = without(tmp_path / "cell", "controller"), tmp_path / "out"
    log, found = tmp_path / "LOG.csv", tmp_path / "C.toml"
    fit = {"out": found, "parameters": ["A2.zero"]}
    refused(cell, "controller", "post", post, SAMPLE, out=out)
    refused(cell, "controller", "verify", verify, PROGRAM)
    refused(cell, "controller", "verify", verify, PROGRAM, against=SAMPLE)
    refused(cell, "controller", "simulate", simulate, PROGRAM, out=log)
    refused(cell, "controller", "calibrate --next", calibrate, measured, poses=20, **fit)
    calibrate(measured, cell=cell, **fit)
    refused(cell, "controller", "compensate", compensate, PROGRAM, calibration=found, out=out)
    refused(cell, "controller", "diagnose with a program", diagnose, log=[measured], program=PROGRAM, out=out)
    refused(
        cell, "controller", "diagnose --write-experiment", diagnose, log=[measured], experiment=out / "e.src", out=out
    )
    assert not out.exists() and not log.exists()
    diagnose(cell=cell, log=[measured], out=out)
    feed(PROGRAM, cell=cell, out=tmp_path / "feed")


@pytest.mark.slow
def test_studies_of_shipped_cells_need_neither(tmp_path: Path) -> None:
    for name, study in (("ta1400_weld", weld), ("kr500_afp", line)):
        cell = without(tmp_path / name, "controller", "resolve", cell=name)
        assert study(cell=cell, out=tmp_path / "out").files


def test_the_command_line_says_it_in_one_line(tmp_path: Path) -> None:
    cell = without(tmp_path / "cell", "controller")
    command = [sys.executable, "-m", "camrob.cli", "simulate", PROGRAM, "--cell", cell, "--out", tmp_path / "LOG.csv"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.startswith(f"{cell / 'cell.toml'}: has no [controller], which camrob simulate needs; add it")
    assert done.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("kinds", "said"),
    [("RRRRRRR", "has 7 axes;"), ("RRPR", "has 4 axes of which some slide;"), ("RRRRR", "has 5 axes;")],
)
def test_an_arm_that_no_program_can_be_made_for_is_not_told_to_add_a_controller(
    tmp_path: Path, kinds: str, said: str
) -> None:
    rows = ", ".join("[90, 0, 0, 300]" if k % 2 else "[-90, 50, 0, 100]" for k in range(len(kinds)))
    text = f'schema = 1\nname = "arm"\nstanding = "datasheet"\n[arm]\nkinds = "{kinds}"\ndh = [{rows}]\n'
    (tmp_path / "cell.toml").write_text(text, encoding="utf-8")
    with pytest.raises(CellError, match="camrob post is for arms of 6 axes that turn, and this one ") as caught:
        post(SAMPLE, cell=tmp_path, out=tmp_path / "out")
    assert said in str(caught.value) and "add it" not in str(caught.value)
