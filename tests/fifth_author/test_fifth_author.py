"""The fifth author's generator: apart from what it judges, and what a label says is what is in the logs."""

from __future__ import annotations

import csv
import re
import sys
import tomllib
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from imported_names import imported_names

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "fifth_author"

from gap.fifth_author import dev, sealed  # noqa: E402
from gap.fifth_author.case import _show, case, made  # noqa: E402
from gap.fifth_author.kind import THEMES, theme  # noqa: E402
from gap.fifth_author.machine import rail_axes  # noqa: E402
from gap.second_author.family import Setting  # noqa: E402
from gap.second_author.run import Run, played  # noqa: E402

KINDS = {"dev": dev.KIND, "sealed": sealed.KIND}
MACHINES = {f"{k}-{n}": make for k, kind in KINDS.items() for n, make in kind.cells.items()}
COLUMNS = re.compile(r"t|[xyzabc]|c?A[1-7]|c?E[12]|T[1-6]|TE[12]|I[1-7]|temp|f[xyz]|line")
KEYS = {"measured_frame", "target", "sigma_mm", "sigma_deg", "sigma_axis_deg", "sigma_axis_mm", "poses", "payload_kg"}


def _log(path: Path) -> dict[str, np.ndarray]:
    with path.open() as file:
        head, *rows = csv.reader(file)
    return dict(zip(head, np.array(rows, float).T, strict=True))


def test_makers_import_nothing_of_what_they_judge_and_families_nothing_of_each_other() -> None:
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    for path in FOLDER.glob("*.py"):
        names = {n for n in imported_names(path) if n.split(".")[0] not in allowed}
        assert all(n.startswith(("gap.second_author", "gap.fifth_author")) for n in names), path
        other = "dev" if path.stem.startswith("sealed") else "sealed" if path.stem.startswith("dev") else None
        assert not {n for n in names if other and (f".{other}" in n or f"second_author.{other}" in n)}, path


@pytest.mark.parametrize("make", MACHINES.values(), ids=MACHINES)
def test_chains_and_gravity_are_those_of_pinocchio(make) -> None:
    import pinocchio as pin

    robot, joint, joints = make(), 0, {}
    model, before = pin.Model(), robot.base
    for row in robot.rows:  # a row is Rz(theta + q) Tz(d + q) Tx(a) Rx(alpha)
        kind = pin.JointModelPZ() if row.kind == "P" else pin.JointModelRZ()
        joint = model.addJoint(joint, kind, pin.SE3(before), row.name)
        turn, tilt = np.radians(row.theta), np.radians(row.alpha)
        still = pin.SE3(pin.utils.rotate("z", turn), np.array([0.0, 0.0, row.d / 1e3]))
        after = (
            still
            * pin.SE3(np.eye(3), np.array([row.a / 1e3, 0.0, 0.0]))
            * pin.SE3(pin.utils.rotate("x", tilt), np.zeros(3))
        )
        before, joints[row.name] = after.homogeneous, (joint, after)
    tip = model.addFrame(pin.Frame("tip", joint, pin.SE3(before @ robot.tip), pin.FrameType.OP_FRAME))
    for body in robot.bodies:
        at, after = joints[body.after]
        model.appendBodyToJoint(at, pin.Inertia(body.mass, np.array(body.centre) / 1e3, np.zeros((3, 3))), after)
    data = model.createData()
    values = np.array(robot.home) * robot.unit + np.random.default_rng(2).uniform(-0.3, 0.3, (4, len(robot.rows)))
    for v in values:
        q = robot.q(v[None])[0]
        pin.framesForwardKinematics(model, data, q)
        assert np.allclose(data.oMf[tip].homogeneous, robot.pose(v)[0], atol=1e-9)
        gravity = pin.computeGeneralizedGravity(model, data, q)
        assert np.allclose(-robot.moments(v)[0, :, 2], gravity, atol=1e-6)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_fifty_seeds_hold_each_theme_as_often_as_is_said(kind) -> None:
    found = Counter(theme(kind, seed) for seed in range(kind.first, kind.first + 50))
    assert found == THEMES
    assert min(found["payload"], found["track"], found["thermal_drift"] + found["measurement_drift"]) >= 8
    assert found["joint_offset"] + found["geometry"] >= 8 and 5 <= found["foreign"] <= 10 and found["none"] == 5


def _one(kind, about, show="poses"):
    """What the family's first case of poses about something is, and its seed."""
    for seed in range(kind.first, kind.first + 50):
        if theme(kind, seed) == about and _show(np.random.default_rng([seed, 5]), about) == show:
            return seed
    raise AssertionError(about)


