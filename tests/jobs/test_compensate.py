"""Compensation: the calibrated robot meets the poses, the text survives, what can't be done is refused."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import CELL, ROOT, SHARED, axis_values, calibrate_cell, drawn, measure
from page_data import block_of

from camrob.calibration.calibration_file import calibration_text
from camrob.calibration.compensate import compensate_postures, pose_difference
from camrob.calibration.error_model import ErrorModel
from camrob.cell.status_turn import StatusTurn
from camrob.cli.app import run
from camrob.controller.replay import replay
from camrob.errors import InputError, KrlError, SingularError, StaleInputError
from camrob.jobs.compensate import compensate
from camrob.jobs.files.solution_program import program_of_solution
from camrob.jobs.release.compensation import analyses_before_after, rates_and_violations
from camrob.kinematics.frames import base_T_tool
from camrob.kinematics.kernels import chain_arrays, inverse_kf_many
from camrob.languages.krl.patch import literal_targets, patch_source
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.program.language import NewTarget
from camrob.program.motion import Motion
from camrob.se3 import xyzabc_from_frame
from camrob.studies.published_newton import compensate_as_published

CELL_FOLDER = ROOT / "cells" / "kr15_track_table"
ERRORS = drawn(CELL)
MODEL = ErrorModel.of(CELL, tuple(ERRORS), in_base=True)
VALUES = np.array(list(ERRORS.values()))


def good_postures(n: int) -> np.ndarray:
    q = CELL.to_q(axis_values(CELL, 3 * n))
    return q[inverse_kf_many(chain_arrays(CELL), q) > 0.15][:n]


def test_the_calibrated_robot_meets_the_poses() -> None:
    q = good_postures(400)
    targets = base_T_tool(CELL, q)
    result = compensate_postures(MODEL, VALUES, q, targets)
    assert np.min(result.before[:, 0]) > 1e-4
    assert np.max(result.after) < 1e-11
    assert np.max(result.iterations) <= 5
    external = [CELL.index("E1"), CELL.index("E2")]
    assert np.array_equal(result.q[:, external], q[:, external])
    reached = MODEL.poses(VALUES, np.asarray(result.q))
    assert np.max(np.abs(pose_difference(targets, reached))) < 1e-11


def test_ours_is_the_published_iteration() -> None:
    """The paper's numbers, delta 1e-8 and epsilon 1e-15, end where ours ends, in 3 to 5 iterations."""
    q = good_postures(12)
    targets = base_T_tool(CELL, q)
    ours = compensate_postures(MODEL, VALUES, q, targets)
    part = CELL.arm_slice
    for row in range(len(q)):

        def forward(arm: np.ndarray, row: int = row) -> np.ndarray:
            posture = q[row].copy()
            posture[part] = arm
            return MODEL.poses(VALUES, posture[None])[0]

        theta, iterations = compensate_as_published(forward, targets[row], q[row, part])
        assert np.allclose(theta, ours.q[row, part], atol=1e-9)
        assert 2 <= iterations <= 5


def test_the_published_iteration_says_when_it_does_not_end() -> None:
    with pytest.raises(SingularError):
        compensate_as_published(lambda q: np.eye(4), np.diag([1.0, 1.0, 1.0, 1.0]) + np.eye(4, k=3), np.zeros(6))


@pytest.mark.slow
def test_a_hundred_thousand_points_are_met() -> None:
    q = np.tile(good_postures(2000), (50, 1))[:100_000]
    targets = base_T_tool(CELL, q[:2000])
    result = compensate_postures(MODEL, VALUES, q, np.tile(targets, (50, 1, 1))[: len(q)])
    assert len(q) > 90_000 and np.max(result.after) < 1e-11


