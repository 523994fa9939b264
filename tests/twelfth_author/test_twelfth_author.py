"""The twelfth author's generator, held to the project's reading of its files, to closed forms, and to its digests."""

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

from gap.twelfth_author import bodies, chains, drives, moves, scores, strangers
from gap.twelfth_author.case import PLAN, made, rms
from gap.twelfth_author.case import _taken as taken
from gap.twelfth_author.fleet import FLEET, cell_text
from gap.twelfth_author.plan import INSTRUMENTS
from gap.twelfth_author.seal import HERE, digest, generator_digest, line, sealed
from gap.twelfth_author.sheets import columns_of, write


def _drawn(chain, n=7):
    return moves.drawn(chain, np.random.default_rng(3), n)


@pytest.mark.parametrize("name", list(FLEET))
def test_chains_are_those_that_their_files_tell(name, tmp_path):
    chain = FLEET[name]
    (tmp_path / "cell.toml").write_text(cell_text(chain), encoding="utf-8")
    cell = camrob.read_cell(tmp_path)
    values = _drawn(chain)
    edge = values / chain.unit
    T = base_T_tool(cell, cell.to_q(edge[:, [chain.index(a) for a in cell.axis_names]]))
    assert np.allclose(chains.tips(chain, values), T, atol=1e-9)


def test_weight_is_the_moment_of_a_level_arm():
    chain = FLEET["kr210_bare"]
    values = _drawn(chain, 4)
    F = chains.frames(chain, values)
    turned = 0.0  # moment of all that hangs behind A2, about A2's own axis
    for name, kg, c in [*chain.masses, ("tip", chain.payload, None)]:
        if name == "A1":
            continue
        at = F[chain.index(name)][:, :3, :3] @ (np.array(c) / 1000) + F[chain.index(name)][:, :3, 3] if c else None
        if c is None:
            at = (F[-2] @ np.append(0.5 * chains.frame(*chain.tool)[:3, 3], 1.0))[:, :3]
        arm = at - F[0][:, :3, 3]
        turned = turned + kg * chains.GRAVITY * np.cross(F[0][:, :3, 2], arm)[:, 2]
    assert np.allclose(chains.weights(chain, values)[:, 1], turned, rtol=1e-5)


def test_the_inverse_comes_back():
    chain = FLEET["gp25_cell"]
    run = moves.rectangle(chain, None, hz=10.0)
    T = chains.tips(chain, run.values)
    assert np.allclose(T[:, :3, :3], T[0, :3, :3], atol=1e-8)
    assert np.isclose(np.ptp(T[:, 0, 3]), 0.4, atol=1e-6)


def _ramp(speed=0.3, seconds=4.0, hz=50.0):
    t = np.arange(0, seconds, 1 / hz)
    chain = FLEET["index_table"]
    return moves.Run(chain, t, (speed * t)[:, None], False)


def test_loops_and_delays_trail_by_speed_times_time():
    run = _ramp()
    for cause in (drives.servo_lag, drives.setpoint_delay):
        assert np.allclose(cause(run, [0], None, 0.006).drive[50:, 0], -0.006 * 0.3, rtol=1e-6)
    smoothed = strangers.recorder_smooths_setpoints(run, [0], None, 0.1).setpoint[50:, 0]
    assert np.allclose(smoothed, -0.05 * 0.3, rtol=1e-6)


def test_play_is_half_behind_on_either_side():
    run = moves.there_and_back(FLEET["index_table"], np.random.default_rng(1), n=9, runs=1)
    link = drives.backlash(run, [0], None, 2e-4).link[:, 0]
    assert np.allclose(link[1:9], -1e-4) and np.allclose(link[10:], 1e-4)


def test_a_yardstick_stretches_distances():
    run = moves.poses(FLEET["tx290_cell"], np.random.default_rng(2), n=9)
    T = chains.tips(run.chain, run.values)
    seen = bodies.measurement_scale(run, [], None, 1e-3).seen[0](T, run)
    assert np.allclose(np.diff(seen[:, :3, 3], axis=0), 1.001 * np.diff(T[:, :3, 3], axis=0))


