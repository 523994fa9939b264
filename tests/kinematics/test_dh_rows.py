"""Every number of a Denavit-Hartenberg row counts: random rows against Pinocchio and against the textbook's product."""

from __future__ import annotations

import json
import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from camrob import post
from camrob.calibration.error_model import ErrorModel
from camrob.cell.cell import Cell
from camrob.cell.joint import Role
from camrob.cell.read_cell import read_cell
from camrob.cell.status_turn import StatusTurn
from camrob.cell.urdf import cell_urdf
from camrob.dynamics.gravity import gravity_arrays, gravity_torques
from camrob.errors import CellError
from camrob.jobs.verify import verify
from camrob.kinematics import frames, kernels
from camrob.kinematics.arm import Arm
from camrob.kinematics.second_library import pinocchio_poses
from camrob.redundancy.planning.freedoms import plan_space, plan_work, pose_in_foot
from camrob.se3 import frame_from_mm_deg

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "cells" / "kr15_track_table"
TEXT = (FOLDER / "cell.toml").read_text(encoding="utf-8")
SAMPLE = ROOT / "toolpaths" / "engraving" / "engraving.cls"
REAL = ("E2", "E1", "A1", "A2", "A3", "A4", "A5", "A6")


def with_row(text: str, joint: str, **numbers: float) -> str:
    """The cell's text with other numbers in a joint's block, keys as in the file."""
    start = text.index(f'[[joint]]\nname = "{joint}"')
    stop = text.index("\n[", start + 1)
    block = text[start:stop]
    for key, value in numbers.items():
        block, count = re.subn(rf"\b{key} = -?[0-9.]+", f"{key} = {value!r}", block)
        assert count == 1, (joint, key)
    return text[:start] + block + text[stop:]


def number(text: str, joint: str, key: str) -> float:
    block = text[text.index(f'[[joint]]\nname = "{joint}"') :]
    return float(re.search(rf"\b{key} = (-?[0-9.]+)", block)[1])


def cell_of(folder: Path, text: str) -> Cell:
    folder.mkdir(exist_ok=True)
    (folder / "cell.toml").write_text(text, encoding="utf-8")
    for file in ("weights_jnt.fis", "weights_cond.fis"):
        shutil.copy(FOLDER / file, folder / file)
    return read_cell(folder)


def drawn(rng: np.random.Generator, *, closed: bool) -> str:
    """The KR15's text with random theta and d in every row; `closed` keeps what a spherical wrist needs."""
    text = TEXT
    for name in REAL:
        row = {"theta_deg": float(rng.uniform(-180, 180)), "d_mm": float(rng.uniform(-700, 700))}
        if not closed:
            row |= {"a_mm": float(rng.uniform(-500, 500)), "alpha_deg": float(rng.uniform(-180, 180))}
        elif name == "A5":
            del row["d_mm"]
        text = with_row(text, name, **row)
    if not closed:  # a sliding table and a turning carriage: each type in each role
        text = turned_to(text, "E2", "prismatic")
        text = turned_to(text, "E1", "revolute")
    return text


def turned_to(text: str, joint: str, kind: str) -> str:
    """A joint of the other type, its units with it."""
    start = text.index(f'[[joint]]\nname = "{joint}"')
    stop = text.index("\n[", start + 1)
    block = text[start:stop]
    old, new = ("deg", "mm") if kind == "prismatic" else ("mm", "deg")
    block = re.sub(r'type = "\w+"', f'type = "{kind}"', block)
    lines = [
        line if line.startswith("dh =") else re.sub(rf"_{old}\b", f"_{new}", re.sub(rf"_{old}_s", f"_{new}_s", line))
        for line in block.splitlines()
    ]
    return text[:start] + "\n".join(lines) + text[stop:]


def postures(cell: Cell, count: int, rng: np.random.Generator) -> np.ndarray:
    lower = np.where(np.isfinite(cell.q_lower), cell.q_lower, -4.0)
    upper = np.where(np.isfinite(cell.q_upper), cell.q_upper, 4.0)
    return rng.uniform(lower, upper, (count, len(cell)))


