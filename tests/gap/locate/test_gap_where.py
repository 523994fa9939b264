"""Where the gap lies: planted errors found in their direction, axis, stretch and regime, with intervals that hold them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from gap_cases import generator, kr15, simulated
from scipy.spatial import cKDTree
from test_gap_program import measured, raster

from camrob.controller.programmed_path import programmed_path
from camrob.controller.replay import program_cell, replay
from camrob.gap.diagnose import _laid_beside, diagnose
from camrob.gap.evidence.design import Panel, build_units, make_panel
from camrob.gap.locate.by_stage import STAGES, stage_gaps
from camrob.gap.locate.localise import axes_of, directions_of, lines_of, regimes_of, segments_of
from camrob.gap.observation.noise import noise_of
from camrob.gap.observation.program_track import track_of
from camrob.gap.observation.scene import make_scene
from camrob.kinematics.frames import world_T_base
from camrob.measurement.log import MeasurementLog

SIGMA = 0.02


def panel(log: MeasurementLog) -> Panel:
    scene = make_scene(log, kr15())
    noise = noise_of(scene)
    return make_panel(scene, 0, build_units([scene], [], {}), [], {}, noise, np.ones(len(scene), bool), 10, 0)


def shifted(direction: str):
    """0.3 mm at the tool, along an axis of world or of the tool."""

    def apply(world) -> None:
        if direction.startswith("tool"):
            part = {"tool_x": 0, "tool_y": 1, "tool_axis": 2}[direction]
            world.tool = generator.rigid(3e-4 * np.eye(6)[part])
        else:
            world.after[:, "xyz".index(direction)] += 3e-4

    return apply


@pytest.mark.parametrize("direction", ["x", "y", "z", "tool_x", "tool_y", "tool_axis"])
def test_a_shift_is_told_in_its_direction(direction: str) -> None:
    found = directions_of([panel(simulated(shifted(direction), sigma_mm=SIGMA))])
    same = ("tool_x", "tool_y", "tool_axis") if direction.startswith("tool") else ("x", "y", "z")
    assert max(same, key=lambda n: found[n].value) == direction
    assert found[direction].value == pytest.approx(3e-4, rel=0.02)
    assert found[direction].low <= found[direction].value <= found[direction].high
    assert found["along"].value ** 2 + found["across"].value ** 2 == pytest.approx(
        9e-8 + 3 * (SIGMA * 1e-3) ** 2, rel=0.05
    )


def test_an_error_of_one_axis_is_reported_at_that_axis() -> None:
    def apply(world) -> None:
        world.link[:, 0] += 3e-4 * np.sin(0.7 * world.t)

    found = axes_of([panel(simulated(apply, sigma_mm=SIGMA))])
    assert found["A1"].value > 0.9
    assert 0.8 < found["A1"].low <= found["A1"].high <= 1.0
    assert found["E2"].value == 0.0  # measured in world, the table can't be seen


def test_noise_is_reported_at_no_axis() -> None:
    found = axes_of([panel(simulated(sigma_mm=SIGMA))])
    assert max(s.value for s in found.values()) < 0.02


def test_a_shift_of_the_work_is_told_in_its_own_axes_though_the_table_turns() -> None:
    """0.3 mm along the table's x, seen in `world`, where it goes round with the table."""

    def apply(world) -> None:
        angle = -world.command[:, 7]  # E2 turns the other way about z
        world.after[:, 0] += 3e-4 * np.cos(angle)
        world.after[:, 1] += 3e-4 * np.sin(angle)

    found = directions_of([panel(simulated(apply, sigma_mm=SIGMA))])
    sizes = [found[f"work_{n}"].value for n in "xyz"]
    assert max(sizes) == pytest.approx(3e-4, rel=0.02)
    assert sorted(sizes)[1] < 4e-5
    assert sum(v**2 for v in sizes) == pytest.approx(sum(found[n].value ** 2 for n in "xyz"))