def test_a_singular_posture_is_named() -> None:
    q = np.repeat(good_postures(1), 3, axis=0)
    q[1] = CELL.to_q(np.array([10.0, -80.0, 90.0, 0.0, 0.0, 0.0, 0.0, 0.0]))  # the wrist is straight
    with pytest.raises(SingularError, match="point 2 can't be compensated"):
        compensate_postures(MODEL, VALUES, q, base_T_tool(CELL, q))


# --- programs -----------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def calibration(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("calibration") / "CALIBRATION.toml"
    path.write_text(calibration_text(calibrate_cell(CELL, measure(CELL, ERRORS, axis_values(CELL, 150)))))
    return path


def program(folder: Path, *, q0=(9.0, -77.0, 123.0, -26.0, 50.0, 27.0), more: str = "") -> Path:
    """A program with a bit of everything, poses along a small square from a posture."""
    pose = xyzabc_from_frame(base_T_tool(CELL, CELL.to_q(np.array([*q0, 100.0, 5.0]))))
    x, y, z = 1e3 * pose[:3]
    a, b, c = np.rad2deg(pose[3:])
    axes = ",".join(f"A{k + 1} {v}" for k, v in enumerate(q0))
    lines = [
        "&ACCESS RVP",
        "DEF sample()",
        ";FOLD INI;%{PE}",
        "BAS(#INITMOV,0)",
        ";ENDFOLD",
        "$BASE={X 0,Y 0,Z 0,A 0,B 0,C 0}",
        "$TOOL={X 0,Y -41.763657,Z 415.577926,A 0,B 0,C -159.579784}",
        "$VEL.CP=0.1",
        f"PTP {{E6AXIS: {axes},E1 100.0,E2 5.0}} ; {{keep: X 1}}",
        f"LIN {{E6POS: X {x:.4f},Y {y:.4f},Z {z:.4f},A {a:.5f},B {b:.5f},C {c:.5f},E1 100.0,E2 5.0}} C_DIS",
        "WAIT SEC 0.5",
        f"  lin {{x {x + 20:.2f}, y {y:.7f}, z {z:.4f}, a {a:.5f}, b {b:.5f}, c {c:.5f}, e1 101.5, e2 5.5}} c_dis ; 20.0 over",
        "$OUT[3]=TRUE",
        f"CIRC {{X {x + 30:.4f},Y {y + 10:.4f},Z {z:.4f},A {a:.5f},B {b:.5f},C {c:.5f}}},"
        f"{{X {x + 20:.4f},Y {y + 20:.4f},Z {z:.4f},A {a:.5f},B {b:.5f},C {c:.5f},E1 103,E2 6}}",
        *([more] if more else []),
        "END",
    ]
    path = folder / "sample.src"
    path.write_bytes("\r\n".join(lines).encode() + b"\r\n; trailing \xe9\r\n")
    return path


def below_head(text: bytes) -> bytes:
    """The program without the lines that say that it is corrected."""
    lines = text.split(b"\n")
    first = next(k for k, line in enumerate(lines) if line.startswith(b"; CORRECTED by camrob compensate"))
    last = next(k for k, line in enumerate(lines) if line.startswith(b"; The original's own head"))
    assert all(line.startswith(b"; ") and line.endswith(b"\r") and len(line) <= 81 for line in lines[first : last + 1])
    return b"\n".join([*lines[:first], *lines[last + 1 :]])


def test_a_program_is_rewritten_and_nothing_else_in_it(tmp_path: Path, calibration: Path) -> None:
    source = program(tmp_path)
    result = compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out")
    assert result.summary.error_before.mean_mm > 0.5
    assert result.summary.error_after.max_mm < 3e-4
    assert result.summary.error_after.max_deg < 3e-5
    assert json.loads((tmp_path / "out" / "sample.json").read_text()) == result.summary.to_json()
    old, new = (
        t.split(b"\n") for t in (source.read_bytes(), below_head((tmp_path / "out" / "sample.src").read_bytes()))
    )
    assert len(old) == len(new)
    changed = [k for k, (a, b) in enumerate(zip(old, new, strict=True)) if a != b]
    assert changed == [8, 9, 11, 13]
    assert new[8].endswith(b"E1 100.0,E2 5.0} ; {keep: X 1}\r") and new[11].endswith(
        b"e1 101.5, e2 5.5} c_dis ; 20.0 over\r"
    )
    assert new[11].startswith(b"  lin {x ") and len(new[11].split(b"y ")[1].split(b",")[0].split(b".")[1]) == 7


