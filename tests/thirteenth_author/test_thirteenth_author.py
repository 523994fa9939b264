"""The thirteenth author's generator, held to the project's reading of its files, to closed forms, and to its digests."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import camrob
from camrob.kinematics.frames import base_T_tool

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from gap.thirteenth_author import arms, odd, scores, wear, work
from gap.thirteenth_author.book import BOOK, INSTRUMENTS, made, rms, taken
from gap.thirteenth_author.park import PARK, cell_text
from gap.thirteenth_author.seal import HERE, digest, generator_digest, line, sealed
from gap.thirteenth_author.tables import columns_of, write


def _drawn(m, n=5):
    return np.random.default_rng(4).uniform(*m.limits.T, (n, len(m.axes)))


@pytest.mark.parametrize("name", list(PARK))
def test_machines_are_those_that_their_files_tell(name, tmp_path):
    m = PARK[name]
    (tmp_path / "cell.toml").write_text(cell_text(m), encoding="utf-8")
    v = _drawn(m)
    assert np.allclose(arms.tip(m, v), _told(camrob.read_cell(tmp_path), m, v), atol=1e-9)
    step = 1e-6 * np.eye(len(m.axes))
    moved = np.stack([arms.tip(m, v + s)[:, :3, 3] - arms.tip(m, v)[:, :3, 3] for s in step], axis=2)
    assert np.allclose(moved / 1e-6, arms.jacobian(m, v)[:, :3], atol=1e-5)


def _told(cell, m, v):
    """Tips by the project's own reading of the cell."""
    edge = v / m.unit
    return base_T_tool(cell, cell.to_q(edge[:, [m.names.index(a) for a in cell.axis_names]]))


def test_weight_is_the_slope_of_the_energy_of_height():
    m = PARK["kr120_rail"]
    v = _drawn(m)

    def energy(u):
        return sum(kg * arms.G * p[:, 2] for _, kg, p in arms._hung(m, arms.chain(m, u)[1]))

    for i, got in enumerate(arms.weight(m, v).T):
        step = 1e-5 * np.eye(len(m.axes))[i]
        assert np.allclose((energy(v + step) - energy(v - step)) / 2e-5, got, atol=1e-3)


def test_a_ball_bar_is_a_circle_and_a_nest_is_one_place():
    run = work.ball_bar(PARK["irb2400"], np.random.default_rng(1), radius=0.1, laps=1)
    p = arms.tip(run.m, run.v)[:, :3, 3]
    assert np.isclose(np.ptp(p[:, 0]), 0.2, atol=1e-4) and np.isclose(np.ptp(p[:, 1]), 0.2, atol=1e-4)
    run = work.nests(PARK["ur10e"], np.random.default_rng(1), k=2, each=3)
    assert np.allclose(arms.tip(run.m, run.v)[:, :3, 3], run.goals, atol=1e-8)


def test_drives_trail_by_speed_times_time_and_play_by_half():
    m, t = PARK["ts60"], np.arange(0, 4, 0.02)
    v = np.outer(t, [0.3, 0, 0, 0])
    for cause in (wear.servo_lag, wear.setpoint_delay):
        run = work.Run(m, t, v)
        assert np.allclose(cause(run, [0], None, 0.005).drive[60:, 0], -0.005 * 0.3, rtol=1e-3)
    run = work.Run(m, np.arange(40.0), np.abs(np.linspace(-1, 1, 40))[:, None] * np.eye(4)[0], np.zeros((40, 4)))
    run.came = np.vstack([run.v[:1] + 0.1, run.v[:-1]])
    link = wear.backlash(run, [0], None, 2e-3).link[:, 0]
    assert np.allclose(link[2:18], 1e-3) and np.allclose(link[22:], -1e-3)


def test_a_tool_on_loose_bolts_stays_on_its_side_until_it_is_pulled_to_the_other():
    run = work.tour(PARK["kr16"], np.random.default_rng(2), seconds=20.0)
    turn = odd.flange_creeps(run, [5], None, 1.0).far["flange"][:, 5]
    assert set(np.unique(turn)) <= {-1.0, 0.0, 1.0} and len(np.unique(turn)) > 1


