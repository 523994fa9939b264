"""The second author's generator: it shares no code with what it judges, and its chains are those of others."""

from __future__ import annotations

import csv
import json
import sys
from pathlib import Path

import numpy as np
import pytest
from imported_names import taken_names
from scipy.spatial.transform import Rotation

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "second_author"
MAKERS = ("chain", "run", "motion", "design", "family", "case", "logs", "make", "kr15")

from gap.second_author import dev_cells  # noqa: E402
from gap.second_author.case import case  # noqa: E402
from gap.second_author.chain import place  # noqa: E402
from gap.second_author.dev import FAMILY as DEV  # noqa: E402
from gap.second_author.sealed import FAMILY as SEALED  # noqa: E402

ROBOTS = [make() for family in (DEV, SEALED) for make, _ in family.cells.values()]


def _makers() -> list[Path]:
    return [p for p in FOLDER.glob("*.py") if p.stem in MAKERS or p.stem.startswith(("dev", "sealed"))]


def test_makers_import_nothing_of_camrob_nor_of_the_first_generator() -> None:
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    foreign = {
        f"{path.name}: {name}"
        for path in _makers()
        for name in taken_names(path)
        if name.split(".")[0] not in allowed and not name.startswith("gap.second_author")
    }
    assert len(_makers()) >= 10 and not foreign


def test_dev_never_imports_sealed_nor_sealed_dev() -> None:
    for path in _makers():
        mine, other = ("dev", "sealed") if path.stem.startswith("dev") else ("sealed", "dev")
        if path.stem.startswith(mine):
            assert not [n for n in taken_names(path) if any(part.startswith(other) for part in n.split("."))], path.name


def test_kr15_meets_the_poses_that_others_worked_out() -> None:
    robot = dev_cells.kr15()
    with (ROOT / "cells" / "kr15_track_table" / "poses.csv").open(encoding="utf-8") as file:
        for row in csv.DictReader(file):
            values = np.array([float(row["E1_mm"]), *(float(row[f"A{i}_deg"]) for i in range(1, 7))])
            turn = place(a=float(row["E2_deg"]))
            tool = turn @ robot.pose(values * robot.unit)[0]
            told = place(*(float(row[k]) for k in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")))
            assert np.abs(tool[:3, 3] - told[:3, 3]).max() < 1e-6, row["name"]
            assert np.linalg.norm(Rotation.from_matrix(tool[:3, :3].T @ told[:3, :3]).as_rotvec()) < 2e-5, row["name"]


def test_ur10_at_zero_is_where_its_maker_has_it() -> None:
    robot = dev_cells.ur10_like()
    robot.tool = (0.0,) * 6
    at = robot.pose(np.zeros((1, 6)))[0, :3, 3] * 1e3
    assert np.allclose(at, [-1184.3, -256.141, 11.6], atol=1e-3)


@pytest.mark.parametrize("robot", ROBOTS, ids=lambda r: r.name)
def test_chains_and_gravity_are_those_of_pinocchio(robot) -> None:
    import pinocchio as pin

    model, joint, offset = pin.Model(), 0, robot.base
    pre, post = robot._fixed
    joints = {}
    for i, row in enumerate(robot.rows):
        kind = pin.JointModelPZ() if robot.slides[i] else pin.JointModelRZ()
        joint = model.addJoint(joint, kind, pin.SE3(offset @ pre[i]), row.name)
        joints[row.name], offset = joint, post[i]
    tip = model.addFrame(pin.Frame("tip", joint, pin.SE3(offset @ robot.tip), pin.FrameType.OP_FRAME))
    for body in robot.bodies:
        at = pin.SE3(post[robot.names.index(body.after)])
        model.appendBodyToJoint(
            joints[body.after], pin.Inertia(body.mass, np.array(body.centre) / 1e3, np.eye(3) * 1e-3), at
        )
    data, rng = model.createData(), np.random.default_rng(3)
    for _ in range(5):
        values = (np.array(robot.home) + rng.uniform(-30, 30, len(robot.rows))) * robot.unit
        q = robot.q(values)
        pin.framesForwardKinematics(model, data, q)
        assert np.abs(data.oMf[tip].homogeneous - robot.pose(values)[0]).max() < 1e-12
        jacobian = pin.computeFrameJacobian(model, data, q, tip, pin.LOCAL_WORLD_ALIGNED)
        lin, ang = robot.jacobian(values)
        assert np.abs(jacobian * robot.signs - np.vstack([lin[0], ang[0]])).max() < 1e-12
        gravity = pin.computeGeneralizedGravity(model, data, q)
        assert np.abs(-robot.moments(values)[0, :, 2] - gravity).max() < 1e-9


@pytest.mark.slow(after=1)
@pytest.mark.parametrize("seed", [5, 15])
def test_a_case_is_the_same_from_the_same_seed_and_its_size_is_in_the_logs(seed, tmp_path) -> None:
    """Seed 5: single poses with the tool's frame off; 15: a log of drives alone."""
    first, again = (case(DEV, seed, tmp_path / name) for name in ("a", "b"))
    assert json.dumps(first) == json.dumps(again)
    assert (tmp_path / "a" / "withheld.csv").read_bytes() == (tmp_path / "b" / "withheld.csv").read_bytes()
    assert first["causes"] and all(c["size_mm"] > 0 for c in first["causes"])
    head = (tmp_path / "a" / "withheld.csv").read_text(encoding="utf-8").splitlines()[0].split(",")
    assert ("x" in head) == first["log"]["tracker"] and ("cA1" in head) == first["log"]["setpoints"]


def test_what_a_joint_adds_is_what_its_column_says() -> None:
    """The pattern of a mastering error is its column of the design, to first order."""
    from gap.second_author import design, motion
    from gap.second_author.run import Cause, Run

    robot = dev_cells.bare()
    t, c = motion.path(robot, np.random.default_rng(1), [motion.circles], 20.0, 0.02)
    log = {"tracker": True, "setpoints": True, "encoders": True, "frame": "world", "target": "tool"}
    one = design.Design(Run(robot, t, c), log)
    cause = Cause("joint_offset", "encoder_to_tcp", link=lambda run: np.full_like(run.c, 1e-5) * (np.arange(6) == 2))
    column = one.joint(2, np.full(len(one.rows), 1e-5))
    made = design.pattern(one, [cause])
    assert np.abs(made - column).max() < 1e-3 * np.abs(column).max()
