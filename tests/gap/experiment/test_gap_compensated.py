"""Compensation on the machine as diagnosed: what is no constant of the chain is taken off the path, and truly so.

The true machine is `gap_generator`'s, which shares no code with camrob; the linear algebra is held to a dense solution.
"""

from __future__ import annotations

import json
import re
import shutil
from itertools import groupby
from pathlib import Path

import numpy as np
import pytest
from gap_cases import KR15, bench_accuracy, closed_loop, generator
from test_gap_program import HEAD, HOME, start

from camrob import post
from camrob.errors import InputError
from camrob.gap.effects.effect import EffectParameter, Unit
from camrob.gap.effects.registry import library
from camrob.gap.fitted_units import FittedUnits
from camrob.jobs.closing.added_targets import places_to_add
from camrob.jobs.closing.diagnosed_machine import DiagnosedMachine, shifted
from camrob.jobs.closing.run_way import RunWay, arcs_of
from camrob.jobs.compensate import compensate
from camrob.jobs.diagnose import diagnose
from camrob.jobs.files.cell_for import cell_for
from camrob.languages import language_of_file
from camrob.measurement.write_log import write_log
from camrob.prediction.deflection import CAUSE
from camrob.program.motion import Motion


def test_ends_hold_the_best_straight_lines_between_them() -> None:
    rng = np.random.default_rng(3)
    kind = np.array([Motion.PTP_AXES, Motion.LIN, Motion.LIN, Motion.CIRC_VIA, Motion.CIRC_END, Motion.LIN])
    motion = np.repeat([0, 1, 2, 4, 5], [3, 40, 50, 60, 30])
    step = rng.uniform(1e-3, 2e-3, len(motion))
    values = rng.normal(size=(len(motion), 2))
    got = RunWay(kind, motion, step).fit(values)
    ends = [0, 1, 2, 4, 5]
    hat = np.zeros((len(motion), len(ends)))
    for j, end in enumerate(ends):
        rows = np.flatnonzero(motion == end)
        share = np.cumsum(step[rows]) / step[rows].sum()
        hat[rows, j] = share if j else 1.0
        if j:
            hat[rows, j - 1] = 1.0 - share
    weight = np.sqrt(np.where(motion == 0, 1e-3, 1.0) * step)
    best = np.linalg.lstsq(hat * weight[:, None], values * weight[:, None], rcond=None)[0]
    assert np.allclose(got[ends], best, atol=0.02)
    assert np.allclose(got[3], 0.5 * (got[2] + got[4]))


def test_what_is_linear_along_the_motions_is_met_exactly() -> None:
    kind = np.full(4, Motion.LIN)
    motion = np.repeat(np.arange(4), 25)
    step = np.full(100, 1e-3)
    share = np.tile(np.arange(1, 26) / 25, 4)
    nodes = np.array([2.0, -1.0, 3.0, 0.5])
    values = np.where(motion == 0, nodes[0], (1 - share) * nodes[np.maximum(motion - 1, 0)] + share * nodes[motion])
    assert np.allclose(RunWay(kind, motion, step).fit(values[:, None])[:, 0], nodes, atol=2e-3)


def test_a_kink_within_a_line_is_met_where_the_line_is_divided_there() -> None:
    kind = np.full(4, Motion.LIN)
    motion = np.repeat(np.arange(4), 40)
    way = RunWay(kind, motion, np.full(160, 1e-3))
    at = np.cumsum(way.step)
    values = np.interp(at, [0.04, 0.07, 0.08, 0.09, 0.11, 0.16], [0.0, 0.0, 1.0, -1.0, 2.0, 2.0])[:, None]
    share = way.share()
    divided = way.split({1: [share[69]], 2: [share[89], share[109]]})
    off = [float(np.abs(w.between(w.fit(values)) - values)[40:].max()) for w in (way, divided)]
    assert off[0] > 0.2 and off[1] < 2e-3
    assert divided.kind.tolist() == [Motion.LIN] * 7
    assert np.bincount(divided.motion).tolist() == [40, 30, 10, 10, 20, 10, 40]


