"""Between program and set-point: rounding found with its distance, other programs and shifted targets told apart."""

from __future__ import annotations

from functools import cache
from pathlib import Path

import numpy as np
import pytest
from gap_cases import kr15

from camrob.controller.programmed_path import programmed_path
from camrob.controller.replay import replay
from camrob.controller.simulate import simulate
from camrob.errors import LogError
from camrob.gap.diagnose import diagnose
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.measurement.log import MeasurementLog
from camrob.measurement.log_info import LogInfo
from camrob.program.program_text import ProgramText

SIGMA = 0.02
HEAD = """DEF p()
$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}
$TOOL={X 200,Y 0,Z 0,A 0,B 90,C 0}
$VEL.CP=0.2
$ACC.CP=2.0
$ADVANCE=3
"""
HOME = "PTP {A1 0,A2 -90,A3 90,A4 0,A5 90,A6 0,E1 0,E2 0}"


@cache
def start(head: str = HEAD) -> tuple[float, ...]:
    """X, Y, Z, A, B, C of the tool at home, as the program's frames have it."""
    program = parsed(head + HOME + "\nEND\n")
    T = np.asarray(replay(program, kr15()).base_T_tool[0])
    A = np.arctan2(T[1, 0], T[0, 0])
    B, C = -np.arcsin(T[2, 0]), np.arctan2(T[2, 1], T[2, 2])
    return (*(T[:3, 3] * 1e3), *np.rad2deg([A, B, C]))


def parsed(text: str) -> ProgramText:
    import tempfile

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "p.src"
        path.write_text(text)
        return read_krl(path)


def raster(cdis: float, *, after: str = "C_DIS", shift: float = 0.0) -> ProgramText:
    """Rows of 60 mm, 15 mm apart, with corners to round; shift: mm that the targets are off in z."""
    x, y, z, a, b, c = start()
    corners = [(60.0 * ((k + 1) // 2 % 2), 15.0 * (k // 2)) for k in range(12)]
    lines = [f"LIN {{X {x + u},Y {y + v},Z {z - 20 + shift},A {a},B {b},C {c},E1 0,E2 0}} {after}" for u, v in corners]
    return parsed(HEAD + f"$APO.CDIS={cdis}\n" + "\n".join([HOME, *lines]) + "\nEND\n")


def measured(program: ProgramText) -> MeasurementLog:
    """The run of a program with an instrument's noise."""
    log = simulate(program, kr15()).log
    rng = np.random.default_rng(0)
    columns = {n: np.array(v) for n, v in log.columns.items()}
    for n in "xyz":
        columns[n] = columns[n] + rng.normal(0, SIGMA, len(log))
    for n in "abc":
        columns[n] = columns[n] + rng.normal(0, 1e-3, len(log))
    return MeasurementLog(columns, LogInfo(sigma_position=SIGMA * 1e-3, sigma_angle=np.deg2rad(1e-3)), Path("run.csv"))


@pytest.mark.slow
def test_rounded_corners_are_found_with_their_distance_whatever_the_program_says() -> None:
    log = measured(raster(4.0))
    for cdis in (4.0, 0.5):  # what was run, and what the text at hand says
        found = diagnose([log], kr15(), programs=[raster(cdis)])
        assert found.claimed == ("corner_rounding",)
        entry = found.summary.to_json()["effects"][0]
        assert entry["parameters"]["cdis_mm"]["value"] == pytest.approx(4.0, rel=0.02)
        assert entry["programmed_cdis_mm"] == cdis
        assert entry["shrink"] > 0.9
        assert entry["rms_before_mm"] == pytest.approx(
            found.summary.to_json()["where"]["rungs"]["program_to_setpoint"], rel=0.05
        )
        assert found.summary.to_json()["status"] == "explained"
        assert found.summary.to_json()["gap"]["rms_mm"] < 1.1 * SIGMA * np.sqrt(3)
        assert sum(a["probability"] for a in found.summary.to_json()["alternatives"]) == pytest.approx(1.0)


def test_exact_stops_round_nothing() -> None:
    program = raster(4.0, after="")
    found = diagnose([measured(program)], kr15(), programs=[program])
    assert found.claimed == ()
    assert found.summary.to_json()["status"] == "no gap"
    assert found.summary.to_json()["where"]["rungs"]["program_to_setpoint"] < 1e-3


def test_rounding_out_of_the_library_is_called_unknown_between_program_and_set_point() -> None:
    found = diagnose([measured(raster(8.0))], kr15(), programs=[raster(8.0)], without=["corner_rounding"])
    assert found.claimed == ()
    assert found.summary.to_json()["status"] == "unexplained"
    assert found.summary.to_json()["unknown"]["probability"] > 0.5
    assert "between program and set-point" in found.summary.to_json()["unknown"]["text"]


def test_targets_that_were_changed_are_no_rounding() -> None:
    found = diagnose([measured(raster(0.5, shift=0.8))], kr15(), programs=[raster(0.5)])
    assert found.claimed == ()
    assert "between program and set-point, 0.6" in found.summary.to_json()["unknown"]["text"]


def test_another_program_is_refused() -> None:
    with pytest.raises(LogError, match=r"set-points lie \d+ mm off the path of P"):
        diagnose([measured(raster(0.5, shift=-60.0))], kr15(), programs=[raster(0.5)])


def test_the_path_by_place_is_the_one_that_the_virtual_controller_runs() -> None:
    program = raster(4.0)
    replayed = replay(program, kr15())
    path = programmed_path(program, replayed)
    plain = programmed_path(program, replayed, distance=0.0)
    assert path.corners > 8
    assert plain.corners == 0
    corner = np.asarray(plain.points)[np.flatnonzero(plain.motion == 2)[-1]]
    off = np.linalg.norm(np.asarray(path.points) - corner, axis=1).min()
    assert off == pytest.approx(4e-3 / 2 * np.sin(np.pi / 4), rel=1e-3)
