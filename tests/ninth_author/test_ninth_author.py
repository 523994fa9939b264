"""The ninth author's generator: apart from what it judges, its physics right by other means, its labels what its files hold."""

from __future__ import annotations

import csv
import json
import sys
import tomllib
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio
import pytest
from imported_names import imported_names
from scipy.integrate import solve_ivp
from scipy.optimize import minimize

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "ninth_author"

from gap.ninth_author import run as driver  # noqa: E402
from gap.ninth_author.arms import CELLS, euler, frame, twist  # noqa: E402
from gap.ninth_author.body_causes import loop, play  # noqa: E402
from gap.ninth_author.case import SEED, made, size_mm, write  # noqa: E402
from gap.ninth_author.drive_causes import follower, lugre  # noqa: E402
from gap.ninth_author.kinds import FOREIGN, MOST, NAMED  # noqa: E402
from gap.ninth_author.label import digest, generator_digest, label, line  # noqa: E402
from gap.ninth_author.machines import MACHINES, machine  # noqa: E402
from gap.ninth_author.paths import DT, handle, poses, work  # noqa: E402
from gap.ninth_author.plan import PLAN, planned  # noqa: E402
from gap.ninth_author.scores import scores, wilson  # noqa: E402
from gap.ninth_author.shift import rms  # noqa: E402

TRIED = 903  # a family of the same kind that is not sealed
BRIEF = (18, 21, 26, 39)  # cases that are made in a second


def test_it_imports_nothing_of_what_it_judges_and_of_no_other_author() -> None:
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    for path in FOLDER.glob("*.py"):
        names = {n for n in imported_names(path) if n.split(".")[0] not in allowed}
        assert all(n.startswith("gap.ninth_author") for n in names), (path, names)


def _pinocchio(arm):
    """The machine once more, as Pinocchio's bodies: model, data, and the frame of the tool behind the last joint."""
    model, here, parent = pinocchio.Model(), pinocchio.SE3.Identity(), 0
    offs = np.zeros(arm.n)
    ends = []
    for i, (alpha, a, theta, d) in enumerate(arm.rows):
        here = here * pinocchio.SE3(arm.pre[i])
        joint = pinocchio.JointModelPZ() if arm.slides[i] else pinocchio.JointModelRZ()
        parent = model.addJoint(parent, joint, here, arm.names[i])
        offs[i] = 0.0 if arm.slides[i] else theta  # what the row adds to a turn of the joint itself
        here = pinocchio.SE3(
            frame([1e3 * a, 0, 1e3 * d, np.degrees(theta) if arm.slides[i] else 0, 0, np.degrees(alpha)])
        )
        if arm.slides[i]:
            turn = frame([0, 0, 0, np.degrees(theta), 0, 0])
            here = pinocchio.SE3(turn @ frame([1e3 * a, 0, 1e3 * d, 0, 0, np.degrees(alpha)]))
        ends.append(here)
    for i, kg, c in arm.masses:
        at = ends[i] * pinocchio.SE3(np.eye(3), np.array(c))
        model.appendBodyToJoint(i + 1, pinocchio.Inertia(kg, np.zeros(3), np.zeros((3, 3))), at)
    return model, model.createData(), ends[-1] * pinocchio.SE3(arm.tool), offs


@pytest.mark.parametrize("name", MACHINES)
def test_a_chain_its_slopes_and_its_weight_are_those_of_pinocchio(name) -> None:
    arm = machine(name)
    model, data, tool, offs = _pinocchio(arm)
    q = arm.middle + np.random.default_rng(4).uniform(-1, 1, (3, arm.n)) * arm.spread
    if arm.table:
        q[:, 0] = np.pi  # world's, where the table stands at 0
    tips, loads, slopes = arm.tips(q), arm.loads(q), arm.jacobian(q)
    first = 1 if arm.table else 0
    for k in range(3):
        pinocchio.forwardKinematics(model, data, q[k] + offs)
        there = (data.oMi[arm.n] * tool).homogeneous
        assert np.abs(there - tips[k]).max() < 1e-12
        model.gravity.linear = np.array([0, 0, -9.81])
        weight = pinocchio.computeGeneralizedGravity(model, data, q[k] + offs)
        assert np.abs(weight + loads[k])[first:].max() < 1e-9 * (1 + np.abs(weight).max())
    for i in range(first, arm.n):
        h = np.zeros(arm.n)
        h[i] = 1e-6
        slope = (arm.tips(q + h) - arm.tips(q - h)) / 2e-6
        assert np.abs(slope[:, :3, 3] - slopes[:, :3, i]).max() < 1e-8