@pytest.mark.parametrize("about", ["payload", "track", "thermal_drift"])
@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_size_is_the_rms_of_what_its_cause_alone_does_at_the_tool(kind, about) -> None:
    got = made(kind, _one(kind, about))
    run, log, rows = got.runs[-1], got.log, got.designs[-1].rows
    for _, cause, told in (*got.left, *got.drawn):
        _, tool = played(run, [cause], rows)
        off = (tool - run.tip[rows])[:, :3, 3].ravel() * 1e3
        free = []
        if log["frame"] == "unknown":  # six numbers of a frame in world
            at = run.tip[rows][:, :3, 3]
            free += [np.tile(e, len(at)) for e in np.eye(3)] + [np.cross(e, at).ravel() for e in np.eye(3)]
        if log["target"] == "unknown":
            free += [run.tip[rows][:, :3, k].ravel() for k in range(3)]
        if free:
            off = off - np.array(free).T @ np.linalg.lstsq(np.array(free).T, off, rcond=None)[0]
        assert told == pytest.approx(np.sqrt((off**2).sum() / len(rows)), rel=2e-3)


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_a_case_is_its_seeds_its_files_are_the_contracts_and_with_causes_off_it_has_noise_alone(kind, tmp_path) -> None:
    seed = _one(kind, "joint_offset")
    first, quiet = case(kind, seed, tmp_path / "a"), case(kind, seed, tmp_path / "off", off=True)
    again, other = case(kind, seed, tmp_path / "again", off=True), made(kind, seed)
    assert again == quiet and [c.params for _, c, _ in other.drawn] == [c["params"] for c in first["causes"]] != []
    robot = kind.cells[first["robot"]]()
    for path in sorted((tmp_path / "a").glob("*.csv")):
        assert (tmp_path / "again" / path.name).read_bytes() == (tmp_path / "off" / path.name).read_bytes()
        log = _log(path)
        assert all(COLUMNS.fullmatch(name) for name in log) and np.all(np.diff(log["t"]) > 0)
        assert set(tomllib.loads(path.with_suffix(".toml").read_text())) <= KEYS
    off, on = _log(tmp_path / "off" / "withheld.csv"), _log(tmp_path / "a" / "withheld.csv")
    tip = robot.pose(np.column_stack([off["c" + n] for n in robot.names]) * robot.unit)

    def left(log):
        """Rms by the median, which gross rows don't move, once a frame and a target were fitted."""
        seen, at = np.column_stack([log[k] for k in "xyz"]), tip[:, :3, 3] * 1e3
        if quiet["log"]["target"] == "unknown":
            at = at + tip[:, :3, :3] @ np.array(quiet["target_mm"])
        if quiet["log"]["frame"] == "unknown":
            u, _, v = np.linalg.svd((seen - seen.mean(0)).T @ (at - at.mean(0)))
            turn = u @ np.diag([1, 1, np.linalg.det(u @ v)]) @ v
            at = (at - at.mean(0)) @ turn.T + seen.mean(0)
        return 1.4826 * np.median(np.abs(seen - at)) * np.sqrt(3)

    assert left(off) == pytest.approx(quiet["noise"]["sigma_mm"] * np.sqrt(3), rel=0.25)
    assert left(on) > 1.3 * left(off)


def _ridden(kind):
    """A machine on a rail that rides along it with its arm still, and the twist of its carriage."""
    robot = next(m() for m in kind.cells.values() if m().carriage and len(m().arm) == 6)
    i, c = robot.carriage[-1], np.repeat((np.array(robot.home) * robot.unit)[None], 2001, 0)
    c[:, i] = np.linspace(-1.0, 1.0, 2001)
    run = Run(robot, np.arange(2001.0), c, rest=True)
    cause = kind.known["track"].make(Setting(robot, [run], {}), np.random.default_rng(4), 1.0)
    (twist,) = cause.between(run).values()
    along, aside, up = rail_axes(robot)
    ahead = np.cross(twist[:, 3:], along)  # how a point a metre ahead moves
    return run, [(twist[:, :3] @ e, ahead @ e) for e in (up, aside)]


def test_dev_carriages_stand_with_both_bogies_on_one_rail() -> None:
    _, ways = _ridden(dev.KIND)
    for here, slope in ways:  # the front bogie now is where the hind one will be a wheelbase later
        apart = {1: [], -1: []}
        for steps in range(490, 910):
            for sign, found in apart.items():
                half = sign * slope * steps * 0.5e-3
                found.append(np.abs((here + half)[:-steps] - (here - half)[steps:]).max())
        assert min(apart[1]) < 2e-7 < 1e-5 < min(apart[-1])


def test_sealed_carriages_pitch_and_yaw_by_the_slope_of_the_rail() -> None:
    run, ways = _ridden(sealed.KIND)
    for here, slope in ways:
        fits = np.polyfit(np.gradient(here, run.c[1, 0] - run.c[0, 0]), slope, 1)
        assert fits[0] == pytest.approx(1.0, abs=0.05) and np.abs(slope).max() > 1e-5


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_what_is_heavier_hangs_lower_and_what_is_warm_is_longer(kind) -> None:
    robot, rng = next(iter(kind.cells.values()))(), np.random.default_rng(1)
    c = (np.array(robot.home) + rng.uniform(-20, 20, (60, len(robot.rows)))) * robot.unit
    runs = [Run(robot, 120.0 * np.arange(60), c, rest=True, begins=7200.0 * k) for k in range(3)]
    heavy = 0
    for seed in range(8):
        cause = kind.known["payload"].make(Setting(robot, runs, {}), np.random.default_rng(seed), 1.0)
        low = (played(runs[-1], [cause])[1] - runs[-1].tip)[:, 2, 3]
        if cause.params.get("mass_kg", 0) > 0:
            heavy += 1
            assert low.min() < -1e-5 and low.mean() < 0 and low.max() < 0.1 * np.abs(low.min())
        warm = kind.known["thermal_drift"].make(Setting(robot, runs, {}), np.random.default_rng(seed), 1.0)
        ends = robot.frames(c, warm.between(runs[-1]))[1]
        links = [
            np.linalg.norm(e[-1][-1, :3, 3] - e[0][-1, :3, 3])
            for e in ([ends[1], ends[2]], [runs[-1].bones[1][k] for k in (1, 2)])
        ]
        assert 3 * robot.metal < links[0] / links[1] - 1 < 24 * robot.metal
    assert heavy
