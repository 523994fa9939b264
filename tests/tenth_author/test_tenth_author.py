"""The tenth author's generator, held to Pinocchio, to others' solutions, and to what stands in its files."""

from __future__ import annotations

import ast
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from scipy.optimize import fsolve
from scipy.spatial.transform import Rotation

import camrob

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "bench"))

from gap.tenth_author import body_causes, drive_causes, reading_causes
from gap.tenth_author.case import PLAN, SEED, label, made
from gap.tenth_author.chain import inverse
from gap.tenth_author.machines import MACHINES
from gap.tenth_author.motions import Run
from gap.tenth_author.seal import HERE, digest, generator_digest, line, sealed
from gap.tenth_author.tables import write
from gap.tenth_author.truth import Truth


def _se3(T):
    return pin.SE3(T[:3, :3], T[:3, 3] / 1000.0)


def _fixed(a, alpha):
    return pin.SE3(Rotation.from_euler("x", alpha).as_matrix(), np.array([a / 1000.0, 0, 0]))


def _model(machine):
    """The machine's arm and carriage in Pinocchio; tables stand at 0. Placements of the joints, then of the tool; metres."""
    model, at, parent, place = pin.Model(), {}, 0, _se3(machine.first)
    behind = {}
    for joint in machine.joints:
        alpha, a, theta, d = joint.row
        screw = pin.SE3(Rotation.from_euler("z", theta).as_matrix(), np.array([0, 0, d / 1000.0]))
        if joint.modified:
            place = place * _fixed(a, alpha)
        if joint.role == "workpiece":  # at the axis value 0
            value = -joint.sign * joint.offset
            still = pin.SE3(Rotation.from_euler("z", value).as_matrix(), np.zeros(3))
            place = place * still * screw if joint.modified else place * still * screw * _fixed(a, alpha)
            continue
        kind = pin.JointModelRZ() if joint.kind == "R" else pin.JointModelPZ()
        parent = model.addJoint(parent, kind, place, joint.name)
        at[joint.name] = parent
        place = screw if joint.modified else screw * _fixed(a, alpha)
        behind[joint.name] = place
    for mass in machine.masses:
        where = behind[mass.after].act(np.array(mass.center) / 1000.0)
        model.appendBodyToJoint(at[mass.after], pin.Inertia(mass.kg, where, np.zeros((3, 3))), pin.SE3.Identity())
    return model, parent, place, behind, at


def _q(machine, q):
    return np.array(
        [
            j.sign * (x - j.offset) / (1.0 if j.kind == "R" else 1000.0)
            for j, x in zip(machine.joints, q, strict=True)
            if j.role != "workpiece"
        ]
    )


def _tool(machine, q, tool=None):
    """world_T_tool, mm, by Pinocchio."""
    model, last, place, _, _ = _model(machine)
    data = model.createData()
    out = np.zeros((len(q), 4, 4))
    for k, row in enumerate(q):
        pin.forwardKinematics(model, data, _q(machine, row))
        T = (data.oMi[last] * place * _se3(machine.flange @ (machine.tool if tool is None else tool))).homogeneous
        T[:3, 3] *= 1000.0
        out[k] = T
    return out


@pytest.mark.parametrize("name", list(MACHINES))
def test_chains_and_weights_are_those_of_pinocchio(name):
    machine = MACHINES[name]
    rng = np.random.default_rng(4)
    q = np.array([[rng.uniform(j.low, j.high) for j in machine.joints] for _ in range(6)])
    assert np.allclose(machine.frames(q)[2], _tool(machine, q), atol=1e-8)
    model, last, place, _, _ = _model(machine)
    flange = (place * _se3(machine.flange)).act(np.array([0.01, 0.02, 0.05]))
    model.appendBodyToJoint(last, pin.Inertia(7.0, flange, np.zeros((3, 3))), pin.SE3.Identity())
    data = model.createData()
    weight = machine.weight(q, 7.0, (10, 20, 50))
    for row, told in zip(q, weight, strict=True):
        held = pin.computeGeneralizedGravity(model, data, _q(machine, row))
        signs = np.array([j.sign for j in machine.joints if j.role != "workpiece"])
        ours = np.array([x for x, j in zip(told, machine.joints, strict=True) if j.role != "workpiece"])
        assert np.allclose(-signs * held, ours, atol=1e-8)


def _ramp(n=4000, dt=0.001, speed=0.5):
    t = np.arange(n) * dt
    return Run(t, (speed * t)[:, None])


def test_a_follower_is_behind_by_speed_and_time_constant():
    truth = Truth(MACHINES["bench"], _ramp())
    drive_causes.slow_loop({"A1": 0.03}, 0.25).act(truth)
    assert np.isclose((truth.run.q - truth.q)[-1, 0], 0.5 * 0.03 * 0.75, rtol=0.02)


def test_play_is_lost_at_each_turn_and_nowhere_else():
    t = np.arange(2000) * 0.005
    truth = Truth(MACHINES["bench"], Run(t, np.sin(t)[:, None]))
    body_causes.play({"A1": 0.2}).act(truth)
    off = np.degrees(truth.link[:, 0])
    assert np.isclose(off.min(), -0.1, atol=1e-9) and np.isclose(off.max(), 0.1, atol=1e-9)
    quick = np.abs(np.cos(t)) > 0.5
    assert np.allclose(off[quick][500:], -0.1 * np.sign(np.cos(t))[quick][500:], atol=1e-9)