@pytest.mark.parametrize("a4", [0.0, -1e-3, 1e-3])
def test_an_axis_near_zero_may_change_its_sign(tmp_path: Path, calibration: Path, a4: float) -> None:
    """A PTP to a pose says the axes' signs: a forearm that stood at 0 is turned by the correction, and T says where to."""
    axes = np.array([9.0, -77.0, 123.0, a4, 50.0, 27.0])
    pose = xyzabc_from_frame(base_T_tool(CELL, CELL.to_q(np.array([*axes, 100.0, 5.0]))))
    numbers = dict(zip("XYZABC", [*(1e3 * pose[:3]), *np.rad2deg(pose[3:])], strict=True))
    s, t = int(StatusTurn.of(CELL).status(axes[None])[0]), int(StatusTurn.turn(axes[None])[0])
    target = ",".join(f"{name} {value:.6f}" for name, value in numbers.items())
    source = program(tmp_path, q0=tuple(axes), more=f"PTP {{E6POS: {target},S {s},T {t},E1 100.0,E2 5.0}}")
    result = compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out")
    assert result.summary.error_after.max_mm < 3e-4
    played = replay(read_krl(tmp_path / "out" / "sample.src"), CELL)
    arm = CELL.to_axis_values(np.asarray(played.q))[-1, :6]
    said = re.search(rb"PTP \{E6POS:.*,S (\d+),T (\d+),E1", (tmp_path / "out" / "sample.src").read_bytes())
    assert said is not None and (int(said[1]), int(said[2])) == (s, int(StatusTurn.turn(arm[None])[0]))
    assert abs(arm[3] - a4) > 1.2e-3  # the correction turns one of the three through 0


def test_odd_bytes_in_comments_move_no_line(tmp_path: Path, calibration: Path) -> None:
    """0x85, 0x0C and 0x1C end a line for Python's text, not for a controller."""
    source = program(tmp_path)
    plain = compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "plain")
    odd = source.read_bytes().replace(b";FOLD INI", b"; a\x85b\x0cc\x1cd\x0be\r\n;FOLD INI")
    source.write_bytes(odd)
    result = compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out")
    new = below_head((tmp_path / "out" / "sample.src").read_bytes())
    as_plain = below_head((tmp_path / "plain" / "sample.src").read_bytes())
    assert new.replace(b"; a\x85b\x0cc\x1cd\x0be\r\n", b"") == as_plain
    assert result.summary.error_after == plain.summary.error_after


def test_what_the_cell_truly_is_meets_the_poses(tmp_path: Path, calibration: Path) -> None:
    """Not the model's word: the robot that was measured, with the errors that were drawn, runs the program."""
    source = program(tmp_path)
    compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out")
    asked = replay(read_krl(source), CELL)
    played = replay(read_krl(tmp_path / "out" / "sample.src"), CELL)
    e = pose_difference(np.asarray(asked.base_T_tool), MODEL.poses(VALUES, np.asarray(played.q)))
    before = pose_difference(np.asarray(asked.base_T_tool), MODEL.poses(VALUES, np.asarray(asked.q)))
    assert np.linalg.norm(before[:, :3], axis=1).max() > 1e-3
    e = np.delete(e, 3, axis=0)  # a CIRC's auxiliary point, where the table is under way
    assert np.linalg.norm(e[:, :3], axis=1).max() < 5e-5  # 0.02 mm of noise an axis in 120 poses


