"""The checker of a plan's bound, which shares nothing with its prover: held to camrob's kinematics, and to wrong certificates."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

from camrob.cell.read_cell import read_cell
from camrob.kinematics.arm import reach
from camrob.redundancy.planning.freedoms import conditioning, plan_space, plan_work, pose_in_foot
from camrob.redundancy.planning.objective import Objective, plan_weights
from camrob.redundancy.planning.waypoints import waypoints

ROOT = Path(__file__).resolve().parents[3]
sys.path[:0] = [str(ROOT / "tests" / "bench"), str(ROOT / "tests" / "redundancy")]

from test_plan_proof import poses, short_path  # noqa: E402

from camrob.redundancy.proving import bins_in_time  # noqa: E402
from camrob.redundancy.proving.plan_certificate import write_certificate  # noqa: E402
from camrob.redundancy.proving.statement import statement_of  # noqa: E402
from camrob.redundancy.proving.whole_plan import prove_plan  # noqa: E402
from camrob.witness.proof_check import check_plan as checker  # noqa: E402
from camrob.witness.proof_check.bins import below  # noqa: E402
from camrob.witness.proof_check.dh_machine import Machine, dh, frame  # noqa: E402

TOML = ROOT / "cells" / "kr15_track_table" / "cell.toml"
CELL = read_cell(TOML.parent)
SPACE = plan_space(CELL)


def every_posture(T, u):
    """1/k_F of all postures of a pose at freedoms u that keep the limits of axes 2, 3 and 5."""
    work, out = plan_work(), []
    pose_in_foot(SPACE, T, u, work)
    reach(SPACE.arm, SPACE.screws, work.Rt, work.pt, SPACE.center, work.Q, work.why)
    for b in np.flatnonzero(work.why == 0):
        q = work.Q[b].copy()
        some = [1, 2, 4]
        if np.all(q[some] >= SPACE.lower[some]) and np.all(q[some] <= SPACE.upper[some]):
            out.append(conditioning(SPACE, q, plan_work()))
    return out


def seen_box(machine, T, u, half):
    """The frame and the box of one pose seen from the arm, and where it stands in it."""
    seen, near = machine.seen(T[None, :3, 3], T[None, :3, 2], u[None, :2], np.full(2, half))
    assert not near.any()
    z = seen[0, 2:, 0] / np.linalg.norm(seen[0, 2:, 0])
    x = np.eye(3)[int(np.argmin(np.abs(z)))]
    x = (x - (x @ z) * z) / np.linalg.norm(x - (x @ z) * z)
    return np.array([x, np.cross(z, x), z]), np.array([seen[0, 0, 0], seen[0, 1, 0]])


@pytest.mark.slow
@pytest.mark.parametrize("half", [1e-7, 0.001])
def test_planes_are_below_the_price_of_every_posture_and_near_it(half):
    machine, rng = Machine(TOML), np.random.default_rng(2)
    rolls, worst = np.linspace(-np.pi, np.pi, 181), 0.0
    for T in poses(12, rng):
        u = np.array([rng.uniform(-3.0, 3.0), rng.uniform(-1.0, 1.0), 0.0])
        axes, (radius, height) = seen_box(machine, T, u, 1e-9)
        box = np.zeros((180, 2, 5))
        box[:, 0, 2] = 0.5 * (rolls[1:] + rolls[:-1])
        box[:, 0, 3], box[:, 0, 4], box[:, 1] = radius, height, half
        box[:, 1, 2] = np.pi / 180.0 * (1.0 + 1e-9)
        plane = below(machine, np.repeat(axes[None], 180, 0), box, 4.0, 0.5)
        least = plane[:, :, 0] - np.abs(plane[:, :, 1:]).sum(-1, where=np.isfinite(plane[:, :, 1:]))
        found = [max(every_posture(np.ascontiguousarray(T), np.array([*u[:2], r])), default=0.0) for r in rolls]
        best = (0.5 / max(max(found), 1e-3)) ** 4
        assert least.min() <= best * (1.0 + 1e-9)
        worst = max(worst, 1.0 - least.min() / best)
    assert worst < (0.02 if half < 1e-6 else 0.3)


@pytest.mark.slow
def test_a_certificate_is_proved_again_and_one_that_claims_too_much_is_not(tmp_path):
    w = waypoints(short_path(), 0.02)
    objective, told = Objective.of(CELL, SPACE, plan_weights(CELL)), []
    stated = statement_of(SPACE, objective, w, np.full(len(w), 0.8))
    proof = prove_plan(CELL, objective, stated, 10.0, levels=2, told=told)
    file = tmp_path / "short.npz"
    write_certificate(file, CELL, objective, [(stated, told)])
    bound = checker.check(file, TOML)
    assert 0.9 * proof.bound < bound <= proof.bound
    data = dict(np.load(file))

    def refused(match, **changes):
        np.savez(tmp_path / "wrong.npz", **(data | {f"0.{name}": value for name, value in changes.items()}))
        with pytest.raises(ValueError, match=match):
            checker.check(tmp_path / "wrong.npz", TOML)

    dear = data["0.planes0"].copy()
    dear[:, 0] *= 30.0  # the first level's are far below
    refused("not below the price", planes0=dear)
    refused("lacks cells", k0=data["0.k0"][1:], where0=data["0.where0"][1:], own0=data["0.own0"][1:])
    refused("lacks cells", rest0=data["0.rest0"][1:]) if "0.k1" in data else None
    refused("further than its lattice", low=data["0.low"] + 0.1)
    twice = tmp_path / "twice.npz"
    write_certificate(twice, CELL, objective, [(stated, told), (stated, told)])
    assert checker.check(twice, TOML) == pytest.approx(2.0 * bound)
    with pytest.raises(TimeoutError):
        checker.check(file, TOML, late=lambda: True)
    box = data["0.box0"].copy()
    box[:, 1, 3] *= 0.5
    refused("leaves its bin", box0=box)


class Looks:
    """A clock whose time is over at a number of looks."""

    def __init__(self, most):
        self.most, self.count, self.taken = most, 0, 0.0

    @property
    def up(self):
        self.count += 1
        return self.count > self.most

    @property
    def left(self):
        return 1e9 if self.count <= self.most else 0.0


@pytest.mark.slow
def test_a_level_that_there_is_no_time_for_keeps_what_the_one_before_says_and_is_proved_again(tmp_path, monkeypatch):
    monkeypatch.setattr(bins_in_time, "_AT_ONCE", 2)
    w = waypoints(short_path(), 0.02)
    objective = Objective.of(CELL, SPACE, plan_weights(CELL))
    stated, all_looks = statement_of(SPACE, objective, w, np.full(len(w), 0.8)), Looks(10**9)
    whole = prove_plan(CELL, objective, stated, 10.0, levels=2, clock=all_looks)
    first = whole.levels[0].bound
    bounds = []
    for share in (0.5, 0.9):
        told, bins = [], whole.levels[0].bins
        looks = -(-bins // 4) + int(share * (all_looks.count - -(-bins // 4)))
        proof = prove_plan(CELL, objective, stated, 10.0, levels=2, clock=Looks(looks), told=told)
        write_certificate(tmp_path / "part.npz", CELL, objective, [(stated, told)])
        assert 0.9 * proof.bound < checker.check(tmp_path / "part.npz", TOML) <= proof.bound
        bounds.append(proof.bound)
    assert first <= bounds[0] <= bounds[1] * (1.0 + 1e-9) <= whole.bound * (1.0 + 1e-9)


def test_a_frame_and_a_row_by_hand():
    np.testing.assert_allclose(frame([1000, 0, 0, 90, 0, 0])[:3, 0], [0, 1, 0], atol=1e-15)
    row = {"alpha_deg": 90, "a_mm": 300, "d_mm": -675}
    np.testing.assert_allclose(dh(row, np.pi / 2)[:3, 3], [0, 0.3, -0.675], atol=1e-15)