def test_a_delta_s_rods_are_as_long_as_they_are():
    machine = MACHINES["delta"]
    rng = np.random.default_rng(2)
    q = np.array([[rng.uniform(j.low, j.high) for j in machine.joints] for _ in range(5)])
    truth = Truth(machine, Run(np.arange(5.0), q, True, np.ones(q.shape)))
    reading_causes.long_rods(1, 0.55).act(truth)
    phi = 2 * np.pi * np.arange(3) / 3
    foot = 220.0 * np.stack([np.cos(phi), np.sin(phi)], 1)
    for x, y, z, shift in zip(q[:, 0], q[:, 1], q[:, 2], truth.shift, strict=True):
        slides = [-z + np.sqrt(650.0**2 - (x - a) ** 2 - (y - b) ** 2) for a, b in foot]

        def off(p, slides=slides):
            return [
                np.linalg.norm(p - [a, b, h]) - (650.55 if k == 1 else 650.0)
                for k, ((a, b), h) in enumerate(zip(foot, slides, strict=True))
            ]

        assert np.allclose(fsolve(off, [x, y, -z]) - [x, y, -z], shift, atol=1e-7)


def _gap(case, folder):
    """The scored logs' gap by their files, project's reader and Pinocchio: mm, unknown frame and target taken out by hand."""
    write(case, folder)
    scored = [x for x in case.logs if x.name == "withheld"] or case.logs
    errs, X = [], []
    shown = {"flat": 2, "along": 1}.get(case.plan.see, 3)
    for log in scored:
        read = camrob.read_log(folder / f"{log.name}.csv")
        axes = [("c" if "set" in case.plan.logged and case.plan.see else "") + n for n in case.machine.names]
        unit = np.array([np.pi / 180 if j.kind == "R" else 1.0 for j in case.machine.joints])
        q = np.stack([np.asarray(read.columns[a]) for a in axes], 1) * unit
        if not case.plan.see:
            want = np.stack([np.asarray(read.columns["c" + a]) for a in axes], 1) * unit
            errs.append(_tool(case.machine, q)[:, :3, 3] - _tool(case.machine, want)[:, :3, 3])
            X.append(np.zeros((len(q), 3, 0)))
            continue
        T = _tool(case.machine, q)
        if case.plan.frame == "base":
            T = inverse(case.machine.part(q)) @ T
        seen = np.stack([np.asarray(read.columns[c]) for c in "xyz"], 1)
        if case.plan.frame == "unknown":
            for _ in range(
                300 if case.plan.target == "unknown" else 1
            ):  # the reflector's place on the flange in turn with the frame
                p = T[:, :3, 3]
                turn, _ = Rotation.align_vectors(p - p.mean(0), seen - seen.mean(0))
                laid = turn.apply(seen - seen.mean(0)) + p.mean(0)
                if case.plan.target == "unknown":
                    more = np.linalg.lstsq(T[:, :3, :3].reshape(-1, 3), (laid - p).reshape(-1), rcond=None)[0]
                    T[:, :3, 3] += T[:, :3, :3] @ more
            seen = laid
        errs.append(seen - T[:, :3, 3])
        columns = [np.zeros((len(q), 3))]
        if case.plan.frame == "unknown":
            p = T[:, :3, 3] - T[:, :3, 3].mean(0)
            columns += [np.tile(e, (len(q), 1)) for e in np.eye(3)] + [np.cross(e, p) / 500 for e in np.eye(3)]
        if case.plan.target == "unknown":
            columns += [T[:, :3, k] for k in range(3)]
        if not log.run.poses and "two clocks" not in case.plan.title:
            columns.append(np.gradient(T[:, :3, 3], log.run.t, axis=0) / 1000)
        X.append(np.stack(columns, 2))
    e, A = np.concatenate(errs)[:, :shown], np.concatenate(X)[:, :shown]
    if A.shape[2]:
        A = A.reshape(-1, A.shape[2])
        e = (e.reshape(-1) - A @ np.linalg.lstsq(A, e.reshape(-1), rcond=None)[0]).reshape(e.shape)
    size = np.sqrt(np.sum(e**2, axis=1))
    if case.plan.gross:
        size = size[size < 1.0]
    return float(np.sqrt(np.mean(size**2)))


QUICK = [0, 7, 8, 12, 14, 20, 29, 34, 38, 46]


@pytest.mark.parametrize("number", QUICK)
def test_files_hold_the_gap_that_the_label_tells(number, tmp_path):
    case = made(SEED, number)
    assert np.isclose(_gap(case, tmp_path), label(case)["gap_mm"], rtol=0.12)


@pytest.mark.slow
@pytest.mark.parametrize("number", [n for n in range(len(PLAN)) if n not in QUICK])
def test_files_hold_the_gap_that_the_label_tells_of_the_others(number, tmp_path):
    case = made(SEED, number)
    assert np.isclose(_gap(case, tmp_path), label(case)["gap_mm"], rtol=0.12)


def test_generator_and_labels_are_those_that_were_sealed():
    fixed = sealed()
    assert generator_digest() == fixed["generator"]
    for number in QUICK:
        assert digest(line(label(made(SEED, number)))) == fixed[str(number)]


def test_nothing_of_the_project_is_used():
    for file in HERE.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text())):
            names = (
                [a.name for a in node.names] if isinstance(node, ast.Import) else [getattr(node, "module", None) or ""]
            )
            assert not any(n.split(".")[0] == "camrob" for n in names), file