@pytest.mark.parametrize("name", [n for n in MACHINES if machine(n).shipped])
def test_a_shipped_cell_meets_its_known_poses(name) -> None:
    arm = machine(name)
    with (CELLS / arm.shipped / "poses.csv").open() as file:
        rows = [r for r in csv.DictReader(file) if r["x_mm"]]
    for row in rows:
        value = [float(row[n + ("_mm" if s else "_deg")]) for n, s in zip(arm.names, arm.slides, strict=True)]
        scale = np.where(arm.slides, 1e-3, np.pi / 180)
        q = ((np.array(value) - arm.off) / arm.sign * scale)[None]
        tip = arm.tables(q) @ arm.tips(q) if arm.table else arm.tips(q)
        want = frame([float(row[k]) for k in ("x_mm", "y_mm", "z_mm", "a_deg", "b_deg", "c_deg")])
        assert np.abs(tip[0] - want).max() < 1e-5
        assert np.abs(frame([0, 0, 0, *euler(tip[0, :3, :3])])[:3, :3] - tip[0, :3, :3]).max() < 1e-12


def test_a_parallelogram_gives_where_its_energy_is_least() -> None:
    arm = machine("long")
    load = arm.loads(arm.middle[None] + 0.2)[0]
    two, three = arm.soft[1:3]

    def energy(
        x,
    ):  # in microradians: each motor's spring holds a link of its own, the forearm's angle counts from the floor
        d2, d3 = x * 1e-6
        return 1e3 * (0.5 * d2**2 / two + 0.5 * (d2 + d3) ** 2 / three - load[1] * d2 - load[2] * d3)

    least = minimize(energy, [0.0, 0.0], method="Nelder-Mead", options={"xatol": 1e-6, "fatol": 1e-12, "maxiter": 4000})
    assert 1e-6 * least.x == pytest.approx(arm.sag(load[None])[0, 1:3], rel=1e-4)


def test_drives_and_loops_are_solutions_of_their_equations() -> None:
    t = np.arange(0, 3, DT)
    c = 0.3 * (1 - np.cos(2.2 * t)) + 0.05 * np.sin(5 * t) - 0.25 * t  # begins at rest
    v = 0.66 * np.sin(2.2 * t) + 0.25 * np.cos(5 * t) - 0.25

    def speed(s):
        return 0.66 * np.sin(2.2 * s) + 0.25 * np.cos(5 * s) - 0.25

    def solved(right, start=0.0):
        return solve_ivp(right, (0, t[-1]), [start], t_eval=t, rtol=1e-8, atol=1e-11, max_step=DT).y[0]

    tau = 0.03
    lag = solved(lambda s, e: -e / tau - 0.4 * speed(s))
    assert np.abs(follower(c, tau, 0.6) - lag).max() < 0.05 * np.abs(lag).max()
    ramp = follower(0.2 * t, tau)
    assert ramp[-1] == pytest.approx(-tau * 0.2, rel=1e-3)
    bristle = 2e-3
    z = solved(lambda s, z: speed(s) - np.abs(speed(s)) * z / (bristle * (1 + 0.5 * np.exp(-((speed(s) / 0.02) ** 2)))))
    assert np.sqrt(np.mean((lugre(v, bristle) - z / bristle) ** 2)) < 0.05
    reach = 0.05
    h = solved(lambda s, h: speed(s) * np.clip(1 - h * np.sign(speed(s)), 0, None) ** 1.5 / reach)
    assert np.abs(loop(c, reach) - h).max() < 0.02
    assert np.abs(loop(c, reach) - loop(c[::2], reach).repeat(2)[: len(c)]).max() < 0.1  # of no rate


def test_a_loop_takes_energy_and_play_stays_in_its_slot() -> None:
    x = 0.1 * np.sin(np.linspace(0, 6 * np.pi, 4000))
    h = loop(x, 0.03)
    assert (
        np.sum(0.5 * (h[1:] + h[:-1])[1333:] * np.diff(x)[1333:]) > 0.1
    )  # a braking force along the way, after the first turn
    u = play(x, 0.02)
    assert np.abs(u).max() == 1
    at = 0.1 * np.sin(6 * np.pi * 0.3) - 0.01 * u[1200]
    assert np.abs(at - 0.1 * np.sin(6 * np.pi * 0.3)) <= 0.0101


