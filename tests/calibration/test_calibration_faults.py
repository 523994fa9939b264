"""Every way in which a calibration can fail ends in one clear line, the right status, and no file."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import CELL, ROOT, axis_values, calibrate_cell, drawn, log_of, measure

from camrob.calibration.terms import PARTS
from camrob.cell.read_cell import read_cell
from camrob.cli.app import run
from camrob.errors import SingularError
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo, MeasuredFrame, Target
from camrob.measurement.write_log import write_log
from camrob.se3 import frame_from_xyzabc

KR15 = ROOT / "cells" / "kr15_track_table"
INFO = LogInfo(sigma_position=2e-5, sigma_angle=1e-5, poses=True)


def log(values: np.ndarray | None = None, info: LogInfo = INFO, **of) -> MeasurementLog:
    return log_of(CELL, measure(CELL, drawn(CELL), axis_values(CELL, 60) if values is None else values, **of), info)


def attempt(folder: Path, measured: MeasurementLog, capsys, *more: str, cell: Path = KR15) -> tuple[int, str]:
    """Status and the line on standard error of `camrob calibrate`; nothing may be left behind."""
    write_log(measured, folder / "m.csv")
    out = folder / "out"
    status = run(["calibrate", str(folder / "m.csv"), "--cell", str(cell), "--out", str(out / "C.toml"), *more])
    line = capsys.readouterr().err.strip()
    assert len(line.splitlines()) == 1 and "Traceback" not in line
    assert not out.exists()
    return status, line


def changed(measured: MeasurementLog, **columns) -> MeasurementLog:
    return replace(measured, columns={**measured.columns, **columns})


def test_too_few_poses(tmp_path, capsys) -> None:
    status, line = attempt(tmp_path, log(axis_values(CELL, 5)), capsys, "--share", "0")
    assert status == 2 and "holds 5 whole poses; measure at least 8, better 50" in line
    seen = log(axis_values(CELL, 9))
    places = replace(seen, columns={n: v for n, v in seen.columns.items() if n not in ("a", "b", "c")})
    asked = [f"base.{p}" for p in PARTS] + ["tool.x", "tool.y", "tool.z", *(f"A{k}.zero" for k in (2, 3, 4, 5)), "A3.x"]
    status, line = attempt(tmp_path, places, capsys, "--share", "0", *(w for n in asked for w in ("--parameter", n)))
    assert status == 2 and "holds 9 poses to fit" in line and "14 parameters need at least 10" in line


def test_lost_rank_names_the_parameters(tmp_path, capsys) -> None:
    status, line = attempt(tmp_path, log(), capsys, "--parameter", "base.x", "--parameter", "A1.x")
    assert status == 3 and "A1.x can't be fitted to m.csv: A1.x: it can't be told from base.x" in line


def test_a_nearly_singular_fit_names_the_parameters(tmp_path, capsys) -> None:
    """A straight wrist that hardly bends: A4 and A6 turn the tool about the same line."""
    values = axis_values(CELL, 60)
    values[:, 4] = np.linspace(-0.02, 0.02, 60)
    more = [part for n in ("A4.zero", "A6.zero") for part in ("--parameter", n)]
    status, line = attempt(tmp_path, log(values, sigma=1e-4, sigma_angle=1e-3), capsys, *more)
    assert status == 3 and "A6.zero can't be fitted to m.csv" in line


@pytest.mark.parametrize("reflector", [False, True])
def test_poses_of_another_frame_or_target(tmp_path, capsys, reflector: bool) -> None:
    """LOG.toml says `world` and the tool, the tracker measured from where it stood."""
    away = frame_from_xyzabc([2.0, -3.0, 0.4, 2.5, 0.3, -1.0])
    of = {"right": frame_from_xyzabc([0.3, 0.1, -0.2, 1.0, 0.5, 2.0])} if reflector else {"left": away}
    status, line = attempt(tmp_path, log(**of), capsys)
    where = 'the tool\'s tip (target = "unknown"' if reflector else 'the instrument\'s own (measured_frame = "unknown"'
    assert status == 2 and where in line
    free = LogInfo(INFO.measured_frame, Target.UNKNOWN) if reflector else LogInfo(MeasuredFrame.UNKNOWN)
    write_log(log(info=replace(free, poses=True, sigma_position=2e-5, sigma_angle=1e-5), **of), tmp_path / "m.csv")
    out = tmp_path / "C.toml"
    assert run(["calibrate", str(tmp_path / "m.csv"), "--cell", str(KR15), "--out", str(out), "--quiet"]) == 0


def test_poses_in_base_that_are_said_to_be_in_world(tmp_path, capsys) -> None:
    status, line = attempt(tmp_path, log(in_base=True), capsys)
    assert status == 2 and 'x, y, z are on the turning table (measured_frame = "base" in its .toml)' in line


def test_numbers_that_are_none(tmp_path, capsys) -> None:
    write_log(log(), tmp_path / "good.csv")
    rows = (tmp_path / "good.csv").read_text().splitlines()
    for bad in ("nan", "NaN", "inf", "1e999"):
        rows[7] = ",".join([rows[7].split(",")[0], bad, *rows[7].split(",")[2:]])
        (tmp_path / "bad.csv").write_text("\n".join(rows) + "\n")
        out = tmp_path / "C.toml"
        assert run(["calibrate", str(tmp_path / "bad.csv"), "--cell", str(KR15), "--out", str(out)]) == 2
        line = capsys.readouterr().err.strip()
        assert len(line.splitlines()) == 1 and "bad.csv:8" in line and not out.exists()


def test_units_that_are_mixed_up(tmp_path, capsys) -> None:
    plain = log()
    metres = changed(plain, **{n: plain.columns[n] / 1000.0 for n in "xyz"})
    status, line = attempt(tmp_path, metres, capsys)
    assert status == 2 and "are the positions in metres? give mm" in line
    radians = changed(plain, **{f"A{k}": np.deg2rad(plain.columns[f"A{k}"]) for k in range(1, 7)})
    status, line = attempt(tmp_path, radians, capsys)
    assert status == 2 and "its A1, A2, A3, A4, A5, A6 are in radians" in line
    turned = changed(plain, **{n: np.deg2rad(plain.columns[n]) for n in "abc"})
    status, line = attempt(tmp_path, turned, capsys)
    assert status == 2 and "its a, b, c are in radians" in line
    track = changed(plain, E1=plain.columns["E1"] / 1000.0)
    status, line = attempt(tmp_path, track, capsys)
    assert status == 2 and "its E1 is in metres" in line


def test_a_log_of_another_cell(tmp_path, capsys) -> None:
    status, line = attempt(tmp_path, log(), capsys, cell=ROOT / "tests" / "data" / "ur10")
    assert status == 2 and "m.csv:1: moves E1, which cell ur10 lacks" in line
    arm_alone = replace(log(), columns={n: v for n, v in log().columns.items() if n not in ("E1", "E2")})
    status, line = attempt(tmp_path, arm_alone, capsys)
    assert status == 2 and "has no column E1" in line
    status, line = attempt(tmp_path, arm_alone, capsys, cell=ROOT / "cells" / "kr500_afp")  # the same six names
    assert status == 3 and "can't be this cell's" in line


def test_torques_that_nobody_knows(tmp_path) -> None:
    """A cell that says nothing of its masses can't have its compliance fitted, and by default it isn't tried."""
    weightless = replace(CELL, masses=())
    data = measure(CELL, {"A2.compliance": 3e-6}, axis_values(CELL, 80))
    with pytest.raises(SingularError, match=r"A2\.compliance: cell kr15_track_table states no masses"):
        calibrate_cell(weightless, data, names=["A2.zero", "A2.compliance"])
    found = calibrate_cell(weightless, data)
    asked = (*found.parameters, *(h.name for h in found.held))
    assert not any(n.endswith("compliance") for n in asked)


def test_the_same_log_twice(tmp_path, capsys) -> None:
    write_log(log(), tmp_path / "m.csv")
    m, out = str(tmp_path / "m.csv"), str(tmp_path / "C.toml")
    for given in ([m, m], [m, "--withheld", m]):
        assert run(["calibrate", *given, "--cell", str(KR15), "--out", out]) == 2
        assert "is given twice" in capsys.readouterr().err


def test_a_withheld_log_that_is_too_short_to_place_its_instrument(tmp_path, capsys) -> None:
    away = frame_from_xyzabc([2.0, -3.0, 0.4, 2.5, 0.3, -1.0])
    free = replace(INFO, measured_frame=MeasuredFrame.UNKNOWN)
    write_log(log(axis_values(CELL, 12, seed=4), info=free, left=away), tmp_path / "short.csv")
    status, line = attempt(tmp_path, log(), capsys, "--withheld", str(tmp_path / "short.csv"))
    assert status == 2 and "short.csv: holds 12 whole poses; 16 are needed" in line


def test_the_cell_of_these_tests_has_masses() -> None:
    assert read_cell(KR15).masses