def textbook(text: str, q: np.ndarray) -> np.ndarray:
    """base_T_tool (4, 4) of one posture, multiplied out of the file's own numbers: Rz(theta) Tz(d) Tx(a) Rx(alpha)."""

    def frame(key: str) -> np.ndarray:
        return frame_from_mm_deg(np.array(json.loads(re.search(rf"(?m)^{key} = (\[.*?\])", text)[1]), float))

    T = frame("base_to_first")
    for name, value in zip((*REAL, "roll"), q, strict=True):
        block = text[text.index(f'[[joint]]\nname = "{name}"') :]
        sliding = re.search(r'type = "(\w+)"', block)[1] == "prismatic"
        theta = np.radians(number(text, name, "theta_deg")) + (0.0 if sliding else value)
        d = number(text, name, "d_mm") / 1000.0 + (value if sliding else 0.0)
        a, alpha = number(text, name, "a_mm") / 1000.0, np.radians(number(text, name, "alpha_deg"))
        ct, st, ca, sa = np.cos(theta), np.sin(theta), np.cos(alpha), np.sin(alpha)
        T = T @ np.array(
            [[ct, -st * ca, st * sa, a * ct], [st, ct * ca, -ct * sa, a * st], [0, sa, ca, d], [0, 0, 0, 1]]
        )
        if name == "A6":
            T = T @ frame("wrist_to_flange") @ frame("flange_to_tool")
    return T


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("closed", [True, False], ids=["spherical", "any"])
def test_random_rows(tmp_path: Path, seed: int, closed: bool) -> None:
    """Kernels, plain frames, calibration's model, URDF and Pinocchio's own chain all stand where the textbook says."""
    import pinocchio

    rng = np.random.default_rng(seed)
    text = drawn(rng, closed=closed)
    cell = cell_of(tmp_path, text)
    q = postures(cell, 12, rng)
    truth = np.stack([textbook(text, x) for x in q])
    model = pinocchio.buildModelFromXML(cell_urdf(cell))
    data = model.createData()
    for k, x in enumerate(q):
        own = np.concatenate(
            [
                [np.cos(v), np.sin(v)] if j.endless and not j.prismatic else [v]
                for j, v in zip(cell.joints, x, strict=True)
            ]
        )
        pinocchio.framesForwardKinematics(model, data, own)
        assert np.abs(data.oMf[model.getFrameId("tool")].homogeneous - truth[k]).max() < 1e-12
    assert np.abs(frames.base_T_tool(cell, q) - truth).max() < 1e-12
    assert np.abs(kernels.forward_many(kernels.chain_arrays(cell), q) - truth).max() < 1e-12
    assert np.abs(pinocchio_poses(cell, q) - truth).max() < 1e-12
    unrolled = q.copy()
    unrolled[:, -1] = 0.0
    model_of_errors = ErrorModel.of(cell, (), in_base=True)
    found = model_of_errors.poses(np.zeros(0), unrolled)
    assert np.abs(found - np.stack([textbook(text, x) for x in unrolled])).max() < 1e-12


@pytest.mark.parametrize("seed", range(4))
def test_random_rows_under_gravity(tmp_path: Path, seed: int) -> None:
    """Torques are the slope of the masses' height along the textbook's chain."""
    rng = np.random.default_rng(100 + seed)
    cell = cell_of(tmp_path, drawn(rng, closed=True))
    q = postures(cell, 3, rng)

    def energy(x: np.ndarray) -> float:
        T = frames.world_T_base(cell, x) @ frames.base_T_joint_frames(cell, x)
        up = [(T[cell.index(m.after)] @ np.append(m.center, 1.0))[2] for m in cell.masses]
        return float(9.80665 * np.dot([m.mass for m in cell.masses], up))

    torque = gravity_torques(gravity_arrays(cell), q)
    part = cell.arm_slice
    for x, expected in zip(q, torque, strict=True):
        steps = 1e-6 * np.eye(len(cell))[part]
        fall = [(energy(x - d) - energy(x + d)) / 2e-6 for d in steps]
        np.testing.assert_allclose(expected[part], fall, atol=2e-5)


@pytest.mark.parametrize("seed", range(8))
def test_random_rows_invert(tmp_path: Path, seed: int) -> None:
    """The closed form of a spherical wrist finds the posture again, and all its branches stand at the same pose."""
    rng = np.random.default_rng(200 + seed)
    text = drawn(rng, closed=True)
    cell = cell_of(tmp_path, text)
    arm = Arm.of(cell)
    assert arm.closed is not None
    space, work = plan_space(cell), plan_work()
    part = cell.arm_slice
    for q in postures(cell, 15, rng):
        base_T_tool = textbook(text, q)
        foot_T_tool = arm.foot_T_tool(base_T_tool, q)
        found = arm.branches(foot_T_tool, q[part])
        assert min(np.abs(f - q[part]).max() for f in found) < 1e-7
        for f in found:
            whole = q.copy()
            whole[part] = f
            assert np.abs(textbook(text, whole) - base_T_tool).max() < 1e-9
        pose_in_foot(space, base_T_tool, np.delete(q, np.arange(part.start, part.stop)), work)
        assert np.abs(work.pt - foot_T_tool[:3, 3]).max() < 1e-12
        assert np.abs(work.Rt - foot_T_tool[:3, :3]).max() < 1e-12


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_random_rows_of_an_arm_without_closed_form_invert(tmp_path: Path, seed: int) -> None:
    rng = np.random.default_rng(300 + seed)
    text = with_row(drawn(rng, closed=True), "A5", d_mm=float(rng.uniform(30, 90)))
    cell = cell_of(tmp_path, text)
    arm = Arm.of(cell)
    assert arm.closed is None
    for q in postures(cell, 4, rng):
        found = arm.branches(arm.foot_T_tool(textbook(text, q), q), q[cell.arm_slice])
        assert min(np.abs(f - q[cell.arm_slice]).max() for f in found) < 1e-7