def test_a_push_does_the_same_work_at_the_tool_and_at_the_axes() -> None:
    run = work(machine("kr500"), np.random.default_rng(2), "pocket", 120, 3)
    k = int(np.argmax(np.linalg.norm(run.force, axis=1)))
    k -= k % 5  # where the Jacobian is reckoned
    step = 1e-6 * np.random.default_rng(3).normal(size=run.arm.n)
    q = run.q[k : k + 1]
    move = (run.arm.tips(q + step) - run.arm.tips(q - step))[0, :3, 3]
    assert 2 * run.work[k] @ step == pytest.approx(run.force[k] @ move, rel=1e-6)


def test_machines_move_as_machines_can() -> None:
    rng = np.random.default_rng(11)
    for name in ("kr15", "kr500", "long", "ur10e"):
        for shape in ("pocket", "trim", "polish"):
            run = work(machine(name), rng, shape, 300, 4)
            assert np.abs(run.rate()).max() < 2.5
            assert np.abs(np.diff(run.q, axis=0)).max() < 0.01
            assert (run.force[:50] == 0).all()
    run = handle(machine("scara"), rng, 300, 4)
    assert np.abs(run.rate()).max() < 2.5
    shown = poses(machine("rx160"), rng, 40)
    assert (np.diff(shown.t) > 10).all()
    assert np.allclose(shown.q[1:] - shown.q[:-1], shown.moves[1:])


def test_a_family_holds_what_its_page_says() -> None:
    plan = [planned(n) for n in range(len(PLAN))]
    assert Counter(p["kind"] for p in plan) == {"one": 17, "two": 12, "three": 1, "foreign": 7, "none": 4}
    assert {p["machine"] for p in plan} == set(MACHINES)
    assert sum(p["left"] for p in plan) == 23
    assert sum(p["correlated"] for p in plan) == 11
    assert {n for p in plan for n in p["causes"]} == set(NAMED) | set(FOREIGN) == set(MOST)
    for p in plan:
        log = p["log"] if p["log"] in ("poses", "drives") else "path"
        assert all(log in (NAMED.get(n) or FOREIGN[n]).logs for n in p["causes"])


def _read(path: Path):
    """Columns of a log; an empty cell is NaN."""
    with path.open() as file:
        head, *rows = csv.reader(file)
    return {n: np.array([float(r[i] or "nan") for r in rows]) for i, n in enumerate(head)}


def _tool(case, log, prefix):
    """x, y, z of the tool by axis values of a log, on the base as it turns: from cell.toml as it is written, by Pinocchio."""
    arm = case.arm
    model, data, tool, offs = _pinocchio(arm)
    scale = np.where(arm.slides, 1e-3, np.pi / 180)
    out = []
    for value in np.stack([log[prefix + n] for n in arm.names], 1):
        if arm.table and case.how["frame"] != "base":
            value = np.r_[0.0, value[1:]]
        pinocchio.forwardKinematics(model, data, (value - arm.off) / arm.sign * scale + offs)
        out.append(1e3 * (data.oMi[arm.n] * tool).translation)
    return np.array(out)


@pytest.mark.parametrize("number", [2, 13, 18, 21, 26, 29, 34, 35])
def test_files_hold_what_the_label_says(number, tmp_path) -> None:
    case = made(TRIED, number)
    case.how |= {
        "unknown_frame": False,
        "unknown_target": False,
        "stands": np.eye(4),
        "reflector": np.zeros(3),
        "lost": 0.0,
    }
    case.runs = [replace(case.runs[-1])]
    case.how["white"] = case.how["wander"] = case.how["chatter"] = case.how["axis_deg"] = case.how["axis_mm"] = 0.0
    parts = {c.name: [c] for c in case.causes}
    for name, causes in parts.items():
        write(case, tmp_path / name, lambda run, causes=causes: [c.shift(run) for c in causes])
        log = _read(tmp_path / name / "withheld.csv")
        if causes[0].kind.stage == "setpoint_to_encoder":
            got = rms((_tool(case, log, "") - _tool(case, log, "c")) / 1e3)
        else:
            got = rms((np.stack([log[k] for k in "xyz"], 1) - _tool(case, log, "c")) / 1e3)
        if name == "encoder_filter":
            want = size_mm(case, causes[0])
            assert rms((np.stack([log[k] for k in "xyz"], 1) - _tool(case, log, "c")) / 1e3) < 2e-3
        else:
            want = rms(case.off(case.runs[0], [causes[0].shift(case.runs[0])], absorb=False))
        assert got == pytest.approx(want, rel=5e-3, abs=3e-3)