def test_program_lines_are_reported_one_by_one() -> None:
    log = simulated(lambda w: w.after.__setitem__((slice(None), 2), 4e-4 * (w.t > 25.0)), sigma_mm=SIGMA)
    line = 10.0 + np.floor(log.t)
    one = panel(MeasurementLog({**log.columns, "line": line}, log.info, log.path))
    found = lines_of([one])
    assert len(found) == len(np.unique(line))
    assert [s.rms for s in found] == sorted((s.rms for s in found), reverse=True)
    late = {s.from_line for s in found if s.rms > 3e-4}
    assert late == set(np.unique(line[log.t > 25.5]).astype(int).tolist()) | {35}
    for s in found:
        rows = line == s.from_line
        gap = one.scene.tcp_gap[rows, :3]
        assert s.samples == rows.sum()
        assert s.rms == pytest.approx(np.sqrt(np.mean(np.sum(gap**2, axis=1))))
        assert s.contour**2 + s.tangential**2 == pytest.approx(s.rms**2)
        assert (s.from_s, s.to_s) == (log.t[rows][0], log.t[rows][-1])
    assert lines_of([panel(log)]) == ()


def test_a_step_is_a_change_point_and_its_stretch_is_reported() -> None:
    def apply(world) -> None:
        world.after[:, 2] += 4e-4 * (world.t > 25.0)

    one = panel(simulated(apply, sigma_mm=SIGMA))
    parts = segments_of([one])
    large = [s for s in parts if s.rms > 2e-4]
    rows = np.flatnonzero(one.scene.t > 25.0)
    assert min(s.from_line for s in large) == pytest.approx(rows[0] + 2, abs=3)
    assert all(s.rms < 6e-5 for s in parts if s not in large)
    assert all(s.contour**2 + s.tangential**2 == pytest.approx(s.rms**2, rel=1e-6) for s in parts)
    changes = [s for s in parts if s.step > 0.0]
    assert [s.from_s for s in changes] == pytest.approx([25.0], abs=0.2)
    assert changes[0].step == pytest.approx(4e-4, rel=0.1)
    assert all(s.step == 0.0 for s in segments_of([panel(simulated(sigma_mm=SIGMA))]))


@pytest.mark.parametrize(
    ("regime", "apply"),
    [
        ("time", lambda w: w.after.__setitem__((slice(None), 0), w.after[:, 0] + 1e-5 * w.t)),
        ("track", lambda w: w.after.__setitem__((slice(None), 1), w.after[:, 1] + 2e-3 * w.command[:, 6])),
        ("table", lambda w: w.after.__setitem__((slice(None), 2), w.after[:, 2] + 2e-3 * w.command[:, 7])),
        ("speed", lambda w: setattr(w, "delay", 0.01)),
    ],
)
def test_what_follows_a_regime_is_reported_there(regime: str, apply) -> None:
    one = panel(simulated(apply, sigma_mm=SIGMA))
    found = regimes_of([one], SIGMA * 1e-3 * np.sqrt(3), [regime])[regime]
    assert found.share > 0.8
    low, high = found.interval
    assert 0.7 < low <= found.share <= high + 1e-9


@pytest.mark.parametrize("named", ["gone.src", "../one/out/ball.src"])
def test_a_program_that_the_log_names_and_nobody_read_is_said_by_its_name(named: str) -> None:
    """It was dropped without a word: what the log's folder doesn't hold is not read of itself."""
    log = simulated(shifted("x"), sigma_mm=SIGMA)
    log = MeasurementLog(log.columns, replace(log.info, program=named), log.path)
    _, stages, timings = _laid_beside([make_scene(log, kr15())], [None])
    assert any(m.startswith(f"no program, for {named}") and "--program" in m for m in stages[0].missing)
    assert named in (timings[0].reason or "")


@pytest.mark.slow
def test_the_summary_says_what_is_missing_and_what_that_costs() -> None:
    log = simulated(shifted("x"), sigma_mm=SIGMA)
    for drop, words in (("c", "no set-points: what the drives do"), ("", "no encoders: drives and arm")):
        columns = {n: v for n, v in log.columns.items() if n not in {f"{drop}{a}" for a in generator.AXES}}
        where = diagnose([MeasurementLog(columns, log.info, log.path)], kr15()).summary.to_json()["where"]
        assert any(m.startswith(words) for m in where["missing"])
        assert any(m.startswith("no program: corner rounding") for m in where["missing"])
        assert where["rungs"]["setpoint_to_encoder"] is None
        assert where["rung_intervals"]["setpoint_to_encoder"] is None
        low, high = where["rung_intervals"]["encoder_to_tcp"]
        assert low <= where["rungs"]["encoder_to_tcp"] <= high
        assert set(where["further_regimes"]) == {"force", "temperature", "track", "table"}