def shifted(rng: np.random.Generator, *names: str) -> str:
    """The same machine with other zeros of q: theta (or d) grows, and q shrinks, by a random part."""
    text = TEXT
    for name in names:
        unit, key = ("mm", "d_mm") if name == "E1" else ("deg", "theta_deg")
        by = round(float(rng.uniform(-170, 170)), 3)
        old = {k: number(text, name, k) for k in (key, f"home_{unit}", f"reference_{unit}", f"offset_{unit}", "sign")}
        text = with_row(
            text,
            name,
            **{
                key: old[key] + by,
                f"home_{unit}": old[f"home_{unit}"] - by,
                f"reference_{unit}": old[f"reference_{unit}"] - by,
                f"offset_{unit}": old[f"offset_{unit}"] + old["sign"] * by,
            },
        )
    return text


def test_the_same_machine_with_other_zeros_is_the_same_machine(tmp_path: Path) -> None:
    """Status, conditioning, world and the posted program do not depend on where q is counted from."""
    rng = np.random.default_rng(5)
    cell, other = read_cell(FOLDER), cell_of(tmp_path / "other", shifted(rng, *REAL))
    axes = cell.to_axis_values(postures(cell, 200, rng))
    q, moved = cell.to_q(axes), other.to_q(axes)
    np.testing.assert_allclose(frames.base_T_tool(other, moved), frames.base_T_tool(cell, q), atol=1e-12)
    np.testing.assert_allclose(frames.world_T_base(other, moved), frames.world_T_base(cell, q), atol=1e-12)
    a, b = StatusTurn.of(cell), StatusTurn.of(other)
    assert a.stretch_deg == pytest.approx(b.stretch_deg)
    assert a.status(axes[:, :6]).tolist() == b.status(axes[:, :6]).tolist()
    kf = [kernels.inverse_kf_many(kernels.chain_arrays(c), x) for c, x in ((cell, q), (other, moved))]
    np.testing.assert_allclose(kf[0], kf[1], atol=1e-12)
    for folder, out in ((FOLDER, "a"), (tmp_path / "other", "b")):
        post(SAMPLE, cell=folder, out=tmp_path / out, report=False)
    one, two = ((tmp_path / out / "engraving.src").read_text().splitlines() for out in ("a", "b"))
    assert len(one) == len(two) > 200
    for x, y in zip(one, two, strict=True):
        parts = [re.split(r"(-?\d+\.\d+)", line) for line in (x, y)]
        assert parts[0][::2] == parts[1][::2]
        values = [np.array(p[1::2], float) for p in parts]
        assert np.all(np.abs(values[0] - values[1]) < 3e-4), (x, y)
    assert verify(tmp_path / "a" / "engraving.src", cell=tmp_path / "other", against=SAMPLE, manifest=False).ok


@pytest.mark.parametrize(("joint", "key", "value"), [("A2", "theta_deg", 5.0), ("E1", "d_mm", 40.0)])
def test_a_constant_of_a_row_is_another_machine(tmp_path: Path, joint: str, key: str, value: float) -> None:
    cell, other = read_cell(FOLDER), cell_of(tmp_path / "other", with_row(TEXT, joint, **{key: value}))
    assert cell.digest != other.digest
    texts = set()
    for folder, out in ((FOLDER, "a"), (tmp_path / "other", "b")):
        post(SAMPLE, cell=folder, out=tmp_path / out, report=False)
        texts.add((tmp_path / out / "engraving.src").read_text())
    assert len(texts) == 2


@pytest.mark.parametrize("key", ["theta_deg", "d_mm", "a_mm", "alpha_deg"])
def test_the_roll_turns_about_the_tools_own_axis(tmp_path: Path, key: str) -> None:
    assert read_cell(FOLDER).joints[-1].role is Role.ROLL
    with pytest.raises(CellError, match=r"joint\[roll\].dh: is not that of a turn about the tool's own axis; make it"):
        cell_of(tmp_path / "other", with_row(TEXT, "roll", **{key: 12.5}))