def _gap_in(case, log, read, cell):
    """(N, 3) m, measured less nominal by the files alone; a frame of the instrument's own is laid on the nominal points."""
    m, sees = log.run.m, INSTRUMENTS.get(case.order.sees)
    on_plate = sees is not None and sees.frame == "base"

    def tips(prefix):
        v = np.stack([read.columns[prefix + n] for n in m.names], axis=1) * m.unit
        return _told(cell, m, v if on_plate else arms.level(m, v))

    T = tips("c" if "c" + m.names[0] in read.columns else "")
    if sees is None:
        return tips("")[:, :3, 3] - T[:, :3, 3]
    seen = np.stack([read.columns[d] for d in "xyz"], axis=1) / 1000
    kept, there, target = ~np.isnan(seen[:, 0]), seen, np.zeros(3)
    for _ in range(0 if sees.frame == "world" or on_plate else 1 if sees.target == "tool" else 200):
        p = (T[:, :3, 3] + T[:, :3, :3] @ target)[kept]
        turn, _ = Rotation.align_vectors(p - p.mean(axis=0), seen[kept] - seen[kept].mean(axis=0))
        there = turn.apply(seen - seen[kept].mean(axis=0)) + p.mean(axis=0)
        if sees.target == "unknown":
            A = np.concatenate([T[:, :3, :3], np.tile(np.eye(3), (len(T), 1, 1))], axis=2)[kept].reshape(-1, 6)
            target = np.linalg.lstsq(A, (there - T[:, :3, 3])[kept].ravel(), rcond=1e-9)[0][:3]
    gap = there - T[:, :3, 3] - T[:, :3, :3] @ target
    return taken(case.order, log.run, np.where(kept[:, None], gap, 0.0))


KEYS = [pytest.param(k, marks=() if k in (1, 19, 38, 47) else pytest.mark.slow) for k in range(len(BOOK))]


@pytest.mark.parametrize("key", KEYS)
def test_files_say_what_was_measured_and_labels_are_those_sealed(key, tmp_path):
    case = made(key)
    assert digest(line(case.label)) == sealed()[str(key)]
    names, gaps = write(case, tmp_path), []
    cell = camrob.read_cell(tmp_path / "cell")
    for log, name in zip(case.logs, [*names[0], *names[1]], strict=True):
        read = camrob.read_log(tmp_path / name)
        for column, values in columns_of(case.order, log).items():
            if column != "t":
                apart = read.columns[column] - values
                apart = (apart + 180) % 360 - 180 if column in "abc" else apart
                assert np.nanmax(np.abs(apart)) < (2e-4 if case.order.form == "counts" else 2e-6), column
                assert np.mean(np.isnan(apart)) < 0.03
        if log.withheld or not case.label["withheld"]:
            gaps.append(_gap_in(case, log, read, cell))
    assert np.isclose(1000 * rms(np.vstack(gaps)), case.label["gap_mm"], rtol=0.12 if case.label["causes"] else 0.3)


def test_the_generator_is_the_sealed_one_and_knows_nothing_of_camrob():
    assert generator_digest() == sealed()["generator"]
    for file in HERE.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, (ast.Import, ast.ImportFrom)):
                names = [a.name for a in node.names] if isinstance(node, ast.Import) else [node.module or ""]
                assert not any(n.split(".")[0] == "camrob" for n in names)


def test_scores_of_a_small_story():
    cause = {"name": "friction", "axes": ["A3"], "alike": [], "foreign": False, "ratio": 9.0, "since": "after"}
    label = {
        "key": 0,
        "kind": "drives",
        "causes": [cause],
        "left_mm": 0.0,
        "noise_mm": 0.1,
        "wander": 0,
        "removable": 0.8,
    }
    effects = [
        {"effect": "friction", "axes": ["A3"], "probability": 0.9},
        {"effect": "lean", "axes": [], "probability": 0.6},
    ]
    together = {"shrink": 0.79, "predicted_shrink": 0.7}
    said = {
        "status": "explained",
        "effects": effects,
        "alternatives": [],
        "unknown": {},
        "together": together,
        "seconds": 2.0,
    }
    tally, _, _, refused = scores.figures([label], {0: said})
    assert not refused and tally["all claims: wrong"] == (1, 2) and tally["claims above 0.8: wrong"] == (0, 1)
    assert tally["since a moment or a service, twice the floor: right"] == (1, 1)
    assert tally["foretold within 5 points of reached"] == (0, 1)