def test_an_arc_that_is_shifted_turned_and_widened_is_met_by_its_three_points(tmp_path: Path) -> None:
    """Three points on a circle by its centre, and what a force along the feed does to it."""
    radius, first, via, last = 40.0, 0.4, 1.1, 3.0

    def place(u: np.ndarray) -> np.ndarray:
        return np.stack([900.0 + radius * np.cos(u), 20.0 + radius * np.sin(u), np.full_like(u, 400.0)], axis=-1)

    points = [f"{{X {x:.9f},Y {y:.9f},Z {z:.9f},A 0,B 90,C 0}}" for x, y, z in place(np.array([first, via, last]))]
    file = tmp_path / "arc.src"
    file.write_text("\n".join(["DEF arc()", HOME, f"LIN {points[0]}", f"CIRC {points[1]},{points[2]}", "END"]))
    text = language_of_file(file).read(file, None)
    arcs = arcs_of(text)
    assert np.allclose(arcs[3], [via - first, last - via], atol=1e-6) and not arcs[:3].any()
    u = np.linspace(first, last, 401)[1:]
    outward = np.stack([np.cos(u), np.sin(u), 0.0 * u], axis=1)
    ahead = np.stack([-np.sin(u), np.cos(u), 0.0 * u], axis=1)
    values = np.array([0.3, -0.2, 0.1]) + 0.5 * outward - 0.7 * ahead
    motion = np.repeat([1, 3], [1, len(u)])
    step = np.append(1e-3, np.full(len(u), 1e-3 * radius * (last - first) / len(u)))
    all_values = np.concatenate([values[:1], values])
    off = [
        np.abs(way.between(way.fit(all_values)) - all_values)[2:].max()
        for way in (RunWay(np.asarray(text.kind), motion, step, arcs), RunWay(np.asarray(text.kind), motion, step))
    ]
    assert off[0] < 2e-3 and off[1] > 0.3


def test_a_machine_that_errs_by_a_twist_meets_the_shifted_target() -> None:
    rng = np.random.default_rng(5)
    targets = np.tile(np.eye(4), (4, 1, 1))
    targets[:, :3, :3] = [generator.turn(w) for w in rng.normal(0, 1.0, (4, 3))]
    targets[:, :3, 3] = rng.normal(size=(4, 3))
    twists = rng.normal(0, 1e-3, (4, 6))
    met = shifted(targets, twists)
    met[:, :3, 3] += twists[:, :3]
    met[:, :3, :3] = np.stack([generator.turn(w) for w in twists[:, 3:]]) @ met[:, :3, :3]
    assert np.allclose(met, targets, atol=1e-12)


def circles(folder: Path) -> Path:
    """A program of circles of some 100 mm in short lines, in which every axis of the arm turns back."""
    head = HEAD.replace("X 200,Y 0,Z 0,A 0,B 90,C 0", "X 0,Y -41.76366,Z 415.57793,A 0,B 0,C -159.57978").replace(
        "$VEL.CP=0.2", "$VEL.CP=0.06"
    )
    x, y, z, a, b, c = start(head)
    lines = []
    for k in range(3 * 60 + 1):
        u = 2.0 * np.pi * k / 60.0
        lines.append(
            f"LIN {{X {x - 120 + 50 * np.cos(u) + 0.1 * k:.3f},Y {y + 55 * np.sin(u):.3f},Z {z - 150 + 30 * np.sin(u + 0.7):.3f},"
            f"A {a + 8 * np.sin(u):.3f},B {b + 6 * np.cos(u):.3f},C {c:.3f},E1 0,E2 0}} C_DIS"
        )
    path = folder / "circles.src"
    path.write_text(head + "$APO.CDIS=0.3\n" + "\n".join([HOME, *lines]) + "\nEND\n")
    return path


def three_plays(world) -> None:
    """Play in the first three axes, which no constant of the chain corrects."""
    for axis, width in ((0, 0.016), (1, 0.013), (2, 0.018)):
        world.link[:, axis] += generator.play(world.command[:, axis], width * closed_loop.DEG)