def test_a_rigid_shift_of_the_robot_shifts_the_program(tmp_path: Path) -> None:
    """Truth on paper: a robot 1 mm too far in +x of the world is sent 1 mm to -x, at E2 = 0."""
    result = calibrate_cell(
        CELL,
        measure(CELL, {"base.x": 1e-3}, axis_values(CELL, 60), sigma=1e-9, sigma_angle=1e-9),
        names=["base.x"],
        share=0.0,
    )
    (tmp_path / "C.toml").write_text(calibration_text(result))
    q0 = (9.0, -77.0, 123.0, -26.0, 50.0, 27.0)
    source = program(tmp_path, q0=q0)
    source.write_bytes(
        source.read_bytes().replace(b"E2 5.0", b"E2 0.0").replace(b"e2 5.5", b"e2 0.0").replace(b"E2 6", b"E2 0")
    )
    compensate(source, cell=CELL_FOLDER, calibration=tmp_path / "C.toml", out=tmp_path / "out")
    texts = source.read_bytes(), below_head((tmp_path / "out" / "sample.src").read_bytes())
    old, new = (t.decode("latin-1").splitlines()[9] for t in texts)
    x_old, x_new = (float(line.split("X ")[1].split(",")[0]) for line in (old, new))
    assert x_new - x_old == pytest.approx(-1.0, abs=2e-4)
    assert old.split(",")[1:3] == new.split(",")[1:3]


def test_limits_are_kept(tmp_path: Path, calibration: Path) -> None:
    low = -145.0 + 1e-4
    source = program(tmp_path, q0=(9.0, low, 100.0, -26.0, 50.0, 27.0))
    text = source.read_text(encoding="latin-1").splitlines(keepends=True)
    source.write_text("".join([*text[:9], "END\n"]), encoding="latin-1")
    found = {}
    for sign in (1.0, -1.0):
        data = measure(CELL, {"A2.zero": sign * 2e-3}, axis_values(CELL, 60))
        (tmp_path / "C.toml").write_text(calibration_text(calibrate_cell(CELL, data, names=["A2.zero"], share=0.0)))
        out = tmp_path / f"out{sign}"
        found[sign] = compensate(source, cell=CELL_FOLDER, calibration=tmp_path / "C.toml", out=out).summary
        assert found[sign].limits.margin_min["A2"] >= 0.0
    short, free = ([w for w in found[sign].warnings if w.code == "limit"] for sign in (1.0, -1.0))
    assert [(w.text, w.line) for w in short] == [("1 point is corrected in part only: A2 is at its limit", 9)]
    assert found[1.0].error_after.max_mm == pytest.approx(found[1.0].error_before.max_mm, rel=2e-3)
    assert any(w.code == "residual" for w in found[1.0].warnings)
    assert free == [] and found[-1.0].error_after.max_mm < 3e-4


def test_corrections_fade_towards_a_limit(tmp_path: Path) -> None:
    """Where the limit is near, what it leaves is used, and neighbours stay neighbours: the correction has no step."""
    data = measure(CELL, {"A2.zero": 2e-3}, axis_values(CELL, 60))
    (tmp_path / "C.toml").write_text(calibration_text(calibrate_cell(CELL, data, names=["A2.zero"], share=0.0)))
    a2 = np.linspace(-144.7, -144.999, 13)
    rows = [f"PTP {{E6AXIS: A1 9,A2 {v:.5f},A3 100,A4 -26,A5 50,A6 27,E1 100,E2 5}}" for v in a2]
    source = tmp_path / "fade.src"
    source.write_text("\n".join(["DEF fade()", "BAS(#INITMOV,0)", *rows, "END", ""]))
    result = compensate(source, cell=CELL_FOLDER, calibration=tmp_path / "C.toml", out=tmp_path / "out")
    after = np.load(tmp_path / "out" / "fade.path.npz")["axis_values"][:, 1]
    moved = a2 - after
    assert np.all(after >= -145.0) and np.allclose(moved[:7], np.rad2deg(2e-3), atol=1e-3)
    assert np.all(np.diff(moved) < 1e-3) and np.max(np.abs(np.diff(after))) < 0.03
    assert np.all(np.diff(result.error_after[8:, 0]) > 0.0)
    assert "points are corrected in part only: A2" in "".join(w.text for w in result.summary.warnings)