@pytest.mark.parametrize("drop", ["", "encoders", "setpoints"])
def test_the_rungs_add_up_whatever_is_missing(drop: str) -> None:
    def apply(world) -> None:
        world.drive[:, 1] += 1e-4 * np.sin(world.t)
        world.link[:, 2] += 2e-4

    log = simulated(apply, sigma_mm=SIGMA)
    lost = {"": set(), "encoders": set(generator.AXES), "setpoints": {f"c{a}" for a in generator.AXES}}[drop]
    scene = make_scene(
        MeasurementLog({n: v for n, v in log.columns.items() if n not in lost}, log.info, log.path), kr15()
    )
    stages = stage_gaps(scene, None)
    parts = [getattr(stages, n) for n in STAGES if getattr(stages, n) is not None]
    assert np.abs(np.sum(parts, axis=0) - stages.whole).max() < 1e-15
    if drop != "setpoints":
        commanded = make_scene(simulated(), kr15()).nominal[:, :3, 3]
        assert np.abs(stages.whole - (scene.measured[:, :3, 3] - commanded)).max() < 1e-9


def test_with_a_program_the_rungs_add_up_to_measured_less_programmed_sample_by_sample() -> None:
    """The whole, found anew: from each measured point back to the place of the program nearest to its set-point."""
    log = measured(raster(4.0))
    scene = make_scene(log, program_cell(raster(4.0), kr15())[0])
    track = track_of(scene, raster(4.0))
    stages = stage_gaps(scene, track)
    parts = [getattr(stages, n) for n in STAGES]
    assert all(p is not None for p in parts)
    nodes = np.asarray(programmed_path(raster(4.0), replay(raster(4.0), kr15()), distance=0.0).points)
    along = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(nodes, axis=0), axis=1))])
    fine = np.linspace(0.0, along[-1], 200_001)
    dense = np.stack([np.interp(fine, along, nodes[:, k]) for k in range(3)], axis=1)
    commanded = scene.nominal[:, :3, 3]  # the virtual controller's encoders are its set-points; base stands on world
    base = np.asarray(world_T_base(scene.cell, scene.cell.to_q(log.setpoints(scene.axes))))[:, :3]
    in_world = dense @ base[0, :, :3].T + base[0, :, 3]
    place = in_world[cKDTree(in_world).query(commanded)[1]]
    whole = scene.measured[:, :3, 3] - place
    assert np.abs(np.sum(parts, axis=0) - whole).max() < 5e-6
    assert np.abs(stages.whole - whole).max() < 5e-6
    assert np.linalg.norm(parts[0], axis=1).max() > 0.9e-3


def test_what_is_lacking_besides_stages_is_reported_too() -> None:
    log = simulated(sigma_mm=SIGMA)
    columns = {k: v for k, v in log.columns.items() if k not in ("a", "b", "c", "temp", "fx", "fy", "fz")}
    cell = replace(kr15(), masses=())
    summary = diagnose([MeasurementLog(columns, log.info, log.path)], cell).summary.to_json()["where"]["missing"]
    for words in ("no orientation", "no temperature", "no forces", "no masses in the cell: what gives way"):
        assert any(m.startswith(words) for m in summary)


@pytest.mark.slow
def test_samples_that_are_left_out_do_not_count_in_the_rungs() -> None:
    log = simulated(sigma_mm=SIGMA)
    wild = log.columns["x"].copy()
    wild[100::200] += 3.0
    found = diagnose([MeasurementLog({**log.columns, "x": wild}, log.info, log.path)], kr15()).summary.to_json()
    assert found["gap"]["outliers"] > 0
    assert found["where"]["rungs"]["encoder_to_tcp"] == pytest.approx(found["gap"]["rms_mm"], rel=0.05)
