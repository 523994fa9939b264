"""The cutting force and what it bends: closed forms of a slot, an arm of springs that is not camrob's, a file's own words."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from calibration_sample import calibration
from test_predict import CELL, MM, ROOT, program

from camrob.calibration.calibration_file import read_calibration
from camrob.cell.read_cell import read_cell
from camrob.controller.replay import program_cell
from camrob.controller.simulate import simulate
from camrob.cutting.cutter import Cutter
from camrob.cutting.dexels import Dexels, Moves
from camrob.cutting.engagement import removed_area
from camrob.errors import InputError
from camrob.jobs.closing.diagnosed_machine import OffWay
from camrob.jobs.compensate import compensate
from camrob.jobs.predict import predict
from camrob.jobs.solving.machine_errors import machine_errors
from camrob.jobs.solving.sought import Sought
from camrob.languages.krl.reader.read_krl import read_krl
from camrob.prediction.deflection import CAUSE
from camrob.prediction.force_model import CuttingForce, Milling
from camrob.prediction.read_force import read_forces
from camrob.prediction.true_path import true_path

sys.path.insert(0, str(ROOT / "tests" / "bench"))

from gap import generator

__all__ = ["program"]

TURN = 200.0  # a second
CHIP, EDGE = np.array([8e8, 3e8, 1e8]), np.array([2e4, 1.5e4, 5e3])


def mill(**other) -> Milling:
    given = {"teeth": 2, "diameter": 6 * MM, "rate": TURN, "side": 0, "sense": 1, "depth": 2 * MM, "width": 6 * MM}
    return Milling(CHIP, EDGE, **{**given, **other})


def test_a_slot_pushes_as_its_integrals_say() -> None:
    """Altintas (2012), eq. 2.39: the mean of a slot is N a/4 K c + N a/pi K_e; along the tool N a/pi K_a c + N a/2 K_ae."""
    c, N, a = 0.05 * MM, 2, 2 * MM
    got = mill().mean(np.array([c * N * TURN]))[0]
    along = -N * a / 4 * CHIP[1] * c - N * a / np.pi * EDGE[1]
    across = N * a / 4 * CHIP[0] * c + N * a / np.pi * EDGE[0]
    axial = N * a / np.pi * CHIP[2] * c + N * a / 2 * EDGE[2]
    np.testing.assert_allclose(got, [along, across, axial], rtol=1e-4)
    other = mill(sense=-1).mean(np.array([c * N * TURN]))[0]
    np.testing.assert_allclose(other, [along, -across, axial], rtol=1e-4)


@pytest.mark.parametrize("width", [1.0, 2.5, 5.0])
def test_a_side_cut_pushes_as_a_finer_sum_says(width: float) -> None:
    feed = np.array([0.02])
    got = mill(side=1, width=width * MM).mean(feed)[0]
    begin = np.arcsin(1.0 - width / 3.0)
    theta = np.linspace(begin, np.pi / 2, 200_001)
    h = 0.02 / (2 * TURN) * np.cos(theta)
    t, r, a = (k * h + e for k, e in zip(CHIP, EDGE, strict=True))
    own = [-t * np.sin(theta) - r * np.cos(theta), t * np.cos(theta) - r * np.sin(theta), a]
    expected = [2 * 2 * MM / (2 * np.pi) * np.trapezoid(x, theta) for x in own]
    np.testing.assert_allclose(got, expected, rtol=0.02, atol=0.02 * np.abs(expected).max())


def test_the_removal_says_how_much_is_engaged() -> None:
    tip = np.c_[np.linspace(-10, 50, 61), np.full(61, 10.0), np.full(61, 8.0)] * MM
    moves = Moves.along(tip, np.tile([0.0, 0.0, 1.0], (61, 1)), Cutter(5 * MM, 0.0, 40 * MM))
    stock = Dexels(np.zeros(3), np.array([40, 20, 10]) * MM, 0.2 * MM)
    before = stock.volume()
    area = removed_area(stock, moves, parts=30)
    assert stock.volume() == before
    inside = (tip[1:, 0] > 8 * MM) & (tip[1:, 0] < 32 * MM)
    np.testing.assert_allclose(area[inside], 20e-6, rtol=0.02)  # 10 mm wide, 2 mm deep
    assert np.all(area[tip[1:, 0] < -6 * MM] == 0.0)
    forces = mill(diameter=10 * MM, width=np.nan).mean(np.full(60, 0.02), area)
    full = mill(diameter=10 * MM, width=10 * MM).mean(np.full(60, 0.02))
    np.testing.assert_allclose(forces[inside], full[inside], rtol=0.03)
    assert np.all(forces[tip[1:, 0] < -6 * MM] == 0.0)


def force_file(folder: Path, text: str) -> Path:
    file = folder / "FORCE.toml"
    file.write_text(text, encoding="utf-8")
    return file


def pushing(file: Path) -> CuttingForce:
    """What a file that speaks of one tool has push on it."""
    return read_forces(file).on([None], "a program")[0]


MEAN = "[mean]\nalong_n = -60\nacross_n = 30\naxial_n = 20\n"


MILL = "[milling]\nteeth = 2\ndiameter_mm = 6\nspindle_rpm = 12000\ndepth_mm = 2\nwidth_mm = 6\n"


def test_a_material_stands_for_its_coefficients(tmp_path: Path) -> None:
    """A slot in Al7075-T6, 0.05 mm a tooth and 2 mm deep, by hand: 2 x 2/4 x 168.8 x 0.05 + 2 x 2/pi x 26.6 = 42.31 N hold it
    back; with its tangential coefficients 38.35 + 35.27 = 73.62 N push across.
    """
    force = pushing(force_file(tmp_path, MILL + 'material = "al7075-t6"\n'))
    along, across, _ = force.mean(np.array([0.05 * MM * 2 * TURN]))[0]
    assert (along, across) == (pytest.approx(-42.31, abs=0.05), pytest.approx(73.62, abs=0.05))
    assert force.doubt == pytest.approx(np.std([600.46, 767.01, 951.365, 1319.41], ddof=1) / 909.6, abs=0.01)
    assert pushing(force_file(tmp_path, "doubt = 0.1\n" + MILL + 'material = "al6082-t6"\n')).doubt == 0.1


@pytest.mark.parametrize(("across", "down"), [(1.0, 0.0), (1.0, 1.0), (0.001, 1.0), (0.0, 1.0)])
def test_a_plunge_is_not_pushed_aside(across: float, down: float, tmp_path: Path) -> None:
    """Of 60 N against the feed and 30 N across it there is the share of the feed that goes across the tool: none in a plunge, a
    thousandth where it drifts by that, and never all of it at the least drift.
    """
    force = pushing(force_file(tmp_path, MEAN))
    t = np.linspace(0.0, 1.0, 11)
    poses = np.tile(np.eye(4), (11, 1, 1))
    poses[:, :3, 3] = 5.0 * MM * t[:, None] * np.array([across, 0.0, -down])
    share = across / np.hypot(across, down)
    np.testing.assert_allclose(force.in_base(poses, t)[5], [-60.0 * share, 30.0 * share, 20.0], atol=1e-9)


def test_what_is_off_counts_by_the_way_not_by_the_time() -> None:
    """95 mm in 5 rows that are off by 1 mm, 5 mm of a slow plunge in 95 rows that are off by 3: the mean square is
    0.95 x 1 + 0.05 x 9 mm2, and 95 % of the way are within 1 mm, where 95 of 100 rows are off by 3.
    """
    off = OffWay(np.repeat([1.0, 3.0], [5, 95]), np.repeat([19.0, 5.0 / 95], [5, 95]), np.repeat([0, 1], [5, 95]))
    assert off.mean_square() == pytest.approx(1.4)
    assert off.within(0.94) == 1.0 and off.within(0.96) == 3.0
    np.testing.assert_allclose(off.by_motion(3), [1.0, 3.0, 0.0])


@pytest.mark.slow
def test_the_deflection_of_an_engraving_is_taken_off_where_it_cuts(program: Path, tmp_path: Path) -> None:
    """A tool that gives 2 um/N across and 0.5 along, 20 N across and 30 N along the tool: 0.040 and 0.015 mm off the path; 40 N
    against the feed only hold it back. At most a half of that may stay, and plunges that suffer for it are said.
    """
    force = force_file(
        tmp_path,
        "[mean]\nalong_n = -40\nacross_n = 20\naxial_n = 30\n[tool]\nacross_um_n = 2\nalong_um_n = 0.5\n",
    )
    said = compensate(program, cell=CELL, force=force, out=tmp_path / "out").summary
    assert said.machine is not None and said.machine.causes == (CAUSE,)
    assert said.machine.before.p95_mm == pytest.approx(np.hypot(0.040, 0.015), rel=0.05)
    assert said.machine.after.p95_mm < 0.5 * said.machine.before.p95_mm
    told = next(w for w in said.warnings if w.code == "farther-off")
    assert told.line > 0 and "farther off the path than before" in told.text


@pytest.mark.parametrize("measured", [True, False])
def test_springs_give_as_an_arm_of_other_code_says(program: Path, tmp_path: Path, measured: bool) -> None:
    """A1, A2 and A5 as they were measured, the others as such axes have beside these; or all of them as is ordinary, as the
    planner takes them.
    """
    given, own = np.array([2e-6, 3e-6, 0.0, 0.0, 8e-6, 0.0]), np.array([2, 3, 5])
    given[own] = np.mean([2e-6, 3e-6, 2e-6]) * np.array([1.0, 4.0, 4.0])
    yields = {f"A{k + 1}.compliance": given[k] for k in (0, 1, 4)}
    if not measured:
        planner = machine_errors(Sought(CELL), read_cell(CELL), None, pushing(force_file(tmp_path, MEAN)))
        given, own, yields = planner.compliance, np.arange(6), {"A1.zero": 1e-5}
    fitted = calibration(tmp_path / "fitted.toml", yields)
    cell = read_cell(CELL)
    text = read_krl(program)
    tooled, _ = program_cell(text, cell)
    run = simulate(text, cell, cycle=0.012).log
    force = pushing(force_file(tmp_path, "doubt = 0.1\n" + MEAN + "[tool]\nacross_um_n = 0.05\nalong_um_n = 0.01\n"))
    found = read_calibration(fitted, cell)
    path = true_path(run, tooled, found, None, rest=0.0, force=force)
    plain = true_path(run, tooled, found, None, rest=0.0)
    bent = path.causes[-1]
    assert bent.name == CAUSE and [c.name for c in path.causes[:-1]] == [c.name for c in plain.causes]
    np.testing.assert_allclose(path.true[:, :3, 3] - plain.true[:, :3, 3], bent.twist[:, :3], atol=1e-12)
    doubt = path.spread[:, :, -len(own) - 1 - (not measured) :]
    np.testing.assert_allclose(doubt[:, :, 0], 0.1 * bent.twist)
    assert path.granted == tuple(f"A{k + 1}" for k in own)
    if not measured:  # a correction leaves alone what is only ordinary
        bare = true_path(run, tooled, found, None, rest=0.0, force=force, assumed=False)
        assert bare.granted == () and np.linalg.norm(bare.causes[-1].twist[:, :3], axis=1).max() < 4e-6

    edge = np.array([1 / generator.DEG] * 6 + [1e3, 1 / generator.DEG])
    axis = run.setpoints(generator.AXES) / edge
    tip = path.ideal[:, :3, 3]
    cuts = np.linalg.norm(np.gradient(tip, np.asarray(run.t), axis=0), axis=1) > 1e-3
    rows = np.flatnonzero(cuts)[50::97]
    push = force.in_base(path.ideal, path.t)
    for k in rows:
        J = generator.jacobian(axis[k : k + 1])[0]
        c, s = np.cos(axis[k, 7]), np.sin(axis[k, 7])
        world_R_base = np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        f = world_R_base @ push[k]
        by_axis = J[:3] * (given * (J[:3].T @ f))
        expected = world_R_base.T @ by_axis[:, own] / np.sqrt(3.0)
        np.testing.assert_allclose(doubt[k, :3, 1 : 1 + len(own)], expected, atol=1e-10)
        moved = by_axis.sum(axis=1)
        if not measured:  # and all of them half or twice as much
            np.testing.assert_allclose(doubt[k, :3, -1], world_R_base.T @ moved * np.log(2.0), atol=1e-10)
        z = path.ideal[k, :3, 2]
        axial = (push[k] @ z) * z
        moved = world_R_base.T @ moved + 5e-8 * (push[k] - axial) + 1e-8 * axial
        np.testing.assert_allclose(bent.twist[k, :3], moved, atol=1e-10)
        assert push[k] @ z == pytest.approx(20.0)
    assert np.linalg.norm(push[rows], axis=1).max() == pytest.approx(70.0, rel=1e-6)


def test_what_is_cut_tells_compensate_how_hard_the_tool_is_pushed(program: Path, tmp_path: Path) -> None:
    """A ball of 3 mm, 0.8 mm deep in a plate, takes a circle's segment; the force is that of its area, however that is stated."""
    radius, depth = 1.5, 0.8
    segment = radius**2 * np.arccos((radius - depth) / radius) - (radius - depth) * np.sqrt(
        2 * radius * depth - depth**2
    )
    milling = (
        "fastest_cut_mm_min = 1500\n[milling]\nteeth = 2\ndiameter_mm = 3\nspindle_rpm = 18000\ntangential_n_mm2 = 2000\n"
        "radial_n_mm2 = 900\naxial_n_mm2 = 300\nwidth_mm = 3\n"
    )
    tool = "[tool]\nacross_um_n = 10\nalong_um_n = 2\n"
    setup, sizes = ROOT / "toolpaths/engraving/setup.toml", {}
    for name, more in (("stated", f"depth_mm = {segment / (2 * radius):.4f}\n"), ("removal", "")):
        force = force_file(tmp_path, milling + more + tool)
        asked = {"cell": CELL, "force": force, "out": tmp_path / name}
        if not more:
            with pytest.raises(InputError, match=r"leaves depth or width to the removal; .* by --setup"):
                compensate(program, **asked)
        said = compensate(program, **asked, setup=None if more else setup).summary
        assert said.machine is not None and said.machine.causes == (CAUSE,)
        sizes[name] = said.machine.before.rms_mm, said.machine.after.rms_mm / said.machine.before.rms_mm
    assert sizes["removal"][0] == pytest.approx(sizes["stated"][0], rel=0.1)
    assert sizes["removal"][1] < 0.5
    with pytest.raises(InputError, match="is not needed: nothing asks what is cut"):
        compensate(program, cell=CELL, force=force_file(tmp_path, MEAN), setup=setup, out=tmp_path / "needless")