def test_programs_that_can_t_be_rewritten_are_refused(tmp_path: Path, calibration: Path) -> None:
    def attempt(more: str) -> None:
        source = program(tmp_path, more=more)
        compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out")

    with pytest.raises(KrlError, match=r"sample\.src:15: the motion's target is not written"):
        target = program(tmp_path).read_text(encoding="latin-1").splitlines()[9].split("E6POS: ")[1].split("}")[0]
        (tmp_path / "sample.dat").write_text(f"DEFDAT sample\nDECL E6POS P1={{{target}}}\nENDDAT\n")
        attempt("LIN P1")
    (tmp_path / "sample.dat").unlink()
    with pytest.raises(InputError, match="choose another --out"):
        compensate(program(tmp_path), cell=CELL_FOLDER, calibration=calibration, out=tmp_path)
    assert not (tmp_path / "out").exists()
    with pytest.raises(StaleInputError, match="of cell kr15_track_table, not of other"):
        from camrob.calibration.calibration_file import read_calibration

        read_calibration(calibration, CELL).check(replace(CELL, name="other"))


def test_the_text_of_targets() -> None:
    pose = NewTarget((1.5, -2.25, 3.0, 10.0, -0.000001, 90.0), False)
    assert patch_source("LIN {X 1,Y 2,Z 3,A 4,B 5,C 6}\n", {1: [pose]}) == (
        "LIN {X 1.5000,Y -2.2500,Z 3.0000,A 10.00000,B 0.00000,C 90.00000}\n"
    )
    assert patch_source("LIN {POS: X 1, Z -3.000000} ;X 9", {1: [pose]}) == (
        "LIN {POS: X 1.5000, Z 3.000000,Y -2.2500,A 10.00000,B 0.00000,C 90.00000} ;X 9"
    )
    kept = patch_source("PTP {E6POS: X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35,E1 -7.5,E2 0.0}", {1: [pose]})
    assert kept.endswith("C 90.00000,S 2,T 35,E1 -7.5,E2 0.0}")
    turned = NewTarget(pose.values, False, turn=11)
    new = patch_source("PTP {E6POS: X 1,Y 2,Z 3,A 4,B 5,C 6,S 2,T 35,E1 -7.5,E2 0.0}", {1: [turned]})
    assert new == kept.replace("T 35", "T 11")
    axes = NewTarget((1.0, 2.0, 3.0, 4.0, 5.0, 6.0), True)
    assert patch_source("PTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0,E1 5}", {1: [axes]}) == (
        "PTP {A1 1.00000,A2 2.00000,A3 3.00000,A4 4.00000,A5 5.00000,A6 6.00000,E1 5}"
    )
    for text, message in [
        ("LIN P1", "is not written in the statement"),
        ("LIN {X 1+2,Y 2,Z 3}", "X is not a plain number"),
        ("LIN {E1 5}", "holds no pose"),
        ("$BASE={X 1,Y 2}", "is not written in the statement"),
    ]:
        with pytest.raises(KrlError, match=message) as caught:
            patch_source("\n" + text, {2: [pose]})
        assert caught.value.line == 2
    assert [literal_targets(t) for t in ("LIN P1", "CIRC {X 1},{X 2}", "$BASE={X 1}", ";LIN {X 1}")] == [0, 2, 0, 0]