def test_a_cell_file_is_the_chain_that_moves() -> None:
    for name in MACHINES:
        arm = machine(name)
        cell = tomllib.loads(arm.text) if arm.text else None
        if cell is None:
            continue
        q = arm.middle + 0.1
        T = np.eye(4)
        for (alpha, a, theta, d), v, slides in zip(cell["arm"]["dh"], q, arm.slides, strict=True):
            turn, slide = (theta, d + 1e3 * v) if slides else (theta + np.degrees(v), d)
            T = T @ frame([0, 0, slide, turn, 0, 0]) @ frame([a, 0, 0, 0, 0, alpha])
        T = T @ frame(cell["tool"]["flange_to_tool"])
        assert np.abs(T - arm.tips(q[None])[0]).max() < 1e-12


def test_a_twist_is_a_small_motion() -> None:
    w = np.array([1e-3, 2e-3, -1e-3, 0.3, -0.2, 0.1])
    quaternion = pinocchio.exp3(w[3:])
    assert np.abs(twist(w)[:3, :3] - quaternion).max() < 1e-12
    assert np.abs(twist(w)[:3, 3] - w[:3]).max() == 0


def test_what_was_sealed_comes_out_again_and_stands_on_the_page() -> None:
    told, page = driver.sealed(), (FOLDER / "README.md").read_text()
    assert [*told] == ["generator", "all", *map(str, range(len(PLAN)))]
    assert told["generator"] == generator_digest()
    assert told["generator"] in page
    assert told["all"] in page
    for number in BRIEF:
        assert digest(line(label(made(SEED, number)))) == told[str(number)]


def test_labels_that_were_changed_are_not_scored(tmp_path) -> None:
    driver.write_all(tmp_path, TRIED, [39])
    assert not list((tmp_path / "cases").rglob("*label*"))
    driver.score(tmp_path)
    file = tmp_path / "sealed" / "labels.jsonl"
    file.write_text(file.read_text().replace('"none"', '"one"'))
    with pytest.raises(SystemExit, match="changed after"):
        driver.score(tmp_path)


def _said(*effects, unknown=0.1, shrink=0.6, where=None):
    return {
        "diagnosis": {
            "status": "partly explained",
            "effects": [{"effect": n, "probability": p, "axes": ["A2"]} for n, p in effects],
            "alternatives": [
                {"effects": [n for n, _ in effects], "probability": 0.96},
                {"effects": [], "probability": 0.04},
            ],
            "unknown": {"probability": unknown, "where": where or {}},
            "together": {"shrink": shrink, "predicted_shrink": shrink + 0.03},
        },
        "seconds": 3.0,
    }


def _told(number, kind, name, **more):
    cause = {
        "axes": ["A2"],
        "stage": "encoder_to_tcp",
        "follows": ["time"],
        "ratio": 4.0,
        "removable": 0.58,
        "alike": ["lean"],
    }
    causes = {name: cause | more} if name else {}
    return {
        "number": number,
        "kind": kind,
        "machine": "kr500",
        "log": "poses",
        "noise_mm": 0.05,
        "left_mm": 0.2 if kind == "one" else 0.0,
        "removable": 0.58,
        "causes": causes,
    }


def test_figures_tell_right_from_wrong_answers() -> None:
    labels = {n: _told(n, "one", "backlash") for n in range(4)} | {
        4: _told(4, "foreign", "float"),
        5: _told(5, "none", ""),
    }
    said = [
        _said(("backlash", 0.9)),
        _said(("lean", 0.9), unknown=0.7),
        _said(("friction", 0.9)),
        _said(("friction", 0.2), ("backlash", 0.3)),
        _said(unknown=0.9, where={"rung": "encoder_to_tcp", "axes": ["A2"], "regimes": ["time"]}),
        _said(("track", 0.6)),
    ]
    got = scores(labels, dict(enumerate(said)))
    assert [r["outcome"] for r in got["rows"]] == ["right", "alike", "missed", "contained"]

    def hits(what):
        return got[what]["hits"], got[what]["count"]

    assert hits("named, twice the floor: claimed right") == (1, 4)
    assert hits("named, twice the floor: right or alike") == (2, 4)
    assert hits("named, twice the floor: contained") == (3, 4)
    assert hits("claims of known causes that are wrong") == (1, 3)
    assert hits("claims above 0.8 that are wrong") == (1, 3)
    assert hits("leftover of twice the noise: unknown said") == (1, 4)
    assert hits("foreign: place right in all") == (1, 1)
    assert hits("nothing wrong: a cause claimed") == (1, 1)
    assert hits("foretold within 5 points of reached") == (6, 6)
    assert hits("reached within 5 points of the simulator's") == (1, 1)
    assert wilson(0, 0) == (0.0, 1.0)
    assert wilson(5, 10) == pytest.approx((0.2366, 0.7634), abs=1e-4)
    json.dumps(got)