@pytest.mark.slow
def test_the_page_says_what_pushes_and_what_cannot_be_told_apart(program: Path, tmp_path: Path) -> None:
    fitted = calibration(tmp_path / "fitted.toml", {"A2.compliance": 3e-6})
    asked = {"cell": CELL, "calibration": fitted, "setup": ROOT / "toolpaths/engraving/setup.toml", "pitch_mm": 0.4}
    force = force_file(
        tmp_path,
        "[milling]\nteeth = 2\ndiameter_mm = 6\nspindle_rpm = 12000\ndepth_mm = 1\n"
        "tangential_n_mm2 = 700\nradial_n_mm2 = 300\naxial_n_mm2 = 100\n",
    )
    made = predict(program, out=tmp_path / "out", cycle_ms=12.0, force=force, **asked)
    said = json.loads((tmp_path / "out" / "predict.json").read_text(encoding="utf-8"))
    assert said == made.summary.to_json()
    assert CAUSE in said["causes"] and CAUSE not in said["not_judged"] and said["force"]["yields"] == ["A2"]
    assert "the engagement from the removal" in said["force"]["told"] and said["force"]["deflection_p95_mm"] > 0.0
    page = (tmp_path / "out" / "predict.html").read_text(encoding="utf-8")
    assert '<td class="text">what yields</td><td class="text">' in page  # words: they run on, and numbers would not
    assert "The cutting force" in page and "only their product" in page
    plain = predict(program, out=tmp_path / "plain", cycle_ms=12.0, **asked)
    assert "force" not in plain.summary.to_json() and CAUSE in plain.summary.not_judged


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("doubt = 0.1\n", "mean"),
        (MEAN + "[milling]\nteeth = 2\n", "mean"),
        ("[mean]\nalong_n = nan\nacross_n = 0\naxial_n = 0\n", "mean.along_n"),
        (MEAN + "wrong = 3\n", "wrong"),
        (MEAN + "[[tool]]\nnumber = 1\n", "tool 1.mean: is missing"),
        ("[[tool]]\nnumber = 1\n[tool.mean]\nalong_n = 1\nacross_n = 1\naxial_n = 1\n" * 2, "number: 1 appears twice"),
        (MILL + 'material = "cheese"\n', "milling.material"),
        (MILL + 'material = "al6082-t6"\nradial_edge_n_mm = 3\n', "milling.radial_edge_n_mm: is given beside material"),
        (
            "[milling]\nteeth = 2\ndiameter_mm = 6\nspindle_rpm = 9000\nwidth_mm = 7\ntangential_n_mm2 = 1\nradial_n_mm2 = 1\n"
            "axial_n_mm2 = 1\n",
            "milling.width_mm",
        ),
    ],
)
def test_what_is_wrong_in_the_file_is_named(text: str, message: str, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=message):
        read_forces(force_file(tmp_path, text))
