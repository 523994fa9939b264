"""The fourth author's generator: apart from what it judges, and each cause alone does what its law says."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import numpy as np
import pytest
from imported_names import imported_names

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests" / "bench"))
FOLDER = ROOT / "tests" / "bench" / "gap" / "fourth_author"

from gap.fourth_author import moves  # noqa: E402
from gap.fourth_author.case import case  # noqa: E402
from gap.fourth_author.causes import KNOWN, compliance_of, dahl, play  # noqa: E402
from gap.fourth_author.machines import MACHINES, heavy, middle, strong  # noqa: E402
from gap.second_author.family import Setting  # noqa: E402
from gap.second_author.run import Run, on_table, played  # noqa: E402


def _ramp(robot, axis, speed=0.2, seconds=6.0):
    """One axis at constant speed behind a gentle start, the others at home."""
    t = np.arange(0.0, seconds, 0.004)
    c = np.repeat((np.array(robot.home) * robot.unit)[None], len(t), 0)
    c[:, axis] += speed * np.where(t < 1, 0.5 * t * t, t - 0.5) - 0.4
    return Run(robot, t, c)


def _cause(name, run, seed=1):
    return KNOWN[name].make(Setting(run.robot, [run], {}), np.random.default_rng(seed), 1.0)


def test_makers_import_numpy_scipy_and_the_second_authors_plumbing_alone() -> None:
    allowed = set(sys.stdlib_module_names) | {"numpy", "scipy"}
    names = {n for path in FOLDER.glob("*.py") for n in imported_names(path)}
    bad = {n for n in names if n.split(".")[0] not in allowed and not n.startswith(("gap.second_author", "gap.fourth"))}
    assert not bad and "gap.second_author.run" in names
    assert not {n for n in names if "third" in n or ".dev" in n or ".sealed" in n}


@pytest.mark.slow(after=2)
@pytest.mark.parametrize("make", MACHINES.values(), ids=MACHINES)
def test_every_motion_stays_within_limits_and_moves(make) -> None:
    robot, rng = make(), np.random.default_rng(3)
    low, high = (np.array([getattr(r, k) for r in robot.rows]) * robot.unit for k in ("low", "high"))
    motions = [f(robot, rng, 60) for f in moves.POSES.values()]
    motions += [f(robot, rng, 0.1) for f in (moves.circle, moves.raster, moves.sweeps)]
    for t, c in motions:
        assert len(t) == len(c) > 20 and np.all(np.diff(t) > 0)
        assert np.all((c >= low - 1e-9) & (c <= high + 1e-9)) and np.ptp(robot.pose(c)[:, :3, 3], axis=0).max() > 0.1


def test_a_circle_is_round_and_driven_at_its_feed() -> None:
    robot = strong()
    t, c = moves.circle(robot, np.random.default_rng(5), 0.1)
    where = robot.pose(c)[:, :3, 3]
    middle_ = (where.max(0) + where.min(0)) / 2
    speed = np.linalg.norm(np.gradient(where, t[1], axis=0), axis=1)
    radius = np.linalg.norm(where - middle_, axis=1)
    assert np.ptp(radius) < 1e-3 * radius.mean() + 2e-5
    assert np.quantile(speed, 0.9) == pytest.approx(0.1, rel=0.02)


def test_sag_turns_each_joint_by_its_torque_over_its_stiffness() -> None:
    run = _ramp(middle(), 1)
    cause = _cause("joint_compliance", run)
    turn = cause.link(run)
    told = np.array([cause.params[f"A{k}_rad_per_Nm"] for k in range(1, 7)])
    assert np.allclose(turn, run.load * told)
    assert np.all((told / compliance_of(run.robot) > 0.69) & (told / compliance_of(run.robot) < 1.41))
    assert played(run, [cause])[1][:, 2, 3].mean() < run.tip[:, 2, 3].mean()  # it goes down


def test_play_and_hysteresis_lag_behind_by_half_and_turn_over() -> None:
    wave = np.sin(np.linspace(0, 12, 4000))
    assert np.abs(play(wave, 0.1) - wave).max() == pytest.approx(0.1)
    state = dahl(wave, 0.05)
    assert state.max() > 0.999 and state.min() < -0.999 and np.abs(state).max() <= 1
    up = np.linspace(0, 0.05, 500)
    assert dahl(up, 0.05)[-1] == pytest.approx(1 - np.exp(-1), rel=0.01)


def test_a_lag_a_delay_and_two_clocks_are_speed_times_their_time() -> None:
    run = _ramp(middle(), 0)
    lag = _cause("servo_lag", run)
    assert lag.drive(run)[-1, 0] == pytest.approx(-0.2 * lag.params["A1_s"], rel=0.25)
    for seed in range(40):
        late = _cause("setpoint_delay", run, seed)
        if late.axes == ["A1"]:
            assert late.drive(run)[-1, 0] == pytest.approx(-0.2 * late.params["A1_s"], rel=1e-6)
            break
    clocks = _cause("latency", run)
    off = played(run, [clocks])[1][-1, :3, 3] - run.tip[-1, :3, 3]
    speed = (run.tip[-1, :3, 3] - run.tip[-2, :3, 3]) / 0.004
    assert off == pytest.approx(-speed * clocks.params["latency_s"], rel=0.02, abs=1e-6)


def test_friction_decays_at_a_steady_speed_and_changes_with_direction() -> None:
    there, back = _ramp(middle(), 0), _ramp(middle(), 0, speed=-0.2)
    for seed in range(40):
        cause = _cause("friction", there, seed)
        if "A1" in cause.axes:
            x, y = cause.drive(there)[:, 0], cause.drive(back)[:, 0]
            assert x.min() < 0 < y.max() and np.allclose(x, -y) and abs(x[-1]) < 0.2 * np.abs(x).max()
            return
    raise AssertionError("never A1")


def test_ripple_has_two_waves_a_turn_of_the_generator() -> None:
    run = _ramp(strong(), 0, speed=0.3)
    for seed in range(60):
        cause = _cause("gear_ripple", run, seed)
        if "A1" in cause.axes:
            x, q = cause.link(run)[:, 0], run.c[:, 0]
            even = np.linspace(q.min(), q.max(), 4000)
            power = np.abs(np.fft.rfft(np.interp(even, q, x) * np.hanning(4000)))
            order = 2 * np.pi * np.argmax(power) / np.ptp(q)
            assert min(abs(order - 2 * r) for r in (50, 80, 100, 120)) < 2 * np.pi / np.ptp(q)
            return
    raise AssertionError("never A1")


def test_links_grow_along_themselves() -> None:
    run = _ramp(strong(), 0)
    run.begins = 1e6
    cause = _cause("thermal_drift", run)
    for where, twist in cause.between(run).items():
        row = run.robot.rows[where - 2]
        length = np.hypot(row.a, row.d) / 1e3
        assert 5 * 11.5e-6 < np.linalg.norm(twist[-1]) / length < 20 * 11.5e-6
    tall = played(run, [cause])[1][-1, 2, 3] - run.tip[-1, 2, 3]
    assert 0 < tall < 20 * 11.5e-6 * 2.5


def test_a_rail_scales_its_way_and_a_scale_the_way_to_the_instrument() -> None:
    run = _ramp(heavy(), 0, speed=0.3)
    off = played(run, [_cause("track", run)])[1][:, :3, 3] - run.tip[:, :3, 3]
    slope = np.polyfit(run.c[:, 0], off[:, 0], 1)[0]
    assert 5e-5 <= abs(slope) <= 2e-4 and np.abs(off[:, 1:]).max() < 3e-4
    cause = _cause("measurement_scale", run)
    seen = played(run, [cause])[1][:, :3, 3]
    stretch = np.linalg.norm(seen[-1] - seen[0]) / np.linalg.norm(run.tip[-1, :3, 3] - run.tip[0, :3, 3]) - 1
    assert stretch * 1e6 == pytest.approx(cause.params["scale_ppm"], rel=1e-3)


def test_a_tables_wrong_axis_turns_with_it_and_a_plates_wobble_does_once() -> None:
    run = _ramp(middle(), 0)
    run.table = np.linspace(0, 2 * np.pi, len(run.t))
    rows = np.arange(len(run.t))
    still = on_table(run, np.repeat(run.tip[:1], len(rows), 0), rows)  # the tool stands, the table goes once round
    off = _cause("frame_table", run).on_table(run, still)[:, :3, 3] - still[:, :3, 3]
    turns = on_table(run, np.repeat(np.eye(4)[None], len(rows), 0), rows)[:, :3, :3]
    steady = np.einsum("nji,nj->ni", turns, off)
    assert np.abs(off).max() > 1e-4 and np.ptp(steady, axis=0).max() < 1e-9
    plate = _cause("turntable", run).on_table(run, still)[:, :3, 3] - still[:, :3, 3]
    assert np.ptp(plate[:, 0]) > 4e-5 and plate[0] == pytest.approx(plate[-1], abs=1e-9)


def test_a_case_is_its_seeds_and_its_cell_holds_its_own_poses(tmp_path: Path) -> None:
    first, again = case(3, tmp_path / "a"), case(3, tmp_path / "b")
    assert json.dumps(first) == json.dumps(again) != json.dumps(case(4, tmp_path / "c"))
    assert (tmp_path / "a" / "withheld.csv").read_bytes() == (tmp_path / "b" / "withheld.csv").read_bytes()
    assert len((tmp_path / "a" / "withheld.csv").read_text().splitlines()) == first["rows"][-1] + 1