def _gap_in(case, log, read):
    """(N, 3) m, measured less nominal by the file alone; a frame of the instrument's own is laid on the nominal points."""
    axes = [("c" if "c" + n in read.columns else "") + n for n in case.chain.names]
    nominal = chains.tips(case.chain, np.stack([read.columns[n] for n in axes], axis=1) * case.chain.unit)[:, :3, 3]
    if case.spec.sees is None:
        real = np.stack([read.columns[n] for n in case.chain.names], axis=1) * case.chain.unit
        return chains.tips(case.chain, real)[:, :3, 3] - nominal
    seen = np.stack([read.columns[d] for d in "xyz"], axis=1) / 1000
    if INSTRUMENTS[case.spec.sees].frame == "unknown":
        T = chains.tips(case.chain, np.stack([read.columns[n] for n in axes], axis=1) * case.chain.unit)
        target = _target(T, seen)
        nominal = nominal + np.einsum("nij,j->ni", T[:, :3, :3], target)
        turn, _ = Rotation.align_vectors(nominal - nominal.mean(axis=0), seen - seen.mean(axis=0))
        seen = turn.apply(seen - seen.mean(axis=0)) + nominal.mean(axis=0)
    return taken(case.spec, log.run, seen - nominal)


def _target(T, seen):
    """The reflector (3,) in the tool's axes, by distances that no frame changes: alternating fits."""
    target = np.zeros(3)
    for _ in range(200):
        nominal = T[:, :3, 3] + T[:, :3, :3] @ target
        turn, _ = Rotation.align_vectors(nominal - nominal.mean(axis=0), seen - seen.mean(axis=0))
        there = turn.apply(seen - seen.mean(axis=0)) + nominal.mean(axis=0)
        A = np.concatenate([T[:, :3, :3], np.tile(np.eye(3), (len(T), 1, 1))], axis=2).reshape(-1, 6)
        target = np.linalg.lstsq(A, (there - T[:, :3, 3]).ravel(), rcond=1e-9)[0][:3]
    return target


KEYS = [pytest.param(k, marks=() if k in (0, 10, 17, 31, 43) else pytest.mark.slow) for k in range(len(PLAN))]


@pytest.mark.parametrize("key", KEYS)
def test_files_say_what_was_measured_and_labels_are_those_sealed(key, tmp_path):
    case = made(key)
    assert digest(line(case.label)) == sealed()[str(key)]
    names, gaps = write(case, tmp_path), []
    for log, name in zip(case.logs, [*names[0], *names[1]], strict=True):
        read = camrob.read_log(tmp_path / name)
        for column, values in columns_of(case.spec, log).items():
            if column != "t":
                close = 6e-4 if case.spec.form == "counts" else 6e-6
                apart = read.columns[column] - values
                assert np.max(np.abs((apart + 180) % 360 - 180 if column in "abc" else apart)) < close, column
        if log.withheld or not case.label["withheld"]:
            gaps.append(_gap_in(case, log, read))
    assert np.isclose(1000 * rms(np.vstack(gaps)), case.label["gap_mm"], rtol=0.15 if case.label["causes"] else 0.3)


def test_the_generator_is_the_sealed_one_and_knows_nothing_of_camrob():
    assert generator_digest() == sealed()["generator"]
    for file in HERE.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            modules = (
                [a.name for a in node.names] if isinstance(node, ast.Import) else [getattr(node, "module", None) or ""]
            )
            assert not any(
                m.split(".")[0] == "camrob" for m in modules if isinstance(node, (ast.Import, ast.ImportFrom))
            )


def test_scores_of_a_small_story():
    cause = {"name": "backlash", "axes": ["A1"], "alike": ["hysteresis"], "foreign": False}
    label = {"causes": [cause]}
    said = {
        "effects": [{"effect": "hysteresis", "axes": ["A1"], "probability": 0.7}],
        "alternatives": [{"effects": ["backlash"], "probability": 1.0}],
    }
    assert scores.outcome(cause, said) == "alike"
    assert scores.wrong(said["effects"][0], label, True) and not scores.wrong(said["effects"][0], label)
    assert scores.outcome(cause, {"effects": [], "alternatives": said["alternatives"]}) == "contained"
    low, high = scores.wilson(8, 10)
    assert np.isclose(low, 0.490, atol=1e-3) and np.isclose(high, 0.943, atol=1e-3)