def test_motions_of_the_spline_kind_are_rewritten_too() -> None:
    new = NewTarget((1.5, 2.0, 3.0, 4.0, 5.0, 6.0), False)
    for word in ("LIN", "SLIN", "SPTP"):
        text = f"{word} {{X 1,Y 2,Z 3,A 4,B 5,C 6}} C_SPL"
        assert patch_source(text, {1: [new]}).startswith(f"{word} {{X 1.5000,Y 2.0000")
    assert literal_targets("SPL {X 1}") == 0


def test_the_command(tmp_path: Path, calibration: Path, capsys) -> None:
    source = program(tmp_path)
    command = ["compensate", str(source), "--cell", str(CELL_FOLDER), "--calibration", str(calibration)]
    assert run([*command, "--out", str(tmp_path / "out"), "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["error_after"]["max_mm"] < 3e-4
    broken = tmp_path / "broken.toml"
    broken.write_text("schema = 1\n")
    assert run([*command[:-1], str(broken), "--out", str(tmp_path / "out2")]) == 2
    assert "broken.toml" in capsys.readouterr().err


# --- section III of the paper ---------------------------------------------------------------------------------------------


def test_compensation_of_a_real_program_brings_no_new_hurry(tmp_path: Path, calibration: Path) -> None:
    source = SHARED / "gap_samples" / "cases" / "a_nothing" / "circle1.src"
    if not source.is_file():
        pytest.skip("../shared is not here: gap_samples")
    summary = compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out").summary
    assert summary.error_before.mean_mm > 0.5 and summary.error_after.max_mm < 3e-4
    for rates in summary.derivatives.values():
        assert rates.after > 0.95 * rates.before
    assert summary.error_between.max_mm < 0.02


# --- eight axes, solved paths, the report ---------------------------------------------------------------------------------


def test_external_axes_stay_as_planned_and_the_arm_is_corrected(tmp_path: Path, calibration: Path) -> None:
    """All that the controller gets to know of table, track, tool and base is what it was; A1 to A6 follow from other poses."""
    source = program(tmp_path)
    summary = compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out").summary
    old, new = read_krl(source), read_krl(tmp_path / "out" / "sample.src")
    assert np.array_equal(old.external, new.external) and np.ptp(old.external[:, 0]) > 2.0
    assert [f.text for f in old.tools] == [f.text for f in new.tools]
    assert [f.text for f in old.bases] == [f.text for f in new.bases]
    assert np.array_equal(old.speed, new.speed) and np.array_equal(old.blend, new.blend)
    axes = summary.correction.axes
    assert list(axes) == ["A1", "A2", "A3", "A4", "A5", "A6", "E1", "E2"]
    assert axes["E1"].max_mm == 0.0 == axes["E2"].max_deg
    assert all(axes[f"A{k}"].max_deg > 1e-4 for k in range(1, 7))
    assert all(margin is None or margin >= 0.0 for margin in summary.limits.margin_min.values())
    assert any(w.text.startswith("backlash, drift") for w in summary.warnings)


def solved(folder: Path, count: int = 60) -> Path:
    """A solved path with all eight axes moving, as `camrob post` writes it."""
    ends = np.array(
        [[9.0, -77.0, 123.0, -26.0, 50.0, 27.0, 100.0, 5.0], [11.0, -75.0, 121.0, -24.0, 52.0, 25.0, 140.0, 9.0]]
    )
    values = ends[0] + np.linspace(0.0, 1.0, count)[:, None] * (ends[1] - ends[0])
    path = folder / "bow.path.npz"
    line = np.arange(10, 10 + count)
    np.savez(path, q=CELL.to_q(values), axes=np.array(CELL.names), axis_values=values, line=line)
    return path


def test_a_solved_path_becomes_a_compensated_program(tmp_path: Path, calibration: Path, capsys) -> None:
    source = solved(tmp_path)
    result = compensate(source, cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out", feed=1200.0)
    out = tmp_path / "out"
    assert {f.name for f in out.iterdir()} == {*result.summary.files} >= {"bow.src", "bow.path.npz", "bow.html"}
    text = read_krl(out / "bow.src")
    assert text.kind.tolist() == [Motion.PTP_AXES] + [Motion.LIN] * 59
    assert np.allclose(text.speed[1:], 0.02)
    with np.load(source) as before, np.load(out / "bow.path.npz") as after:
        assert np.allclose(after["axis_values"][:, 6:], before["axis_values"][:, 6:], atol=1e-3)
        targets = base_T_tool(CELL, before["q"])
        e = pose_difference(targets, MODEL.poses(VALUES, after["q"]))  # the robot that was drawn
        assert np.linalg.norm(e[:, :3], axis=1).max() < 5e-5
    assert result.summary.error_after.max_mm < 3e-4 < 0.3 < result.summary.error_before.mean_mm
    assert run(["verify", str(out / "bow.src"), "--cell", str(CELL_FOLDER), "--quiet"]) == 0
    command = [
        "compensate",
        "--cell",
        str(CELL_FOLDER),
        "--calibration",
        str(calibration),
        "--out",
        str(tmp_path / "no"),
    ]
    (tmp_path / "torn.path.npz").write_bytes(source.read_bytes()[:200])
    other = tmp_path / "other.path.npz"
    np.savez(other, q=np.zeros((9, 6)), axes=np.array(["A1"] * 6), line=np.zeros(9, int))
    capsys.readouterr()
    for given, message in [
        ([str(source)], "bow.path.npz: holds no speeds; give --feed in mm/min"),
        ([str(source), "--feed", "0"], "a feed of 0 mm/min can't be run"),
        ([str(program(tmp_path)), "--feed", "900"], "sample.src: writes its own speeds; leave --feed out"),
        ([str(tmp_path / "torn.path.npz"), "--feed", "900"], "torn.path.npz: is not a solved path"),
        ([str(other), "--feed", "900"], "other.path.npz: holds postures of another cell"),
        ([str(tmp_path / "none.path.npz"), "--feed", "900"], "none.path.npz: is not a solved path"),
    ]:
        assert run([*command, *given]) == 2
        line = capsys.readouterr().err.strip()
        assert message in line and len(line.splitlines()) == 1 and not (tmp_path / "no").exists()


def test_a_new_violation_is_said_and_an_old_one_is_not_new(tmp_path: Path) -> None:
    """A trembling axis passes bounds that it kept; what was passed before as much is nobody's fault."""
    path = solved(tmp_path)
    text = read_krl(program_of_solution(path, CELL, 6000.0, tmp_path))
    planned = replay(text, CELL)
    q = np.asarray(planned.q)
    trembling = q.copy()
    trembling[::2, CELL.index("A4")] += 3e-3
    same = rates_and_violations(analyses_before_after(CELL, text, q, q), text, planned)[1]
    assert same.new == () and same.before == same.after
    worse = rates_and_violations(analyses_before_after(CELL, text, q, trembling), text, planned)[1]
    assert "A4" in {v.axis for v in worse.new} and worse.after > worse.before
    assert all(v.times > 1.0 and v.line > 0 for v in worse.new)
    better = rates_and_violations(analyses_before_after(CELL, text, trembling, q), text, planned)[1]
    assert better.new == ()


def test_the_page_of_a_compensation(tmp_path: Path, calibration: Path) -> None:
    compensate(solved(tmp_path), cell=CELL_FOLDER, calibration=calibration, out=tmp_path / "out", feed=1200.0)
    page = (tmp_path / "out" / "bow.html").read_text()
    charts = block_of(page, "charts")
    assert {c["id"]: c["ruler"] for c in charts} == {
        "error-position": "motion",
        "error-orientation": "motion",
        "corrections": "motion",
        "rates": "s",
    }
    for text in ("Compensation of BOW", "backlash, drift", "as planned", "no new violation", "Axis by axis"):
        assert text in page
    assert "://" not in re.sub(r"<script>.*?</script>", "", page, flags=re.DOTALL)