def test_play_is_taken_off_the_path_of_the_true_machine(tmp_path: Path) -> None:
    """The published way (constants alone) has nothing to correct here; what the diagnosis tells takes half of the error."""
    program = circles(tmp_path)
    first = closed_loop.run_on_cell(program, three_plays, 1)
    write_log(first, tmp_path / "run1.csv")
    diagnose(cell=KR15, log=[tmp_path / "run1.csv"], out=tmp_path / "diagnosis")
    summary = json.loads((tmp_path / "diagnosis" / "diagnosis.json").read_text())
    assert [e["effect"] for e in summary["effects"] if e["probability"] > 0.5] == ["backlash"]

    said = compensate(program, cell=KR15, diagnosis=tmp_path / "diagnosis", out=tmp_path / "out").summary
    assert said.machine is not None and said.calibration is None
    assert set(said.machine.causes) == {"backlash of A1", "backlash of A2", "backlash of A3"}
    assert said.machine.after.rms_mm < 0.6 * said.machine.before.rms_mm
    (page,) = (tmp_path / "out").glob("*.html")
    words = page.read_text(encoding="utf-8")
    assert "Off the path, as diagnosed" in words
    assert "on the diagnosed chain" in words and "calibrated" not in words  # nothing was

    (added,) = said.machine.targets_added.values()
    quiet = [
        off_path(program, program, three_plays),
        off_path(tmp_path / "out" / program.name, program, three_plays, added),
    ]
    rms, worst = [float(np.sqrt(np.mean(e**2))) for e in quiet], [e.max() for e in quiet]
    assert rms[1] < 0.6 * rms[0]
    assert rms[0] == pytest.approx(said.machine.before.rms_mm, rel=0.15)
    assert rms[1] == pytest.approx(said.machine.after.rms_mm, rel=0.25)
    assert worst[1] < worst[0]
    # all but the targets is as it was, and what was added is a copy of the line behind it
    old, new = (
        [re.sub(r"[-.\d]+", "0", line) for line in p.read_text().splitlines()]
        for p in (program, tmp_path / "out" / program.name)
    )
    head = closed_loop.lines_of_head(tmp_path / "out" / program.name)
    assert len(added) == len(new) - len(old) - len(head) > 0 and head
    assert all(new[line - 1] == new[line] for line in added)
    del new[head[0] - 1 : head[-1]]
    assert [line for line, _ in groupby(old)] == [line for line, _ in groupby(new)]


def test_no_file_gets_more_motions_than_its_controller_takes(tmp_path: Path) -> None:
    """And those that it gets are where they matter most."""
    program = circles(tmp_path)
    cell = tmp_path / "cell"
    shutil.copytree(KR15, cell)
    text = (cell / "cell.toml").read_text()
    full = 1 + sum(line.startswith("LIN") for line in program.read_text().splitlines())
    (cell / "cell.toml").write_text(re.sub(r"max_lines = \d+", f"max_lines = {full + 3}", text))
    machine = DiagnosedMachine(cell_for("compensate", cell), None, None, 0.0, "")
    run = machine.run(language_of_file(program).read(program))
    kink = np.maximum(np.abs(np.arange(len(run.log)) - len(run.log) // 2)[:, None] * -1e-6 + 4e-4, 0.0)
    twist = kink * np.array([1.0, 0, 0, 0, 0, 0]) + 1e-4 * np.sign(np.sin(np.arange(len(run.log)) / 40.0))[:, None]
    object.__setattr__(run, "beyond_constants", twist)
    places = places_to_add(run, language_of_file(program), tmp_path)
    assert sum(map(len, places.values())) == 3
    (cell / "cell.toml").write_text(text)
    machine = DiagnosedMachine(cell_for("compensate", cell), None, None, 0.0, "")
    free = machine.run(language_of_file(program).read(program))
    object.__setattr__(free, "beyond_constants", twist)
    assert sum(map(len, places_to_add(free, language_of_file(program), tmp_path).values())) > 10


def off_path(run: Path, intended: Path, apply, added: tuple[int, ...] = ()) -> np.ndarray:
    """(N,) mm of the true machine's tool, without the instrument's noise, off the path that was meant.

    added: lines of the program that ran which the intended one does not have.
    """
    log = closed_loop.run_on_cell(run, apply, 2, sigma_mm=0.0)
    return closed_loop.off_path(log, intended, added=(*closed_loop.lines_of_head(run), *added))


@pytest.mark.slow
def test_what_late_drives_leave_in_corners_asks_for_a_lower_feed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A zigzag with a drive that is 30 ms late: said at its feed, and not at a twentieth of it, where a twentieth is left."""
    unit = Unit("servo_lag", "A1", (EffectParameter("A1_s", "s", 0.02, 0.0, 1.0),))
    effect = next(e for e in library() if e.name == "servo_lag")
    found = FittedUnits((unit,), (effect,), ({},), np.array([0.03]), np.zeros((1, 1)), None)
    monkeypatch.setattr("camrob.jobs.compensate.diagnosed", lambda *_: (found, 0.0))
    left, said = [], []
    for name, speed in (("fast", 0.06), ("slow", 0.003)):
        (tmp_path / name).mkdir()
        program = zigzag(tmp_path / name, speed)
        machine = DiagnosedMachine(cell_for("compensate", KR15), None, found, 0.0, "")
        left.append(machine.run(language_of_file(program).read(program)).left_of_speed().within(0.95))
        made = compensate(program, cell=KR15, diagnosis=tmp_path, out=tmp_path / f"{name}_out").summary
        said.append({w.code for w in made.warnings})
    assert left[0] > 1e-4 and left[1] < 0.1 * left[0]
    assert "left-by-speed" in said[0] and "left-by-speed" not in said[1]


def zigzag(folder: Path, speed: float) -> Path:
    """A program of lines of 8 mm that turn by right angles, at a speed in m/s."""
    head = HEAD.replace("$VEL.CP=0.2", f"$VEL.CP={speed}")
    x, y, z, a, b, c = start(head)
    places = [(x - 60 + 8 * ((k + 1) // 2), y + 8 * (k // 2), z - 100) for k in range(12)]
    turned = f"A {a:.3f},B {b:.3f},C {c:.3f},E1 0,E2 0"
    lines = [f"LIN {{X {u:.3f},Y {v:.3f},Z {w:.3f},{turned}}}" for u, v, w in places]
    path = folder / "zigzag.src"
    path.write_text(head + "\n".join([HOME, *lines]) + "\nEND\n")
    return path


def test_without_any_word_of_what_is_wrong_it_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="nothing says what is wrong with the machine"):
        compensate(circles(tmp_path), cell=KR15, out=tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.slow
def test_what_yields_under_a_stated_force_is_taken_off_too(tmp_path: Path) -> None:
    """The arm of springs is the bench's; the force that it feels is up to 30 % other than the stated one."""
    clfile = bench_accuracy.raster_file(tmp_path, 1)
    apply = bench_accuracy.effects("force", 1)
    post(clfile, cell=KR15, out=tmp_path / "post", report=False)
    program = tmp_path / "post" / "raster.src"
    write_log(closed_loop.run_on_cell(program, apply, 1), tmp_path / "run.csv")
    file, found = tmp_path / "fitted.toml", tmp_path / "diagnosis"
    diagnose(cell=KR15, log=[tmp_path / "run.csv"], out=found, calibration=file)
    along, across, axial = bench_accuracy.STATED
    (tmp_path / "force.toml").write_text(
        f"fastest_cut_mm_min = {bench_accuracy.FEED}\n[mean]\nalong_n = {along}\nacross_n = {across}\naxial_n = {axial}\n"
    )
    _, asked = bench_accuracy.errors_on_cell(program, apply)
    rms = {}
    for name, force in (("constants", None), ("force", tmp_path / "force.toml")):
        said = compensate(
            program, cell=KR15, calibration=file, diagnosis=found, force=force, out=tmp_path / name
        ).summary
        off = bench_accuracy.errors_on_cell(tmp_path / name / "raster.src", apply, asked)[0]
        rms[name] = float(np.sqrt(np.mean(off**2)))
    assert said.machine is not None and CAUSE in said.machine.causes
    assert rms["force"] < 0.5 * rms["constants"]


def test_a_force_that_only_the_removal_tells_is_refused(tmp_path: Path) -> None:
    (tmp_path / "force.toml").write_text(
        "[milling]\nteeth = 2\ndiameter_mm = 6\nspindle_rpm = 9000\ntangential_n_mm2 = 700\nradial_n_mm2 = 250\n"
        "axial_n_mm2 = 100\n"
    )
    with pytest.raises(InputError, match="leaves depth or width to the removal; give depth_mm and width_mm, or stock"):
        compensate(circles(tmp_path), cell=KR15, force=tmp_path / "force.toml", out=tmp_path / "out")
    assert not (tmp_path / "out").exists()
